//! Feasibility of the limits of boxed terms.

use super::error::{InfeasibleCycle, JumpError};
use super::network::{Arc, NONE, Network, incidence};
use crate::CompressedRows;
use crate::observer::check_stopped;

/// Lowers potentials until every boxed jump lies within its limits, to a tolerance, and adds to
/// `work`. Returns infeasible cycles of terms; none if all limits are satisfied.
///
/// A limit bounds a difference of two potentials, so this is a shortest-path problem (Bellman-Ford)
/// on the boxed terms; its negative cycles are infeasible. A component of boxed terms is dropped
/// once it shows a negative cycle while the others continue, so that one call reports all
/// infeasible components.
///
/// # Errors
/// [`JumpError::WorkLimit`].
///
/// # Cost
/// O(boxed terms) if few are violated; O(nodes x terms) of the boxed subgraph at worst.
pub(super) fn enforce_limits(
    network: &Network,
    potentials: &mut [f64],
    tolerance: f64,
    work_limit: u64,
    work: &mut u64,
) -> Result<Vec<InfeasibleCycle>, JumpError> {
    let arcs = &network.arcs;
    let boxed = || arcs.iter().enumerate().filter(|(_, arc)| arc.is_boxed()).map(|(a, arc)| (a as u32, arc));
    if boxed().all(|(_, arc)| within(arc, arc.jump(potentials), tolerance)) {
        return Ok(Vec::new());
    }
    let incidence = incidence(network.nodes(), boxed());
    let mut search = Search::new(network, &incidence);
    let mut found = Vec::new();
    let members = search.members.len();
    let mut queue = search.members.clone();
    let mut queued = vec![false; network.nodes()];
    let mut lowered = 0;
    let mut next = Vec::new();
    for round in 0..=members {
        for &v in &queue {
            queued[v as usize] = false;
            if search.dropped[v as usize] {
                continue;
            }
            *work += incidence.row(v as usize).len() as u64;
            for &a in incidence.row(v as usize) {
                let arc = &arcs[a as usize];
                let (w, bound) = bound(arc, v, potentials);
                if potentials[w as usize] > bound + tolerance {
                    potentials[w as usize] = bound;
                    search.predecessor[w as usize] = a;
                    lowered += 1;
                    if !queued[w as usize] {
                        queued[w as usize] = true;
                        next.push(w);
                    }
                }
            }
        }
        std::mem::swap(&mut queue, &mut next);
        next.clear();
        if queue.is_empty() {
            return Ok(found);
        }
        if lowered >= members || round == members {
            lowered = 0;
            *work += members as u64;
            search.infeasible_cycles(&mut found);
        }
        check_stopped()?;
        if *work > work_limit {
            return Err(JumpError::WorkLimit { work: work_limit });
        }
    }
    // For components not dropped, this is reached through rounding only: a cycle infeasible by
    // about the tolerance.
    Ok(found)
}

fn within(arc: &Arc, jump: f64, tolerance: f64) -> bool {
    jump >= -tolerance && jump <= arc.limit + tolerance
}

/// Upper bound on the potential at the other end of a boxed arc, given that of `v`.
fn bound(arc: &Arc, v: u32, potentials: &[f64]) -> (u32, f64) {
    let here = potentials[v as usize];
    match arc.from == v {
        true => (arc.to, here + arc.shift),
        false => (arc.from, here + (arc.limit - arc.shift)),
    }
}

/// Predecessor graph of the shortest-path search, for finding negative cycles.
struct Search<'a> {
    network: &'a Network,
    incidence: &'a CompressedRows<u32>,
    /// Nodes with boxed arcs.
    members: Vec<u32>,
    /// The arc that currently bounds a node's potential.
    predecessor: Vec<u32>,
    /// Start of the last walk through a node.
    seen: Vec<u32>,
    dropped: Vec<bool>,
}

impl<'a> Search<'a> {
    fn new(network: &'a Network, incidence: &'a CompressedRows<u32>) -> Self {
        let n = network.nodes();
        let members = (0..n as u32).filter(|&v| !incidence.row(v as usize).is_empty()).collect();
        let (predecessor, seen) = (vec![NONE; n], vec![NONE; n]);
        Search { network, incidence, members, predecessor, seen, dropped: vec![false; n] }
    }

    /// Finds the cycles of the predecessor graph and drops their components. Every node has one
    /// predecessor, so no two cycles share a node.
    fn infeasible_cycles(&mut self, found: &mut Vec<InfeasibleCycle>) {
        for &v in &self.members {
            self.seen[v as usize] = NONE;
        }
        let mut on_cycles = Vec::new();
        for &start in &self.members {
            let mut v = start;
            while self.seen[v as usize] == NONE
                && self.predecessor[v as usize] != NONE
                && !self.dropped[v as usize]
            {
                self.seen[v as usize] = start;
                v = self.network.across(self.predecessor[v as usize], v);
            }
            if self.seen[v as usize] == start {
                let cycle = self.cycle(v);
                if cycle.excess > 0.0 {
                    found.push(cycle);
                    on_cycles.push(v);
                }
            }
        }
        while let Some(v) = on_cycles.pop() {
            if !std::mem::replace(&mut self.dropped[v as usize], true) {
                on_cycles.extend(self.incidence.row(v as usize).iter().map(|&a| self.network.across(a, v)));
            }
        }
    }

    /// The cycle of predecessor arcs through a node.
    fn cycle(&self, first: u32) -> InfeasibleCycle {
        let (mut v, mut total, mut terms) = (first, 0.0, Vec::new());
        loop {
            let a = self.predecessor[v as usize];
            let arc = &self.network.arcs[a as usize];
            total += if arc.to == v { arc.shift } else { arc.limit - arc.shift };
            terms.push(self.network.terms[a as usize] as usize);
            v = arc.across(v);
            if v == first {
                break;
            }
        }
        terms.reverse();
        InfeasibleCycle { terms, excess: -total }
    }
}
