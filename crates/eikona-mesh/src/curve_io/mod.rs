//! Curve files: our JSON, lines of OBJ files, and the text formats of signed-heat-demo and of SWN
//! (surface winding numbers).
//!
//! The two text formats number the edges of the mesh. Their rule is that of our
//! [`Edge`](crate::Edge) ids: edge `i` is the `i`-th one met when the faces are walked in order,
//! and `t` runs in the direction in which the edge was first met. A curve made for a polygon mesh
//! numbers the edges of the polygons, which a triangulation does not keep.

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
pub use obj::curves_from_lines;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A polyline in space, to be projected to a surface and traced over its faces.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpacePolyline {
    /// Oriented or not.
    #[serde(default)]
    pub kind: CurveKind,
    /// Whether the last point is joined to the first. The first point is not repeated at the end.
    #[serde(default)]
    pub closed: bool,
    /// The corners.
    pub points: Vec<[f64; 3]>,
}

impl SpacePolyline {
    /// A polyline whose last point may repeat the first, which closes it.
    pub(crate) fn from_points(kind: CurveKind, points: Vec<[f64; 3]>) -> Self {
        let closed = points.len() > 2 && points.first() == points.last();
        let mut polyline = SpacePolyline { kind, closed, points };
        polyline.drop_repeated_end();
        polyline
    }

    /// Takes from the end of a closed polyline all points that repeat the first, so that reading
    /// what was written takes no more.
    fn drop_repeated_end(&mut self) {
        while self.closed && self.points.len() > 2 && self.points.first() == self.points.last() {
            self.points.pop();
        }
    }
}

/// What a curve file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurveFile {
    /// Curves and points on the surface. Every node has been looked up in the mesh; segments may
    /// still span several faces.
    pub curves: SurfaceCurves,
    /// Polylines in space.
    pub polylines: Vec<SpacePolyline>,
    /// What was passed over or changed, with the line.
    pub warnings: Vec<String>,
}

/// The curve formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveFormat {
    /// Our own: `{"eikona":"curves","version":1,"curves":[..],"points":[..],"polylines":[..]}`.
    Json,
    /// `l` lines over the file's own `v` lines. Where these are the vertices of the mesh, the lines
    /// are curves through vertices; otherwise they are polylines in space.
    Obj,
    /// Blocks `signed_curve [0|1]`, `unsigned_curve`, `unsigned_point` of `v i`, `e i t`, `f i a b
    /// c`, `l i j ..`.
    SignedHeatDemo,
    /// Nodes `v i`, `e i t`, `f i a b c`, and segments `l a b` between them.
    SurfaceWinding,
}

impl CurveFormat {
    /// The format of a file, by what is in it; the extension decides where the content does not.
    pub fn detect(path: &Path, bytes: &[u8]) -> CurveFormat {
        // A `v` line of OBJ may go on in the next one.
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

    /// The format that a file of this name is written in: `.json`, `.obj`, and `.txt` for
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

/// Reads a curve file for this mesh; the format is found by [`CurveFormat::detect`].
///
/// # Errors
/// [`FileError::Io`], [`FileError::Syntax`] with the line, the value and what is expected: also for
/// a vertex, edge or face that the mesh does not have.
///
/// # Cost
/// Linear in the file (n log n for the joining of SWN segments).
pub fn read_curves(path: impl AsRef<Path>, mesh: &TriangleMesh) -> Result<CurveFile, FileError> {
    let path = path.as_ref();
    let name = path.display().to_string();
    let bytes = std::fs::read(path).map_err(|fault| FileError::Io { path: name.clone(), fault })?;
    let bytes = without_gzip(bytes, &name)?;
    read_curves_bytes(&bytes, CurveFormat::detect(path, &bytes), mesh)
}

/// The text of a curve file in UTF-8 with `\n` at the ends of lines, whatever its encoding and line
/// ends.
pub fn curve_text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(&decode_text(bytes)).replace("\r\n", "\n").replace('\r', "\n")
}

/// The curves in the bytes of a file.
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
/// As [`read_curves`].
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

/// The text of a curve file.
///
/// # Errors
/// [`FileError::Unsupported`] when the format can not hold something: polylines in space and `up`
/// go into JSON only (the polylines also into OBJ), unsigned curves and points not into
/// [`CurveFormat::SurfaceWinding`]. [`FileError::Curve`] when a node is not on the mesh.
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

/// Writes a curve file whole or not at all.
///
/// # Errors
/// Those of [`format_curves`], and [`FileError::Io`].
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

/// Writes curves on a surface as JSON, which keeps everything.
///
/// # Errors
/// As [`write_curves`].
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

/// One line of a text format: its words, and where it stands.
struct Line<'a> {
    format: &'static str,
    number: usize,
    words: Vec<&'a str>,
}

impl<'a> Line<'a> {
    /// The line at this place, counted from 0. A comment behind other words is passed over.
    fn new(format: &'static str, index: usize, text: &'a str) -> Self {
        let words = text.split_whitespace().enumerate();
        let words = words.take_while(|(i, word)| *i == 0 || !word.starts_with('#')).map(|(_, word)| word);
        Line { format, number: index + 1, words: words.collect() }
    }
    /// A [`FileError::Syntax`] at this line.
    fn error(&self, problem: impl std::fmt::Display) -> FileError {
        FileError::syntax(self.format, format!("line {}", self.number), problem.to_string())
    }
    /// The word at this place.
    fn word(&self, place: usize, what: &str) -> Result<&'a str, FileError> {
        self.words
            .get(place)
            .copied()
            .ok_or_else(|| self.error(format!("\"{}\" ends before its {what}; add it", self.words.join(" "))))
    }
    /// A whole number.
    fn integer(&self, place: usize, what: &str) -> Result<i64, FileError> {
        let word = self.word(place, what)?;
        word.parse().map_err(|_| self.error(format!("\"{word}\" is not a whole number; expected the {what}")))
    }
    /// A finite number.
    fn number(&self, place: usize, what: &str) -> Result<f64, FileError> {
        let word = self.word(place, what)?;
        let fault = || self.error(format!("\"{word}\" is not a finite number; expected the {what}"));
        let value: f64 = word.parse().map_err(|_| fault())?;
        if value.is_finite() { Ok(value) } else { Err(fault()) }
    }
    /// Refuses more words than this.
    fn at_most(&self, words: usize) -> Result<(), FileError> {
        match self.words.get(words) {
            Some(extra) => Err(self.error(format!("\"{extra}\" is one word too many; remove it"))),
            None => Ok(()),
        }
    }

    /// The index of an element that the mesh has `count` of; in the file they are numbered from
    /// `base`.
    fn element(&self, place: usize, kind: &'static str, count: usize, base: i64) -> Result<u32, FileError> {
        let given = self.integer(place, &format!("{kind} index"))?;
        let index = given.checked_sub(base).filter(|i| (0..count as i64).contains(i));
        index.map(|i| i as u32).ok_or_else(|| {
            self.error(format!(
                "{kind} {given} does not exist: the mesh has {count}, numbered from {base} here; correct the index, or check \
                 that this is the mesh the curve was made for"
            ))
        })
    }

    /// A node `v i`, `e i t`, `f i a b` or `f i a b c`, or `None` if the line is something else.
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

/// A node as both text formats write it, with indices from 0. `None` for a node that is not on the
/// mesh.
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

/// Refuses what only JSON can hold.
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
