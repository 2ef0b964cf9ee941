//! The colour of a place in a face: field, colour map, isolines.

use crate::color::{CLAY, ColorMap, Linear, label_linear, mix, to_linear};
use crate::crumbs::zero_crumbs;
use crate::raster::FacePlace;
use crate::scene::{Isolines, Levels, Scene, SceneField};
use crate::vector::V3;

/// The field of a scene, ready to be looked up.
pub(crate) struct Coloring<'a> {
    field: SceneField<'a>,
    triangles: &'a [[u32; 3]],
    map: ColorMap,
    /// Values at the ends of the colour map.
    range: [f64; 2],
    /// Values at the ends of the colour bar: the part of `range` that occurs.
    pub(crate) bar: [f64; 2],
    surface: Linear,
    lines: Option<Lines>,
}

/// What a face shows at a sample.
pub(crate) enum Shown {
    /// This colour.
    Color(Linear),
    /// The hatch for "no value".
    Missing,
}

struct Lines {
    style: Isolines,
    color: Linear,
    levels: Sorted,
    /// No line is drawn beyond these values.
    between: [f64; 2],
    /// Faces in which the line of value 0 is too short to be drawn.
    crumbs: Vec<bool>,
}

enum Sorted {
    Multiples(f64),
    Values(Vec<f64>),
}

/// The value at a sample and its change one sample to the right and one downwards.
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
        let range = scene.range.unwrap_or_else(|| chosen_range(occurring, &map));
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
                // A line at the very ends of the range would be a scatter of dashes around peaks
                // and pits.
                (Levels::About(_), Sorted::Multiples(step)) => [bar[0] + 0.02 * step, bar[1] - 0.02 * step],
                _ => [f64::NEG_INFINITY, f64::INFINITY],
            };
            let crumbs = match scene.field {
                SceneField::Vertex(values) => zero_crumbs(scene.mesh, values),
                _ => Vec::new(),
            };
            Lines { color: to_linear(style.color), style, levels, between, crumbs }
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

    /// The colour at a place in a face; `samples` is the number of samples along a pixel.
    pub(crate) fn at(&self, face: usize, place: Option<&FacePlace>, samples: f64) -> Shown {
        match self.field {
            SceneField::None => Shown::Color(self.surface),
            SceneField::Labels(labels) => Shown::Color(label_linear(labels[face])),
            SceneField::Face(values) if values[face].is_nan() => Shown::Missing,
            SceneField::Face(values) => Shown::Color(self.map.linear(self.share(values[face]))),
            SceneField::Vertex(values) => {
                let corners = self.triangles[face].map(|v| values[v as usize]);
                self.interpolated(face, corners, [1.0; 3], place, samples)
            }
            SceneField::Corner(values) => {
                self.interpolated(face, [0, 1, 2].map(|k| values[3 * face + k]), [1.0; 3], place, samples)
            }
            SceneField::Quotient { numerator, denominator } => {
                let corners = |v: &[f64]| [0, 1, 2].map(|k| v[3 * face + k]);
                self.interpolated(face, corners(numerator), corners(denominator), place, samples)
            }
        }
    }

    fn interpolated(
        &self,
        face: usize,
        numerator: V3,
        denominator: V3,
        place: Option<&FacePlace>,
        samples: f64,
    ) -> Shown {
        let here = value_at(numerator, denominator, place);
        if !here.value.is_finite() {
            return Shown::Missing;
        }
        let color = self.map.linear(self.share(here.value));
        match &self.lines {
            Some(lines) => Shown::Color(lines.over(color, face, &here, samples)),
            None => Shown::Color(color),
        }
    }

    /// The place of a value in the colour map, 0 to 1.
    fn share(&self, value: f64) -> f64 {
        share_of(self.range, value)
    }

    /// The place of a value in the colour bar, 0 at its lower end.
    pub(crate) fn share_of_bar(&self, value: f64) -> f64 {
        share_of(self.bar, value)
    }

    /// The colour of the bar at a share of its length.
    pub(crate) fn bar_color(&self, share: f64) -> [u8; 3] {
        let [low, high] = self.bar.map(|v| self.share(v));
        self.map.color(low + share * (high - low))
    }

    /// The labels that occur, in increasing order; `None` when the field is not of labels or there
    /// are more than `most`.
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

/// `N / D` for numerator and denominator that are linear in the face, and its derivative in the
/// picture: with `e` linear in the sample, `f = sum(e n) / sum(e d)` gives `f' = sum(e' (n - f d))
/// / sum(e d)`.
fn value_at(numerator: V3, denominator: V3, place: Option<&FacePlace>) -> Value {
    let Some(place) = place else {
        let value = numerator.iter().sum::<f64>() / denominator.iter().sum::<f64>();
        return Value { value, dx: 0.0, dy: 0.0 };
    };
    let sum = |w: V3, v: V3| w[0] * v[0] + w[1] * v[1] + w[2] * v[2];
    let below = sum(place.weights, denominator);
    let value = sum(place.weights, numerator) / below;
    let rest = [0, 1, 2].map(|k| numerator[k] - value * denominator[k]);
    Value { value, dx: sum(place.dx, rest) / below, dy: sum(place.dy, rest) / below }
}

