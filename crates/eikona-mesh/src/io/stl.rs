//! STL, ascii and binary. A facet names no vertices, so each has its own three, in order; welding is a separate step.
//!
//! Own reader: stl_io welds equal positions while it reads, which loses the order and count of vertices.

use super::words::{Number, Words, number, shown};
use super::{Encoding, MeshFile, MeshOut};
use crate::error::{FileError, MeshError};
use crate::polygon::PolygonMesh;
use std::io::{self, Write};

const STL: &str = "STL";
/// A free text of 80 bytes, and the number of facets.
const HEADER: usize = 84;
/// A normal and three vertices of 32-bit floats, and two bytes of no fixed meaning.
const FACET: usize = 50;

/// The facets of an STL file: face `f` has the vertices `3 f`, `3 f + 1`, `3 f + 2`. Normals and the two free bytes of a
/// facet are not kept.
///
/// A file is binary when its length fits its facet count, even if it begins with "solid"; else it is ascii if it begins so
/// and the next line is of the ascii grammar.
///
/// # Errors
/// [`FileError::Syntax`] with the line or byte: cut off, not a number, a facet without exactly three vertices.
pub fn read_stl(bytes: &[u8]) -> Result<MeshFile, FileError> {
    if is_binary(bytes) || !is_ascii(bytes) { read_binary(bytes) } else { read_ascii(bytes) }
}

/// Whether the length is exactly that of a binary file with the announced number of facets.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    announced(bytes).is_some_and(|n| (n as u64) * FACET as u64 + HEADER as u64 == bytes.len() as u64)
}

fn announced(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER - 4..HEADER)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*count) as usize)
}

fn is_ascii(bytes: &[u8]) -> bool {
    let mut words = Words::new(bytes);
    let Some(first) = words.word() else { return true };
    if !first.eq_ignore_ascii_case(b"solid") {
        return false;
    }
    words.next_line();
    match words.word() {
        Some(word) => [&b"facet"[..], b"endsolid", b"solid"].iter().any(|k| word.eq_ignore_ascii_case(k)),
        None => !bytes.contains(&0), // a single line: an empty text, or binary without any line end
    }
}

fn read_binary(bytes: &[u8]) -> Result<MeshFile, FileError> {
    let Some(count) = announced(bytes) else {
        let problem = format!(
            "the file has {} bytes; binary STL begins with {HEADER}, ascii STL with \"solid\"",
            bytes.len()
        );
        return Err(FileError::syntax(STL, "byte 0", problem));
    };
    let body = &bytes[HEADER..];
    let whole = body.len() / FACET;
    if whole < count {
        let problem = format!(
            "the header announces {count} facets, but the file holds {whole}; it is cut off or not an STL file"
        );
        return Err(FileError::syntax(STL, "byte 80", problem));
    }
    if count > (u32::MAX / 3) as usize {
        return Err(MeshError::TooLarge { vertices: 3 * count, faces: count }.into());
    }
    let mut file = MeshFile::default();
    let extra = body.len() - count * FACET;
    if extra > 0 {
        file.warnings.push(format!("{extra} bytes after the last facet were left out"));
    }
    let mut positions = Vec::with_capacity(3 * count);
    for facet in body.chunks_exact(FACET).take(count) {
        for vertex in facet[12..48].chunks_exact(12) {
            let coordinate = |k: usize| {
                f64::from(f32::from_le_bytes([vertex[k], vertex[k + 1], vertex[k + 2], vertex[k + 3]]))
            };
            positions.push([coordinate(0), coordinate(4), coordinate(8)]);
        }
    }
    file.mesh = unwelded(positions);
    Ok(file)
}

fn read_ascii(bytes: &[u8]) -> Result<MeshFile, FileError> {
    let mut words = Words::new(bytes);
    let mut positions: Vec<[f64; 3]> = Vec::new();
    let mut facet_open = false;
    let mut solid_open = false;
    loop {
        let keyword = words.word_on_line().unwrap_or_default();
        let is = |k: &[u8]| keyword.eq_ignore_ascii_case(k);
        if is(b"vertex") {
            let mut position = [0.0; 3];
            for coordinate in &mut position {
                let word = words.word_on_line().unwrap_or_default();
                *coordinate = number(word).ok_or_else(|| {
                    words.fault(STL, format!("{} is not a number; vertex takes three", shown(word)))
                })?;
            }
            positions.push(position);
        } else if is(b"facet") {
            facet_open = true;
        } else if is(b"endfacet") {
            if !facet_open || !positions.len().is_multiple_of(3) {
                return Err(words.fault(STL, "the facet that ends here does not have three vertices"));
            }
            facet_open = false;
        } else if is(b"solid") {
            solid_open = true;
        } else if is(b"endsolid") {
            solid_open = false;
        } else if !(keyword.is_empty() || is(b"outer") || is(b"endloop")) {
            let problem =
                format!("{} is no word of ascii STL; the file is damaged or not an STL file", shown(keyword));
            return Err(words.fault(STL, problem));
        }
        if !words.next_line() {
            break;
        }
    }
    if facet_open || !positions.len().is_multiple_of(3) {
        return Err(words.fault(STL, "the file ends inside a facet; it is cut off"));
    }
    let mut file = MeshFile::default();
    if solid_open {
        file.warnings.push("the last line is not \"endsolid\"; the file may be cut off".into());
    }
    file.mesh = unwelded(positions);
    Ok(file)
}

fn unwelded(positions: Vec<[f64; 3]>) -> PolygonMesh {
    let faces: Vec<[u32; 3]> =
        (0..positions.len() as u32 / 3).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    PolygonMesh::from_triangles(positions, &faces)
}

/// Writes the triangles with unit normals; the normal of a triangle without area is zero. Coordinates are 32-bit floats in
/// binary.
pub(super) fn write_stl(out: &mut dyn Write, mesh: &MeshOut) -> io::Result<()> {
    let corners = |face: &[u32]| {
        let p = mesh.positions();
        [0, 1, 2].map(|k| face.get(k).and_then(|&v| p.get(v as usize)).copied().unwrap_or_default())
    };
    if mesh.encoding == Encoding::Ascii {
        writeln!(out, "solid eikona")?;
        for p in mesh.faces().map(corners) {
            let n = unit_normal(p).map(Number);
            writeln!(out, "facet normal {} {} {}\nouter loop", n[0], n[1], n[2])?;
            for [x, y, z] in p {
                writeln!(out, "vertex {} {} {}", Number(x), Number(y), Number(z))?;
            }
            writeln!(out, "endloop\nendfacet")?;
        }
        return writeln!(out, "endsolid eikona");
    }
    let mut header = [b' '; HEADER];
    header[..6].copy_from_slice(b"eikona"); // not "solid", by which readers tell ascii
    header[HEADER - 4..].copy_from_slice(&(mesh.face_count() as u32).to_le_bytes());
    out.write_all(&header)?;
    for p in mesh.faces().map(corners) {
        let mut facet = [0; FACET];
        let values = unit_normal(p).into_iter().chain(p.into_iter().flatten());
        for (value, bytes) in values.zip(facet.chunks_exact_mut(4)) {
            bytes.copy_from_slice(&(value as f32).to_le_bytes());
        }
        out.write_all(&facet)?;
    }
    Ok(())
}

fn unit_normal([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let u = [0, 1, 2].map(|k| b[k] - a[k]);
    let v = [0, 1, 2].map(|k| c[k] - a[k]);
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 && length.is_finite() { n.map(|x| x / length) } else { [0.0; 3] }
}
