//! Total area and volume, and how far they are from a value (RS section 7.3.1).

use super::surface::{Vec3, face_shapes};
use crate::geometry::vector::scale;
use crate::repulsive::error::RepulsiveError;
use crate::repulsive::quantity::{Quantity, check_oriented};
use eikona_mesh::TriangleMesh;

/// A volume below this share of `area^(3/2)` is zero up to rounding.
const NO_VOLUME: f64 = 1e-9;

/// # Errors
/// [`RepulsiveError::FlatFace`] for areas, whose derivative needs normals, and
/// [`RepulsiveError::Inconsistent`] for volumes.
pub(super) fn check(quantity: Quantity, mesh: &TriangleMesh) -> Result<(), RepulsiveError> {
    match quantity {
        Quantity::Area => face_shapes(mesh).map(|_| ()),
        Quantity::Volume => check_oriented(mesh),
    }
}

/// Returns a total.
pub(super) fn total(quantity: Quantity, mesh: &TriangleMesh) -> Result<f64, RepulsiveError> {
    check(quantity, mesh).map(|()| quantity.of(mesh))
}

/// Returns the derivative of a total by each vertex.
pub(super) fn differential(quantity: Quantity, mesh: &TriangleMesh) -> Result<Vec<Vec3>, RepulsiveError> {
    check(quantity, mesh).map(|()| quantity.differential(mesh))
}

/// Returns the size by which deviations of a volume are divided: the volume itself, or
/// `area^(3/2)` if it is zero up to rounding.
pub(super) fn volume_scale(volume: f64, area: f64) -> f64 {
    let size = area.powf(1.5);
    if volume.abs() > NO_VOLUME * size { volume.abs() } else { size }
}

/// How far a total is from a value, as a share of a scale, squared.
#[derive(Clone, Copy, Debug)]
pub(super) struct Deviation {
    pub from: f64,
    pub scale: f64,
}

impl Deviation {
    /// # Errors
    /// [`RepulsiveError::Target`] unless the value is finite and the scale positive.
    pub fn check(&self, what: &'static str) -> Result<(), RepulsiveError> {
        for (value, fine) in [(self.from, true), (self.scale, self.scale > 0.0)] {
            if !(fine && value.is_finite()) {
                return Err(RepulsiveError::Target { what, value });
            }
        }
        Ok(())
    }

    pub fn value(&self, total: f64) -> f64 {
        ((total - self.from) / self.scale).powi(2)
    }

    /// Returns the derivative, from that of the total.
    pub fn differential(&self, total: f64, of_total: Vec<Vec3>) -> Vec<Vec3> {
        let slope = 2.0 * (total - self.from) / self.scale / self.scale;
        of_total.into_iter().map(|v| scale(v, slope)).collect()
    }
}
