//! Curves.

use super::Canvas;
use super::path::{Path, Segment};
use super::stroke::{HEAD_LENGTH, layers};
use crate::camera::Projected;
use crate::drawing::CurveStyle;
use eikona_mesh::vector::Vec3;

impl Canvas<'_> {
    /// Draws a polyline.
    pub(super) fn curve(&mut self, points: &[Vec3], style: &CurveStyle) {
        let width = style.width * self.samples;
        let outline = style.outline.map_or(0.0, |o| o.width * self.samples);
        let border = width / 2.0 + outline + 3.0 * width;
        let projected: Vec<Projected> = points.iter().map(|p| self.project(p)).collect();
        let segments: Vec<Segment> = match projected.as_slice() {
            [one] => self.clipped_segment(one, one, border).into_iter().collect(),
            all => all.windows(2).filter_map(|w| self.clipped_segment(&w[0], &w[1], border)).collect(),
        };
        // Alternations shorter than twice the stroke width, which occur along silhouettes, are
        // removed.
        let shortest = (2.0 * (width + 2.0 * outline)).ceil() as usize;
        let path = Path::new(segments, shortest, |position, key| self.is_centre_visible(position, key));
        // Heads closer together than their length would only cover one another.
        let spacing = style.arrow_spacing.map(|s| s.max(HEAD_LENGTH * style.width) * self.samples);
        let heads = spacing.map_or(Vec::new(), |spacing| path.arrowheads(spacing, width));
        for (color, extra) in layers(style.color, style.outline) {
            let (extra, radius) = (extra * self.samples, width / 2.0 + extra * self.samples);
            for (segment, start) in path.segments.iter().zip(&path.start) {
                self.cover_segment(segment, radius, radius, |s| path.is_visible(start + s));
            }
            for head in &heads {
                self.cover_head(head, extra);
            }
            self.paint(color);
        }
    }
}
