//! Glyphs: arrows and marks.

use super::Canvas;
use super::path::Segment;
use super::stroke::{Arrowhead, HEAD_LENGTH, layers};
use crate::camera::NEAR;
use crate::drawing::GlyphStyle;
use eikona_mesh::vector::Vec3;

struct Glyph {
    shaft: Segment,
    width: f64,
    head: Option<Arrowhead>,
}

impl Canvas<'_> {
    /// Draws arrows or marks from tail to tip. Outlines are below all of them.
    pub(super) fn glyphs(&mut self, ends: &[[Vec3; 2]], style: &GlyphStyle) {
        let glyphs: Vec<Glyph> = ends.iter().filter_map(|ends| self.glyph(ends, style)).collect();
        for (color, extra) in layers(style.color, style.outline) {
            let extra = extra * self.samples;
            for glyph in &glyphs {
                let radius = glyph.width / 2.0 + extra;
                // The middle is visible, but where the surface is concave, the ends are below it:
                // tolerate a slope of 1 over half the length.
                let reach = radius + glyph.shaft.length() / 8.0;
                self.cover_segment(&glyph.shaft, radius, reach, |_| true);
                if let Some(head) = &glyph.head {
                    self.cover_head(head, extra);
                }
            }
            self.paint(color);
        }
    }

    /// Projects a glyph; `None` if it is hidden.
    fn glyph(&self, ends: &[Vec3; 2], style: &GlyphStyle) -> Option<Glyph> {
        let [tail, tip] = [0, 1].map(|k| self.project(&ends[k]));
        if tail.depth < NEAR || tip.depth < NEAR {
            return None;
        }
        let whole = Segment::between(self.view, &tail, &tip);
        let (middle, key) = whole.at(0.5);
        if !self.is_centre_visible(middle, key) {
            return None;
        }
        let (length, width) = (whole.length(), style.width * self.samples);
        if !style.head || length == 0.0 {
            return Some(Glyph { shaft: whole, width, head: None });
        }
        // The head takes at most half of the arrow.
        let width = width.min(0.5 * length / HEAD_LENGTH);
        let head_share = HEAD_LENGTH * width / length;
        let (position, key) = whole.at(1.0 - 0.5 * head_share);
        let direction = [0, 1].map(|k| (whole.to[k] - whole.from[k]) / length);
        let head = Some(Arrowhead { position, direction, key, width });
        // The round end of the shaft must not show beyond the tip.
        let shaft = Segment { to: position, key: [whole.key[0], key], ..whole };
        Some(Glyph { shaft, width, head })
    }
}
