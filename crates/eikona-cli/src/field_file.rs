//! Output files of values per vertex: on the mesh, or as a table.

use crate::exit::Failure;
use crate::input::MeshInput;
use crate::numpy::npy;
use crate::picture::colours;
use crate::session::Session;
use crate::warned::Warned;
use eikona_mesh::io::{MeshFormat, MeshOut};
use std::fmt::Write as _;
use std::path::Path;

/// Formats of vertex values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldFormat {
    /// The mesh with the values.
    Mesh(MeshFormat),
    /// NumPy array of little-endian doubles, one column per field.
    Npy,
    /// CSV text with a header line.
    Csv,
}

/// Determines the format from a file name, or from `given` for standard output.
pub fn field_format(path: &Path, given: Option<&str>) -> Result<FieldFormat, Failure> {
    let is_stdout = path == Path::new("-");
    if given.is_some() && !is_stdout {
        return Err(Failure::Usage(format!(
            "--out-format sets the format of standard output, but this output goes to {}, whose name sets \
             its format; leave --out-format out",
            path.display()
        )));
    }
    let name = match given {
        Some(format) => format!("x.{format}"),
        None if is_stdout => {
            return Err(Failure::Usage(
                "the format of standard output is not given; add --out-format with ply, obj, off, glb, \
                 gltf, vtp, npy or csv"
                    .into(),
            ));
        }
        None => path.to_string_lossy().to_ascii_lowercase(),
    };
    if name.ends_with(".npy") {
        return Ok(FieldFormat::Npy);
    }
    if name.ends_with(".csv") {
        return Ok(FieldFormat::Csv);
    }
    match MeshFormat::from_path(&name) {
        Some(MeshFormat::Stl) => Err(Failure::Usage(format!(
            "{}: STL cannot store values per vertex; write .ply, .vtp, .glb, .obj, .off, .npy or .csv",
            path.display()
        ))),
        Some(format) => Ok(FieldFormat::Mesh(format)),
        None => Err(Failure::Usage(format!(
            "{}: unknown output format; use .ply, .obj, .off, .vtp, .glb, .gltf, .npy or .csv",
            path.display()
        ))),
    }
}

/// Stages an output file of the distance and the fields that explain it, by name.
pub fn output_fields(
    path: &Path,
    format: FieldFormat,
    input: &MeshInput,
    fields: &[(&str, &[f64])],
    session: &mut Session,
) -> Result<(), Failure> {
    match format {
        FieldFormat::Npy => session.output("distance", path, npy_of_fields(fields)?)?,
        FieldFormat::Csv => session.output("distance", path, csv(fields).into_bytes())?,
        FieldFormat::Mesh(format) => {
            let mut out = input.to_write(format);
            let shown = fields.first().map_or(Vec::new(), |f| colours(f.1));
            // OFF cannot store values, and glTF viewers show only colours.
            if matches!(format, MeshFormat::Off | MeshFormat::Glb | MeshFormat::Gltf) {
                out.vertex_colours = Some(&shown);
            }
            out.vertex_scalars = if format == MeshFormat::Off { Vec::new() } else { fields.to_vec() };
            // Data formats keep the fields of the input; the others only show the new field.
            let carried = if matches!(format, MeshFormat::Ply | MeshFormat::Vtp) {
                Carried::of(input)
            } else {
                Carried::default()
            };
            carried.add_to(&mut out);
            if format == MeshFormat::Off {
                let sentence = "OFF stores colours instead of values; write .ply or .csv to keep the values";
                session.warn(Warned::new("values_as_colours", sentence).about(path.display()));
            }
            session.mesh_output("distance", path, Some(format), &out)?;
            if format == MeshFormat::Off {
                return Ok(()); // colours only
            }
        }
    }
    session.name_fields(fields.iter().map(|(name, _)| *name));
    Ok(())
}

/// Values and colours of the input mesh that the output keeps.
#[derive(Default)]
struct Carried<'a> {
    vertex_scalars: Vec<(&'a str, Vec<f64>)>,
    face_scalars: Vec<(&'a str, &'a [f64])>,
    colours: Option<Vec<[u8; 3]>>,
}

/// Results of an earlier run, which the output does not keep: they would look like results of this
/// one. The same holds for `quality` if it copies the distance, as it does in our PLY files; any
/// other `quality` is renamed.
const RESULTS: [&str; 3] = ["distance", "confidence", "distance_to_data"];

