//! The weights that Laplacian and Hodge star share.

use crate::geometry::Triangle;
use crate::winding::jump_laplace::cotangents;
use eikona_mesh::TriangleMesh;

/// Half the cotangent opposite each halfedge, kept between these bounds. The Hodge step divides by sums of them, and a
/// Laplacian with negative sums need not be definite. Both operators must have the same weights: otherwise the derivative of
/// the first solve is not co-closed in the second.
const BOUNDS: (f64, f64) = (1e-3, 1e3);

#[derive(Debug)]
pub(crate) struct Weights {
    pub of_halfedge: Vec<f64>,
}

impl Weights {
    pub fn of(triangles: &[Triangle]) -> Weights {
        let bounded = |w: f64| if w.is_nan() { 1.0 } else { w.clamp(BOUNDS.0, BOUNDS.1) };
        Weights { of_halfedge: cotangents(triangles).map(bounded).collect() }
    }

    /// The Hodge star of a halfedge's edge: the sum over both its faces. At edges of one face, or of more than two (where the
    /// surface is cut open), that of the face alone.
    pub fn star(&self, mesh: &TriangleMesh, h: eikona_mesh::Halfedge) -> f64 {
        match mesh.edge_halfedges(mesh.edge(h)) {
            [a, b] => self.of_halfedge[a.index()] + self.of_halfedge[b.index()],
            _ => self.of_halfedge[h.index()],
        }
    }
}
