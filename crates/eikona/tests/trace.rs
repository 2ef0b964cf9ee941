//! Tracing: every segment of every result lies in one face, and known lengths are reproduced.

mod shapes;
use eikona::contour::polylines;
use eikona::curves::{
    DEFAULT_TOLERANCE, TraceError, Traced, shortest_vertex_path, trace_curve, trace_polyline,
};
use eikona::spatial::Bvh;
use eikona_mesh::{Curve, CurveKind, SurfaceCurves, SurfacePoint, TriangleMesh, Vertex};
use shapes::{DATA, Random, cube, flat_grid, read_mesh, rough_grid, sphere, torus};
use std::f64::consts::TAU;

fn length(mesh: &TriangleMesh, curve: &Curve) -> f64 {
    let points = polylines(mesh, [curve]).unwrap().remove(0);
    points.windows(2).map(|p| (0..3).map(|k| (p[0][k] - p[1][k]).powi(2)).sum::<f64>().sqrt()).sum()
}

fn trace(mesh: &TriangleMesh, points: &[[f64; 3]], closed: bool) -> Traced {
    let bvh = Bvh::new(mesh);
    let traced = trace_polyline(mesh, &bvh, points, closed, CurveKind::Signed, DEFAULT_TOLERANCE).unwrap();
    check(mesh, &traced);
    assert_eq!(traced.curve.is_closed(), closed);
    traced
}

/// Checks that each segment lies in one face and that none is so short that it is an artefact.
fn check(mesh: &TriangleMesh, traced: &Traced) {
    let segments = SurfaceCurves::from_curve(traced.curve.clone()).segments(mesh).unwrap();
    assert_eq!(segments.len(), traced.curve.nodes.len() - 1, "no segment of length zero");
    assert_eq!(traced.parents.len(), traced.curve.nodes.len());
}

#[test]
fn a_line_on_a_flat_grid_keeps_its_length() {
    let mesh = flat_grid(37);
    for (a, b) in [
        ([0.013, 0.027, 0.0], [0.971, 0.883, 0.0]),
        ([0.0, 0.0, 0.0], [1.0, 1.0, 0.0]), // along diagonals
        ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0]), // along the boundary
        ([0.2, 0.0, 0.0], [0.2, 1.0, 0.0]),
        ([10.0 / 37.0, 0.0, 0.0], [10.0 / 37.0, 1.0, 0.0]), // along edges
        ([0.0, 1.0, 0.0], [1.0, 0.0, 0.0]),                 // through vertices and across diagonals
        ([0.9, 0.1, 0.0], [0.05, 0.12, 0.0]),
    ] {
        let traced = trace(&mesh, &[a, b], false);
        let exact = ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)).sqrt();
        assert!((length(&mesh, &traced.curve) - exact).abs() < 1e-11, "{a:?} {b:?}");
        assert!(traced.subdivided.is_empty() && traced.replaced.is_empty());
    }
    let along = trace(&mesh, &[[0.0, 0.0, 1.0], [1.0, 0.0, 1.0]], false);
    assert_eq!(along.curve.nodes.len(), 38);
    assert!((along.largest_projection_distance - 1.0).abs() < 1e-15);
}

#[test]
fn a_latitude_circle_converges_to_its_length() {
    let z: f64 = 0.3;
    let r = (1.0 - z * z).sqrt();
    let errors: Vec<f64> = [2, 3, 4, 5]
        .map(|level| {
            let mesh = sphere(level);
            let n = 20 << level;
            let circle: Vec<_> = (0..n)
                .map(|i| {
                    let a = TAU * i as f64 / n as f64;
                    [r * a.cos(), r * a.sin(), z]
                })
                .collect();
            let traced = trace(&mesh, &circle, true);
            assert!(traced.replaced.is_empty());
            (length(&mesh, &traced.curve) - TAU * r).abs()
        })
        .into();
    println!("length errors of the circle: {errors:?}");
    for pair in errors.windows(2) {
        assert!(pair[1] < 0.4 * pair[0], "second order: {errors:?}");
    }
}

