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
    /// Number of threads. Default: 1. The result is the same for any number.
    pub threads: usize,
}

impl Default for EnergyOptions {
    fn default() -> Self {
        EnergyOptions {
            exponents: Exponents::default(),
            pairs: Pairs::Hierarchical,
            separation: 0.2,
            threads: 1,
        }
    }
}

setters!(EnergyOptions {
    with_exponents: exponents = Exponents,
    with_pairs: pairs = Pairs,
    with_separation: separation = f64,
    with_threads: threads = usize
});
