//! Strokes: segments with round ends, and arrowheads.

use super::Canvas;
use super::path::Segment;
use crate::color::{Linear, to_linear};
use crate::drawing::Outline;

/// Arrowhead in sample coordinates.
pub(super) struct Arrowhead {
    /// Its middle.
    pub(super) position: [f64; 2],
    /// Unit vector.
    pub(super) direction: [f64; 2],
    /// Depth key.
    pub(super) key: f64,
    /// Width of its stroke in samples.
    pub(super) width: f64,
}

/// Length of an arrowhead over the width of its stroke.
pub(super) const HEAD_LENGTH: f64 = 4.6;
/// Half width of an arrowhead over the width of its stroke.
const HEAD_HALF_WIDTH: f64 = 2.0;

/// Returns the colours of a stroke from bottom to top, with the width that the outline adds on each
/// side, in pixels.
pub(super) fn layers(color: [u8; 3], outline: Option<Outline>) -> impl Iterator<Item = (Linear, f64)> {
    let outline = outline.map(|o| (to_linear(o.color), o.width));
    outline.into_iter().chain([(to_linear(color), 0.0)])
}

impl Canvas<'_> {
    /// Covers the samples within a radius of a segment whose nearest point, given by its arc
    /// length, is drawn. `reach` is as for [`Canvas::cover`].
    pub(super) fn cover_segment(
        &mut self,
        segment: &Segment,
        radius: f64,
        reach: f64,
        is_drawn: impl Fn(f64) -> bool,
    ) {
        let length = segment.length();
        let border = radius + 0.5;
        let [(ax, ay), (bx, by)] = [segment.from, segment.to].map(|p| (p[0], p[1]));
        let (dx, dy) = (bx - ax, by - ay);
        let length_sq = dx * dx + dy * dy;
        let low = [ax.min(bx) - border, ay.min(by) - border];
        let high = [ax.max(bx) + border, ay.max(by) + border];
        let Some((rows, _)) = self.window(low, high) else { return };
        for j in rows {
            let y = j as f64 + 0.5;
            // Restrict columns to the part of the segment near this row.
            let (mut t0, mut t1) = (0.0, 1.0);
            if dy.abs() > 1e-9 {
                let (s0, s1) = ((y - border - ay) / dy, (y + border - ay) / dy);
                t0 = s0.min(s1).clamp(0.0, 1.0);
                t1 = s0.max(s1).clamp(0.0, 1.0);
            }
            let (x0, x1) = (ax + t0 * dx, ax + t1 * dx);
            let Some((_, columns)) = self.window([x0.min(x1) - border, y], [x0.max(x1) + border, y]) else {
                continue;
            };
            for i in columns {
                let sample = j * self.visibility.width + i;
                if self.coverage[sample] == 1.0 {
                    continue; // as most samples of a wide stroke with short segments
                }
                let x = i as f64 + 0.5;
                let t = if length_sq > 0.0 {
                    (((x - ax) * dx + (y - ay) * dy) / length_sq).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                let foot = [ax + t * dx, ay + t * dy];
                let cover = (border - (x - foot[0]).hypot(y - foot[1])).clamp(0.0, 1.0);
                if cover > 0.0 && is_drawn(t * length) {
                    self.cover(sample, cover, segment.at(t).1, reach);
                }
            }
        }
    }

    /// Covers the samples of an arrowhead that is `extra` samples wider on each side.
    pub(super) fn cover_head(&mut self, head: &Arrowhead, extra: f64) {
        let [ux, uy] = head.direction;
        let (length, half) = (HEAD_LENGTH * head.width, HEAD_HALF_WIDTH * head.width);
        let tip = [head.position[0] + 0.5 * length * ux, head.position[1] + 0.5 * length * uy];
        let border = length + extra + 1.0;
        let low = [head.position[0] - border, head.position[1] - border];
        let high = [head.position[0] + border, head.position[1] + border];
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
                    self.cover(j * self.visibility.width + i, cover, head.key, length);
                }
            }
        }
    }
}
