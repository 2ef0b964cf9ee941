//! Errors of meshes, curves and files: each names the element, the value, the bound and the remedy.

use crate::id::{Edge, Face, Vertex};
use std::fmt;
use std::path::Path;
use thiserror::Error;

/// A fault of a mesh, with its element and value.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Fault {
    /// A coordinate is NaN or infinite.
    NonFinitePosition {
        /// The vertex.
        vertex: Vertex,
        /// Its coordinates as read.
        position: [f64; 3],
    },
    /// A face refers to a vertex that does not exist.
    IndexOutOfRange {
        /// The face.
        face: Face,
        /// The index as given (0-based).
        index: i64,
        /// The number of vertices.
        vertices: usize,
    },
    /// A face repeats a vertex: at successive corners, or without enclosing an area. (A polygon may
    /// revisit a vertex on the way back from a hole.)
    RepeatedVertex {
        /// The face.
        face: Face,
        /// The repeated vertex.
        vertex: Vertex,
    },
    /// A polygon with fewer than three corners.
    TooFewCorners {
        /// The face.
        face: Face,
        /// Its number of corners.
        corners: usize,
    },
    /// A face whose area is zero, or so small that its angles are meaningless.
    ZeroArea {
        /// The face.
        face: Face,
        /// Its area.
        area: f64,
    },
    /// A vertex that no face uses.
    UnreferencedVertex {
        /// The vertex.
        vertex: Vertex,
    },
    /// An edge with more than two faces.
    NonmanifoldEdge {
        /// The edge.
        edge: Edge,
        /// Its endpoints.
        vertices: [Vertex; 2],
        /// The number of its faces.
        faces: usize,
    },
    /// A vertex with more than one vertex fan.
    NonmanifoldVertex {
        /// The vertex.
        vertex: Vertex,
        /// The number of fans.
        fans: usize,
    },
    /// An edge whose two faces are inconsistently oriented.
    InconsistentOrientation {
        /// The edge.
        edge: Edge,
        /// Its endpoints.
        vertices: [Vertex; 2],
    },
    /// Two faces have the same three vertices.
    DuplicateFace {
        /// The later face.
        face: Face,
        /// The first one with these vertices.
        first: Face,
    },
    /// A vertex inside an edge whose faces do not use it (a T-junction).
    HangingVertex {
        /// The vertex.
        vertex: Vertex,
        /// The edge.
        edge: Edge,
        /// Its endpoints.
        vertices: [Vertex; 2],
        /// The distance of the vertex from the edge.
        gap: f64,
    },
    /// A boundary vertex separated from another one by a small gap.
    Crack {
        /// The later vertex.
        vertex: Vertex,
        /// The earlier vertex.
        to: Vertex,
        /// Their distance.
        gap: f64,
    },
    /// A face of very small height.
    Sliver {
        /// The face.
        face: Face,
        /// Its height above its longest edge, relative to that edge.
        height: f64,
    },
    /// Two vertices with exactly the same position.
    CoincidentVertices {
        /// The later vertex.
        vertex: Vertex,
        /// The first one at this position.
        first: Vertex,
    },
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Fault::NonFinitePosition { vertex, position: [x, y, z] } => {
                write!(f, "{vertex} is at ({x}, {y}, {z}), which is not finite; correct or remove it")
            }
            Fault::IndexOutOfRange { face, index, vertices } => write!(
                f,
                "{face} refers to vertex {index}, but there are {vertices} vertices (0 to {}); correct the index",
                *vertices as i64 - 1
            ),
            Fault::RepeatedVertex { face, vertex } => {
                write!(f, "{face} repeats {vertex}; remove the face")
            }
            Fault::TooFewCorners { face, corners } => {
                write!(f, "{face} has {corners} corners but needs at least 3; remove the face")
            }
            Fault::ZeroArea { face, area } => write!(f, "{face} has area {area:e}"),
            Fault::UnreferencedVertex { vertex } => write!(f, "{vertex} is used by no face"),
            Fault::NonmanifoldEdge { edge, vertices: [a, b], faces } => {
                write!(f, "{edge} ({a} to {b}) is shared by {faces} faces")
            }
            Fault::NonmanifoldVertex { vertex, fans } => {
                write!(f, "{vertex} has {fans} vertex fans that share no edge")
            }
            Fault::InconsistentOrientation { edge, vertices: [a, b] } => {
                write!(f, "the two faces at {edge} ({a} to {b}) are inconsistently oriented")
            }
            Fault::DuplicateFace { face, first } => write!(f, "{face} has the same vertices as {first}"),
            Fault::HangingVertex { vertex, edge, vertices: [a, b], gap } => {
                write!(f, "{vertex} lies inside {edge} ({a} to {b}), whose faces do not use it")?;
                if *gap > 0.0 { write!(f, "; the gap is {gap:.1e}") } else { Ok(()) }
            }
            Fault::Crack { vertex, to, gap } => {
                write!(f, "{vertex} is not joined to {to}, across a gap of {gap:.1e}")
            }
            Fault::Sliver { face, height } => {
                write!(f, "{face} has a height of {height:.1e} times its longest edge")
            }
            Fault::CoincidentVertices { vertex, first } => {
                write!(f, "{vertex} lies exactly on {first}")
            }
        }
    }
}

