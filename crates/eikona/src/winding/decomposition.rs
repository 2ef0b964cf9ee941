//! Which parts of the curve bound (section 3.5).

use crate::winding::chain::Step;
use eikona_mesh::Edge;
use std::collections::BTreeMap;

/// Jumps of the nonbounding part below this are taken for none.
pub(crate) const THRESHOLD: f64 = 0.1;

/// What a step of the curve belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The boundary of regions.
    Bounding,
    /// Loops that bound nothing.
    Nonbounding,
    /// Nothing: the step runs along the boundary of the surface or an edge of three faces, or
    /// cancels with another.
    LeftOut,
}

/// For every step of the input its part. Of the steps along an edge as many count as its jump has
/// copies, in the direction of the jump; and of these as many are nonbounding as the nonbounding
/// jump has copies.
pub(crate) fn parts_of(steps: &[Step], jump: &[i32], nonbounding: &[f64]) -> Vec<Part> {
    // Copies that are left to be told, of both kinds.
    let mut left: BTreeMap<Edge, [i32; 2]> = BTreeMap::new();
    let part = |step: &Step| {
        let (jump, t) = (jump[step.edge.index()], nonbounding[step.edge.index()]);
        if step.jump * jump.signum() <= 0 {
            return Part::LeftOut;
        }
        let [nonbounding, all] = left.entry(step.edge).or_insert_with(|| {
            let has_part = t.abs() > THRESHOLD && (t > 0.0) == (jump > 0);
            [if has_part { t.abs().round().max(1.0) as i32 } else { 0 }, jump.abs()]
        });
        if *all == 0 {
            return Part::LeftOut;
        }
        *all -= 1;
        if *nonbounding == 0 {
            return Part::Bounding;
        }
        *nonbounding -= 1;
        Part::Nonbounding
    };
    steps.iter().map(part).collect()
}
