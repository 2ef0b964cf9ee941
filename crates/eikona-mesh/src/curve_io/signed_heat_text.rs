//! Curve files of signed-heat-demo: blocks of nodes under `signed_curve`, `unsigned_curve` or
//! `unsigned_point`.

use super::{CurveFile, Line, node_line, refuse_polylines_and_normals};
use crate::curve::{Curve, CurveKind};
use crate::error::FileError;
use crate::mesh::TriangleMesh;
use crate::point::SurfacePoint;
use crate::warning::FileWarning;

const FORMAT: &str = "signed-heat-demo curves";

/// The block that the lines after a keyword belong to.
enum Block {
    Curve { kind: CurveKind, reversed: bool, nodes: Vec<SurfacePoint>, line: usize },
    Points,
}

pub(super) fn read(text: &str, mesh: &TriangleMesh) -> Result<CurveFile, FileError> {
    let mut file = CurveFile::default();
    let mut block = None;
    for (i, line) in text.lines().enumerate() {
        let line = Line::new(FORMAT, i, line);
        let Some(&first) = line.words.first() else { continue };
        if first.starts_with('#') {
            continue;
        }
        let opened = match first {
            "signed_curve" | "unsigned_curve" => {
                line.at_most(2)?;
                let reversed = match line.words.get(1) {
                    None | Some(&"0") => false,
                    Some(&"1") => true,
                    Some(other) => {
                        let problem = format!("\"{other}\" after {first}; expected 1 (reverse) or 0");
                        return Err(line.error(problem));
                    }
                };
                let kind = if first == "signed_curve" { CurveKind::Signed } else { CurveKind::Unsigned };
                Some(Block::Curve { kind, reversed, nodes: Vec::new(), line: line.number })
            }
            "unsigned_point" => {
                line.at_most(1)?;
                Some(Block::Points)
            }
            _ => None,
        };
        if let Some(next) = opened {
            if let Some(done) = block.replace(next) {
                finish(done, &mut file);
            }
            continue;
        }
        let nodes = read_nodes(&line, mesh)?;
        match &mut block {
            Some(Block::Curve { nodes: all, .. }) => all.extend(nodes),
            Some(Block::Points) => file.curves.points.extend(nodes),
            None => {
                return Err(line.error(
                    "a node precedes the first block; begin with signed_curve, unsigned_curve or unsigned_point",
                ));
            }
        }
    }
    if let Some(done) = block {
        finish(done, &mut file);
    }
    Ok(file)
}

fn read_nodes(line: &Line, mesh: &TriangleMesh) -> Result<Vec<SurfacePoint>, FileError> {
    if line.words.first() == Some(&"l") {
        return (1..line.words.len())
            .map(|k| Ok(SurfacePoint::Vertex { vertex: line.element(k, "vertex", mesh.vertex_count(), 1)? }))
            .collect();
    }
    match line.node(mesh, 0)? {
        Some(node) => Ok(vec![node]),
        None => Err(line.error(format!(
            "unknown keyword \"{}\"; expected signed_curve, unsigned_curve, unsigned_point, v, e, f or l",
            line.words.first().unwrap_or(&"")
        ))),
    }
}

fn finish(block: Block, file: &mut CurveFile) {
    let Block::Curve { kind, reversed, nodes, line } = block else { return };
    if nodes.len() < 2 {
        file.warnings.push(FileWarning::ShortCurve { line, nodes: nodes.len() });
        return;
    }
    let curve = Curve { kind, nodes, up: None };
    file.curves.curves.push(if reversed { curve.reversed() } else { curve });
}

pub(super) fn write(file: &CurveFile, mesh: &TriangleMesh) -> Result<String, FileError> {
    refuse_polylines_and_normals(file, "signed-heat-demo")?;
    let mut text = String::new();
    for curve in &file.curves.curves {
        text += match curve.kind {
            CurveKind::Signed => "signed_curve 0\n",
            CurveKind::Unsigned => "unsigned_curve\n",
        };
        text.extend(curve.nodes.iter().filter_map(|n| node_line(n, mesh)));
    }
    for point in &file.curves.points {
        text += "unsigned_point\n";
        text.extend(node_line(point, mesh));
    }
    Ok(text)
}
