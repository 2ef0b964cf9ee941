//! What the field follows, and automatic prescriptions.

use crate::exit::Failure;
use crate::field::prescription::{entry, is_sings};
use crate::input::MeshInput;
use crate::session::Session;
use crate::source::{SourceArguments, read_source};
use eikona::polar_field::{CREASE_DEGREES, Guide, Place, Prescription};
use eikona_mesh::SurfacePoint;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// A value of `--align`.
#[derive(Clone, Debug, PartialEq)]
pub enum Alignment {
    Boundary,
    Creases(f64),
    Curve(PathBuf),
}

/// Reads a value of `--align`. Words come before file names; `./boundary` is a file.
pub fn parse_alignment(text: &str) -> Result<Alignment, String> {
    match text.split_once('=') {
        None if text == "boundary" => Ok(Alignment::Boundary),
        None if text == "creases" => Ok(Alignment::Creases(CREASE_DEGREES)),
        Some(("creases", degrees)) => match degrees.parse() {
            Ok(degrees) if degrees > 0.0 && degrees < 180.0 => Ok(Alignment::Creases(degrees)),
            _ => Err(format!("{degrees} is not an angle in degrees between 0 and 180; give creases=30, say")),
        },
        _ if text.is_empty() => Err("expected boundary, creases, creases=DEG or a curve file".into()),
        _ => Ok(Alignment::Curve(text.into())),
    }
}

/// Returns the curve files.
pub fn files(alignments: &[Alignment]) -> impl Iterator<Item = &Path> {
    alignments.iter().filter_map(|alignment| match alignment {
        Alignment::Curve(path) => Some(path.as_path()),
        Alignment::Boundary | Alignment::Creases(_) => None,
    })
}

/// Reads the curves and returns all guides.
pub fn read_guides(
    alignments: &[Alignment],
    input: &MeshInput,
    session: &mut Session,
) -> Result<Vec<Guide>, Failure> {
    let mut guides = Vec::with_capacity(alignments.len());
    for alignment in alignments {
        guides.push(match alignment {
            Alignment::Boundary => Guide::Boundary,
            Alignment::Creases(degrees) => Guide::Creases { degrees: *degrees },
            Alignment::Curve(path) => {
                let source = SourceArguments { curve: vec![path.clone()], ..SourceArguments::default() };
                Guide::Curves(read_source(&source, input, session)?.0)
            }
        });
    }
    Ok(guides)
}

/// How `--auto` finds singularities.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Automatic {
    /// Of the smoothest field, near what `--align` names.
    Smoothest,
    /// Of a field along the principal curvatures, where they differ.
    Curvature,
}

impl Automatic {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Automatic::Smoothest => "smoothest",
            Automatic::Curvature => "curvature",
        }
    }
}

/// Writes a prescription in the form that `--singularities` and `--cycles` read, in the numbers of
/// the mesh file.
pub fn output_prescription(
    [singularities, cycles]: [Option<&Path>; 2],
    prescription: &Prescription,
    degree: u32,
    input: &MeshInput,
    session: &mut Session,
) -> Result<(), Failure> {
    if let Some(path) = singularities.filter(|path| is_sings(path)) {
        let text = sings(path, prescription, degree, input)?;
        session.output("singularities", path, text.into_bytes())?;
    } else if let Some(path) = singularities {
        let entries: Vec<Value> =
            prescription.singularities.iter().map(|s| entry(s, |v| input.vertex_in_file(v))).collect();
        let lines: Vec<String> = entries.iter().map(Value::to_string).collect();
        session.output("singularities", path, format!("[{}]\n", lines.join(",\n ")).into_bytes())?;
    }
    if let Some(path) = cycles {
        session.output("cycles", path, format!("{}\n", json!(prescription.generators)).into_bytes())?;
    }
    Ok(())
}

/// Lists vertices with their index times N. Other places have no row in this format.
fn sings(
    path: &Path,
    prescription: &Prescription,
    degree: u32,
    input: &MeshInput,
) -> Result<String, Failure> {
    let mut rows = Vec::with_capacity(prescription.singularities.len());
    for singularity in prescription.singularities.iter().filter(|s| s.index != 0.0) {
        let Place::Point(SurfacePoint::Vertex { vertex }) = singularity.place else {
            return Err(Failure::Input(format!(
                "{}: this format is for singularities at vertices only; write .json, or add --split MESH.obj",
                path.display()
            )));
        };
        let vertex = input.vertex_in_file(vertex);
        rows.push(format!("{vertex} {}\n", (singularity.index * f64::from(degree)).round()));
    }
    Ok(format!("{degree} {}\n{}", rows.len(), rows.concat()))
}
