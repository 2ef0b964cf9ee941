//! Cutting along curves: the cut mesh is the same surface, and every curve runs along its edges.

mod embedding;
mod shapes;
use eikona::cut::{EmbedError, SHORT_PIECE_EDGES, embed_curves};
use eikona_mesh::{
    Curve, CurveError, CurveKind, Face, MeshError, SurfaceCurves, SurfacePoint, Topology, TriangleMesh,
    Vertex, VertexField,
};
use embedding::*;
use shapes::flat_grid;
use std::collections::BTreeSet;

fn vertex(vertex: u32) -> SurfacePoint {
    SurfacePoint::Vertex { vertex }
}

#[test]
fn curves_along_edges_leave_the_mesh_unchanged() {
    let mesh = square();
    let cut = embed("none", &mesh, Vec::new());
    assert_eq!(cut.mesh.triangles(), mesh.triangles());
    let cut = embed("along an edge", &mesh, vec![Curve::signed([vertex(2), vertex(0), vertex(1)])]);
    assert_eq!(cut.mesh.triangles(), mesh.triangles());
    assert_eq!(
        (cut.curves[0].vertices.as_slice(), cut.curves[0].segments.as_slice()),
        (&[2, 0, 1].map(Vertex)[..], &[0, 1][..])
    );
    let multiplicities = cut.chain().multiplicities;
    let of = |a, b| multiplicities[mesh.find_edge(Vertex(a), Vertex(b)).unwrap()];
    assert_eq!((of(0, 1), of(0, 2), of(1, 2)), (1, 1, 0), "edge 02 is first met as 20");
}

#[test]
fn crossing_curves_share_a_vertex() {
    let mesh = square();
    let across = Curve::signed([edge(0, 1, 0.25), inside([0, 1, 2], 0.6, 0.3), edge(1, 2, 0.5)]);
    let other = Curve::signed([vertex(1), edge(0, 2, 0.5), vertex(3)]);
    let third = Curve::unsigned([edge(1, 2, 0.25), edge(0, 2, 0.25), edge(3, 0, 0.75)]);
    let cut = embed("crossing", &mesh, vec![across, other, third]);
    let on = |c: usize| cut.curves[c].vertices.iter().copied().collect::<BTreeSet<_>>();
    for (a, b) in [(0, 1), (0, 2), (1, 2)] {
        assert_eq!(on(a).intersection(&on(b)).count(), 1, "{a} {b}");
    }
    assert_eq!(cut.curves[2].kind, CurveKind::Unsigned);
    assert_eq!(
        cut.chain_of(|c| c.kind == CurveKind::Signed).edges.iter().map(|e| e.walks.len()).sum::<usize>(),
        8
    );
}

#[test]
fn three_curves_through_one_point_share_one_vertex() {
    let mesh = square();
    let through = |a: f64| {
        let (x, y) = (0.07 * a.cos(), 0.07 * a.sin());
        Curve::signed([inside([0, 1, 2], 0.4 + x, 0.3 + y), inside([0, 1, 2], 0.4 - x, 0.3 - y)])
    };
    let cut = embed("star", &mesh, (0..30).map(|i| through(0.1 * i as f64)).collect());
    assert_eq!(cut.mesh.vertex_count(), 4 + 60 + 1);
    assert!(cut.curves.iter().all(|c| c.vertices.len() == 3));
}

