//! Pairs of triangles whose distance is small relative to their size.

use super::cluster_tree::ClusterTree;
use crate::geometry::vector::{add, distance, scale};
use eikona_numeric::{NumericError, check_stopped, mapped};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

type Vec3 = [f64; 3];

/// Pairs of triangles.
#[derive(Clone, Debug, Default)]
pub(crate) struct ClosePairs {
    /// The lower number first, in increasing order; only one of them if there are more than asked
    /// for.
    pub pairs: Vec<[u32; 2]>,
    /// The number of all pairs, or one that is larger than asked for.
    pub count: usize,
}

/// The centroid of a triangle and the largest distance of a corner from it.
#[derive(Clone, Copy, Default)]
pub(crate) struct Ball {
    pub centre: Vec3,
    pub radius: f64,
}

impl Ball {
    pub fn of([a, b, c]: [Vec3; 3]) -> Ball {
        let centre = scale(add(add(a, b), c), 1.0 / 3.0);
        let radius = [a, b, c].iter().map(|p| distance(*p, centre)).fold(0.0, f64::max);
        Ball { centre, radius }
    }

    /// A lower bound of the distance of what the balls contain.
    pub fn gap(&self, other: &Ball) -> f64 {
        distance(self.centre, other.centre) - self.radius - other.radius
    }
}

/// Returns the pairs of triangles that count, among all those of which one may have a radius of
/// more than `separation` times their distance. The radius is the largest distance of a corner from
/// the centroid.
///
/// # Cost
/// O(F log F) if few triangles are close.
pub(crate) fn close_pairs(
    triangles: &[[Vec3; 3]],
    separation: f64,
    counts: impl Fn(usize, usize) -> bool + Sync,
    most: usize,
    threads: usize,
) -> Result<ClosePairs, NumericError> {
    let search = Search::new(triangles, separation, threads)?;
    let count = AtomicUsize::new(0);
    let parts = search.tree.over_leaves(threads, |leaves| {
        let mut pairs = Vec::new();
        search.for_pairs(leaves, &counts, |pair| {
            pairs.push(pair);
            if count.fetch_add(1, Relaxed) < most {
                ControlFlow::Continue(())
            } else {
                ControlFlow::Break(())
            }
        })?;
        Ok(pairs)
    })?;
    let count = count.into_inner();
    // Where the search ended depends on the threads; where it began does not.
    let mut pairs = if count > most { search.first(&counts)? } else { parts.concat() };
    pairs.sort_unstable();
    Ok(ClosePairs { pairs, count })
}

/// Triangles in a tree.
struct Search {
    separation: f64,
    tree: ClusterTree,
    clusters: Vec<Extent>,
    /// In the order of the tree.
    balls: Vec<Ball>,
}

/// The box of a cluster, and the largest radius in it.
#[derive(Clone, Copy)]
struct Extent {
    bounds: Aabb,
    largest: f64,
}

impl Search {
    fn new(triangles: &[[Vec3; 3]], separation: f64, threads: usize) -> Result<Search, NumericError> {
        let balls: Vec<Ball> = mapped(threads, triangles.len(), |f| Ball::of(triangles[f]))?;
        let centres: Vec<Vec3> = balls.iter().map(|ball| ball.centre).collect();
        let tree = ClusterTree::on_threads(&centres, threads);
        check_stopped()?;
        let balls = tree.in_order(&balls);
        let mut clusters = vec![Extent { bounds: Aabb::EMPTY, largest: 0.0 }; tree.nodes().len()];
        tree.ascend(&mut clusters, 1, threads, |node, own, children| {
            let own = &mut own[0];
            match children {
                Some([a, b]) => *own = a[0].joined(&b[0]),
                None => {
                    for place in tree.nodes()[node].places() {
                        let corners = triangles[tree.order()[place] as usize];
                        own.bounds = corners.iter().fold(own.bounds, |whole, &p| whole.including(p));
                        own.largest = own.largest.max(balls[place].radius);
                    }
                }
            }
        });
        Ok(Search { separation, tree, clusters, balls })
    }

