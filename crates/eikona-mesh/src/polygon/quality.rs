//! Convexity and planarity of polygons.

use super::PolygonMesh;
use super::crossing::crosses_itself;
use super::cut::without_dead_ends;
use super::ears;
use super::outline::{Outline, cross};
use crate::id::Face;

/// A polygon is nonplanar if a corner is farther than this from its plane, relative to its largest
/// extent along an axis. Coordinates with six digits stay below it.
pub const NONPLANAR: f64 = 1e-5;

/// A corner is reflex if the sine of its right turn is above this.
const REFLEX: f64 = 1e-6;

/// Relative excess of the total area of the triangles over the area of the polygon that indicates
/// an overlap.
const OVERLAP: f64 = 1e-9;

/// Polygons that are nonconvex, nonplanar, self-intersecting or collinear. All lists are in
/// increasing order and contain no triangles.
///
/// The plane of a polygon is perpendicular to its area vector (Newell normal), halfway between its
/// outermost corners.
///
/// ```
/// use eikona_mesh::{Face, PolygonMesh, PolygonQuality};
/// let corners = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.5], [0., 1., 0.]];
/// let mut mesh = PolygonMesh::new(corners.to_vec());
/// mesh.push_face([0, 1, 2, 3]);
/// let quality = PolygonQuality::of(&mesh);
/// assert_eq!(quality.nonplanar, [Face(0)]);
/// assert!(quality.nonconvex.is_empty() && quality.self_crossing.is_empty());
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolygonQuality {
    /// Polygons with a reflex corner.
    pub nonconvex: Vec<Face>,
    /// Polygons with a corner farther from their plane than [`NONPLANAR`] times their size.
    pub nonplanar: Vec<Face>,
    /// The largest distance of a corner from the plane of its polygon, relative to the polygon's
    /// largest extent along an axis.
    pub largest_deviation: f64,
    /// Polygons whose projection onto their plane crosses itself, such as bow ties: their triangles
    /// overlap. Among thousands of long edges close together, a crossing may be missed.
    pub self_crossing: Vec<Face>,
    /// Polygons with more than three corners, all collinear.
    pub collinear: Vec<Face>,
}

impl PolygonQuality {
    /// Examines all polygons with four or more corners that can be triangulated.
    ///
    /// # Cost
    /// As for [`PolygonMesh::triangulate`].
    pub fn of(mesh: &PolygonMesh) -> PolygonQuality {
        let mut quality = PolygonQuality::default();
        for (f, corners) in mesh.faces().enumerate() {
            let face = Face(f as u32);
            let n = corners.len();
            let broken = (0..n).any(|k| corners[k] == corners[(k + 1) % n])
                || corners.iter().any(|&v| v as usize >= mesh.vertex_count());
            if n < 4 || broken {
                continue;
            }
            let corners = &*without_dead_ends(corners);
            if corners.len() < 3 {
                continue;
            }
            let Some(outline) = Outline::of(corners, &mesh.positions) else {
                quality.collinear.push(face);
                continue;
            };
            quality.largest_deviation = quality.largest_deviation.max(outline.deviation);
            if outline.deviation > NONPLANAR {
                quality.nonplanar.push(face);
            }
            if outline.has_reflex_corner(REFLEX) {
                quality.nonconvex.push(face);
            }
            if !outline.is_star_shaped_from(0) && overlaps_itself(&outline.points, corners) {
                quality.self_crossing.push(face);
            }
        }
        quality
    }
}

/// Returns whether edges cross, or the polygon flips over at a vertex that it visits twice.
fn overlaps_itself(points: &[[f64; 2]], corners: &[u32]) -> bool {
    let n = corners.len();
    if crosses_itself(points) {
        return true;
    }
    let mut triangles = Vec::with_capacity(n - 2);
    ears::triangulate(points, corners, &mut triangles);
    let area: f64 = (1..n - 1).map(|k| cross(points[0], points[k], points[k + 1])).sum();
    ears::doubled_area(points, &triangles) > area * (1.0 + OVERLAP) + OVERLAP
}
