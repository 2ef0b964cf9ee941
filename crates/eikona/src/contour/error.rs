//! Why a curve could not be made.

use eikona_mesh::{CurveError, Vertex};
use thiserror::Error;

/// Why a curve could not be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ContourError {
    /// The mesh has no faces to draw on.
    #[error("the mesh has no faces; a curve needs a surface to lie on")]
    NoFaces,
    /// Too few points for a curve.
    #[error(
        "{points} different point(s) are left on the surface, a curve needs at least 2; give isolated places as points"
    )]
    TooFewPoints {
        /// How many there are.
        points: usize,
    },
    /// A coordinate is NaN or infinite.
    #[error("point {node} of the polyline is at ({}, {}, {}), which is not finite; correct or remove it", position[0], position[1], position[2])]
    NonFinitePoint {
        /// 0-based index of the point.
        node: usize,
        /// Its coordinates as given.
        position: [f64; 3],
    },
    /// No path over the surface joins two nodes.
    #[error(
        "node {from} and node {to} lie on pieces of the surface that no edge joins; join the pieces if they touch (`weld` or `stitch`, or --weld or --stitch on the command line), else split the curve between the nodes"
    )]
    NotConnected {
        /// 0-based index of the first node.
        from: usize,
        /// 0-based index of the second node.
        to: usize,
    },
    /// A vertex that the mesh does not have.
    #[error("{vertex} does not exist: the mesh has {vertices} vertices, numbered from 0")]
    VertexOutOfRange {
        /// The vertex as given.
        vertex: Vertex,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A parameter is out of its range.
    #[error("{name} = {value} is out of range: {bound}")]
    Parameter {
        /// The parameter's name.
        name: &'static str,
        /// The value given.
        value: f64,
        /// What is allowed.
        bound: &'static str,
    },
    /// A field does not have one value a vertex.
    #[error("the field has {found} values, the mesh has {expected} vertices; give one value a vertex")]
    WrongLength {
        /// The number of values given.
        found: usize,
        /// The number needed.
        expected: usize,
    },
    /// A vector that must have a direction has none.
    #[error("the plane's {name} is ({}, {}, {}); it must be finite and, for a normal, not zero", value[0], value[1], value[2])]
    BadPlane {
        /// "point" or "normal".
        name: &'static str,
        /// The value given.
        value: [f64; 3],
    },
    /// The curve is not on the mesh.
    #[error(transparent)]
    Curve(#[from] CurveError),
}
