//! Spatial queries: a bounding volume hierarchy over the triangles of a mesh, and closest points.

mod bvh;
mod closest;

pub use bvh::Bvh;
pub use closest::{ClosestPoint, closest_point_of_triangle};
