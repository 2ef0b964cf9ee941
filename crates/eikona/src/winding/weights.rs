//! The weights that Laplacian and Hodge star share.

use crate::geometry::Triangle;
use eikona_mesh::{Halfedge, TriangleMesh};

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
        let of_face = |t: &Triangle| [0, 1, 2].map(|k| bounded(0.5 * t.cotangent((k + 2) % 3)));
        Weights { of_halfedge: triangles.iter().flat_map(of_face).collect() }
    }

    /// The Hodge star of a halfedge's edge: the sum over both its faces. At edges of one face, or of more than two (where the
    /// surface is cut open), that of the face alone.
    pub fn star(&self, mesh: &TriangleMesh, h: Halfedge) -> f64 {
        match mesh.edge_halfedges(mesh.edge(h)) {
            [a, b] => self.of_halfedge[a.index()] + self.of_halfedge[b.index()],
            _ => self.of_halfedge[h.index()],
        }
    }
}
