//! Colour of a sample: field lookup, colour map, isolines.

use crate::color::{CLAY, ColorMap, Linear, label_linear, mix, to_linear};
use crate::raster::FacePoint;
use crate::scene::{Isolines, Levels, Scene, SceneField};
use crate::short_isolines::short_zero_isolines;
use eikona_mesh::vector::Vec3;

/// Field of a scene, prepared for lookup.
pub(crate) struct Coloring<'a> {
    field: SceneField<'a>,
    triangles: &'a [[u32; 3]],
    map: ColorMap,
    /// Values at the ends of the colour map.
    range: [f64; 2],
    /// Values at the ends of the colour bar: by default the part of `range` that occurs.
    pub(crate) bar: [f64; 2],
    surface: Linear,
    lines: Option<Lines>,
}

/// Appearance of a face at a sample.
pub(crate) enum Shown {
    /// A colour.
    Color(Linear),
    /// The hatch for "no value".
    Missing,
}

struct Lines {
    style: Isolines,
    color: Linear,
    levels: Sorted,
    /// Isolines outside this interval are not drawn.
    between: [f64; 2],
    /// Faces whose zero isoline is too short to be drawn.
    short: Vec<bool>,
}

enum Sorted {
    Multiples(f64),
    Values(Vec<f64>),
}

/// Value at a sample, and its change per sample to the right and downwards.
struct Value {
    value: f64,
    dx: f64,
    dy: f64,
}

