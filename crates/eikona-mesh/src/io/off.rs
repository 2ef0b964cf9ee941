//! Geomview's Object File Format: OFF, COFF, NOFF, STOFF and their combinations. No Rust crate
//! keeps its polygons and colours.

use super::faces::Faces;
use super::text::decode_text;
use super::words::{Number, Words, integer, number, shown, whole};
use super::{MeshFile, MeshOut};
use crate::error::FileError;
use crate::polygon::PolygonMesh;
use crate::warning::FileWarning;
use std::io::{self, Write};

const OFF: &str = "OFF";

/// What the keyword in the first line specifies about the vertices.
#[derive(Clone, Copy, Default)]
pub(super) struct Header {
    normals: bool,
    colours: bool,
    texture: bool,
    unsupported: bool,
}

impl Header {
    /// Parses `[ST][C][N][4][n]OFF` in any case. Also returns digits that follow directly, since
    /// many ModelNet files begin with `OFF4 2 0`.
    pub fn parse(word: &[u8]) -> Option<(Header, &[u8])> {
        let at = word.windows(3).position(|w| w.eq_ignore_ascii_case(b"OFF"))?;
        let (prefix, rest) = word.split_at(at);
        let (off, digits) = rest.split_at(3);
        if !digits.iter().all(u8::is_ascii_digit) {
            return None;
        }
        // Only the case distinguishes NOFF, with normals, from nOFF, of n dimensions.
        let dimensions = off == b"OFF" && prefix.ends_with(b"n");
        let prefix = if dimensions { &prefix[..at - 1] } else { prefix }.to_ascii_uppercase();
        let take = |prefix: &mut &[u8], part: &[u8]| match prefix.strip_prefix(part) {
            Some(rest) => {
                *prefix = rest;
                true
            }
            None => false,
        };
        let mut left = prefix.as_slice();
        let (texture, colours) = (take(&mut left, b"ST"), take(&mut left, b"C"));
        let (normals, four) = (take(&mut left, b"N"), take(&mut left, b"4"));
        left.is_empty()
            .then_some((Header { normals, colours, texture, unsupported: dimensions || four }, digits))
    }

    /// Returns the names of the vertex scalars that are kept, in the order of the file.
    fn scalars(self) -> impl Iterator<Item = &'static str> {
        let normals = if self.normals { &["nx", "ny", "nz"][..] } else { &[] };
        let colours = if self.colours { &["red", "green", "blue"][..] } else { &[] };
        normals.iter().chain(colours).copied()
    }
}

/// Reads the mesh of an OFF text. The keyword may be missing; the counts may follow it or be on
/// separate lines. Lines with several vertices or faces are read if there is only one way to do so.
/// Normals of NOFF become the vertex scalars `nx`, `ny`, `nz`, and colours of COFF `red`, `green`,
/// `blue`, as written (0 to 1 or 0 to 255); other values after vertices, and colours after faces,
/// are not kept.
///
/// # Errors
/// [`FileError::Syntax`] with the line, also if there are fewer vertices or faces than the header
/// declares; [`FileError::Mesh`] with every face that refers to a vertex that does not exist;
/// [`FileError::Unsupported`] for binary OFF, 4OFF and nOFF.
pub fn read_off(bytes: &[u8]) -> Result<MeshFile, FileError> {
    let text = decode_text(bytes);
    let mut words = Words::new(&text).with_comments();
    let first = words.word().ok_or_else(|| words.fault(OFF, "the file is empty"))?;
    let (header, first_count) = match Header::parse(first) {
        Some((header, b"")) => (header, words.word()),
        Some((header, digits)) => (header, Some(digits)),
        None => (Header::default(), Some(first)),
    };
    if header.unsupported {
        return Err(FileError::Unsupported(format!(
            "{}: only vertices with three coordinates are supported; convert the file to OFF",
            shown(first)
        )));
    }
    if first_count.is_some_and(|word| word.eq_ignore_ascii_case(b"BINARY")) {
        return Err(FileError::Unsupported(
            "binary OFF is not supported; convert the file to ascii OFF or PLY".into(),
        ));
    }
    let vertices = count(&words, first_count, "vertices")?;
    let second_count = words.word();
    let faces = count(&words, second_count, "faces")?;
    let body = Body { header, keyword: first, vertices, faces };
    let starts = body.starts(words);

    let by_line = body.read(starts[0].clone(), Layout { vertex_lines: true, face_lines: true, alpha: false });
    if by_line.as_ref().is_ok_and(|file| file.warnings.is_empty()) {
        return by_line;
    }
    // Lines with several elements: accept only a layout that consumes every word of the file.
    let mut found: Vec<MeshFile> = Vec::new();
    for start in starts {
        for face_lines in [true, false] {
            for alpha in [false, true].into_iter().take(if header.colours { 2 } else { 1 }) {
                let layout = Layout { vertex_lines: false, face_lines, alpha };
                let file = body.read(start.clone(), layout).ok();
                found.extend(file.filter(|file| {
                    file.warnings.is_empty() && is_plausible(&file.mesh) && !found.contains(file)
                }));
            }
        }
    }
    match found.len() {
        0 => by_line,
        1 => Ok(found.swap_remove(0)),
        _ => Err(FileError::syntax(
            OFF,
            "whole file",
            "lines contain more than one vertex or face, and there are several ways to read them; write one per line",
        )),
    }
}

