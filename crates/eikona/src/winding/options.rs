//! What the user wants.

use eikona_mesh::Face;

/// Where jumps of the nonbounding part are imposed in the last solve (step 9).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Completion {
    /// Everywhere: the function jumps by the curve minus its completed nonbounding part, as the
    /// supplement has it.
    #[default]
    Full,
    /// At vertices of the curve only: off the curve the function stays continuous. What the public
    /// program does. (Such jumps end in the middle of the surface, and are no form: the last solve
    /// is on the faces, also with [`intrinsic_delaunay`](WindingOptions::intrinsic_delaunay).)
    Curve,
}

/// The shape of what completes the curve, where it has gaps: boundaries of regions and nonbounding
/// loops off the curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CompletionShape {
    /// Locally shortest paths across faces, from open end to open end or between the places where
    /// pieces of the completion meet, and closed geodesics where it has no ends. Each is in the
    /// homotopy class of the path along edges, and does not cross the curve. The mesh is cut along
    /// them, and labels, values and the nonbounding jump are those of the straight completion.
    #[default]
    Straight,
    /// Paths along edges of the mesh, as the method finds them.
    Edges,
}

/// Where the level of the labels is fixed. The winding number is defined up to one constant a
/// connected component.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reference {
    /// The label that covers most of the area is 0, in each component.
    #[default]
    LargestArea,
    /// The label of this face is 0 in its component; in others the one that covers most.
    Face(Face),
}

/// Whether stretches of the curve that look reversed are looked for: those that, turned over, would
/// leave a smoother function (on the faces, whatever the triangles of the solve).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Diagnosis {
    /// If the curve has at most [`MOST_STRETCHES`](super::MOST_STRETCHES) stretches.
    #[default]
    Automatic,
    /// Always, up to 2000 stretches; time and memory grow with their number, squared.
    Always,
    /// Never.
    Never,
}

/// Values of [`WindingOptions::epsilon`] that are accepted.
pub const EPSILONS: std::ops::RangeInclusive<f64> = 1e-9..=1.0;

/// Choices of a solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WindingOptions {
    /// Where the nonbounding part is taken off.
    pub completion: Completion,
    /// The shape of the completion.
    pub completion_shape: CompletionShape,
    /// Cost of a nonbounding loop along the curve, as a share of its cost elsewhere (eq. 11), from
    /// 1e-9 to 1. Larger than zero, since ties would decide otherwise.
    pub epsilon: f64,
    /// Where labels are zero.
    pub reference: Reference,
    /// Bisect open pieces of the curve that have fewer than 8 edges, and the faces there with them.
    /// Edges between two endpoints are in no operator, so that a short piece would have little
    /// effect or none.
    pub split_short: bool,
    /// Solve on intrinsic Delaunay triangles instead of the faces: better where these are badly
    /// shaped. The result is on the faces all the same.
    pub intrinsic_delaunay: bool,
    /// Whether the curve's orientation is looked at.
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
