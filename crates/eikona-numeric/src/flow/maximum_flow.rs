//! Maximum flow from nodes with a surplus to nodes with a deficit, by growing breadth-first trees from both ends.
//!
//! Incremental breadth-first search (Goldberg, Hed, Kaplan, Tarjan, Werneck 2011): a tree of the nodes that surplus reaches and one
//! of those that reach a deficit grow by one level in turn. Where they touch, flow is sent; nodes cut off from their tree by
//! that look for a parent at the same distance, else at a larger one, else leave. Paths are shortest at all times, so the number of
//! steps is bounded whatever the capacities are: O(n^2 m); on surfaces it grows little faster than the flow's own length.

/// One of the two directions of an arc, seen from the node where it starts.
#[derive(Clone, Copy)]
pub(super) struct Half {
    /// Where it leads.
    pub(super) head: u32,
    /// The other direction.
    pub(super) mate: u32,
    /// How much flow it can take. May be infinite.
    pub(super) room: f64,
    /// What a unit of flow costs in this direction, infinite if there is no room at any price. Used by the levels only.
    pub(super) cost: f64,
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

#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Free,
    Source,
    Sink,
}

/// In place of a parent: the node has a surplus or deficit of its own.
const ROOT: u32 = u32::MAX;

#[derive(Clone, Copy)]
struct Mark {
    side: Side,
    label: u32,
    /// The half from the node to its parent.
    parent: u32,
}

/// A tree that grows: its depth and the nodes at that depth.
struct Growth {
    depth: u32,
    front: Vec<u32>,
    next: Vec<u32>,
}

/// What is kept from one run to the next.
pub(super) struct MaximumFlow {
    marks: Vec<Mark>,
    source: Growth,
    sink: Growth,
    orphans: std::collections::VecDeque<u32>,
    /// Steps taken.
    pub(super) work: u64,
}

impl MaximumFlow {
    pub(super) fn new(nodes: usize) -> MaximumFlow {
        let growth = || Growth { depth: 1, front: Vec::new(), next: Vec::new() };
        MaximumFlow {
            marks: vec![Mark { side: Side::Free, label: 0, parent: ROOT }; nodes],
            source: growth(),
            sink: growth(),
            orphans: std::collections::VecDeque::new(),
            work: 0,
        }
    }

    /// Sends as much as possible from nodes of positive to nodes of negative surplus. What is at most `tolerance` in size counts as
    /// nothing. Stops early after `work_limit` steps.
    pub(super) fn run(&mut self, halves: &mut Halves, surplus: &mut [f64], tolerance: f64, work_limit: u64) {
        self.marks.fill(Mark { side: Side::Free, label: 0, parent: ROOT });
        for growth in [&mut self.source, &mut self.sink] {
            growth.depth = 1;
            growth.front.clear();
            growth.next.clear();
        }
        for (v, s) in surplus.iter().enumerate() {
            if s.abs() > tolerance {
                let (side, growth) = match *s > 0.0 {
                    true => (Side::Source, &mut self.source),
                    false => (Side::Sink, &mut self.sink),
                };
                self.marks[v] = Mark { side, label: 1, parent: ROOT };
                growth.front.push(v as u32);
            }
        }
        let end = self.work.saturating_add(work_limit);
        let mut run = Run { flow: self, halves, surplus, tolerance, growing: Side::Free };
        while !run.flow.source.front.is_empty() && !run.flow.sink.front.is_empty() && run.flow.work < end {
            let source_is_smaller = run.flow.source.front.len() <= run.flow.sink.front.len();
            run.grow(if source_is_smaller { Side::Source } else { Side::Sink });
        }
    }
}

struct Run<'a> {
    flow: &'a mut MaximumFlow,
    halves: &'a mut Halves,
    surplus: &'a mut [f64],
    tolerance: f64,
    growing: Side,
}

