//! Options of the signed heat method, with the paper's values named beside the defaults.

use crate::signed_heat::condition::{Condition, condition};
use eikona_mesh::{SurfaceCurves, TriangleMesh};

/// How long normals diffuse: `t` in `(M + t L) X = X_0` (SHM eq. 12).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DiffusionTime {
    /// `t = coefficient * h^2` with `h` half the mean edge length. 1 is the paper's choice (section
    /// 6). Larger values smooth corners and noise and follow rounder completions; smaller ones
    /// follow the nearest normal.
    Coefficient(f64),
    /// Chosen from the mesh and the source; the report says what was chosen and why.
    ///
    /// * Curves without gaps, or with short ones: coefficient 1, growing on fine meshes as `0.005
    ///   sqrt(A) / h` for surface area `A`.
    /// * Curves of which a fourth or more is missing:
    ///   [`AutomaticForGaps`](DiffusionTime::AutomaticForGaps).
    /// * The same, if they are rough:
    ///   [`AutomaticForRoughGaps`](DiffusionTime::AutomaticForRoughGaps).
    ///
    /// A [`Solver`](super::Solver) knows no source when it is built. It factors the diffusion for
    /// curves without gaps then, and for the others when the first such curve comes. If all sources
    /// are known to be alike, [`for_source`](DiffusionTime::for_source) saves it one factor.
    Automatic,
    /// For smooth closed curves on smooth surfaces: `t = 0.1 h sqrt(A)` for surface area `A`, but
    /// at least `h^2`, so that the error falls at least in proportion to `h`. Ridges of the
    /// distance are rounded more than by [`Automatic`](DiffusionTime::Automatic), which on curves
    /// in general has half the error.
    ///
    /// Deviation: with the paper's `t = h^2` the decay of a discrete vector depends on its
    /// direction through the mesh by a share that does not fall with `h`, so that the error on a
    /// sphere stalls near 1e-4 (test `paper_time_stalls_on_the_sphere`). Making `t / h^2` grow as
    /// `1 / h` makes that share fall as `h`.
    SmoothCurves,
    /// Coefficient 1.5, for curves with gaps (measured by `examples/broken_curves`; 1 and 3 are
    /// nearly as good).
    AutomaticForGaps,
    /// Coefficient 5, for curves with gaps whose normals are rough, such as walks along edges:
    /// their pieces point the wrong way at their ends unless longer diffusion averages them.
    AutomaticForRoughGaps,
}

impl DiffusionTime {
    /// The time for a source that is known: replaces [`Automatic`](DiffusionTime::Automatic) by
    /// what it stands for with this source, and keeps everything else.
    pub fn for_source(self, mesh: &TriangleMesh, source: &SurfaceCurves) -> DiffusionTime {
        match self {
            DiffusionTime::Automatic => match condition(mesh, source) {
                Condition::Whole => self,
                Condition::Broken => DiffusionTime::AutomaticForGaps,
                Condition::BrokenAndRough => DiffusionTime::AutomaticForRoughGaps,
            },
            other => other,
        }
    }
}

/// Which level sets of the distance the curves are held to be (SHM section 7.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelSets {
    /// Chosen from the source, for each connected component of the mesh; the report says what was
    /// chosen and why.
    ///
    /// * Closed curves are held at [`Zero`](LevelSets::Zero), also where they cross each other.
    /// * Curves with gaps are held at zero by a firm weight, unless the fit shows that this would
    ///   press flat what lies between pieces beside each other: then by the weight at which the
    ///   curves change the slope next to them by 0.15, as a root mean square.
    /// * Where pieces lie at clearly different levels, each has its own:
    ///   [`PerComponent`](LevelSets::PerComponent).
    ///
    /// Deviation: the paper leaves the choice to the user. `examples/broken_curves` prints the
    /// errors of every choice.
    Automatic,
    /// Nothing is imposed: the fit is free, then shifted so that the curves have mean zero.
    Free,
    /// The distance is zero along every curve and at every point: exactly at vertices and isolated
    /// points, and to the square of the edge length where curves cross edges and faces.
    Zero,
    /// The distance is constant along each connected piece of the curves, at a value that comes out
    /// of the fit. Curves that cross are one piece.
    PerComponent,
    /// The integral of the square of the distance along the curves is weighed against the fit of
    /// the gradient. The weight has no unit and does not depend on resolution: it is divided by the
    /// square root of the area of the surface's component. 100 holds a curve tightly. A point
    /// counts as a curve of a hundredth of that root.
    Soft(f64),
}

/// The weights that [`LevelSets::Soft`] allows. Outside, the weight drowns in rounding, or
/// everything else does.
pub const SOFT_WEIGHTS: std::ops::RangeInclusive<f64> = 1e-9..=1e12;

/// On which side of an oriented curve the distance is negative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SignConvention {
    /// Negative on the left, so that a counter-clockwise loop has a negative inside.
    #[default]
    LeftNegative,
    /// Positive on the left, as geometry-central and potpourri3d have it.
    LeftPositive,
}

/// Options of a [`Solver`](super::Solver), fixed as long as it is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverOptions {
    /// Diffusion time. Default: [`DiffusionTime::Automatic`]; the paper's is coefficient 1.
    pub time: DiffusionTime,
    /// Number of threads for factorisations. Default: 1. The digits are the same for any number.
    pub threads: usize,
    /// Refuse to factor when the factors are predicted to take more bytes than this. Default: no
    /// limit.
    pub memory_limit: Option<usize>,
}

impl Default for SolverOptions {
    fn default() -> Self {
        SolverOptions { time: DiffusionTime::Automatic, threads: 1, memory_limit: None }
    }
}

/// Options of one solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveOptions {
    /// Default [`LevelSets::Automatic`]; the paper's figures have [`LevelSets::Zero`].
    pub level_sets: LevelSets,
    /// Keep the diffused vectors normal to the curves, on the mean of each passage through a face
    /// or along an edge, so that corners of a curve are not rounded (default false). Costs a
    /// handful of back-substitutions: [`Report::kept_normals`](super::Report::kept_normals) counts
    /// them.
    pub preserve_source_normals: bool,
    /// Default [`SignConvention::LeftNegative`].
    pub sign: SignConvention,
    /// Also compute how far each value rests on extrapolation (default false).
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
