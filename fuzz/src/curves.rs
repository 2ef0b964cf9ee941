//! Bytes to curves on a small mesh, all operations on curves, and back to bytes.

use eikona::curves::{CurveReport, DEFAULT_TOLERANCE, straighten_curve, trace_curve, trace_polyline};
use eikona::spatial::Bvh;
use eikona_mesh::{
    Curve, CurveFile, CurveFormat, SurfaceCurves, TriangleMesh, curves_from_lines, format_curves,
    read_curves_bytes,
};
use std::hint::black_box;
use std::path::Path;
use std::sync::OnceLock;

const FORMATS: [CurveFormat; 4] =
    [CurveFormat::Json, CurveFormat::Obj, CurveFormat::SignedHeatDemo, CurveFormat::SurfaceWinding];

/// A bent sheet of 3 x 2 squares, a separate tetrahedron, an edge of three faces, and an unused
/// vertex.
pub fn mesh() -> &'static TriangleMesh {
    static MESH: OnceLock<TriangleMesh> = OnceLock::new();
    MESH.get_or_init(|| {
        let mut positions = Vec::new();
        let mut faces = Vec::new();
        for y in 0..3 {
            for x in 0..4 {
                positions.push([f64::from(x), f64::from(y), 0.3 * f64::from(x * y)]);
            }
        }
        for y in 0..2 {
            for x in 0..3 {
                let v = 4 * y + x;
                faces.push([v, v + 1, v + 5]);
                faces.push([v, v + 5, v + 4]);
            }
        }
        positions.extend([[9., 0., 0.], [10., 0., 0.], [9., 1., 0.], [9., 0., 1.]]);
        faces.extend([[12, 14, 13], [12, 13, 15], [13, 14, 15], [14, 12, 15]]);
        positions.extend([[1.5, 1., 2.], [-5., -5., -5.]]);
        faces.push([5, 6, 16]);
        TriangleMesh::new(positions, faces).expect("the mesh above is valid")
    })
}

/// Reads the bytes in every format; whatever can be read must survive all operations on it.
///
/// # Panics
/// If our own output cannot be read again, or a traced curve does not lie in the faces.
pub fn check(bytes: &[u8]) {
    black_box(CurveFormat::detect(Path::new("curve.txt"), bytes));
    for format in FORMATS {
        match read_curves_bytes(bytes, format, mesh()) {
            Ok(file) => check_file(&file),
            Err(fault) => assert!(!fault.to_string().is_empty()),
        }
    }
    if let Ok(file) = eikona_mesh::io::read_obj(bytes) {
        if let Ok(file) = curves_from_lines(&file.lines, mesh()) {
            check_file(&file);
        }
    }
}

fn check_file(file: &CurveFile) {
    for format in FORMATS {
        let Ok(text) = format_curves(file, format, mesh()) else { continue };
        let again = match read_curves_bytes(text.as_bytes(), format, mesh()) {
            Ok(again) => again,
            Err(fault) => panic!("our own {format:?} cannot be read: {fault}\n{text}"),
        };
        if format == CurveFormat::Json {
            assert_eq!((&again.curves, &again.polylines), (&file.curves, &file.polylines), "{text}");
        }
    }
    check_curves(&file.curves);
    let bvh = Bvh::new(mesh());
    for polyline in &file.polylines {
        if let Ok(traced) =
            trace_polyline(mesh(), &bvh, &polyline.points, polyline.closed, polyline.kind, DEFAULT_TOLERANCE)
        {
            black_box(traced.warnings());
            check_traced(traced.curve);
        }
    }
}

fn check_curves(curves: &SurfaceCurves) {
    black_box(curves.segments(mesh()).ok());
    if let Ok(report) = CurveReport::of(mesh(), curves) {
        black_box(report.warnings(curves));
        assert!(report.length().is_finite() && report.length() >= 0.0);
    }
    for curve in &curves.curves {
        if let Ok(traced) = trace_curve(mesh(), curve) {
            check_traced(traced.curve);
        }
    }
}

fn check_traced(curve: Curve) {
    let straight = straighten_curve(mesh(), &curve);
    let traced = SurfaceCurves::from_curve(curve);
    if let Err(fault) = traced.segments(mesh()) {
        panic!("a traced curve is refused: {fault}\n{traced:?}");
    }
    let _ = black_box(straight);
}
