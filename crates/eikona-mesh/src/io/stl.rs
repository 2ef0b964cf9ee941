//! STL, ascii and binary. Facets do not share vertices, so each has its own three, in order;
//! welding is a separate step.
//!
//! Own reader: stl_io 0.11 welds equal positions while it reads, which loses the order and count of
//! vertices. It also rejects ascii with several statements per line, "end loop" or upper case, and
//! returns no facets if their count in the header is 0.

use super::text::decode_text;
use super::words::{Number, Words, number, shown};
use super::{Encoding, MeshFile, MeshOut};
use crate::error::{FileError, MeshError};
use crate::polygon::PolygonMesh;
use crate::warning::FileWarning;
use std::io::{self, Write};

const STL: &str = "STL";
/// 80 bytes of free text, and the number of facets.
const HEADER: usize = 84;
/// A normal and three vertices of 32-bit floats, and two bytes without fixed meaning.
const FACET: usize = 50;

/// Reads the facets of an STL file: face `f` has the vertices `3 f`, `3 f + 1`, `3 f + 2`. Normals
/// and the two free bytes of a facet are not kept.
///
/// A file is binary if its length matches its facet count, even if it begins with "solid".
/// Otherwise it is ascii if it is text that begins with "solid" or "facet". Ascii keywords may be
/// in any case and on any line.
///
/// # Errors
/// [`FileError::Syntax`] with the line or byte: a truncated file, a word that is not a number, a
/// facet without exactly three vertices.
pub fn read_stl(bytes: &[u8]) -> Result<MeshFile, FileError> {
    if is_binary(bytes) {
        return read_binary(bytes);
    }
    // The header of a binary file may be UTF-16, too.
    let text = decode_text(bytes);
    if text.is_empty() || is_ascii(&text) { read_ascii(&text) } else { read_binary(bytes) }
}

/// Returns whether the length is exactly that of a binary file with the facet count in the header.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    declared(bytes).is_some_and(|n| (n as u64) * FACET as u64 + HEADER as u64 == bytes.len() as u64)
}

fn declared(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER - 4..HEADER)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*count) as usize)
}

/// Returns whether the text begins like ascii STL. Binary files have a zero byte early, usually in
/// the facet count.
pub(super) fn is_ascii(text: &[u8]) -> bool {
    const HEAD: usize = 512;
    let head = text.get(..HEAD).unwrap_or(text);
    let begins = |word: &[u8]| word.eq_ignore_ascii_case(b"solid") || word.eq_ignore_ascii_case(b"facet");
    !head.contains(&0) && Words::new(head).word().is_some_and(begins)
}

fn read_binary(bytes: &[u8]) -> Result<MeshFile, FileError> {
    let Some(declared) = declared(bytes) else {
        let problem = format!(
            "the file has {} bytes; binary STL has at least {HEADER}, and ascii STL begins with \"solid\"",
            bytes.len()
        );
        return Err(FileError::syntax(STL, "byte 0", problem));
    };
    let body = &bytes[HEADER..];
    let whole = body.len() / FACET;
    let mut file = MeshFile::default();
    let mut count = declared;
    // Programs that stream facets leave the count at 0 or all ones.
    let unset = declared == 0 || declared == u32::MAX as usize;
    let exact = body.len().is_multiple_of(FACET);
    if declared != whole && (unset || exact && declared < whole) {
        let rest = body.chunks_exact(FACET).skip(if unset { 0 } else { declared });
        if rest.len() > 0 && rest.clone().all(is_plausible) {
            file.warnings.push(FileWarning::FacetCount { declared, found: whole });
            count = whole;
        }
    }
    if whole < count {
        let problem = format!(
            "the header declares {count} facets, but the file contains {whole}; it is truncated, its count is wrong or it is not an STL file"
        );
        return Err(FileError::syntax(STL, "byte 80", problem));
    }
    if count > (u32::MAX / 3) as usize {
        return Err(MeshError::TooLarge { vertices: 3 * count, faces: count }.into());
    }
    let extra = body.len() - count * FACET;
    if extra > 0 {
        file.warnings.push(FileWarning::TrailingBytes { bytes: extra, declared: format!("{count} facets") });
    }
    let mut positions = Vec::with_capacity(3 * count);
    for facet in body.chunks_exact(FACET).take(count) {
        positions.extend(vertices(facet).map(|v| v.map(f64::from)));
    }
    file.mesh = unwelded(positions);
    Ok(file)
}

fn vertices(facet: &[u8]) -> impl Iterator<Item = [f32; 3]> {
    facet[12..48]
        .as_chunks::<12>()
        .0
        .iter()
        .map(|v| [0, 4, 8].map(|k| f32::from_le_bytes([v[k], v[k + 1], v[k + 2], v[k + 3]])))
}

/// Returns whether the bytes can be a facet that the header does not count: finite, and not zero
/// padding.
fn is_plausible(facet: &[u8]) -> bool {
    facet.iter().any(|&b| b != 0) && vertices(facet).flatten().all(f32::is_finite)
}

/// Keywords of ascii STL, which may be written as two words ("end loop").
#[derive(Clone, Copy, PartialEq)]
enum Keyword {
    Solid,
    Facet,
    Normal,
    Loop,
    Vertex,
    EndLoop,
    EndFacet,
    EndSolid,
}