#[test]
fn long_segments_follow_curved_and_folded_surfaces() {
    // A square of four chords through the inside of a sphere.
    let mesh = sphere(4);
    let square = [[1., 0.1, 0.], [0., 1., 0.1], [-1., 0., 0.2], [0.1, -1., 0.]];
    let traced = trace(&mesh, &square, true);
    let around = length(&mesh, &traced.curve);
    assert!(around > 0.99 * TAU && around < 1.1 * TAU, "{around}");
    // From the centre of one side of a cube to that of the next: 1 is the shortest path.
    let mesh = cube(7);
    let traced = trace(&mesh, &[[0.4, 0.45, 1.0], [1.0, 0.45, 0.4]], false);
    assert!((length(&mesh, &traced.curve) - 1.2).abs() < 1e-9);
    // Through the cube to the opposite side.
    let traced = trace(&mesh, &[[0.4, 0.5, 1.0], [0.4, 0.5, 0.0]], false);
    let exact = 1.8;
    let found = length(&mesh, &traced.curve);
    assert!(found >= exact - 1e-9 && found < 1.02 * exact, "{found}");
}

#[test]
fn the_shortest_path_replaces_a_walk_around_a_hole() {
    // A thin plate with two sides: the nearest path leads over the rim.
    let mesh = shapes::grid(20, |x, y| [x, y, 0.0]);
    let keep: Vec<[u32; 3]> = mesh
        .faces()
        .filter(|&f| {
            let p = mesh.face_positions(f);
            let c = [0, 1].map(|k| (p[0][k] + p[1][k] + p[2][k]) / 3.0);
            !((c[0] - 0.5).abs() < 0.2 && (c[1] - 0.5).abs() < 0.2)
        })
        .map(|f| mesh.triangles()[f.index()])
        .collect();
    let mesh = TriangleMesh::new(mesh.positions().to_vec(), keep).unwrap();
    let traced = trace(&mesh, &[[0.1, 0.5, 0.0], [0.9, 0.5, 0.0]], false);
    // The hole is equally wide on both sides of the line.
    assert_eq!((traced.replaced.len(), traced.ambiguous.len(), traced.warnings().len()), (1, 1, 2));
    let exact = 2.0 * (0.2f64.powi(2) + 0.2f64.powi(2)).sqrt() + 0.4;
    let found = length(&mesh, &traced.curve);
    println!("round a hole: {found}, shortest {exact}");
    assert!(found >= exact - 1e-9 && found < 1.35 * exact);
}

#[test]
fn random_polylines_on_rough_surfaces() {
    let (mut walked, mut halved, mut replaced) = (0, 0, 0);
    for seed in 0..40 {
        let mut random = Random(seed);
        let mesh = match seed % 4 {
            0 => rough_grid(15, seed),
            1 => sphere(2),
            2 => torus(24, 12, 0.4),
            _ => cube(3),
        };
        let mut points: Vec<[f64; 3]> = (0..8).map(|_| random.point(-1.2, 1.2)).collect();
        points.push(mesh.positions()[random.next() as usize % mesh.vertex_count()]);
        let closed = seed % 3 == 0;
        let traced = trace(&mesh, &points, closed);
        walked += traced.curve.nodes.len();
        halved += traced.subdivided.len();
        replaced += traced.replaced.len();
        // A traced curve stays as it is.
        let again = trace_curve(&mesh, &traced.curve).unwrap();
        assert_eq!(again.curve.nodes.len(), traced.curve.nodes.len());
        let both = polylines(&mesh, [&again.curve, &traced.curve]).unwrap();
        assert!(both[0].iter().zip(&both[1]).all(|(p, q)| (0..3).all(|k| (p[k] - q[k]).abs() < 1e-14)));
    }
    println!("random polylines: {walked} nodes, {halved} segments halved, {replaced} by edge path");
}

#[test]
fn scale_and_place_change_nothing() {
    let mesh = rough_grid(12, 7);
    let line = [[0.05, 0.1, 0.3], [0.8, 0.35, 0.0], [0.4, 0.9, 0.1]];
    let nodes = trace(&mesh, &line, true).curve.nodes.len();
    for (factor, shift) in [(1e-8, 0.0), (1e8, 0.0), (1.0, 100.0)] {
        let place = |p: [f64; 3]| p.map(|x| factor * x + shift);
        let moved = mesh.with_positions(mesh.positions().iter().map(|&p| place(p)).collect()).unwrap();
        let traced = trace(&moved, &line.map(place), true);
        assert_eq!(traced.curve.nodes.len(), nodes);
    }
}

#[test]
fn a_curve_of_distant_vertices_is_traced() {
    let mesh = flat_grid(10);
    let curve = Curve::unsigned([Vertex(0), Vertex(120), Vertex(10)]);
    let traced = trace_curve(&mesh, &curve).unwrap();
    check(&mesh, &traced);
    assert_eq!(traced.curve.kind, CurveKind::Unsigned);
    assert!((length(&mesh, &traced.curve) - (1.0 + 2f64.sqrt())).abs() < 1e-12);
}

