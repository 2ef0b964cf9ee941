//! Warnings of all solvers, as data.

use crate::curves::SegmentId;
use eikona_mesh::{Face, SurfacePoint, Vertex, counted};
use serde::Serialize;
use std::fmt;

/// Something about the input or the result that the user should know. The result is defined
/// nevertheless.
///
/// [`Display`](fmt::Display) gives a sentence for the user; the fields name the elements. Elements
/// are those of the input mesh, even where the mesh was cut. Serialized, a warning is an object
/// with its [`kind`](Warning::kind) and its fields.
///
/// ```
/// use eikona::{Warning, mesh::Face};
/// let warning = Warning::DegenerateFaces { count: 4, first: Face(1203) };
/// assert_eq!(warning.kind(), "degenerate_faces");
/// assert!(warning.to_string().starts_with("4 degenerate faces (first: face 1203)"));
/// assert_eq!(
///     serde_json::to_string(&warning)?,
///     r#"{"kind":"degenerate_faces","count":4,"first":{"face":1203}}"#
/// );
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, strum::IntoStaticStr)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
#[non_exhaustive]
pub enum Warning {
    /// Faces were flipped to make the orientation consistent.
    FacesFlipped {
        /// Number of flipped faces.
        count: usize,
    },
    /// The surface has no consistent orientation.
    NotOrientable,
    /// Edges of three or more faces, where winding numbers treat the surface as cut open.
    NonmanifoldEdges {
        /// Number of these edges.
        count: usize,
        /// Vertices of the first one.
        first: [Vertex; 2],
    },
    /// Vertices that no face uses; the distance there is NaN.
    UnusedVertices {
        /// Number of these vertices.
        count: usize,
        /// The first one.
        first: Vertex,
    },
    /// Faces without area, whose edge lengths were perturbed.
    DegenerateFaces {
        /// Number of these faces.
        count: usize,
        /// The first one.
        first: Face,
    },

    /// Nodes of a polyline that coincided with their predecessors and were removed.
    MergedNodes {
        /// Their indices in the polyline.
        nodes: Vec<usize>,
    },
    /// Segments of a polyline that do not follow the surface; shortest paths replaced them.
    ReplacedSegments {
        /// Indices of their first nodes.
        nodes: Vec<usize>,
    },
    /// Segments of a polyline between points that several paths of nearly the same length connect.
    AmbiguousSegments {
        /// Indices of their first nodes.
        nodes: Vec<usize>,
        /// Largest relative difference of lengths that counts as the same.
        tolerance: f64,
    },
    /// Long segments of a polyline that were not compared with the shortest path.
    UncomparedSegments {
        /// Indices of their first nodes.
        nodes: Vec<usize>,
    },
    /// Segments of a curve whose ends share no face.
    SegmentsAcrossFaces {
        /// Index of the curve.
        curve: usize,
        /// Number of these segments.
        count: usize,
        /// First node of the first one.
        first_node: usize,
    },
    /// A closed signed curve along which left becomes right after one turn.
    OneSidedCurve {
        /// Index of the curve.
        curve: usize,
    },
    /// A curve that begins along an edge of three or more faces whose orientations disagree about
    /// its left side.
    UndeterminedSide {
        /// Index of the curve.
        curve: usize,
    },
    /// Pieces of curve that overlap in opposite directions and cancel.
    OppositeOverlaps {
        /// Number of pairs of pieces.
        count: usize,
    },
    /// Pieces of curve that overlap in the same direction; both count.
    Overlaps {
        /// Number of pairs of pieces.
        count: usize,
    },
    /// Curves that cross inside faces.
    Crossings {
        /// Number of crossings.
        count: usize,
    },

    /// No edge is a crease, so a field does not follow any.
    NoCreases {
        /// Angle beyond which an edge counts as one, in degrees.
        degrees: f64,
        /// Largest angle by which the surface bends at an edge, in degrees.
        sharpest: f64,
    },