impl<'a> Coloring<'a> {
    pub(crate) fn new(scene: &Scene<'a>) -> Coloring<'a> {
        let occurring = occurring_range(&scene.field);
        let map = scene.color_map.clone().unwrap_or_else(|| {
            let both = occurring.is_some_and(|[low, high]| low < 0.0 && high > 0.0);
            if both { ColorMap::signed() } else { ColorMap::viridis() }
        });
        let range = scene.range.unwrap_or_else(|| automatic_range(occurring, &map));
        let bar = match (scene.range, occurring) {
            (None, Some([low, high])) if low < high => [low, high],
            _ => range,
        };
        let lines = scene.isolines.clone().map(|style| {
            let levels = match &style.levels {
                Levels::About(count) => {
                    Sorted::Multiples(round_step(half_span(bar) * 2.0, (*count).max(1) as f64))
                }
                Levels::Spacing(s) => Sorted::Multiples(*s),
                Levels::Values(values) => {
                    let mut sorted = values.clone();
                    sorted.sort_by(f64::total_cmp);
                    Sorted::Values(sorted)
                }
            };
            let between = match (&style.levels, &levels) {
                // An isoline at the very ends of the range would be scattered dashes around peaks
                // and pits.
                (Levels::About(_), Sorted::Multiples(step)) => [bar[0] + 0.02 * step, bar[1] - 0.02 * step],
                _ => [f64::NEG_INFINITY, f64::INFINITY],
            };
            let short = match scene.field {
                SceneField::Vertex(values) => short_zero_isolines(scene.mesh, values),
                _ => Vec::new(),
            };
            Lines { color: to_linear(style.color), style, levels, between, short }
        });
        Coloring {
            field: scene.field,
            triangles: scene.mesh.triangles(),
            map,
            range,
            bar,
            surface: to_linear(scene.surface_color.unwrap_or(CLAY)),
            lines,
        }
    }

    /// Returns the colour at a point of a face; `samples` is the number of samples along a pixel.
    pub(crate) fn at(&self, face: usize, point: Option<&FacePoint>, samples: f64) -> Shown {
        match self.field {
            SceneField::None => Shown::Color(self.surface),
            SceneField::Labels(labels) => Shown::Color(label_linear(labels[face])),
            SceneField::Face(values) if values[face].is_nan() => Shown::Missing,
            SceneField::Face(values) => Shown::Color(self.map.linear(self.fraction(values[face]))),
            SceneField::Vertex(values) => {
                let corners = self.triangles[face].map(|v| values[v as usize]);
                self.interpolated(face, corners, [1.0; 3], point, samples)
            }
            SceneField::Corner(values) => {
                self.interpolated(face, [0, 1, 2].map(|k| values[3 * face + k]), [1.0; 3], point, samples)
            }
            SceneField::Quotient { numerator, denominator } => {
                let corners = |v: &[f64]| [0, 1, 2].map(|k| v[3 * face + k]);
                self.interpolated(face, corners(numerator), corners(denominator), point, samples)
            }
        }
    }

    fn interpolated(
        &self,
        face: usize,
        numerator: Vec3,
        denominator: Vec3,
        point: Option<&FacePoint>,
        samples: f64,
    ) -> Shown {
        let here = value_at(numerator, denominator, point);
        if !here.value.is_finite() {
            return Shown::Missing;
        }
        let color = self.map.linear(self.fraction(here.value));
        match &self.lines {
            Some(lines) => Shown::Color(lines.over(color, face, &here, samples)),
            None => Shown::Color(color),
        }
    }

    /// Position of a value in the colour map, 0 to 1.
    fn fraction(&self, value: f64) -> f64 {
        fraction_of(self.range, value)
    }

    /// Position of a value in the colour bar, 0 at its lower end.
    pub(crate) fn bar_fraction(&self, value: f64) -> f64 {
        fraction_of(self.bar, value)
    }

    /// Returns the colour of the bar at a fraction of its length.
    pub(crate) fn bar_color(&self, fraction: f64) -> [u8; 3] {
        let [low, high] = self.bar.map(|v| self.fraction(v));
        self.map.color(low + fraction * (high - low))
    }

    /// Returns the labels that occur in increasing order; `None` if the field has no labels or more
    /// than `most`.
    pub(crate) fn labels(&self, most: usize) -> Option<Vec<i64>> {
        let SceneField::Labels(labels) = self.field else { return None };
        let mut found = std::collections::BTreeSet::new();
        for &label in labels {
            found.insert(label);
            if found.len() > most {
                return None;
            }
        }
        Some(found.into_iter().collect())
    }
}

/// Evaluates the quotient of numerator and denominator, both linear in the face, and its derivative
/// in the image: for `f = sum(e n) / sum(e d)` with `e` linear in the sample coordinates, `f' =
/// sum(e' (n - f d)) / sum(e d)`.
fn value_at(numerator: Vec3, denominator: Vec3, point: Option<&FacePoint>) -> Value {
    let Some(point) = point else {
        let value = numerator.iter().sum::<f64>() / denominator.iter().sum::<f64>();
        return Value { value, dx: 0.0, dy: 0.0 };
    };
    let sum = |w: Vec3, v: Vec3| w[0] * v[0] + w[1] * v[1] + w[2] * v[2];
    let below = sum(point.weights, denominator);
    let value = sum(point.weights, numerator) / below;
    let rest = [0, 1, 2].map(|k| numerator[k] - value * denominator[k]);
    Value { value, dx: sum(point.dx, rest) / below, dy: sum(point.dy, rest) / below }
}

impl Lines {
    /// Blends the nearest isoline over a colour.
    fn over(&self, color: Linear, face: usize, here: &Value, samples: f64) -> Linear {
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
        if zero && self.short.get(face) == Some(&true) {
            return color;
        }
        let width = if zero { self.style.zero_width } else { self.style.width };
        // Antialiased over one sample; the pixel filter does the rest.
        let coverage = ((width / 2.0 - distance) * samples + 0.5).clamp(0.0, 1.0);
        if coverage == 0.0 || !coverage.is_finite() {
            return color;
        }
        let opacity = if zero {
            1.0 - (1.0 - self.style.opacity) * 0.15
        } else {
            // Isolines closer together than their width would fill the face with their colour; fade
            // them instead.
            let gap = spacing / slope / self.style.width.max(1e-9);
            self.style.opacity * ((gap - 1.2) / 2.5).clamp(0.0, 1.0)
        };
        mix(color, self.color, (coverage * opacity) as f32)
    }

