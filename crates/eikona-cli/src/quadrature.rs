//! How the energy of two faces is integrated, as an argument.

use eikona::repulsive::Quadrature;

/// The value of `--quadrature`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum QuadratureKind {
    /// Faces are subdivided where they are close to each other.
    Adaptive,
    /// The midpoint rule.
    Midpoint,
}

impl From<QuadratureKind> for Quadrature {
    fn from(kind: QuadratureKind) -> Quadrature {
        match kind {
            QuadratureKind::Adaptive => Quadrature::adaptive(),
            QuadratureKind::Midpoint => Quadrature::Midpoint,
        }
    }
}
