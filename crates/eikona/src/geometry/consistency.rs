//! Whether faces are wound alike.

use eikona_mesh::TriangleMesh;

/// Whether every edge has at most two faces, which run along it in opposite directions.
pub(crate) fn winding_is_consistent(mesh: &TriangleMesh) -> bool {
    mesh.edges().all(|e| match mesh.edge_halfedges(e) {
        [_] => true,
        &[a, b] => mesh.origin(a) != mesh.origin(b),
        _ => false,
    })
}
