//! Errors of cutting a mesh along curves.

use eikona_mesh::{CurveError, Face, MeshError};
use eikona_numeric::NumericError;
use thiserror::Error;

/// Error of cutting a mesh along curves.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum EmbedError {
    /// A curve is not on the mesh, or a segment of it leaves its face.
    #[error(transparent)]
    Curve(#[from] CurveError),
    /// The cut mesh has more faces than 32-bit indices can address.
    #[error("the mesh cannot be cut along the curves: {0}")]
    Mesh(#[from] MeshError),
    /// The observer stopped the computation.
    #[error(transparent)]
    Stopped(#[from] NumericError),
    /// The curves in one face are too close together to be ordered.
    #[error(
        "the curves in {face} are too close together to be ordered; merge nodes closer than 1e-8 of an edge length"
    )]
    Tangled {
        /// The face of the input.
        face: Face,
    },
}
