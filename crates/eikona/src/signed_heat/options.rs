//! What the user wants.

use eikona_mesh::{Curve, CurveKind, SurfaceCurves};

/// How long normals diffuse: `t` in `(M + t L) X = X_0` (SHM eq. 12).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DiffusionTime {
    /// `t = coefficient * h^2` with `h` half the mean edge length. 1 is the paper's choice (section 6). Larger values smooth
    /// corners and noise and follow rounder completions; smaller ones follow the nearest normal.
    Coefficient(f64),
    /// Chosen from mesh and source; the report says what was chosen and why. For a source in which a signed curve is open, that of
    /// [`AutomaticForGaps`](DiffusionTime::AutomaticForGaps). Else so that the error of smooth curves falls with refinement:
    /// `t = 0.1 h sqrt(A)` for surface area `A`, but at least `h^2`.
    ///
    /// The rule is the same in [`signed_distance`](super::signed_distance) and in a [`Solver`](super::Solver), which knows no
    /// source when it is built: it factors the diffusion for gaps when the first open curve comes. (A solver with one time for
    /// all would be off by twice the error on broken curves, or would stop converging on closed ones.) If all sources are
    /// known to have gaps, [`for_source`](DiffusionTime::for_source) saves it the other factor.
    ///
    /// Deviation: with the paper's `t = h^2` the decay of a discrete vector depends on its direction through the mesh by a
    /// share that does not fall with `h`, so that the error on a sphere stalls near 1e-4 (test `convergence_on_the_sphere`).
    /// Making `t / h^2` grow as `1 / h` makes that share fall as `h`.
    Automatic,
    /// Chosen for curves with gaps: coefficient 3. Over strongly broken curves the error was smallest between 1 and 10, and
    /// twice as large at 100: where normals must be carried across gaps, longer diffusion mixes in those from farther away.
    AutomaticForGaps,
}

impl DiffusionTime {
    /// The time to use for a source that is known: [`Automatic`](DiffusionTime::Automatic) becomes
    /// [`AutomaticForGaps`](DiffusionTime::AutomaticForGaps) if a signed curve is open; everything else stays as it is.
    pub fn for_source(self, source: &SurfaceCurves) -> DiffusionTime {
        let open = |c: &Curve| c.kind == CurveKind::Signed && !c.is_closed();
        match self {
            DiffusionTime::Automatic if source.curves.iter().any(open) => DiffusionTime::AutomaticForGaps,
            other => other,
        }
    }
}

/// Which level sets of the distance the curves are held to be (SHM section 7.1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelSets {
    /// Nothing is imposed: the fit is free, then shifted so that the curves have mean zero. Right for noisy curves.
    Free,
    /// The distance is zero along every curve and at every point: exactly at vertices and isolated points, and to the square of
    /// the edge length where curves cross edges and faces.
    Zero,
    /// The distance is constant along each connected piece of the curves, at a value that comes out of the fit.
    PerComponent,
    /// The integral of the square of the distance along the curves is weighed against the fit of the gradient. The weight has no unit and
    /// does not depend on resolution: it is divided by the square root of the area of the surface's component. 100 holds a
    /// curve tightly. A point counts as a curve of a hundredth of that root.
    Soft(f64),
}

/// The weights that [`LevelSets::Soft`] allows. Outside, the weight drowns in rounding, or everything else does.
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

/// What a solver is built with: fixed as long as it is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverOptions {
    /// Diffusion time. Default: the paper's, coefficient 1.
    pub time: DiffusionTime,
    /// How many threads may factor the two systems: 1 (default) or 2. The digits are the same for any number.
    pub threads: usize,
    /// Refuse to factor when the factors are predicted to take more bytes than this. Default: no limit.
    pub memory_limit: Option<usize>,
}

impl Default for SolverOptions {
    fn default() -> Self {
        SolverOptions { time: DiffusionTime::Coefficient(1.0), threads: 1, memory_limit: None }
    }
}

/// What may change from one solve to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveOptions {
    /// Default [`LevelSets::Zero`], as in the paper's figures.
    pub level_sets: LevelSets,
    /// Keep the diffused vectors normal to the curves, on the mean of each passage through a face or along an edge, so that
    /// corners of a curve are not rounded (default false). Costs a handful of back-substitutions:
    /// [`Report::kept_normals`](super::Report::kept_normals) counts them.
    pub preserve_source_normals: bool,
    /// Default [`SignConvention::LeftNegative`].
    pub sign: SignConvention,
    /// Also compute how far each value rests on extrapolation (default false).
    pub confidence: bool,
}

impl Default for SolveOptions {
    fn default() -> Self {
        SolveOptions {
            level_sets: LevelSets::Zero,
            preserve_source_normals: false,
            sign: SignConvention::default(),
            confidence: false,
        }
    }
}
