//! Why curves could not be made edges of a mesh.

use eikona_mesh::{CurveError, Face, MeshError};
use thiserror::Error;

/// Why curves could not be made edges of a mesh.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum EmbedError {
    /// A curve is not on the mesh, or a segment of it leaves its face.
    #[error(transparent)]
    Curve(#[from] CurveError),
    /// The cut mesh can not be built: it has more faces than 32-bit indices can name.
    #[error("the mesh cut along the curves: {0}")]
    Mesh(#[from] MeshError),
    /// The curves in one face lie so near to each other that no order of them could be told.
    #[error(
        "the curves in {face} lie too near to each other to be told apart; merge nodes that are nearer than 1e-8 of an edge"
    )]
    Tangled {
        /// The face of the input.
        face: Face,
    },
    /// A field does not have one value an element.
    #[error("the field has {found} values, the cut mesh has {expected} {kind}; give one value each")]
    WrongLength {
        /// "vertices" or "faces".
        kind: &'static str,
        /// The number of values given.
        found: usize,
        /// The number needed.
        expected: usize,
    },
}