    /// A component that no curve or point reaches; its distance is NaN.
    UnreachedComponent {
        /// Index of the component.
        component: usize,
        /// Number of its faces.
        faces: usize,
        /// The first of them.
        first: Face,
    },
    /// A component with curves or points whose normals cancel; its distance is NaN.
    CancelledComponent {
        /// Index of the component.
        component: usize,
        /// Number of its faces.
        faces: usize,
        /// The first of them.
        first: Face,
    },
    /// Regions of slivers on which rounding affects the distance.
    SliverErrors {
        /// Number of slivers.
        count: usize,
        /// The first one.
        first: Face,
        /// Estimated error of the distance, in the unit of length.
        error: f64,
    },
    /// Level set constraints that the distance violates.
    ViolatedConstraints {
        /// Largest violation, in the unit of length.
        violation: f64,
    },
    /// Diffused vectors that are not as normal to the curves as requested.
    TiltedNormals {
        /// Remaining tangential part, relative to the length of the vectors.
        residual: f64,
        /// Tolerance on the residual.
        tolerance: f64,
        /// Number of iterations.
        iterations: usize,
    },

    /// Edges that curves traverse equally often in both directions.
    CancelledEdges {
        /// Number of these edges.
        count: usize,
    },
    /// Steps along the boundary, where no jump is possible; they were ignored.
    StepsOnBoundary {
        /// Number of these steps.
        count: usize,
    },
    /// Steps along edges of three or more faces, where left is undefined; they were ignored.
    StepsOnNonmanifoldEdges {
        /// Number of these steps.
        count: usize,
    },
    /// No edge has a jump, so all labels are 0.
    NoJump,
    /// Vertices of the completed curve with more than one fan of faces, where the winding number is
    /// undefined.
    SeveralFans {
        /// Number of these vertices.
        count: usize,
        /// The first one.
        first: SurfacePoint,
    },
    /// Faces without a value at any corner.
    FacesWithoutValue {
        /// Number of these faces.
        count: usize,
        /// The first one; on a cut mesh, the face that contains it.
        first: Face,
    },
    /// Edges of the curve that alone connect a ring of faces; the nonbounding part may exceed the
    /// curve there.
    NarrowRings {
        /// Number of these edges.
        count: usize,
        /// Ends of the first one.
        first: [SurfacePoint; 2],
    },
    /// A large share of the area has uncertain labels.
    UncertainLabels {
        /// The share of the area.
        share: f64,
        /// Labels with a smaller margin count as uncertain.
        margin: f64,
    },
    /// Pieces of the completion that could not be straightened.
    UnstraightenedPieces {
        /// Number of these pieces.
        count: usize,
        /// Number of all pieces.
        of: usize,
    },
    /// Segments of the input that look reversed.
    ReversedSegments {
        /// All of them, in the order of the curves.
        segments: Vec<SegmentId>,
        /// Relative decrease of the energy when they are reversed.
        energy_saved: f64,
        /// Share of the area whose label changes when they are reversed, if known.
        changed_area: Option<f64>,
    },
    /// The orientation of the curve was not checked.
    UncheckedOrientation {
        /// The reason.
        reason: String,
    },
}

