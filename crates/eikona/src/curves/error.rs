//! Errors of curve construction.

use eikona_mesh::{CurveError, Vertex};
use thiserror::Error;

/// Error of tracing, straightening or path finding.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TraceError {
    /// The mesh has no faces.
    #[error("the mesh has no faces; a curve needs a surface to lie on")]
    NoFaces,
    /// Fewer than two distinct points remain.
    #[error(
        "{points} distinct point(s) remain on the surface; a curve needs at least 2; give isolated \
         places as points"
    )]
    TooFewPoints {
        /// Number of distinct points.
        points: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error(
        "point {node} of the polyline is ({}, {}, {}), which is not finite; correct or remove it",
        position[0], position[1], position[2]
    )]
    NonFinitePoint {
        /// 0-based index of the point.
        node: usize,
        /// Its coordinates as given.
        position: [f64; 3],
    },
    /// No path on the surface connects two nodes.
    #[error(
        "no path on the surface connects node {from} and node {to}; join the components if they \
         touch (`weld` or `stitch`, or --weld or --stitch on the command line), else split the \
         curve between the nodes"
    )]
    NotConnected {
        /// 0-based index of the first node.
        from: usize,
        /// 0-based index of the second node.
        to: usize,
    },
    /// A vertex index out of range.
    #[error("{vertex} does not exist: the mesh has {vertices} vertices, numbered from 0")]
    VertexOutOfRange {
        /// The vertex as given.
        vertex: Vertex,
        /// Number of vertices.
        vertices: usize,
    },
    /// A parameter out of range.
    #[error("{name} = {value} is out of range: {bound}")]
    Parameter {
        /// The parameter's name.
        name: &'static str,
        /// The value given.
        value: f64,
        /// The accepted range.
        bound: &'static str,
    },
    /// The curve is not on the mesh.
    #[error(transparent)]
    Curve(#[from] CurveError),
}
