//! Output files of `eikona field`.

use crate::exit::Failure;
use crate::number::fraction;
use crate::picture::{PictureArguments, draw};
use crate::session::Session;
use eikona::contour::obj_lines;
use eikona::polar_field::{Match, Place, PolarField, Singularity, Streamline};
use eikona_mesh::{Quality, SurfacePoint, counted};
use eikona_render::{Coloring, CurveStyle, Drawing, GlyphStyle, PointStyle, Scene, TextStyle};
use std::fmt::Write as _;
use std::path::Path;

/// Formats of N vectors per face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldFormat {
    /// A header with N and the number of faces, then 3N numbers per face (Directional).
    Rawfield,
    /// A header line, then centroid and vectors per face.
    Csv,
    /// The number of faces, 4, and the first of four vectors per face (QuadWild).
    Rosy,
}

/// Determines the format from a file name.
pub fn field_format(path: &Path) -> Result<FieldFormat, Failure> {
    let name = path.to_string_lossy().to_ascii_lowercase();
    if name.ends_with(".rawfield") {
        Ok(FieldFormat::Rawfield)
    } else if name.ends_with(".csv") {
        Ok(FieldFormat::Csv)
    } else if name.ends_with(".rosy") {
        Ok(FieldFormat::Rosy)
    } else {
        Err(Failure::Usage(format!(
            "{}: unknown output format; use .rawfield, .rosy or .csv",
            path.display()
        )))
    }
}

/// Writes the vectors at the centroids of all faces.
pub fn output_field(
    path: &Path,
    format: FieldFormat,
    field: &PolarField,
    session: &mut Session,
) -> Result<(), Failure> {
    let centroid = |corners: &[u32; 3]| {
        let third = 1.0 / 3.0;
        SurfacePoint::Face { vertices: *corners, bary: [third, third, 1.0 - 2.0 * third] }
    };
    let points: Vec<SurfacePoint> = field.mesh().triangles().iter().map(centroid).collect();
    let text = match format {
        FieldFormat::Csv => table(field, &points)?,
        FieldFormat::Rosy => {
            let mut text = format!("{}\n4\n", points.len());
            for &point in &points {
                let [x, y, z] = vectors(field, point)?[0];
                let _ = writeln!(text, "{x:?} {y:?} {z:?}");
            }
            text
        }
        FieldFormat::Rawfield => {
            let mut text = format!("{} {}\n", field.degree(), points.len());
            for &point in &points {
                let numbers: Vec<String> =
                    vectors(field, point)?.iter().flatten().map(|x| format!("{x:?}")).collect();
                let _ = writeln!(text, "{}", numbers.join(" "));
            }
            text
        }
    };
    session.output("field", path, text.into_bytes())
}

/// Writes how the vectors of neighbouring faces continue each other: N and the number of rows, then
/// two faces, the vertices of their edge, and the shift (Directional).
pub fn output_matching(path: &Path, field: &PolarField, session: &mut Session) -> Result<(), Failure> {
    let rows = field.matching();
    let mut text = format!("{} {}\n", field.degree(), rows.len());
    for Match { faces: [f, g], vertices, shift } in rows {
        let [v, w] = vertices.map(|pair| pair.map(|v| v.0)).unwrap_or_default();
        let _ = writeln!(text, "{} {} {v} {w} {shift}", f.0, g.0);
    }
    session.output("matching", path, text.into_bytes())
}

/// Writes the vectors at points, with their positions.
pub fn output_samples(
    path: &Path,
    field: &PolarField,
    points: &[SurfacePoint],
    session: &mut Session,
) -> Result<(), Failure> {
    session.output("samples", path, table(field, points)?.into_bytes())
}

fn table(field: &PolarField, points: &[SurfacePoint]) -> Result<String, Failure> {
    let mut text = String::from("x,y,z");
    for k in 0..field.degree() {
        let _ = write!(text, ",vx{k},vy{k},vz{k}");
    }
    text.push('\n');
    for &point in points {
        let located = point.locate(field.mesh()).map_err(|e| Failure::Input(e.to_string()))?;
        let vectors = vectors(field, point)?;
        let numbers = located.position(field.mesh()).into_iter().chain(vectors.into_iter().flatten());
        let numbers: Vec<String> = numbers.map(|x| format!("{x:?}")).collect();
        let _ = writeln!(text, "{}", numbers.join(","));
    }
    Ok(text)
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
