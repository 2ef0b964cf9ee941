//! Warnings about thin faces: perturbed edge lengths, and digits lost to rounding.

use crate::Warning;
use crate::geometry::Triangle;
use eikona_mesh::{ElementId, Face, TriangleMesh, UnionFind};
use eikona_numeric::{NumericError, check_step};

/// Edges with at least this cotangent weight are stiff: they keep the values at their ends
/// together. Their faces have a height below about 1e-3 of their longest side.
const STIFF: f64 = 1e3;

/// Error of the sum of a vertex's weights, in relative terms. Measured on strips of 40 columns and
/// one or two rows; with many rows the errors are up to a thousand times larger.
const ROUNDING: f64 = 0.1 * f64::EPSILON;

/// Estimated errors below this share of the extent need no refinement.
const NEGLIGIBLE: f64 = 1e-13;

/// Remaining errors above this share of the largest distance raise a warning.
const WARN_ABOVE: f64 = 1e-6;

/// Returns a warning if faces are degenerate.
pub(super) fn degenerate_faces(triangles: &[Triangle]) -> Option<Warning> {
    let first = Face::from_index(triangles.iter().position(|t| t.mollified)?);
    let count = triangles.iter().filter(|t| t.mollified).count();
    Some(Warning::DegenerateFaces { count, first })
}

/// Regions of slivers, on which the assembled Laplacian loses digits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slivers {
    count: usize,
    first: Face,
}

impl Slivers {
    /// Returns a warning if refinement left an error that matters; `None` otherwise.
    pub fn warning(&self, correction: f64, largest: f64) -> Option<Warning> {
        let &Slivers { count, first } = self;
        (correction > WARN_ABOVE * largest).then_some(Warning::SliverErrors {
            count,
            first,
            error: correction,
        })
    }

    /// Finds the regions of slivers of a mesh; `None` where no digits are lost.
    ///
    /// The diagonal of the Laplacian is rounded relative to the sum of all weights at a vertex.
    /// Vertices connected by stiff edges move as one. The weights of their other edges determine
    /// that common motion, so the rounding error counts relative to those. A few slivers in a good
    /// mesh lose as many digits as their weights have; a region of slivers of height `h` loses
    /// `h^-2`, since the other weights are as small as `h`.
    pub fn of(mesh: &TriangleMesh, triangles: &[Triangle]) -> Result<Option<Slivers>, NumericError> {
        let weight = |e| {
            let halfedges = mesh.edge_halfedges(e).iter();
            let weights = halfedges.map(|h| 0.5 * triangles[h.face().index()].cotangent((h.side() + 2) % 3));
            weights.sum::<f64>().abs()
        };
        let mut weights = Vec::with_capacity(mesh.edge_count());
        for e in mesh.edges() {
            check_step(e.index())?;
            weights.push(weight(e));
        }
        if weights.iter().all(|w| *w < STIFF) {
            return Ok(None);
        }
        let mut sets = UnionFind::new(mesh.vertex_count());
        for e in mesh.edges().filter(|e| weights[e.index()] >= STIFF) {
            let [a, b] = mesh.edge_vertices(e);
            sets.join(a.0, b.0);
        }
        let (group, count) = sets.numbers();
        let (mut stiff, mut loose) = (vec![0.0; count], vec![0.0; count]);
        for e in mesh.edges() {
            check_step(e.index())?;
            let [a, b] = mesh.edge_vertices(e).map(|v| group[v.index()] as usize);
            if a == b {
                stiff[a] += weights[e.index()];
            } else {
                loose[a] += weights[e.index()];
                loose[b] += weights[e.index()];
            }
        }
        let share = |g: usize| if loose[g] > 0.0 { (ROUNDING * stiff[g] / loose[g]).min(1.0) } else { 0.0 };
        let shares: Vec<f64> = (0..count).map(share).collect();
        let is_stiff = |f: &Face| {
            let edges = mesh.face_edges(*f);
            edges.into_iter().any(|e| {
                let [a, _] = mesh.edge_vertices(e);
                weights[e.index()] >= STIFF && shares[group[a.index()] as usize] > NEGLIGIBLE
            })
        };
        let count = mesh.faces().filter(is_stiff).count();
        Ok(mesh.faces().find(is_stiff).map(|first| Slivers { count, first }))
    }
}
