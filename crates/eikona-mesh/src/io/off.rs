//! Geomview's Object File Format: OFF, COFF, NOFF, STOFF and their combinations. No Rust crate keeps its polygons and
//! colours.

use super::faces::Faces;
use super::words::{Number, Words, integer, number, shown};
use super::{MeshFile, MeshOut};
use crate::error::FileError;
use std::io::{self, Write};

const OFF: &str = "OFF";

/// What the keyword in the first line announces about the vertices.
#[derive(Clone, Copy, Default)]
pub(super) struct Header {
    normals: bool,
    colours: bool,
    unsupported: bool,
}

impl Header {
    /// `[ST][C][N][4][n]OFF`
    pub fn parse(keyword: &[u8]) -> Option<Header> {
        let rest = keyword.strip_suffix(b"OFF")?;
        let rest = rest.strip_prefix(b"ST").unwrap_or(rest);
        let (colours, rest) = rest.strip_prefix(b"C").map_or((false, rest), |r| (true, r));
        let (normals, rest) = rest.strip_prefix(b"N").map_or((false, rest), |r| (true, r));
        let unsupported = matches!(rest, b"4" | b"n" | b"4n");
        (rest.is_empty() || unsupported).then_some(Header { normals, colours, unsupported })
    }
}

/// The mesh of an OFF text. The counts may stand behind the keyword or on the next line; the keyword may be missing.
/// Normals of NOFF become the vertex scalars `nx`, `ny`, `nz`, colours of COFF `red`, `green`, `blue`, as they are written
/// (0 to 1 or 0 to 255); other values behind vertices and colours behind faces are not kept.
///
/// # Errors
/// [`FileError::Syntax`] with the line, also when there are fewer vertices or faces than announced; [`FileError::Mesh`] with
/// every face that names a vertex that does not exist; [`FileError::Unsupported`] for binary OFF, 4OFF and nOFF.
pub fn read_off(bytes: &[u8]) -> Result<MeshFile, FileError> {
    let mut words = Words::new(bytes).with_comments();
    let first = words.word().ok_or_else(|| words.fault(OFF, "the file is empty"))?;
    let (header, first_count) = match Header::parse(first) {
        Some(header) => (header, words.word()),
        None => (Header::default(), Some(first)),
    };
    if header.unsupported {
        return Err(FileError::Unsupported(format!(
            "{}: vertices with other than three coordinates are not read; convert the file to OFF",
            shown(first)
        )));
    }
    if first_count == Some(b"BINARY") {
        return Err(FileError::Unsupported(
            "binary OFF is not read; convert the file to ascii OFF or PLY".into(),
        ));
    }
    let vertices = count(&words, first_count, "vertices")?;
    let second_count = words.word();
    let faces = count(&words, second_count, "faces")?;
    words.next_line(); // the number of edges, which is often left out

    let mut file = MeshFile::default();
    let mut columns: Vec<(&str, Vec<f64>)> = Vec::new();
    if header.normals {
        columns.extend(["nx", "ny", "nz"].map(|name| (name, Vec::new())));
    }
    if header.colours {
        columns.extend(["red", "green", "blue"].map(|name| (name, Vec::new())));
    }
    let mut positions = Vec::with_capacity(vertices.min(words.remaining() / 6)); // "0 0 0" and a line end
    for i in 0..vertices {
        let mut position = [0.0; 3];
        for coordinate in &mut position {
            let word = words.word().ok_or_else(|| cut_off(&words, "vertices", vertices, i))?;
            *coordinate = number(word)
                .ok_or_else(|| words.fault(OFF, format!("vertex {i}: {} is not a number", shown(word))))?;
        }
        positions.push(position);
        for (name, values) in &mut columns {
            let word = words.word_on_line().unwrap_or_default();
            values.push(number(word).ok_or_else(|| {
                let problem =
                    format!("vertex {i}: {} stands where {} announces {name}", shown(word), shown(first));
                words.fault(OFF, problem)
            })?);
        }
        words.next_line();
    }
    let mut polygons = Faces::default();
    let mut corners = Vec::new();
    for i in 0..faces {
        let word = words.word().ok_or_else(|| cut_off(&words, "faces", faces, i))?;
        let bad =
            |words: &Words, word| words.fault(OFF, format!("face {i}: {} is not an integer", shown(word)));
        let length = integer(word).ok_or_else(|| bad(&words, word))?;
        let length = usize::try_from(length).map_err(|_| {
            words.fault(OFF, format!("face {i} announces {length} corners; correct the number"))
        })?;
        corners.clear();
        for _ in 0..length {
            let word = words.word().ok_or_else(|| cut_off(&words, "faces", faces, i))?;
            corners.push(integer(word).ok_or_else(|| bad(&words, word))?);
        }
        polygons.push(&corners)?;
        words.next_line(); // a colour
    }
    if words.word().is_some() {
        file.warnings.push(format!(
            "there is more from line {} on than the {faces} faces announced; it was left out",
            words.line()
        ));
    }
    file.mesh = polygons.finish(positions)?;
    file.vertex_scalars = columns.into_iter().map(|(name, values)| (name.to_string(), values)).collect();
    Ok(file)
}

fn count(words: &Words, word: Option<&[u8]>, what: &str) -> Result<usize, FileError> {
    let word = word.unwrap_or_default();
    integer(word).and_then(|n| usize::try_from(n).ok()).ok_or_else(|| {
        let problem =
            format!("{} stands where the number of {what} is expected; is this an OFF file?", shown(word));
        words.fault(OFF, problem)
    })
}

fn cut_off(words: &Words, what: &str, announced: usize, found: usize) -> FileError {
    words.fault(OFF, format!("the file ends after {found} of {announced} announced {what}; it is cut off"))
}

/// Writes OFF, or COFF when there are colours.
pub(super) fn write_off(out: &mut dyn Write, mesh: &MeshOut) -> io::Result<()> {
    let keyword = if mesh.vertex_colours.is_some() { "COFF" } else { "OFF" };
    writeln!(out, "{keyword}\n{} {} 0", mesh.positions().len(), mesh.face_count())?;
    for (i, &[x, y, z]) in mesh.positions().iter().enumerate() {
        write!(out, "{} {} {}", Number(x), Number(y), Number(z))?;
        if let Some([r, g, b]) = mesh.vertex_colours.and_then(|c| c.get(i)) {
            write!(out, " {r} {g} {b} 255")?;
        }
        writeln!(out)?;
    }
    for face in mesh.faces() {
        write!(out, "{}", face.len())?;
        for v in face {
            write!(out, " {v}")?;
        }
        writeln!(out)?;
    }
    Ok(())
}
