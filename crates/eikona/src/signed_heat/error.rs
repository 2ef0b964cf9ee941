//! Errors of the signed heat method.

use eikona_mesh::{CurveError, Edge, Face};
use eikona_numeric::NumericError;
use thiserror::Error;

/// Error of the signed heat method.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SignedHeatError {
    /// The source is empty, or a curve or point of it is not valid on the mesh.
    #[error(transparent)]
    Curve(#[from] CurveError),
    /// The mesh has no faces.
    #[error("the mesh has no faces; distances need a surface, not only points or lines")]
    NoFaces,
    /// Every face is degenerate: its height is below 1e-8 of its longest edge.
    #[error("every face has a height below 1e-8 of its longest edge; remesh with better shaped faces")]
    NoArea,
    /// An option is out of range.
    #[error("{name} = {value:?} is out of range: {bound}")]
    Option {
        /// Name of the option.
        name: &'static str,
        /// The given value.
        value: f64,
        /// The allowed range.
        bound: &'static str,
    },
    /// The diffusion system could not be solved.
    #[error("the diffusion of the normals failed at {edge}: {fault}")]
    Diffusion {
        /// Edge of the unknown at which the solver failed.
        edge: Edge,
        /// Error of the linear solver.
        fault: NumericError,
    },
    /// The Poisson system could not be solved.
    #[error("the integration of the gradient failed at vertex {vertex}: {fault}")]
    Integration {
        /// Vertex at which the solver failed.
        vertex: usize,
        /// Error of the linear solver.
        fault: NumericError,
    },
    /// A system could not be set up.
    #[error(transparent)]
    Numeric(#[from] NumericError),
    /// The longest edge is outside the range from 1e-100 to 1e100: squares of lengths would
    /// overflow or underflow.
    #[error(
        "{face} has edge lengths {lengths:?}, but the longest edge of a mesh must be between 1e-100 and 1e100; rescale the mesh"
    )]
    Scale {
        /// The face.
        face: Face,
        /// Lengths of its edges.
        lengths: [f64; 3],
    },
}
