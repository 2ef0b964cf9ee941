//! Drawings of directions: streamlines, marks per face, singular points.

use crate::number::fraction;
use eikona::polar_field::{FaceVectors, Place, PolarField, Streamline};
use eikona_mesh::{Quality, TriangleMesh};
use eikona_render::{CurveStyle, Drawing, GlyphStyle, PointStyle, TextStyle};

/// Most marks in a picture; on finer meshes, evenly spaced faces have one.
const MOST_MARKS: usize = 3000;
/// Colours of singular points of positive and negative index.
const POSITIVE: [u8; 3] = [206, 52, 43];
const NEGATIVE: [u8; 3] = [38, 84, 168];
/// Most singular points whose index is written beside them.
const MOST_TEXTS: usize = 80;
/// Colour of streamlines.
const LINE: [u8; 3] = [42, 48, 60];

/// Returns streamlines, with arrows if N = 1.
pub fn streamlines(field: &PolarField, lines: &[Streamline]) -> Vec<Drawing<'static>> {
    let positions = lines.iter().map(|line| line.positions(field.mesh()));
    polylines(positions, (field.degree() == 1).then_some(90.0))
}

/// Returns polylines in the style of streamlines.
pub fn polylines(
    lines: impl Iterator<Item = Vec<[f64; 3]>>,
    arrow_spacing: Option<f64>,
) -> Vec<Drawing<'static>> {
    let style = CurveStyle { color: LINE, width: 1.6, outline: None, arrow_spacing };
    lines.map(|line| Drawing::Curve { points: line.into(), style: style.clone() }).collect()
}

/// Returns a mark for each of the N vectors at evenly chosen faces.
pub fn marks(mesh: &TriangleMesh, field: &FaceVectors) -> Drawing<'static> {
    let step = mesh.face_count().div_ceil(MOST_MARKS).max(1);
    let shown = mesh.face_count().div_ceil(step).max(1);
    // Marks fill about half of the distance between their centres.
    let length = 0.6 * (Quality::of(mesh).area / shown as f64).sqrt();
    let longest = field.vectors.iter().map(|v| v[0].hypot(v[1]).hypot(v[2])).fold(0.0, f64::max);
    let scale = if longest > 0.0 { length / longest } else { 0.0 };
    let degree = field.degree as usize;
    let directed = !degree.is_multiple_of(2);
    // Opposite directions share a mark.
    let per_face = if directed { degree } else { degree / 2 };
    let mut ends = Vec::new();
    for (face, own) in mesh.faces().zip(field.vectors.chunks(degree)).step_by(step) {
        let [a, b, c] = mesh.face_positions(face);
        let middle = [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0);
        for v in &own[..per_face] {
            let end = |s: f64| [0, 1, 2].map(|k| middle[k] + s * scale * v[k]);
            ends.push(if directed { [end(-0.35), end(0.65)] } else { [end(-0.5), end(0.5)] });
        }
    }
    let style = GlyphStyle { head: directed, ..GlyphStyle::default() };
    Drawing::Glyphs { ends: ends.into(), style }
}

/// Returns the singular points of a field with their index.
pub fn points_of(field: &PolarField) -> Vec<([f64; 3], f64)> {
    let mesh = field.mesh();
    let points = field.singularities().into_iter().filter_map(|s| match s.place {
        Place::Point(point) => Some((point.locate(mesh).ok()?.position(mesh), s.index)),
        Place::Boundary(_) => None,
    });
    points.collect()
}

/// Returns dots with their index, red for positive indices and blue for negative ones.
pub fn singular_points(points: &[([f64; 3], f64)], degree: u32) -> Vec<Drawing<'static>> {
    let mut drawings = Vec::new();
    for (color, sign) in [(POSITIVE, 1.0), (NEGATIVE, -1.0)] {
        let own = points.iter().filter(|(_, index)| index * sign > 0.0);
        let positions: Vec<[f64; 3]> = own.map(|(position, _)| *position).collect();
        if !positions.is_empty() {
            let style = PointStyle { color, radius: 7.0 };
            drawings.push(Drawing::Points { positions: positions.into(), style });
        }
    }
    let written: Vec<_> = points.iter().filter(|(_, index)| *index != 0.0).collect();
    // More of them would hide the field.
    if written.len() <= MOST_TEXTS {
        let (positions, texts): (Vec<_>, Vec<_>) =
            written.into_iter().map(|(position, index)| (*position, fraction(*index, degree))).unzip();
        let style = TextStyle::default();
        drawings.push(Drawing::Texts { positions: positions.into(), texts: texts.into(), style });
    }
    drawings
}
