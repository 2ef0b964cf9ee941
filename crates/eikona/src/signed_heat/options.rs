//! Options of the signed heat method: defaults, and the values used in the paper.

use crate::setters::setters;
use crate::signed_heat::condition::{Condition, condition};
use eikona_mesh::{SurfaceCurves, TriangleMesh};

/// Diffusion time: `t` in `(M + t L) X = X_0` (SHM eq. 12).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DiffusionTime {
    /// `t = coefficient * h^2`, with `h` half the mean edge length. The paper uses 1 (section 6).
    /// Larger values smooth corners and noise and give rounder completions; smaller values follow
    /// the nearest normal.
    Coefficient(f64),
    /// Chosen from the mesh and the source; the report gives the choice and its reason.
    ///
    /// * Curves without gaps, or with short ones: coefficient 1, growing on fine meshes as `0.005
    ///   sqrt(A) / h` for surface area `A`.
    /// * Curves with a quarter or more missing:
    ///   [`ForGaps`](DiffusionTime::ForGaps).
    /// * Rough curves with a quarter or more missing:
    ///   [`ForRoughGaps`](DiffusionTime::ForRoughGaps).
    ///
    /// A [`Solver`](super::Solver) is built before any source is known. It first factors the
    /// diffusion operator for curves without gaps, and for each of the other two cases when the
    /// first such source is solved. If all sources are of one kind,
    /// [`for_source`](DiffusionTime::for_source) saves one factorisation.
    Automatic,
    /// For smooth closed curves on smooth surfaces: `t = 0.1 h sqrt(A)` for surface area `A`, but
    /// at least `h^2`, so that the error falls at least in proportion to `h`. It rounds ridges of
    /// the distance more than [`Automatic`](DiffusionTime::Automatic), which has half the error on
    /// general curves.
    ///
    /// Deviation: with the paper's `t = h^2`, the decay of a discrete vector depends on its
    /// direction through the mesh by a share that does not fall with `h`, so that the error on a
    /// sphere stalls near 1e-4 (test `paper_time_stalls_on_the_sphere`). If `t / h^2` grows as `1 /
    /// h`, that share falls as `h`.
    SmoothCurves,
    /// Coefficient 1.5, for curves with gaps (measured by `examples/broken_curves`; 1 and 3 are
    /// nearly as good).
    ForGaps,
    /// Coefficient 5, for curves with gaps and rough normals, such as walks along edges: near the
    /// ends of pieces their normals point the wrong way unless longer diffusion averages them.
    ForRoughGaps,
}

impl DiffusionTime {
    /// Replaces [`Automatic`](DiffusionTime::Automatic) by its choice for this source; returns
    /// every other value unchanged.
    pub fn for_source(self, mesh: &TriangleMesh, source: &SurfaceCurves) -> DiffusionTime {
        match self {
            DiffusionTime::Automatic => match condition(mesh, source) {
                Condition::Whole => self,
                Condition::Broken => DiffusionTime::ForGaps,
                Condition::BrokenAndRough => DiffusionTime::ForRoughGaps,
            },
            other => other,
        }
    }
}

/// Level set constraints: on which level sets of the distance the curves lie (SHM section 7.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelSets {
    /// Chosen from the source for each connected component of the mesh; the report gives the choice
    /// and its reason.
    ///
    /// * Closed curves are constrained to [`Zero`](LevelSets::Zero), also where they cross each
    ///   other.
    /// * Curves with gaps are drawn to zero by a stiff penalty, unless the fit shows that this
    ///   would flatten the distance between adjacent pieces. In that case the weight is the one at
    ///   which the curves change the slope next to them by 0.15 (root mean square).
    /// * Where pieces lie at clearly different levels, each has its own:
    ///   [`PerComponent`](LevelSets::PerComponent).
    ///
    /// Deviation: the paper leaves the choice to the user. `examples/broken_curves` prints the
    /// errors of every choice.
    Automatic,
    /// No constraints: the fit is free, then shifted so that the curves have mean zero.
    Free,
    /// The distance is zero along every curve and at every point: exactly at vertices and isolated
    /// points, and up to the square of the edge length where curves cross edges and faces.
    Zero,
    /// The distance is constant along each connected piece of the curves, at a level determined by
    /// the fit. Curves that cross form one piece.
    PerComponent,
    /// A penalty on the integral of the squared distance along the curves. The weight is
    /// dimensionless and independent of the resolution: it is divided by the square root of the
    /// area of the surface's component. A weight of 100 holds a curve tightly. A point counts as a
    /// curve of length one hundredth of that root.
    Soft(f64),
}

/// Weights that [`LevelSets::Soft`] allows. Below this range the penalty is lost to rounding; above
/// it, everything else is.
pub const SOFT_WEIGHT_RANGE: std::ops::RangeInclusive<f64> = 1e-9..=1e12;

/// Side of an oriented curve on which the distance is negative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SignConvention {
    /// Negative on the left: the inside of a counter-clockwise loop is negative.
    #[default]
    LeftNegative,
    /// Positive on the left, as in geometry-central and potpourri3d.
    LeftPositive,
}

/// Options of a [`Solver`](super::Solver), fixed when it is built.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SolverOptions {
    /// Diffusion time. Default: [`DiffusionTime::Automatic`]; the paper uses coefficient 1.
    pub time: DiffusionTime,
    /// Number of threads for factorisations. Default: 1. The result is the same for any number.
    pub threads: usize,
    /// Memory limit in bytes for the factors; building the solver, or a solve, fails if they are
    /// predicted to exceed it. Default: no limit.
    pub memory_limit: Option<usize>,
}

impl Default for SolverOptions {
    fn default() -> Self {
        SolverOptions { time: DiffusionTime::Automatic, threads: 1, memory_limit: None }
    }
}

setters!(SolverOptions {
    with_time: time = DiffusionTime,
    with_threads: threads = usize,
    with_memory_limit: memory_limit = Option<usize>,
});

/// Options of one solve.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SolveOptions {
    /// Level set constraints. Default: [`LevelSets::Automatic`]; the paper's figures use
    /// [`LevelSets::Zero`].
    pub level_sets: LevelSets,
    /// Whether to keep the diffused vectors normal to the curves, on average over each passage
    /// through a face or along an edge, so that corners of a curve are not rounded. Default: false.
    /// Costs a handful of back-substitutions, counted by
    /// [`Report::normal_constraints`](super::Report::normal_constraints).
    pub preserve_source_normals: bool,
    /// Sign of the distance. Default: [`SignConvention::LeftNegative`].
    pub sign: SignConvention,
    /// Whether to compute [`Confidence`](super::Confidence). Default: false.
    pub confidence: bool,
}

impl Default for SolveOptions {
    fn default() -> Self {
        SolveOptions {
            level_sets: LevelSets::Automatic,
            preserve_source_normals: false,
            sign: SignConvention::default(),
            confidence: false,
        }
    }
}

setters!(SolveOptions {
    with_level_sets: level_sets = LevelSets,
    with_preserve_source_normals: preserve_source_normals = bool,
    with_sign: sign = SignConvention,
    with_confidence: confidence = bool,
});