impl Warning {
    /// Returns the stable name of the kind of warning: its variant in snake case.
    pub fn kind(&self) -> &'static str {
        self.into()
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use Warning::*;
        match self {
            FacesFlipped { count } => {
                let faces = counted(*count, "face was", "faces were");
                write!(f, "{faces} flipped to make the orientation consistent")
            }
            NoCreases { degrees, sharpest } => write!(
                f,
                "no edge bends by more than {degrees} degrees, so no creases are followed; the sharpest bends by \
                 {sharpest:.1}: choose a smaller angle",
            ),
            NotOrientable => write!(
                f,
                "the surface has no consistent orientation: left is taken from a curve's `up`, or from the \
                 orientation of the first face it touches, and transported along the curve"
            ),
            NonmanifoldEdges { count, first: [a, b] } => write!(
                f,
                "{} three or more faces (first: from {a} to {b}); the surface is treated as cut open there",
                counted(*count, "edge has", "edges have")
            ),
            UnusedVertices { count, first } => write!(
                f,
                "{} used by no face (first: {first}); the distance there is NaN",
                counted(*count, "vertex is", "vertices are")
            ),
            DegenerateFaces { count, first } => write!(
                f,
                "{} (first: {first}); edge lengths were perturbed by at most 1e-7 of the longest edge of each",
                counted(*count, "degenerate face", "degenerate faces")
            ),
            MergedNodes { nodes } => {
                let they = if nodes.len() == 1 {
                    "coincides with its predecessor and was"
                } else {
                    "coincide with their predecessors and were"
                };
                write!(f, "{} {they} removed", named_nodes(nodes))
            }
            ReplacedSegments { nodes } => write!(
                f,
                "{} not follow the surface; shortest paths on it replace them",
                segments_after(nodes, "does", "do")
            ),
            AmbiguousSegments { nodes, tolerance } => write!(
                f,
                "{} ambiguous: the surface has several paths of the same length to within {:.0} %; add nodes in \
                 between to choose one",
                segments_after(nodes, "is", "are"),
                100.0 * tolerance
            ),
            UncomparedSegments { nodes } => write!(
                f,
                "{} take detours: the curve has too many long segments to compare each with the shortest path; add \
                 nodes to shorten the segments",
                segments_after(nodes, "may", "may")
            ),
            SegmentsAcrossFaces { curve, count, first_node } => write!(
                f,
                "curve {curve}: {} not lie in a single face (first: node {first_node}); trace the curve",
                counted(*count, "segment does", "segments do")
            ),
            OneSidedCurve { curve } => write!(
                f,
                "curve {curve} is closed but one-sided: left becomes right after one turn, at its first node; \
                 make it unsigned"
            ),
            UndeterminedSide { curve } => write!(
                f,
                "curve {curve} begins along an edge of three or more faces whose orientations disagree on its \
                 left side; specify `up`"
            ),
            OppositeOverlaps { count } => write!(
                f,
                "{} in opposite directions and cancel",
                counted(*count, "pair of pieces overlaps", "pairs of pieces overlap")
            ),
            Overlaps { count } => write!(
                f,
                "{} in the same direction; both count",
                counted(*count, "pair of pieces overlaps", "pairs of pieces overlap")
            ),
            Crossings { count } => {
                write!(f, "curves cross inside faces at {}", counted(*count, "place", "places"))
            }
            UnreachedComponent { component, faces, first } => write!(
                f,
                "component {component} ({}, the first is {first}) is reached by no curve or point; its distance \
                 is NaN",
                counted(*faces, "face", "faces")
            ),
            CancelledComponent { component, faces, first } => write!(
                f,
                "component {component} ({}, the first is {first}) has curves or points, but their normals \
                 cancel; its distance is NaN",
                counted(*faces, "face", "faces")
            ),
            SliverErrors { count, first, error } => write!(
                f,
                "{} (first: {first}): distances along these faces may have rounding errors of about {error:.0e}; \
                 remesh with better shaped faces",
                counted(*count, "sliver", "slivers")
            ),
            ViolatedConstraints { violation } => write!(
                f,
                "level set constraints are violated by up to {violation:.1e}; use fewer nodes where curves are \
                 close together"
            ),
            TiltedNormals { residual, tolerance, iterations } => write!(
                f,
                "preserve_source_normals reached a residual of {residual:.1e} instead of {tolerance:.0e} in \
                 {iterations} iterations; resample curves that are much finer than the mesh, or turn the option \
                 off"
            ),
            CancelledEdges { count } => write!(
                f,
                "{} traversed equally often in both directions; these steps cancel",
                counted(*count, "edge is", "edges are")
            ),
            StepsOnBoundary { count } => write!(
                f,
                "{} along the boundary, where no jump is possible; ignored",
                counted(*count, "step runs", "steps run")
            ),
            StepsOnNonmanifoldEdges { count } => write!(
                f,
                "{} along edges of three or more faces, where left is undefined; ignored",
                counted(*count, "step runs", "steps run")
            ),
            NoJump => write!(f, "no edge has a jump, so all labels are 0"),
            SeveralFans { count, first } => {
                let vertices = counted(
                    *count,
                    "vertex of the completed curve has",
                    "vertices of the completed curve have",
                );
                let first = Place(first);
                write!(
                    f,
                    "{vertices} more than one fan of faces (first: {first}); the winding number is undefined there"
                )
            }
            FacesWithoutValue { count, first } => write!(
                f,
                "{} no value at any corner (first: {first}); labels there come from the nearest face with a value, \
                 if there is one",
                counted(*count, "face has", "faces have")
            ),
            NarrowRings { count, first: [a, b] } => write!(
                f,
                "{} the only edges connecting a ring of faces (first: from {} to {}), so the nonbounding part may \
                 exceed the curve there; refine the mesh around them",
                counted(*count, "edge of the curve is", "edges of the curve are"),
                Place(a),
                Place(b)
            ),
            UncertainLabels { share, margin } => write!(
                f,
                "labels are uncertain (margin below {margin}) on {:.0} % of the area; close the widest gaps of the \
                 curve",
                100.0 * share
            ),
            UnstraightenedPieces { count, of } => write!(
                f,
                "{} of the completion (of {of}) could not be straightened; close the widest gaps of the curve, or \
                 refine the mesh",
                counted(*count, "piece", "pieces")
            ),
            ReversedSegments { segments, energy_saved, changed_area } => {
                write!(f, "{} reversed", counted(segments.len(), "segment looks", "segments look"))?;
                if let Some(first) = segments.first() {
                    write!(f, " (first: curve {}, node {})", first.curve, first.node)?;
                }
                write!(f, "; reversing lowers the energy by {:.0} %", 100.0 * energy_saved)?;
                match changed_area {
                    Some(share) => write!(f, " and changes labels on {:.1} % of the area", 100.0 * share),
                    None => Ok(()),
                }
            }
            UncheckedOrientation { reason } => {
                write!(f, "the orientation of the curve was not checked: {reason}")
            }
        }
    }
}

