//! `l` lines of OBJ files: curves through the vertices of the mesh, or polylines in space. The mesh
//! reader parses the file itself.

use super::{CurveFile, SpacePolyline, chain};
use crate::curve::{Curve, CurveKind, SurfaceCurves};
use crate::error::{CurveError, FileError};
use crate::id::Vertex;
use crate::io::{MeshFormat, read_mesh_bytes};
use crate::mesh::TriangleMesh;
use crate::point::SurfacePoint;
use crate::warning::FileWarning;

/// Converts the `l` lines (0-based vertices) of a mesh's own file to curves.
///
/// A line of three or more vertices is a curve. Lines of two vertices are joined where exactly two
/// of them meet, regardless of direction, since modelling programs write single edges in any
/// direction; the curve takes the direction of most of them. Lines of one vertex become points.
///
/// A curve through vertices used by faces is a curve on the mesh; where no edge joins them its
/// segments cross faces, which tracing resolves. A curve with an unreferenced vertex, as from a
/// separate object in the same file, is a polyline in space. Points at unreferenced vertices are
/// skipped with a warning.
///
/// # Errors
/// [`CurveError::VertexOutOfRange`] with the index of the line and the position in it.
pub fn curves_from_lines(lines: &[Vec<u32>], mesh: &TriangleMesh) -> Result<CurveFile, CurveError> {
    for (c, line) in lines.iter().enumerate() {
        for (n, &vertex) in line.iter().enumerate() {
            SurfacePoint::Vertex { vertex }.locate(mesh).map_err(|e| e.at(c, n))?;
        }
    }
    let is_on_mesh = |v: u32| !mesh.vertex_corners(Vertex(v)).is_empty();
    Ok(curve_file(lines, mesh.positions(), is_on_mesh))
}

/// Converts lines whose indices are in range. `is_on_mesh` tells whether a vertex belongs to the
/// mesh.
fn curve_file(lines: &[Vec<u32>], positions: &[[f64; 3]], is_on_mesh: impl Fn(u32) -> bool) -> CurveFile {
    let mut file = CurveFile::default();
    let (joined, points, reversed) = join_lines(lines, positions.len());
    if reversed > 0 {
        file.warnings.push(FileWarning::ReversedLines { count: reversed });
    }
    let (on_mesh, in_space): (Vec<_>, Vec<_>) =
        joined.into_iter().partition(|line| line.iter().all(|&v| is_on_mesh(v)));
    let (points, loose): (Vec<u32>, Vec<u32>) = points.into_iter().partition(|&v| is_on_mesh(v));
    file.curves = surface_curves(on_mesh, points);
    for line in in_space {
        let points = line.into_iter().map(|v| positions[v as usize]).collect();
        file.polylines.push(SpacePolyline::from_points(CurveKind::Signed, points));
    }
    if !loose.is_empty() {
        file.warnings.push(FileWarning::SkippedPoints { count: loose.len() });
    }
    file
}

fn surface_curves(lines: Vec<Vec<u32>>, points: Vec<u32>) -> SurfaceCurves {
    SurfaceCurves {
        curves: lines.into_iter().map(|l| Curve::signed(l.into_iter().map(Vertex))).collect(),
        points: points.into_iter().map(|vertex| SurfacePoint::Vertex { vertex }).collect(),
    }
}

/// Returns polylines (loose segments joined), single points, and the number of segments that were
/// reversed. Indices are in range.
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
    let mut reversed = 0;
    for chain in chain::unoriented(vertices, &loose) {
        reversed += chain.reversed;
        joined.push(chain.points.into_iter().map(|p| p as u32).collect());
    }
    (joined, points, reversed)
}

pub(super) fn read(text: &str, mesh: &TriangleMesh) -> Result<CurveFile, FileError> {
    if !text.lines().any(|line| line.split_whitespace().next() == Some("v")) {
        let warnings = vec![FileWarning::NoCurve { missing: "v" }];
        return Ok(CurveFile { warnings, ..CurveFile::default() });
    }
    let read = read_mesh_bytes(text.as_bytes(), MeshFormat::Obj)?;
    let positions = &read.mesh.positions;
    let lines: Vec<Vec<u32>> =
        read.lines.into_iter().chain(read.points.into_iter().map(|v| vec![v])).collect();
    if let Some(v) = lines.iter().flatten().find(|&&v| !positions[v as usize].iter().all(|x| x.is_finite())) {
        let problem = format!("vertex {} has a coordinate that is not finite; correct it", v + 1);
        return Err(FileError::syntax("OBJ", "v lines", problem));
    }
    let is_own = positions == mesh.positions();
    let is_on_mesh = |v: u32| is_own && !mesh.vertex_corners(Vertex(v)).is_empty();
    let mut file = curve_file(&lines, positions, is_on_mesh);
    if lines.is_empty() {
        file.warnings.push(FileWarning::NoCurve { missing: "l" });
    }
    Ok(file)
}

/// Formats positions and `l` lines. The kind of the curves is lost, and isolated points become `p`
/// lines.
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
