//! Closest point of a triangle.

use crate::geometry::vector::{cross, distance, dot, sub};
use eikona_mesh::{Face, Located, TriangleMesh};

/// Point of a mesh closest to a given point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    /// Face that contains the point; among equally close ones, the one with the lowest id.
    pub face: Face,
    /// Barycentric coordinates in the face, in the order of its corners: nonnegative, with sum 1.
    pub weights: [f64; 3],
    /// Position in space.
    pub position: [f64; 3],
    /// Distance from the given point.
    pub distance: f64,
}

impl ClosestPoint {
    /// Returns the point as a location on the mesh.
    pub fn locate(&self, mesh: &TriangleMesh) -> Located {
        Located::in_face(mesh, self.face, self.weights)
    }
}

/// If twice the area is below this share of the squared longest side, the triangle's plane is
/// unreliable and its sides are tested too.
const SLIVER: f64 = 1e-6;

/// Returns the barycentric coordinates of the point of a triangle (of any shape, including zero
/// area) closest to `p`, its position and its squared distance.
pub fn closest_point_of_triangle(p: [f64; 3], triangle: [[f64; 3]; 3]) -> ([f64; 3], [f64; 3], f64) {
    let [a, b, c] = triangle;
    let (ab, ac, ap) = (sub(b, a), sub(c, a), sub(p, a));
    let normal = cross(ab, ac);
    let normal_sq = dot(normal, normal);
    let longest_sq = dot(ab, ab).max(dot(ac, ac)).max(dot(sub(c, b), sub(c, b)));
    let mut best: Option<([f64; 3], [f64; 3], f64)> = None;
    if normal_sq > 0.0 {
        let wb = dot(cross(ap, ac), normal) / normal_sq;
        let wc = dot(cross(ab, ap), normal) / normal_sq;
        let wa = 1.0 - wb - wc;
        if wa >= 0.0 && wb >= 0.0 && wc >= 0.0 {
            let foot = candidate(p, triangle, [wa, wb, wc]);
            if normal_sq > (SLIVER * longest_sq).powi(2) {
                return foot;
            }
            best = Some(foot);
        }
    }
    for k in 0..3 {
        let (i, j) = (k, (k + 1) % 3);
        let side = sub(triangle[j], triangle[i]);
        let side_sq = dot(side, side);
        let t = dot(sub(p, triangle[i]), side) / side_sq;
        let t = if side_sq > 0.0 && t.is_finite() { t.clamp(0.0, 1.0) } else { 0.0 };
        let mut weights = [0.0; 3];
        weights[i] = 1.0 - t;
        weights[j] = t;
        let foot = candidate(p, triangle, weights);
        if best.is_none_or(|b| foot.2 < b.2) {
            best = Some(foot);
        }
    }
    best.unwrap_or_else(|| candidate(p, triangle, [1.0, 0.0, 0.0]))
}

/// Returns the distance of two segments, of any length, zero included.
pub fn segment_distance([a, b]: [[f64; 3]; 2], [c, d]: [[f64; 3]; 2]) -> f64 {
    let (along, other, between) = (sub(b, a), sub(d, c), sub(a, c));
    let (aa, ab, bb) = (dot(along, along), dot(along, other), dot(other, other));
    let (ra, rb) = (dot(along, between), dot(other, between));
    // The closest points of the lines, if they lie within both segments and are well defined.
    let determinant = aa * bb - ab * ab;
    let mut least = f64::INFINITY;
    if determinant > 0.0 {
        let s = (ab * rb - bb * ra) / determinant;
        let t = (aa * rb - ab * ra) / determinant;
        if (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t) {
            let apart = [0, 1, 2].map(|k| between[k] + s * along[k] - t * other[k]);
            least = dot(apart, apart).sqrt();
        }
    }
    // Otherwise one of them is an end.
    let from_end = |p: [f64; 3], [u, v]: [[f64; 3]; 2]| {
        let side = sub(v, u);
        let side_sq = dot(side, side);
        let t = if side_sq > 0.0 { (dot(sub(p, u), side) / side_sq).clamp(0.0, 1.0) } else { 0.0 };
        distance(p, [0, 1, 2].map(|k| u[k] + t * side[k]))
    };
    let ends = [from_end(a, [c, d]), from_end(b, [c, d]), from_end(c, [a, b]), from_end(d, [a, b])];
    ends.into_iter().fold(least, f64::min)
}

/// Returns the distance of two triangles that do not cross. Of two that do, it returns the distance
/// of their sides and corners.
pub(crate) fn triangle_distance(s: [[f64; 3]; 3], t: [[f64; 3]; 3]) -> f64 {
    let mut least = f64::INFINITY;
    for (points, triangle) in [(s, t), (t, s)] {
        for p in points {
            least = least.min(closest_point_of_triangle(p, triangle).2.sqrt());
        }
    }
    let sides = |[a, b, c]: [[f64; 3]; 3]| [[a, b], [b, c], [c, a]];
    for side in sides(s) {
        for other in sides(t) {
            least = least.min(segment_distance(side, other));
        }
    }
    least
}

fn candidate(p: [f64; 3], [a, b, c]: [[f64; 3]; 3], w: [f64; 3]) -> ([f64; 3], [f64; 3], f64) {
    let foot = [0, 1, 2].map(|k| w[0] * a[k] + w[1] * b[k] + w[2] * c[k]);
    (w, foot, distance(p, foot).powi(2))
}
