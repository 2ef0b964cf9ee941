//! A surface prepared for fields.

use crate::polar_field::bevel::{BeveledMesh, PerCycle, Rotation};
use crate::polar_field::homology::Homology;
use eikona_numeric::{NumericError, check_stopped};

/// What does not depend on the prescription.
#[derive(Debug)]
pub(crate) struct Domain {
    pub bevel: BeveledMesh,
    pub homology: Homology,
    pub connection: Rotation,
    pub curvature: PerCycle<f64>,
}

impl Domain {
    /// Computes generators, connection and curvature.
    pub fn new(bevel: BeveledMesh) -> Result<Domain, NumericError> {
        let homology = Homology::of(&bevel)?;
        check_stopped()?;
        let connection = bevel.connection()?;
        check_stopped()?;
        let curvature = bevel.curvature();
        Ok(Domain { bevel, homology, connection, curvature })
    }
}