const COLOURS: [&str; 3] = ["red", "green", "blue"];

impl<'a> Carried<'a> {
    fn of(input: &'a MeshInput) -> Carried<'a> {
        let scalars = &input.file.vertex_scalars;
        let mut vertex_scalars: Vec<_> =
            scalars.iter().map(|(name, values)| (name.as_str(), input.vertex_values(values))).collect();
        let values = |name: &str| vertex_scalars.iter().find(|s| s.0 == name).map(|s| &s.1);
        let equal = |a: &f64, b: &f64| a.to_bits() == b.to_bits();
        let is_copy = values("quality")
            .zip(values("distance"))
            .is_some_and(|(quality, distance)| quality.iter().zip(distance).all(|(a, b)| equal(a, b)));
        vertex_scalars.retain(|(name, _)| !(RESULTS.contains(name) || is_copy && *name == "quality"));
        if let Some((name, _)) = vertex_scalars.iter_mut().find(|s| s.0 == "quality") {
            *name = "quality_of_input";
        }
        let colours = byte_colours(&vertex_scalars);
        if colours.is_some() {
            vertex_scalars.retain(|(name, _)| !COLOURS.contains(name));
        }
        let mut face_scalars = Vec::new();
        if input.writes_faces_of_file() {
            face_scalars
                .extend(input.file.face_scalars.iter().map(|(name, v)| (name.as_str(), v.as_slice())));
        }
        Carried { vertex_scalars, face_scalars, colours }
    }

    /// Adds the values whose names are free.
    fn add_to<'b>(&'b self, out: &mut MeshOut<'b>) {
        let new = |there: &[(&str, &[f64])], name: &str| {
            !name.is_empty() && !there.iter().any(|(other, _)| word(other) == word(name))
        };
        for (name, values) in &self.vertex_scalars {
            if new(&out.vertex_scalars, name) {
                out.vertex_scalars.push((name, values));
            }
        }
        for (name, values) in &self.face_scalars {
            if new(&out.face_scalars, name) {
                out.face_scalars.push((name, values));
            }
        }
        out.vertex_colours = out.vertex_colours.or(self.colours.as_deref());
    }
}

/// A name as files store it: names that differ only in whitespace collide.
fn word(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_graphic() { c } else { '_' }).collect()
}

/// Colours per vertex, if the file has all three channels as bytes.
fn byte_colours(scalars: &[(&str, Vec<f64>)]) -> Option<Vec<[u8; 3]>> {
    let channel = |name: &str| scalars.iter().find(|s| s.0 == name).map(|s| &s.1);
    let channels = [channel(COLOURS[0])?, channel(COLOURS[1])?, channel(COLOURS[2])?];
    let byte = |x: f64| (x.fract() == 0.0 && (0.0..=255.0).contains(&x)).then_some(x as u8);
    let colour = |v: usize| {
        Some([byte(*channels[0].get(v)?)?, byte(*channels[1].get(v)?)?, byte(*channels[2].get(v)?)?])
    };
    (0..channels[0].len()).map(colour).collect()
}

/// NumPy file of doubles: shape (V,) for one field, (V, n) for n fields.
fn npy_of_fields(fields: &[(&str, &[f64])]) -> Result<Vec<u8>, Failure> {
    let rows = fields.first().map_or(0, |f| f.1.len());
    let value = |row: usize| fields.iter().map(move |f| f.1.get(row).copied().unwrap_or(f64::NAN));
    let values: Vec<f64> = (0..rows).flat_map(value).collect();
    let shape = [rows, fields.len()];
    npy(if fields.len() == 1 { &shape[..1] } else { &shape }, &values).map_err(Failure::encoding)
}

fn csv(fields: &[(&str, &[f64])]) -> String {
    let mut text = String::from("vertex");
    fields.iter().for_each(|(name, _)| text += &format!(",{name}"));
    text.push('\n');
    for row in 0..fields.first().map_or(0, |f| f.1.len()) {
        let _ = write!(text, "{row}");
        for (_, values) in fields {
            let _ = write!(text, ",{}", values.get(row).copied().unwrap_or(f64::NAN));
        }
        text.push('\n');
    }
    text
}
