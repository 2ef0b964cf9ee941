//! Reports of the solver: timings, residuals, choices and warnings.

use crate::Warning;
use crate::phases::Phases;
use crate::signed_heat::automatic::ChosenLevelSets;
use crate::signed_heat::time::ChosenTime;

/// Timings, memory and warnings of building a solver.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Preparation {
    /// Phases of [`Solver::new`](super::Solver::new).
    pub phases: Phases,
    /// Size of both factors in bytes.
    pub factor_bytes: usize,
    /// Predicted bytes needed to build the factors; compared with the memory limit.
    pub needed_bytes: usize,
    /// Whether the real form was needed (nonmanifold edges, or no consistent orientation).
    pub real_frames: bool,
    /// Warnings about the mesh.
    pub warnings: Vec<Warning>,
}

/// Timings, residuals, choices and warnings of one solve.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Report {
    /// Report on building the solver.
    pub preparation: Preparation,
    /// Diffusion time, and the reason for it.
    pub time: ChosenTime,
    /// Phases of [`Solver::solve`](super::Solver::solve).
    pub phases: Phases,
    /// Number of diffusion solves needed to reach all faces.
    pub stages: usize,
    /// Largest relative residual of the diffusion solves.
    pub diffusion_residual: f64,
    /// Convergence of the normal constraints; `None` unless
    /// [`preserve_source_normals`](super::SolveOptions::preserve_source_normals) is set.
    pub normal_constraints: Option<NormalConstraints>,
    /// Relative residual of the fit.
    pub integration_residual: f64,
    /// Level sets, and the reason for them.
    pub level_sets: ChosenLevelSets,
    /// Largest constraint violation, in the unit of length.
    ///
    /// The violation is the deviation of the distance from its level at nodes of the curves,
    /// midpoints of segments inside edges and faces, and isolated points. It is zero up to rounding
    /// where values are constrained exactly. Elsewhere, and for
    /// [`LevelSets::Soft`](super::LevelSets::Soft) (whose level is zero), it is the deviation that
    /// the penalty admits. `None` for [`LevelSets::Free`](super::LevelSets::Free), which has no
    /// constraints.
    pub constraint_violation: Option<f64>,
    /// Mean distance along each curve of the source, in their order; for
    /// [`LevelSets::PerComponent`](super::LevelSets::PerComponent) this is the level of the curve.
    /// NaN for curves without length or distance.
    pub levels: Vec<f64>,
    /// Number of segments of all curves, without those of zero length.
    pub source_segments: usize,
    /// Number of isolated points.
    pub source_points: usize,
    /// Warnings about the solve; those of the preparation are separate.
    pub warnings: Vec<Warning>,
}

/// Convergence of the constraints that keep the diffused vectors normal to the curves, for
/// [`preserve_source_normals`](super::SolveOptions::preserve_source_normals).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NormalConstraints {
    /// Number of conjugate gradient iterations; each costs one back-substitution.
    pub iterations: usize,
    /// Remaining tangential part of the vectors at the curves, relative to their length (root sums
    /// of squares with one term per passage of a curve through a face or along an edge).
    pub residual: f64,
    /// Tolerance on `residual`; a larger residual raises a warning.
    pub tolerance: f64,
}

impl NormalConstraints {
    pub(crate) fn warning(&self) -> Option<Warning> {
        let &NormalConstraints { residual, tolerance, iterations } = self;
        // Written so that a NaN residual warns as well.
        let converged = residual <= tolerance;
        (!converged).then_some(Warning::TiltedNormals { residual, tolerance, iterations })
    }
}

impl Report {
    /// Iterates over all warnings: those of the solver, then those of the solve.
    pub fn all_warnings(&self) -> impl Iterator<Item = &Warning> {
        self.preparation.warnings.iter().chain(&self.warnings)
    }
}
