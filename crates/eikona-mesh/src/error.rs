//! What can be wrong with a mesh, a curve or a file: element, value, bound and remedy in a
//! sentence.

use crate::id::{Edge, Face, Vertex};
use std::fmt;
use std::path::Path;
use thiserror::Error;

/// One fault of a mesh, with the element and the value.
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
    /// A face names a vertex that does not exist.
    IndexOutOfRange {
        /// The face.
        face: Face,
        /// The index as given (0-based).
        index: i64,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A face names one vertex twice: at successive corners, or without area. (Polygons may pass a
    /// vertex again on the way back from a hole.)
    RepeatedVertex {
        /// The face.
        face: Face,
        /// The vertex named twice.
        vertex: Vertex,
    },
    /// A polygon with fewer than three corners.
    TooFewCorners {
        /// The face.
        face: Face,
        /// Its number of corners.
        corners: usize,
    },
    /// A face whose area is zero (or so small that its angles mean nothing).
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
    /// More than two faces at an edge.
    NonmanifoldEdge {
        /// The edge.
        edge: Edge,
        /// Its ends.
        vertices: [Vertex; 2],
        /// The number of faces at it.
        faces: usize,
    },
    /// The faces at a vertex form more than one fan.
    NonmanifoldVertex {
        /// The vertex.
        vertex: Vertex,
        /// The number of fans.
        fans: usize,
    },
    /// Two faces run along their common edge in the same direction.
    InconsistentOrientation {
        /// The edge.
        edge: Edge,
        /// Its ends.
        vertices: [Vertex; 2],
    },
    /// Two faces have the same three vertices.
    DuplicateFace {
        /// The later face.
        face: Face,
        /// The first one with these vertices.
        first: Face,
    },
    /// A vertex inside an edge of faces that it does not belong to (a T-junction).
    HangingVertex {
        /// The vertex.
        vertex: Vertex,
        /// The edge.
        edge: Edge,
        /// Its ends.
        vertices: [Vertex; 2],
        /// The distance of the vertex from the edge.
        gap: f64,
    },
    /// A boundary vertex a small gap away from another one that it is not joined to.
    Crack {
        /// The later vertex.
        vertex: Vertex,
        /// The one before it.
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
    /// Two vertices have exactly the same position.
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
                "{face} names vertex {index}, but there are {vertices} vertices (0 to {}); correct the index",
                *vertices as i64 - 1
            ),
            Fault::RepeatedVertex { face, vertex } => {
                write!(f, "{face} names {vertex} twice; remove the face")
            }
            Fault::TooFewCorners { face, corners } => {
                write!(f, "{face} has {corners} corners, 3 are needed; remove the face")
            }
            Fault::ZeroArea { face, area } => write!(f, "{face} has area {area:e}"),
            Fault::UnreferencedVertex { vertex } => write!(f, "{vertex} is used by no face"),
            Fault::NonmanifoldEdge { edge, vertices: [a, b], faces } => {
                write!(f, "{edge} ({a} to {b}) is shared by {faces} faces")
            }
            Fault::NonmanifoldVertex { vertex, fans } => {
                write!(f, "{vertex} joins {fans} fans of faces that share no edge there")
            }
            Fault::InconsistentOrientation { edge, vertices: [a, b] } => {
                write!(f, "the two faces at {edge} ({a} to {b}) are oriented against each other")
            }
            Fault::DuplicateFace { face, first } => write!(f, "{face} has the same vertices as {first}"),
            Fault::HangingVertex { vertex, edge, vertices: [a, b], gap } => {
                write!(f, "{vertex} lies inside {edge} ({a} to {b}), whose faces do not have it")?;
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

/// How many faults an error message spells out before it says how many more there are.
const FAULTS_SHOWN: usize = 5;

/// The first faults, one a line, and the number of the others.
fn list(faults: &[Fault]) -> String {
    let mut text: String = faults.iter().take(FAULTS_SHOWN).map(|x| format!("\n  {x}")).collect();
    if faults.len() > FAULTS_SHOWN {
        text += &format!("\n  and {} more", faults.len() - FAULTS_SHOWN);
    }
    text
}

/// Why no mesh could be made.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MeshError {
    /// All the faults that stand in the way.
    #[error("the mesh is not valid:{}", list(.0))]
    Invalid(Vec<Fault>),
    /// More elements than 32-bit indices can name.
    #[error("{vertices} vertices and {faces} faces are more than 32-bit indices can name; split the mesh")]
    TooLarge {
        /// Number of vertices.
        vertices: usize,
        /// Number of faces.
        faces: usize,
    },
    /// An array does not have one value an element.
    #[error("{found} {what} were given, {expected} are needed")]
    WrongLength {
        /// What the array holds.
        what: &'static str,
        /// The number of values given.
        found: usize,
        /// The number needed.
        expected: usize,
    },
    /// A parameter of a procedural shape or of a damage is out of its range.
    #[error("{name} = {value} is out of range: {bound}")]
    Parameter {
        /// The parameter's name.
        name: &'static str,
        /// The value given.
        value: String,
        /// What is allowed.
        bound: &'static str,
    },
    /// A shape, or a parameter of a shape, that does not exist.
    #[error("there is no {what} called {name:?}; there {}", known_names(.known))]
    UnknownName {
        /// "shape" or "parameter".
        what: &'static str,
        /// The name as given.
        name: String,
        /// Those that exist, the most similar one first.
        known: Vec<&'static str>,
    },
}

/// "is a" or "are a, b, c", to follow "there".
fn known_names(known: &[&str]) -> String {
    match known {
        [] => "are none to choose".to_string(),
        [one] => format!("is {one}"),
        many => format!("are {}", many.join(", ")),
    }
}

/// What is wrong with a curve or a point on a surface.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CurveError {
    /// The fault, with the place where it was found.
    #[error("curve {curve}, node {node}: {fault}")]
    AtNode {
        /// 0-based index of the curve.
        curve: usize,
        /// 0-based index of the node; for a segment, of its first node.
        node: usize,
        /// What is wrong there.
        fault: Box<CurveError>,
    },
    /// The fault, with the isolated point at which it was found.
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
        /// How many vertices there are.
        vertices: usize,
    },
    /// An edge number (of a text format) that the mesh does not have.
    #[error("{kind} {index} does not exist: the mesh has {count}, numbered from 0")]
    ElementOutOfRange {
        /// "edge" or "face".
        kind: &'static str,
        /// The number as given.
        index: i64,
        /// How many there are.
        count: usize,
    },
    /// Two vertices that no edge joins.
    #[error("vertices {} and {} are not joined by an edge; name the ends of an edge, or give positions in space and have them traced", vertices[0], vertices[1])]
    NoSuchEdge {
        /// The vertices as given.
        vertices: [u32; 2],
    },
    /// Three vertices that are not the corners of a face.
    #[error("vertices {}, {} and {} are not the corners of a face", vertices[0], vertices[1], vertices[2])]
    NoSuchFace {
        /// The vertices as given.
        vertices: [u32; 3],
    },
    /// The place on an edge is not between its ends.
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
    /// The same fault, with the curve and node at which it was found.
    pub fn at(self, curve: usize, node: usize) -> CurveError {
        CurveError::AtNode { curve, node, fault: Box::new(self) }
    }
    /// The same fault, with the isolated point at which it was found.
    pub fn at_point(self, point: usize) -> CurveError {
        CurveError::AtPoint { point, fault: Box::new(self) }
    }
}

