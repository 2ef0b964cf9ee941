//! Intrinsic geometry of triangles and meshes: lengths, areas, angles, triangulations.

mod fast_marching;
mod intrinsic;
mod size;
mod triangle;

pub use eikona_mesh::vector;
pub use fast_marching::fast_marching;
pub(crate) use intrinsic::IntrinsicTriangulation;
pub(crate) use size::{face_in, lay_out_in, shape_of_face, unit_of};
pub(crate) use triangle::power_of_two_near;
pub use triangle::{Triangle, lay_out, mean_edge_length};
