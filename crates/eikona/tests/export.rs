//! Exported curves: what is read back equals what was written.

mod shapes;
use eikona::contour::{obj_lines, plane_cut, ply_edges, polylines, svg_paths};
use eikona::curves::{DEFAULT_TOLERANCE, trace_polyline};
use eikona::spatial::Bvh;
use eikona_mesh::{Curve, CurveError, CurveFormat, CurveKind, Vertex, read_curves_bytes};
use shapes::{flat_grid, sphere};

#[test]
fn a_cut_written_as_obj_traces_back_to_itself() {
    let mesh = sphere(3);
    let curves = plane_cut(&mesh, [0.0, 0.0, 0.2], [0.1, 0.0, 1.0]).unwrap();
    let text = obj_lines(&polylines(&mesh, &curves).unwrap()).unwrap();
    let file = read_curves_bytes(text.as_bytes(), CurveFormat::Obj, &mesh).unwrap();
    assert_eq!((file.polylines.len(), file.polylines[0].closed), (1, true));
    let bvh = Bvh::new(&mesh);
    let traced =
        trace_polyline(&mesh, &bvh, &file.polylines[0].points, true, CurveKind::Signed, DEFAULT_TOLERANCE)
            .unwrap();
    assert!(traced.largest_projection_distance < 1e-15);
    assert_eq!(traced.curve.nodes.len(), curves[0].nodes.len());
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
fn a_node_off_the_mesh_is_reported_with_its_curve() {
    let mesh = flat_grid(4);
    let curves = [Curve::signed([0, 1].map(Vertex)), Curve::signed([0, 1, 99].map(Vertex))];
    let fault = polylines(&mesh, &curves).unwrap_err();
    assert!(matches!(fault, CurveError::AtNode { curve: 1, node: 2, .. }), "{fault}");
}
