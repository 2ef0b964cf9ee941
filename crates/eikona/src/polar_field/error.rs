//! Errors of polar field solves.

use crate::cut::EmbedError;
use eikona_mesh::{CurveError, Edge, Face, Vertex, counted};
use eikona_numeric::NumericError;
use thiserror::Error;

/// Largest accepted index times N.
pub(crate) const MOST_TURNS: f64 = 1e6;

/// Why no field could be computed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PolarFieldError {
    /// The mesh has no faces.
    #[error("the mesh has no faces; give a mesh with at least one face")]
    NoFaces,
    /// The degree is out of range.
    #[error("the degree N = {degree} is out of range; choose a number from 1 to 1000")]
    Degree {
        /// The degree given.
        degree: u32,
    },
    /// An edge has more than two faces.
    #[error(
        "{edge} ({} to {}) has {faces} faces, and fields need a manifold surface; split the mesh along such edges",
        vertices[0], vertices[1]
    )]
    NonmanifoldEdge {
        /// The first such edge.
        edge: Edge,
        /// Its vertices.
        vertices: [Vertex; 2],
        /// The number of its faces.
        faces: usize,
    },
    /// A vertex has more than one fan of faces.
    #[error(
        "{vertex} has {fans} fans of faces, and fields need a manifold surface; duplicate the vertex per fan"
    )]
    NonmanifoldVertex {
        /// The first such vertex.
        vertex: Vertex,
        /// The number of its fans.
        fans: usize,
    },
    /// A component is one-sided.
    #[error(
        "component {component} (from {first_face}) is not orientable, so directions have no sense of rotation; cut it open"
    )]
    NotOrientable {
        /// The component.
        component: usize,
        /// Its first face.
        first_face: Face,
    },
    /// A face has no area.
    #[error("{face} has no area; remove it, or remesh around it")]
    FlatFace {
        /// The first such face.
        face: Face,
    },
    /// An index is not a multiple of 1/N, or too large.
    #[error("{what} has index {index}, which is not a whole multiple of 1/{degree}; {}", remedy(*index, *degree))]
    Index {
        /// The singularity or generator, in words.
        what: String,
        /// The index given.
        index: f64,
        /// The degree N.
        degree: u32,
    },
    /// The indices of a component do not add up to its Euler characteristic.
    #[error(
        "the indices on component {component} (from {first_face}) add up to {sum} instead of its Euler characteristic \
         {needed}: {missing:+} is missing; add it at a vertex, edge{} or face of the component",
        if *has_boundary { ", boundary loop" } else { "" }
    )]
    IndexSum {
        /// The component.
        component: usize,
        /// Its first face.
        first_face: Face,
        /// The sum of the indices given.
        sum: f64,
        /// The Euler characteristic.
        needed: i64,
        /// What is missing.
        missing: f64,
        /// Whether the component has a boundary, whose loops may have an index, too.
        has_boundary: bool,
    },
    /// A singularity is on the boundary.
    #[error(
        "singularity {singularity} is at {element}, which is on the boundary; move it inside, or give the boundary \
         loop an index"
    )]
    OnBoundary {
        /// 0-based index of the singularity.
        singularity: usize,
        /// The vertex or edge.
        element: String,
    },
    /// A singularity is at a vertex without faces.
    #[error("singularity {singularity} is at {vertex}, which no face uses; choose another vertex")]
    UnusedVertex {
        /// 0-based index of the singularity.
        singularity: usize,
        /// The vertex.
        vertex: Vertex,
    },
    /// There is no such boundary loop.
    #[error(
        "singularity {singularity} is on boundary loop {boundary}, but the mesh has {}; loops are numbered from 0",
        counted(*loops, "boundary loop", "boundary loops")
    )]
    NoSuchLoop {
        /// 0-based index of the singularity.
        singularity: usize,
        /// The loop given.
        boundary: usize,
        /// The number of loops.
        loops: usize,
    },
    /// Two singularities share an element.
    #[error(
        "singularity {singularity} is on {element}, which has another one; add their indices, or move one"
    )]
    Repeated {
        /// 0-based index of the second singularity.
        singularity: usize,
        /// The element.
        element: String,
    },
    /// Singular elements are too close together for one face.
    #[error(
        "{element} and its neighbours have singularities that determine the scale in {face} more than once; move one \
         of them to another face"
    )]
    Conflict {
        /// The face.
        face: Face,
        /// The singular element found last.
        element: String,
    },
    /// A singularity is inside a face and another one on its own edge.
    #[error(
        "singularity {inside} is inside {face} and singularity {on_edge} on its own edge, but the field of a face \
         vanishes at one point only; move one of them, or add their indices"
    )]
    FaceAndEdge {
        /// The face.
        face: Face,
        /// The singularity inside the face.
        inside: usize,
        /// The singularity on its edge.
        on_edge: usize,
    },
    /// The number of indices of homology generators is wrong.
    #[error(
        "{} for homology generators, but the surface has {}, two per handle; give one index per generator, or none",
        counted(*found, "index is given", "indices are given"),
        counted(*expected, "generator", "generators")
    )]
    Generators {
        /// The number given.
        found: usize,
        /// The number of generators.
        expected: usize,
    },
    /// The regularizer of the printed energy is not positive.
    #[error("the regularizer {regularizer} is out of range; give a positive number, such as 1")]
    Regularizer {
        /// The regularizer given.
        regularizer: f64,
    },
    /// A trivial connection has singularities at vertices only.
    #[error("{element} has an index, but trivial connections are singular at vertices only; move it to one")]
    NotAtVertex {
        /// The face or edge.
        element: String,
    },
    /// The field is to follow the boundary of a closed surface.
    #[error("the surface has no boundary to follow; leave this guide out")]
    NoBoundary,
    /// The field is to follow curves, but there are none.
    #[error("no curve is given to follow; give at least one with two nodes")]
    NoCurve,
    /// The indices make the field turn along a closed guide without corners.
    #[error(
        "with the prescribed indices, the field turns by {turns} relative to {guide}, so it cannot follow it; change \
         the sum of the indices on one side of it by this, or give the guide a weight"
    )]
    Unfollowable {
        /// The curve, boundary loop or crease, in words.
        guide: String,
        /// How often the field turns relative to it.
        turns: f64,
    },
    /// The weight of guides is out of range.
    #[error("the weight {weight} of guides is out of range; give a positive number")]
    GuideWeight {
        /// The weight given.
        weight: f64,
    },
    /// The angle of creases is out of range.
    #[error("the crease angle {degrees} is out of range; give degrees between 0 and 180")]
    CreaseAngle {
        /// The angle given, in degrees.
        degrees: f64,
    },
    /// Creases have no direction.
    #[error(
        "creases have no direction to follow with N = {degree}; choose an even N, or give them as curves"
    )]
    CreasesWithOddDegree {
        /// The degree N.
        degree: u32,
    },
    /// Principal curvatures have no direction.
    #[error("directions of curvature are lines, which N = {degree} vectors cannot follow; choose an even N")]
    CurvatureWithOddDegree {
        /// The degree N.
        degree: u32,
    },
    /// A singularity is not on the mesh.
    #[error("singularity {singularity}: {fault}")]
    Point {
        /// 0-based index of the singularity.
        singularity: usize,
        /// What is wrong with its point.
        fault: CurveError,
    },
    /// The number of vectors is not N per face.
    #[error(
        "{found} vectors are given, but {faces} faces with N = {degree} need {}; check that the field is of this mesh",
        *degree as usize * faces
    )]
    FieldSize {
        /// The number of vectors.
        found: usize,
        /// The degree N.
        degree: u32,
        /// The number of faces.
        faces: usize,
    },
    /// A vector is not finite.
    #[error("vector {vector} of {face} is not finite; replace it")]
    NonFiniteVector {
        /// The face.
        face: Face,
        /// 0-based index of the vector in its face.
        vector: usize,
    },
    /// A matching is between faces that share no edge.
    #[error(
        "row {row} of the matching is between {} and {}, which share no edge of two faces; check that it is of this \
         mesh", faces[0], faces[1]
    )]
    Matching {
        /// 0-based index of the row.
        row: usize,
        /// Its faces.
        faces: [Face; 2],
    },
    /// Rounding errors of the rotation are too large.
    #[error(
        "the rotation misses the prescribed sums by {residual:.1e}, and phases close to {closure:.1e}; the mesh has \
         angles too small for double precision: remesh it"
    )]
    NotClosed {
        /// Largest deviation from the prescribed sums, in radians.
        residual: f64,
        /// Largest deviation of a phase from a whole number of turns, in radians.
        closure: f64,
    },
    /// The separation of streamlines is out of range.
    #[error("the separation {separation} of streamlines is out of range; give a length above {least:.3e}")]
    Separation {
        /// The separation given.
        separation: f64,
        /// The least one.
        least: f64,
    },
    /// The point of a streamline is not on the mesh.
    #[error("{0}")]
    Start(CurveError),
    /// The field has no direction at the start of a streamline.
    #[error("the field vanishes at {element}, so no streamline starts there; choose another point")]
    Vanishes {
        /// The vertex, edge or face.
        element: String,
    },
    /// A curve to follow is not on the mesh.
    #[error(transparent)]
    Curve(#[from] CurveError),
    /// Stored values do not belong to the mesh.
    #[error("the stored field is not one of this mesh: {what}; give the mesh that it was computed on")]
    OtherMesh {
        /// What differs.
        what: String,
    },
    /// The mesh cannot be split at the singular points.
    #[error("the mesh cannot be split at its singular points: {0}")]
    Split(#[from] EmbedError),
    /// A linear system could not be solved.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}

/// What to do about an index that is no multiple of 1/N, or too large.
fn remedy(index: f64, degree: u32) -> String {
    let n = f64::from(degree);
    let turns = index * n;
    if turns.abs() <= MOST_TURNS {
        let [below, above] = [turns.floor() / n, turns.ceil() / n];
        format!("choose {below} or {above}, or change N")
    } else {
        format!("choose one of at most {MOST_TURNS}/{degree} in magnitude")
    }
}
