//! A tree of bounding boxes over the corners or edges of a polygon.

/// A bounding box; empty if its lower end lies above its upper end.
#[derive(Clone, Copy)]
pub(crate) struct Box2 {
    low: [f64; 2],
    high: [f64; 2],
}

impl Box2 {
    const EMPTY: Box2 = Box2 { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };

    pub fn of<const N: usize>(points: [[f64; 2]; N]) -> Box2 {
        points.iter().fold(Box2::EMPTY, |b, &p| b.joined(Box2 { low: p, high: p }))
    }
    fn joined(self, other: Box2) -> Box2 {
        Box2 {
            low: [0, 1].map(|k| self.low[k].min(other.low[k])),
            high: [0, 1].map(|k| self.high[k].max(other.high[k])),
        }
    }
    fn is_empty(&self) -> bool {
        self.low[0] > self.high[0]
    }
    /// Returns whether the boxes share a point.
    pub fn meets(&self, other: &Box2) -> bool {
        (0..2).all(|k| self.low[k] <= other.high[k] && other.low[k] <= self.high[k])
    }
    /// Returns the least and greatest value of the cross product (b - a) x (p - a) over the points
    /// p of the box.
    pub fn sides_of(&self, a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let terms = [
            [dx * (self.low[1] - a[1]), dx * (self.high[1] - a[1])],
            [dy * (a[0] - self.low[0]), dy * (a[0] - self.high[0])],
        ];
        let pick = |f: fn(f64, f64) -> f64| f(terms[0][0], terms[0][1]) + f(terms[1][0], terms[1][1]);
        [pick(f64::min), pick(f64::max)]
    }
}

/// A complete binary tree of boxes over items sorted like a k-d tree, alternately by x and y. Node
/// `i` has the children `2 i` and `2 i + 1`. Items can be removed.
pub(crate) struct BoxTree {
    nodes: Vec<Box2>,
    leaves: usize,
    /// The item of each leaf.
    items: Vec<usize>,
    /// The leaf of each item.
    places: Vec<usize>,
}

impl BoxTree {
    /// Builds the tree. Items of `boxes` that are `None` are absent.
    ///
    /// # Cost
    /// O(n log n).
    pub fn new(boxes: &[Option<Box2>]) -> BoxTree {
        let present = |i: &usize| boxes[*i].is_some();
        let mut items: Vec<usize> = (0..boxes.len()).filter(present).collect();
        let leaves = items.len().next_power_of_two();
        let centre = |i: usize, axis: usize| boxes[i].map_or(0.0, |b| b.low[axis] + b.high[axis]);
        sort(&mut items, leaves, 0, &centre);
        let mut places = vec![ABSENT; boxes.len()];
        let mut nodes = vec![Box2::EMPTY; 2 * leaves];
        for (place, &item) in items.iter().enumerate() {
            places[item] = place;
            nodes[leaves + place] = boxes[item].unwrap_or(Box2::EMPTY);
        }
        for i in (1..leaves).rev() {
            nodes[i] = nodes[2 * i].joined(nodes[2 * i + 1]);
        }
        BoxTree { nodes, leaves, items, places }
    }

    /// Returns whether an item is present.
    pub fn contains(&self, item: usize) -> bool {
        self.places[item] != ABSENT
    }

    /// Removes an item that is present, and shrinks the boxes that contain it.
    pub fn remove(&mut self, item: usize) {
        let place = std::mem::replace(&mut self.places[item], ABSENT);
        let mut i = self.leaves + place;
        self.nodes[i] = Box2::EMPTY;
        while i > 1 {
            i /= 2;
            self.nodes[i] = self.nodes[2 * i].joined(self.nodes[2 * i + 1]);
        }
    }

    /// Returns the first result of `visit` for an item whose box, and all boxes around it, are
    /// accepted by `enter`.
    pub fn find<T>(
        &self,
        enter: impl Fn(&Box2) -> bool,
        mut visit: impl FnMut(usize) -> Option<T>,
    ) -> Option<T> {
        // Depth first: each level leaves at most one node on the stack.
        let mut stack = [1usize; usize::BITS as usize + 1];
        let mut size = 1;
        while size > 0 {
            size -= 1;
            let node = stack[size];
            if self.nodes[node].is_empty() || !enter(&self.nodes[node]) {
                continue;
            }
            if node >= self.leaves {
                if let Some(found) = visit(self.items[node - self.leaves]) {
                    return Some(found);
                }
            } else {
                stack[size] = 2 * node + 1;
                stack[size + 1] = 2 * node;
                size += 2;
            }
        }
        None
    }
}

/// The position of an item that is absent.
const ABSENT: usize = usize::MAX;

/// Sorts the items below a node with room for `leaves`: the items of its first child come first.
fn sort(items: &mut [usize], leaves: usize, axis: usize, centre: &impl Fn(usize, usize) -> f64) {
    if items.len() <= 1 {
        return;
    }
    let half = leaves / 2;
    if half < items.len() {
        items.select_nth_unstable_by(half, |&i, &j| {
            centre(i, axis).total_cmp(&centre(j, axis)).then(i.cmp(&j))
        });
        sort(&mut items[half..], half, 1 - axis, centre);
    }
    let first = half.min(items.len());
    sort(&mut items[..first], half, 1 - axis, centre);
}
