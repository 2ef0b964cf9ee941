//! Errors of repulsive energies.

use eikona_mesh::Face;
use eikona_numeric::NumericError;
use thiserror::Error;

/// Why no energy could be computed.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RepulsiveError {
    /// The mesh has no faces.
    #[error("the mesh has no faces; give a mesh with at least one face")]
    NoFaces,
    /// The exponents are out of range.
    #[error(
        "the exponents alpha = {alpha}, beta = {beta} are out of range: the energy is finite and keeps surfaces apart \
         only if alpha > 2 and alpha + 2 < beta < 2 alpha + 2; choose p = 6 (alpha = 6, beta = 12), say"
    )]
    Exponents {
        /// The exponent of the distance from the tangent plane.
        alpha: f64,
        /// The exponent of the distance.
        beta: f64,
    },
    /// A face has no area, so it has no normal.
    #[error("{face} has no area, so it has no normal; repair the mesh, or drop the face")]
    FlatFace {
        /// The first such face.
        face: Face,
    },
    /// Two faces have the same centroid.
    #[error("{} and {} have the same centroid, where the energy is infinite; drop one of them", faces[0], faces[1])]
    Coincident {
        /// The first such pair.
        faces: [Face; 2],
    },
    /// The energy is beyond the range of numbers.
    #[error("the energy at {face} is beyond the range of numbers; scale the mesh to about unit size")]
    Range {
        /// The first such face.
        face: Face,
    },
    /// The observer stopped the computation.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}
