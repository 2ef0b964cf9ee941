//! Prescriptions read from smooth fields.

use crate::polar_field::bevel::{BeveledMesh, Cycle, Rotation, wrapped};
use crate::polar_field::curvature::principal_directions;
use crate::polar_field::domain::Domain;
use crate::polar_field::error::PolarFieldError;
use crate::polar_field::face_field::{FaceTarget, smoothest_face_field};
use crate::polar_field::guides::{Guide, directions_in_faces, paths};
use crate::polar_field::options::AutomaticOptions;
use crate::polar_field::singularity::{Place, Singularity};
use eikona_mesh::{FaceField, SurfacePoint};
use eikona_numeric::{Complex, NumericError, Resources, check_step, check_stopped};
use std::f64::consts::TAU;

/// Singularities and indices of generators: what a solve takes.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Prescription {
    /// The singularities, at vertices and boundary loops.
    pub singularities: Vec<Singularity>,
    /// The index of each homology generator.
    pub generators: Vec<f64>,
}

/// Weight of the faces on guides, relative to the smoothness.
const GUIDE_WEIGHT: f64 = 1e3;

/// Reads the indices of the smoothest field, or of the smoothest among those near the guides.
pub(super) fn prescription(
    domain: &Domain,
    options: &AutomaticOptions,
    resources: Resources,
) -> Result<Prescription, PolarFieldError> {
    let Domain { bevel, connection, .. } = domain;
    let degree = options.degree;
    let mut targets = Vec::new();
    if options.curvature {
        if !degree.is_multiple_of(2) {
            return Err(PolarFieldError::CurvatureWithOddDegree { degree });
        }
        targets = principal_directions(bevel, degree);
    }
    targets.extend(of_guides(bevel, &options.guides, degree)?);
    let field = smoothest_face_field(bevel, connection, degree, &targets, resources)?;
    Ok(indices(domain, &field, degree)?)
}

fn of_guides(bevel: &BeveledMesh, guides: &[Guide], degree: u32) -> Result<Vec<FaceTarget>, PolarFieldError> {
    let paths = paths(bevel, guides, degree)?;
    let target = |(face, value)| FaceTarget { face, value, weight: GUIDE_WEIGHT };
    Ok(directions_in_faces(&paths, degree).into_iter().map(target).collect())
}

/// Returns the indices of a field of one direction per face. The field turns by less than half a
/// turn of its power across each edge; the same jump counts at both ends of the edge, so that the
/// indices add up to the Euler characteristic exactly.
fn indices(domain: &Domain, field: &FaceField<Complex>, degree: u32) -> Result<Prescription, NumericError> {
    let Domain { bevel, homology, connection, curvature } = domain;
    let n = f64::from(degree);
    let mut jumps: Rotation = bevel.zero();
    for (step, (h, twin)) in bevel.edges().enumerate() {
        check_step(step)?;
        let [own, other] = [h, twin].map(|h| field[h.face()].arg());
        let jump = wrapped(own - other - n * connection.jump[h]);
        jumps.jump[h] = jump;
        jumps.jump[twin] = -jump;
    }
    check_stopped()?;
    let sums = bevel.sums(&jumps);
    check_stopped()?;
    let index = |sum: f64, curvature: f64| ((sum + n * curvature) / TAU).round() / n;
    let mut prescription = Prescription::default();
    for cycle in bevel.cycles() {
        let place = match cycle {
            Cycle::Vertex(v) => Place::Point(SurfacePoint::Vertex { vertex: v.0 }),
            Cycle::Boundary(b) => Place::Boundary(b as usize),
            Cycle::Face(_) | Cycle::Edge(_) => continue,
        };
        let index = index(sums[cycle], curvature[cycle]);
        if index != 0.0 {
            prescription.singularities.push(Singularity { place, index });
        }
    }
    prescription.generators = homology.generators.iter().map(|g| index(g.sum(&jumps), g.curvature)).collect();
    Ok(prescription)
}
