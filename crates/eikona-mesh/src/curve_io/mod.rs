//! Curve files: the native JSON format, `l` lines of OBJ files, and the text formats of
//! signed-heat-demo and of SWN (surface winding numbers).
//!
//! The two text formats refer to edges of the mesh by number. Their numbering is that of the
//! [`Edge`](crate::Edge) ids: edge `i` is the `i`-th one met when the faces are visited in order,
//! and `t` runs in the direction in which the edge was first met. A curve made for a polygon mesh
//! numbers the edges of the polygons, which a triangulation does not preserve.

mod chain;
mod json;
mod obj;
mod signed_heat_text;
mod winding_text;

use crate::curve::{Curve, CurveKind, SurfaceCurves};
use crate::error::{CurveError, FileError};
use crate::id::{Edge, Face};
use crate::io::{decode_text, without_gzip, write_atomically};
use crate::mesh::TriangleMesh;
use crate::point::SurfacePoint;
use crate::warning::FileWarning;
pub use obj::curves_from_lines;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A polyline in space, to be projected onto a surface and traced across its faces.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpacePolyline {
    /// Whether the curve is oriented.
    #[serde(default)]
    pub kind: CurveKind,
    /// Whether the last point is joined to the first. The first point is not repeated at the end.
    #[serde(default)]
    pub closed: bool,
    /// The vertices of the polyline.
    pub points: Vec<[f64; 3]>,
}

impl SpacePolyline {
    /// Creates a polyline whose last point may repeat the first, which closes it.
    pub(crate) fn from_points(kind: CurveKind, points: Vec<[f64; 3]>) -> Self {
        let closed = points.len() > 2 && points.first() == points.last();
        let mut polyline = SpacePolyline { kind, closed, points };
        polyline.drop_repeated_end();
        polyline
    }

    /// Removes all points at the end of a closed polyline that repeat the first, so that reading
    /// back what was written removes no more.
    fn drop_repeated_end(&mut self) {
        while self.closed && self.points.len() > 2 && self.points.first() == self.points.last() {
            self.points.pop();
        }
    }
}

/// The contents of a curve file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurveFile {
    /// Curves and points on the surface. Every node exists in the mesh; segments may still span
    /// several faces.
    pub curves: SurfaceCurves,
    /// Polylines in space.
    pub polylines: Vec<SpacePolyline>,
    /// Warnings about what was skipped or changed, with the line.
    pub warnings: Vec<FileWarning>,
}

/// A curve file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveFormat {
    /// The native format:
    /// `{"eikona":"curves","version":1,"curves":[..],"points":[..],"polylines":[..]}`.
    Json,
    /// `l` lines over the file's own `v` lines. If these are the vertices of the mesh, the lines
    /// are curves through vertices; otherwise they are polylines in space.
    Obj,
    /// Blocks `signed_curve [0|1]`, `unsigned_curve`, `unsigned_point` of `v i`, `e i t`, `f i a b
    /// c`, `l i j ..`.
    SignedHeatDemo,
    /// Nodes `v i`, `e i t`, `f i a b c`, and segments `l a b` between them.
    SurfaceWinding,
}

impl CurveFormat {
    /// Detects the format of a file by its content, or by its extension if the content does not
    /// decide.
    pub fn detect(path: &Path, bytes: &[u8]) -> CurveFormat {
        // A `v` line of OBJ may continue on the next line.
        let text = curve_text(bytes).replace("\\\n", " ");
        let text = text.trim_start();
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        if text.starts_with('{') {
            return CurveFormat::Json;
        }
        for (i, line) in text.lines().enumerate() {
            let words = Line::new("", i, line).words;
            match (words.first().copied(), words.len().saturating_sub(1)) {
                (Some("signed_curve" | "unsigned_curve" | "unsigned_point"), _) => {
                    return CurveFormat::SignedHeatDemo;
                }
                (Some("v"), 3..) => return CurveFormat::Obj,
                (Some("v" | "e"), 1..) => return CurveFormat::SurfaceWinding,
                _ => {}
            }
        }
        match extension.as_str() {
            "json" => CurveFormat::Json,
            "obj" => CurveFormat::Obj,
            _ => CurveFormat::SurfaceWinding,
        }
    }

    /// Returns the format in which a file of this name is written: `.json`, `.obj`, and `.txt` for
    /// signed-heat-demo.
    pub fn from_extension(path: &Path) -> Option<CurveFormat> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "json" => Some(CurveFormat::Json),
            "obj" => Some(CurveFormat::Obj),
            "txt" => Some(CurveFormat::SignedHeatDemo),
            _ => None,
        }
    }
}

