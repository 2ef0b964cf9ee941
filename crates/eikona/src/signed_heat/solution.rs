//! Result of one solve.

use crate::signed_heat::report::Report;
use eikona_mesh::{FaceField, VertexField};

/// Signed distance, with its gradient, confidence and report.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Solution {
    /// Signed distance at each vertex, in the mesh's unit of length; NaN where no source reaches
    /// (with a warning in the report).
    pub distance: VertexField<f64>,
    /// One unit vector per face, to which the gradient of the distance was fitted; zero where no
    /// source reaches.
    pub gradient: FaceField<[f64; 3]>,
    /// Confidence in each value, if asked for: whether it rests on data or on extrapolation.
    pub confidence: Option<Confidence>,
    /// Timings, residuals, choices, warnings.
    pub report: Report,
}

/// Confidence in each distance: whether it rests on data or on extrapolation.
#[derive(Clone, Debug)]
pub struct Confidence {
    /// Distance along the surface from each vertex to the nearest given segment or point, in the
    /// unit of length (first-order accurate). Where it exceeds the absolute distance, the nearest
    /// point lies on a completed piece.
    pub distance_to_data: VertexField<f64>,
    /// Confidence at each vertex, from 0 to 1: absolute distance (plus one edge) over distance to
    /// data (plus one edge), times the agreement of the diffused vectors around the vertex. Near 1,
    /// the nearest point lies on a given curve. Near 0, it lies on a completed piece, or the vertex
    /// is amid contradicting data.
    pub confidence: VertexField<f64>,
}
