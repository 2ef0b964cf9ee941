//! Rasteriser: clipping, integer edge functions with the top-left rule, depth test.

use crate::camera::{NEAR, Projected};
use eikona_mesh::vector::Vec3;

/// Marks the absence of a face.
pub(crate) const NONE: u32 = u32::MAX;

/// Visibility buffer: the nearest face at each sample and its depth key. Larger keys are nearer.
pub(crate) struct Visibility {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) face: Vec<u32>,
    pub(crate) key: Vec<f32>,
}

/// Subsample resolution to which corners are rounded, so that adjacent faces meet without gap or
/// overlap.
const SUBSAMPLE: f64 = 256.0;
/// Guard band in samples around the image at which faces are clipped, which keeps products of
/// coordinates within 63 bits.
const GUARD: f64 = 4096.0;

impl Visibility {
    pub(crate) fn new(width: usize, height: usize) -> Visibility {
        let count = width * height;
        Visibility { width, height, face: vec![NONE; count], key: vec![f32::NEG_INFINITY; count] }
    }

    /// Rasterises all faces. At equal depth, the first face wins.
    pub(crate) fn draw(&mut self, vertices: &[Projected], triangles: &[[u32; 3]], perspective: bool) {
        let mut polygon = Vec::with_capacity(10);
        let mut spare = Vec::with_capacity(10);
        for (f, t) in triangles.iter().enumerate() {
            polygon.clear();
            polygon.extend(t.map(|v| vertices[v as usize]));
            if !self.is_inside(&polygon) {
                self.clip(&mut polygon, &mut spare);
            }
            if polygon.len() < 3 {
                continue;
            }
            let flat = |p: &Projected| {
                let key = if perspective { 1.0 / p.depth } else { -p.depth };
                Corner {
                    x: (p.h[0] / p.h[2] * SUBSAMPLE).round() as i64,
                    y: (p.h[1] / p.h[2] * SUBSAMPLE).round() as i64,
                    key,
                }
            };
            let first = flat(&polygon[0]);
            let mut previous = flat(&polygon[1]);
            for p in &polygon[2..] {
                let next = flat(p);
                self.fill([first, previous, next], f as u32);
                previous = next;
            }
        }
    }

    fn planes(&self) -> [(Vec3, f64, f64); 5] {
        // Coefficients of (X, Y, W) and of depth, and a constant: points with a nonnegative sum are
        // kept.
        let (w, h) = (self.width as f64 + GUARD, self.height as f64 + GUARD);
        [
            ([0.0, 0.0, 0.0], 1.0, -NEAR),
            ([1.0, 0.0, GUARD], 0.0, 0.0),
            ([-1.0, 0.0, w], 0.0, 0.0),
            ([0.0, 1.0, GUARD], 0.0, 0.0),
            ([0.0, -1.0, h], 0.0, 0.0),
        ]
    }

    fn is_inside(&self, polygon: &[Projected]) -> bool {
        let planes = self.planes();
        polygon.iter().all(|p| planes.iter().all(|plane| side(plane, p) >= 0.0))
    }

    /// Clips a polygon by Sutherland-Hodgman.
    fn clip(&self, polygon: &mut Vec<Projected>, spare: &mut Vec<Projected>) {
        for plane in &self.planes() {
            spare.clear();
            for (i, b) in polygon.iter().enumerate() {
                let a = &polygon[(i + polygon.len() - 1) % polygon.len()];
                let (da, db) = (side(plane, a), side(plane, b));
                if (da >= 0.0) != (db >= 0.0) {
                    let t = da / (da - db);
                    let between = |x: f64, y: f64| x + t * (y - x);
                    let mut depth = between(a.depth, b.depth);
                    let mut h = [0, 1, 2].map(|k| between(a.h[k], b.h[k]));
                    if plane.1 != 0.0 && h[2] < NEAR {
                        // Rounding must not put the point behind the near plane.
                        (depth, h[2]) = (NEAR, NEAR);
                    }
                    spare.push(Projected { h, depth });
                }
                if db >= 0.0 {
                    spare.push(*b);
                }
            }
            std::mem::swap(polygon, spare);
        }
    }

    fn fill(&mut self, [a, mut b, mut c]: [Corner; 3], face: u32) {
        let mut area = cross(a, b, c);
        if area == 0 {
            return;
        }
        if area < 0 {
            std::mem::swap(&mut b, &mut c);
            area = -area;
        }
        let corners = [a, b, c];
        let unit = SUBSAMPLE as i64;
        // Sample i is centred at i + 1/2.
        let first = |low: i64| (low - unit / 2 + unit - 1).div_euclid(unit).max(0);
        let last = |high: i64, count: usize| (high - unit / 2).div_euclid(unit).min(count as i64 - 1);
        let (x0, x1) = (first(a.x.min(b.x).min(c.x)), last(a.x.max(b.x).max(c.x), self.width));
        let (y0, y1) = (first(a.y.min(b.y).min(c.y)), last(a.y.max(b.y).max(c.y), self.height));
        if x0 > x1 || y0 > y1 {
            return;
        }
        // Edge function k, opposite corner k: value at the first sample, step in x, step in y.
        let start = Corner { x: x0 * unit + unit / 2, y: y0 * unit + unit / 2, key: 0.0 };
        let edge = [0, 1, 2].map(|k| {
            let (p, q) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
            let (dx, dy) = (q.x - p.x, q.y - p.y);
            // Top-left rule: with y downwards and positive area, the inside lies right of a left
            // edge (dy < 0) and below a top edge.
            let owns_border = dy < 0 || (dy == 0 && dx > 0);
            (cross(p, q, start) - i64::from(!owns_border), -dy * unit, dx * unit)
        });
        let key_step = |step: [i64; 3]| {
            (0..3).map(|k| step[k] as f64 * (corners[k].key - a.key)).sum::<f64>() / area as f64
        };
        let dkey_dx = key_step(edge.map(|e| e.1));
        let dkey_dy = key_step(edge.map(|e| e.2));
        let key0 =
            a.key + key_step([0, 1, 2].map(|k| cross(corners[(k + 1) % 3], corners[(k + 2) % 3], start)));
        for y in y0..=y1 {
            // Columns at which all edge functions are nonnegative: thin faces fill little of their
            // box.
            let (mut low, mut high) = (0, x1 - x0);
            for (start, dx, dy) in edge {
                let value = start + (y - y0) * dy;
                match dx.signum() {
                    1 => low = low.max(-value.div_euclid(dx)),
                    -1 => high = high.min(value.div_euclid(-dx)),
                    _ if value < 0 => high = -1,
                    _ => {}
                }
            }
            let row = y as usize * self.width + x0 as usize;
            let row_key = key0 + (y - y0) as f64 * dkey_dy;
            for i in low..=high {
                let key = (row_key + i as f64 * dkey_dx) as f32;
                let sample = row + i as usize;
                if key > self.key[sample] {
                    self.key[sample] = key;
                    self.face[sample] = face;
                }
            }
        }
    }
}

