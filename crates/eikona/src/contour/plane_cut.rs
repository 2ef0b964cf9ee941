//! Where a plane cuts a mesh.

use super::ContourError;
use super::isolines::isolines;
use crate::geometry::vector::{dot, normalize, sub};
use eikona_mesh::{Curve, TriangleMesh};

/// The curves in which a plane cuts the mesh: signed, closed or ending at the boundary, one segment a face.
///
/// The side of the plane to which `normal` points is on the right of each curve, the other on the left. Vertices exactly
/// on the plane count as lying on the normal's side, so the cut of faces that lie in the plane is their rim towards the
/// other side.
///
/// # Errors
/// [`ContourError::BadPlane`] if the point or the normal is not finite, or the normal zero.
///
/// # Cost
/// O(F).
pub fn plane_cut(mesh: &TriangleMesh, point: [f64; 3], normal: [f64; 3]) -> Result<Vec<Curve>, ContourError> {
    let unit = normalize(normal).ok_or(ContourError::BadPlane { name: "normal", value: normal })?;
    if !point.iter().all(|x| x.is_finite()) {
        return Err(ContourError::BadPlane { name: "point", value: point });
    }
    let height: Vec<f64> = mesh.positions().iter().map(|&p| dot(sub(p, point), unit)).collect();
    Ok(isolines(mesh, &height.into(), &[0.0])?.pop().map_or_else(Vec::new, |l| l.curves))
}
