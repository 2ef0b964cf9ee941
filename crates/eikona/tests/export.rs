//! Curves written for other programs come back as they were.

mod shapes;
use eikona::contour::{
    DEFAULT_TOLERANCE, obj_lines, plane_cut, ply_edges, polylines, svg_paths, trace_polyline, write_polylines,
};
use eikona::spatial::Bvh;
use eikona_mesh::{CurveFormat, CurveKind, SurfaceCurves, read_curves_bytes};
use shapes::{flat_grid, sphere};

#[test]
fn a_cut_written_as_obj_is_read_and_traced_to_itself() {
    let mesh = sphere(3);
    let curves = plane_cut(&mesh, [0.0, 0.0, 0.2], [0.1, 0.0, 1.0]).unwrap();
    let curves = SurfaceCurves { curves, points: Vec::new() };
    let text = obj_lines(&polylines(&mesh, &curves).unwrap()).unwrap();
    let file = read_curves_bytes(text.as_bytes(), CurveFormat::Obj, &mesh).unwrap();
    assert_eq!((file.polylines.len(), file.polylines[0].closed), (1, true));
    let bvh = Bvh::new(&mesh);
    let traced =
        trace_polyline(&mesh, &bvh, &file.polylines[0].points, true, CurveKind::Signed, DEFAULT_TOLERANCE)
            .unwrap();
    assert!(traced.largest_projection_distance < 1e-15);
    assert_eq!(traced.curve.nodes.len(), curves.curves[0].nodes.len());
}

#[test]
fn ply_counts_and_svg_flatness() {
    let triangle = vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 0.]];
    let line = vec![[0., 0., 0.], [0.5, 2., 0.]];
    let lines = [triangle, line];
    let ply = ply_edges(&lines).unwrap();
    assert!(ply.contains("element vertex 5\n") && ply.contains("element edge 4\n"));
    assert!(ply.ends_with("0 1\n1 2\n2 0\n3 4\n"));
    let svg = svg_paths(&lines).unwrap();
    assert!(svg.contains("<path d=\"M0 0 L1 0 L0 -1 Z\"/>") && svg.contains("<path d=\"M0 0 L0.5 -2\"/>"));
    assert!(svg_paths(&[vec![[0.0; 3], [1.0; 3]]]).unwrap_err().to_string().contains("z runs from 0 to 1"));
    assert!(obj_lines(&[vec![[0.0; 3], [f64::NAN; 3]]]).is_err());
    assert!(svg_paths(&[]).is_ok());
}

#[test]
fn files_are_written_whole() {
    let folder = std::env::temp_dir().join(format!("eikona-export-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let mesh = flat_grid(4);
    let cut = plane_cut(&mesh, [0.3, 0.0, 0.0], [1.0, 0.0, 0.0]).unwrap();
    let lines = polylines(&mesh, &SurfaceCurves { curves: cut, points: Vec::new() }).unwrap();
    for name in ["a.obj", "b.ply", "c.svg"] {
        write_polylines(folder.join(name), &lines).unwrap();
    }
    assert!(write_polylines(folder.join("d.xyz"), &lines).is_err());
    assert!(write_polylines(folder.join("nowhere/e.obj"), &lines).is_err());
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 3);
    std::fs::remove_dir_all(&folder).unwrap();
}
