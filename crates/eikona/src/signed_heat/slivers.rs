//! What thin faces cost: lengths that had to be perturbed, and digits that rounding takes.

use crate::geometry::Triangle;
use crate::wording::counted;
use eikona_mesh::{DisjointSets, Face, TriangleMesh};

/// Edges of at least this cotangent weight hold their ends together: their faces are lower than about 1e-4 of their longest side.
const STIFF: f64 = 1e4;

/// Share of the rounding unit by which the sum of a vertex's weights is off, as a rule. Measured on strips of 40 columns
/// and one or two rows, 3e-6 to 1e-8 wide: the errors are 0.3 to 9 times those estimated.
const ROUNDING: f64 = 0.1 * f64::EPSILON;

/// Errors below this share of the extent are not worth a warning.
const NOTICED: f64 = 1e-6;

/// Adds warnings of degenerate faces, and of regions of slivers in which distances lose digits.
pub(super) fn note_slivers(mesh: &TriangleMesh, triangles: &[Triangle], warnings: &mut Vec<String>) {
    let mollified = triangles.iter().filter(|t| t.mollified).count();
    if let Some(first) = triangles.iter().position(|t| t.mollified) {
        warnings.push(format!(
            "{} (first: {first}); edge lengths were perturbed by at most 1e-7 of the longest edge of each",
            counted(mollified, "degenerate face", "degenerate faces")
        ));
    }
    if let Some(Loss { share, faces, first }) = loss_of_digits(mesh, triangles) {
        warnings.push(format!(
            "{} (first: {}): distances along these faces may be off by about {share:.0e} of their length by rounding; remesh \
             with better shaped faces",
            counted(faces, "sliver", "slivers"),
            first.0
        ));
    }
}

/// See [`loss_of_digits`].
struct Loss {
    /// The estimate of the relative error where it is largest.
    share: f64,
    /// Number of faces where it is noticed.
    faces: usize,
    first: Face,
}

/// How many digits are lost where whole regions consist of slivers; `None` if it is not noticed.
///
/// The diagonal of the Laplacian is rounded relative to the sum of all weights at a vertex. Vertices that stiff edges hold together
/// move as one, and what moves them are the weights of the other edges at them, so the rounding counts relative to those. A few
/// slivers in a good mesh lose as many digits as their weights have; a region of slivers of height `h` loses `h^-2`, since the
/// other weights are as small as `h`.
fn loss_of_digits(mesh: &TriangleMesh, triangles: &[Triangle]) -> Option<Loss> {
    let weight = |e| {
        let halfedges = mesh.edge_halfedges(e).iter();
        let weights = halfedges.map(|h| 0.5 * triangles[h.face().index()].cotangent((h.side() + 2) % 3));
        weights.sum::<f64>().abs()
    };
    let weights: Vec<f64> = mesh.edges().map(weight).collect();
    if weights.iter().all(|w| *w < STIFF) {
        return None;
    }
    let mut sets = DisjointSets::new(mesh.vertex_count());
    for e in mesh.edges().filter(|e| weights[e.index()] >= STIFF) {
        let [a, b] = mesh.edge_vertices(e);
        sets.join(a.0, b.0);
    }
    let (group, count) = sets.numbers();
    let (mut stiff, mut loose) = (vec![0.0; count], vec![0.0; count]);
    for e in mesh.edges() {
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
            weights[e.index()] >= STIFF && shares[group[a.index()] as usize] > NOTICED
        })
    };
    let faces = mesh.faces().filter(is_stiff).count();
    let first = mesh.faces().find(is_stiff)?;
    Some(Loss { share: shares.iter().fold(0.0, |m, s| m.max(*s)), faces, first })
}