#[test]
fn multiplicities_of_doubled_and_opposite_pieces_add_up() {
    let mesh = square();
    let point = |x: f64| inside([0, 1, 2], x, 0.2);
    let curves = vec![
        Curve::signed([point(0.3), point(0.7)]),
        Curve::signed([point(0.5), point(0.6)]),
        Curve::signed([point(0.6), point(0.4)]),
        Curve::signed([edge(0, 2, 0.1), edge(0, 2, 0.7)]),
        Curve::signed([edge(2, 0, 0.5), vertex(0)]),
        Curve::signed([edge(0, 2, 0.3), edge(0, 2, 0.2)]),
    ];
    let cut = embed("doubled", &mesh, curves);
    let chain = cut.chain();
    // Along the first line: 0.3 to 0.4 to 0.5 to 0.6 to 0.7.
    let along = |c: usize| {
        let steps = cut.curves[c].vertices.windows(2);
        steps
            .map(|v| {
                let e = cut.mesh.find_edge(v[0], v[1]).unwrap();
                let sign = if cut.mesh.edge_vertices(e)[0] == v[0] { 1 } else { -1 };
                sign * chain.multiplicities[e]
            })
            .collect::<Vec<_>>()
    };
    assert_eq!(along(0), [1, 0, 1, 1]);
    assert_eq!(along(3), [0, -1, 0, 1], "0.1 to 0.2 to 0.3 to 0.5 to 0.7");
    let cancelled = chain.edges.iter().filter(|e| e.multiplicity == 0).count();
    assert_eq!(cancelled, 3);
    assert_eq!(chain.edges.iter().map(|e| e.walks.len()).max(), Some(3));
}

#[test]
fn zero_length_and_isolated_points() {
    let mesh = square();
    let here = inside([0, 2, 3], 0.25, 0.25);
    let curves = vec![
        Curve::signed([here, here, vertex(2), vertex(2), here]),
        Curve::signed([here, here]),
        Curve::signed([vertex(1), vertex(1), vertex(1)]),
    ];
    let points = vec![vertex(3), edge(0, 1, 0.5), here, inside([0, 1, 2], 0.3, 0.3)];
    let cut = embed_with("zero", &mesh, &SurfaceCurves { curves, points }, 0.0);
    assert_eq!(cut.curves[0].segments, [1, 3]);
    assert_eq!((cut.curves[1].vertices.len(), cut.curves[2].vertices.as_slice()), (1, &[Vertex(1)][..]));
    assert_eq!(cut.points[0], Vertex(3));
    assert_eq!(cut.points[2], cut.curves[1].vertices[0]);
    assert_eq!(cut.mesh.vertex_count(), 7);
}

#[test]
fn faces_with_the_same_corners_stay_distinct() {
    let mesh = pillow();
    let around = Curve::signed([edge(0, 1, 0.5), edge(1, 2, 0.5), edge(2, 0, 0.5), edge(0, 1, 0.5)]);
    let cut = embed("pillow", &mesh, vec![around, Curve::signed([vertex(0), edge(1, 2, 0.25)])]);
    assert!(Topology::of(&cut.mesh).is_manifold());
    let cut = embed("pillow, along a side", &mesh, vec![Curve::signed([vertex(0), vertex(1)])]);
    let finer = cut.split_short().unwrap();
    assert_eq!(finer.curves[0].segments, [0; 8]);
    check(
        "pillow, finer",
        &mesh,
        &SurfaceCurves::from_curve(Curve::signed([vertex(0), vertex(1)])),
        &finer,
        0.0,
    );
    // The same face three times.
    let mesh = TriangleMesh::new(mesh.positions().to_vec(), vec![[0, 1, 2]; 3]).unwrap();
    embed(
        "triple",
        &mesh,
        vec![Curve::signed([edge(0, 1, 0.5), inside([0, 1, 2], 0.2, 0.7), edge(1, 2, 0.5)])],
    );
}