/// Number of faults that an error message lists before it counts the rest.
const FAULTS_SHOWN: usize = 5;

/// Lists the first faults, one per line, and counts the rest.
fn list(faults: &[Fault]) -> String {
    let mut text: String = faults.iter().take(FAULTS_SHOWN).map(|x| format!("\n  {x}")).collect();
    if faults.len() > FAULTS_SHOWN {
        text += &format!("\n  and {} more", faults.len() - FAULTS_SHOWN);
    }
    text
}

/// Why a mesh could not be built.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The faults, all of them.
    #[error("the mesh is not valid:{}", list(.0))]
    Invalid(Vec<Fault>),
    /// More elements than 32-bit indices can address.
    #[error("{vertices} vertices and {faces} faces are more than 32-bit indices can address; split the mesh")]
    TooLarge {
        /// Number of vertices.
        vertices: usize,
        /// Number of faces.
        faces: usize,
    },
    /// An array whose length differs from the number of elements.
    #[error("found {found} {what}, expected {expected}")]
    WrongLength {
        /// What the array holds.
        what: &'static str,
        /// The number of values given.
        found: usize,
        /// The number needed.
        expected: usize,
    },
    /// A parameter of a procedural shape or of damage is not valid.
    #[error("{name} = {value} is not valid: {bound}")]
    Parameter {
        /// The parameter's name.
        name: &'static str,
        /// The value as given.
        value: String,
        /// The allowed values.
        bound: &'static str,
    },
    /// A shape, or a parameter of a shape, that does not exist.
    #[error("unknown {what} {name:?}; {}", known_names(.known))]
    UnknownName {
        /// "shape" or "parameter".
        what: &'static str,
        /// The name as given.
        name: String,
        /// The existing names, the most similar one first.
        known: Vec<&'static str>,
    },
}

/// Lists the known names for an error message.
fn known_names(known: &[&str]) -> String {
    match known {
        [] => "there are none".to_string(),
        [one] => format!("the only one is {one}"),
        many => format!("expected one of {}", many.join(", ")),
    }
}