    /// Calls `visit` with the pairs of triangles of some leaves with triangles at later places,
    /// until it breaks.
    fn for_pairs(
        &self,
        leaves: &[usize],
        counts: impl Fn(usize, usize) -> bool,
        mut visit: impl FnMut([u32; 2]) -> ControlFlow<()>,
    ) -> Result<(), NumericError> {
        let close = |leaf: usize, node: usize| {
            let [own, other] = [leaf, node].map(|node| &self.clusters[node]);
            self.separation * other.bounds.distance(&own.bounds) < own.largest.max(other.largest)
        };
        self.tree.for_pairs(leaves, close, |a, b| {
            let [own, other] = [a, b].map(|place| &self.balls[place]);
            if self.separation * own.gap(other) >= own.radius.max(other.radius) {
                return ControlFlow::Continue(());
            }
            let [s, t] = [a, b].map(|place| self.tree.order()[place]);
            let [f, g] = [s.min(t), s.max(t)];
            if counts(f as usize, g as usize) { visit([f, g]) } else { ControlFlow::Continue(()) }
        })
    }

    /// The first pair that is found, if there is one.
    fn first(&self, counts: impl Fn(usize, usize) -> bool) -> Result<Vec<[u32; 2]>, NumericError> {
        let leaves: Vec<usize> = self.tree.leaves().collect();
        let mut first = Vec::new();
        self.for_pairs(&leaves, counts, |pair| {
            first.push(pair);
            ControlFlow::Break(())
        })?;
        Ok(first)
    }
}

impl Extent {
    fn joined(&self, other: &Extent) -> Extent {
        let bounds = self.bounds.including(other.bounds.low).including(other.bounds.high);
        Extent { bounds, largest: self.largest.max(other.largest) }
    }
}

/// A box along the axes.
#[derive(Clone, Copy)]
struct Aabb {
    low: [f64; 3],
    high: [f64; 3],
}

impl Aabb {
    const EMPTY: Aabb = Aabb { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    fn including(mut self, p: [f64; 3]) -> Aabb {
        for k in 0..3 {
            self.low[k] = self.low[k].min(p[k]);
            self.high[k] = self.high[k].max(p[k]);
        }
        self
    }

    /// Distance of the boxes, zero if they meet.
    fn distance(&self, other: &Aabb) -> f64 {
        let apart =
            [0, 1, 2].map(|k| (other.low[k] - self.high[k]).max(self.low[k] - other.high[k]).max(0.0));
        apart.iter().map(|x| x * x).sum::<f64>().sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spatial::triangle_distance;
    use eikona_mesh::shapes;

    #[test]
    fn pairs_do_not_depend_on_the_threads() {
        let mesh = shapes::icosphere(4).unwrap();
        let triangles: Vec<[Vec3; 3]> = mesh.faces().map(|f| mesh.face_positions(f)).collect();
        let apart = |f: usize, g: usize| !mesh.triangles()[f].iter().any(|v| mesh.triangles()[g].contains(v));
        let find = |most: usize, threads: usize| close_pairs(&triangles, 0.7, apart, most, threads).unwrap();
        let all = find(usize::MAX, 1);
        for f in (0..triangles.len()).step_by(100) {
            for g in f + 1..triangles.len() {
                let [s, t] = [f, g].map(|f| Ball::of(triangles[f]));
                let near = |distance: f64| apart(f, g) && 0.7 * distance < s.radius.max(t.radius);
                let found = all.pairs.binary_search(&[f as u32, g as u32]).is_ok();
                let distance = triangle_distance(triangles[f], triangles[g]);
                assert!(if found { near(s.gap(&t)) } else { !near(distance) }, "{f} {g}");
            }
        }
        assert_eq!(all.pairs.len(), all.count);
        for threads in [2, 3] {
            assert_eq!(find(all.count, threads).pairs, all.pairs);
            let first = find(all.count - 1, threads);
            assert!(first.count >= all.count);
            assert_eq!((first.pairs.len(), &first.pairs), (1, &find(5, 1).pairs));
        }
    }
}
