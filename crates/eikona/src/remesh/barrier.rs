//! Parts of space that a surface stays out of, other than meshes.

use super::changing::Vec3;
use super::guard::Replacement;
use std::fmt::Debug;

/// Operations may bring a face closer to a barrier by this share of the distance that it has, or
/// that those have which it replaces. Potentials of barriers are high powers of the distance.
const CLOSEST: f64 = 0.5;

/// A part of space that a surface stays out of.
pub(crate) trait Barrier: Debug + Send + Sync {
    /// A bound of the distance of a triangle, not far below it. Zero if the triangle touches.
    fn gap(&self, triangle: [Vec3; 3]) -> f64;

    /// Whether a triangle passes the barrier nowhere as its corners move along straight lines.
    fn clears(&self, triangle: [Vec3; 3], ways: [Vec3; 3]) -> bool;
}

/// Whether the surface can go over from the removed faces to the added ones.
pub(super) fn allows(barrier: &dyn Barrier, removed: &[[Vec3; 3]], replacement: &Replacement) -> bool {
    let gap =
        |triangles: &[[Vec3; 3]]| triangles.iter().map(|t| barrier.gap(*t)).fold(f64::INFINITY, f64::min);
    let sides = |[a, b, c, d]: [Vec3; 4]| [[a, b, c], [a, b, d], [a, c, d], [b, c, d]];
    gap(&replacement.added) >= CLOSEST * gap(removed)
        && replacement.between.iter().all(|t| gap(&sides(*t)) > 0.0)
}

/// Whether a face can move.
pub(super) fn allows_motion(barrier: &dyn Barrier, from: [Vec3; 3], to: [Vec3; 3], ways: [Vec3; 3]) -> bool {
    barrier.gap(to) >= CLOSEST * barrier.gap(from) && barrier.clears(from, ways)
}