#[test]
fn short_pieces_get_eight_edges() {
    let mesh = flat_grid(4);
    let curves = vec![
        Curve::signed([vertex(6), vertex(7)]),               // 1 edge: into 8
        Curve::signed([vertex(16), vertex(17), vertex(22)]), // 2 edges: split into 4 each
        // The next two form one piece of 3 edges: split into 4 each.
        Curve::signed([vertex(11), vertex(12), vertex(13)]),
        Curve::unsigned([vertex(8), vertex(13), vertex(12)]),
        Curve::signed((19..20).map(vertex).chain([24, 23, 18, 19].map(vertex))), // closed: kept
    ];
    let curves = SurfaceCurves { curves, points: vec![inside([8, 9, 14], 0.2, 0.2)] };
    let cut = embed_with("short", &mesh, &curves, 0.0);
    let finer = cut.split_short().unwrap();
    check("short, finer", &mesh, &curves, &finer, 0.0);
    let edges: Vec<usize> = finer.curves.iter().map(|c| c.segments.len()).collect();
    assert_eq!(edges, [8, 8, 8, 8, 4]);
    assert_eq!(finer.curves[1].segments, [0, 0, 0, 0, 1, 1, 1, 1]);
    assert_eq!(finer.points, cut.points);
    let again = finer.split_short().unwrap();
    assert_eq!(again.mesh.face_count(), finer.mesh.face_count());
    // Also inside faces: the place of a midpoint is found through both meshes.
    let curves = SurfaceCurves::from_curve(Curve::signed([
        inside([8, 9, 14], 0.2, 0.2),
        edge(8, 14, 0.5),
        inside([8, 14, 13], 0.1, 0.3),
    ]));
    let finer = embed_with("short inside", &mesh, &curves, 0.0).split_short().unwrap();
    check("short inside, finer", &mesh, &curves, &finer, 0.0);
    assert!(finer.curves[0].segments.len() >= SHORT_PIECE_EDGES);
}

#[test]
fn fields_transfer_back_to_the_input() {
    let mesh = square();
    let cut = embed("fields", &mesh, vec![Curve::signed([edge(0, 1, 0.5), edge(0, 2, 0.5)])]);
    let heights: Vec<f64> = cut.mesh.positions().iter().map(|p| p[0] + 2.0 * p[1]).collect();
    let back = cut.field_to_input_vertices(&VertexField::from(heights)).unwrap();
    assert_eq!(back.as_slice(), [0.0, 1.0, 3.0, 2.0]);
    // 1 on the small triangle that the curve cuts off, a quarter of its face.
    let near = |f: Face| cut.mesh.face_positions(f).iter().all(|p| p[0] <= 0.5);
    let lower = |f: Face| cut.provenance.face_parent(f) == Face(0);
    let field: Vec<f64> = cut.mesh.faces().map(|f| if lower(f) && near(f) { 1.0 } else { 0.0 }).collect();
    let labels: Vec<i64> = field.iter().map(|&x| x as i64).collect();
    assert_eq!(cut.field_to_input_faces(&field.into()).unwrap().as_slice(), [0.25, 0.0]);
    assert_eq!(cut.labels_to_input_faces(&labels.into()).unwrap().as_slice(), [0, 0]);
    let wrong = cut.field_to_input_faces(&vec![1.0].into());
    assert!(matches!(wrong, Err(MeshError::WrongLength { what: "face values", found: 1, .. })));
}

#[test]
fn many_crossings_beside_an_edge_are_moved_onto_it() {
    let mesh = square();
    let face = [0, 1, 2];
    let pair = |k: i32| {
        let at = |x: f64| 0.05 + 0.008 * f64::from(k) + x / 60.0;
        [
            Curve::signed([edge(0, 2, at(0.2)), inside(face, 2.4e-9, at(0.5))]),
            Curve::signed([edge(0, 2, at(0.3)), inside(face, 2.0e-9, at(0.05))]),
        ]
    };
    let curves = SurfaceCurves { curves: (0..100).flat_map(pair).collect(), points: Vec::new() };
    let cut = embed_with("many beside an edge", &mesh, &curves, 2e-9);
    for pair in cut.curves.chunks(2) {
        assert!(pair[0].vertices.iter().any(|v| pair[1].vertices.contains(v)));
    }
    let places = cut.mesh.vertices().map(|v| cut.provenance.vertex_place(v));
    let on_edge = places.filter(|p| matches!(p, Some(SurfacePoint::Edge { .. }))).count();
    assert_eq!(on_edge, 300);
}