#[test]
fn invalid_input_is_refused_with_a_reason() {
    let mesh = flat_grid(2);
    let bvh = Bvh::new(&mesh);
    let run = |points: &[[f64; 3]], tolerance| {
        trace_polyline(&mesh, &bvh, points, false, CurveKind::Signed, tolerance).unwrap_err()
    };
    let origin = [0.0; 3];
    assert!(matches!(run(&[origin, [f64::NAN; 3]], 1e-6), TraceError::NonFinitePoint { node: 1, .. }));
    assert!(matches!(run(&[origin, [0.0, 0.0, 5.0]], 1e-6), TraceError::TooFewPoints { points: 1 }));
    assert!(matches!(run(&[origin, [1.0; 3]], f64::NAN), TraceError::Parameter { .. }));
    assert!(matches!(run(&[], 1e-6), TraceError::TooFewPoints { points: 0 }));
    let mut positions = mesh.positions().to_vec();
    positions.extend(mesh.positions().iter().map(|p| [p[0] + 3.0, p[1], p[2]]));
    let mut faces = mesh.triangles().to_vec();
    faces.extend(mesh.triangles().iter().map(|f| f.map(|v| v + 9)));
    let two = TriangleMesh::new(positions, faces).unwrap();
    let error = trace_polyline(
        &two,
        &Bvh::new(&two),
        &[origin, [1.0, 1.0, 0.0], [3.5, 0.5, 0.0]],
        false,
        CurveKind::Signed,
        DEFAULT_TOLERANCE,
    );
    assert!(matches!(error, Err(TraceError::NotConnected { from: 1, to: 2 })));
    assert!(shortest_vertex_path(&two, &[Vertex(0), Vertex(9)]).is_err());
    assert_eq!(shortest_vertex_path(&two, &[Vertex(0), Vertex(8)]).unwrap(), [0, 4, 8].map(Vertex));
    assert!(trace_curve(&mesh, &Curve::signed([Vertex(0), Vertex(99)])).is_err());
    let outside = SurfacePoint::Face { vertices: [0, 1, 4], bary: [2.0, -1.0, 0.0] };
    assert!(trace_curve(&mesh, &Curve::signed([Vertex(0).into(), outside])).is_err());
}

#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn circles_are_traced_on_meshes_of_the_data_folder() {
    let mut run = 0;
    for name in [
        "closed/bunny.obj",
        "closed/spot.obj",
        "closed/fandisk.obj",
        "closed/3holes.off",
        "boundary/camelhead.off",
        "badquality/Havocglass8_left.obj",
        "badquality/block.obj",
        "badquality/capsule.obj",
        "nonmanifold/beetle.obj",
        "nonmanifold/fan3.obj",
        "nonmanifold/screwdriver.obj",
        "nonorientable/moebius.obj",
        "nonorientable/klein_bottle_2.obj",
        "synthetic/projective-plane-roman.obj",
    ] {
        let mesh = read_mesh(format!("{DATA}/{name}")).expect(name);
        run += 1;
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in mesh.positions() {
            for k in 0..3 {
                low[k] = low[k].min(p[k]);
                high[k] = high[k].max(p[k]);
            }
        }
        let bvh = Bvh::new(&mesh);
        let circle: Vec<[f64; 3]> = (0..40)
            .map(|i| {
                let a = TAU * i as f64 / 40.0;
                let u = [0.5 + 0.5 * a.cos(), 0.5 + 0.4 * a.sin(), 0.5 + 0.3 * a.sin()];
                [0, 1, 2].map(|k| low[k] + u[k] * (high[k] - low[k]))
            })
            .collect();
        let start = std::time::Instant::now();
        match trace_polyline(&mesh, &bvh, &circle, true, CurveKind::Signed, DEFAULT_TOLERANCE) {
            Ok(traced) => {
                check(&mesh, &traced);
                println!(
                    "{name}: {} nodes, {} halved, {} by edge path, {:?}",
                    traced.curve.nodes.len(),
                    traced.subdivided.len(),
                    traced.replaced.len(),
                    start.elapsed()
                );
            }
            Err(TraceError::NotConnected { from, to }) => println!("{name}: parts at {from} and {to}"),
            Err(error) => panic!("{name}: {error}"),
        }
    }
    println!("circles traced on {run} files");
}