/// What is wrong with a curve or a point on a surface.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CurveError {
    /// A fault, with its place on a curve.
    #[error("curve {curve}, node {node}: {fault}")]
    AtNode {
        /// 0-based index of the curve.
        curve: usize,
        /// 0-based index of the node; for a segment, of its first node.
        node: usize,
        /// What is wrong there.
        fault: Box<CurveError>,
    },
    /// A fault, with the index of its isolated point.
    #[error("point {point}: {fault}")]
    AtPoint {
        /// 0-based index of the point.
        point: usize,
        /// What is wrong with it.
        fault: Box<CurveError>,
    },
    /// A vertex index that the mesh does not have.
    #[error("vertex {vertex} does not exist: the mesh has {vertices} vertices, numbered from 0")]
    VertexOutOfRange {
        /// The index as given.
        vertex: i64,
        /// The number of vertices.
        vertices: usize,
    },
    /// An edge or face number (in a text format) that the mesh does not have.
    #[error("{kind} {index} does not exist: the mesh has {count}, numbered from 0")]
    ElementOutOfRange {
        /// "edge" or "face".
        kind: &'static str,
        /// The number as given.
        index: i64,
        /// The number of such elements.
        count: usize,
    },
    /// Two vertices that are not joined by an edge.
    #[error("vertices {} and {} are not joined by an edge; name the ends of an edge, or give positions in space and have them traced", vertices[0], vertices[1])]
    NoSuchEdge {
        /// The vertices as given.
        vertices: [u32; 2],
    },
    /// Three vertices that are not the corners of a face.
    #[error("vertices {}, {} and {} are not the corners of a face; name the three corners of one", vertices[0], vertices[1], vertices[2])]
    NoSuchFace {
        /// The vertices as given.
        vertices: [u32; 3],
    },
    /// An edge parameter outside [0, 1].
    #[error("t = {t} is outside [0, 1]; t runs from 0 at the first vertex to 1 at the second")]
    ParameterOutOfRange {
        /// The parameter as given.
        t: f64,
    },
    /// Barycentric weights that are not a point of the face.
    #[error(
        "barycentric weights {bary:?} are not a point of the face; each must lie in [0, 1] and their sum be 1"
    )]
    WeightsOutOfRange {
        /// The weights as given.
        bary: [f64; 3],
    },
    /// A segment whose two nodes share no face.
    #[error(
        "the segment to the next node does not lie in one face; have the curve traced across the faces (`trace`, or `--trace` on the command line)"
    )]
    SegmentAcrossFaces,
    /// A curve with fewer than two nodes.
    #[error("curve {curve} has {nodes} node(s), a curve needs at least 2; give isolated places as points")]
    TooFewNodes {
        /// 0-based index of the curve.
        curve: usize,
        /// Its number of nodes.
        nodes: usize,
    },
    /// A curve all of whose segments have length zero.
    #[error("curve {curve} has length 0; give isolated places as points")]
    ZeroLength {
        /// 0-based index of the curve.
        curve: usize,
    },
    /// Neither a curve nor a point.
    #[error("there is no curve and no point to measure distance to")]
    Empty,
}

impl CurveError {
    /// Adds the curve and node at which the fault was found.
    pub fn at(self, curve: usize, node: usize) -> CurveError {
        CurveError::AtNode { curve, node, fault: Box::new(self) }
    }
    /// Adds the isolated point at which the fault was found.
    pub fn at_point(self, point: usize) -> CurveError {
        CurveError::AtPoint { point, fault: Box::new(self) }
    }
}

/// Why a file could not be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FileError {
    /// An error of the operating system.
    #[error("{path}: {fault}")]
    Io {
        /// The file.
        path: String,
        /// The error.
        #[source]
        fault: std::io::Error,
    },
    /// The content does not follow the format.
    #[error("{format}, {place}: {problem}")]
    Syntax {
        /// The format's name ("OBJ").
        format: &'static str,
        /// The place: "line 12", "byte 80", "vertex 17".
        place: String,
        /// What is wrong and what is expected.
        problem: String,
    },
    /// A fault, with its file.
    #[error("{path}: {fault}")]
    InFile {
        /// The file.
        path: String,
        /// What is wrong with it.
        fault: Box<FileError>,
    },
    /// The format is unknown, or can not hold the data to be written.
    #[error("{0}")]
    Unsupported(String),
    /// The mesh in the file is not valid.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The curve in the file is not valid.
    #[error(transparent)]
    Curve(#[from] CurveError),
}

impl FileError {
    /// Creates a [`FileError::Syntax`].
    pub fn syntax(format: &'static str, place: impl Into<String>, problem: impl Into<String>) -> Self {
        FileError::Syntax { format, place: place.into(), problem: problem.into() }
    }
    /// Creates a [`FileError::Io`].
    pub fn io(path: impl AsRef<Path>, fault: std::io::Error) -> Self {
        FileError::Io { path: path.as_ref().display().to_string(), fault }
    }
    /// Adds the file in which the fault was found, unless the fault already names one.
    pub fn in_file(self, path: impl AsRef<Path>) -> Self {
        match self {
            FileError::Io { .. } | FileError::InFile { .. } => self,
            fault => FileError::InFile { path: path.as_ref().display().to_string(), fault: Box::new(fault) },
        }
    }
}
