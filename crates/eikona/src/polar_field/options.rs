//! Options of a solver and of a solve.

use crate::polar_field::guides::Guide;
use crate::setters::setters;
use eikona_numeric::Resources;

/// The energy that the smoothest field minimises.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Smoothness {
    /// Squared gradients in faces plus 10 times squared jumps across edges.
    #[default]
    Split,
    /// The energy as printed in the paper: the square of the sum of the gradients in two faces and
    /// 50 times their jump, which may cancel. It has a minimum only with a regularizer.
    Printed {
        /// Factor of the squared rotation along each edge of the beveled mesh, which is added. With
        /// less than 0.01, fields are rough.
        regularizer: f64,
    },
}

/// Options of a [`Solver`](super::Solver), fixed when it is built.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SolverOptions {
    /// The energy. Default: [`Smoothness::Split`].
    pub smoothness: Smoothness,
    /// Number of threads for factorisations. Default: 1. The result is the same for any number.
    pub threads: usize,
    /// Memory limit in bytes for each factorisation. Default: no limit.
    pub memory_limit: Option<usize>,
}

impl Default for SolverOptions {
    fn default() -> Self {
        SolverOptions { smoothness: Smoothness::Split, threads: 1, memory_limit: None }
    }
}

setters!(SolverOptions {
    with_smoothness: smoothness = Smoothness,
    with_threads: threads = usize,
    with_memory_limit: memory_limit = Option<usize>,
});

impl SolverOptions {
    pub(super) fn resources(&self) -> Resources {
        Resources { threads: self.threads, memory_limit: self.memory_limit }
    }
}

/// Options of a solve.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FieldOptions {
    /// The number N of directions at each point: 1 for vectors, 2 for lines, 4 for crosses (the
    /// default).
    pub degree: u32,
    /// How often the field turns along each homology generator relative to its tangent: whole
    /// multiples of 1/N, one per generator, or empty (the default) for zero.
    pub generators: Vec<f64>,
    /// What the field follows: one of its directions is tangent to it. Default: nothing.
    pub guides: Vec<Guide>,
    /// Weight of the guides: that of the squared error of the phase, averaged over a length equal
    /// to the square root of the area, relative to the smoothness energy. It has the same effect at
    /// every resolution. Default: `None`, the field follows exactly.
    pub guide_weight: Option<f64>,
}

impl Default for FieldOptions {
    fn default() -> Self {
        FieldOptions { degree: 4, generators: Vec::new(), guides: Vec::new(), guide_weight: None }
    }
}

setters!(FieldOptions {
    with_degree: degree = u32,
    with_generators: generators = Vec<f64>,
    with_guides: guides = Vec<Guide>,
    with_guide_weight: guide_weight = Option<f64>,
});

/// Options of an automatic prescription.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct AutomaticOptions {
    /// The number N of directions at each point. Default: 4.
    pub degree: u32,
    /// What the field should follow. Default: nothing.
    pub guides: Vec<Guide>,
    /// Whether it should follow the principal curvatures where they differ. Needs an even N.
    /// Default: no.
    pub curvature: bool,
}

impl Default for AutomaticOptions {
    fn default() -> Self {
        AutomaticOptions { degree: 4, guides: Vec::new(), curvature: false }
    }
}

setters!(AutomaticOptions { with_degree: degree = u32, with_guides: guides = Vec<Guide>, with_curvature: curvature = bool });
