//! Draws curves and points over the image: strokes of constant width, with a depth test.

use crate::camera::{NEAR, Projected, View};
use crate::color::{Linear, to_linear};
use crate::options::Lighting;
use crate::raster::Visibility;
use crate::scene::{CurveStyle, PointStyle};
use crate::shade::studio;
use eikona_mesh::vector::Vec3;

/// Depth bias: how far below the surface a curve may lie and still be drawn, in units of the
/// scene's radius.
const BIAS: f64 = 0.004;

/// Samples to draw on.
pub(crate) struct Canvas<'a> {
    view: &'a View,
    visibility: &'a Visibility,
    colors: &'a mut [[f32; 4]],
    samples: f64,
    /// Coverage of each sample by the current curve, so that overlapping segments count once.
    coverage: Vec<f32>,
    touched: Vec<u32>,
}

/// Segment of a curve in sample coordinates, with depth keys.
#[derive(Clone, Copy)]
struct Piece {
    from: [f64; 2],
    to: [f64; 2],
    key: [f64; 2],
}

impl Piece {
    fn length(&self) -> f64 {
        (self.to[0] - self.from[0]).hypot(self.to[1] - self.from[1])
    }
    /// Returns position and depth key at a fraction of its length.
    fn at(&self, t: f64) -> ([f64; 2], f64) {
        let position = [0, 1].map(|k| self.from[k] + t * (self.to[k] - self.from[k]));
        (position, self.key[0] + t * (self.key[1] - self.key[0]))
    }
}

impl<'a> Canvas<'a> {
    pub(crate) fn new(
        view: &'a View,
        visibility: &'a Visibility,
        colors: &'a mut [[f32; 4]],
        samples: f64,
    ) -> Self {
        let coverage = vec![0.0; colors.len()];
        Canvas { view, visibility, colors, samples, coverage, touched: Vec::new() }
    }

    /// Draws a polyline of normalised points.
    pub(crate) fn curve(&mut self, points: &[Vec3], style: &CurveStyle) {
        let width = style.width * self.samples;
        let rim = style.rim.map(|(color, w)| (to_linear(color), w * self.samples));
        let widest = width / 2.0 + rim.map_or(0.0, |r| r.1) + 3.0 * width;
        let projected: Vec<Projected> = points.iter().map(|&p| self.view.project(p)).collect();
        let pieces: Vec<Piece> = match projected.as_slice() {
            [one] => self.piece(one, one, widest).into_iter().collect(),
            all => all.windows(2).filter_map(|w| self.piece(&w[0], &w[1], widest)).collect(),
        };
        let path = self.visible_path(pieces, width + 2.0 * rim.map_or(0.0, |r| r.1));
        let pieces = &path.pieces;
        let arrows = style.arrow_spacing.map_or(Vec::new(), |s| path.arrows(s * self.samples, width));
        for (color, extra) in rim.into_iter().chain([(to_linear(style.color), 0.0)]) {
            for i in 0..pieces.len() {
                self.cover_piece(&path, i, width / 2.0 + extra);
            }
            for arrow in &arrows {
                self.cover_arrow(arrow, width, extra);
            }
            self.paint(color);
        }
    }

    /// Draws points as balls, farthest first.
    pub(crate) fn points(&mut self, points: &[(Vec3, PointStyle)], lighting: Lighting) {
        let mut balls: Vec<(Projected, &PointStyle)> =
            points.iter().map(|(p, style)| (self.view.project(*p), style)).collect();
        balls.retain(|b| b.0.depth >= NEAR);
        balls.sort_by(|a, b| b.0.depth.total_cmp(&a.0.depth));
        for (p, style) in balls {
            let (x, y) = (p.h[0] / p.h[2], p.h[1] / p.h[2]);
            let radius = style.radius * self.samples;
            let color = to_linear(style.color);
            let tolerance = BIAS + radius * 1.5 * self.view.sample_size(p.depth);
            let reach = radius + 1.0;
            let Some((rows, columns)) = self.window([x - reach, y - reach], [x + reach, y + reach]) else {
                continue;
            };
            for j in rows {
                for i in columns.clone() {
                    let (dx, dy) = (i as f64 + 0.5 - x, j as f64 + 0.5 - y);
                    let distance = dx.hypot(dy);
                    let cover = (radius + 0.5 - distance).clamp(0.0, 1.0);
                    let sample = j * self.visibility.width + i;
                    if cover == 0.0 || self.surface_depth(sample) < p.depth - tolerance {
                        continue;
                    }
                    // A ball smaller than a sample has no visible shape, and radius 0 must not
                    // divide.
                    let across = radius.max(1.0);
                    let (nx, ny) = (dx / across, -dy / across);
                    let normal = [nx, ny, (1.0 - nx * nx - ny * ny).max(0.0).sqrt()];
                    let lit = match lighting {
                        Lighting::Studio => studio(color, normal, 0.55 + 0.45 * normal[2]),
                        Lighting::Unlit => color,
                    };
                    over(&mut self.colors[sample], lit, cover as f32);
                }
            }
        }
    }

