//! What a domain *is*: triangle meshes with typed ids and fields over their elements, connectivity that is honest about
//! nonmanifold edges, points and curves on surfaces, validation, procedural shapes, and file formats. No matrices here.
//!
//! Indices are 0-based everywhere but in OBJ files. Faces are counter-clockwise. Order and count of vertices and faces are
//! those of the input; every repair is a named step that returns index maps.

mod curve;
mod error;
mod field;
mod id;
pub mod io;
mod mesh;
mod point;
mod polygon;

pub use curve::{Curve, CurveKind, Segment, SegmentHost, SurfaceCurves, segment_host};
pub use error::{CurveError, Fault, FileError, MeshError};
pub use field::{CornerField, EdgeField, FaceField, Field, HalfedgeField, VertexField};
pub use id::{Corner, Edge, ElementId, Face, Halfedge, Vertex};
pub use mesh::{Neighbour, TriangleMesh};
pub use point::{BARYCENTRIC_TOLERANCE, Located, SNAP_TOLERANCE, SurfacePoint};
pub use polygon::PolygonMesh;
