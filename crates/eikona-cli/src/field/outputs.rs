//! Output files of `eikona field`.

use crate::exit::Failure;
use crate::number::fraction;
use crate::picture::{PictureArguments, draw};
use crate::session::Session;
use eikona::contour::obj_lines;
use eikona::polar_field::{Place, PolarField, Singularity, Streamline};
use eikona_mesh::{Quality, SurfacePoint, counted};
use eikona_render::{Coloring, CurveStyle, Drawing, GlyphStyle, PointStyle, Scene, TextStyle};
use std::fmt::Write as _;
use std::path::Path;

/// Writes the vectors at points, with their positions.
pub fn output_samples(
    path: &Path,
    field: &PolarField,
    points: &[SurfacePoint],
    scaled: bool,
    session: &mut Session,
) -> Result<(), Failure> {
    let mut rows = Vec::with_capacity(points.len());
    for &point in points {
        let located = point.locate(field.mesh()).map_err(|e| Failure::Input(e.to_string()))?;
        let vectors = if scaled { field.scaled_vectors_at(point) } else { field.vectors_at(point) };
        let vectors = vectors.map_err(|e| Failure::Input(e.to_string()))?;
        rows.push((located.position(field.mesh()), vectors));
    }
    let rows = rows.iter().map(|(position, vectors)| (*position, vectors.as_slice()));
    session.output("samples", path, table(field.degree(), rows).into_bytes())
}

/// Returns a header line, then per point its position and N vectors.
pub fn table<'a>(degree: u32, rows: impl Iterator<Item = ([f64; 3], &'a [[f64; 3]])>) -> String {
    let mut text = String::from("x,y,z");
    for k in 0..degree {
        let _ = write!(text, ",vx{k},vy{k},vz{k}");
    }
    text.push('\n');
    for (position, vectors) in rows {
        let numbers = position.iter().chain(vectors.as_flattened());
        let numbers: Vec<String> = numbers.map(|x| format!("{x:?}")).collect();
        let _ = writeln!(text, "{}", numbers.join(","));
    }
    text
}

fn vectors(field: &PolarField, point: SurfacePoint) -> Result<Vec<[f64; 3]>, Failure> {
    field.vectors_at(point).map_err(|e| Failure::Input(e.to_string()))
}

/// Writes streamlines as OBJ polylines.
pub fn output_streamlines(
    path: &Path,
    field: &PolarField,
    lines: &[Streamline],
    session: &mut Session,
) -> Result<(), Failure> {
    let polylines: Vec<_> = lines.iter().map(|line| line.positions(field.mesh())).collect();
    let text = obj_lines(&polylines).map_err(|e| Failure::Failed(e.to_string()))?;
    session.note(&counted(lines.len(), "streamline", "streamlines"));
    session.output("streamlines", path, text.into_bytes())
}

/// Most glyphs in a picture; on finer meshes, evenly spaced faces have one.
const MOST_GLYPHS: usize = 3000;
/// Colours of singular points of positive and negative index.
const POSITIVE: [u8; 3] = [206, 52, 43];
const NEGATIVE: [u8; 3] = [38, 84, 168];
/// Most singular points whose index is written beside them.
const MOST_TEXTS: usize = 80;
/// Colour of streamlines.
const LINE: [u8; 3] = [42, 48, 60];

/// Draws streamlines, or vectors as marks, and the singular points as dots with their index, red
/// for positive indices and blue for negative ones.
pub fn output_picture(
    path: &Path,
    field: &PolarField,
    lines: Option<&[Streamline]>,
    singularities: &[Singularity],
    picture: &PictureArguments,
    session: &mut Session,
) -> Result<(), Failure> {
    let mesh = field.mesh();
    let mut scene = Scene::new(mesh, Coloring::default());
    match lines {
        Some(lines) => {
            let arrow_spacing = (field.degree() == 1).then_some(90.0);
            let style = CurveStyle { color: LINE, width: 1.6, outline: None, arrow_spacing };
            for line in lines {
                let points = line.positions(mesh).into();
                scene = scene.with(Drawing::Curve { points, style: style.clone() });
            }
        }
        None => scene = scene.with(glyphs(field)?),
    }
    let mut texts: Vec<([f64; 3], String)> = Vec::new();
    for (color, sign) in [(POSITIVE, 1.0), (NEGATIVE, -1.0)] {
        let place = |s: &Singularity| match s.place {
            Place::Point(point) => Some((point.locate(mesh).ok()?.position(mesh), s.index)),
            Place::Boundary(_) => None,
        };
        let points: Vec<([f64; 3], f64)> =
            singularities.iter().filter(|s| s.index * sign > 0.0).filter_map(place).collect();
        if !points.is_empty() {
            let style = PointStyle { color, radius: 7.0 };
            let positions = points.iter().map(|(position, _)| *position).collect();
            scene = scene.with(Drawing::Points { positions, style });
        }
        texts.extend(points.into_iter().map(|(p, index)| (p, fraction(index, field.degree()))));
    }
    // More of them would hide the field.
    if texts.len() <= MOST_TEXTS {
        let (positions, texts): (Vec<_>, Vec<_>) = texts.into_iter().unzip();
        let style = TextStyle::default();
        scene = scene.with(Drawing::Texts { positions: positions.into(), texts: texts.into(), style });
    }
    let png = session.phase("render", || draw(scene, picture))?;
    session.output("picture", path, png)
}

/// Returns a mark for each of the N vectors at evenly chosen faces.
fn glyphs(field: &PolarField) -> Result<Drawing<'static>, Failure> {
    let mesh = field.mesh();
    let step = mesh.face_count().div_ceil(MOST_GLYPHS);
    let area: f64 = Quality::of(mesh).area;
    let shown = mesh.face_count().div_ceil(step);
    // Marks fill about half of the distance between their centres.
    let length = 0.6 * (area / shown as f64).sqrt();
    let directed = field.degree() % 2 == 1;
    // Opposite directions share a mark.
    let per_face = if directed { field.degree() } else { field.degree() / 2 } as usize;
    let mut ends = Vec::new();
    for &[a, b, c] in mesh.triangles().iter().step_by(step) {
        let point = SurfacePoint::Face { vertices: [a, b, c], bary: [0.25, 0.25, 0.5] };
        let middle = point.locate(mesh).map_err(|e| Failure::Input(e.to_string()))?.position(mesh);
        for v in vectors(field, point)?.into_iter().take(per_face) {
            let end = |s: f64| [0, 1, 2].map(|k| middle[k] + s * length * v[k]);
            ends.push(if directed { [end(-0.35), end(0.65)] } else { [end(-0.5), end(0.5)] });
        }
    }
    let style = GlyphStyle { head: directed, ..GlyphStyle::default() };
    Ok(Drawing::Glyphs { ends: ends.into(), style })
}
