//! A tree of bounding boxes over the corners of a polygon, in their order.

/// Bounding box; empty if its lower end lies above its upper end.
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
    /// Whether the boxes share a point.
    pub fn meets(&self, other: &Box2) -> bool {
        (0..2).all(|k| self.low[k] <= other.high[k] && other.low[k] <= self.high[k])
    }
    /// Least and greatest value of the cross product (b - a) x (p - a) over the points p of the box.
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

/// Complete binary tree of boxes: node `i` has the children `2 i` and `2 i + 1`. Neighbours on a
/// polygon are near each other, so their order serves as well as a spatial sort.
pub(crate) struct ChainTree {
    nodes: Vec<Box2>,
    leaves: usize,
}

impl ChainTree {
    /// Builds the tree; `None` stands for items that are absent.
    pub fn new(boxes: impl ExactSizeIterator<Item = Option<Box2>>) -> ChainTree {
        let leaves = boxes.len().next_power_of_two();
        let mut nodes = vec![Box2::EMPTY; 2 * leaves];
        for (i, b) in boxes.enumerate() {
            nodes[leaves + i] = b.unwrap_or(Box2::EMPTY);
        }
        for i in (1..leaves).rev() {
            nodes[i] = nodes[2 * i].joined(nodes[2 * i + 1]);
        }
        ChainTree { nodes, leaves }
    }

    /// Whether an item is present.
    pub fn contains(&self, item: usize) -> bool {
        let b = self.nodes[self.leaves + item];
        b.low[0] <= b.high[0]
    }

    /// Removes an item and shrinks the boxes around it.
    pub fn remove(&mut self, item: usize) {
        let mut i = self.leaves + item;
        self.nodes[i] = Box2::EMPTY;
        while i > 1 {
            i /= 2;
            self.nodes[i] = self.nodes[2 * i].joined(self.nodes[2 * i + 1]);
        }
    }

    /// Gives the first result of `visit` for an item from `from` on whose box and all boxes around
    /// it `enter` accepts.
    pub fn find<T>(
        &self,
        from: usize,
        enter: impl Fn(&Box2) -> bool,
        mut visit: impl FnMut(usize) -> Option<T>,
    ) -> Option<T> {
        // Nodes still to be entered, with the depth-first path never deeper than the bits of an index.
        let mut stack = [0usize; 2 * usize::BITS as usize];
        let mut size = 1;
        stack[0] = 1;
        while size > 0 {
            size -= 1;
            let node = stack[size];
            // The last leaf below the node.
            let below = (self.leaves / (1 << node.ilog2())).max(1);
            let last = (node + 1) * below - 1 - self.leaves;
            if last < from || self.nodes[node].low[0] > self.nodes[node].high[0] || !enter(&self.nodes[node])
            {
                continue;
            }
            if node >= self.leaves {
                if let Some(found) = visit(node - self.leaves) {
                    return Some(found);
                }
                continue;
            }
            stack[size] = 2 * node + 1;
            stack[size + 1] = 2 * node;
            size += 2;
        }
        None
    }
}
