//! Rescaling of meshes at the ends of the range of doubles, where areas overflow or underflow.

use crate::geometry::triangle::{Triangle, power_of_two_near};
use eikona_mesh::{Face, TriangleMesh};
use eikona_numeric::{NumericError, check_step};

/// Coordinates between this and its inverse need no rescaling: areas and their products stay far
/// from the ends of the range.
const SMALL: f64 = 1e-60;

/// Returns a power of two by which lengths can be divided to bring the mesh into the middle of the
/// range of doubles; 1 if it is there already. For methods whose results do not depend on size.
pub(crate) fn unit_of(mesh: &TriangleMesh) -> f64 {
    unit_near(mesh.positions().iter().flatten().fold(0.0f64, |m, x| m.max(x.abs())))
}

fn unit_near(largest: f64) -> f64 {
    if (SMALL..=1.0 / SMALL).contains(&largest) { 1.0 } else { power_of_two_near(largest) }
}

/// Returns the triangles of all faces in this unit of length. Fails if the observer stops the
/// computation.
pub(crate) fn lay_out_in(mesh: &TriangleMesh, unit: f64) -> Result<Vec<Triangle>, NumericError> {
    let mut triangles = Vec::with_capacity(mesh.face_count());
    for face in mesh.faces() {
        check_step(face.index())?;
        triangles.push(if unit == 1.0 { Triangle::of_face(mesh, face) } else { face_in(mesh, face, unit) });
    }
    Ok(triangles)
}

/// Returns the triangle of a face in this unit of length.
pub(crate) fn face_in(mesh: &TriangleMesh, face: Face, unit: f64) -> Triangle {
    Triangle::of_corners(mesh.face_positions(face).map(|p| p.map(|x| x / unit)))
}

/// Returns the shape of a face: its triangle in a unit chosen for this face.
pub(crate) fn shape_of_face(mesh: &TriangleMesh, face: Face) -> Triangle {
    let largest = mesh.face_positions(face).iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    face_in(mesh, face, unit_near(largest))
}
