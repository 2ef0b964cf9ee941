//! Meshes at the ends of the range of doubles, where areas overflow or vanish.

use crate::geometry::triangle::{Triangle, lay_out, power_of_two_near};
use eikona_mesh::{Face, TriangleMesh};

/// Coordinates from here to the inverse are taken as they are: areas, and products of those, stay
/// far from the ends of the range.
const SMALL: f64 = 1e-60;

/// A power of two that brings the mesh into the middle of the range of doubles when all lengths are
/// divided by it; 1 if it is there. For methods whose results do not depend on size.
pub(crate) fn unit_of(mesh: &TriangleMesh) -> f64 {
    unit_near(mesh.positions().iter().flatten().fold(0.0f64, |m, x| m.max(x.abs())))
}

fn unit_near(largest: f64) -> f64 {
    if (SMALL..=1.0 / SMALL).contains(&largest) { 1.0 } else { power_of_two_near(largest) }
}

/// The triangles of all faces in such units.
pub(crate) fn lay_out_in(mesh: &TriangleMesh, unit: f64) -> Vec<Triangle> {
    if unit == 1.0 { lay_out(mesh) } else { mesh.faces().map(|f| face_in(mesh, f, unit)).collect() }
}

/// The triangle of a face in such units.
pub(crate) fn face_in(mesh: &TriangleMesh, face: Face, unit: f64) -> Triangle {
    Triangle::of_corners(mesh.face_positions(face).map(|p| p.map(|x| x / unit)))
}

/// The shape of a face: its triangle in a unit of its own.
pub(crate) fn shape_of_face(mesh: &TriangleMesh, face: Face) -> Triangle {
    let largest = mesh.face_positions(face).iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    face_in(mesh, face, unit_near(largest))
}
