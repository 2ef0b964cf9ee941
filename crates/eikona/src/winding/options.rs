//! Options of a solve.

use crate::setters::setters;
use eikona_mesh::Face;
use eikona_numeric::Resources;

/// Where the jumps of the nonbounding part are subtracted in the last solve (step 9).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Completion {
    /// Everywhere: the function jumps by the curve minus its completed nonbounding part, as in the
    /// supplement.
    #[default]
    Full,
    /// At vertices of the curve only: off the curve the function stays continuous, as in the public
    /// program. (Such jumps end inside the surface, so their derivative is no 1-form: the last
    /// solve uses the faces, also with [`intrinsic_delaunay`](WindingOptions::intrinsic_delaunay).)
    Curve,
}

/// Shape of the completion in gaps of the curve: boundaries of regions and nonbounding loops off
/// the curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CompletionShape {
    /// Locally shortest paths across faces, from open end to open end or between junctions of
    /// completion pieces; closed geodesics where a piece has no ends. Each is in the homotopy class
    /// of the edge path and does not cross the curve. The mesh is cut along them, and labels,
    /// values and the nonbounding jump are those of the straight completion.
    #[default]
    Straight,
    /// Paths along edges of the mesh, as the linear program and the labels yield them.
    Edges,
}

/// Where the labels are zero. The winding number is defined up to one constant per connected
/// component.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reference {
    /// In each component, the label that covers the largest area is 0.
    #[default]
    LargestArea,
    /// The label of this face is 0; in other components, the label that covers the largest area.
    Face(Face),
}

/// Whether to look for stretches of the curve that seem reversed: reversing them would leave a
/// smoother function (measured on the faces, whatever the triangulation of the solve).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Diagnosis {
    /// If the curve has at most
    /// [`AUTOMATIC_DIAGNOSIS_LIMIT`](super::AUTOMATIC_DIAGNOSIS_LIMIT) stretches.
    #[default]
    Automatic,
    /// Always, up to 2000 stretches; time and memory grow quadratically with their number.
    Always,
    /// Never.
    Never,
}

/// Accepted values of [`WindingOptions::epsilon`].
pub const EPSILON_RANGE: std::ops::RangeInclusive<f64> = 1e-9..=1.0;

/// Options of a [`Solver`](super::Solver), fixed when it is built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct SolverOptions {
    /// Number of threads for factorisations. Default: 1. The result is the same for any number.
    pub threads: usize,
    /// Memory limit in bytes for each factorisation: a solve fails if one is predicted to exceed
    /// it. A solver keeps up to three factors. Default: no limit.
    pub memory_limit: Option<usize>,
}

impl Default for SolverOptions {
    fn default() -> Self {
        SolverOptions { threads: 1, memory_limit: None }
    }
}

setters!(SolverOptions { with_threads: threads = usize, with_memory_limit: memory_limit = Option<usize> });

impl SolverOptions {
    pub(super) fn resources(&self) -> Resources {
        Resources { threads: self.threads, memory_limit: self.memory_limit }
    }
}

/// Options of a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct WindingOptions {
    /// Where the nonbounding part is subtracted.
    pub completion: Completion,
    /// The shape of the completion.
    pub completion_shape: CompletionShape,
    /// Cost of a nonbounding loop along the curve relative to its cost elsewhere (eq. 11), from
    /// 1e-9 to 1. Zero is excluded because it leaves ties.
    pub epsilon: f64,
    /// Where the labels are zero.
    pub reference: Reference,
    /// Bisects open pieces of the curve that have fewer than 8 edges, and the faces there with
    /// them. Edges between two endpoints are in no operator, so that a short piece would have
    /// little or no effect.
    pub split_short: bool,
    /// Solves on intrinsic Delaunay triangles instead of the faces: better for badly shaped faces.
    /// The result is on the faces either way.
    pub intrinsic_delaunay: bool,
    /// Whether to check the curve's orientation.
    pub diagnosis: Diagnosis,
}

impl Default for WindingOptions {
    fn default() -> Self {
        WindingOptions {
            completion: Completion::Full,
            completion_shape: CompletionShape::Straight,
            epsilon: 1e-2,
            reference: Reference::LargestArea,
            split_short: true,
            intrinsic_delaunay: false,
            diagnosis: Diagnosis::Automatic,
        }
    }
}

setters!(WindingOptions {
    with_completion: completion = Completion,
    with_completion_shape: completion_shape = CompletionShape,
    with_epsilon: epsilon = f64,
    with_reference: reference = Reference,
    with_split_short: split_short = bool,
    with_intrinsic_delaunay: intrinsic_delaunay = bool,
    with_diagnosis: diagnosis = Diagnosis,
});
