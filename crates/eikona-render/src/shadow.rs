//! Soft shadow on a ground just below the mesh. The mesh is split by height into layers; each casts
//! a shadow blurred in proportion to its height. The mesh is treated as solid between its lowest
//! and highest point above each cell.

use crate::camera::{Projected, View};
use crate::raster::{NONE, Visibility};
use crate::shade::tangent_frame;
use eikona_mesh::vector::{Vec3, dot};

/// Number of cells along the longer side of the ground.
const CELLS: usize = 300;
/// Upper ends of the layers, in units of the scene's radius.
const LAYERS: [f64; 6] = [0.02, 0.08, 0.2, 0.45, 0.9, f64::INFINITY];
/// Blur width of each layer.
const BLURS: [f64; 6] = [0.012, 0.04, 0.09, 0.19, 0.34, 0.55];
/// Darkness of each layer.
const DARKNESS: [f64; 6] = [0.40, 0.34, 0.30, 0.28, 0.26, 0.18];

/// Offset that keeps depths positive.
const ABOVE: f64 = 4.0;

/// Fraction of hidden sky, on a grid over the ground.
pub(crate) struct GroundShadow {
    up: Vec3,
    across: (Vec3, Vec3),
    ground: f64,
    low: [f64; 2],
    cell: f64,
    size: [usize; 2],
    dark: Vec<f32>,
    strength: f64,
}

impl GroundShadow {
    /// Computes the shadow; `None` without faces, strength or ground, or unless the camera looks
    /// down on the ground.
    pub(crate) fn new(
        view: &View,
        positions: &[Vec3],
        triangles: &[[u32; 3]],
        strength: f64,
    ) -> Option<GroundShadow> {
        let up = view.world_up;
        if !view.has_ground || triangles.is_empty() || strength == 0.0 || dot(view.back, up) < 0.02 {
            return None;
        }
        let across = tangent_frame(up);
        let mut ground = f64::INFINITY;
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for &v in triangles.iter().flatten() {
            let p = positions[v as usize];
            ground = ground.min(dot(p, up));
            for (k, x) in [dot(p, across.0), dot(p, across.1)].into_iter().enumerate() {
                (low[k], high[k]) = (low[k].min(x), high[k].max(x));
            }
        }
        if dot(view.eye, up) <= ground {
            return None;
        }
        let padding = 1.3; // the widest blur fades out within it
        let low = low.map(|x| x - padding);
        let side = [high[0] + padding - low[0], high[1] + padding - low[1]];
        let cell = side[0].max(side[1]) / CELLS as f64;
        let size = side.map(|s| ((s / cell).ceil() as usize).clamp(1, CELLS));
        // Lowest and highest point over each cell, from depth buffers seen from below and from
        // above.
        let seen = |direction: f64| {
            let projected: Vec<Projected> = positions
                .iter()
                .map(|&p| {
                    let (x, y) = ((dot(p, across.0) - low[0]) / cell, (dot(p, across.1) - low[1]) / cell);
                    Projected { h: [x, y, 1.0], depth: ABOVE + direction * (dot(p, up) - ground) }
                })
                .collect();
            let mut seen = Visibility::new(size[0], size[1]);
            seen.draw(&projected, triangles, false);
            seen
        };
        let (below, above) = (seen(1.0), seen(-1.0));
        let mut light = vec![1.0f32; size[0] * size[1]];
        let mut start = f64::NEG_INFINITY;
        for ((&end, &width), &darkness) in LAYERS.iter().zip(&BLURS).zip(&DARKNESS) {
            let mut layer: Vec<f32> = (0..light.len())
                .map(|i| {
                    let lowest = -(below.key[i] as f64) - ABOVE;
                    let highest = ABOVE + above.key[i] as f64;
                    f32::from(below.face[i] != NONE && lowest <= end && highest > start)
                })
                .collect();
            // Three box blurs approximate a Gaussian.
            let reach = ((width / cell).round() as usize).max(1);
            for _ in 0..3 {
                layer = box_blur(&layer, size, reach);
            }
            for (l, d) in light.iter_mut().zip(&layer) {
                *l *= 1.0 - (darkness as f32) * d.clamp(0.0, 1.0);
            }
            start = end;
        }
        let dark = light.into_iter().map(|l| 1.0 - l).collect();
        Some(GroundShadow { up, across, ground, low, cell, size, dark, strength })
    }

    /// Darkness of the ground at a sample, 0 to 1.
    pub(crate) fn at(&self, view: &View, x: f64, y: f64) -> f64 {
        let (origin, direction) = view.ray(x, y);
        let fall = dot(direction, self.up);
        let t = (self.ground - dot(origin, self.up)) / fall;
        if !(fall < 0.0 && t > 0.0 && t.is_finite()) {
            return 0.0;
        }
        let coordinate = |axis: Vec3| dot(origin, axis) + t * dot(direction, axis);
        let u = (coordinate(self.across.0) - self.low[0]) / self.cell - 0.5;
        let v = (coordinate(self.across.1) - self.low[1]) / self.cell - 0.5;
        let (limit_u, limit_v) = (self.size[0] as f64 - 1.0, self.size[1] as f64 - 1.0);
        if !(u >= 0.0 && v >= 0.0 && u < limit_u && v < limit_v) {
            return 0.0;
        }
        let (i, j) = (u as usize, v as usize);
        let (fu, fv) = (u - i as f64, v - j as f64);
        let cell = |i: usize, j: usize| self.dark[j * self.size[0] + i] as f64;
        let row = |j: usize| cell(i, j) * (1.0 - fu) + cell(i + 1, j) * fu;
        self.strength * (row(j) * (1.0 - fv) + row(j + 1) * fv)
    }
}

/// Box blur over `2 reach + 1` cells along both axes, zero outside.
fn box_blur(values: &[f32], [width, height]: [usize; 2], reach: usize) -> Vec<f32> {
    let line = |source: &[f32], target: &mut [f32], start: usize, step: usize, count: usize| {
        let share = 1.0 / (2 * reach + 1) as f64;
        let value = |i: usize| if i < count { source[start + i * step] as f64 } else { 0.0 };
        let mut sum: f64 = (0..reach.min(count)).map(value).sum();
        for i in 0..count {
            sum += value(i + reach);
            target[start + i * step] = (sum * share) as f32;
            if i >= reach {
                sum -= value(i - reach);
            }
        }
    };
    let mut across = vec![0.0; values.len()];
    for y in 0..height {
        line(values, &mut across, y * width, 1, width);
    }
    let mut both = vec![0.0; values.len()];
    for x in 0..width {
        line(&across, &mut both, x, width, height);
    }
    both
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn box_blur_keeps_the_sum() {
        let mut spike = vec![0.0; 21 * 15];
        spike[7 * 21 + 10] = 1.0;
        let out = box_blur(&spike, [21, 15], 2);
        assert!((out.iter().sum::<f32>() - 1.0).abs() < 1e-5);
        assert!((out[7 * 21 + 12] - 0.04).abs() < 1e-6 && out[7 * 21 + 13].abs() < 1e-6);
    }
}
