//! Colour of the surface at a sample, before it is lit: field lookup, colour map, isolines.

use crate::color::{ColorMap, Linear, label_linear, to_linear};
use crate::drawing::Drawing;
use crate::isolines::PreparedIsolines;
use crate::raster::FacePoint;
use crate::scene::{Coloring, ScalarField, Scene, Values};
use crate::short_isolines::short_zero_isolines;
use eikona_mesh::vector::Vec3;

/// Colouring of a scene, prepared for lookup.
pub(crate) enum Albedo<'a> {
    Plain(Linear),
    Field(MappedField<'a>),
    Labels(&'a [i64]),
}

impl<'a> Albedo<'a> {
    pub(crate) fn new(scene: &Scene<'a>) -> Albedo<'a> {
        match &scene.coloring {
            Coloring::Plain(color) => Albedo::Plain(to_linear(*color)),
            Coloring::Field(field) => Albedo::Field(MappedField::new(scene, field)),
            Coloring::Labels { labels, .. } => Albedo::Labels(labels),
        }
    }

    /// Returns the colour at a point of a face, or `None` where the field has no value; `samples`
    /// is the number of samples along a pixel.
    pub(crate) fn at(&self, face: usize, point: Option<&FacePoint>, samples: f64) -> Option<Linear> {
        match self {
            Albedo::Plain(color) => Some(*color),
            Albedo::Field(field) => field.at(face, point, samples),
            Albedo::Labels(labels) => Some(label_linear(labels[face])),
        }
    }
}

/// Scalar field with its colour map and isolines.
pub(crate) struct MappedField<'a> {
    values: Values<'a>,
    triangles: &'a [[u32; 3]],
    map: ColorMap,
    /// Values at the ends of the colour map.
    range: [f64; 2],
    /// Values at the ends of the colour bar: by default the part of `range` that occurs.
    pub(crate) bar: [f64; 2],
    isolines: Vec<PreparedIsolines>,
    /// Faces whose zero isoline is too short to be drawn.
    short: Vec<bool>,
}

/// Value at a sample, and its change per sample to the right and downwards.
pub(crate) struct Value {
    pub(crate) value: f64,
    pub(crate) dx: f64,
    pub(crate) dy: f64,
}

impl<'a> MappedField<'a> {
    fn new(scene: &Scene<'a>, field: &ScalarField<'a>) -> MappedField<'a> {
        let occurring = occurring_range(&field.values);
        let map = field.color_map.clone().unwrap_or_else(|| {
            let both = occurring.is_some_and(|[low, high]| low < 0.0 && high > 0.0);
            if both { ColorMap::signed() } else { ColorMap::viridis() }
        });
        let range = field.range.unwrap_or_else(|| automatic_range(occurring, &map));
        let bar = match (field.range, occurring) {
            (None, Some([low, high])) if low < high => [low, high],
            _ => range,
        };
        let isolines: Vec<PreparedIsolines> = scene
            .drawings
            .iter()
            .filter_map(|drawing| match drawing {
                Drawing::Isolines(isolines) => Some(PreparedIsolines::new(isolines, bar)),
                _ => None,
            })
            .collect();
        let short = match field.values {
            Values::PerVertex(values) if !isolines.is_empty() => short_zero_isolines(scene.mesh, values),
            _ => Vec::new(),
        };
        let triangles = scene.mesh.triangles();
        MappedField { values: field.values, triangles, map, range, bar, isolines, short }
    }

    fn at(&self, face: usize, point: Option<&FacePoint>, samples: f64) -> Option<Linear> {
        let corners = |v: &[f64]| [0, 1, 2].map(|k| v[3 * face + k]);
        let here = match self.values {
            Values::PerFace(v) => {
                return (!v[face].is_nan()).then(|| self.map.linear(self.fraction(v[face])));
            }
            Values::PerVertex(v) => {
                value_at(self.triangles[face].map(|vertex| v[vertex as usize]), [1.0; 3], point)
            }
            Values::PerCorner(v) => value_at(corners(v), [1.0; 3], point),
            Values::Quotient { numerator, denominator } => {
                value_at(corners(numerator), corners(denominator), point)
            }
        };
        if !here.value.is_finite() {
            return None;
        }
        let short = self.short.get(face) == Some(&true);
        let color = self.map.linear(self.fraction(here.value));
        Some(self.isolines.iter().fold(color, |below, lines| lines.over(below, &here, short, samples)))
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

fn fraction_of(range: [f64; 2], value: f64) -> f64 {
    // Halve first: the difference of the ends may overflow.
    ((value / 2.0 - range[0] / 2.0) / half_span(range)).clamp(0.0, 1.0)
}

pub(crate) fn half_span([low, high]: [f64; 2]) -> f64 {
    high / 2.0 - low / 2.0
}

fn occurring_range(values: &Values) -> Option<[f64; 2]> {
    let over = |values: &mut dyn Iterator<Item = f64>| {
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for v in values.filter(|v| v.is_finite()) {
            range = [range[0].min(v), range[1].max(v)];
        }
        (range[0] <= range[1]).then_some(range)
    };
    match *values {
        Values::PerVertex(v) | Values::PerFace(v) | Values::PerCorner(v) => over(&mut v.iter().copied()),
        Values::Quotient { numerator, denominator } => {
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
        let reach = if low == 0.0 { 1.0 } else { (low.abs() / 2.0).max(f64::MIN_POSITIVE) };
        [(low - reach).max(f64::MIN), (high + reach).min(f64::MAX)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_shows_the_range_of_the_field() {
        let corners = vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
        let mesh = eikona_mesh::TriangleMesh::new(corners, vec![[0, 1, 2]]).unwrap();
        let scene = Scene::new(&mesh, Coloring::default());
        let mapped = |values, range| {
            MappedField::new(&scene, &ScalarField { range, ..ScalarField::new(Values::PerVertex(values)) })
        };
        let field = mapped(&[-0.1, 0.3, 0.9], None);
        let map = ColorMap::signed();
        assert_eq!((field.bar, field.map.name()), ([-0.1, 0.9], "signed"));
        assert_eq!(field.fraction(0.0), 0.5, "0 is the middle of the map");
        assert!((field.bar_fraction(0.0) - 0.1).abs() < 1e-12, "but not of the bar");
        assert_eq!(field.bar_color(1.0), map.color(1.0));
        assert_eq!(field.bar_color(0.0), map.color(0.4 / 0.9));
        assert_eq!(field.bar_color(0.1), map.color(0.5));
        // An explicit range is shown whole.
        let explicit = mapped(&[-0.1, 0.3, 0.9], Some([-2.0, 1.0]));
        assert_eq!((explicit.bar, explicit.bar_color(0.0)), ([-2.0, 1.0], map.color(0.0)));
        assert_eq!(mapped(&[2.0; 3], None).bar, [1.0, 3.0], "a constant lies in the middle");
        for constant in [f64::MAX, f64::MIN, 5e-324, -1e-310] {
            let values = [constant; 3];
            let field = MappedField::new(&scene, &ScalarField::new(Values::PerVertex(&values)));
            let [low, high] = field.bar;
            assert!(low.is_finite() && high.is_finite() && low < high, "{low} {high}");
            assert!((0.0..=1.0).contains(&field.fraction(constant)), "{constant}");
        }
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
