//! Maximum flow from nodes with a surplus to nodes with a deficit, by pushing and relabelling.
//!
//! Surplus flows downhill on labels that never exceed a node's distance to the nearest deficit
//! (Goldberg and Tarjan 1988), highest label first (Cheriyan and Maheshwari 1989), so that what
//! comes together at a node goes on together. Labels are made exact from time to time by a
//! breadth-first search (Cherkassky and Goldberg 1997); surplus that can not reach a deficit stays
//! where it is. The number of steps is bounded whatever the capacities are: O(n^2 sqrt(m)).

/// One of the two directions of an arc, seen from the node where it starts.
#[derive(Clone, Copy)]
pub(super) struct Half {
    /// Where it leads.
    pub(super) head: u32,
    /// The other direction.
    pub(super) mate: u32,
    /// How much flow it can take. May be infinite.
    pub(super) room: f64,
}

/// The halves of all arcs, by the node where they start.
pub(super) struct Halves {
    pub(super) start: Vec<u32>,
    pub(super) list: Vec<Half>,
}

impl Halves {
    #[inline]
    pub(super) fn range(&self, v: u32) -> std::ops::Range<usize> {
        self.start[v as usize] as usize..self.start[v as usize + 1] as usize
    }
}

const NONE: u32 = u32::MAX;
/// The label of nodes that reach no deficit.
const CUT_OFF: u32 = u32::MAX;

/// What is kept from one run to the next.
pub(super) struct MaximumFlow {
    labels: Vec<u32>,
    /// Nodes with a surplus, by label: the first of each and who follows whom.
    first: Vec<u32>,
    follower: Vec<u32>,
    listed: Vec<bool>,
    /// How many nodes have each label.
    count: Vec<u32>,
    /// No listed node has a larger label.
    highest: usize,
    /// A label that no node had: nodes above it are cut off.
    gap: u32,
    queue: Vec<u32>,
    /// Steps taken.
    pub(super) work: u64,
}

impl MaximumFlow {
    pub(super) fn new(nodes: usize) -> MaximumFlow {
        MaximumFlow {
            labels: vec![CUT_OFF; nodes],
            first: vec![NONE; nodes + 1],
            follower: vec![NONE; nodes],
            listed: vec![false; nodes],
            count: vec![0; nodes + 1],
            highest: 0,
            gap: CUT_OFF,
            queue: Vec::new(),
            work: 0,
        }
    }

    /// Sends as much as possible from nodes of positive to nodes of negative surplus. What is at
    /// most `nothing` in size counts as nothing. Stops early after `work_limit` steps.
    pub(super) fn run(&mut self, halves: &mut Halves, surplus: &mut [f64], nothing: f64, work_limit: u64) {
        let end = self.work.saturating_add(work_limit);
        let between_searches = (2 * halves.list.len() + surplus.len()) as u64;
        loop {
            self.search(halves, surplus, nothing);
            let next_search = end.min(self.work + between_searches);
            loop {
                let v = self.first[self.highest];
                if v == NONE {
                    if self.highest == 0 {
                        return;
                    }
                    self.highest -= 1;
                    continue;
                }
                self.first[self.highest] = self.follower[v as usize];
                self.listed[v as usize] = false;
                self.discharge(v, halves, surplus, nothing);
                if self.work >= next_search {
                    break;
                }
            }
            if self.work >= end {
                return;
            }
        }
    }

    /// Exact labels: distances to the nearest deficit.
    fn search(&mut self, halves: &Halves, surplus: &[f64], nothing: f64) {
        self.labels.fill(CUT_OFF);
        self.first.fill(NONE);
        self.count.fill(0);
        self.listed.fill(false);
        self.gap = CUT_OFF;
        self.highest = 0;
        self.queue.clear();
        for (v, s) in surplus.iter().enumerate() {
            if *s < -nothing {
                self.labels[v] = 0;
                self.queue.push(v as u32);
            }
        }
        let mut at = 0;
        while let Some(&v) = self.queue.get(at) {
            at += 1;
            let label = self.labels[v as usize];
            self.count[label as usize] += 1;
            if surplus[v as usize] > nothing {
                self.list(v, label);
            }
            for half in &halves.list[halves.range(v)] {
                let there = &mut self.labels[half.head as usize];
                if *there == CUT_OFF && halves.list[half.mate as usize].room > 0.0 {
                    *there = label + 1;
                    self.queue.push(half.head);
                }
            }
        }
        self.work += halves.list.len() as u64;
    }

    #[inline]
    fn list(&mut self, v: u32, label: u32) {
        if !self.listed[v as usize] {
            self.listed[v as usize] = true;
            self.follower[v as usize] = self.first[label as usize];
            self.first[label as usize] = v;
            self.highest = self.highest.max(label as usize);
        }
    }

    /// Pushes the surplus of a node on until nothing is left or the node is cut off.
    fn discharge(&mut self, v: u32, halves: &mut Halves, surplus: &mut [f64], nothing: f64) {
        let mut label = self.labels[v as usize];
        if label > self.gap {
            self.labels[v as usize] = CUT_OFF;
            return;
        }
        let mut here = surplus[v as usize];
        loop {
            // The lowest label that can be pushed to.
            let mut lowest = CUT_OFF;
            for h in halves.range(v) {
                self.work += 1;
                let Half { head, mate, room } = halves.list[h];
                if room <= 0.0 {
                    continue;
                }
                let there = self.labels[head as usize];
                if there < label {
                    let step = here.min(room);
                    let left = room - step;
                    halves.list[h].room = if left <= nothing { 0.0 } else { left };
                    halves.list[mate as usize].room += step;
                    here -= step;
                    surplus[head as usize] += step;
                    if surplus[head as usize] > nothing {
                        self.list(head, there);
                    }
                    if here <= nothing {
                        surplus[v as usize] = here;
                        return;
                    }
                    if left <= nothing {
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
                self.labels[v as usize] = CUT_OFF;
                surplus[v as usize] = here;
                return;
            }
            label = lowest + 1;
            self.labels[v as usize] = label;
            self.count[label as usize] += 1;
        }
    }
}
