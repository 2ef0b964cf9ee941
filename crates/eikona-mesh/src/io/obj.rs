//! Wavefront OBJ: `v`, `vt`, `f`, `l` and `p` lines; everything else is ignored.
//!
//! Own reader: tobj triangulates or re-indexes by position/texture/normal triples, which loses the
//! order and count of vertices, and it drops `l` lines. Version 4.0 reads UTF-16 as an empty mesh.

use super::text::decode_text;
use super::words::{Number, Words, integer, number, shown};
use super::{MeshFile, MeshOut};
use crate::error::FileError;
use crate::polygon::PolygonMesh;
use crate::warning::FileWarning;
use std::io::{self, Write};

const OBJ: &str = "OBJ";

/// Reads the mesh and lines of an OBJ text. Colours after the coordinates (`v x y z r g b`) become
/// the vertex scalars `red`, `green` and `blue`; a single fourth number is a weight and is ignored;
/// texture coordinates are kept if every corner of every face has them; normals are not kept.
///
/// # Errors
/// [`FileError::Syntax`] with the line: a word that is not a number, an index that is 0 or out of
/// range, no vertex at all.
pub fn read_obj(bytes: &[u8]) -> Result<MeshFile, FileError> {
    let text = decode_text(bytes);
    let mut words = Words::new(&text).with_comments().with_continuation(begins_statement);
    let mut content = Content::default();
    loop {
        match words.word_on_line() {
            Some(b"v") => content.vertex(&mut words)?,
            Some(b"vt") => content.texture(&mut words),
            Some(b"f") => {
                content.indices(&mut words, Keyword::Face)?;
                let Content { mesh, corners, .. } = &mut content;
                mesh.push_face(corners.iter().copied());
            }
            Some(b"l") => {
                content.indices(&mut words, Keyword::Line)?;
                content.lines.push(content.corners.clone());
            }
            Some(b"p") => {
                content.indices(&mut words, Keyword::Point)?;
                content.points.extend_from_slice(&content.corners);
            }
            _ => {}
        }
        if !words.next_line() {
            break;
        }
    }
    let mut file = content.finish()?;
    if let Some(line) = words.not_joined() {
        file.warnings.push(FileWarning::UnjoinedLine { line });
    }
    Ok(file)
}

/// Returns whether the text begins with a statement. A backslash before it (as in `g C:\`) does not
/// join the lines.
fn begins_statement(line: &[u8]) -> bool {
    let mut words = Words::new(line);
    let (keyword, value) = (words.word_on_line(), words.word_on_line());
    match keyword {
        // A continued list of names may contain these letters, but then no number follows.
        Some(b"v" | b"vn" | b"vt" | b"vp" | b"f" | b"l" | b"p") => {
            value.and_then(|w| w.split(|&b| b == b'/').next()).and_then(number).is_some()
        }
        Some(b"g" | b"o" | b"s" | b"usemtl" | b"mtllib") => value.is_some(),
        _ => false,
    }
}

/// A statement that lists vertices.
#[derive(Clone, Copy, PartialEq)]
enum Keyword {
    Face,
    Line,
    Point,
}

#[derive(Default)]
struct Content {
    mesh: PolygonMesh,
    lines: Vec<Vec<u32>>,
    points: Vec<u32>,
    /// Texture coordinates; NaN for what is not a number.
    textures: Vec<[f64; 2]>,
    /// The 0-based texture index of each face corner that has one.
    corner_textures: Vec<usize>,
    /// Colours of the first vertices; NaN where a vertex before a coloured one has none.
    colours: Vec<[f64; 3]>,
    /// The vertices of the current `f`, `l` or `p` line.
    corners: Vec<u32>,
    /// Forward references, (line, 1-based index), each larger than all before: the first to exceed
    /// the final count is among them.
    forward: Vec<(usize, i64)>,
}

impl Content {
    fn vertex(&mut self, words: &mut Words) -> Result<(), FileError> {
        // x y z, then nothing, w, r g b, or r g b a.
        let mut values = [0.0; 7];
        let mut count = 0;
        while let Some(word) = words.word_on_line() {
            let Some(value) = values.get_mut(count) else { break };
            *value = number(word).ok_or_else(|| {
                words.fault(OBJ, format!("{} is not a number; v expects coordinates", shown(word)))
            })?;
            count += 1;
        }
        let [x, y, z, r, g, b, _] = values;
        if count < 3 {
            return Err(words.fault(OBJ, format!("v has {count} coordinates but needs 3")));
        }
        if count >= 6 {
            self.colours.resize(self.mesh.positions.len(), [f64::NAN; 3]);
            self.colours.push([r, g, b]);
        }
        self.mesh.positions.push([x, y, z]);
        Ok(())
    }

    /// Reads u and v (0 if missing) without checks: nothing depends on them.
    fn texture(&mut self, words: &mut Words) {
        let mut coordinate =
            |missing: f64| words.word_on_line().map_or(missing, |w| number(w).unwrap_or(f64::NAN));
        self.textures.push([coordinate(f64::NAN), coordinate(0.0)]);
    }

