//! Screen-space ambient occlusion from the depth buffer.
//!
//! The estimator is that of McGuire, Mara and Luebke (Scalable Ambient Obscurance, 2012):
//! neighbours on a spiral, each weighted by the cosine to the normal over its distance. A fixed
//! pattern of the pixel coordinates rotates the spiral, and a depth-aware blur removes the noise.

use crate::camera::View;
use crate::shade::Surface;
use eikona_mesh::vector::{Vec3, dot, sub};
use rayon::prelude::*;

/// Sampling radius in units of the scene's radius.
const RADIUS: f64 = 0.32;
const TAPS: usize = 26;
const TURNS: f64 = 7.0;
const BLUR: i64 = 5;

/// Visibility of the sky per pixel: 1 is unoccluded, 0 fully occluded.
pub(crate) struct Occlusion {
    width: usize,
    height: usize,
    samples: usize,
    depth: Vec<f32>,
    open: Vec<f32>,
}

impl Occlusion {
    pub(crate) fn compute(surface: &Surface, samples: usize) -> Occlusion {
        let (width, height) = (surface.visibility.width / samples, surface.visibility.height / samples);
        let mut pixels = vec![(f32::INFINITY, [0.0f32; 3]); width * height];
        pixels.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for (x, out) in row.iter_mut().enumerate() {
                if let Some(hit) = surface.hit(x * samples + samples / 2, y * samples + samples / 2) {
                    *out = (hit.depth as f32, hit.normal.map(|c| c as f32));
                }
            }
        });
        let spiral = (0..TAPS)
            .map(|i| {
                let share = (i as f64 + 0.5) / TAPS as f64;
                let (sin, cos) = (std::f64::consts::TAU * TURNS * share).sin_cos();
                [share * cos, share * sin]
            })
            .collect();
        let depth: Vec<f32> = pixels.iter().map(|p| p.0).collect();
        let grid =
            Grid { view: surface.view, width, height, samples, depth: &depth, pixels: &pixels, spiral };
        let mut raw = vec![1.0f32; width * height];
        raw.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for (x, out) in row.iter_mut().enumerate() {
                *out = grid.open_at(x, y) as f32;
            }
        });
        let across = blur(&raw, &depth, width, height, [1, 0]);
        let open = blur(&across, &depth, width, height, [0, 1]);
        Occlusion { width, height, samples, depth, open }
    }

    /// Visibility of the sky at a sample, interpolated from surrounding pixels of similar depth.
    pub(crate) fn at(&self, x: usize, y: usize, depth: f64) -> f64 {
        // Pixel i was evaluated at its sample `samples / 2`.
        let position = |c: usize| (c as f64 - (self.samples / 2) as f64) / self.samples as f64;
        let (px, py) = (position(x), position(y));
        let (fx, fy) = (px - px.floor(), py - py.floor());
        let (mut sum, mut total) = (0.0, 0.0);
        for (dy, wy) in [(0, 1.0 - fy), (1, fy)] {
            for (dx, wx) in [(0, 1.0 - fx), (1, fx)] {
                let (i, j) = (px.floor() as i64 + dx, py.floor() as i64 + dy);
                if i < 0 || j < 0 || i >= self.width as i64 || j >= self.height as i64 {
                    continue;
                }
                let at = j as usize * self.width + i as usize;
                let weight = (wx * wy + 1e-4) * similarity(depth, self.depth[at] as f64);
                sum += weight * self.open[at] as f64;
                total += weight;
            }
        }
        if total > 0.0 { sum / total } else { 1.0 }
    }
}

/// Similarity of two depths, from 1 down to almost 0.
fn similarity(a: f64, b: f64) -> f64 {
    if !b.is_finite() {
        return 0.0;
    }
    let share = (a - b) / 0.03;
    1.0 / (1.0 + share * share * share * share)
}

