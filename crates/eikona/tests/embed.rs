//! Curves made edges of the mesh: the cut mesh is the same surface, and every curve walks its edges.

mod embedding;
mod shapes;
use eikona::contour::{
    DEFAULT_TOLERANCE, EmbedError, Embedded, SHORT, embed_curves, trace_curve, trace_polyline,
};
use eikona::spatial::Bvh;
use eikona_mesh::{
    Curve, CurveError, CurveKind, Face, Located, SurfaceCurves, SurfacePoint, Topology, TriangleMesh, Vertex,
    VertexField, io, read_curves,
};
use embedding::*;
use shapes::{DATA, Random, cube, flat_grid, moebius, rough_grid, sphere, torus};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

#[test]
fn nothing_to_cut_changes_nothing() {
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
    assert_eq!((of(0, 1), of(0, 2), of(1, 2)), (1, 1, 0), "edge 02 was first met as 20");
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
fn doubled_and_opposite_pieces_count() {
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
fn faces_with_the_same_corners_stay_apart() {
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
        Curve::signed([vertex(6), vertex(7)]),                // 1 edge: into 8
        Curve::signed([vertex(16), vertex(17), vertex(22)]),  // 2 edges: into 4 each
        Curve::signed([vertex(11), vertex(12), vertex(13)]),  // these
        Curve::unsigned([vertex(8), vertex(13), vertex(12)]), // are one piece of 3 edges: into 4 each
        Curve::signed((19..20).map(vertex).chain([24, 23, 18, 19].map(vertex))), // closed: stays
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
    // Inside faces too: the place of a vertex in the middle is found through both meshes.
    let curves = SurfaceCurves::from_curve(Curve::signed([
        inside([8, 9, 14], 0.2, 0.2),
        edge(8, 14, 0.5),
        inside([8, 14, 13], 0.1, 0.3),
    ]));
    let finer = embed_with("short inside", &mesh, &curves, 0.0).split_short().unwrap();
    check("short inside, finer", &mesh, &curves, &finer, 0.0);
    assert!(finer.curves[0].segments.len() >= SHORT);
}

#[test]
fn fields_go_back_to_the_input() {
    let mesh = square();
    let cut = embed("fields", &mesh, vec![Curve::signed([edge(0, 1, 0.5), edge(0, 2, 0.5)])]);
    let heights: Vec<f64> = cut.mesh.positions().iter().map(|p| p[0] + 2.0 * p[1]).collect();
    let back = cut.field_to_input_vertices(&VertexField::from(heights)).unwrap();
    assert_eq!(back.as_slice(), [0.0, 1.0, 3.0, 2.0]);
    // 1 on the small triangle that the curve cuts off, a quarter of its face.
    let near = |f: Face| cut.mesh.face_positions(f).iter().all(|p| p[0] <= 0.5);
    let lower = |f: Face| cut.face_parent[f.index()] == Face(0);
    let field: Vec<f64> = cut.mesh.faces().map(|f| if lower(f) && near(f) { 1.0 } else { 0.0 }).collect();
    let labels: Vec<i64> = field.iter().map(|&x| x as i64).collect();
    assert_eq!(cut.field_to_input_faces(&field.into()).unwrap().as_slice(), [0.25, 0.0]);
    assert_eq!(cut.labels_to_input_faces(&labels.into()).unwrap().as_slice(), [0, 0]);
    let wrong = cut.field_to_input_faces(&vec![1.0].into());
    assert!(matches!(wrong, Err(EmbedError::WrongLength { kind: "faces", found: 1, .. })));
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
    let on_edge = cut.vertex_place.iter().filter(|p| matches!(p, SurfacePoint::Edge { .. })).count();
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

/// A walk over a mesh with each step in one face: to inner points, to edges (often to the same places) and to vertices.
/// `jitter` moves some of them by as much.
fn random_walk(mesh: &TriangleMesh, random: &mut Random, steps: usize, jitter: f64) -> Curve {
    let mut here = Located::Vertex(Vertex((random.next() % mesh.vertex_count() as u64) as u32));
    if here.faces(mesh).is_empty() {
        here = Located::Vertex(mesh.face_vertices(Face(0))[0]);
    }
    let mut nodes = vec![here.to_surface_point(mesh)];
    while nodes.len() <= steps {
        let faces = here.faces(mesh);
        let face = faces[random.next() as usize % faces.len()];
        let corner = random.next() as usize % 3;
        let some = [0.5, 0.25, 1.0 / 3.0, random.unit(), random.unit()][random.next() as usize % 5];
        let mut w = [0.0; 3];
        match random.next() % 8 {
            0 => w[corner] = 1.0,
            1..4 => {
                w[corner] = some;
                w[(corner + 1) % 3] = 1.0 - some;
            }
            _ => {
                let other = [0.5, 0.25, random.unit()][random.next() as usize % 3];
                w[corner] = some;
                w[(corner + 1) % 3] = (1.0 - some) * other;
                w[(corner + 2) % 3] = (1.0 - some) * (1.0 - other);
            }
        }
        if jitter > 0.0 && random.next().is_multiple_of(2) {
            w[corner] = (w[corner] + jitter * random.unit()).abs();
        }
        let next = Located::in_face(mesh, face, w);
        // The point is named by vertices, so it has to be found in the first of doubled faces.
        if let Ok(place) = next.to_surface_point(mesh).locate(mesh)
            && eikona_mesh::segment_host(mesh, here, place).is_some()
        {
            nodes.push(place.to_surface_point(mesh));
            here = place;
        }
    }
    Curve::signed(nodes)
}

fn some_mesh(i: u64, seed: u64) -> (&'static str, TriangleMesh) {
    match i % 10 {
        0 => ("rough grid", rough_grid(3, seed)),
        1 => ("sphere", sphere(1)),
        2 => ("torus", torus(7, 5, 0.4)),
        3 => ("cube", cube(2)),
        4 => ("moebius", moebius(9, 2)),
        5 => ("book", book(2, 3)),
        6 => ("square", square()),
        7 => ("wound both ways", flat_square([[0, 1, 2], [0, 3, 2]])),
        8 => ("pillow", pillow()),
        _ => ("book of five", book(1, 5)),
    }
}

#[test]
fn random_walks_over_random_meshes() {
    let (mut faces, mut steps) = (0, 0);
    for seed in 0..200u64 {
        let mut random = Random(seed);
        let (name, mesh) = some_mesh(seed, seed);
        let count = 1 + random.next() as usize % 4;
        let curves: Vec<Curve> = (0..count)
            .map(|_| {
                let n = 3 + random.next() as usize % 20;
                random_walk(&mesh, &mut random, n, 0.0)
            })
            .collect();
        let name = format!("{name}, seed {seed}");
        let curves = SurfaceCurves { curves, points: Vec::new() };
        let cut = embed_with(&name, &mesh, &curves, 1e-15);
        faces += cut.mesh.face_count();
        steps += cut.curves.iter().map(|c| c.segments.len()).sum::<usize>();
        let finer = cut.split_short().unwrap();
        check(&format!("{name}, finer"), &mesh, &curves, &finer, 1e-15);
        // What is embedded already stays as it is.
        let again = embed_with("again", &cut.mesh, &cut.curves_on_mesh(), 0.0);
        assert_eq!(again.mesh.triangles(), cut.mesh.triangles(), "{name}");
    }
    println!("random walks: {faces} faces, {steps} steps");
}

#[test]
fn random_walks_with_near_misses() {
    let mut thinnest = f64::INFINITY;
    for seed in 0..200u64 {
        let mut random = Random(1000 + seed);
        let (name, mesh) = some_mesh(seed, seed);
        let jitter = [1e-15, 1e-12, 1e-10, 1e-9, 3e-9, 1e-8][seed as usize / 10 % 6];
        let curves: Vec<Curve> = (0..3).map(|_| random_walk(&mesh, &mut random, 20, jitter)).collect();
        let curves = SurfaceCurves { curves, points: Vec::new() };
        let cut = embed_with(&format!("{name}, seed {seed}, jitter {jitter}"), &mesh, &curves, 1e-8);
        thinnest = thinnest.min(lowest_height(&mesh, &cut));
    }
    println!("near misses: lowest height {thinnest:e} of a face of sides 1");
    assert!(thinnest > 1e-10, "{thinnest:e}");
}

/// The lowest height of a new face, in a parent of three sides of length 1.
fn lowest_height(mesh: &TriangleMesh, cut: &Embedded) -> f64 {
    let mut lowest = f64::INFINITY;
    for f in cut.mesh.faces() {
        let parent = cut.face_parent[f.index()];
        let weights = cut
            .mesh
            .face_vertices(f)
            .map(|v| cut.vertex_place[v.index()].locate(mesh).unwrap().weights_in_face(mesh, parent));
        // A place inside one of two faces with the same corners is found in the first.
        let [Some(a), Some(b), Some(c)] = weights else { continue };
        let flat = |w: Vec3| [w[1] + 0.5 * w[2], 0.75f64.sqrt() * w[2], 0.0];
        let p = [a, b, c].map(flat);
        let (u, v) = (sub(p[1], p[0]), sub(p[2], p[0]));
        let longest = (0..3).map(|k| norm(sub(p[k], p[(k + 1) % 3]))).fold(0.0, f64::max);
        lowest = lowest.min((u[0] * v[1] - u[1] * v[0]).abs() / longest);
    }
    lowest
}

#[test]
fn dust_is_embedded_wherever_it_lies() {
    let mesh = square();
    let mut thinnest = f64::INFINITY;
    for seed in 0..120u64 {
        let mut random = Random(seed);
        let size = [1e-12, 1e-9, 2e-9, 5e-9, 2e-8, 1e-7][seed as usize % 6];
        // Inside, at a side, at both ends of a side, at a corner.
        let around: &[[f64; 3]] = match seed / 6 % 4 {
            0 => &[[0.3, 0.3, 0.4]],
            1 => &[[0.0, 0.4, 0.6], [0.5, 0.0, 0.5]],
            2 => &[[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
            _ => &[[0.0, 1.0, 0.0], [0.1, 0.8, 0.1]],
        };
        let nodes = (0..60).map(|_| {
            let w = around[random.next() as usize % around.len()];
            let b = w[1] + size * (random.unit() - 0.5);
            let c = w[2] + size * (random.unit() - 0.5);
            let (b, c) = (b.clamp(0.0, 1.0), c.clamp(0.0, 1.0));
            Located::in_face(&mesh, Face(0), [(1.0 - b - c).max(0.0), b, c]).to_surface_point(&mesh)
        });
        let curves = SurfaceCurves::from_curve(Curve::signed(nodes));
        let cut = embed_with(&format!("dust, seed {seed}"), &mesh, &curves, 5e-9);
        thinnest = thinnest.min(lowest_height(&mesh, &cut));
    }
    // Three grains of dust may happen to lie on a line, so this is below the tolerance; but it is far above rounding.
    println!("dust: lowest height {thinnest:e} of a face of sides 1");
    assert!(thinnest > 1e-12, "{thinnest:e}");
}

#[test]
fn a_crossing_beside_an_edge_is_moved_onto_it() {
    let mesh = square();
    // Two curves rise from the diagonal by 8e-9 of their ways, against each other: they cross 4e-10 beside it.
    let face = [0, 1, 2];
    let curves = vec![
        Curve::signed([edge(0, 2, 0.2), inside(face, 2.4e-9, 0.5)]),
        Curve::signed([edge(0, 2, 0.3), inside(face, 2.0e-9, 0.05)]),
    ];
    let cut = embed_with("beside an edge", &mesh, &SurfaceCurves { curves, points: Vec::new() }, 2e-9);
    let shared: Vec<_> =
        cut.curves[0].vertices.iter().filter(|v| cut.curves[1].vertices.contains(v)).collect();
    assert!(shared.iter().any(|v| {
        matches!(cut.vertex_place[v.index()], SurfacePoint::Edge { t, .. } if (t - 0.25).abs() < 1e-2 || (t - 0.75).abs() < 1e-2)
    }));
    assert!(lowest_height(&mesh, &cut) > 1e-10);
    assert!(
        cut.face_parent.iter().filter(|f| f.0 == 1).count() == 4,
        "the other face at the edge has the points too"
    );
}

#[test]
fn random_polylines_traced_over_random_meshes() {
    let (mut run, mut faces) = (0, 0);
    for seed in 0..200u64 {
        let mut random = Random(2000 + seed);
        let (name, mesh) = match seed % 4 {
            0 => ("rough grid", rough_grid(9, seed)),
            1 => ("moebius", moebius(24, 4)),
            2 => ("book", book(5, 4)),
            _ => ("torus", torus(20, 12, 0.4)),
        };
        let bvh = Bvh::new(&mesh);
        let mut curves = Vec::new();
        for k in 0..3 {
            let points: Vec<Vec3> = (0..5).map(|_| random.point(-1.2, 1.2)).collect();
            if let Ok(t) = trace_polyline(&mesh, &bvh, &points, k == 0, CurveKind::Signed, DEFAULT_TOLERANCE)
            {
                curves.push(t.curve);
            }
        }
        run += curves.len();
        let cut = embed_with(
            &format!("{name}, seed {seed}"),
            &mesh,
            &SurfaceCurves { curves, points: Vec::new() },
            1e-15,
        );
        faces += cut.mesh.face_count();
    }
    println!("{run} traced polylines, {faces} faces");
}

#[test]
fn scale_place_and_winding_do_not_matter() {
    let mesh = rough_grid(4, 3);
    let mut random = Random(5);
    let curves: Vec<Curve> = (0..3).map(|_| random_walk(&mesh, &mut random, 25, 0.0)).collect();
    let cut = embed("as given", &mesh, curves.clone());
    for factor in [1e-100, 1e-8, 1e8, 1e100] {
        let scaled =
            mesh.with_positions(mesh.positions().iter().map(|p| p.map(|x| factor * x)).collect()).unwrap();
        let other =
            embed_curves(&scaled, &SurfaceCurves { curves: curves.clone(), points: Vec::new() }).unwrap();
        assert_eq!(other.mesh.triangles(), cut.mesh.triangles(), "{factor}");
    }
    let back = embed("reversed", &mesh, curves.iter().cloned().map(Curve::reversed).collect());
    assert_eq!(back.mesh.vertex_count(), cut.mesh.vertex_count());
    let turned = mesh.with_flipped_faces(|f| f.0 % 3 == 0);
    let other = embed("turned over", &turned, curves);
    assert_eq!(other.mesh.face_count(), cut.mesh.face_count());
    assert_eq!(other.mesh.vertex_count(), cut.mesh.vertex_count());
}

#[test]
fn degenerate_faces_are_cut() {
    // A face of height 0, one of height 1e-14, and one with two corners in one place.
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

#[test]
fn many_curves_over_many_faces() {
    for n in [100, 400] {
        let mesh = rough_grid(n, 1);
        let bvh = Bvh::new(&mesh);
        let line = |y: f64| [[0.0, y, 0.0], [0.3, 1.0 - y, 0.0], [1.0, y, 0.0]];
        let curves = (0..n / 8).map(|i| {
            let y = i as f64 / (n / 8) as f64;
            trace_polyline(&mesh, &bvh, &line(y), false, CurveKind::Signed, DEFAULT_TOLERANCE).unwrap().curve
        });
        let curves = SurfaceCurves { curves: curves.collect(), points: Vec::new() };
        let cut = embed_curves(&mesh, &curves).unwrap();
        check("many", &mesh, &curves, &cut, 1e-15);
    }
}

#[test]
fn ten_thousand_segments_in_one_face() {
    let mesh = square();
    let face = [0, 1, 2];
    let mut random = Random(11);
    let cut_along = |name: &str, curves: Vec<Curve>| {
        embed_with(name, &mesh, &SurfaceCurves { curves, points: Vec::new() }, 2e-9)
    };
    let spiral = (0..=10_000).map(|i| {
        let (a, r) = (0.05 * i as f64, 2e-5 * i as f64);
        inside(face, 0.4 + r * a.cos(), 0.3 + r * a.sin())
    });
    let cut = cut_along("spiral", vec![Curve::signed(spiral)]);
    assert!(cut.curves[0].segments.len() >= 10_000);
    let short = (0..10_000).map(|_| {
        let [x, y] = [0.05 + 0.6 * random.unit(), 0.05 + 0.2 * random.unit()];
        let [dx, dy] = [0, 1].map(|_| 0.02 * (random.unit() - 0.5));
        Curve::signed([inside(face, x, y), inside(face, x + dx, y + dy)])
    });
    cut_along("short ones", short.collect());
    let hub = (0..5_000).flat_map(|i| {
        let a = 0.001 * i as f64;
        [inside(face, 0.4, 0.3), inside(face, 0.4 + 0.2 * a.cos(), 0.3 + 0.2 * a.sin())]
    });
    cut_along("hub", vec![Curve::signed(hub)]);
    let long = (0..200).map(|_| {
        let [s, t] = [random.unit(), random.unit()];
        Curve::signed([edge(0, 1, s), edge(1, 2, t)])
    });
    cut_along("200 chords", long.collect());
    let collinear = (0..10_000).map(|_| {
        let s = 0.1 + 0.7 * random.unit();
        Curve::signed([inside(face, s, 0.1), inside(face, s + 0.01 * (random.unit() - 0.5), 0.1)])
    });
    cut_along("collinear", collinear.collect());
    let along = (0..10_000).map(|_| {
        let s = 0.1 + 0.7 * random.unit();
        Curve::signed([edge(0, 2, s), edge(0, 2, s + 0.01 * (random.unit() - 0.5))])
    });
    cut_along("along an edge", along.collect());
    let same = (0..10_000).map(|i| {
        let (a, b) = (inside(face, 0.2, 0.2), inside(face, 0.5, 0.3));
        Curve::signed(if i % 2 == 0 { [a, b] } else { [b, a] })
    });
    let cut = cut_along("one and the same", same.collect());
    assert!(cut.chain().edges.iter().all(|e| e.multiplicity == 0 && e.walks.len() == 10_000));
    // All nodes in a heap of 1e-12, each segment out of it and back.
    let heap = (0..2_000).map(|i| match i % 2 {
        0 => inside(face, 0.4 + 1e-12 * random.unit(), 0.3 + 1e-12 * random.unit()),
        _ => inside(face, 0.1 + 0.5 * random.unit(), 0.1 + 0.3 * random.unit()),
    });
    cut_along("heap", vec![Curve::signed(heap)]);
    // All nodes about as near to each other as the tolerance.
    for size in [1e-9, 3e-9, 1e-8] {
        let dust = (0..300).map(|_| inside(face, 0.4 + size * random.unit(), 0.3 + size * random.unit()));
        cut_along("dust", vec![Curve::signed(dust)]);
    }
}

fn host(name: &str) -> Option<&'static str> {
    Some(match name {
        "shm/block-points" => "badquality/block.obj",
        "shm/bumpy-sphere" => "curves/shm/bumpy-sphere.obj",
        "shm/cactus" => "curves/shm/cactus.obj",
        "shm/fish-unsigned" => "curves/shm/fish-unsigned.obj",
        "shm/hemisphere-point" => "boundary/hemisphere.obj",
        "shm/mobius-orientable-curve" => "nonorientable/mobius-orientable-curve.obj",
        "shm/polygon-bear" => "polygon/polygon-bear.obj",
        "shm/screwdriver" => "nonmanifold/screwdriver.obj",
        "swn/annulus" => "curves/swn/annulus.obj",
        "swn/asymmetric-torus" => "curves/swn/asymmetric-torus.obj",
        "swn/bunny-brokenheart" | "swn/bunny-heart" => "closed/bunny.obj",
        "swn/double-torus" => "closed/double-torus.obj",
        "swn/spots-on-spot" => "curves/swn/spots-on-spot.obj",
        "swn/torus-phi" => "curves/swn/torus.obj",
        _ => return None,
    })
}

#[test]
fn curves_of_the_data_folder() {
    let mut run = 0;
    let mut files: Vec<PathBuf> = Vec::new();
    for folder in ["curves/shm", "curves/swn"] {
        files.extend(
            std::fs::read_dir(Path::new(DATA).join(folder)).into_iter().flatten().flatten().map(|e| e.path()),
        );
    }
    files.sort();
    for path in files.iter().filter(|p| p.extension().is_some_and(|e| e == "txt")) {
        let name = path.strip_prefix(Path::new(DATA).join("curves")).unwrap().with_extension("");
        let name = name.to_string_lossy().replace('\\', "/");
        let Some(host) = host(&name) else { continue };
        let mesh = io::read_mesh(Path::new(DATA).join(host)).unwrap().mesh.triangulate().unwrap().0;
        let mut curves = read_curves(path, &mesh).unwrap().curves;
        for curve in &mut curves.curves {
            if SurfaceCurves::from_curve(curve.clone()).segments(&mesh).is_err() {
                *curve = trace_curve(&mesh, curve).unwrap().curve;
            }
        }
        let cut = embed_curves(&mesh, &curves).unwrap();
        check(&name, &mesh, &curves, &cut, 1e-15);
        let finer = cut.split_short().unwrap();
        check(&name, &mesh, &curves, &finer, 1e-15);
        println!(
            "{name}: {} curves, {} faces, cut {}, short pieces split {}",
            curves.curves.len(),
            mesh.face_count(),
            cut.mesh.face_count(),
            finer.mesh.face_count()
        );
        run += 1;
    }
    println!("curves embedded on {run} files");
}
