//! Self-intersection test for polygons.

use super::box_tree::{Box2, BoxTree};
use super::outline::{exact_side, tolerance};
use std::cell::Cell;

/// Mean number of boxes visited per edge after which the search stops.
const BOXES_PER_EDGE: usize = 200;

/// Returns whether two edges cross in their interiors. Edges that touch or overlap do not cross.
///
/// # Cost
/// O(n log n) for most polygons. Where many long edges lie close together, as in a bundle of
/// needles, the search stops after O(n) boxes and misses the crossings not yet found.
pub(crate) fn crosses_itself(points: &[[f64; 2]]) -> bool {
    let n = points.len();
    let edge = |k: usize| [points[k], points[(k + 1) % n]];
    let boxes: Vec<_> = (0..n).map(|k| Some(Box2::of(edge(k)))).collect();
    let tree = BoxTree::new(&boxes);
    let entered = Cell::new(0);
    (0..n).take_while(|_| entered.get() < BOXES_PER_EDGE * n + 4096).any(|k| {
        let [a, b] = edge(k);
        let own = Box2::of([a, b]);
        let margin = tolerance((b[0] - a[0]).powi(2) + (b[1] - a[1]).powi(2)) + f64::EPSILON;
        let near = |other: &Box2| {
            entered.set(entered.get() + 1);
            let [least, greatest] = other.sides_of(a, b);
            own.meets(other) && least <= margin && greatest >= -margin
        };
        tree.find(near, |j| {
            let [c, d] = edge(j);
            let apart = |p, q, r, s| exact_side(p, q, r) * exact_side(p, q, s) < 0.0;
            (apart(a, b, c, d) && apart(c, d, a, b)).then_some(())
        })
        .is_some()
    })
}
