//! Files of N vectors per face, of the mesh they belong to, and of the field itself.

use crate::exit::Failure;
use crate::field::outputs::table;
use crate::numpy::npy;
use crate::session::Session;
use crate::stored_field::{json_of_field, npz_of_field};
use eikona::polar_field::{Match, PolarField, SampledField};
use eikona_mesh::io::{MeshFormat, MeshOut};
use std::fmt::Write as _;
use std::path::Path;

/// Formats of fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldFormat {
    /// A header with N and the number of faces, then 3N numbers per face (Directional).
    Rawfield,
    /// A header line, then place and vectors per face.
    Csv,
    /// The number of faces, 4, and the first of four vectors per face (QuadWild).
    Rosy,
    /// NumPy array of doubles, shape (F, N, 3).
    Npy,
    /// The mesh with vectors `v0` to `vN-1` per face.
    Mesh(MeshFormat),
    /// The field itself, as arrays.
    Npz,
    /// The field itself, as text.
    Json,
}

impl FieldFormat {
    /// Whether a format holds the field itself, rather than vectors per face.
    pub fn is_stored(self) -> bool {
        matches!(self, FieldFormat::Npz | FieldFormat::Json)
    }
}

/// Determines the format from a file name.
pub fn field_format(path: &Path) -> Result<FieldFormat, Failure> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("rawfield") => Ok(FieldFormat::Rawfield),
        Some("csv") => Ok(FieldFormat::Csv),
        Some("rosy") => Ok(FieldFormat::Rosy),
        Some("npy") => Ok(FieldFormat::Npy),
        Some("ply") => Ok(FieldFormat::Mesh(MeshFormat::Ply)),
        Some("vtp") => Ok(FieldFormat::Mesh(MeshFormat::Vtp)),
        Some("npz") => Ok(FieldFormat::Npz),
        Some("json") => Ok(FieldFormat::Json),
        _ => Err(Failure::Usage(format!(
            "{}: unknown output format; use .rawfield, .rosy, .csv, .npy, .vtp or .ply for vectors per face, .npz or \
             .json for the field itself",
            path.display()
        ))),
    }
}

/// Determines the format of the split mesh from its name.
pub fn split_format(path: &Path) -> Result<MeshFormat, Failure> {
    MeshFormat::from_path(path).ok_or_else(|| {
        Failure::Usage(format!(
            "{}: unknown format for the split mesh; use .obj, .off, .ply, .vtp, .stl, .glb or .gltf",
            path.display()
        ))
    })
}

/// Writes the field itself.
pub fn output_stored(
    path: &Path,
    format: FieldFormat,
    field: &PolarField,
    session: &mut Session,
) -> Result<(), Failure> {
    let data = field.data();
    let bytes = if format == FieldFormat::Json { json_of_field(data) } else { npz_of_field(&data) };
    session.output("field", path, bytes.map_err(Failure::encoding)?)
}

/// Writes the vectors of all faces.
pub fn output_field(
    path: &Path,
    format: FieldFormat,
    sampled: &SampledField,
    session: &mut Session,
) -> Result<(), Failure> {
    let degree = sampled.vectors.degree;
    let vectors = &sampled.vectors.vectors;
    let of_faces = || vectors.chunks(degree as usize);
    let bytes = match format {
        FieldFormat::Mesh(_) => return output_mesh(path, sampled, session),
        FieldFormat::Npy => {
            let shape = [sampled.mesh.face_count(), degree as usize, 3];
            npy(&shape, vectors.as_flattened()).map_err(Failure::encoding)?
        }
        FieldFormat::Csv => table(degree, sampled.places.iter().copied().zip(of_faces())).into_bytes(),
        FieldFormat::Rosy => {
            let mut text = format!("{}\n4\n", sampled.mesh.face_count());
            for own in of_faces() {
                let [x, y, z] = own[0];
                let _ = writeln!(text, "{x:?} {y:?} {z:?}");
            }
            text.into_bytes()
        }
        FieldFormat::Rawfield | FieldFormat::Npz | FieldFormat::Json => {
            let mut text = format!("{degree} {}\n", sampled.mesh.face_count());
            for own in of_faces() {
                let numbers: Vec<String> = own.as_flattened().iter().map(|x| format!("{x:?}")).collect();
                let _ = writeln!(text, "{}", numbers.join(" "));
            }
            text.into_bytes()
        }
    };
    session.output("field", path, bytes)
}

/// Writes the mesh with N vectors per face.
fn output_mesh(path: &Path, sampled: &SampledField, session: &mut Session) -> Result<(), Failure> {
    let degree = sampled.vectors.degree as usize;
    let named: Vec<(String, Vec<[f64; 3]>)> = (0..degree)
        .map(|k| (format!("v{k}"), sampled.vectors.vectors.iter().skip(k).step_by(degree).copied().collect()))
        .collect();
    let mut out = MeshOut::from(&sampled.mesh);
    out.face_vectors = named.iter().map(|(name, vectors)| (name.as_str(), vectors.as_slice())).collect();
    session.mesh_output("field", path, None, &out)?;
    session.name_fields(named.iter().map(|(name, _)| name.as_str()));
    Ok(())
}

/// Writes the mesh that is split at singular points.
pub fn output_split(path: &Path, sampled: &SampledField, session: &mut Session) -> Result<(), Failure> {
    session.mesh_output("split mesh", path, None, &MeshOut::from(&sampled.mesh))
}

/// Writes how the vectors of neighbouring faces continue each other: N and the number of rows, then
/// two faces, the vertices of their edge, and the shift (Directional).
pub fn output_matching(path: &Path, sampled: &SampledField, session: &mut Session) -> Result<(), Failure> {
    let rows = &sampled.vectors.matching;
    let mut text = format!("{} {}\n", sampled.vectors.degree, rows.len());
    for Match { faces: [f, g], vertices, shift } in rows {
        let [v, w] = vertices.map(|pair| pair.map(|v| v.0)).unwrap_or_default();
        let _ = writeln!(text, "{} {} {v} {w} {shift}", f.0, g.0);
    }
    session.output("matching", path, text.into_bytes())
}

/// Writes the singular vertices with their index times N (Directional).
pub fn output_vertex_list(path: &Path, sampled: &SampledField, session: &mut Session) -> Result<(), Failure> {
    let degree = sampled.vectors.degree;
    let mut text = format!("{degree} {}\n", sampled.singular_vertices.len());
    for (v, index) in &sampled.singular_vertices {
        let _ = writeln!(text, "{} {}", v.0, (index * f64::from(degree)).round());
    }
    session.output("singularities", path, text.into_bytes())
}
