//! The tangent-point energy of a mesh and its differential.

use crate::geometry::power_of_two_near;
use crate::repulsive::error::RepulsiveError;
use crate::repulsive::options::{EnergyOptions, Exponents};
use crate::repulsive::pair_sum::{PairSum, PairSumOptions};
use eikona_mesh::{ElementId, Face, FaceField, TriangleMesh, VertexField};

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
/// By default, far faces are summed cluster by cluster, see [`Pairs`](super::Pairs).
///
/// # Errors
/// [`RepulsiveError::NoFaces`], [`RepulsiveError::FlatFace`], [`RepulsiveError::Coincident`],
/// [`RepulsiveError::Range`], [`RepulsiveError::Separation`], with adaptive quadrature
/// [`RepulsiveError::Touching`] and [`RepulsiveError::NearContact`]; [`RepulsiveError::Numeric`] if
/// an observer stops it.
///
/// # Cost
/// O(F log F): about 5 s per million faces and thread with `p = 6`. With
/// [`Pairs::All`](super::Pairs::All), O(F^2): 7 ns per ordered pair and thread.
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
    let options = PairSumOptions {
        exponents,
        pairs: options.pairs,
        separation: options.separation,
        quadrature: options.quadrature,
        threads: options.threads,
    };
    let summed = PairSum::new(mesh, unit, &options)?;
    let summed = summed.at(mesh, true)?;
    let energy = TangentPointEnergy {
        value: summed.value()?,
        differential: summed.differential(),
        density: summed.densities().into(),
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
