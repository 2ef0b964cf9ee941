//! A surface prepared for fields.

use crate::polar_field::bevel::{BeveledMesh, PerCycle, Rotation};
use crate::polar_field::homology::Homology;

/// What does not depend on the prescription.
#[derive(Debug)]
pub(crate) struct Domain {
    pub bevel: BeveledMesh,
    pub homology: Homology,
    pub connection: Rotation,
    pub curvature: PerCycle<f64>,
}