/// Why a file could not be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FileError {
    /// The operating system said no.
    #[error("{path}: {fault}")]
    Io {
        /// The file.
        path: String,
        /// What it said.
        #[source]
        fault: std::io::Error,
    },
    /// The content does not follow the format.
    #[error("{format}, {place}: {problem}")]
    Syntax {
        /// The format's name ("OBJ").
        format: &'static str,
        /// Where: "line 12", "byte 80", "vertex 17".
        place: String,
        /// What is wrong and what is expected.
        problem: String,
    },
    /// The fault, with the file in which it was found.
    #[error("{path}: {fault}")]
    InFile {
        /// The file.
        path: String,
        /// What is wrong with it.
        fault: Box<FileError>,
    },
    /// The format is not known, or can not hold what is to be written.
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
    /// A [`FileError::Syntax`].
    pub fn syntax(format: &'static str, place: impl Into<String>, problem: impl Into<String>) -> Self {
        FileError::Syntax { format, place: place.into(), problem: problem.into() }
    }
    /// A [`FileError::Io`].
    pub fn io(path: impl AsRef<Path>, fault: std::io::Error) -> Self {
        FileError::Io { path: path.as_ref().display().to_string(), fault }
    }
    /// The same fault, with the file in which it was found (once: a fault that names a file stays
    /// as it is).
    pub fn in_file(self, path: impl AsRef<Path>) -> Self {
        match self {
            FileError::Io { .. } | FileError::InFile { .. } => self,
            fault => FileError::InFile { path: path.as_ref().display().to_string(), fault: Box::new(fault) },
        }
    }
}
