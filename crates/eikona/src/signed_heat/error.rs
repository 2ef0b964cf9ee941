//! Why no distance could be computed.

use eikona_mesh::{CurveError, Edge, Face};
use eikona_numeric::NumericError;
use thiserror::Error;

/// Why no distance could be computed.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SignedHeatError {
    /// The curve or point is not on the mesh.
    #[error(transparent)]
    Curve(#[from] CurveError),
    /// The mesh has no faces.
    #[error("the mesh has no faces, so there is no surface to measure on")]
    NoFaces,
    /// All faces are degenerate: their height is below 1e-8 of their longest side.
    #[error(
        "every face has a height below 1e-8 of its longest edge, so there is no surface to measure on; remesh with better shaped faces"
    )]
    NoArea,
    /// An option is out of range.
    #[error("{name} = {value:?} is out of range: {bound}")]
    Option {
        /// The option.
        name: &'static str,
        /// The value given.
        value: f64,
        /// What is allowed.
        bound: &'static str,
    },
    /// The factors would exceed the memory limit.
    #[error(
        "factoring needs about {needed_bytes} bytes, more than the limit of {limit_bytes}; raise the limit or use a coarser mesh"
    )]
    MemoryLimit {
        /// Predicted bytes.
        needed_bytes: usize,
        /// The limit given.
        limit_bytes: usize,
    },
    /// The diffusion system could not be solved.
    #[error("diffusing the normals failed at {edge}: {fault}")]
    Diffusion {
        /// The edge of the unknown that failed.
        edge: Edge,
        /// What the solver said.
        fault: NumericError,
    },
    /// The Poisson system could not be solved.
    #[error("integrating the gradient failed at vertex {vertex}: {fault}")]
    Integration {
        /// The vertex that failed.
        vertex: usize,
        /// What the solver said.
        fault: NumericError,
    },
    /// A system could not be set up.
    #[error(transparent)]
    Numeric(#[from] NumericError),
    /// Lengths that overflow or underflow double precision when squared.
    #[error("{face} has sides {lengths:?}, which can not be squared in double precision; rescale the mesh")]
    Scale {
        /// The face.
        face: Face,
        /// The lengths of its sides.
        lengths: [f64; 3],
    },
}