    fn surface_depth(&self, sample: usize) -> f64 {
        let key = self.visibility.key[sample];
        if key == f32::NEG_INFINITY { f64::INFINITY } else { self.view.depth_of_key(key as f64) }
    }

    /// Returns the rows and columns of the samples of a box, clipped to the image.
    fn window(
        &self,
        low: [f64; 2],
        high: [f64; 2],
    ) -> Option<(std::ops::Range<usize>, std::ops::Range<usize>)> {
        let range = |low: f64, high: f64, count: usize| {
            let start = low.floor().max(0.0);
            let end = (high.ceil() + 1.0).min(count as f64);
            (start < end).then_some(start as usize..end as usize)
        };
        Some((
            range(low[1], high[1], self.visibility.height)?,
            range(low[0], high[0], self.visibility.width)?,
        ))
    }

    /// Clips a segment to the near plane and to the image, widened by the stroke.
    fn piece(&self, a: &Projected, b: &Projected, reach: f64) -> Option<Piece> {
        let (mut a, mut b) = (*a, *b);
        if a.depth < NEAR && b.depth < NEAR {
            return None;
        }
        let at_near = |inner: &Projected, outer: &Projected| {
            let t = (inner.depth - NEAR) / (inner.depth - outer.depth);
            let h = [0, 1, 2].map(|k| inner.h[k] + t * (outer.h[k] - inner.h[k]));
            Projected { h: [h[0], h[1], if self.view.perspective { NEAR } else { 1.0 }], depth: NEAR }
        };
        if a.depth < NEAR {
            a = at_near(&b, &a);
        } else if b.depth < NEAR {
            b = at_near(&a, &b);
        }
        let flat = |p: &Projected| [p.h[0] / p.h[2], p.h[1] / p.h[2]];
        let (from, to) = (flat(&a), flat(&b));
        let key = [self.view.depth_key(a.depth), self.view.depth_key(b.depth)];
        // Liang-Barsky against the image widened by the stroke.
        let size = [self.visibility.width as f64, self.visibility.height as f64];
        let (mut t0, mut t1) = (0.0f64, 1.0f64);
        for k in 0..2 {
            let step = to[k] - from[k];
            for (p, q) in [(-step, from[k] + reach), (step, size[k] + reach - from[k])] {
                if p < 0.0 {
                    t0 = t0.max(q / p);
                } else if p > 0.0 {
                    t1 = t1.min(q / p);
                } else if q < 0.0 {
                    return None;
                }
            }
        }
        if t0.is_nan() || t1.is_nan() || t0 > t1 {
            return None;
        }
        let at = |t: f64| [from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])];
        let key_at = |t: f64| key[0] + t * (key[1] - key[0]);
        Some(Piece { from: at(t0), to: at(t1), key: [key_at(t0), key_at(t1)] })
    }

    /// Determines where the centre line of a curve is visible. Alternations shorter than twice the
    /// stroke width, which occur along silhouettes, are removed.
    fn visible_path(&self, pieces: Vec<Piece>, width: f64) -> Path {
        let mut start = Vec::with_capacity(pieces.len());
        let mut total = 0.0;
        let mut visible = Vec::new();
        for piece in &pieces {
            start.push(total);
            let end = total + piece.length();
            while (visible.len() as f64) < end.max(1.0) {
                let t = ((visible.len() as f64 + 0.5 - total) / piece.length().max(1e-9)).clamp(0.0, 1.0);
                let (position, key) = piece.at(t);
                visible.push(self.is_centre_visible(position, key));
            }
            total = end;
        }
        let shortest = (2.0 * width).ceil() as usize;
        flip_short_runs(&mut visible, shortest, false);
        flip_short_runs(&mut visible, shortest, true);
        Path { pieces, start, total, visible }
    }

    fn is_centre_visible(&self, position: [f64; 2], key: f64) -> bool {
        let (width, height) = (self.visibility.width, self.visibility.height);
        if !(position[0] >= 0.0
            && position[1] >= 0.0
            && position[0] < width as f64
            && position[1] < height as f64)
        {
            return true;
        }
        let depth = self.view.depth_of_key(key);
        let tolerance = BIAS + 3.0 * self.view.sample_size(depth);
        self.surface_depth(position[1] as usize * width + position[0] as usize) >= depth - tolerance
    }

    fn cover_piece(&mut self, path: &Path, index: usize, radius: f64) {
        let piece = &path.pieces[index];
        let length = piece.length();
        let reach = radius + 0.5;
        let [(ax, ay), (bx, by)] = [piece.from, piece.to].map(|p| (p[0], p[1]));
        let (dx, dy) = (bx - ax, by - ay);
        let length_sq = dx * dx + dy * dy;
        let low = [ax.min(bx) - reach, ay.min(by) - reach];
        let high = [ax.max(bx) + reach, ay.max(by) + reach];
        let Some((rows, _)) = self.window(low, high) else { return };
        for j in rows {
            let y = j as f64 + 0.5;
            // Restrict columns to the part of the segment near this row.
            let (mut t0, mut t1) = (0.0, 1.0);
            if dy.abs() > 1e-9 {
                let (s0, s1) = ((y - reach - ay) / dy, (y + reach - ay) / dy);
                t0 = s0.min(s1).clamp(0.0, 1.0);
                t1 = s0.max(s1).clamp(0.0, 1.0);
            }
            let (x0, x1) = (ax + t0 * dx, ax + t1 * dx);
            let Some((_, columns)) = self.window([x0.min(x1) - reach, y], [x0.max(x1) + reach, y]) else {
                continue;
            };
            for i in columns {
                let x = i as f64 + 0.5;
                let t = if length_sq > 0.0 {
                    (((x - ax) * dx + (y - ay) * dy) / length_sq).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                let foot = [ax + t * dx, ay + t * dy];
                let cover = (reach - (x - foot[0]).hypot(y - foot[1])).clamp(0.0, 1.0);
                if cover > 0.0 && path.is_visible(path.start[index] + t * length) {
                    self.cover(j * self.visibility.width + i, cover, piece.at(t).1, radius);
                }
            }
        }
    }

    fn cover_arrow(&mut self, arrow: &Arrow, width: f64, extra: f64) {
        let [ux, uy] = arrow.direction;
        let (length, half) = arrow_size(width);
        let tip = [arrow.position[0] + 0.5 * length * ux, arrow.position[1] + 0.5 * length * uy];
        let reach = length + extra + 1.0;
        let low = [arrow.position[0] - reach, arrow.position[1] - reach];
        let high = [arrow.position[0] + reach, arrow.position[1] + reach];
        let Some((rows, columns)) = self.window(low, high) else { return };
        let slant = length.hypot(half);
        for j in rows {
            for i in columns.clone() {
                let (rx, ry) = (i as f64 + 0.5 - tip[0], j as f64 + 0.5 - tip[1]);
                let (along, across) = (-(rx * ux + ry * uy), (ry * ux - rx * uy).abs());
                // Signed distance to the base and to the nearer slanted side.
                let outside = (along - length).max((across * length - along * half) / slant);
                let cover = (extra + 0.5 - outside).clamp(0.0, 1.0);
                if cover > 0.0 {
                    let sample = j * self.visibility.width + i;
                    self.cover(sample, cover, arrow.key, length);
                }
            }
        }
    }

    /// Adds coverage of a stroke whose centre line has this depth, unless the surface hides it.
    fn cover(&mut self, sample: usize, cover: f64, key: f64, radius: f64) {
        let depth = self.view.depth_of_key(key);
        // The surface beside the centre line may be nearer to the camera: tolerate a slope of 4.
        if self.surface_depth(sample) < depth - BIAS - 4.0 * radius * self.view.sample_size(depth) {
            return;
        }
        if self.coverage[sample] == 0.0 {
            self.touched.push(sample as u32);
        }
        self.coverage[sample] = self.coverage[sample].max(cover as f32);
    }

    /// Blends a colour over the covered samples and clears the coverage.
    fn paint(&mut self, color: Linear) {
        for &sample in &self.touched {
            let sample = sample as usize;
            over(&mut self.colors[sample], color, self.coverage[sample]);
            self.coverage[sample] = 0.0;
        }
        self.touched.clear();
    }
}

