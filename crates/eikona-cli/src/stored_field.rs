//! Files that hold a polar field without loss: `.npz` and `.json`.

use crate::exit::Failure;
use crate::field::prescription::{Entry, entry};
use crate::numpy::{Array, NpzReader, NpzWriter};
use eikona::polar_field::{FieldData, Place, PolarField, PolarFieldError, Singularity};
use eikona_mesh::{FileError, SurfacePoint, TriangleMesh};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::io;
use std::path::Path;

/// Whether a file name is that of a stored field.
pub fn is_stored_field(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("npz") || e.eq_ignore_ascii_case("json"))
}

/// Returns a field as the bytes of a `.npz` file.
///
/// Singular points are three vertices with weights, padded with -1 and 0; boundary loops have no
/// vertices and their number in `singular_loops`, which is -1 for points.
pub fn npz_of_field(data: &FieldData) -> io::Result<Vec<u8>> {
    let faces = data.powers.len();
    let rows: Vec<Row> = data.singularities.iter().map(Row::from).collect();
    let count = rows.len();
    let mut npz = NpzWriter::new();
    npz.add("degree", &[], &[data.degree])?;
    npz.add("triangles", &[faces, 3], data.triangles.as_flattened())?;
    npz.add("powers", &[faces], &data.powers)?;
    npz.add("base", &[faces, 3, 2], data.base.as_flattened())?;
    npz.add("turns", &[faces, 3], &data.turns)?;
    npz.add(
        "singular_vertices",
        &[count, 3],
        rows.iter().flat_map(|r| r.vertices).collect::<Vec<_>>().as_slice(),
    )?;
    npz.add(
        "singular_weights",
        &[count, 3],
        rows.iter().flat_map(|r| r.weights).collect::<Vec<_>>().as_slice(),
    )?;
    npz.add("singular_loops", &[count], rows.iter().map(|r| r.boundary).collect::<Vec<_>>().as_slice())?;
    npz.add("singular_indices", &[count], rows.iter().map(|r| r.index).collect::<Vec<_>>().as_slice())?;
    npz.finish()
}

/// A prescribed index as numbers.
struct Row {
    vertices: [i64; 3],
    weights: [f64; 3],
    boundary: i64,
    index: f64,
}

impl From<&Singularity> for Row {
    fn from(singularity: &Singularity) -> Row {
        let id = i64::from;
        let (vertices, weights, boundary) = match singularity.place {
            Place::Boundary(boundary) => ([-1; 3], [0.0; 3], boundary as i64),
            Place::Point(SurfacePoint::Vertex { vertex }) => ([id(vertex), -1, -1], [1.0, 0.0, 0.0], -1),
            Place::Point(SurfacePoint::Edge { vertices: [a, b], t }) => {
                ([id(a), id(b), -1], [1.0 - t, t, 0.0], -1)
            }
            Place::Point(SurfacePoint::Face { vertices, bary }) => (vertices.map(id), bary, -1),
        };
        Row { vertices, weights, boundary, index: singularity.index }
    }
}

impl Row {
    fn singularity(&self) -> Result<Singularity, String> {
        let id = |v: i64| u32::try_from(v).ok();
        let place = match self.vertices.map(id) {
            [None, None, None] => usize::try_from(self.boundary).ok().map(Place::Boundary),
            [Some(vertex), None, None] => Some(Place::Point(SurfacePoint::Vertex { vertex })),
            [Some(a), Some(b), None] => {
                Some(Place::Point(SurfacePoint::Edge { vertices: [a, b], t: self.weights[1] }))
            }
            [Some(a), Some(b), Some(c)] => {
                Some(Place::Point(SurfacePoint::Face { vertices: [a, b, c], bary: self.weights }))
            }
            _ => None,
        };
        let place = place.ok_or("a singularity is neither a point nor a boundary loop")?;
        Ok(Singularity { place, index: self.index })
    }
}