    /// Reads the vertices of an `f`, `l` or `p` line into `corners`; texture and normal indices
    /// follow a slash.
    fn indices(&mut self, words: &mut Words, line: Keyword) -> Result<(), FileError> {
        let keyword = match line {
            Keyword::Face => "f",
            Keyword::Line => "l",
            Keyword::Point => "p",
        };
        self.corners.clear();
        let vertices = self.mesh.positions.len() as i64;
        while let Some(word) = words.word_on_line() {
            let mut parts = word.split(|&b| b == b'/');
            let vertex = parts.next().unwrap_or(word);
            if line == Keyword::Face
                && let Some(index) = parts.next().and_then(integer)
            {
                let count = self.textures.len() as i64;
                let from_0 = if index < 0 { count.saturating_add(index) } else { index - 1 };
                self.corner_textures.extend(usize::try_from(from_0));
            }
            let index = integer(vertex).ok_or_else(|| {
                words.fault(OBJ, format!("{keyword} contains {}, which is not a vertex number", shown(word)))
            })?;
            if index == 0 {
                let problem =
                    format!("{keyword} refers to vertex 0; OBJ counts vertices from 1, or backwards from -1");
                return Err(words.fault(OBJ, problem));
            }
            self.corners.push(if index > 0 {
                // beyond all vertices: reported as a forward reference
                u32::try_from(index - 1).unwrap_or(u32::MAX)
            } else {
                u32::try_from(vertices.saturating_add(index)).map_err(|_| {
                    let problem = format!(
                        "{keyword} refers to vertex {index}, but only {vertices} vertices precede it; correct the index"
                    );
                    words.fault(OBJ, problem)
                })?
            });
            if index > vertices && self.forward.last().is_none_or(|(_, largest)| index > *largest) {
                self.forward.push((words.line(), index));
            }
        }
        Ok(())
    }

    fn finish(self) -> Result<MeshFile, FileError> {
        let vertices = self.mesh.positions.len();
        if vertices == 0 {
            return Err(FileError::syntax(
                OBJ,
                "whole file",
                "the file has no vertices (`v x y z`); check that it is an OBJ file",
            ));
        }
        if let Some((line, index)) = self.forward.iter().find(|(_, index)| *index > vertices as i64) {
            let problem = format!(
                "vertex {index} does not exist: there are {vertices} vertices (1 to {vertices}); correct the index"
            );
            return Err(FileError::syntax(OBJ, format!("line {line}"), problem));
        }
        let mut file =
            MeshFile { mesh: self.mesh, lines: self.lines, points: self.points, ..MeshFile::default() };
        let corners: usize = file.mesh.faces().map(<[u32]>::len).sum();
        if corners > 0 && self.corner_textures.len() == corners {
            let coordinates = self.corner_textures.iter().map(|&i| self.textures.get(i).copied());
            file.corner_uvs = coordinates.collect();
        }
        let mut colours = self.colours;
        if !colours.is_empty() {
            colours.resize(vertices, [f64::NAN; 3]);
            let bare = colours.iter().filter(|c| c[0].is_nan()).count();
            if bare > 0 {
                file.warnings.push(FileWarning::MissingValues { field: "colour".into(), count: Some(bare) });
            }
            for (k, name) in ["red", "green", "blue"].into_iter().enumerate() {
                file.vertex_scalars.push((name.into(), colours.iter().map(|c| c[k]).collect()));
            }
        }
        Ok(file)
    }
}

/// Writes `v`, `vt`, `f` and `l` lines. Corner texture coordinates are written as one `vt` per
/// corner; without them, the first vertex scalar is written as `vt value 0`, one per vertex, if
/// requested.
pub(super) fn write_obj(out: &mut dyn Write, mesh: &MeshOut) -> io::Result<()> {
    for (i, &[x, y, z]) in mesh.positions().iter().enumerate() {
        write!(out, "v {} {} {}", Number(x), Number(y), Number(z))?;
        if let Some(colour) = mesh.vertex_colours.and_then(|c| c.get(i)) {
            let [r, g, b] = colour.map(|c| Number(f64::from(c) / 255.0));
            write!(out, " {r} {g} {b}")?;
        }
        writeln!(out)?;
    }
    let scalar = mesh.scalar_as_texture();
    if let Some(uvs) = mesh.corner_uvs {
        for [u, v] in uvs {
            writeln!(out, "vt {} {}", Number(*u), Number(*v))?;
        }
    } else if let Some((_, values)) = scalar {
        for value in values {
            writeln!(out, "vt {} 0", Number(*value))?;
        }
    }
    let mut corner = 0;
    for face in mesh.faces() {
        write!(out, "f")?;
        for v in face {
            corner += 1;
            if mesh.corner_uvs.is_some() {
                write!(out, " {}/{corner}", v + 1)?;
            } else if scalar.is_some() {
                write!(out, " {0}/{0}", v + 1)?;
            } else {
                write!(out, " {}", v + 1)?;
            }
        }
        writeln!(out)?;
    }
    for line in mesh.lines {
        write!(out, "l")?;
        for v in line {
            write!(out, " {}", v + 1)?;
        }
        writeln!(out)?;
    }
    Ok(())
}
