//! Lines of OBJ files: curves through the vertices of the mesh, or polylines in space.

use super::{CurveFile, Line, SpacePolyline, chain};
use crate::curve::{Curve, CurveKind, SurfaceCurves};
use crate::error::{CurveError, FileError};
use crate::id::Vertex;
use crate::mesh::TriangleMesh;
use crate::point::SurfacePoint;

const FORMAT: &str = "OBJ";

/// Oriented curves through vertices of the mesh, from the `l` lines (0-based) of its own file.
///
/// A line of three or more vertices is a curve. Lines of two vertices are joined where exactly two of them meet, whichever
/// way they run, since modelling programs write single edges in any direction; the curve runs the way most of them do.
/// Vertices that no edge joins make segments across faces, which tracing resolves. Lines of one vertex become points.
///
/// # Errors
/// [`CurveError::VertexOutOfRange`] with the index of the line and the place in it.
pub fn curves_from_lines(lines: &[Vec<u32>], mesh: &TriangleMesh) -> Result<SurfaceCurves, CurveError> {
    for (c, line) in lines.iter().enumerate() {
        for (n, &vertex) in line.iter().enumerate() {
            SurfacePoint::Vertex { vertex }.locate(mesh).map_err(|e| e.at(c, n))?;
        }
    }
    let (joined, points, _) = join_lines(lines, mesh.vertex_count());
    Ok(surface_curves(joined, points))
}

fn surface_curves(lines: Vec<Vec<u32>>, points: Vec<u32>) -> SurfaceCurves {
    SurfaceCurves {
        curves: lines.into_iter().map(|l| Curve::signed(l.into_iter().map(Vertex))).collect(),
        points: points.into_iter().map(|vertex| SurfacePoint::Vertex { vertex }).collect(),
    }
}

/// Polylines (loose segments joined), single points, and the number of segments that were turned. Indices are in range.
fn join_lines(lines: &[Vec<u32>], vertices: usize) -> (Vec<Vec<u32>>, Vec<u32>, usize) {
    let (mut joined, mut points, mut loose) = (Vec::new(), Vec::new(), Vec::new());
    for line in lines {
        let mut line = line.clone();
        line.dedup();
        match line[..] {
            [] => {}
            [a] => points.push(a),
            [a, b] => loose.push([a as usize, b as usize]),
            _ => joined.push(line),
        }
    }
    let mut turned = 0;
    for chain in chain::unoriented(vertices, &loose) {
        turned += chain.turned;
        joined.push(chain.points.into_iter().map(|p| p as u32).collect());
    }
    (joined, points, turned)
}

pub(super) fn read(text: &str, mesh: &TriangleMesh) -> Result<CurveFile, FileError> {
    let mut file = CurveFile::default();
    let mut positions: Vec<[f64; 3]> = Vec::new();
    let mut lines: Vec<Vec<u32>> = Vec::new();
    // Indices count from 1; negative ones count back from the vertices read so far.
    for (i, line) in text.lines().enumerate() {
        let line = Line { format: FORMAT, number: i + 1, words: line.split_whitespace().collect() };
        match line.words.first() {
            Some(&"v") => positions.push([
                line.number(1, "x coordinate")?,
                line.number(2, "y coordinate")?,
                line.number(3, "z coordinate")?,
            ]),
            Some(&"l") => {
                let indices = (1..line.words.len()).map(|k| vertex_index(&line, k, positions.len()));
                let indices = indices.collect::<Result<Vec<u32>, _>>()?;
                if indices.len() < 2 {
                    return Err(line.error("an l line needs 2 vertices or more"));
                }
                lines.push(indices);
            }
            Some(&"p") => {
                for k in 1..line.words.len() {
                    lines.push(vec![vertex_index(&line, k, positions.len())?]);
                }
            }
            _ => {}
        }
    }
    let (joined, points, turned) = join_lines(&lines, positions.len());
    if turned > 0 {
        file.warnings.push(format!(
            "{turned} two-vertex l lines ran against the others of their curve and were turned; check the direction"
        ));
    }
    if positions == mesh.positions() {
        file.curves = surface_curves(joined, points);
        return Ok(file);
    }
    for line in joined {
        let points = line.into_iter().filter_map(|v| positions.get(v as usize).copied()).collect();
        file.polylines.push(SpacePolyline::from_points(CurveKind::Signed, points));
    }
    if !points.is_empty() {
        file.warnings.push(format!(
            "{} single points in space were left out: give points on the mesh by vertex, edge or face",
            points.len()
        ));
    }
    if file.polylines.is_empty() {
        file.warnings.push("the file has no l lines, so there is no curve in it".into());
    }
    Ok(file)
}

fn vertex_index(line: &Line, place: usize, count: usize) -> Result<u32, FileError> {
    let word = line.word(place, "vertex index")?;
    let given: i64 = word
        .split('/')
        .next()
        .and_then(|w| w.parse().ok())
        .ok_or_else(|| line.error(format!("\"{word}\" is not a vertex index")))?;
    let index = if given < 0 { given.saturating_add(count as i64) } else { given - 1 };
    if (0..count as i64).contains(&index) {
        Ok(index as u32)
    } else {
        Err(line.error(format!(
            "vertex {given} does not exist: {count} vertices come before this line, numbered from 1; correct the index"
        )))
    }
}

/// Positions and `l` lines. The kind of the curves and the isolated points are not kept (points become `p` lines).
pub(super) fn write(file: &CurveFile, mesh: &TriangleMesh) -> Result<String, FileError> {
    let mut text = String::new();
    let mut count = 0;
    let mut push = |points: &[[f64; 3]], closed: bool| {
        for [x, y, z] in points {
            text += &format!("v {x} {y} {z}\n");
        }
        text.push_str(if points.len() == 1 { "p" } else { "l" });
        for k in (1..=points.len()).chain(closed.then_some(1)) {
            text += &format!(" {}", count + k);
        }
        text.push('\n');
        count += points.len();
    };
    for (c, curve) in file.curves.curves.iter().enumerate() {
        let mut points = Vec::with_capacity(curve.nodes.len());
        for (n, node) in curve.nodes.iter().enumerate() {
            points.push(node.locate(mesh).map_err(|e| e.at(c, n))?.position(mesh));
        }
        if curve.is_closed() {
            points.pop();
        }
        if points.len() > 1 {
            push(&points, curve.is_closed());
        }
    }
    for (i, point) in file.curves.points.iter().enumerate() {
        push(&[point.locate(mesh).map_err(|e| e.at_point(i))?.position(mesh)], false);
    }
    for line in file.polylines.iter().filter(|l| l.points.len() > 1) {
        push(&line.points, line.closed);
    }
    Ok(text)
}
