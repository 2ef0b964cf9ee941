//! Isolines of a field, as part of the colour of the surface.

use crate::albedo::{Value, half_span};
use crate::color::{Linear, mix, to_linear};
use crate::drawing::{Isolines, Levels};
use eikona_mesh::round_step;

/// Isolines, prepared for lookup.
pub(crate) struct PreparedIsolines {
    levels: SortedLevels,
    /// Isolines outside this interval are not drawn.
    between: [f64; 2],
    width: f64,
    zero_width: f64,
    color: Linear,
    opacity: f64,
}

enum SortedLevels {
    Multiples(f64),
    Values(Vec<f64>),
}

impl PreparedIsolines {
    /// Prepares isolines of a field whose values in `bar` are shown.
    pub(crate) fn new(isolines: &Isolines, bar: [f64; 2]) -> PreparedIsolines {
        let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
        let (levels, between) = match &isolines.levels {
            Levels::About(count) => {
                let step = round_step(half_span(bar) * 2.0, (*count).max(1) as f64);
                // An isoline at the very ends of the range would be scattered dashes around peaks
                // and pits.
                (SortedLevels::Multiples(step), [bar[0] + 0.02 * step, bar[1] - 0.02 * step])
            }
            Levels::Spacing(s) => (SortedLevels::Multiples(*s), everywhere),
            Levels::Values(values) => {
                let mut sorted = values.clone();
                sorted.sort_by(f64::total_cmp);
                (SortedLevels::Values(sorted), everywhere)
            }
        };
        let &Isolines { width, zero_width, opacity, .. } = isolines;
        PreparedIsolines { levels, between, width, zero_width, color: to_linear(isolines.color), opacity }
    }

    /// Blends the nearest isoline over a colour; `short` leaves out the zero isoline.
    pub(crate) fn over(&self, color: Linear, here: &Value, short: bool, samples: f64) -> Linear {
        let slope = here.dx.hypot(here.dy) * samples; // change per pixel
        if !(slope > 0.0 && slope.is_finite()) {
            return color;
        }
        let (level, spacing) = self.nearest(here.value);
        if !(self.between[0]..=self.between[1]).contains(&level) {
            return color;
        }
        let distance = (here.value - level).abs() / slope;
        let zero = level == 0.0;
        if zero && short {
            return color;
        }
        let width = if zero { self.zero_width } else { self.width };
        // Antialiased over one sample; the pixel filter does the rest.
        let coverage = ((width / 2.0 - distance) * samples + 0.5).clamp(0.0, 1.0);
        if coverage == 0.0 || !coverage.is_finite() {
            return color;
        }
        let opacity = if zero {
            1.0 - (1.0 - self.opacity) * 0.15
        } else {
            // Isolines closer together than their width would fill the face with their colour; fade
            // them instead.
            let gap = spacing / slope / self.width.max(1e-9);
            self.opacity * ((gap - 1.2) / 2.5).clamp(0.0, 1.0)
        };
        mix(color, self.color, (coverage * opacity) as f32)
    }

    /// Returns the level nearest to a value, and the spacing of levels there.
    fn nearest(&self, value: f64) -> (f64, f64) {
        match &self.levels {
            SortedLevels::Multiples(step) => ((value / step).round() * step, *step),
            SortedLevels::Values(values) => {
                let i = values.partition_point(|v| *v < value);
                let below = i.checked_sub(1).and_then(|k| values.get(k)).copied();
                match (below, values.get(i).copied()) {
                    (Some(a), Some(b)) => (if value - a < b - value { a } else { b }, b - a),
                    (Some(a), None) | (None, Some(a)) => (a, f64::INFINITY),
                    (None, None) => (f64::INFINITY, f64::INFINITY),
                }
            }
        }
    }
}
