//! Options of energies.

use crate::repulsive::error::RepulsiveError;
use crate::setters::setters;

/// The exponents of the tangent-point energy.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Exponents {
    /// The exponent of the distance from the tangent plane.
    pub alpha: f64,
    /// The exponent of the distance.
    pub beta: f64,
}

impl Exponents {
    /// Returns `alpha = p` and `beta = 2 p`. The kernel is then the diameter of the tangent sphere
    /// to the power `-p`.
    ///
    /// # Errors
    /// [`RepulsiveError::Exponents`] unless `p > 2`.
    pub fn of_power(p: f64) -> Result<Exponents, RepulsiveError> {
        Exponents::new(p, 2.0 * p)
    }

    /// Checks exponents.
    ///
    /// # Errors
    /// [`RepulsiveError::Exponents`] unless `alpha > 2` and `alpha + 2 < beta < 2 alpha + 2`.
    pub fn new(alpha: f64, beta: f64) -> Result<Exponents, RepulsiveError> {
        let fine = alpha > 2.0 && beta > alpha + 2.0 && beta < 2.0 * alpha + 2.0 && beta.is_finite();
        fine.then_some(Exponents { alpha, beta }).ok_or(RepulsiveError::Exponents { alpha, beta })
    }

    /// Returns the order `s = (beta - 2) / alpha` of the inner product: `2 - 2 / p`.
    pub fn order(&self) -> f64 {
        (self.beta - 2.0) / self.alpha
    }

    /// Returns the power of the scale with which the energy grows: `4 + alpha - beta`.
    pub fn degree(&self) -> f64 {
        4.0 + self.alpha - self.beta
    }
}

/// `p = 6`.
impl Default for Exponents {
    fn default() -> Self {
        Exponents { alpha: 6.0, beta: 12.0 }
    }
}

/// Which pairs of faces are summed one by one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pairs {
    /// Only near ones. Far faces are summed cluster by cluster, with second moments: the energy and
    /// its differential are within 0.5 % of the sum over all pairs.
    #[default]
    Hierarchical,
    /// All.
    All,
}

/// How the energy of two faces is integrated.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quadrature {
    /// By the midpoint rule: one term per ordered pair of faces, as in the paper.
    #[default]
    Midpoint,
    /// Splits faces in near contact in four, until the parts are small relative to their distance,
    /// and integrates over pairs of parts. The energy then grows without bound as faces come
    /// closer, instead of slipping between their centroids.
    ///
    /// Two faces are in near contact if they share no vertex, one has a radius of more than
    /// `separation` times their distance, and they do not lie side by side in about one plane,
    /// where the kernel is small. The radius is the largest distance of a corner from the centroid.
    /// Parts are split until it is at most `2 separation` times their distance, and integrated by a
    /// rule of degree two. All other pairs keep their one term. Faces that share a vertex are never
    /// subdivided, whatever their angle.
    ///
    /// The subdivision is decided for the surface as given; the differential is that of the sum
    /// over these parts.
    ///
    /// There are at most 2^20 pairs of parts, and 32 more per face, of 48 bytes each. Parts are no
    /// smaller than a millionth of a face. Where these bounds end the subdivision, the energy is
    /// finite, even for faces that touch or cross, unless points of the quadrature coincide
    /// ([`RepulsiveError::Touching`]). If there are more pairs of faces in near contact than that,
    /// the result is [`RepulsiveError::NearContact`].
    ///
    /// Deviation: the paper has the midpoint rule only.
    ///
    /// # Cost
    /// 2 us per face and thread to find near contact, and 1 us per pair of parts to subdivide.
    ///
    /// # Reference
    /// Sassen, Schumacher, Rumpf and Crane, *Repulsive Shells*, 2024.
    ///
    /// ```
    /// use eikona::mesh::TriangleMesh;
    /// use eikona::repulsive::{EnergyOptions, Quadrature, tangent_point_energy};
    /// // Two triangles whose tips nearly touch, which their centroids do not show.
    /// let tip = |z: f64| [[0.0, 0.0, 0.01 * z], [1.0, 0.0, z], [0.0, 1.0, z]];
    /// let points = [tip(1.0), tip(-1.0)].concat();
    /// let mesh = TriangleMesh::new(points, vec![[0, 1, 2], [3, 5, 4]])?;
    /// let energy = |quadrature| {
    ///     let options = EnergyOptions::default().with_quadrature(quadrature);
    ///     tangent_point_energy(&mesh, &options).map(|energy| energy.value)
    /// };
    /// assert!((energy(Quadrature::Midpoint)? - 0.00986).abs() < 1e-5);
    /// // The limit is 6.67.
    /// assert!((energy(Quadrature::adaptive())? - 6.565).abs() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    Adaptive {
        /// The bound of radius and distance, above 0 and up to 1. Smaller is slower and more
        /// accurate: the energy between two spheres at gaps from 0.01 to 0.1 of their radius is
        /// within 0.5 % of its limit with 0.35, and within 2 % with 0.5.
        separation: f64,
    },
}

impl Quadrature {
    /// Returns adaptive quadrature with separation 0.5.
    pub fn adaptive() -> Quadrature {
        Quadrature::Adaptive { separation: 0.5 }
    }

    /// # Errors
    /// [`RepulsiveError::Separation`].
    pub(crate) fn check(self) -> Result<(), RepulsiveError> {
        match self {
            Quadrature::Midpoint => Ok(()),
            Quadrature::Adaptive { separation } => check_separation(separation),
        }
    }
}

/// # Errors
/// [`RepulsiveError::Separation`].
pub(crate) fn check_separation(separation: f64) -> Result<(), RepulsiveError> {
    let fine = separation > 0.0 && separation <= 1.0;
    if fine { Ok(()) } else { Err(RepulsiveError::Separation { separation }) }
}

/// Options of [`tangent_point_energy`](super::tangent_point_energy).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct EnergyOptions {
    /// The exponents. Default: `p = 6`.
    pub exponents: Exponents,
    /// Which pairs of faces are summed one by one. Default: [`Pairs::Hierarchical`].
    pub pairs: Pairs,
    /// A cluster of faces counts as far if its radius is less than this share of its distance.
    /// Smaller is slower and more accurate. Default: 0.2.
    pub separation: f64,
    /// How the energy of two faces is integrated. Default: [`Quadrature::Midpoint`].
    pub quadrature: Quadrature,
    /// Number of threads. Default: 1. The result is the same for any number.
    pub threads: usize,
}

impl Default for EnergyOptions {
    fn default() -> Self {
        EnergyOptions {
            exponents: Exponents::default(),
            pairs: Pairs::Hierarchical,
            separation: 0.2,
            quadrature: Quadrature::Midpoint,
            threads: 1,
        }
    }
}

setters!(EnergyOptions {
    with_exponents: exponents = Exponents,
    with_pairs: pairs = Pairs,
    with_separation: separation = f64,
    with_quadrature: quadrature = Quadrature,
    with_threads: threads = usize
});
