//! Output files of `eikona field`.

use crate::exit::Failure;
use crate::session::Session;
use eikona::polar_field::PolarField;
use eikona_mesh::SurfacePoint;
use std::fmt::Write as _;
use std::path::Path;

/// Formats of N vectors per face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldFormat {
    /// A header with N and the number of faces, then 3N numbers per face (Directional).
    Rawfield,
    /// A header line, then centroid and vectors per face.
    Csv,
}

/// Determines the format from a file name.
pub fn field_format(path: &Path) -> Result<FieldFormat, Failure> {
    let name = path.to_string_lossy().to_ascii_lowercase();
    if name.ends_with(".rawfield") {
        Ok(FieldFormat::Rawfield)
    } else if name.ends_with(".csv") {
        Ok(FieldFormat::Csv)
    } else {
        Err(Failure::Usage(format!("{}: unknown output format; use .rawfield or .csv", path.display())))
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