#[derive(Clone, Copy)]
struct Corner {
    x: i64,
    y: i64,
    key: f64,
}

/// Twice the signed area, positive if c lies to the right of a to b on a screen with y downwards.
fn cross(a: Corner, b: Corner, c: Corner) -> i64 {
    (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)
}

fn side(plane: &(Vec3, f64, f64), p: &Projected) -> f64 {
    plane.0[0] * p.h[0] + plane.0[1] * p.h[1] + plane.0[2] * p.h[2] + plane.1 * p.depth + plane.2
}

/// Perspective-correct barycentric coordinates of a sample: the weight of corner k is `e[k] / (e[0]
/// + e[1] + e[2])`, where every `e` is linear in the sample coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FacePoint {
    /// Weights of the corners, nonnegative with sum 1.
    pub(crate) weights: Vec3,
    /// `e` over its sum.
    pub(crate) e: Vec3,
    /// Change of `e` (over the same sum) per sample to the right and downwards.
    pub(crate) dx: Vec3,
    pub(crate) dy: Vec3,
}

impl FacePoint {
    /// Computes the coordinates; `None` if the face is seen exactly edge-on.
    pub(crate) fn at(h: [Vec3; 3], x: f64, y: f64) -> Option<FacePoint> {
        // Shift the origin to the sample, which avoids cancellation.
        let q = h.map(|p| [p[0] - x * p[2], p[1] - y * p[2], p[2]]);
        let next = |k: usize| (q[(k + 1) % 3], q[(k + 2) % 3]);
        let e = [0, 1, 2].map(|k| {
            let (a, b) = next(k);
            a[0] * b[1] - b[0] * a[1]
        });
        let sum = e[0] + e[1] + e[2];
        let inverse = 1.0 / sum;
        if !inverse.is_finite() {
            return None;
        }
        let dx = [0, 1, 2].map(|k| {
            let (a, b) = next(k);
            (b[2] * a[1] - a[2] * b[1]) * inverse
        });
        let dy = [0, 1, 2].map(|k| {
            let (a, b) = next(k);
            (a[0] * b[2] - b[0] * a[2]) * -inverse
        });
        let e = e.map(|v| v * inverse);
        // Rounding of the corners can put a sample outside the face.
        let clamped = e.map(|v| v.clamp(0.0, 1.0));
        let total = clamped[0] + clamped[1] + clamped[2];
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        Some(FacePoint { weights: clamped.map(|v| v / total), e, dx, dy })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Samples inside a triangle by the definition: all edge functions are positive, or zero on an
    /// edge that owns its border.
    fn samples_inside(corners: [[i64; 2]; 3], width: usize, height: usize) -> Vec<bool> {
        let mut corners = corners.map(|[x, y]| Corner { x, y, key: 1.0 });
        let area = cross(corners[0], corners[1], corners[2]);
        if area < 0 {
            corners.swap(1, 2);
        }
        let centre = |i: usize| i as i64 * 256 + 128;
        let inside = |x: usize, y: usize| {
            (0..3).all(|k| {
                let (p, q) = (corners[k], corners[(k + 1) % 3]);
                let value = cross(p, q, Corner { x: centre(x), y: centre(y), key: 0.0 });
                value > 0 || value == 0 && (q.y < p.y || q.y == p.y && q.x > p.x)
            })
        };
        (0..width * height).map(|i| area != 0 && inside(i % width, i / width)).collect()
    }

    #[test]
    fn faces_cover_the_samples_inside_them() {
        let (width, height) = (23, 17);
        let mut random = 1u64;
        let mut coordinate = |snap: i64| {
            random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            ((random >> 33) % 8192) as i64 / snap * snap - 1024
        };
        for round in 0..2000 {
            // Corners at centres of samples and thin faces are frequent.
            let snap = [1, 128, 256][round % 3];
            let mut corners = [0; 3].map(|_| [0; 2].map(|_| coordinate(snap)));
            if round % 5 == 0 {
                corners[2] = [corners[1][0] + 1, corners[1][1] - 2];
            }
            let mut visibility = Visibility::new(width, height);
            visibility.fill(corners.map(|[x, y]| Corner { x, y, key: 1.0 }), 0);
            let covered: Vec<bool> = visibility.face.iter().map(|f| *f == 0).collect();
            assert_eq!(covered, samples_inside(corners, width, height), "{corners:?}");
        }
    }
}
