//! Values at corners: facewise integrals of closed 1-forms, and their jumps across edges.

use eikona_mesh::{Halfedge, TriangleMesh};

/// Returns the index of the corner at the tip of a halfedge, in its face. (The corner at its origin
/// has the index of the halfedge.)
pub(crate) fn tip_corner(h: Halfedge) -> usize {
    h.next().index()
}

/// Integrates a closed 1-form on halfedges within each face, from zero at its first corner.
pub(crate) fn integrated_in_faces(form: &[f64]) -> Vec<f64> {
    form.chunks_exact(3).flat_map(|sides| [0.0, sides[0], sides[0] + sides[1]]).collect()
}

/// Returns, per edge of two faces, the value in the first face minus that in the second, at the
/// origin of the first halfedge; 0 at other edges.
pub(crate) fn jumps_of(mesh: &TriangleMesh, values: &[f64]) -> Vec<f64> {
    mesh.edges()
        .map(|e| match mesh.edge_halfedges(e) {
            &[a, b] => {
                let other = if mesh.origin(b) == mesh.origin(a) { b.index() } else { tip_corner(b) };
                values[a.index()] - values[other]
            }
            _ => 0.0,
        })
        .collect()
}