/// Returns whether every face has at least three corners, all distinct.
fn is_plausible(mesh: &PolygonMesh) -> bool {
    let mut corners = Vec::new();
    mesh.faces().all(|face| {
        corners.clear();
        corners.extend_from_slice(face);
        corners.sort_unstable();
        corners.windows(2).all(|w| w[0] != w[1]) && face.len() >= 3
    })
}

/// The arrangement of vertices and faces in lines.
#[derive(Clone, Copy)]
struct Layout {
    /// Whether the rest of a line after a vertex is ignored.
    vertex_lines: bool,
    /// Whether the rest of a line after a face is ignored.
    face_lines: bool,
    /// Whether colours have a fourth component; matters only without `vertex_lines`.
    alpha: bool,
}

/// What the header specifies about the rest of the file.
struct Body<'a> {
    header: Header,
    keyword: &'a [u8],
    vertices: usize,
    faces: usize,
}

impl Body<'_> {
    /// Skips the number of edges, given the words after the number of faces. It may be on this
    /// line, on a later one, or missing; returns both possibilities if the lines do not decide.
    fn starts<'t>(&self, mut words: Words<'t>) -> Vec<Words<'t>> {
        let width = 3 + self.header.scalars().count();
        let mut next = words.clone();
        if let Some(word) = next.word_on_line() {
            if number(word).is_some_and(|x| whole(x).is_none()) {
                return vec![words]; // a coordinate
            }
            // The rest of the line may contain vertices.
            if words_on_line(next.clone()) < width {
                next.next_line();
            }
            return vec![next];
        }
        words.next_line();
        let mut lines = words.clone();
        let mut line_width = || loop {
            match words_on_line(lines.clone()) {
                0 if lines.next_line() => {}
                width => {
                    lines.next_line();
                    return width;
                }
            }
        };
        let widths = (line_width(), line_width());
        let mut behind = words.clone();
        let is_whole = behind.word().and_then(integer).is_some();
        match widths {
            (1, _) if is_whole => vec![behind],
            (0..=2, _) => vec![words],
            (_, 0) if is_whole => vec![words, behind],
            // The number of edges shares a line with the first vertices.
            (first, second)
                if is_whole
                    && self.vertices > 1
                    && (first % width == 1 && second % width == 0
                        || second >= width && first == second + 1) =>
            {
                vec![behind]
            }
            _ => vec![words],
        }
    }

    fn read(&self, mut words: Words, layout: Layout) -> Result<MeshFile, FileError> {
        let Body { header, keyword, vertices, faces } = *self;
        let mut file = MeshFile::default();
        let mut columns: Vec<(&str, Vec<f64>)> = header.scalars().map(|name| (name, Vec::new())).collect();
        let passed_over = usize::from(header.colours && layout.alpha) + if header.texture { 2 } else { 0 };
        // A vertex takes at least six bytes: "0 0 0" and a line end.
        let mut positions = Vec::with_capacity(vertices.min(words.remaining() / 6));
        let mut line_before = 0;
        for i in 0..vertices {
            let mut position = [0.0; 3];
            let mut line = 0;
            for (k, coordinate) in position.iter_mut().enumerate() {
                let word = words.word().ok_or_else(|| truncated(&words, "vertices", vertices, i))?;
                *coordinate = number(word).ok_or_else(|| {
                    words.fault(OFF, format!("vertex {i}: {} is not a number", shown(word)))
                })?;
                if k == 0 {
                    line = words.line();
                }
            }
            if layout.vertex_lines && words.line() > line && words_on_line(words.clone()) > 0 {
                let problem =
                    format!("vertex {i}, which begins in line {line}, ends in the middle of this line");
                return Err(words.fault(OFF, problem));
            }
            positions.push(position);
            for (name, values) in &mut columns {
                let word = if layout.vertex_lines { words.word_on_line() } else { words.word() };
                let word = word.unwrap_or_default();
                values.push(number(word).ok_or_else(|| {
                    let problem = format!(
                        "vertex {i}: found {}, but {} specifies {name} here",
                        shown(word),
                        shown(keyword)
                    );
                    words.fault(OFF, problem)
                })?);
            }
            if layout.vertex_lines {
                words.next_line();
            } else {
                for _ in 0..passed_over {
                    words.word();
                }
                // Guards against reading four colour components as three, or the reverse.
                if header.colours && line == line_before && words.line() > line {
                    return Err(words.fault(OFF, format!("vertex {i} is not on a single line")));
                }
                line_before = words.line();
            }
        }
        let mut polygons = Faces::default();
        let mut corners = Vec::new();
        for i in 0..faces {
            let word = words.word().ok_or_else(|| truncated(&words, "faces", faces, i))?;
            let bad = |words: &Words, word| {
                words.fault(OFF, format!("face {i}: {} is not an integer", shown(word)))
            };
            let length = integer(word).ok_or_else(|| bad(&words, word))?;
            let length = usize::try_from(length).map_err(|_| {
                words.fault(OFF, format!("face {i} specifies {length} corners; correct the number"))
            })?;
            corners.clear();
            for _ in 0..length {
                let word = words.word().ok_or_else(|| truncated(&words, "faces", faces, i))?;
                corners.push(integer(word).ok_or_else(|| bad(&words, word))?);
            }
            polygons.push(&corners)?;
            if layout.face_lines {
                words.next_line(); // a colour
            }
        }
        if words.word().is_some() {
            let declared = format!("{faces} faces");
            file.warnings.push(FileWarning::TrailingLines { line: words.line(), declared });
        }
        file.mesh = polygons.finish(positions)?;
        file.vertex_scalars = columns.into_iter().map(|(name, values)| (name.to_string(), values)).collect();
        Ok(file)
    }
}

fn words_on_line(mut words: Words) -> usize {
    std::iter::from_fn(|| words.word_on_line()).count()
}

fn count(words: &Words, word: Option<&[u8]>, what: &str) -> Result<usize, FileError> {
    let word = word.unwrap_or_default();
    integer(word).and_then(|n| usize::try_from(n).ok()).ok_or_else(|| {
        let problem =
            format!("expected the number of {what}, found {}; check that this is an OFF file", shown(word));
        words.fault(OFF, problem)
    })
}

fn truncated(words: &Words, what: &str, declared: usize, found: usize) -> FileError {
    let problem = format!(
        "the file ends after {found} of {declared} {what}; it is truncated, or the counts in its header are wrong"
    );
    words.fault(OFF, problem)
}

/// Writes OFF, or COFF if there are colours.
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
