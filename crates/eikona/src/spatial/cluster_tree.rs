//! A binary tree of clusters of points, for sums over all pairs of points.

/// Points per leaf. Every leaf is full except the last, so that vectors of 2, 4 or 8 lanes fill it.
pub const LEAF_POINTS: usize = 8;

/// A binary tree of clusters of points, in depth-first order.
///
/// Points are renumbered: those of a cluster have consecutive *places*, and the leaf `k` has the
/// places from `8 k` on. The tree depends on positions only through the order that it gives them,
/// so it stays valid as they move, though its clusters may grow.
///
/// ```
/// use eikona::spatial::ClusterTree;
/// let points: Vec<[f64; 3]> = (0..20).map(|i| [f64::from(19 - i), 0.0, 0.0]).collect();
/// let tree = ClusterTree::new(&points);
/// assert_eq!(tree.order()[0..8].iter().map(|p| p / 12).collect::<Vec<_>>(), [1; 8]);
/// let leaves = tree.nodes().iter().filter(|node| node.is_leaf());
/// assert_eq!(leaves.map(|leaf| leaf.places()).collect::<Vec<_>>(), [0..8, 8..16, 16..20]);
/// ```
#[derive(Clone, Debug)]
pub struct ClusterTree {
    nodes: Vec<Cluster>,
    order: Vec<u32>,
}

/// A cluster of a [`ClusterTree`].
#[derive(Clone, Copy, Debug)]
pub struct Cluster {
    first: u32,
    end: u32,
    /// Number of nodes of its subtree, itself included.
    nodes: u32,
}

impl Cluster {
    /// Returns the places of its points.
    pub fn places(&self) -> std::ops::Range<usize> {
        self.first as usize..self.end as usize
    }
    /// Returns whether it has no children.
    pub fn is_leaf(&self) -> bool {
        self.nodes == 1
    }
}

impl ClusterTree {
    /// Splits the points along the widest side of their box, about in half, until at most
    /// [`LEAF_POINTS`] are left.
    ///
    /// # Cost
    /// O(n log n).
    pub fn new(points: &[[f64; 3]]) -> ClusterTree {
        let mut keyed: Vec<([f64; 3], u32)> = points.iter().copied().zip(0..).collect();
        let mut nodes = Vec::with_capacity(2 * points.len().div_ceil(LEAF_POINTS));
        if !keyed.is_empty() {
            split(&mut keyed, 0, &mut nodes);
        }
        ClusterTree { nodes, order: keyed.into_iter().map(|(_, point)| point).collect() }
    }

    /// Returns the clusters in depth-first order: the root first, and the first child of a cluster
    /// right after it.
    pub fn nodes(&self) -> &[Cluster] {
        &self.nodes
    }

    /// Returns the two children of a cluster; `None` for a leaf.
    pub fn children(&self, node: usize) -> Option<[usize; 2]> {
        let first = node + 1;
        (!self.nodes[node].is_leaf()).then(|| [first, first + self.nodes[first].nodes as usize])
    }

    /// Returns what belongs to the points, in the order of the places.
    pub fn in_order<T: Copy>(&self, of_points: &[T]) -> Vec<T> {
        self.order.iter().map(|&point| of_points[point as usize]).collect()
    }

    /// Returns the point at each place.
    pub fn order(&self) -> &[u32] {
        &self.order
    }
}

fn split(points: &mut [([f64; 3], u32)], first: usize, nodes: &mut Vec<Cluster>) {
    let here = nodes.len();
    nodes.push(Cluster { first: first as u32, end: (first + points.len()) as u32, nodes: 1 });
    if points.len() <= LEAF_POINTS {
        return;
    }
    let (mut low, mut high) = (points[0].0, points[0].0);
    for (p, _) in points.iter() {
        for k in 0..3 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    let width = [0, 1, 2].map(|k| high[k] - low[k]);
    let widest = (0..3).max_by(|&i, &j| width[i].total_cmp(&width[j])).unwrap_or(0);
    // The first half consists of full leaves.
    let half = (points.len() / 2).next_multiple_of(LEAF_POINTS);
    let half = if half < points.len() { half } else { half - LEAF_POINTS };
    points.select_nth_unstable_by(half, |a, b| a.0[widest].total_cmp(&b.0[widest]).then(a.1.cmp(&b.1)));
    let (left, right) = points.split_at_mut(half);
    split(left, first, nodes);
    split(right, first + half, nodes);
    nodes[here].nodes = (nodes.len() - here) as u32;
}
