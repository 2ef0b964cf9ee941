//! Layout of a single triangle in its own plane, from intrinsic data.

use crate::geometry::vector::{cross, distance, dot, norm, sub};
use eikona_mesh::{Face, TriangleMesh};
use eikona_numeric::Complex;

/// Triangle in the complex plane, counter-clockwise, with corner 0 at the origin and corner 1 on
/// the positive real axis.
///
/// It depends on edge lengths only, so it is invariant under isometric bending of the surface;
/// corner positions, if given, only improve the accuracy.
///
/// A flat triangle (with a height below 1e-8 of its longest side) is mollified: sides are
/// lengthened to at least 1e-7 of the longest, then all by 1e-14 of it. The triangle then has
/// angles, and no length changes by more than 1e-7 of the longest side. (After Sharp and Crane
/// 2020, section 4.5, who use one amount for the whole mesh.)
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// Length of each side; side `k` runs from corner `k` to corner `k + 1`.
    pub lengths: [f64; 3],
    /// Cosine and sine of the angle at each corner, as `cos + i sin`.
    pub angles: [Complex; 3],
    /// Area.
    pub area: f64,
    /// Whether the triangle was mollified: its sides were lengthened.
    pub mollified: bool,
}

/// Triangles with a smaller height, relative to the longest side, are mollified.
const FLAT: f64 = 1e-8;
/// Minimum length of the sides of a flat triangle, and the length then added to each, relative to
/// the longest side.
const SHORTEST_SIDE: f64 = 1e-7;
const SLACK: f64 = 1e-14;

impl Triangle {
    /// Lays out a face of a mesh.
    pub fn of_face(mesh: &TriangleMesh, face: Face) -> Triangle {
        Triangle::of_corners(mesh.face_positions(face))
    }

    /// Lays out the triangle with these corners. Angles come from products of edge vectors: for a
    /// face of height `h` (relative to its longest side) their error is 1e-16 / h, compared with
    /// 1e-16 / h^2 from lengths.
    pub(crate) fn of_corners([a, b, c]: [[f64; 3]; 3]) -> Triangle {
        let lengths = [distance(a, b), distance(b, c), distance(c, a)];
        let longest = (0..3).fold(0, |l, k| if lengths[k] > lengths[l] { k } else { l });
        let unit = power_of_two_near(lengths[longest]);
        let sides = [sub(b, a), sub(c, b), sub(a, c)].map(|side| side.map(|x| x / unit));
        // The product of the two shorter sides has the smallest rounding error.
        let sin = norm(cross(sides[(longest + 1) % 3], sides[(longest + 2) % 3]));
        let area = 0.5 * sin * unit * unit;
        if !is_solid(&lengths, area) {
            return Triangle::mollified(lengths);
        }
        let angles = [0, 1, 2].map(|k| unit_complex(-dot(sides[k], sides[(k + 2) % 3]), sin));
        Triangle { lengths, angles, area, mollified: false }
    }

    /// Lays out the triangle with these side lengths. Lengths that violate the triangle inequality
    /// are mollified.
    pub fn from_lengths(lengths: [f64; 3]) -> Triangle {
        let area = area_from_lengths(lengths);
        if is_solid(&lengths, area) {
            Triangle { lengths, angles: angles_from_lengths(lengths, area), area, mollified: false }
        } else {
            Triangle::mollified(lengths)
        }
    }

    fn mollified(lengths: [f64; 3]) -> Triangle {
        let longest = lengths.iter().fold(0.0f64, |m, &l| m.max(l));
        let unit = if longest > 0.0 { longest } else { 1e-60 };
        let lengths = lengths.map(|l| l.max(SHORTEST_SIDE * unit));
        let slack = |k: usize| lengths[(k + 1) % 3] + lengths[(k + 2) % 3] - lengths[k];
        let add = SLACK * unit - slack(0).min(slack(1)).min(slack(2)).min(0.0);
        let lengths = lengths.map(|l| l + add);
        let area = area_from_lengths(lengths);
        Triangle { lengths, angles: angles_from_lengths(lengths, area), area, mollified: true }
    }

    /// Returns the unit vector along each side.
    #[inline]
    pub fn directions(&self) -> [Complex; 3] {
        // From side k to side k + 1 the direction turns by pi - angle.
        let turn = |angle: Complex| Complex { re: -angle.re, im: angle.im };
        let second = turn(self.angles[1]);
        [Complex { re: 1.0, im: 0.0 }, second, second * turn(self.angles[2])]
    }

    /// Returns the corners.
    #[inline]
    pub fn corners(&self) -> [Complex; 3] {
        let zero = Complex { re: 0.0, im: 0.0 };
        [zero, Complex { re: self.lengths[0], im: 0.0 }, self.angles[0] * self.lengths[2]]
    }