impl Lines {
    /// The colour with the nearest line over it.
    fn over(&self, color: Linear, face: usize, here: &Value, samples: f64) -> Linear {
        let slope = here.dx.hypot(here.dy) * samples; // change a pixel
        if !(slope > 0.0 && slope.is_finite()) {
            return color;
        }
        let (level, spacing) = self.nearest(here.value);
        if !(self.between[0]..=self.between[1]).contains(&level) {
            return color;
        }
        let distance = (here.value - level).abs() / slope;
        let zero = level == 0.0;
        if zero && self.crumbs.get(face) == Some(&true) {
            return color;
        }
        let width = if zero { self.style.zero_width } else { self.style.width };
        // One sample of softness; the filter over the samples does the rest.
        let coverage = ((width / 2.0 - distance) * samples + 0.5).clamp(0.0, 1.0);
        if coverage == 0.0 || !coverage.is_finite() {
            return color;
        }
        let opacity = if zero {
            1.0 - (1.0 - self.style.opacity) * 0.15
        } else {
            // Lines nearer to each other than they are wide would fill the face with black: they
            // fade instead.
            let gap = spacing / slope / self.style.width.max(1e-9);
            self.style.opacity * ((gap - 1.2) / 2.5).clamp(0.0, 1.0)
        };
        mix(color, self.color, (coverage * opacity) as f32)
    }

    /// The level nearest to a value and the distance between levels there.
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

fn share_of(range: [f64; 2], value: f64) -> f64 {
    // Halves: the difference of the ends may overflow.
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

fn chosen_range(occurring: Option<[f64; 2]>, map: &ColorMap) -> [f64; 2] {
    let [low, high] = occurring.unwrap_or([0.0, 1.0]);
    if map.is_diverging() {
        let most = low.abs().max(high.abs());
        if most > 0.0 { [-most, most] } else { [-1.0, 1.0] }
    } else if low < high {
        [low, high]
    } else {
        // One value everywhere: a range about it in which it is in the middle.
        let reach = if low == 0.0 { 1.0 } else { low.abs() / 2.0 };
        [low - reach, high + reach]
    }
}

/// The round number (1, 2 or 5 times a power of ten) that divides the span into about `count`
/// parts.
pub(crate) fn round_step(span: f64, count: f64) -> f64 {
    let raw = (span / count).clamp(1e-300, 1e300);
    let power = 10f64.powf(raw.log10().floor());
    let share = raw / power;
    power
        * if share < 1.5 {
            1.0
        } else if share < 3.5 {
            2.0
        } else if share < 7.5 {
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
    fn the_bar_shows_the_values_that_occur_in_the_colours_they_have() {
        let corners = vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
        let mesh = eikona_mesh::TriangleMesh::new(corners, vec![[0, 1, 2]]).unwrap();
        let scene = Scene::new(&mesh).vertex_scalar(&[-0.1, 0.3, 0.9]);
        let coloring = Coloring::new(&scene);
        let map = ColorMap::signed();
        assert_eq!((coloring.bar, coloring.map.name()), ([-0.1, 0.9], "signed"));
        assert_eq!(coloring.share(0.0), 0.5, "0 is the middle of the map");
        assert!((coloring.share_of_bar(0.0) - 0.1).abs() < 1e-12, "but not of the bar");
        assert_eq!(coloring.bar_color(1.0), map.color(1.0));
        assert_eq!(coloring.bar_color(0.0), map.color(0.4 / 0.9));
        assert_eq!(coloring.bar_color(0.1), map.color(0.5));
        // A range that was asked for is shown whole.
        let asked = Coloring::new(&scene.range(-2.0, 1.0));
        assert_eq!((asked.bar, asked.bar_color(0.0)), ([-2.0, 1.0], map.color(0.0)));
        let same = Scene::new(&mesh).vertex_scalar(&[2.0; 3]);
        assert_eq!(Coloring::new(&same).bar, [1.0, 3.0], "one value lies in the middle");
    }

    #[test]
    fn quotient_and_its_slope_match_finite_differences() {
        // A face in perspective: the weights at the corners differ.
        let h = [[0.0, 0.0, 1.0], [40.0, 4.0, 2.0], [6.0, 33.0, 1.5]];
        let (n, d) = ([1.0, -2.0, 0.5], [1.0, 3.0, 2.0]);
        let value = |x: f64, y: f64| value_at(n, d, FacePlace::at(h, x, y).as_ref());
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
