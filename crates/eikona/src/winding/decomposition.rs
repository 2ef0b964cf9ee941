//! Decomposition of the curve into bounding and nonbounding parts (section 3.5).

use crate::winding::chain::Step;
use eikona_mesh::Edge;
use std::collections::BTreeMap;

/// Nonbounding jumps below this count as zero.
pub(crate) const THRESHOLD: f64 = 0.1;

/// The part of the curve that a step belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The boundary of regions.
    Bounding,
    /// Loops that bound nothing.
    Nonbounding,
    /// Neither: the step runs along the boundary of the surface or an edge of three or more faces,
    /// or cancels with another.
    LeftOut,
}

/// Returns the part of every step of the input. Along an edge with a jump of `n`, the first `|n|`
/// steps in the direction of the jump count; the first of these are nonbounding, as many as the
/// rounded nonbounding jump.
pub(crate) fn parts_of(steps: &[Step], jump: &[i32], nonbounding: &[f64]) -> Vec<Part> {
    // Copies not yet assigned, nonbounding ones and all.
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
