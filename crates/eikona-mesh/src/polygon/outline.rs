//! A polygon projected along its Newell normal.

use robust::{Coord, orient2d};

/// Twice the area of a triangle counts as zero below this share of its longest edge squared when
/// ears are chosen: corners meant to be collinear are off by rounding.
const FLAT: f64 = 1e-12;

/// Rounding error of the projected coordinates, which are at most 1.
const ROUNDING: f64 = 4e-16;

/// A Newell normal below this length per corner may be rounding error only, if the polygon has
/// size 1.
const NO_NORMAL: f64 = 1e-12;

/// A polygon in the plane of its Newell normal, scaled to size 1. The projection runs along the
/// normal onto a coordinate plane, so it is affine, and exact if the normal is a coordinate axis.
pub(crate) struct Outline {
    /// The corners; counter-clockwise if the polygon encloses area.
    pub points: Vec<[f64; 2]>,
    /// Largest distance of a corner from the plane, relative to the largest extent along an axis.
    pub deviation: f64,
}

impl Outline {
    /// Projects the polygon; `None` if its corners are collinear or not finite.
    pub fn of(corners: &[u32], positions: &[[f64; 3]]) -> Option<Outline> {
        let points = normalised(corners.iter().map(|&v| positions[v as usize]))?;
        let newell = newell_normal(&points);
        let normal = if length(newell) > NO_NORMAL * points.len() as f64 {
            newell
        } else {
            // The areas cancel, as in a bow tie: any triangle of the corners spans the plane.
            let normal = normal_of_largest_triangle(&points)?;
            if dot(normal, newell) < 0.0 { normal.map(|x| -x) } else { normal }
        };
        let [x, y, z] = normal.map(f64::abs);
        let k = if z >= x && z >= y {
            2
        } else if y >= x {
            1
        } else {
            0
        };
        let (i, j) = if normal[k] > 0.0 { ((k + 1) % 3, (k + 2) % 3) } else { ((k + 2) % 3, (k + 1) % 3) };
        let slope = [normal[i] / normal[k], normal[j] / normal[k]];
        let projected = points.iter().map(|p| [p[i] - slope[0] * p[k], p[j] - slope[1] * p[k]]);
        let extent = |of: &dyn Fn(&[f64; 3]) -> f64| {
            let (low, high) = points
                .iter()
                .map(of)
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)));
            high - low
        };
        let size = extent(&|p| p[0]).max(extent(&|p| p[1])).max(extent(&|p| p[2]));
        let thickness = extent(&|p| dot(*p, normal) / length(normal));
        Some(Outline { deviation: thickness / 2.0 / size, points: projected.collect() })
    }

    /// Returns whether the fan of triangles from a corner covers the polygon without folding over,
    /// with no triangle of zero area.
    pub fn is_star_shaped_from(&self, corner: usize) -> bool {
        let n = self.points.len();
        let at = |k: usize| self.points[(corner + k) % n];
        let mut behind = false;
        for k in 1..n - 1 {
            if Shape::of([at(0), at(k), at(k + 1)]).is_flat() {
                return false;
            }
            // Once behind the first edge, a fan that comes around to its front overlaps itself.
            let in_front = cross(at(0), at(1), at(k + 1)) >= 0.0;
            if behind && in_front {
                return false;
            }
            behind |= !in_front;
        }
        true
    }

    /// Returns whether a corner turns right by an angle with a sine above `sine`.
    pub fn has_reflex_corner(&self, sine: f64) -> bool {
        let n = self.points.len();
        (0..n).any(|k| {
            let [a, b, c] = [k, k + 1, k + 2].map(|k| self.points[k % n]);
            cross(a, b, c) < -sine * (squared(a, b) * squared(b, c)).sqrt()
        })
    }
}

/// Area and longest edge of a triangle.
#[derive(Clone, Copy)]
pub(crate) struct Shape {
    /// Twice the area; negative for clockwise triangles.
    pub doubled_area: f64,
    /// Square of the longest edge.
    pub longest_squared: f64,
}

impl Shape {
    pub fn of([a, b, c]: [[f64; 2]; 3]) -> Shape {
        let longest_squared = squared(a, b).max(squared(b, c)).max(squared(c, a));
        Shape { doubled_area: cross(a, b, c), longest_squared }
    }
    /// Returns whether the triangle is clockwise or its area may be rounding error.
    pub fn is_flat(&self) -> bool {
        self.doubled_area <= tolerance(self.longest_squared)
    }
    /// Returns a scale-invariant quality: positive for counter-clockwise triangles, largest for
    /// equilateral ones.
    pub fn quality(&self) -> f64 {
        if self.longest_squared > 0.0 { self.doubled_area / self.longest_squared } else { 0.0 }
    }
}

/// Returns how far [`cross`] may be from zero for points meant to be collinear, given their squared
/// distance.
pub(crate) fn tolerance(squared: f64) -> f64 {
    FLAT * squared + ROUNDING * squared.sqrt()
}

/// Returns twice the signed area of a triangle, rounded.
pub(crate) fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Returns twice the signed area of a triangle, with the exact sign.
pub(crate) fn exact_side(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    let [a, b, c] = [a, b, c].map(|[x, y]| Coord { x, y });
    orient2d(a, b, c)
}

pub(crate) fn squared(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).powi(2) + (b[1] - a[1]).powi(2)
}

/// Returns the corners relative to the first one, in a unit that makes the largest coordinate
/// about 1. `None` if they coincide or are not finite. Units are powers of two, so that rounding
/// does not depend on the scale and differences of nearby coordinates stay exact.
fn normalised(corners: impl Iterator<Item = [f64; 3]>) -> Option<Vec<[f64; 3]>> {
    let mut points: Vec<[f64; 3]> = corners.collect();
    rescale(&mut points)?;
    let origin = *points.first()?;
    points.iter_mut().for_each(|p| *p = sub(*p, origin));
    rescale(&mut points)?;
    Some(points)
}

/// Divides by a power of two so that the largest coordinate is in [1/4, 1].
fn rescale(points: &mut [[f64; 3]]) -> Option<()> {
    let largest = points.iter().flatten().fold(0.0f64, |m, x| if x.is_nan() { *x } else { m.max(x.abs()) });
    if !(largest > 0.0 && points.iter().flatten().all(|x| x.is_finite())) {
        return None;
    }
    // Two factors, since one may be out of range.
    let exponent = -(largest.log2().ceil() as i32);
    let factors = [exponent / 2, exponent - exponent / 2].map(|e| 2.0f64.powi(e));
    points.iter_mut().flatten().for_each(|x| *x = *x * factors[0] * factors[1]);
    Some(())
}

/// Returns twice the area vector of the polygon.
fn newell_normal(points: &[[f64; 3]]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (k, &p) in points.iter().enumerate() {
        let vector = cross3(p, points[(k + 1) % points.len()]);
        (0..3).for_each(|i| sum[i] += vector[i]);
    }
    sum
}

/// Returns `None` if all points are collinear.
fn normal_of_largest_triangle(points: &[[f64; 3]]) -> Option<[f64; 3]> {
    let origin = *points.first()?;
    let arms = || points.iter().map(|&p| sub(p, origin));
    let far = arms().max_by(|a, b| length(*a).total_cmp(&length(*b)))?;
    let normal = arms().map(|arm| cross3(far, arm)).max_by(|a, b| length(*a).total_cmp(&length(*b)))?;
    (length(normal) > NO_NORMAL).then_some(normal)
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross3(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}
