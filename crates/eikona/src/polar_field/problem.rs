//! A prescription, checked and turned into sums of the rotation.

use crate::polar_field::bevel::{BeveledMesh, Cycle, PerCycle, Rotation};
use crate::polar_field::domain::Domain;
use crate::polar_field::error::PolarFieldError;
use crate::polar_field::options::FieldOptions;
use crate::polar_field::particular::particular_rotation;
use crate::polar_field::singularity::{Prescribed, Singularity, located, turns_of_cycles, whole_turns};
use crate::polar_field::targets::needed_sum;
use eikona_mesh::Face;
use eikona_numeric::{NumericError, check_stopped};
use std::collections::HashMap;
use std::f64::consts::TAU;

/// What a rotation must add up to.
pub(crate) struct Problem<'a> {
    domain: &'a Domain,
    pub degree: u32,
    pub prescribed: Vec<Prescribed>,
    /// The index times N of each cycle.
    pub turns: PerCycle<i64>,
    /// The sum of the rotation around each cycle.
    pub around: PerCycle<f64>,
    /// The sum of the rotation along each generator.
    pub along: Vec<f64>,
}

impl<'a> Problem<'a> {
    /// Checks a prescription: degree, places, whole turns, and their sum on each component.
    pub fn new(
        domain: &'a Domain,
        singularities: &[Singularity],
        options: &FieldOptions,
    ) -> Result<Problem<'a>, PolarFieldError> {
        let Domain { bevel, homology, curvature, .. } = domain;
        let degree = options.degree;
        check_degree(degree)?;
        let (found, expected) = (options.generators.len(), homology.generators.len());
        if found != 0 && found != expected {
            return Err(PolarFieldError::Generators { found, expected });
        }
        if let Some(weight) = options.guide_weight.filter(|weight| !(*weight > 0.0 && weight.is_finite())) {
            return Err(PolarFieldError::GuideWeight { weight });
        }
        let prescribed = located(bevel, singularities, degree)?;
        check_faces(bevel, &prescribed)?;
        let turns = turns_of_cycles(bevel, &prescribed, degree)?;
        let mut around = bevel.constant(0.0);
        check_stopped()?;
        for cycle in bevel.cycles() {
            around[cycle] = needed_sum(turns[cycle], degree, curvature[cycle]);
        }
        let mut along = Vec::with_capacity(expected);
        for (i, generator) in homology.generators.iter().enumerate() {
            let index = options.generators.get(i).copied().unwrap_or(0.0);
            let turns = whole_turns(index, degree, || format!("generator {i}"))?;
            along.push(TAU * turns as f64 - f64::from(degree) * generator.curvature);
        }
        Ok(Problem { domain, degree, prescribed, turns, around, along })
    }

    /// Returns a rotation with these sums.
    pub fn particular(&self) -> Result<Rotation, NumericError> {
        let Domain { bevel, homology, .. } = self.domain;
        particular_rotation(bevel, homology, &self.around, &self.along)
    }

    /// Adds to a rotation what is missing from the sums, and returns the largest of what is missing
    /// then: rounding adds up along the trees, but that of a small correction is small.
    pub fn correct(&self, theta: &mut Rotation) -> Result<f64, NumericError> {
        let Domain { bevel, homology, .. } = self.domain;
        let ((around, along), _) = self.missing(theta)?;
        theta.add(1.0, &particular_rotation(bevel, homology, &around, &along)?);
        check_stopped()?;
        Ok(self.missing(theta)?.1)
    }

    /// Returns the largest of what is missing from the sums.
    pub fn residual(&self, theta: &Rotation) -> Result<f64, NumericError> {
        Ok(self.missing(theta)?.1)
    }

    /// Returns what is missing from the sums around cycles and along generators, and the largest of
    /// it.
    fn missing(&self, theta: &Rotation) -> Result<((PerCycle<f64>, Vec<f64>), f64), NumericError> {
        let Domain { bevel, homology, .. } = self.domain;
        let mut around = bevel.sums(theta);
        check_stopped()?;
        let mut largest = 0.0f64;
        for cycle in bevel.cycles() {
            around[cycle] = self.around[cycle] - around[cycle];
            largest = largest.max(around[cycle].abs());
        }
        let of_generators = homology.generators.iter().zip(&self.along);
        let along: Vec<f64> = of_generators.map(|(g, wanted)| wanted - g.sum(theta)).collect();
        let largest = along.iter().fold(largest, |m, x| m.max(x.abs()));
        check_stopped()?;
        Ok(((around, along), largest))
    }
}

/// Refuses a singularity inside a face next to one on its own edge: the field of a face vanishes at
/// one point only.
fn check_faces(bevel: &BeveledMesh, prescribed: &[Prescribed]) -> Result<(), PolarFieldError> {
    let turning = || prescribed.iter().enumerate().filter(|(_, s)| s.turns != 0);
    let inside = |(i, s): (usize, &Prescribed)| match s.cycle {
        Cycle::Face(face) => Some((face, i)),
        _ => None,
    };
    let inside: HashMap<Face, usize> = turning().filter_map(inside).collect();
    for (on_edge, s) in turning() {
        let Cycle::Edge(e) = s.cycle else { continue };
        for face in bevel.mesh.edge_halfedges(e).iter().map(|h| h.face()) {
            if let Some(&inside) = inside.get(&face) {
                return Err(PolarFieldError::FaceAndEdge { face, inside, on_edge });
            }
        }
    }
    Ok(())
}

/// Largest accepted deviation of sums and phases, in radians per direction. Rounding reaches 1e-12
/// at a million faces, more on thin ones.
const CLOSED: f64 = 1e-8;

/// Refuses a field whose rotation misses the prescribed sums, or whose phases do not close: with
/// another rotation, it would have other indices.
pub(crate) fn check_closed(residual: f64, closure: f64, degree: u32) -> Result<(), PolarFieldError> {
    let most = CLOSED * f64::from(degree);
    if residual <= most && closure <= most {
        Ok(())
    } else {
        Err(PolarFieldError::NotClosed { residual, closure })
    }
}

/// Refuses degrees out of range.
pub(crate) fn check_degree(degree: u32) -> Result<(), PolarFieldError> {
    if (1..=1000).contains(&degree) { Ok(()) } else { Err(PolarFieldError::Degree { degree }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_that_do_not_close_are_refused() {
        assert!(check_closed(1e-9, 1e-9, 1).is_ok());
        for (residual, closure) in [(1e-7, 0.0), (0.0, 1e-7), (f64::NAN, 0.0), (f64::INFINITY, 0.0)] {
            let fault = check_closed(residual, closure, 1).unwrap_err();
            assert!(matches!(fault, PolarFieldError::NotClosed { .. }), "{fault}");
        }
    }
}
