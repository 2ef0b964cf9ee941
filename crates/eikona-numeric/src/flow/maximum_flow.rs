//! Maximum flow from nodes with a surplus to nodes with a deficit, by push-relabel.
//!
//! Labels are lower bounds on a node's distance to the nearest deficit, and surplus flows downhill
//! (Goldberg and Tarjan 1988), highest label first (Cheriyan and Maheshwari 1989), so that surplus
//! which meets at a node moves on together. Global relabelling by breadth-first search makes labels
//! exact from time to time (Cherkassky and Goldberg 1997); surplus that cannot reach a deficit
//! stays where it is. The number of steps is O(n^2 sqrt(m)) for any capacities.

use crate::NumericError;
use crate::observer::{check_step, check_stopped};

/// One direction of an arc, stored at the node where it starts.
#[derive(Clone, Copy)]
pub(super) struct HalfArc {
    /// The node it leads to.
    pub(super) head: u32,
    /// The opposite direction.
    pub(super) reverse: u32,
    /// Residual capacity; may be infinite.
    pub(super) capacity: f64,
}

/// Residual graph: the half-arcs of all arcs, by the node where they start.
pub(super) struct ResidualGraph {
    pub(super) start: Vec<u32>,
    pub(super) arcs: Vec<HalfArc>,
}

impl ResidualGraph {
    #[inline]
    pub(super) fn range(&self, v: u32) -> std::ops::Range<usize> {
        self.start[v as usize] as usize..self.start[v as usize + 1] as usize
    }
}

const NONE: u32 = u32::MAX;
/// Label of nodes that cannot reach a deficit.
const UNREACHABLE: u32 = u32::MAX;

/// Working memory that is reused between runs.
pub(super) struct MaximumFlow {
    labels: Vec<u32>,
    /// Active nodes (with a surplus) as one linked list per label: its head, and the next node.
    head_active: Vec<u32>,
    next_active: Vec<u32>,
    active: Vec<bool>,
    /// Number of nodes with each label.
    count: Vec<u32>,
    /// Upper bound on the labels of active nodes.
    highest: usize,
    /// Gap heuristic: no node has this label, so nodes above it cannot reach a deficit.
    gap: u32,
    queue: Vec<u32>,
    /// Steps taken.
    pub(super) work: u64,
}

impl MaximumFlow {
    pub(super) fn new(nodes: usize) -> MaximumFlow {
        MaximumFlow {
            labels: vec![UNREACHABLE; nodes],
            head_active: vec![NONE; nodes + 1],
            next_active: vec![NONE; nodes],
            active: vec![false; nodes],
            count: vec![0; nodes + 1],
            highest: 0,
            gap: UNREACHABLE,
            queue: Vec::new(),
            work: 0,
        }
    }

    /// Sends as much flow as possible from nodes of positive to nodes of negative surplus. Amounts
    /// up to `negligible` count as zero. Stops early after `work_limit` steps.
    pub(super) fn run(
        &mut self,
        residual: &mut ResidualGraph,
        surplus: &mut [f64],
        negligible: f64,
        work_limit: u64,
    ) -> Result<(), NumericError> {
        let end = self.work.saturating_add(work_limit);
        let relabel_interval = (2 * residual.arcs.len() + surplus.len()) as u64;
        let mut discharged = 0;
        loop {
            self.global_relabel(residual, surplus, negligible)?;
            let next_relabel = end.min(self.work + relabel_interval);
            loop {
                let v = self.head_active[self.highest];
                if v == NONE {
                    if self.highest == 0 {
                        return Ok(());
                    }
                    self.highest -= 1;
                    continue;
                }
                self.head_active[self.highest] = self.next_active[v as usize];
                self.active[v as usize] = false;
                self.discharge(v, residual, surplus, negligible);
                if self.work >= next_relabel {
                    break;
                }
                discharged += 1;
                check_step(discharged)?;
            }
            check_stopped()?;
            if self.work >= end {
                return Ok(());
            }
        }
    }

    /// Global relabelling: sets labels to exact distances to the nearest deficit.
    fn global_relabel(
        &mut self,
        residual: &ResidualGraph,
        surplus: &[f64],
        negligible: f64,
    ) -> Result<(), NumericError> {
        self.labels.fill(UNREACHABLE);
        self.head_active.fill(NONE);
        self.count.fill(0);
        self.active.fill(false);
        self.gap = UNREACHABLE;
        self.highest = 0;
        self.queue.clear();
        for (v, s) in surplus.iter().enumerate() {
            if *s < -negligible {
                self.labels[v] = 0;
                self.queue.push(v as u32);
            }
        }
        let mut at = 0;
        while let Some(&v) = self.queue.get(at) {
            check_step(at)?;
            at += 1;
            let label = self.labels[v as usize];
            self.count[label as usize] += 1;
            if surplus[v as usize] > negligible {
                self.activate(v, label);
            }
            for half in &residual.arcs[residual.range(v)] {
                let there = &mut self.labels[half.head as usize];
                if *there == UNREACHABLE && residual.arcs[half.reverse as usize].capacity > 0.0 {
                    *there = label + 1;
                    self.queue.push(half.head);
                }
            }
        }
        self.work += residual.arcs.len() as u64;
        Ok(())
    }

    #[inline]
    fn activate(&mut self, v: u32, label: u32) {
        if !self.active[v as usize] {
            self.active[v as usize] = true;
            self.next_active[v as usize] = self.head_active[label as usize];
            self.head_active[label as usize] = v;
            self.highest = self.highest.max(label as usize);
        }
    }

    /// Pushes and relabels a node until its surplus is gone or it cannot reach a deficit.
    fn discharge(&mut self, v: u32, residual: &mut ResidualGraph, surplus: &mut [f64], negligible: f64) {
        let mut label = self.labels[v as usize];
        if label > self.gap {
            self.labels[v as usize] = UNREACHABLE;
            return;
        }
        let mut here = surplus[v as usize];
        loop {
            // Lowest label of a residual neighbour.
            let mut lowest = UNREACHABLE;
            for h in residual.range(v) {
                self.work += 1;
                let HalfArc { head, reverse, capacity } = residual.arcs[h];
                if capacity <= 0.0 {
                    continue;
                }
                let there = self.labels[head as usize];
                if there < label {
                    let step = here.min(capacity);
                    let left = capacity - step;
                    residual.arcs[h].capacity = if left <= negligible { 0.0 } else { left };
                    residual.arcs[reverse as usize].capacity += step;
                    here -= step;
                    surplus[head as usize] += step;
                    if surplus[head as usize] > negligible {
                        self.activate(head, there);
                    }
                    if here <= negligible {
                        surplus[v as usize] = here;
                        return;
                    }
                    if left <= negligible {
                        continue;
                    }
                }
                lowest = lowest.min(there);
            }
            let count = &mut self.count[label as usize];
            *count -= 1;
            if *count == 0 {
                self.gap = self.gap.min(label);
            }
            if lowest >= self.gap || lowest as usize + 1 >= self.labels.len() {
                self.labels[v as usize] = UNREACHABLE;
                surplus[v as usize] = here;
                return;
            }
            label = lowest + 1;
            self.labels[v as usize] = label;
            self.count[label as usize] += 1;
        }
    }
}
