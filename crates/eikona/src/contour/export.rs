//! Exports curves to other programs: OBJ lines, PLY edges, and SVG for flat meshes.

use eikona_mesh::{Curve, CurveError, FileError, TriangleMesh};
use std::fmt::Write as _;

/// A polyline in space. A closed one repeats its first point at the end.
pub type Polyline = Vec<[f64; 3]>;

/// Flatness tolerance for SVG: the range of z as a share of the larger side in x or y.
pub const FLATNESS_TOLERANCE: f64 = 1e-9;

/// Returns the positions of the nodes of each curve in space.
///
/// # Errors
/// [`CurveError`], with the index of the curve, for a node that is not on the mesh.
pub fn polylines<'a>(
    mesh: &TriangleMesh,
    curves: impl IntoIterator<Item = &'a Curve>,
) -> Result<Vec<Polyline>, CurveError> {
    let points = |(c, curve): (usize, &Curve)| {
        let nodes = curve.nodes.iter().enumerate();
        nodes.map(|(n, p)| Ok(p.locate(mesh).map_err(|e| e.at(c, n))?.position(mesh))).collect()
    };
    curves.into_iter().enumerate().map(points).collect()
}

/// Writes an OBJ file with one `l` line per polyline.
///
/// # Errors
/// [`FileError::Unsupported`] for coordinates that are not finite.
pub fn obj_lines(lines: &[Polyline]) -> Result<String, FileError> {
    let mut text = String::new();
    let mut first = 1;
    for (points, closed) in checked(lines)? {
        for [x, y, z] in points {
            let _ = writeln!(text, "v {x} {y} {z}");
        }
        text.push('l');
        for k in (0..points.len()).chain(closed.then_some(0)) {
            let _ = write!(text, " {}", first + k);
        }
        text.push('\n');
        first += points.len();
    }
    Ok(text)
}

/// Writes an ASCII PLY file with one `edge` element per segment.
///
/// # Errors
/// [`FileError::Unsupported`] for coordinates that are not finite.
pub fn ply_edges(lines: &[Polyline]) -> Result<String, FileError> {
    let (mut vertices, mut edges) = (String::new(), String::new());
    let (mut first, mut count) = (0, 0);
    for (points, closed) in checked(lines)? {
        for [x, y, z] in points {
            let _ = writeln!(vertices, "{x} {y} {z}");
        }
        let segments = points.len() - usize::from(!closed);
        for k in 0..segments {
            let _ = writeln!(edges, "{} {}", first + k, first + (k + 1) % points.len());
        }
        first += points.len();
        count += segments;
    }
    Ok(format!(
        "ply\nformat ascii 1.0\nelement vertex {first}\nproperty double x\nproperty double y\nproperty double z\n\
         element edge {count}\nproperty int vertex1\nproperty int vertex2\nend_header\n{vertices}{edges}"
    ))
}

/// Writes an SVG file with one path per polyline, y upwards as on the mesh, lengths in the mesh's
/// own unit.
///
/// # Errors
/// [`FileError::Unsupported`] if the points do not all have the same z (up to
/// [`FLATNESS_TOLERANCE`]), or are not finite.
pub fn svg_paths(lines: &[Polyline]) -> Result<String, FileError> {
    let lines = checked(lines)?;
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in lines.iter().flat_map(|l| l.0) {
        for k in 0..3 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    if lines.is_empty() {
        (low, high) = ([0.0; 3], [1.0, 1.0, 0.0]);
    }
    let size = (high[0] - low[0]).max(high[1] - low[1]);
    if high[2] - low[2] > FLATNESS_TOLERANCE * size {
        return Err(FileError::Unsupported(format!(
            "SVG can hold flat curves only, but z runs from {} to {}; write OBJ or PLY, or project the curves",
            low[2], high[2]
        )));
    }
    let margin = 0.02 * size;
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{} {} {} {}\">\n\
         <g fill=\"none\" stroke=\"black\" stroke-width=\"{}\" stroke-linejoin=\"round\">\n",
        low[0] - margin,
        -high[1] - margin,
        high[0] - low[0] + 2.0 * margin,
        high[1] - low[1] + 2.0 * margin,
        0.003 * size
    );
    for (points, closed) in lines {
        text += "<path d=\"";
        for (k, [x, y, _]) in points.iter().enumerate() {
            // SVG has y pointing down. Subtracting from 0 avoids "-0".
            let _ = write!(text, "{}{x} {}", if k == 0 { "M" } else { " L" }, 0.0 - y);
        }
        text += if closed { " Z\"/>\n" } else { "\"/>\n" };
    }
    text += "</g>\n</svg>\n";
    Ok(text)
}

/// Returns the polylines of at least two points, without the repeated first point, and whether they
/// are closed.
fn checked(lines: &[Polyline]) -> Result<Vec<(&[[f64; 3]], bool)>, FileError> {
    let mut open = Vec::with_capacity(lines.len());
    for (i, line) in lines.iter().enumerate() {
        if let Some(k) = line.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
            return Err(FileError::Unsupported(format!(
                "polyline {i}, point {k} is at {:?}, which is not finite; correct or remove it",
                line[k]
            )));
        }
        let closed = line.len() > 2 && line.first() == line.last();
        if line.len() > 1 {
            open.push((&line[..line.len() - usize::from(closed)], closed));
        }
    }
    Ok(open)
}