/// Reads a curve file for this mesh, in the format found by [`CurveFormat::detect`].
///
/// # Errors
/// [`FileError::Io`]; [`FileError::Syntax`] with the line, the value and what is expected, also for
/// a vertex, edge or face that the mesh does not have.
///
/// # Cost
/// Linear in the file size (n log n to join SWN segments).
pub fn read_curves(path: impl AsRef<Path>, mesh: &TriangleMesh) -> Result<CurveFile, FileError> {
    let path = path.as_ref();
    let name = path.display().to_string();
    let bytes = std::fs::read(path).map_err(|fault| FileError::Io { path: name.clone(), fault })?;
    let bytes = without_gzip(bytes, &name)?;
    read_curves_bytes(&bytes, CurveFormat::detect(path, &bytes), mesh)
}

/// Decodes a curve file to UTF-8 with `\n` line ends, whatever its encoding and line ends.
pub fn curve_text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(&decode_text(bytes)).replace("\r\n", "\n").replace('\r', "\n")
}

/// Reads curves from the bytes of a file.
///
/// ```
/// use eikona_mesh::{CurveFormat, TriangleMesh, read_curves_bytes};
/// let mesh = TriangleMesh::new(vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], vec![[0, 1, 2]])?;
/// let text = b"signed_curve\nv 0\ne 1 0.5\n";
/// let file = read_curves_bytes(text, CurveFormat::SignedHeatDemo, &mesh)?;
/// assert_eq!(file.curves.segments(&mesh)?[0].ends[1].position(&mesh), [0.5, 0.5, 0.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As for [`read_curves`].
pub fn read_curves_bytes(
    bytes: &[u8],
    format: CurveFormat,
    mesh: &TriangleMesh,
) -> Result<CurveFile, FileError> {
    let text = curve_text(bytes);
    match format {
        CurveFormat::Json => json::read(&text, mesh),
        CurveFormat::Obj => obj::read(&text, mesh),
        CurveFormat::SignedHeatDemo => signed_heat_text::read(&text, mesh),
        CurveFormat::SurfaceWinding => winding_text::read(&text, mesh),
    }
}

/// Returns the text of a curve file.
///
/// # Errors
/// [`FileError::Unsupported`] if the format can not hold something: only JSON holds `up`, only JSON
/// and OBJ hold polylines in space, and [`CurveFormat::SurfaceWinding`] holds neither unsigned
/// curves nor points. [`FileError::Curve`] if a node is not on the mesh.
pub fn format_curves(
    file: &CurveFile,
    format: CurveFormat,
    mesh: &TriangleMesh,
) -> Result<String, FileError> {
    check_nodes(&file.curves, mesh)?;
    if file.polylines.iter().flat_map(|p| &p.points).flatten().any(|x| !x.is_finite()) {
        return Err(FileError::Unsupported(
            "a polyline has a coordinate that is not finite; correct it before writing".into(),
        ));
    }
    match format {
        CurveFormat::Json => json::write(file),
        CurveFormat::Obj => obj::write(file, mesh),
        CurveFormat::SignedHeatDemo => signed_heat_text::write(file, mesh),
        CurveFormat::SurfaceWinding => winding_text::write(file, mesh),
    }
}

/// Writes a curve file atomically.
///
/// # Errors
/// As for [`format_curves`], and [`FileError::Io`].
pub fn write_curves(
    path: impl AsRef<Path>,
    file: &CurveFile,
    format: CurveFormat,
    mesh: &TriangleMesh,
) -> Result<(), FileError> {
    let path = path.as_ref();
    let text = format_curves(file, format, mesh)?;
    write_atomically(path, |out| out.write_all(text.as_bytes()))
}

/// Writes curves on a surface as JSON, which is lossless.
///
/// # Errors
/// As for [`write_curves`].
pub fn write_curves_json(
    path: impl AsRef<Path>,
    file: &CurveFile,
    mesh: &TriangleMesh,
) -> Result<(), FileError> {
    write_curves(path, file, CurveFormat::Json, mesh)
}

fn check_nodes(curves: &SurfaceCurves, mesh: &TriangleMesh) -> Result<(), CurveError> {
    for (c, curve) in curves.curves.iter().enumerate() {
        for (n, node) in curve.nodes.iter().enumerate() {
            node.locate(mesh).map_err(|e| e.at(c, n))?;
        }
    }
    for (i, point) in curves.points.iter().enumerate() {
        point.locate(mesh).map_err(|e| e.at_point(i))?;
    }
    Ok(())
}

/// One line of a text format: its words and its number.
struct Line<'a> {
    format: &'static str,
    number: usize,
    words: Vec<&'a str>,
}

