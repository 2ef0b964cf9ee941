//! What the solver did, measured.

use crate::phases::Phases;
use crate::signed_heat::automatic::ChosenLevelSets;
use crate::signed_heat::time::ChosenTime;

/// What building the solver took and noticed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Preparation {
    /// Phases of [`Solver::new`](super::Solver::new).
    pub phases: Phases,
    /// Bytes of both factors.
    pub factor_bytes: usize,
    /// Bytes that building them was predicted to take: what a memory limit is compared with.
    pub needed_bytes: usize,
    /// Whether the real form was needed (nonmanifold edges, or no consistent orientation).
    pub real_form: bool,
    /// Sentences for the user.
    pub warnings: Vec<String>,
}

/// What one solve took and noticed.
#[derive(Clone, Debug)]
pub struct Report {
    /// Of the solver.
    pub preparation: Preparation,
    /// The diffusion time and why.
    pub time: ChosenTime,
    /// Phases of [`Solver::solve`](super::Solver::solve).
    pub phases: Phases,
    /// How many solves the diffusion took to reach all faces.
    pub stages: usize,
    /// Largest relative residual of the diffusion solves.
    pub diffusion_residual: f64,
    /// How the normals of the source were kept, if asked for.
    pub kept_normals: Option<KeptNormals>,
    /// Relative residual of the fit.
    pub integration_residual: f64,
    /// The level sets and why.
    pub level_sets: ChosenLevelSets,
    /// Largest deviation of the distance from its level at nodes of the curves, middles of segments
    /// inside edges and faces, and points, in the unit of length: zero to rounding where values are
    /// held exactly; elsewhere, and for [`LevelSets::Soft`](super::LevelSets::Soft) (whose level is
    /// zero), what the weight leaves. `None` for [`LevelSets::Free`](super::LevelSets::Free), which
    /// asks for nothing.
    pub constraint_violation: Option<f64>,
    /// The mean distance along each curve of the source, in their order: its level, for
    /// [`LevelSets::PerComponent`](super::LevelSets::PerComponent). NaN for curves without length
    /// or distance.
    pub levels: Vec<f64>,
    /// Segments of all curves, zero-length ones left out.
    pub source_segments: usize,
    /// Isolated points.
    pub source_points: usize,
    /// Sentences for the user, besides those of the preparation.
    pub warnings: Vec<String>,
}

/// How well the diffused vectors stay normal to the curves, for
/// [`preserve_source_normals`](super::SolveOptions::preserve_source_normals).
#[derive(Clone, Debug, PartialEq)]
pub struct KeptNormals {
    /// Conjugate gradient iterations, of one back-substitution each.
    pub iterations: usize,
    /// What is left of the parts along the curves, as a share of the length of the vectors there
    /// (roots of the sums of squares, one a passage through a face or along an edge).
    pub residual: f64,
    /// The share at which they count as gone; above it there is a warning.
    pub tolerance: f64,
}

impl KeptNormals {
    pub(crate) fn warning(&self) -> Option<String> {
        // Also for a residual that is not a number.
        let converged = self.residual <= self.tolerance;
        (!converged).then(|| {
            format!(
                "the normals of the source are kept to {:.1e} only, not {:.0e}, after {} iterations: \
                 look for curves that are much finer than the mesh, or do without preserve_source_normals",
                self.residual, self.tolerance, self.iterations
            )
        })
    }
}

impl Report {
    /// All warnings: of the solver, then of the solve.
    pub fn all_warnings(&self) -> impl Iterator<Item = &str> {
        self.preparation.warnings.iter().chain(&self.warnings).map(String::as_str)
    }
}
