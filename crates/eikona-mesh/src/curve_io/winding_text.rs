//! Curve files of SWN (surface winding numbers): a list of nodes and a list of oriented segments
//! between them.

use super::{CurveFile, Line, chain, node_line, refuse_polylines_and_normals};
use crate::curve::{Curve, CurveKind};
use crate::error::FileError;
use crate::mesh::TriangleMesh;
use crate::point::SurfacePoint;
use crate::warning::FileWarning;
use std::collections::BTreeMap;

const FORMAT: &str = "SWN curves";

pub(super) fn read(text: &str, mesh: &TriangleMesh) -> Result<CurveFile, FileError> {
    let mut file = CurveFile::default();
    let mut base = 1;
    let mut nodes = Vec::new();
    // Segments may refer to nodes later in the file, so they are resolved at the end.
    let mut segment_lines: Vec<(Line, i64)> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let line = Line::new(FORMAT, i, line);
        match line.words.first() {
            // "n" separates curves for a human reader; the segments define them anyway.
            None | Some(&"n") => {}
            Some(&"#offset") => {
                base = match line.integer(1, "offset (0 or -1)")? {
                    0 => 0,
                    -1 => 1,
                    other => {
                        return Err(line.error(format!(
                            "offset {other}; expected 0 (indices from 0) or -1 (indices from 1)"
                        )));
                    }
                };
            }
            Some(word) if word.starts_with('#') => {}
            Some(&"l") => segment_lines.push((line, base)),
            Some(&"c") => {
                return Err(
                    line.error("\"c\" is a chain of faces, not a curve; give the curve by nodes and l lines")
                );
            }
            Some(word) => match line.node(mesh, base)? {
                Some(node) => nodes.push(node),
                None => {
                    let problem = format!("unknown keyword \"{word}\"; expected v, e, f, l, n or #offset");
                    return Err(line.error(problem));
                }
            },
        }
    }
    let same_point = number_points(&nodes);
    let mut segments = Vec::new();
    for (line, base) in &segment_lines {
        let mut previous = None;
        for k in 1..line.words.len().max(3) {
            let given = line.integer(k, "node index")?;
            let place = given.checked_sub(*base).and_then(|i| usize::try_from(i).ok());
            let Some(&here) = place.and_then(|i| same_point.get(i)) else {
                return Err(line.error(format!(
                    "node {given} does not exist: the file has {}, numbered from {base}; correct the index or the #offset line",
                    nodes.len()
                )));
            };
            match previous {
                Some(p) if p == here => {
                    file.warnings.push(FileWarning::EmptySegment { line: line.number, node: given })
                }
                Some(p) => segments.push([p, here]),
                None => {}
            }
            previous = Some(here);
        }
    }
    for chain in chain::oriented(nodes.len(), &segments) {
        file.curves.curves.push(Curve::signed(chain.points.into_iter().map(|p| nodes[p])));
    }
    Ok(file)
}

/// Returns, for each node, the first one at the same point: many files repeat the node for each
/// segment.
fn number_points(nodes: &[SurfacePoint]) -> Vec<usize> {
    let mut first: BTreeMap<([u32; 3], [u64; 3]), usize> = BTreeMap::new();
    let key = |p: &SurfacePoint| match *p {
        SurfacePoint::Vertex { vertex } => ([vertex; 3], [0; 3]),
        SurfacePoint::Edge { vertices: [a, b], t } => ([a, b, a], [t.to_bits(), 0, 0]),
        SurfacePoint::Face { vertices, bary } => (vertices, bary.map(f64::to_bits)),
    };
    nodes.iter().enumerate().map(|(i, p)| *first.entry(key(p)).or_insert(i)).collect()
}

pub(super) fn write(file: &CurveFile, mesh: &TriangleMesh) -> Result<String, FileError> {
    refuse_polylines_and_normals(file, "SWN")?;
    if let Some(c) = file.curves.curves.iter().position(|c| c.kind == CurveKind::Unsigned) {
        return Err(FileError::Unsupported(format!(
            "SWN files can not hold curve {c}, which is unsigned; write JSON or the signed-heat-demo format"
        )));
    }
    if !file.curves.points.is_empty() {
        return Err(FileError::Unsupported(
            "SWN files can not hold isolated points; write JSON or the signed-heat-demo format".into(),
        ));
    }
    let mut text = String::from("#offset 0\n");
    let mut count = 0;
    for curve in &file.curves.curves {
        let closed = curve.is_closed();
        let own = &curve.nodes[..curve.nodes.len() - usize::from(closed)];
        text.extend(own.iter().filter_map(|n| node_line(n, mesh)));
        for k in 1..curve.nodes.len() {
            let end = if k == own.len() { 0 } else { k };
            text += &format!("l {} {}\n", count + k - 1, count + end);
        }
        count += own.len();
    }
    Ok(text)
}
