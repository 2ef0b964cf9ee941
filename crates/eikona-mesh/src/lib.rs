//! Triangle meshes with typed ids and fields over their elements, connectivity that represents
//! nonmanifold edges explicitly, points and curves on surfaces, validation and repair, procedural
//! shapes, and file formats. This crate knows no matrices.
//!
//! Indices are 0-based everywhere but in OBJ files. Faces are counter-clockwise. Vertices and faces
//! keep the order and count of the input; every repair is an explicit function that returns the
//! [`Provenance`] of its result.

mod curve;
mod curve_io;
pub mod damage;
mod duplicates;
mod error;
mod fan;
mod field;
mod id;
pub mod io;
mod mesh;
mod near;
mod orientation;
mod point;
mod polygon;
mod provenance;
mod quality;
pub mod random;
mod repair;
mod seams;
pub mod shapes;
mod slivers;
mod stitch;
mod topology;
mod union_find;
mod validate;
pub mod vector;
mod warning;
mod wording;

pub use curve::{Curve, CurveKind, Segment, SegmentHost, SurfaceCurves, segment_host};
pub use curve_io::{
    CurveFile, CurveFormat, SpacePolyline, curve_text, curves_from_lines, format_curves, read_curves,
    read_curves_bytes, write_curves, write_curves_json,
};
pub use error::{CurveError, Fault, FileError, MeshError};
pub use fan::{Crossing, VertexFan};
pub use field::{CornerField, EdgeField, FaceField, Field, HalfedgeField, VertexField};
pub use id::{Corner, Edge, ElementId, Face, Halfedge, Vertex};
pub use mesh::{Neighbour, TriangleMesh};
pub use orientation::{Orientation, Patch};
pub use point::{BARYCENTRIC_TOLERANCE, Located, SNAP_TOLERANCE, SurfacePoint};
pub use polygon::{NONPLANAR, PolygonMesh, PolygonQuality};
pub use provenance::Provenance;
pub use quality::{Quality, Range, ZERO_AREA};
pub use repair::{
    Repaired, RepairedPolygons, drop_broken_polygons, drop_degenerate_faces, drop_duplicate_faces,
    drop_unreferenced_vertices, orient, split_nonmanifold_vertices, weld, weld_polygons,
};
pub use seams::{HangingVertex, Joint, SEAM_TOLERANCE, Seams};
pub use slivers::{SLIVER, Sliver, slivers};
pub use stitch::{Stitched, stitch};
pub use topology::{BoundaryLoop, Component, Components, NonmanifoldVertex, Topology};
pub use union_find::UnionFind;
pub use validate::validate;
pub use warning::FileWarning;
pub use wording::{counted, round_step};
