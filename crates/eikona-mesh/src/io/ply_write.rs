//! Stanford PLY writer.

use super::words::Number;
use super::{Encoding, MeshOut};
use crate::io::output::{component_names, one_word};
use std::io::{self, Write};

/// Writes vertices, faces and edges with all scalars.
///
/// Positions and scalars are `double`: MeshLab itself writes and reads them so, and Blender
/// converts any number to `float` on reading, so `float` would only lose digits. Each scalar has
/// its own name, which Blender turns into an attribute; the first is repeated as `quality`, the
/// only name from which MeshLab reads values. Colours are `uchar`, as both expect. Texture
/// coordinates are the face list `texcoord`, as in MeshLab. Lines are `edge` elements, one per
/// segment.
pub(super) fn write_ply(out: &mut dyn Write, mesh: &MeshOut) -> io::Result<()> {
    let positions = mesh.positions();
    let scalars = vertex_scalars(mesh);
    let index_type = if positions.len() <= i32::MAX as usize { "int" } else { "uint" };
    let long_faces = mesh.faces().any(|face| 2 * face.len() > usize::from(u8::MAX));
    let count_type = if long_faces { "uint" } else { "uchar" };
    let ascii = mesh.encoding == Encoding::Ascii;
    let format = if ascii { "ascii" } else { "binary_little_endian" };
    writeln!(out, "ply\nformat {format} 1.0\ncomment written by eikona\nelement vertex {}", positions.len())?;
    writeln!(out, "property double x\nproperty double y\nproperty double z")?;
    if mesh.vertex_colours.is_some() {
        writeln!(out, "property uchar red\nproperty uchar green\nproperty uchar blue")?;
    }
    for (name, _) in &scalars {
        writeln!(out, "property double {name}")?;
    }
    writeln!(
        out,
        "element face {}\nproperty list {count_type} {index_type} vertex_indices",
        mesh.face_count()
    )?;
    if mesh.corner_uvs.is_some() {
        writeln!(out, "property list {count_type} double texcoord")?;
    }
    for (name, _) in &mesh.face_scalars {
        let name = one_word(name);
        let prefix = if ["vertex_indices", "texcoord"].contains(&name.as_str()) { "scalar_" } else { "" };
        writeln!(out, "property double {prefix}{name}")?;
    }
    for name in mesh.face_vectors.iter().flat_map(|(name, _)| component_names(name)) {
        writeln!(out, "property double {}", one_word(&name))?;
    }
    let segments = || mesh.lines.iter().flat_map(|line| line.windows(2));
    let edges = segments().count();
    if edges > 0 {
        writeln!(out, "element edge {edges}\nproperty {index_type} vertex1\nproperty {index_type} vertex2")?;
    }
    writeln!(out, "end_header")?;

    let mut row = Row { ascii, long_counts: long_faces, bytes: Vec::new() };
    for (i, position) in positions.iter().enumerate() {
        position.iter().try_for_each(|&x| row.double(x))?;
        if let Some(colour) = mesh.vertex_colours.and_then(|c| c.get(i)) {
            colour.iter().try_for_each(|&c| row.byte(c))?;
        }
        scalars.iter().filter_map(|(_, values)| values.get(i)).try_for_each(|&x| row.double(x))?;
        row.end(out)?;
    }
    let mut uvs = mesh.corner_uvs.unwrap_or_default().iter();
    for (f, face) in mesh.faces().enumerate() {
        row.count(face.len())?;
        face.iter().try_for_each(|&v| row.index(v))?;
        if mesh.corner_uvs.is_some() {
            row.count(2 * face.len())?;
            uvs.by_ref().take(face.len()).flatten().try_for_each(|&x| row.double(x))?;
        }
        mesh.face_scalars.iter().filter_map(|(_, values)| values.get(f)).try_for_each(|&x| row.double(x))?;
        let vectors = mesh.face_vectors.iter().filter_map(|(_, vectors)| vectors.get(f));
        vectors.flatten().try_for_each(|&x| row.double(x))?;
        row.end(out)?;
    }
    for segment in segments() {
        segment.iter().try_for_each(|&v| row.index(v))?;
        row.end(out)?;
    }
    Ok(())
}

/// Returns the scalars under names that no other property has, `quality` first.
fn vertex_scalars<'a>(mesh: &MeshOut<'a>) -> Vec<(String, &'a [f64])> {
    let taken = |name: &str| {
        let axes = ["x", "y", "z"].contains(&name);
        axes || (mesh.vertex_colours.is_some() && ["red", "green", "blue"].contains(&name))
    };
    let mut scalars = Vec::new();
    if let Some((_, values)) = mesh.vertex_scalars.first()
        && !mesh.vertex_scalars.iter().any(|(name, _)| *name == "quality")
    {
        scalars.push(("quality".to_string(), *values));
    }
    for (name, values) in &mesh.vertex_scalars {
        let name = one_word(name);
        scalars.push((if taken(&name) { format!("scalar_{name}") } else { name }, *values));
    }
    scalars
}

/// The values of one element in the chosen encoding.
struct Row {
    ascii: bool,
    long_counts: bool,
    bytes: Vec<u8>,
}

impl Row {
    fn text(&mut self, value: impl std::fmt::Display) -> io::Result<()> {
        let blank = if self.bytes.is_empty() { "" } else { " " };
        write!(self.bytes, "{blank}{value}")
    }
    fn double(&mut self, value: f64) -> io::Result<()> {
        if self.ascii { self.text(Number(value)) } else { self.bytes.write_all(&value.to_le_bytes()) }
    }
    fn byte(&mut self, value: u8) -> io::Result<()> {
        if self.ascii { self.text(value) } else { self.bytes.write_all(&[value]) }
    }
    fn index(&mut self, value: u32) -> io::Result<()> {
        if self.ascii { self.text(value) } else { self.bytes.write_all(&value.to_le_bytes()) }
    }
    fn count(&mut self, value: usize) -> io::Result<()> {
        if self.long_counts { self.index(value as u32) } else { self.byte(value as u8) }
    }
    fn end(&mut self, out: &mut dyn Write) -> io::Result<()> {
        if self.ascii {
            self.bytes.push(b'\n');
        }
        out.write_all(&self.bytes)?;
        self.bytes.clear();
        Ok(())
    }
}