fn over(below: &mut [f32; 4], color: Linear, alpha: f32) {
    for k in 0..3 {
        below[k] = below[k] * (1.0 - alpha) + color[k] * alpha;
    }
    below[3] = below[3] * (1.0 - alpha) + alpha;
}

struct Arrow {
    position: [f64; 2],
    direction: [f64; 2],
    key: f64,
}

/// Length and half width of an arrowhead for this stroke width.
fn arrow_size(width: f64) -> (f64, f64) {
    (4.6 * width, 2.0 * width)
}

/// Projected curve with its visible parts.
struct Path {
    pieces: Vec<Piece>,
    /// Arc length before each piece, in samples.
    start: Vec<f64>,
    total: f64,
    /// Whether the centre line is visible, per sample of arc length.
    visible: Vec<bool>,
}

impl Path {
    fn is_visible(&self, s: f64) -> bool {
        self.visible.get(s as usize).or(self.visible.last()).copied().unwrap_or(false)
    }

    fn at(&self, s: f64) -> Option<([f64; 2], f64)> {
        let i = self.start.partition_point(|start| *start <= s).saturating_sub(1);
        let piece = self.pieces.get(i)?;
        let length = piece.length();
        Some(piece.at(if length > 0.0 { ((s - self.start[i]) / length).clamp(0.0, 1.0) } else { 0.0 }))
    }

