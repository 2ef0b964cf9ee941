//! What comes out.

use crate::signed_heat::report::Report;
use eikona_mesh::{FaceField, VertexField};

/// The distance with everything that tells how it came about.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Signed distance at each vertex, in the mesh's unit of length; NaN where no source reaches
    /// (the report warns of it).
    pub distance: VertexField<f64>,
    /// The unit vector of each face that the gradient of the distance was fitted to; zero where no
    /// source reaches.
    pub gradient: FaceField<[f64; 3]>,
    /// How far each value rests on data rather than on extrapolation, if asked for.
    pub confidence: Option<Confidence>,
    /// Timings, residuals, choices, warnings.
    pub report: Report,
}

/// How far the values rest on data.
#[derive(Clone, Debug)]
pub struct Confidence {
    /// Distance at each vertex to the nearest given piece of curve or point, along the surface, in
    /// the unit of length (first-order accurate). Where it is larger than the absolute distance,
    /// the nearest point lies on a completed piece.
    pub distance_to_data: VertexField<f64>,
    /// From 0 to 1 at each vertex: absolute distance (plus one edge) over distance to data (plus
    /// one edge), times the agreement of the diffused vectors around the vertex. Near 1: the
    /// nearest point is on a given piece. Near 0: on a piece that was invented, or in the middle of
    /// contradicting data.
    pub confidence: VertexField<f64>,
}