/// Names nodes, at most the first five: "node 7", "nodes 1, 3".
fn named_nodes(nodes: &[usize]) -> String {
    const SHOWN: usize = 5;
    let shown: Vec<String> = nodes.iter().take(SHOWN).map(usize::to_string).collect();
    let noun = if nodes.len() == 1 { "node" } else { "nodes" };
    match nodes.len().saturating_sub(SHOWN) {
        0 => format!("{noun} {}", shown.join(", ")),
        more => format!("{noun} {} and {more} more", shown.join(", ")),
    }
}

/// Names segments by their first nodes, with the verb: "the segment after node 7 is".
fn segments_after(nodes: &[usize], one: &str, several: &str) -> String {
    let (segments, verb) = if nodes.len() == 1 { ("segment", one) } else { ("segments", several) };
    format!("the {segments} after {} {verb}", named_nodes(nodes))
}

/// A point on the surface, described by the vertices around it.
struct Place<'a>(&'a SurfacePoint);

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            SurfacePoint::Vertex { vertex } => write!(f, "vertex {vertex}"),
            SurfacePoint::Edge { vertices: [a, b], .. } => {
                write!(f, "a point between vertices {a} and {b}")
            }
            SurfacePoint::Face { vertices: [a, b, c], .. } => {
                write!(f, "a point in the face of vertices {a}, {b} and {c}")
            }
        }
    }
}
