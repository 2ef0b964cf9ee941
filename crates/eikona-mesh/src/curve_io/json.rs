//! The native curve format (JSON), which identifies elements by vertices and is lossless.

use super::{CurveFile, SpacePolyline};
use crate::curve::{Curve, CurveKind, SurfaceCurves};
use crate::error::FileError;
use crate::mesh::TriangleMesh;
use crate::point::SurfacePoint;
use serde::{Deserialize, Serialize};

const FORMAT: &str = "curve JSON";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    eikona: String,
    version: u32,
    #[serde(default)]
    curves: Vec<CurveEntry>,
    #[serde(default)]
    points: Vec<Node>,
    #[serde(default)]
    polylines: Vec<SpacePolyline>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CurveEntry {
    #[serde(default)]
    kind: CurveKind,
    nodes: Vec<Node>,
    #[serde(default)]
    up: Option<[f64; 3]>,
}

/// A [`SurfacePoint`] read key by key, so that the error names a wrong key (an untagged enum only
/// reports "no match").
#[derive(Deserialize)]
#[serde(try_from = "NodeKeys")]
struct Node(SurfacePoint);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NodeKeys {
    vertex: Option<u32>,
    edge: Option<[u32; 2]>,
    t: Option<f64>,
    face: Option<[u32; 3]>,
    bary: Option<[f64; 3]>,
}

impl TryFrom<NodeKeys> for Node {
    type Error = &'static str;
    fn try_from(keys: NodeKeys) -> Result<Node, Self::Error> {
        Ok(Node(match keys {
            NodeKeys { vertex: Some(vertex), edge: None, t: None, face: None, bary: None } => {
                SurfacePoint::Vertex { vertex }
            }
            NodeKeys { vertex: None, edge: Some(vertices), t: Some(t), face: None, bary: None } => {
                SurfacePoint::Edge { vertices, t }
            }
            NodeKeys { vertex: None, edge: None, t: None, face: Some(vertices), bary: Some(bary) } => {
                SurfacePoint::Face { vertices, bary }
            }
            _ => {
                return Err("a node is {\"vertex\": i}, or {\"edge\": [i, j], \"t\": t}, or \
                            {\"face\": [i, j, k], \"bary\": [a, b, c]}, with exactly these keys");
            }
        }))
    }
}

pub(super) fn read(text: &str, mesh: &TriangleMesh) -> Result<CurveFile, FileError> {
    let document: Document = serde_json::from_str(text).map_err(|e| {
        let message = e.to_string();
        // The place is given once, before the problem.
        let problem = message.rsplit_once(" at line ").map_or(message.as_str(), |(problem, _)| problem);
        FileError::syntax(FORMAT, format!("line {} column {}", e.line(), e.column()), problem)
    })?;
    if document.eikona != "curves" || document.version != 1 {
        return Err(FileError::Unsupported(format!(
            "this is {:?} version {}, but {{\"eikona\": \"curves\", \"version\": 1}} can be read; use a newer eikona or the \
             right file",
            document.eikona, document.version
        )));
    }
    let mut file = CurveFile::default();
    for (c, entry) in document.curves.into_iter().enumerate() {
        if entry.nodes.len() < 2 {
            let place = format!("curve {c}");
            let count = entry.nodes.len();
            let problem = format!(
                "{count} node(s), but a curve needs at least 2; put isolated points under \"points\""
            );
            return Err(FileError::syntax(FORMAT, place, problem));
        }
        for (n, node) in entry.nodes.iter().enumerate() {
            let path = [Step::Key("curves"), Step::Index(c), Step::Key("nodes"), Step::Index(n)];
            check(node, mesh, text, &path, || format!("curve {c}, node {n}"))?;
        }
        let nodes = entry.nodes.into_iter().map(|n| n.0).collect();
        file.curves.curves.push(Curve { kind: entry.kind, nodes, up: entry.up });
    }
    for (i, node) in document.points.iter().enumerate() {
        check(node, mesh, text, &[Step::Key("points"), Step::Index(i)], || format!("point {i}"))?;
        file.curves.points.push(node.0);
    }
    file.polylines = document.polylines;
    for (i, line) in file.polylines.iter_mut().enumerate() {
        line.drop_repeated_end();
        if line.points.len() < 2 {
            let problem =
                format!("{} different point(s), but a polyline needs at least 2", line.points.len());
            return Err(FileError::syntax(FORMAT, format!("polyline {i}"), problem));
        }
    }
    Ok(file)
}

fn check(
    node: &Node,
    mesh: &TriangleMesh,
    text: &str,
    path: &[Step],
    name: impl Fn() -> String,
) -> Result<(), FileError> {
    let fault = match node.0.locate(mesh) {
        Ok(_) => return Ok(()),
        Err(fault) => fault,
    };
    let place = match line_of_object(text, path) {
        Some(line) => format!("line {line} ({})", name()),
        None => name(),
    };
    let problem = format!("{fault}; correct it, or check that this is the mesh that the curve belongs to");
    Err(FileError::syntax(FORMAT, place, problem))
}

#[derive(Debug, PartialEq)]
enum Step<'a> {
    Key(&'a str),
    Index(usize),
}

/// Returns the line on which the object at this path begins, in well-formed JSON.
fn line_of_object(text: &str, path: &[Step]) -> Option<usize> {
    let mut here: Vec<Step> = Vec::new();
    let mut line = 1;
    let mut string_start = None;
    let mut escaped = false;
    let mut key_next = false;
    for (i, byte) in text.bytes().enumerate() {
        if let Some(start) = string_start {
            match byte {
                _ if escaped => escaped = false,
                b'\\' => escaped = true,
                b'"' => {
                    if key_next && let Some(Step::Key(key)) = here.last_mut() {
                        *key = text.get(start..i)?;
                        key_next = false;
                    }
                    string_start = None;
                }
                _ => {}
            }
            continue;
        }
        match byte {
            b'\n' => line += 1,
            b'"' => string_start = Some(i + 1),
            b'{' => {
                if here == path {
                    return Some(line);
                }
                here.push(Step::Key(""));
                key_next = true;
            }
            b'[' => here.push(Step::Index(0)),
            b'}' | b']' => {
                here.pop();
                key_next = false;
            }
            b',' => match here.last_mut()? {
                Step::Index(k) => *k += 1,
                Step::Key(_) => key_next = true,
            },
            _ => {}
        }
    }
    None
}

#[derive(Serialize)]
struct Written<'a> {
    eikona: &'static str,
    version: u32,
    curves: &'a [Curve],
    points: &'a [SurfacePoint],
    polylines: &'a [SpacePolyline],
}

pub(super) fn write(file: &CurveFile) -> Result<String, FileError> {
    let CurveFile { curves: SurfaceCurves { curves, points }, polylines, .. } = file;
    if curves.iter().filter_map(|c| c.up).flatten().any(|x| !x.is_finite()) {
        return Err(FileError::Unsupported("the normal `up` of a curve is not finite; correct it".into()));
    }
    let document = Written { eikona: "curves", version: 1, curves, points, polylines };
    let mut text = serde_json::to_string(&document)
        .map_err(|e| FileError::Unsupported(format!("the curves can not be written as JSON: {e}")))?;
    text.push('\n');
    Ok(text)
}
