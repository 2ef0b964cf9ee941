//! Pairs of triangles whose distance is small relative to their size.

use super::cluster_tree::ClusterTree;
use crate::geometry::vector::{add, distance, scale};
use eikona_numeric::{NumericError, check_step, check_stopped, together};
use std::ops::Range;

type Vec3 = [f64; 3];

/// Pairs of triangles.
#[derive(Clone, Debug, Default)]
pub(crate) struct ClosePairs {
    /// The lower number first, in increasing order; at most as many as asked for.
    pub pairs: Vec<[u32; 2]>,
    /// The number of all pairs, or one that is larger than asked for.
    pub count: usize,
}

/// The centroid of a triangle and the largest distance of a corner from it.
#[derive(Clone, Copy)]
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
    let search = Search::new(triangles, separation)?;
    let leaves = search.leaves();
    let shares = leaves.chunks(leaves.len().div_ceil(threads.max(1)).max(1));
    let parts = together(shares.map(|leaves| || search.pairs_of(leaves, &counts, most)));
    let mut all = ClosePairs::default();
    for part in parts {
        let part = part?;
        all.count += part.count;
        all.pairs.extend(part.pairs);
    }
    all.pairs.sort_unstable();
    all.pairs.truncate(most);
    Ok(all)
}

/// Triangles in a tree.
struct Search {
    separation: f64,
    tree: ClusterTree,
    /// Boxes of the clusters.
    boxes: Vec<Aabb>,
    /// The largest radius in each cluster.
    largest: Vec<f64>,
    /// In the order of the tree.
    balls: Vec<Ball>,
}

impl Search {
    fn new(triangles: &[[Vec3; 3]], separation: f64) -> Result<Search, NumericError> {
        let balls: Vec<Ball> = triangles.iter().map(|corners| Ball::of(*corners)).collect();
        let centres: Vec<Vec3> = balls.iter().map(|ball| ball.centre).collect();
        check_stopped()?;
        let tree = ClusterTree::new(&centres);
        check_stopped()?;
        let balls = tree.in_order(&balls);
        let mut boxes = vec![Aabb::EMPTY; tree.nodes().len()];
        let mut largest = vec![0.0f64; boxes.len()];
        for node in (0..boxes.len()).rev() {
            if let Some([a, b]) = tree.children(node) {
                boxes[node] = boxes[a].including(boxes[b].low).including(boxes[b].high);
                largest[node] = largest[a].max(largest[b]);
            } else {
                for place in tree.nodes()[node].places() {
                    let corners = triangles[tree.order()[place] as usize];
                    boxes[node] = corners.iter().fold(boxes[node], |whole, &p| whole.including(p));
                    largest[node] = largest[node].max(balls[place].radius);
                }
            }
        }
        Ok(Search { separation, tree, boxes, largest, balls })
    }

    fn leaves(&self) -> Vec<usize> {
        (0..self.boxes.len()).filter(|&node| self.tree.nodes()[node].is_leaf()).collect()
    }

    /// The pairs of triangles of some leaves with triangles at later places. Stops beyond
    /// `most`.
    fn pairs_of(
        &self,
        leaves: &[usize],
        counts: impl Fn(usize, usize) -> bool,
        most: usize,
    ) -> Result<ClosePairs, NumericError> {
        let mut found = ClosePairs::default();
        let mut stack = Vec::new();
        for (step, &leaf) in leaves.iter().enumerate() {
            check_step(16 * step)?;
            let own = self.tree.nodes()[leaf].places();
            stack.push(0);
            while let Some(node) = stack.pop() {
                if found.count > most {
                    return Ok(found);
                }
                let places = self.tree.nodes()[node].places();
                let largest = self.largest[leaf].max(self.largest[node]);
                let apart = self.separation * self.boxes[node].distance(&self.boxes[leaf]) >= largest;
                if places.end <= own.start || apart {
                    continue;
                }
                if let Some(children) = self.tree.children(node) {
                    stack.extend(children);
                } else {
                    self.pairs_between(own.clone(), places, &counts, most, &mut found);
                }
            }
        }
        Ok(found)
    }

    fn pairs_between(
        &self,
        own: Range<usize>,
        others: Range<usize>,
        counts: impl Fn(usize, usize) -> bool,
        most: usize,
        found: &mut ClosePairs,
    ) {
        for a in own {
            for b in others.start.max(a + 1)..others.end {
                let largest = self.balls[a].radius.max(self.balls[b].radius);
                if self.separation * self.balls[a].gap(&self.balls[b]) >= largest {
                    continue;
                }
                let [s, t] = [a, b].map(|place| self.tree.order()[place]);
                let [f, g] = [s.min(t), s.max(t)].map(|f| f as usize);
                if counts(f, g) {
                    found.count += 1;
                    if found.pairs.len() < most {
                        found.pairs.push([f as u32, g as u32]);
                    }
                }
            }
        }
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