    /// Returns the level nearest to a value, and the spacing of levels there.
    fn nearest(&self, value: f64) -> (f64, f64) {
        match &self.levels {
            Sorted::Multiples(step) => ((value / step).round() * step, *step),
            Sorted::Values(values) => {
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

fn fraction_of(range: [f64; 2], value: f64) -> f64 {
    // Halve first: the difference of the ends may overflow.
    ((value / 2.0 - range[0] / 2.0) / half_span(range)).clamp(0.0, 1.0)
}

fn half_span([low, high]: [f64; 2]) -> f64 {
    high / 2.0 - low / 2.0
}

fn occurring_range(field: &SceneField) -> Option<[f64; 2]> {
    let over = |values: &mut dyn Iterator<Item = f64>| {
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for v in values.filter(|v| v.is_finite()) {
            range = [range[0].min(v), range[1].max(v)];
        }
        (range[0] <= range[1]).then_some(range)
    };
    match *field {
        SceneField::None | SceneField::Labels(_) => None,
        SceneField::Vertex(v) | SceneField::Face(v) | SceneField::Corner(v) => over(&mut v.iter().copied()),
        SceneField::Quotient { numerator, denominator } => {
            over(&mut numerator.iter().zip(denominator).map(|(n, d)| n / d))
        }
    }
}

fn automatic_range(occurring: Option<[f64; 2]>, map: &ColorMap) -> [f64; 2] {
    let [low, high] = occurring.unwrap_or([0.0, 1.0]);
    if map.is_diverging() {
        let most = low.abs().max(high.abs());
        if most > 0.0 { [-most, most] } else { [-1.0, 1.0] }
    } else if low < high {
        [low, high]
    } else {
        // A constant field: centre the range on its value.
        let reach = if low == 0.0 { 1.0 } else { low.abs() / 2.0 };
        [low - reach, high + reach]
    }
}

/// Returns the round number (1, 2 or 5 times a power of ten) that divides the span into about
/// `count` parts.
pub(crate) fn round_step(span: f64, count: f64) -> f64 {
    let raw = (span / count).clamp(1e-300, 1e300);
    let power = 10f64.powf(raw.log10().floor());
    let fraction = raw / power;
    power
        * if fraction < 1.5 {
            1.0
        } else if fraction < 3.5 {
            2.0
        } else if fraction < 7.5 {
            5.0
        } else {
            10.0
        }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_steps() {
        assert_eq!(round_step(10.0, 5.0), 2.0);
        assert_eq!(round_step(1.0, 10.0), 0.1);
        assert!((round_step(4.7e-6, 10.0) - 5e-7).abs() < 1e-20);
        assert!(round_step(f64::INFINITY, 3.0).is_finite());
        assert!(round_step(0.0, 3.0) > 0.0);
    }

    #[test]
    fn the_bar_shows_the_range_of_the_field() {
        let corners = vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
        let mesh = eikona_mesh::TriangleMesh::new(corners, vec![[0, 1, 2]]).unwrap();
        let scene = Scene::new(&mesh).vertex_scalar(&[-0.1, 0.3, 0.9]);
        let coloring = Coloring::new(&scene);
        let map = ColorMap::signed();
        assert_eq!((coloring.bar, coloring.map.name()), ([-0.1, 0.9], "signed"));
        assert_eq!(coloring.fraction(0.0), 0.5, "0 is the middle of the map");
        assert!((coloring.bar_fraction(0.0) - 0.1).abs() < 1e-12, "but not of the bar");
        assert_eq!(coloring.bar_color(1.0), map.color(1.0));
        assert_eq!(coloring.bar_color(0.0), map.color(0.4 / 0.9));
        assert_eq!(coloring.bar_color(0.1), map.color(0.5));
        // An explicit range is shown whole.
        let explicit = Coloring::new(&scene.range(-2.0, 1.0));
        assert_eq!((explicit.bar, explicit.bar_color(0.0)), ([-2.0, 1.0], map.color(0.0)));
        let same = Scene::new(&mesh).vertex_scalar(&[2.0; 3]);
        assert_eq!(Coloring::new(&same).bar, [1.0, 3.0], "a constant lies in the middle");
    }

    #[test]
    fn quotient_and_its_slope_match_finite_differences() {
        // A face in perspective: the weights at the corners differ.
        let h = [[0.0, 0.0, 1.0], [40.0, 4.0, 2.0], [6.0, 33.0, 1.5]];
        let (n, d) = ([1.0, -2.0, 0.5], [1.0, 3.0, 2.0]);
        let value = |x: f64, y: f64| value_at(n, d, FacePoint::at(h, x, y).as_ref());
        let (x, y, step) = (6.0, 7.0, 1e-5);
        let here = value(x, y);
        let dx = (value(x + step, y).value - value(x - step, y).value) / (2.0 * step);
        let dy = (value(x, y + step).value - value(x, y - step).value) / (2.0 * step);
        assert!(
            (here.dx - dx).abs() < 1e-8 && (here.dy - dy).abs() < 1e-8,
            "{} {dx} {} {dy}",
            here.dx,
            here.dy
        );
    }
}