impl<'a> Line<'a> {
    /// Splits the line at this 0-based index into words. A comment after other words is ignored.
    fn new(format: &'static str, index: usize, text: &'a str) -> Self {
        let words = text.split_whitespace().enumerate();
        let words = words.take_while(|(i, word)| *i == 0 || !word.starts_with('#')).map(|(_, word)| word);
        Line { format, number: index + 1, words: words.collect() }
    }
    /// Creates a [`FileError::Syntax`] at this line.
    fn error(&self, problem: impl std::fmt::Display) -> FileError {
        FileError::syntax(self.format, format!("line {}", self.number), problem.to_string())
    }
    /// Returns the word at this position.
    fn word(&self, place: usize, what: &str) -> Result<&'a str, FileError> {
        self.words
            .get(place)
            .copied()
            .ok_or_else(|| self.error(format!("\"{}\" ends before its {what}; add it", self.words.join(" "))))
    }
    /// Parses an integer.
    fn integer(&self, place: usize, what: &str) -> Result<i64, FileError> {
        let word = self.word(place, what)?;
        word.parse().map_err(|_| self.error(format!("\"{word}\" is not an integer; expected the {what}")))
    }
    /// Parses a finite number.
    fn number(&self, place: usize, what: &str) -> Result<f64, FileError> {
        let word = self.word(place, what)?;
        let fault = || self.error(format!("\"{word}\" is not a finite number; expected the {what}"));
        let value: f64 = word.parse().map_err(|_| fault())?;
        if value.is_finite() { Ok(value) } else { Err(fault()) }
    }
    /// Fails if there are more words than this.
    fn at_most(&self, words: usize) -> Result<(), FileError> {
        match self.words.get(words) {
            Some(extra) => Err(self.error(format!("unexpected word \"{extra}\"; remove it"))),
            None => Ok(()),
        }
    }

    /// Parses the index of one of `count` elements, which the file numbers from `base`.
    fn element(&self, place: usize, kind: &'static str, count: usize, base: i64) -> Result<u32, FileError> {
        let given = self.integer(place, &format!("{kind} index"))?;
        let index = given.checked_sub(base).filter(|i| (0..count as i64).contains(i));
        index.map(|i| i as u32).ok_or_else(|| {
            self.error(format!(
                "{kind} {given} does not exist: the mesh has {count}, numbered from {base} here; correct the index, or check \
                 that this is the mesh that the curve belongs to"
            ))
        })
    }

    /// Parses a node `v i`, `e i t`, `f i a b` or `f i a b c`; `None` if the line is something
    /// else.
    fn node(&self, mesh: &TriangleMesh, base: i64) -> Result<Option<SurfacePoint>, FileError> {
        let point = match self.words.first() {
            Some(&"v") => {
                self.at_most(2)?;
                SurfacePoint::Vertex { vertex: self.element(1, "vertex", mesh.vertex_count(), base)? }
            }
            Some(&"e") => {
                self.at_most(3)?;
                let edge = Edge(self.element(1, "edge", mesh.edge_count(), base)?);
                SurfacePoint::Edge {
                    vertices: mesh.edge_vertices(edge).map(|v| v.0),
                    t: self.number(2, "parameter t in [0, 1]")?,
                }
            }
            Some(&"f") => {
                self.at_most(5)?;
                let face = Face(self.element(1, "face", mesh.face_count(), base)?);
                let (a, b) = (self.number(2, "first weight")?, self.number(3, "second weight")?);
                let c = if self.words.len() > 4 { self.number(4, "third weight")? } else { 1.0 - a - b };
                SurfacePoint::Face { vertices: mesh.face_vertices(face).map(|v| v.0), bary: [a, b, c] }
            }
            _ => return Ok(None),
        };
        point.locate(mesh).map_err(|e| self.error(e))?;
        Ok(Some(point))
    }
}

/// Formats a node as both text formats do, with indices from 0. `None` for a node that is not on
/// the mesh.
fn node_line(point: &SurfacePoint, mesh: &TriangleMesh) -> Option<String> {
    use crate::id::Vertex;
    Some(match *point {
        SurfacePoint::Vertex { vertex } => format!("v {vertex}\n"),
        SurfacePoint::Edge { vertices: [a, b], t } => {
            let edge = mesh.find_edge(Vertex(a), Vertex(b))?;
            let along = mesh.edge_vertices(edge)[0] == Vertex(a);
            format!("e {} {}\n", edge.0, if along { t } else { 1.0 - t })
        }
        SurfacePoint::Face { vertices, bary } => {
            let face = mesh.find_face(vertices.map(Vertex))?;
            let weight = |v: Vertex| vertices.iter().zip(bary).find(|(u, _)| **u == v.0).map(|(_, w)| w);
            let [a, b, c] = mesh.face_vertices(face).map(weight);
            format!("f {} {} {} {}\n", face.0, a?, b?, c?)
        }
    })
}

/// Fails if the file contains what only JSON can hold.
fn refuse_polylines_and_normals(file: &CurveFile, format: &str) -> Result<(), FileError> {
    if !file.polylines.is_empty() {
        return Err(FileError::Unsupported(format!(
            "{format} files can not hold polylines in space; write JSON or OBJ, or trace them over the mesh first"
        )));
    }
    if let Some(c) = file.curves.curves.iter().position(|c: &Curve| c.up.is_some()) {
        return Err(FileError::Unsupported(format!(
            "{format} files can not hold the normal `up` of curve {c}; write JSON"
        )));
    }
    Ok(())
}