impl Keyword {
    /// Parses a keyword; consumes the next word if it belongs to it.
    fn parse(word: &[u8], words: &mut Words) -> Option<Keyword> {
        use Keyword::*;
        const KEYWORDS: [(&[u8], Keyword); 9] = [
            (b"vertex", Vertex),
            (b"facet", Facet),
            (b"normal", Normal),
            (b"outerloop", Loop),
            (b"loop", Loop),
            (b"endloop", EndLoop),
            (b"endfacet", EndFacet),
            (b"solid", Solid),
            (b"endsolid", EndSolid),
        ];
        let find = |word: &[u8]| KEYWORDS.iter().find(|(k, _)| word.eq_ignore_ascii_case(k)).map(|(_, k)| *k);
        let is_end = word.eq_ignore_ascii_case(b"end");
        if !is_end && !word.eq_ignore_ascii_case(b"outer") {
            return find(word);
        }
        let mut behind = words.clone();
        let keyword = match (is_end, behind.word().and_then(find)) {
            (true, Some(Loop)) => EndLoop,
            (true, Some(Facet)) => EndFacet,
            (true, Some(Solid)) => EndSolid,
            (false, Some(Loop)) => Loop,
            _ => return None,
        };
        *words = behind;
        Some(keyword)
    }
}

/// Skips a name up to the end of its line or to a facet that begins there.
fn skip_name(words: &mut Words) {
    loop {
        let mut behind = words.clone();
        match behind.word_on_line() {
            None => return,
            Some(word) if word.eq_ignore_ascii_case(b"facet") => {
                if behind.word_on_line().is_some_and(|next| next.eq_ignore_ascii_case(b"normal")) {
                    return;
                }
            }
            Some(_) => {}
        }
        words.word_on_line();
    }
}

fn read_ascii(text: &[u8]) -> Result<MeshFile, FileError> {
    let mut words = Words::new(text);
    let mut positions: Vec<[f64; 3]> = Vec::new();
    let mut solid_open = false;
    let mut facet_open = false;
    // Vertices since the last facet began or ended.
    let mut corners = 0;
    // Unknown words after a keyword are ignored up to the end of the line.
    let mut first_on_line = true;
    loop {
        let Some(word) = words.word_on_line() else {
            first_on_line = true;
            if words.next_line() { continue } else { break }
        };
        let keyword = Keyword::parse(word, &mut words);
        match keyword {
            Some(Keyword::Solid | Keyword::EndSolid) => {
                solid_open = keyword == Some(Keyword::Solid);
                if facet_open && corners == 3 {
                    (facet_open, corners) = (false, 0); // some files omit endfacet
                }
                skip_name(&mut words);
            }
            Some(Keyword::Facet | Keyword::EndFacet) => {
                let begins = keyword == Some(Keyword::Facet);
                let problem = match corners {
                    3 if facet_open => None,
                    0 if begins && !facet_open => None,
                    _ if !begins && !facet_open => Some("endfacet without a facet; remove it".to_string()),
                    n => Some(format!("a facet has {n} vertices before this; it needs exactly three")),
                };
                if let Some(problem) = problem {
                    return Err(words.fault(STL, problem));
                }
                facet_open = begins;
                corners = 0;
            }
            Some(Keyword::Normal) => skip_numbers(&mut words),
            Some(Keyword::Vertex) => {
                let place = words.clone();
                let mut position = [0.0; 3];
                for coordinate in &mut position {
                    let word = words.word().unwrap_or_default();
                    *coordinate = number(word).ok_or_else(|| {
                        place.fault(STL, format!("{} is not a number; vertex expects three", shown(word)))
                    })?;
                }
                positions.push(position);
                corners += 1;
            }
            Some(Keyword::Loop | Keyword::EndLoop) => {}
            None if first_on_line => {
                let problem =
                    format!("unknown keyword {}; the file is damaged or not an STL file", shown(word));
                return Err(words.fault(STL, problem));
            }
            None => {}
        }
        first_on_line = false;
    }
    let mut file = MeshFile::default();
    if corners != 0 && !(facet_open && corners == 3) || facet_open && corners == 0 {
        let problem =
            format!("the file ends inside a facet, after {corners} of its vertices; it is truncated");
        return Err(words.fault(STL, problem));
    }
    if facet_open || solid_open {
        let keyword = if facet_open { "endfacet" } else { "endsolid" };
        file.warnings.push(FileWarning::MissingEnd { keyword });
    }
    file.mesh = unwelded(positions);
    Ok(file)
}

/// Skips the components of a normal, on this line or the next.
fn skip_numbers(words: &mut Words) {
    for _ in 0..3 {
        let mut behind = words.clone();
        if behind.word().and_then(number).is_none() {
            return;
        }
        *words = behind;
    }
}

fn unwelded(positions: Vec<[f64; 3]>) -> PolygonMesh {
    let faces: Vec<[u32; 3]> =
        (0..positions.len() as u32 / 3).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    PolygonMesh::from_triangles(positions, &faces)
}

/// Writes the triangles with unit normals; the normal of a degenerate triangle is zero. Binary
/// coordinates are 32-bit floats.
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
    header[..6].copy_from_slice(b"eikona"); // not "solid", which would suggest ascii
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