impl Run<'_> {
    fn growth(&mut self, side: Side) -> &mut Growth {
        if side == Side::Source { &mut self.flow.source } else { &mut self.flow.sink }
    }

    /// Room for flow that comes down a tree over a half which is seen from below: towards the node in the tree of the sources,
    /// away from it in that of the sinks.
    #[inline]
    fn room_from_parent(&self, side: Side, half: usize) -> f64 {
        let half = &self.halves.list[half];
        if side == Side::Source { self.halves.list[half.mate as usize].room } else { half.room }
    }

    /// One more level of a tree.
    fn grow(&mut self, side: Side) {
        self.growing = side;
        let depth = self.growth(side).depth;
        let mut at = 0;
        while let Some(&v) = self.growth(side).front.get(at) {
            at += 1;
            for h in self.halves.range(v) {
                self.flow.work += 1;
                let Half { head, mate, room, .. } = self.halves.list[h];
                let outward = if side == Side::Source { room } else { self.halves.list[mate as usize].room };
                if outward <= 0.0 {
                    continue;
                }
                let mark = self.flow.marks[v as usize];
                if mark.side != side || mark.label != depth {
                    break;
                }
                match self.flow.marks[head as usize].side {
                    Side::Free => {
                        self.flow.marks[head as usize] = Mark { side, label: depth + 1, parent: mate };
                        self.growth(side).next.push(head);
                    }
                    other if other != side => self.touch(v, h),
                    _ => {}
                }
            }
        }
        let growth = self.growth(side);
        growth.depth += 1;
        growth.front.clear();
        std::mem::swap(&mut growth.front, &mut growth.next);
    }

    /// Sends flow over a half between the trees until it is full or one of its ends has changed trees.
    fn touch(&mut self, v: u32, h: usize) {
        let Half { head, mate, .. } = self.halves.list[h];
        let depth = self.flow.marks[v as usize].label;
        let (bridge, from, to) = match self.growing == Side::Source {
            true => (h, v, head),
            false => (mate as usize, head, v),
        };
        while self.halves.list[bridge].room > 0.0
            && self.flow.marks[from as usize].side == Side::Source
            && self.flow.marks[to as usize].side == Side::Sink
            && self.flow.marks[v as usize].label == depth
        {
            self.augment(bridge, from, to);
            self.adopt();
        }
    }

    /// Sends flow along the path through a bridge. What it fills cuts nodes off.
    fn augment(&mut self, bridge: usize, from: u32, to: u32) {
        let mut step = self.halves.list[bridge].room;
        for (side, end) in [(Side::Source, from), (Side::Sink, to)] {
            let mut v = end;
            loop {
                let parent = self.flow.marks[v as usize].parent;
                if parent == ROOT {
                    break;
                }
                step = step.min(self.room_from_parent(side, parent as usize));
                v = self.halves.list[parent as usize].head;
                self.flow.work += 1;
            }
            step = step.min(self.surplus[v as usize].abs());
        }
        self.send(bridge, step);
        for (side, end) in [(Side::Source, from), (Side::Sink, to)] {
            let mut v = end;
            loop {
                let parent = self.flow.marks[v as usize].parent;
                if parent == ROOT {
                    break;
                }
                let towards_sinks = match side == Side::Source {
                    true => self.halves.list[parent as usize].mate as usize,
                    false => parent as usize,
                };
                if self.send(towards_sinks, step) {
                    self.flow.orphans.push_back(v);
                }
                v = self.halves.list[parent as usize].head;
            }
            let surplus = &mut self.surplus[v as usize];
            *surplus -= if side == Side::Source { step } else { -step };
            if surplus.abs() <= self.tolerance {
                self.flow.orphans.push_back(v);
            }
        }
    }

    /// True if the half is full then.
    #[inline]
    fn send(&mut self, half: usize, step: f64) -> bool {
        let Half { mate, room, .. } = self.halves.list[half];
        let left = room - step;
        self.halves.list[half].room = if left <= self.tolerance { 0.0 } else { left };
        self.halves.list[mate as usize].room += step;
        left <= self.tolerance
    }

    /// Finds new parents for nodes that were cut off.
    fn adopt(&mut self) {
        while let Some(v) = self.flow.orphans.pop_front() {
            let Mark { side, label, .. } = self.flow.marks[v as usize];
            let mut nearest = u32::MAX;
            let mut parent = ROOT;
            for h in self.halves.range(v) {
                self.flow.work += 1;
                let u = self.halves.list[h].head;
                let mark = self.flow.marks[u as usize];
                if mark.side == side && mark.label < nearest && self.room_from_parent(side, h) > 0.0 {
                    (nearest, parent) = (mark.label, h as u32);
                    if nearest + 1 == label {
                        break;
                    }
                }
            }
            if parent != ROOT && nearest + 1 == label {
                self.flow.marks[v as usize].parent = parent;
                continue;
            }
            // What hangs on this node hangs too high or on nothing.
            for h in self.halves.range(v) {
                let Half { head, mate, .. } = self.halves.list[h];
                let mark = self.flow.marks[head as usize];
                if mark.side == side && mark.parent == mate {
                    self.flow.orphans.push_back(head);
                }
            }
            let depth = self.growth(side).depth;
            let deepest = depth + u32::from(self.growing == side);
            if parent == ROOT || nearest >= deepest {
                self.flow.marks[v as usize] = Mark { side: Side::Free, label: 0, parent: ROOT };
                continue;
            }
            let label = nearest + 1;
            self.flow.marks[v as usize] = Mark { side, label, parent };
            let growth = self.growth(side);
            if label == depth {
                growth.front.push(v);
            } else if label > depth {
                growth.next.push(v);
            }
        }
    }
}