#[test]
fn faults_name_curve_and_node() {
    let mesh = flat_grid(4);
    let fault = |nodes: Vec<SurfacePoint>| {
        let curves = vec![Curve::signed([vertex(0), vertex(1)]), Curve::signed(nodes)];
        embed_curves(&mesh, &SurfaceCurves { curves, points: Vec::new() }).unwrap_err().to_string()
    };
    let at = "curve 1, node 1: ";
    let nan = SurfacePoint::Face { vertices: [0, 1, 6], bary: [f64::NAN, 0.5, 0.5] };
    assert!(fault(vec![vertex(0), nan]).starts_with(at));
    assert!(fault(vec![vertex(0), edge(0, 1, f64::NAN)]).starts_with(at));
    assert!(fault(vec![vertex(0), edge(0, 1, 1.1)]).starts_with(at));
    assert!(fault(vec![vertex(0), edge(0, 2, 0.5)]).starts_with(at));
    assert!(fault(vec![vertex(0), inside([0, 1, 6], 2.0, -1.0)]).starts_with(at));
    assert!(fault(vec![vertex(0), inside([0, 1, 7], 0.2, 0.2)]).starts_with(at));
    assert!(fault(vec![vertex(0), vertex(999)]).starts_with(at));
    let across = fault(vec![vertex(0), vertex(1), vertex(24)]);
    assert!(across.starts_with(at) && across.contains("trace"), "{across}");
    assert!(fault(vec![vertex(0)]).starts_with("curve 1 has 1 node"));
    assert!(fault(vec![]).starts_with("curve 1 has 0 node"));
    let points = SurfaceCurves { curves: Vec::new(), points: vec![vertex(0), vertex(99)] };
    let error = embed_curves(&mesh, &points).unwrap_err();
    assert!(matches!(error, EmbedError::Curve(CurveError::AtPoint { point: 1, .. })));
    let empty = TriangleMesh::new(Vec::new(), Vec::new()).unwrap();
    assert_eq!(embed_curves(&empty, &SurfaceCurves::default()).unwrap().mesh.face_count(), 0);
}

#[test]
fn a_crossing_beside_an_edge_is_moved_onto_it() {
    let mesh = square();
    // Two curves rise from the diagonal by 8e-9 of their length in opposite directions: they cross
    // 4e-10 beside it.
    let face = [0, 1, 2];
    let curves = vec![
        Curve::signed([edge(0, 2, 0.2), inside(face, 2.4e-9, 0.5)]),
        Curve::signed([edge(0, 2, 0.3), inside(face, 2.0e-9, 0.05)]),
    ];
    let cut = embed_with("beside an edge", &mesh, &SurfaceCurves { curves, points: Vec::new() }, 2e-9);
    let shared: Vec<_> =
        cut.curves[0].vertices.iter().filter(|v| cut.curves[1].vertices.contains(v)).collect();
    assert!(shared.iter().any(|v| {
        matches!(cut.provenance.vertex_place(**v), Some(SurfacePoint::Edge { t, .. }) if (t - 0.25).abs() < 1e-2 || (t - 0.75).abs() < 1e-2)
    }));
    assert!(lowest_height(&mesh, &cut) > 1e-10);
    assert!(cut.provenance.face_parts(Face(1)).len() == 4, "the other face at the edge has the points, too");
}

#[test]
fn degenerate_faces_are_cut() {
    // A face of height 0, one of height 1e-14, and one with two coinciding corners.
    for corner in [[0.5, 0.0, 0.0], [0.3, 1e-14, 0.0], [0.0, 0.0, 0.0]] {
        let corners = vec![[0., 0., 0.], [1., 0., 0.], corner, [0.5, -1., 0.]];
        let mesh = TriangleMesh::new(corners, vec![[0, 1, 2], [1, 0, 3]]).unwrap();
        let curves = vec![
            Curve::signed([edge(0, 2, 0.5), edge(0, 1, 0.5), vertex(3)]),
            Curve::signed([vertex(2), inside([0, 1, 2], 0.3, 0.3), edge(0, 1, 0.25), edge(1, 3, 0.5)]),
        ];
        embed("degenerate", &mesh, curves);
    }
}