fn field_of_npz(bytes: &[u8]) -> Result<FieldData, String> {
    let mut npz = NpzReader::new(bytes)?;
    let degree = npz.array("degree", &[])?;
    let triangles = npz.array("triangles", &[None, Some(3)])?;
    let faces = Some(triangles.shape[0]);
    let powers = npz.array("powers", &[faces])?;
    let base = npz.array("base", &[faces, Some(3), Some(2)])?;
    let turns = npz.array("turns", &[faces, Some(3)])?.values;
    let indices = npz.array("singular_indices", &[None])?.values;
    let count = Some(indices.len());
    let loops = whole(&npz.array("singular_loops", &[count])?)?;
    let vertices = whole(&npz.array("singular_vertices", &[count, Some(3)])?)?;
    let weights = npz.array("singular_weights", &[count, Some(3)])?.values;
    let rows = vertices.chunks(3).zip(weights.chunks(3)).zip(loops.into_iter().zip(indices));
    let singularity = |((v, w), (boundary, index)): ((&[i64], &[f64]), (i64, f64))| {
        Row { vertices: [v[0], v[1], v[2]], weights: [w[0], w[1], w[2]], boundary, index }.singularity()
    };
    let unsigned = |array: &Array| -> Result<Vec<u32>, String> {
        let number = |x: i64| u32::try_from(x).map_err(|_| format!("{x} is out of range"));
        whole(array)?.into_iter().map(number).collect()
    };
    Ok(FieldData {
        degree: unsigned(&degree)?[0],
        triangles: unsigned(&triangles)?.chunks(3).map(|t| [t[0], t[1], t[2]]).collect(),
        powers: unsigned(&powers)?,
        base: base.values.chunks(2).map(|z| [z[0], z[1]]).collect(),
        turns,
        singularities: rows.map(singularity).collect::<Result<_, _>>()?,
    })
}

fn whole(array: &Array) -> Result<Vec<i64>, String> {
    let number =
        |x: &f64| (x.fract() == 0.0).then_some(*x as i64).ok_or(format!("{x} is not a whole number"));
    array.values.iter().map(number).collect()
}

/// The form of `.json` files.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Stored<S> {
    degree: u32,
    triangles: Vec<[u32; 3]>,
    powers: Vec<u32>,
    base: Vec<[f64; 2]>,
    turns: Vec<f64>,
    singularities: Vec<S>,
}

/// Returns a field as JSON text.
pub fn json_of_field(data: FieldData) -> io::Result<Vec<u8>> {
    let FieldData { degree, triangles, powers, base, turns, singularities } = data;
    let singularities: Vec<Value> = singularities.iter().map(|s| entry(s, |v| v)).collect();
    let mut text = serde_json::to_vec(&Stored { degree, triangles, powers, base, turns, singularities })?;
    text.push(b'\n');
    Ok(text)
}

fn field_of_json(bytes: &[u8]) -> Result<FieldData, String> {
    if bytes.trim_ascii_start().first() != Some(&b'{') {
        return Err("this is not a stored field, which is one JSON object".into());
    }
    let stored: Stored<Entry> = serde_json::from_slice(bytes).map_err(|fault| fault.to_string())?;
    let Stored { degree, triangles, powers, base, turns, singularities } = stored;
    let singularity = |(i, entry): (usize, &Entry)| {
        entry.singularity().map_err(|problem| format!("singularity {i}: {problem}"))
    };
    let singularities = singularities.iter().enumerate().map(singularity).collect::<Result<_, _>>()?;
    Ok(FieldData { degree, triangles, powers, base, turns, singularities })
}

/// Reads a stored field.
pub fn read_stored_field(path: &Path) -> Result<FieldData, Failure> {
    if !is_stored_field(path) {
        return Err(Failure::Usage(format!("{}: stored fields are .npz or .json files", path.display())));
    }
    let bytes = std::fs::read(path)
        .map_err(|fault| Failure::reading(path, FileError::Io { path: path.display().to_string(), fault }))?;
    let is_json = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    let data = if is_json { field_of_json(&bytes) } else { field_of_npz(&bytes) };
    data.map_err(|problem| {
        Failure::Input(format!("{}: {problem}; give a file that eikona field -o wrote", path.display()))
    })
}

/// Restores a field. What is wrong with it is wrong with the file.
pub fn restored_field(path: &Path, mesh: &TriangleMesh, data: &FieldData) -> Result<PolarField, Failure> {
    PolarField::from_data(mesh, data).map_err(|fault| match fault {
        PolarFieldError::Numeric(_) => Failure::from(fault),
        _ => Failure::Input(format!("{}: {fault}", path.display())),
    })
}
