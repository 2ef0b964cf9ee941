//! Spatial queries: a bounding volume hierarchy over the triangles of a mesh, closest points, and
//! clusters of points.

mod bvh;
mod closest;
mod cluster_tree;

pub use bvh::Bvh;
pub use closest::{ClosestPoint, closest_point_of_triangle};
pub use cluster_tree::{Cluster, ClusterTree, LEAF_POINTS};
