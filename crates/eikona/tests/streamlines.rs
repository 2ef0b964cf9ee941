//! Streamlines: closed forms, a slow twin, spacing, and faults.

use eikona::mesh::shapes::Diagonal;
use eikona::mesh::{SurfacePoint, TriangleMesh, damage, shapes};
use eikona::polar_field::{
    AutomaticOptions, FieldOptions, Guide, Place, PolarField, PolarFieldError, Singularity, Solver,
    Streamline, StreamlineEnd, StreamlineOptions,
};
use eikona::spatial::Bvh;

fn solve(mesh: &TriangleMesh, singularities: &[Singularity], options: &FieldOptions) -> PolarField {
    Solver::new(mesh, &Default::default()).unwrap().solve(singularities, options).unwrap()
}

fn automatic(mesh: &TriangleMesh, degree: u32) -> PolarField {
    let solver = Solver::new(mesh, &Default::default()).unwrap();
    let found = solver.automatic(&AutomaticOptions::default().with_degree(degree)).unwrap();
    let options = FieldOptions::default().with_degree(degree).with_generators(found.generators);
    solver.solve(&found.singularities, &options).unwrap()
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn point_of_face(mesh: &TriangleMesh, face: usize) -> SurfacePoint {
    SurfacePoint::Face { vertices: mesh.triangles()[face], bary: [0.3, 0.4, 0.3] }
}

#[test]
fn lines_of_a_constant_field_are_straight() {
    let plate = shapes::grid(9, 7, 1.8, 1.4, Diagonal::Alternating).unwrap();
    let whole = [Singularity { place: Place::Boundary(0), index: 1.0 }];
    let field = solve(&plate, &whole, &FieldOptions::default());
    for face in [3, 40, 77] {
        for k in 0..4 {
            let line = field.streamline_from(point_of_face(&plate, face), k, f64::INFINITY).unwrap();
            assert_eq!(line.ends, [StreamlineEnd::Boundary; 2]);
            let points = line.positions(&plate);
            let whole = sub(*points.last().unwrap(), points[0]);
            for &p in &points {
                let d = sub(p, points[0]);
                let aside = (d[0] * whole[1] - d[1] * whole[0]).abs() / norm(whole);
                assert!(aside < 1e-5 * norm(whole), "{aside:e}");
            }
        }
    }
}

#[test]
fn lines_around_a_centre_are_logarithmic_spirals() {
    // With index 1 at the centre of a disk, the field keeps its angle to the radius: along a line,
    // the logarithm of the radius is proportional to the angle.
    let disk = shapes::disk(24, 72, 1.0).unwrap();
    let centre = [Singularity { place: Place::Point(SurfacePoint::Vertex { vertex: 0 }), index: 1.0 }];
    let field = solve(&disk, &centre, &FieldOptions::default().with_degree(1));
    let face = (0..disk.face_count())
        .min_by(|a, b| {
            let off = |f: &usize| {
                let [x, y, _] = disk.positions()[disk.triangles()[*f][0] as usize];
                (x.hypot(y) - 0.6).abs()
            };
            off(a).total_cmp(&off(b))
        })
        .unwrap();
    let line = field.streamline_from(point_of_face(&disk, face), 0, f64::INFINITY).unwrap();
    let points: Vec<[f64; 3]> =
        line.positions(&disk).into_iter().filter(|p| (0.15..0.95).contains(&p[0].hypot(p[1]))).collect();
    assert!(points.len() > 30);
    let slope = |p: [f64; 3], q: [f64; 3]| {
        let turn = (q[1] * p[0] - q[0] * p[1]).atan2(dot(p, q));
        let growth = (q[0].hypot(q[1]) / p[0].hypot(p[1])).ln();
        turn.atan2(growth)
    };
    let angles: Vec<f64> = points.chunks(10).filter(|c| c.len() == 10).map(|c| slope(c[0], c[9])).collect();
    for angle in &angles {
        let off = (angle - angles[0]).sin().abs();
        assert!(off < 0.02, "{angles:?}");
    }
}

#[test]
fn lines_agree_with_small_steps_along_evaluated_vectors() {
    let mesh = shapes::grid(12, 12, 1.0, 1.0, Diagonal::Alternating).unwrap();
    let face = |f: usize, index: f64| Singularity { place: Place::Point(point_of_face(&mesh, f)), index };
    let whole = Singularity { place: Place::Boundary(0), index: 1.0 };
    let field =
        solve(&mesh, &[whole, face(100, 0.5), face(210, -0.5)], &FieldOptions::default().with_degree(2));
    let bvh = Bvh::new(&mesh);
    for start in [20, 90, 130, 200] {
        let point = point_of_face(&mesh, start);
        let line = field.streamline_from(point, 0, 0.3).unwrap();
        let points = line.positions(&mesh);
        let first =
            points.iter().position(|p| norm(sub(*p, point.locate(&mesh).unwrap().position(&mesh))) < 1e-12);
        let ahead = &points[first.unwrap()..];
        // The twin: the midpoint rule in space, with vectors from the public evaluation.
        let (mut p, mut before) = (ahead[0], sub(ahead[1], ahead[0]));
        let mut path = vec![p];
        let vector = |p: [f64; 3], near: [f64; 3]| {
            let place = bvh.closest_point(p).unwrap().locate(&mesh).to_surface_point(&mesh);
            let all = field.vectors_at(place).unwrap();
            all.into_iter().max_by(|a, b| dot(*a, near).total_cmp(&dot(*b, near))).unwrap()
        };
        const STEP: f64 = 2e-4;
        for _ in 0..1500 {
            let v = vector(p, before);
            let half = std::array::from_fn(|k| p[k] + 0.5 * STEP * v[k]);
            let v = vector(half, v);
            p = std::array::from_fn(|k| p[k] + STEP * v[k]);
            before = v;
            path.push(p);
        }
        let farthest = ahead
            .iter()
            .map(|q| path.iter().map(|p| norm(sub(*p, *q))).fold(f64::INFINITY, f64::min))
            .fold(0.0, f64::max);
        // Half a step, and the error of the twin where it crosses edges.
        assert!(farthest < 5e-4, "from face {start}: {farthest:e}");
    }
}

#[test]
fn circles_close() {
    let annulus = shapes::annulus(0.5, 1.0, 10, 60).unwrap();
    // Both boundaries run with the surface on their left: vectors would have to turn in between.
    let options = FieldOptions::default().with_degree(2).with_guides(vec![Guide::Boundary]);
    let field = solve(&annulus, &[], &options);
    let lines = field.streamlines(&StreamlineOptions::default().with_separation(Some(0.08))).unwrap();
    // The field follows the boundaries exactly, and circles in between nearly: most lines come back
    // beside where they began, and some spiral.
    let closed: Vec<&Streamline> = lines.iter().filter(|line| line.is_closed()).collect();
    assert!(lines.len() >= 5 && 2 * closed.len() > lines.len(), "{} of {}", closed.len(), lines.len());
    for line in closed {
        let radii: Vec<f64> = line.positions(&annulus).iter().map(|p| p[0].hypot(p[1])).collect();
        let (low, high) = radii.iter().fold((f64::INFINITY, 0.0f64), |(a, b), r| (a.min(*r), b.max(*r)));
        assert!(high - low < 0.02, "{low} to {high}");
        assert_eq!(line.nodes[0], *line.nodes.last().unwrap());
    }
}

/// The largest number of pairs of points that a slow search finds too close.
fn crowded(field: &PolarField, lines: &[Streamline], within: f64, parallel: f64) -> usize {
    let mesh = field.mesh();
    let sampled: Vec<Vec<([f64; 3], [f64; 3])>> = lines
        .iter()
        .map(|line| {
            let points = line.positions(mesh);
            // Ends may touch others.
            let inner = 3..points.len().saturating_sub(3).max(3);
            inner.map(|i| (points[i], sub(points[i + 1], points[i - 1]))).collect()
        })
        .collect();
    let mut found = 0;
    for (i, a) in sampled.iter().enumerate() {
        for b in &sampled[..i] {
            for (p, t) in a {
                let is_close = |(q, u): &&([f64; 3], [f64; 3])| {
                    norm(sub(*p, *q)) < within && (dot(*t, *u) / norm(*t) / norm(*u)).abs() > parallel
                };
                found += b.iter().filter(is_close).count();
            }
        }
    }
    found
}

#[test]
fn lines_of_one_direction_keep_their_distance_and_leave_no_holes() {
    let sphere = damage::jitter(&shapes::icosphere(4).unwrap(), 0.1, 2).unwrap();
    for (degree, parallel) in [(1, 0.1), (2, 0.1), (4, 0.8)] {
        let field = automatic(&sphere, degree);
        let separation = 0.12;
        let options = StreamlineOptions::default().with_separation(Some(separation));
        let lines = field.streamlines(&options).unwrap();
        assert_eq!(crowded(&field, &lines, 0.4 * separation, parallel), 0, "N = {degree}");
        // No vertex is far from all lines.
        let points: Vec<[f64; 3]> = lines.iter().flat_map(|line| line.positions(&sphere)).collect();
        let far = sphere
            .positions()
            .iter()
            .map(|p| points.iter().map(|q| norm(sub(*p, *q))).fold(f64::INFINITY, f64::min))
            .fold(0.0, f64::max);
        assert!(far < 1.3 * separation, "N = {degree}: {far}");
        assert_eq!(field.streamlines(&options).unwrap(), lines, "the same every time");
    }
}

#[test]
fn lines_scale_with_the_mesh() {
    let torus = shapes::torus(1.0, 0.4, 40, 16).unwrap();
    let lines = |scale: f64| {
        let positions = torus.positions().iter().map(|p| p.map(|x| x * scale)).collect();
        let mesh = TriangleMesh::new(positions, torus.triangles().to_vec()).unwrap();
        automatic(&mesh, 2).streamlines(&StreamlineOptions::default()).unwrap()
    };
    let plain = lines(1.0);
    for exponent in [-27, 27, 400] {
        let scaled = lines(2f64.powi(exponent));
        assert_eq!(scaled.len(), plain.len());
        for (a, b) in scaled.iter().zip(&plain) {
            assert_eq!((a.nodes.len(), a.ends), (b.nodes.len(), b.ends));
        }
    }
}

#[test]
fn positions_are_apart() {
    let mesh = damage::jitter(&shapes::torus(1.0, 0.4, 50, 20).unwrap(), 0.2, 6).unwrap();
    for degree in [1, 2, 3, 4] {
        let field = automatic(&mesh, degree);
        let lines = field.streamlines(&StreamlineOptions::default().with_separation(Some(0.05))).unwrap();
        for line in &lines {
            let points = line.positions(&mesh);
            assert!(points.len() > 1 && points.windows(2).all(|pair| norm(sub(pair[0], pair[1])) > 1e-7));
            assert_eq!(points[0], line.nodes[0].position(&mesh));
        }
    }
}

#[test]
fn faults_of_streamlines_are_named() {
    let sphere = shapes::icosphere(2).unwrap();
    let field = automatic(&sphere, 4);
    for separation in [0.0, -1.0, f64::NAN, 1e-9] {
        let options = StreamlineOptions::default().with_separation(Some(separation));
        let fault = field.streamlines(&options).map(drop).unwrap_err();
        assert!(matches!(fault, PolarFieldError::Separation { .. }), "{fault}");
    }
    let nowhere = SurfacePoint::Vertex { vertex: 100_000 };
    let fault = field.streamline_from(nowhere, 0, 1.0).map(drop).unwrap_err();
    assert!(matches!(fault, PolarFieldError::Start(_)), "{fault}");
}
