//! Errors of repulsive energies.

use eikona_mesh::{Edge, Face, Vertex};
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
    /// The separation of clusters is out of range.
    #[error("the separation {separation} is out of range; give a number above 0 and up to 1, such as 0.2")]
    Separation {
        /// The separation.
        separation: f64,
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
    /// Three or more faces meet at an edge.
    #[error("{edge} has {faces} faces, where the surface cannot move apart; split the mesh there")]
    NonmanifoldEdge {
        /// The first such edge.
        edge: Edge,
        /// Its number of faces.
        faces: usize,
    },
    /// The faces at a vertex form several fans.
    #[error("the faces at {vertex} form several fans, which cannot move apart; split the mesh there")]
    NonmanifoldVertex {
        /// The first such vertex.
        vertex: Vertex,
    },
    /// The surface intersects itself, where the energy of these exponents is infinite.
    #[error(
        "{} pairs of faces intersect (first: {} and {}), where the energy of alpha >= 4 is infinite on finer meshes; \
         repair the mesh, or choose p below 4",
        pairs.len(), pairs[0][0], pairs[0][1]
    )]
    Intersecting {
        /// All pairs, at least one.
        pairs: Vec<[Face; 2]>,
    },
    /// There is no volume, since faces are not oriented consistently.
    #[error(
        "the faces at {edge} are not oriented consistently, so the surface encloses no volume; orient the mesh"
    )]
    Inconsistent {
        /// The first such edge.
        edge: Edge,
    },
    /// The state is none of a flow with these options.
    #[error("the flow cannot continue: {fault}; start it again, or give the options it had")]
    State {
        /// What is wrong.
        fault: String,
    },
    /// The observer stopped the computation.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}
