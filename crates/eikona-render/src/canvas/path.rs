//! Projected polylines: clipping, visible parts, positions of arrowheads.

use super::Canvas;
use super::stroke::{Arrowhead, HEAD_LENGTH};
use crate::camera::{NEAR, Projected, View};

/// Segment in sample coordinates, with depth keys.
#[derive(Clone, Copy)]
pub(super) struct Segment {
    pub(super) from: [f64; 2],
    pub(super) to: [f64; 2],
    pub(super) key: [f64; 2],
}

impl Segment {
    /// Returns the segment between two points in front of the near plane.
    pub(super) fn between(view: &View, a: &Projected, b: &Projected) -> Segment {
        let flat = |p: &Projected| [p.h[0] / p.h[2], p.h[1] / p.h[2]];
        let key = [view.depth_key(a.depth), view.depth_key(b.depth)];
        Segment { from: flat(a), to: flat(b), key }
    }

    pub(super) fn length(&self) -> f64 {
        (self.to[0] - self.from[0]).hypot(self.to[1] - self.from[1])
    }

    /// Returns position and depth key at a fraction of its length.
    pub(super) fn at(&self, t: f64) -> ([f64; 2], f64) {
        let position = [0, 1].map(|k| self.from[k] + t * (self.to[k] - self.from[k]));
        (position, self.key[0] + t * (self.key[1] - self.key[0]))
    }

    /// Clips to the image, widened by `border` on each side (Liang and Barsky 1984).
    fn clipped(&self, [width, height]: [usize; 2], border: f64) -> Option<Segment> {
        let (mut t0, mut t1) = (0.0f64, 1.0f64);
        for (k, size) in [width as f64, height as f64].into_iter().enumerate() {
            let step = self.to[k] - self.from[k];
            for (p, q) in [(-step, self.from[k] + border), (step, size + border - self.from[k])] {
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
        let ((from, key0), (to, key1)) = (self.at(t0), self.at(t1));
        Some(Segment { from, to, key: [key0, key1] })
    }
}

impl Canvas<'_> {
    /// Clips a segment to the near plane and to the image, widened by `border`.
    pub(super) fn clipped_segment(&self, a: &Projected, b: &Projected, border: f64) -> Option<Segment> {
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
        let size = [self.visibility.width, self.visibility.height];
        Segment::between(self.view, &a, &b).clipped(size, border)
    }
}

/// Projected polyline with its visible parts.
pub(super) struct Path {
    pub(super) segments: Vec<Segment>,
    /// Arc length before each segment, in samples.
    pub(super) start: Vec<f64>,
    total: f64,
    /// Whether the centre line is visible, per sample of arc length.
    visible: Vec<bool>,
}

impl Path {
    /// Determines where the centre line is visible, given by position and depth key. Visible and
    /// hidden parts between others that are shorter than `shortest` samples are removed.
    pub(super) fn new(
        segments: Vec<Segment>,
        shortest: usize,
        is_visible: impl Fn([f64; 2], f64) -> bool,
    ) -> Path {
        let mut start = Vec::with_capacity(segments.len());
        let mut total = 0.0;
        let mut visible = Vec::new();
        for segment in &segments {
            start.push(total);
            let end = total + segment.length();
            while (visible.len() as f64) < end.max(1.0) {
                let t = ((visible.len() as f64 + 0.5 - total) / segment.length().max(1e-9)).clamp(0.0, 1.0);
                let (position, key) = segment.at(t);
                visible.push(is_visible(position, key));
            }
            total = end;
        }
        flip_short_runs(&mut visible, shortest, false);
        flip_short_runs(&mut visible, shortest, true);
        Path { segments, start, total, visible }
    }

    pub(super) fn is_visible(&self, s: f64) -> bool {
        self.visible.get(s as usize).or(self.visible.last()).copied().unwrap_or(false)
    }

    fn at(&self, s: f64) -> Option<([f64; 2], f64)> {
        let i = self.start.partition_point(|start| *start <= s).saturating_sub(1);
        let segment = self.segments.get(i)?;
        let length = segment.length();
        Some(segment.at(if length > 0.0 { ((s - self.start[i]) / length).clamp(0.0, 1.0) } else { 0.0 }))
    }

    /// Returns evenly spaced arrowheads where the path is visible, each aligned with the chord over
    /// its own length.
    pub(super) fn arrowheads(&self, spacing: f64, width: f64) -> Vec<Arrowhead> {
        if self.total.is_nan() || self.total <= 0.0 {
            return Vec::new();
        }
        let count = (self.total / spacing).round().clamp(1.0, 10_000.0);
        let half = HEAD_LENGTH * width / 2.0;
        let head = |i: usize| {
            let s = (i as f64 + 0.5) * self.total / count;
            if !(self.is_visible((s - half).max(0.0)) && self.is_visible(s) && self.is_visible(s + half)) {
                return None;
            }
            let (position, key) = self.at(s)?;
            let ([ax, ay], [bx, by]) =
                (self.at((s - half).max(0.0))?.0, self.at((s + half).min(self.total))?.0);
            let length = (bx - ax).hypot(by - ay);
            let direction = [(bx - ax) / length, (by - ay) / length];
            (length > 0.0).then_some(Arrowhead { position, direction, key, width })
        };
        (0..count as usize).filter_map(head).collect()
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