    /// Returns evenly spaced arrowheads where the curve is visible, each aligned with the chord
    /// over its own length.
    fn arrows(&self, spacing: f64, width: f64) -> Vec<Arrow> {
        if self.total.is_nan() || self.total <= 0.0 {
            return Vec::new();
        }
        let count = (self.total / spacing).round().clamp(1.0, 10_000.0);
        let half = arrow_size(width).0 / 2.0;
        let arrow = |i: usize| {
            let s = (i as f64 + 0.5) * self.total / count;
            if !(self.is_visible((s - half).max(0.0)) && self.is_visible(s) && self.is_visible(s + half)) {
                return None;
            }
            let (position, key) = self.at(s)?;
            let ([ax, ay], [bx, by]) =
                (self.at((s - half).max(0.0))?.0, self.at((s + half).min(self.total))?.0);
            let length = (bx - ax).hypot(by - ay);
            (length > 0.0).then(|| Arrow {
                position,
                direction: [(bx - ax) / length, (by - ay) / length],
                key,
            })
        };
        (0..count as usize).filter_map(arrow).collect()
    }
}

/// Flips runs of `value` that are shorter than `shortest` and lie between runs of the other value.
fn flip_short_runs(flags: &mut [bool], shortest: usize, value: bool) {
    let mut i = 0;
    while i < flags.len() {
        let start = i;
        while i < flags.len() && flags[i] == flags[start] {
            i += 1;
        }
        if flags[start] == value && i - start < shortest && start > 0 && i < flags.len() {
            flags[start..i].fill(!value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_inner_runs_are_flipped() {
        let mut flags = [true, true, false, true, true, true, false, false, false, true];
        flip_short_runs(&mut flags, 2, false);
        assert_eq!(flags, [true, true, true, true, true, true, false, false, false, true]);
        flip_short_runs(&mut flags, 9, true);
        assert_eq!(flags, [true, true, true, true, true, true, false, false, false, true], "ends are kept");
    }
}
