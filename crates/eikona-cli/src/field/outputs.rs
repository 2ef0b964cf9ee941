//! Output files of `eikona field`.

use crate::directions::{marks, points_of, singular_points, streamlines};
use crate::exit::Failure;
use crate::picture::{PictureArguments, draw};
use crate::session::Session;
use eikona::contour::obj_lines;
use eikona::polar_field::{PolarField, Streamline};
use eikona_mesh::{SurfacePoint, counted};
use eikona_render::{Coloring, Scene};
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

/// Draws streamlines, or vectors as marks, and the singular points as dots with their index, red
/// for positive indices and blue for negative ones.
pub fn output_picture(
    path: &Path,
    field: &PolarField,
    lines: Option<&[Streamline]>,
    picture: &PictureArguments,
    session: &mut Session,
) -> Result<(), Failure> {
    let mut scene = Scene::new(field.mesh(), Coloring::default());
    scene.drawings = match lines {
        Some(lines) => streamlines(field, lines),
        None => {
            let sampled = session.solver("vectors per face", || field.per_face())?;
            vec![marks(field.mesh(), &sampled.vectors)]
        }
    };
    scene.drawings.extend(singular_points(&points_of(field), field.degree()));
    let png = session.phase("render", || draw(scene, picture))?;
    session.output("picture", path, png)
}