    /// Returns the cotangent of the angle at a corner.
    #[inline]
    pub fn cotangent(&self, corner: usize) -> f64 {
        self.angles[corner].re / self.angles[corner].im
    }

    /// Returns the point with these barycentric coordinates.
    #[inline]
    pub fn point(&self, weights: [f64; 3]) -> Complex {
        let [_, b, c] = self.corners();
        b * weights[1] + c * weights[2]
    }
}

/// Lays out all faces of a mesh.
pub fn lay_out(mesh: &TriangleMesh) -> Vec<Triangle> {
    mesh.faces().map(|f| Triangle::of_face(mesh, f)).collect()
}

/// Returns the mean edge length of a mesh, with each edge counted once, from the layouts of its
/// faces; zero without edges.
pub fn mean_edge_length(mesh: &TriangleMesh, triangles: &[Triangle]) -> f64 {
    let length = |e| {
        let h = mesh.edge_halfedges(e)[0];
        triangles[h.face().index()].lengths[h.side()]
    };
    mesh.edges().map(length).sum::<f64>() / mesh.edge_count().max(1) as f64
}

/// Returns whether a triangle is high enough for its angles to be used; false if the area is NaN.
fn is_solid(lengths: &[f64; 3], area: f64) -> bool {
    let longest = lengths.iter().fold(0.0f64, |m, &l| m.max(l));
    2.0 * area >= FLAT * longest * longest && area > 0.0
}

fn angles_from_lengths(lengths: [f64; 3], area: f64) -> [Complex; 3] {
    [0, 1, 2].map(|k| {
        // Between side k and side k - 1, opposite side k + 1.
        let (b, c, a) = (lengths[k], lengths[(k + 2) % 3], lengths[(k + 1) % 3]);
        unit_complex(((b - a) * (b + a) + c * c) / (2.0 * b * c), 2.0 * area / (b * c))
    })
}

fn unit_complex(re: f64, im: f64) -> Complex {
    let norm = (re * re + im * im).sqrt();
    Complex { re: re / norm, im: im / norm }
}

/// Heron's formula in Kahan's arrangement, accurate for slivers.
fn area_from_lengths(lengths: [f64; 3]) -> f64 {
    let mut l = lengths;
    l.sort_by(|x, y| y.total_cmp(x));
    // A product of four lengths overflows or underflows long before a length does.
    let unit = power_of_two_near(l[0]);
    let [a, b, c] = l.map(|x| x / unit);
    let product = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c));
    0.25 * product.max(0.0).sqrt() * unit * unit
}

/// Returns the power of two at or below a positive length, by which lengths can be divided without
/// rounding; 1 if there is none.
pub(crate) fn power_of_two_near(length: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff0_0000_0000_0000;
    let power = f64::from_bits(length.to_bits() & EXPONENT);
    if power.is_normal() { power } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_triangle() {
        let t = Triangle::from_lengths([3.0, 4.0, 5.0]);
        assert!((t.area - 6.0).abs() < 1e-14);
        assert!(t.angles[1].re.abs() < 1e-15, "right angle at corner 1");
        assert!((t.cotangent(0) - 3.0 / 4.0).abs() < 1e-14);
        assert!((t.corners()[2] - Complex { re: 3.0, im: 4.0 }).norm() < 1e-14);
        for k in 0..3 {
            let side = t.corners()[(k + 1) % 3] - t.corners()[k];
            assert!((side - t.directions()[k] * t.lengths[k]).norm() < 1e-14);
        }
    }

    #[test]
    fn flat_triangles_get_angles() {
        for lengths in [[1.0, 1.0, 2.0], [0.0, 1.0, 1.0], [0.0, 0.0, 0.0], [1.0, 1.0, 2.5]] {
            let t = Triangle::from_lengths(lengths);
            assert!(t.mollified && t.area > 0.0, "{lengths:?}");
            assert!((0..3).all(|k| t.cotangent(k).is_finite() && t.angles[k].im > 0.0), "{lengths:?} {t:?}");
        }
    }

    #[test]
    fn scale_does_not_matter() {
        // The last scales were found by fuzzing: their fourth powers overflow and underflow.
        for scale in [1e-8, 1e8, 1e-100, 1e100] {
            let t = Triangle::from_lengths([3.0 * scale, 4.0 * scale, 5.0 * scale]);
            assert!((t.area / (scale * scale) - 6.0).abs() < 1e-13);
            assert!((t.cotangent(2) - 4.0 / 3.0).abs() < 1e-13);
        }
    }
}
