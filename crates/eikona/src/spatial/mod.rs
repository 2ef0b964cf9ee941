//! Queries in space: a tree of boxes over the triangles of a mesh, and the point of the mesh
//! nearest to a given one.

mod bvh;
mod closest;

pub use bvh::Bvh;
pub use closest::{ClosestPoint, closest_point_of_triangle};