struct Grid<'a> {
    view: &'a View,
    width: usize,
    height: usize,
    samples: usize,
    /// Depths only: the neighbours are scattered over the image, and these fit the cache.
    depth: &'a [f32],
    pixels: &'a [(f32, [f32; 3])],
    /// Offsets of the neighbours, in units of the sampling radius.
    spiral: Vec<[f64; 2]>,
}

impl Grid<'_> {
    /// Position of a pixel in the camera's frame (right, up, towards the camera).
    fn position(&self, x: i64, y: i64, depth: f64) -> Vec3 {
        let at = |c: i64| (c * self.samples as i64 + self.samples as i64 / 2) as f64 + 0.5;
        let reach = if self.view.perspective { depth } else { 1.0 } / self.view.focal;
        [(at(x) - self.view.center[0]) * reach, -(at(y) - self.view.center[1]) * reach, -depth]
    }

    fn open_at(&self, x: usize, y: usize) -> f64 {
        let (depth, normal) = self.pixels[y * self.width + x];
        if !depth.is_finite() {
            return 1.0;
        }
        let normal = normal.map(f64::from);
        let depth = depth as f64;
        let here = self.position(x as i64, y as i64, depth);
        let reach = RADIUS / self.view.sample_size(depth) / self.samples as f64;
        if reach.is_nan() || reach < 1.5 {
            return 1.0;
        }
        // Limit the radius, or a camera inside the mesh would see only distant pixels.
        let reach = reach.min(self.width.max(self.height) as f64 / 3.0);
        // Interleaved gradient noise (Jimenez 2014).
        let pattern = 52.982_918_9 * (0.067_110_56 * x as f64 + 0.005_837_15 * y as f64).fract();
        let (sin, cos) = (std::f64::consts::TAU * pattern.fract()).sin_cos();
        let mut sum = 0.0;
        for [u, v] in &self.spiral {
            let (dx, dy) = (reach * (cos * u - sin * v), reach * (sin * u + cos * v));
            let (i, j) = ((x as f64 + dx).round() as i64, (y as f64 + dy).round() as i64);
            if i < 0 || j < 0 || i >= self.width as i64 || j >= self.height as i64 {
                continue;
            }
            let other = self.depth[j as usize * self.width + i as usize];
            if !other.is_finite() {
                continue;
            }
            let v = sub(self.position(i, j, other as f64), here);
            let (distance_sq, height) = (dot(v, v), dot(v, normal));
            if height <= 0.004 || distance_sq >= RADIUS * RADIUS {
                continue;
            }
            let near = 1.0 - distance_sq / (RADIUS * RADIUS);
            let rise = (height - 0.004 - 0.02 * distance_sq.sqrt()).max(0.0);
            sum += near * near * rise / (distance_sq + 1e-4) * RADIUS;
        }
        (1.0 - 1.55 * sum / TAPS as f64).clamp(0.0, 1.0)
    }
}

fn blur(values: &[f32], depth: &[f32], width: usize, height: usize, [dx, dy]: [i64; 2]) -> Vec<f32> {
    let weights: Vec<f64> = (-BLUR..=BLUR).map(|k| (-(k * k) as f64 / 14.0).exp()).collect();
    let mut out = vec![1.0f32; values.len()];
    out.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for (x, out) in row.iter_mut().enumerate() {
            let here = depth[y * width + x] as f64;
            if !here.is_finite() {
                continue;
            }
            let (mut sum, mut total) = (0.0, 0.0);
            for (k, weight) in (-BLUR..=BLUR).zip(&weights) {
                let (i, j) = (x as i64 + k * dx, y as i64 + k * dy);
                if i < 0 || j < 0 || i >= width as i64 || j >= height as i64 {
                    continue;
                }
                let at = j as usize * width + i as usize;
                let weight = weight * similarity(here, depth[at] as f64);
                sum += weight * values[at] as f64;
                total += weight;
            }
            *out = (sum / total) as f32;
        }
    });
    out
}
