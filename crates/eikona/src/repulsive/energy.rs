//! The tangent-point energy of a mesh and its differential.

use crate::geometry::power_of_two_near;
use crate::repulsive::all_pairs::{Row, all_pairs};
use crate::repulsive::error::RepulsiveError;
use crate::repulsive::faces::{FaceDatum, FaceForce, face_data, pulled_back};
use crate::repulsive::hierarchical::{Interactions, hierarchical};
use crate::repulsive::options::{EnergyOptions, Exponents, Pairs};
use eikona_mesh::{ElementId, Face, FaceField, TriangleMesh, VertexField};
use eikona_numeric::check_step;

/// The tangent-point energy of a mesh.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TangentPointEnergy {
    /// The energy.
    pub value: f64,
    /// The derivative by each vertex.
    pub differential: VertexField<[f64; 3]>,
    /// The energy per area of each face: times the areas, it adds up to the energy.
    pub density: FaceField<f64>,
}

impl TangentPointEnergy {
    /// Returns the Euclidean norm of the differential over all coordinates.
    pub fn gradient_norm(&self) -> f64 {
        // Squares overflow long before the norm does.
        let all = || self.differential.as_slice().iter().flatten();
        let largest = all().fold(0.0f64, |m, x| m.max(x.abs()));
        if largest == 0.0 { 0.0 } else { largest * all().map(|x| (x / largest).powi(2)).sum::<f64>().sqrt() }
    }
}

/// Computes the tangent-point energy of a mesh.
///
/// The energy is the sum over ordered pairs of different faces of
/// `|n_S . v|^alpha / |v|^beta a_S a_T`, where `v` joins the centroids. It depends neither on
/// orientation nor on position, and grows with the power `4 + alpha - beta` of the scale. Faces of
/// any topology are accepted.
///
/// By default, far faces are summed cluster by cluster, see [`Pairs`].
///
/// # Errors
/// [`RepulsiveError::NoFaces`], [`RepulsiveError::FlatFace`], [`RepulsiveError::Coincident`],
/// [`RepulsiveError::Range`], [`RepulsiveError::Separation`]; [`RepulsiveError::Numeric`] if an
/// observer stops it.
///
/// # Cost
/// O(F log F): about 5 s per million faces and thread with `p = 6`. With [`Pairs::All`], O(F^2):
/// 7 ns per ordered pair and thread.
///
/// # Reference
/// Yu, Brakensiek, Schumacher and Crane, *Repulsive Surfaces*, 2021, equation 3.
///
/// ```
/// use eikona::mesh::shapes;
/// use eikona::repulsive::{EnergyOptions, Pairs, tangent_point_energy};
/// // On the unit sphere, every tangent sphere is the sphere itself: the limit is pi^2 / 4.
/// let sphere = shapes::icosphere(3)?;
/// let energy = tangent_point_energy(&sphere, &EnergyOptions::default())?;
/// assert!((energy.value - 2.504071120297146).abs() < 0.002);
/// let options = EnergyOptions::default().with_pairs(Pairs::All);
/// let all_pairs = tangent_point_energy(&sphere, &options)?;
/// assert!((all_pairs.value - 2.504071120297146).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn tangent_point_energy(
    mesh: &TriangleMesh,
    options: &EnergyOptions,
) -> Result<TangentPointEnergy, RepulsiveError> {
    if mesh.face_count() == 0 {
        return Err(RepulsiveError::NoFaces);
    }
    let Exponents { alpha, beta } = options.exponents;
    let exponents = Exponents::new(alpha, beta)?;
    let unit = unit_of_length(mesh);
    let faces = face_data(mesh, unit)?;
    let rows = match options.pairs {
        Pairs::All => all_pairs(&faces, exponents, options.threads)?,
        Pairs::Hierarchical => {
            check_separation(options.separation)?;
            let interactions = Interactions::new(&faces, options.separation)?;
            hierarchical(&interactions, &faces, exponents, true, options.threads)?
        }
    };
    let degree = exponents.degree();
    let scaled = |x: f64, power: f64| x * unit.powf(power);
    let value = scaled(sum(&faces, &rows)?, degree);
    let energy = TangentPointEnergy {
        value,
        differential: differential(mesh, unit, &faces, &rows, scaled(1.0, degree - 1.0)),
        density: rows.iter().map(|row| scaled(row.density, degree - 2.0)).collect::<Vec<_>>().into(),
    };
    let out_of_range = energy.density.as_slice().iter().position(|x| !x.is_finite());
    match out_of_range {
        Some(f) => Err(RepulsiveError::Range { face: Face::from_index(f) }),
        None => Ok(energy),
    }
}

/// Returns the unit of length in which energies are summed: high powers of lengths would leave the
/// range of numbers. A power of two changes no digits.
pub(super) fn unit_of_length(mesh: &TriangleMesh) -> f64 {
    power_of_two_near(mesh.positions().iter().flatten().fold(0.0f64, |m, x| m.max(x.abs())))
}

/// # Errors
/// [`RepulsiveError::Separation`].
pub(super) fn check_separation(separation: f64) -> Result<(), RepulsiveError> {
    let fine = separation > 0.0 && separation <= 1.0;
    if fine { Ok(()) } else { Err(RepulsiveError::Separation { separation }) }
}

/// Returns the energy in the unit of length.
///
/// # Errors
/// Those of [`check_finite`].
pub(super) fn sum(faces: &[FaceDatum], rows: &[Row]) -> Result<f64, RepulsiveError> {
    check_finite(faces, rows)?;
    Ok(faces.iter().zip(rows).map(|(face, row)| face.area * row.density).sum())
}

/// Returns the derivative by each vertex, times `factor`.
pub(super) fn differential(
    mesh: &TriangleMesh,
    unit: f64,
    faces: &[FaceDatum],
    rows: &[Row],
    factor: f64,
) -> VertexField<[f64; 3]> {
    let forces: Vec<FaceForce> = rows.iter().map(|row| row.force).collect();
    let differential = pulled_back(mesh, unit, faces, &forces).into_vec();
    differential.into_iter().map(|v| v.map(|x| factor * x)).collect::<Vec<_>>().into()
}

fn check_finite(faces: &[FaceDatum], rows: &[Row]) -> Result<(), RepulsiveError> {
    let Some(f) = rows.iter().position(|row| !(row.density.is_finite() && row.force.area.is_finite())) else {
        return Ok(());
    };
    for (g, other) in faces.iter().enumerate().filter(|(g, _)| *g != f) {
        check_step(g)?;
        if other.centroid == faces[f].centroid {
            return Err(RepulsiveError::Coincident { faces: [f, g].map(Face::from_index) });
        }
    }
    Err(RepulsiveError::Range { face: Face::from_index(f) })
}
