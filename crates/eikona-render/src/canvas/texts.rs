//! Short texts beside points.

use super::{BIAS, Canvas};
use crate::camera::NEAR;
use crate::color::to_linear;
use crate::drawing::TextStyle;
use crate::font::{stroke_radius, text_segments};
use eikona_mesh::vector::Vec3;

/// Width of the halo around letters, relative to their height.
const HALO: f64 = 0.22;

impl Canvas<'_> {
    /// Draws texts to the upper right of points that are not hidden, each on a halo.
    pub(super) fn texts(&mut self, positions: &[Vec3], texts: &[String], style: &TextStyle) {
        let size = style.size * self.samples;
        let offset = style.offset * self.samples;
        for (position, text) in positions.iter().zip(texts) {
            let point = self.project(position);
            if point.depth < NEAR || size == 0.0 {
                continue;
            }
            let (x, y) = (point.h[0] / point.h[2], point.h[1] / point.h[2]);
            let Some((rows, columns)) = self.window([x, y], [x, y]) else { continue };
            let sample = rows.start * self.visibility.width + columns.start;
            let tolerance = BIAS + 1.5 * offset.max(1.0) * self.view.sample_size(point.depth);
            if self.surface_depth(sample) < point.depth - tolerance {
                continue;
            }
            let segments = text_segments(text, x + offset, y - offset, size);
            let radius = stroke_radius(size).max(0.5 * self.samples);
            for (color, radius) in [(style.halo, radius + HALO * size), (style.color, radius)] {
                segments.iter().for_each(|segment| self.cover_line(*segment, radius));
                self.paint(to_linear(color));
            }
        }
    }

    /// Adds coverage by a line of this half width, in front of everything.
    fn cover_line(&mut self, [a, b]: [[f64; 2]; 2], radius: f64) {
        let reach = radius + 0.5;
        let low = [0, 1].map(|k| a[k].min(b[k]) - reach);
        let high = [0, 1].map(|k| a[k].max(b[k]) + reach);
        let Some((rows, columns)) = self.window(low, high) else { return };
        let along = [b[0] - a[0], b[1] - a[1]];
        let length = (along[0] * along[0] + along[1] * along[1]).max(f64::MIN_POSITIVE);
        for j in rows {
            for i in columns.clone() {
                let from = [i as f64 + 0.5 - a[0], j as f64 + 0.5 - a[1]];
                let t = ((from[0] * along[0] + from[1] * along[1]) / length).clamp(0.0, 1.0);
                let distance = (from[0] - t * along[0]).hypot(from[1] - t * along[1]);
                let cover = (reach - distance).clamp(0.0, 1.0) as f32;
                let sample = j * self.visibility.width + i;
                if cover > 0.0 {
                    if self.coverage[sample] == 0.0 {
                        self.touched.push(sample as u32);
                    }
                    self.coverage[sample] = self.coverage[sample].max(cover);
                }
            }
        }
    }
}
