//! A binary tree of clusters of points, for sums over all pairs of points.

use eikona_numeric::{NumericError, check_step, for_chunks, side_by_side};
use std::ops::ControlFlow;

/// Points per leaf. Every leaf is full except the last, so that vectors of 2, 4 or 8 lanes fill it.
pub const LEAF_POINTS: usize = 8;

/// Subtrees with fewer clusters stay on one thread.
const WORTH_THREADS: usize = 1 << 9;

/// Leaves per unit of work.
const SHARE: usize = 1 << 7;

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
#[derive(Clone, Copy, Debug, Default)]
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
        ClusterTree::on_threads(points, 1)
    }

    /// Like [`new`](Self::new), on several threads. The tree is the same for any number.
    ///
    /// # Cost
    /// O(n log n). Splits of the largest clusters are not shared.
    ///
    /// ```
    /// use eikona::spatial::ClusterTree;
    /// let points: Vec<[f64; 3]> = (0..9000).map(|i| [f64::from(i).sin(), 0.0, 0.0]).collect();
    /// let tree = ClusterTree::on_threads(&points, 3);
    /// assert_eq!(tree.order(), ClusterTree::new(&points).order());
    /// ```
    pub fn on_threads(points: &[[f64; 3]], threads: usize) -> ClusterTree {
        let mut keyed: Vec<([f64; 3], u32)> = points.iter().copied().zip(0..).collect();
        let mut nodes = vec![Cluster::default(); cluster_count(points.len())];
        if !keyed.is_empty() {
            split(&mut keyed, 0, &mut nodes, threads);
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

    /// Returns the clusters without children, in the order of their places.
    pub(crate) fn leaves(&self) -> impl Iterator<Item = usize> {
        (0..self.nodes.len()).filter(|&node| self.nodes[node].is_leaf())
    }

    /// Does some work for all leaves, a number of them at a time, and returns what it gives in the
    /// order of the leaves. The division does not depend on the number of threads.
    ///
    /// # Errors
    /// An error of the work.
    pub(crate) fn over_leaves<R: Send>(
        &self,
        threads: usize,
        work: impl Fn(&[usize]) -> Result<R, NumericError> + Sync,
    ) -> Result<Vec<R>, NumericError> {
        let leaves: Vec<usize> = self.leaves().collect();
        let shares: Vec<&[usize]> = leaves.chunks(SHARE).collect();
        let mut results: Vec<Option<R>> = shares.iter().map(|_| None).collect();
        for_chunks(threads, &mut results, 1, |share, result| {
            result[0] = Some(work(shares[share])?);
            Ok(())
        })?;
        Ok(results.into_iter().flatten().collect())
    }

    /// Calls `visit` with the places of pairs of points until it breaks: the first point in some
    /// leaves, the second at a later place, for all leaves and clusters that may have pairs.
    ///
    /// # Errors
    /// [`NumericError::Stopped`].
    pub(crate) fn for_pairs(
        &self,
        leaves: &[usize],
        may_have: impl Fn(usize, usize) -> bool,
        mut visit: impl FnMut(usize, usize) -> ControlFlow<()>,
    ) -> Result<(), NumericError> {
        let mut stack = Vec::new();
        for (step, &leaf) in leaves.iter().enumerate() {
            check_step(16 * step)?;
            let own = self.nodes[leaf].places();
            stack.push(0);
            while let Some(node) = stack.pop() {
                let others = self.nodes[node].places();
                if others.end <= own.start || !may_have(leaf, node) {
                    continue;
                }
                if let Some(children) = self.children(node) {
                    stack.extend(children);
                    continue;
                }
                for a in own.clone() {
                    for b in others.start.max(a + 1)..others.end {
                        if visit(a, b).is_break() {
                            return Ok(());
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Calls `visit` for each cluster after its children, with its number, its values, and those of
    /// the children. There are `many` values per cluster.
    pub(crate) fn ascend<T: Send>(
        &self,
        values: &mut [T],
        many: usize,
        threads: usize,
        visit: impl Fn(usize, &mut [T], Option<[&[T]; 2]>) + Sync,
    ) {
        if !self.nodes.is_empty() {
            ascend(self, 0, values, many, threads, &visit);
        }
    }

    /// Calls `visit` for each cluster with children before these, with its values, and those of the
    /// children. There are `many` values per cluster.
    pub(crate) fn descend<T: Send>(
        &self,
        values: &mut [T],
        many: usize,
        threads: usize,
        visit: impl Fn([usize; 3], &[T], [&mut [T]; 2]) + Sync,
    ) {
        if !self.nodes.is_empty() {
            descend(self, 0, values, many, threads, &visit);
        }
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

fn cluster_count(points: usize) -> usize {
    (2 * points.div_ceil(LEAF_POINTS)).saturating_sub(1)
}

/// The number of threads for a part of a tree.
fn worth(threads: usize, clusters: usize) -> usize {
    if clusters < WORTH_THREADS { 1 } else { threads }
}

fn split(points: &mut [([f64; 3], u32)], first: usize, nodes: &mut [Cluster], threads: usize) {
    let threads = worth(threads, nodes.len());
    let (first_place, end) = (first as u32, (first + points.len()) as u32);
    nodes[0] = Cluster { first: first_place, end, nodes: nodes.len() as u32 };
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
    let (left_nodes, right_nodes) = nodes[1..].split_at_mut(cluster_count(half));
    side_by_side(
        threads,
        || split(right, first + half, right_nodes, threads / 2),
        || split(left, first, left_nodes, threads.div_ceil(2)),
    );
}

/// The values of a cluster, of the first child and what is below, and of the second child.
fn divided<'a, T>(tree: &ClusterTree, child: usize, values: &'a mut [T], many: usize) -> [&'a mut [T]; 3] {
    let (own, below) = values.split_at_mut(many);
    let (first, second) = below.split_at_mut(many * tree.nodes[child].nodes as usize);
    [own, first, second]
}

fn ascend<T: Send>(
    tree: &ClusterTree,
    node: usize,
    values: &mut [T],
    many: usize,
    threads: usize,
    visit: &(impl Fn(usize, &mut [T], Option<[&[T]; 2]>) + Sync),
) {
    let Some([first, second]) = tree.children(node) else { return visit(node, values, None) };
    let threads = worth(threads, tree.nodes[node].nodes as usize);
    let [own, at_first, at_second] = divided(tree, first, values, many);
    side_by_side(
        threads,
        || ascend(tree, second, at_second, many, threads / 2, visit),
        || ascend(tree, first, at_first, many, threads.div_ceil(2), visit),
    );
    visit(node, own, Some([&at_first[..many], &at_second[..many]]));
}

fn descend<T: Send>(
    tree: &ClusterTree,
    node: usize,
    values: &mut [T],
    many: usize,
    threads: usize,
    visit: &(impl Fn([usize; 3], &[T], [&mut [T]; 2]) + Sync),
) {
    let Some([first, second]) = tree.children(node) else { return };
    let threads = worth(threads, tree.nodes[node].nodes as usize);
    let [own, at_first, at_second] = divided(tree, first, values, many);
    visit([node, first, second], own, [&mut at_first[..many], &mut at_second[..many]]);
    side_by_side(
        threads,
        || descend(tree, second, at_second, many, threads / 2, visit),
        || descend(tree, first, at_first, many, threads.div_ceil(2), visit),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(count: usize) -> Vec<[f64; 3]> {
        (0..count).map(|i| [1.0, 2.0, 3.0].map(|k| (12.9898 * k * i as f64).sin())).collect()
    }

    #[test]
    fn trees_and_passes_over_them_do_not_depend_on_the_threads() {
        for count in [0, 1, 8, 9, 700, 30_000] {
            let points = points(count);
            let tree = ClusterTree::new(&points);
            // Sums of places, and the sums of those of all ancestors.
            let mut sums = vec![[0; 2]; 2 * tree.nodes().len()];
            let mut ancestors = sums.clone();
            for (node, cluster) in tree.nodes().iter().enumerate() {
                sums[2 * node] = [cluster.places().sum(), 1];
                sums[2 * node + 1] = [cluster.places().len(), 2];
                if let Some(children) = tree.children(node) {
                    for (child, k) in children.into_iter().flat_map(|child| [(child, 0), (child, 1)]) {
                        ancestors[2 * child + k] = [ancestors[2 * node + k][0] + sums[2 * node + k][0], 0];
                    }
                }
            }
            for threads in [1, 2, 3, 8] {
                let same = ClusterTree::on_threads(&points, threads);
                assert_eq!(same.order(), tree.order());
                assert!((0..sums.len() / 2).all(|node| same.children(node) == tree.children(node)));
                let mut found = vec![[0; 2]; sums.len()];
                same.ascend(&mut found, 2, threads, |node, own, children| {
                    let places = tree.nodes()[node].places();
                    own[0] = children.map_or([places.clone().sum(), 1], |[a, b]| [a[0][0] + b[0][0], 1]);
                    own[1] = children.map_or([places.len(), 2], |[a, b]| [a[1][0] + b[1][0], 2]);
                });
                assert_eq!(found, sums);
                let mut found = vec![[0; 2]; sums.len()];
                same.descend(&mut found, 2, threads, |[node, first, second], own, [left, right]| {
                    assert_eq!(tree.children(node), Some([first, second]));
                    for child in [left, right] {
                        (0..2).for_each(|k| child[k] = [own[k][0] + sums[2 * node + k][0], 0]);
                    }
                });
                assert_eq!(found, ancestors);
                let leaves = same.over_leaves(threads, |leaves| Ok(leaves.to_vec())).unwrap().concat();
                assert!(leaves.into_iter().eq(tree.leaves()));
            }
        }
    }

    #[test]
    fn pairs_are_all_visited_once() {
        let tree = ClusterTree::new(&points(100));
        let leaves: Vec<usize> = tree.leaves().collect();
        let mut pairs = Vec::new();
        let mut visit = |a, b| {
            pairs.push((a, b));
            ControlFlow::Continue(())
        };
        tree.for_pairs(&leaves, |_, _| true, &mut visit).unwrap();
        pairs.sort_unstable();
        assert!(pairs.into_iter().eq((0..100).flat_map(|a| (a + 1..100).map(move |b| (a, b)))));
        let mut visits = 0;
        let visit = |_, _| {
            visits += 1;
            if visits == 5 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        tree.for_pairs(&leaves, |_, _| true, visit).unwrap();
        assert_eq!(visits, 5);
    }
}
