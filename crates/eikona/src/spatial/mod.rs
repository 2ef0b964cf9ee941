//! Spatial queries: a bounding volume hierarchy over the triangles of a mesh, closest points,
//! clusters of points, and continuous collision detection.

mod bvh;
mod close_faces;
mod closest;
mod cluster_tree;
mod collision;
mod intersections;

pub use bvh::Bvh;
pub use closest::{ClosestPoint, closest_point_of_triangle, segment_distance};
pub use cluster_tree::{Cluster, ClusterTree, LEAF_POINTS};
pub use collision::{Contact, SafeMotion, safe_motion, safe_motion_past, self_distance};
pub use intersections::{intersections_with, self_intersections};

pub(crate) use close_faces::{Ball, ClosePairs, close_pairs};
pub(crate) use closest::triangle_distance;
pub(crate) use collision::{contacts, joined};
pub(crate) use intersections::{is_in_tetrahedron, triangles_intersect};
