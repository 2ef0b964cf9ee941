//! Errors of repulsive energies.

use crate::remesh::RemeshError;
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
    /// Two faces touch.
    #[error(
        "{} and {} touch, where the energy is infinite; move them apart, or choose the midpoint rule",
        faces[0], faces[1]
    )]
    Touching {
        /// The first such pair.
        faces: [Face; 2],
    },
    /// Too many faces are in near contact for adaptive quadrature.
    #[error(
        "more than {pairs} pairs of faces are closer than about their size (such as {} and {}), too many for \
         adaptive quadrature; repair the mesh, or choose the midpoint rule",
        faces[0], faces[1]
    )]
    NearContact {
        /// The largest number of pairs.
        pairs: usize,
        /// One of them.
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
    /// The surface intersects the obstacle, or touches it.
    #[error(
        "{} pairs of a face and a face of the obstacle intersect (first: {} and {} of the obstacle); move the \
         obstacle away",
        pairs.len(), pairs[0][0], pairs[0][1]
    )]
    IntersectsObstacle {
        /// All pairs, at least one: a face of the surface and one of the obstacle.
        pairs: Vec<[Face; 2]>,
    },
    /// A constraint or a setting of the flow is out of range.
    #[error("{fault}; give finite values, positive lengths, 1 or more steps, and each constraint once")]
    Constraint {
        /// What is wrong.
        fault: String,
    },
    /// The weight of a potential is not a number.
    #[error("the weight {weight} of a potential is not finite; give a number, such as 1")]
    Weight {
        /// The weight.
        weight: f64,
    },
    /// The exponent of a potential is out of range.
    #[error(
        "the exponent {exponent} of a potential is out of range; give a number {}",
        if *least > 0.0 { "of at least 1, such as 2" } else { "above 0, such as 6" }
    )]
    PotentialExponent {
        /// The exponent.
        exponent: f64,
        /// The bound: 1 for attractors, 0 for what repels.
        least: f64,
    },
    /// An obstacle has no face with an area.
    #[error("none of the {faces} faces of the obstacle has an area, so it does not repel; give another mesh")]
    FlatObstacle {
        /// Its number of faces.
        faces: usize,
    },
    /// A point cloud has no points.
    #[error("the obstacle has no points; give at least one")]
    NoObstaclePoints,
    /// A point of an obstacle is not finite.
    #[error("point {point} of the obstacle is not finite; drop it")]
    ObstaclePoint {
        /// The first such point, from 0.
        point: usize,
    },
    /// A face lies on an obstacle.
    #[error(
        "{face} lies on an obstacle, or so close that the potential is beyond the range of numbers; move the surface \
         away from it"
    )]
    FaceOnObstacle {
        /// The first such face.
        face: Face,
    },
    /// An edge of the surface passes through an implicit obstacle.
    #[error(
        "the edge from {} to {} passes through an implicit obstacle, from distance {} to {}; move the surface to \
         one side of it, or turn collisions off",
        vertices[0], vertices[1], distances[0], distances[1]
    )]
    EdgeThroughBarrier {
        /// The ends of the edge.
        vertices: [Vertex; 2],
        /// Their signed distances from the obstacle.
        distances: [f64; 2],
    },
    /// A face touches an implicit obstacle, or passes through it between its corners.
    #[error(
        "{face}, whose centroid is at distance {distance} from an implicit obstacle, touches it or passes through \
         it; move the surface away from it, or turn collisions off"
    )]
    FaceAtBarrier {
        /// The first such face.
        face: Face,
        /// The signed distance of its centroid.
        distance: f64,
    },
    /// A number that describes an implicit surface is out of range.
    #[error(
        "{what} is {value}; points have to be finite, radii, lengths of directions and spacings also positive"
    )]
    ImplicitShape {
        /// Which number.
        what: &'static str,
        /// The number.
        value: f64,
    },
    /// The samples of a distance do not fill their grid.
    #[error(
        "a grid of {} x {} x {} samples cannot have {values} values; give at least two samples along each axis, and \
         one value for each", shape[0], shape[1], shape[2]
    )]
    GridShape {
        /// The number of samples along each axis.
        shape: [usize; 3],
        /// The number of values.
        values: usize,
    },
    /// A sample of a distance is not finite.
    #[error("sample {sample:?} of the distance is {value}; fill such samples with finite distances")]
    GridValue {
        /// The first such sample, along each axis from 0.
        sample: [usize; 3],
        /// Its value.
        value: f64,
    },
    /// A value to which a quantity is held is out of range.
    #[error("{what} is {value}; targets have to be finite, and what is divided by positive")]
    Target {
        /// Which value.
        what: &'static str,
        /// The value.
        value: f64,
    },
    /// The area to which a face is held is not positive.
    #[error("the area {area} to which {face} is held is not positive; give positive areas")]
    TargetArea {
        /// The first such face.
        face: Face,
        /// The area.
        area: f64,
    },
    /// The values of a potential are those of another mesh.
    #[error("there are {found} {what}, but the mesh has {expected} {elements}; transfer them to this mesh")]
    WrongCount {
        /// Which values.
        what: &'static str,
        /// Their number.
        found: usize,
        /// The number of elements.
        expected: usize,
        /// What has such a value: `vertices` or `faces`.
        elements: &'static str,
    },
    /// A potential is beyond the range of numbers.
    #[error(
        "{potential} is beyond the range of numbers; scale the mesh to about unit size, or lower its weight"
    )]
    PotentialRange {
        /// Which potential.
        potential: &'static str,
    },
    /// The state is none of a flow with these options.
    #[error("the flow cannot continue: {fault}; start it again, or give the options it had")]
    State {
        /// What is wrong.
        fault: String,
    },
    /// Remeshing failed.
    #[error("remeshing failed: {fault}; start the flow without remeshing")]
    Remeshing {
        /// What is wrong.
        fault: String,
    },
    /// The observer stopped the computation.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}

impl RepulsiveError {
    pub(super) fn from_remeshing(fault: RemeshError) -> RepulsiveError {
        match fault {
            RemeshError::Numeric(stopped) => stopped.into(),
            other => RepulsiveError::Remeshing { fault: other.to_string() },
        }
    }
}
