//! Sources of every kind, where the distance has a closed form.

mod exact;

use eikona::signed_heat::{DiffusionTime, LevelSets, SolveOptions};
use eikona_mesh::{
    Curve, SurfaceCurves, SurfacePoint, TriangleMesh, damage,
    shapes::{self, Diagonal},
};
use exact::*;

#[test]
fn parts_of_edges_have_a_direction() {
    let mesh = shapes::grid(10, 4, 10.0, 4.0, Diagonal::Alternating).unwrap();
    let on_edge = |y: f64, t: f64| SurfacePoint::Edge {
        vertices: [vertex_at(&mesh, [5.0, y, 0.0]), vertex_at(&mesh, [5.0, y + 1.0, 0.0])].map(|v| v.0),
        t,
    };
    let ys = [0.0, 1.0, 2.0, 3.0];
    // The middle halves of the edges, each a separate curve; and one curve with three nodes per
    // edge.
    let parts: Vec<Curve> = ys.iter().map(|&y| Curve::signed([on_edge(y, 0.25), on_edge(y, 0.75)])).collect();
    let parts = SurfaceCurves { curves: parts, points: Vec::new() };
    let whole = SurfaceCurves::from_curve(Curve::signed(
        ys.iter().flat_map(|&y| [on_edge(y, 0.0), on_edge(y, 0.4), on_edge(y, 0.9), on_edge(y, 1.0)]),
    ));
    for source in [parts, whole] {
        for (source, sign) in [(reversed(&source), -1.0), (source, 1.0)] {
            for values in [free(&mesh, &source), zero(&mesh, &source)] {
                let e = errors(&mesh, &values, |p| sign * (p[0] - 5.0));
                assert!(e.largest < 1e-9, "{sign}: {e:?}");
            }
        }
    }
}

#[test]
fn duplicated_curves_equal_single_ones() {
    let mesh = rough_plate(20);
    let mut source = zero_level(&mesh, |p| (p[0] - 0.9).hypot(p[1] - 1.1) - 0.5);
    source.curves.push(through_vertices(&plate(20), |p| p[0] == 1.8, |p| p[1]));
    let mut doubled = source.clone();
    doubled.curves.extend(source.curves.clone());
    assert!(largest_difference(&free(&mesh, &source), &free(&mesh, &doubled)) < 1e-12);
    assert!(largest_difference(&zero(&mesh, &source), &zero(&mesh, &doubled)) < 1e-7);
    let soft = |source| solve(&mesh, source, PAPER_TIME, LevelSets::Soft(3.0)).distance.into_vec();
    assert!(largest_difference(&soft(&source), &soft(&doubled)) < 1e-9);
}

/// A soft level set constraint is independent of the resolution, for curves and for points.
#[test]
fn soft_level_sets_do_not_depend_on_resolution() {
    let ask = |n: usize| {
        let mesh = plate(n);
        let mut source = zero_level(&mesh, |p| (p[0] - 0.9).hypot(p[1] - 1.1) - 0.5);
        source.points.push(vertex_at(&mesh, [0.2, 0.2, 0.0]).into());
        // The same diffusion time on all meshes.
        let time = DiffusionTime::Coefficient((n as f64 / 40.0).powi(2));
        let solution = solve(&mesh, &source, time, LevelSets::Soft(30.0));
        [[0.5, 0.2, 0.0], [1.8, 1.8, 0.0], [1.0, 1.0, 0.0]].map(|p| solution.distance[vertex_at(&mesh, p)])
    };
    let (coarse, fine) = (ask(40), ask(160));
    println!("{coarse:?} {fine:?}");
    for (a, b) in coarse.into_iter().zip(fine) {
        assert!((a - b).abs() < 0.015, "{coarse:?} {fine:?}");
    }
}

/// The normals of a curve and of its reverse cancel. Alone on a surface they give no distance, with
/// a warning.
#[test]
fn opposite_curves_cancel() {
    let mesh = rough_plate(20);
    let circle = zero_level(&mesh, |p| (p[0] - 0.9).hypot(p[1] - 1.1) - 0.5);
    let line = straight(&mesh, [0.1, 0.1, 0.0], [1.9, 0.2, 0.0]);
    let mut source = SurfaceCurves::from_curve(line.clone());
    source.curves.push(line.clone().reversed());
    let mut both = circle.clone();
    both.curves.extend(source.curves.clone());
    let difference = largest_difference(&free(&mesh, &both), &free(&mesh, &circle));
    // Not bitwise: the shift counts the length of the cancelled line, too.
    let alone = free(&mesh, &circle);
    let shift = free(&mesh, &both)[0] - alone[0];
    let moved: Vec<f64> = alone.iter().map(|x| x + shift).collect();
    assert!(largest_difference(&free(&mesh, &both), &moved) < 1e-9, "{difference}");

    let solution = solve(&mesh, &source, PAPER_TIME, LevelSets::Free);
    assert!(
        solution.distance.as_slice().iter().all(|d| d.is_nan()),
        "rounding of cancelled normals gives a distance of up to {}",
        largest(solution.distance.as_slice())
    );
    assert!(solution.report.all_warnings().any(|w| w.to_string().contains("800 faces")));
}

/// Two lines that cross, with contradictory signs in two quadrants: the result keeps the symmetry,
/// and in the quadrant where both are positive the constrained distance is that to the nearer line.
#[test]
fn crossing_lines() {
    for n in [20, 40] {
        let mesh = plate(n);
        let up = through_vertices(&mesh, |p| p[0] == 1.0, |p| p[1]);
        let leftwards = through_vertices(&mesh, |p| p[1] == 1.0, |p| -p[0]);
        let source = SurfaceCurves { curves: vec![up, leftwards], points: Vec::new() };
        for (constrained, values) in [(false, free(&mesh, &source)), (true, zero(&mesh, &source))] {
            for v in mesh.vertices() {
                let [x, y, _] = mesh.position(v);
                let at = |x: f64, y: f64| values[vertex_at(&mesh, [x, y, 0.0]).index()];
                let here = values[v.index()];
                assert!((here - at(y, x)).abs() < 1e-7 && (here + at(2.0 - y, 2.0 - x)).abs() < 1e-7);
                if constrained && x > 1.0 && y > 1.0 {
                    let exact = (x - 1.0).min(y - 1.0);
                    assert!((here - exact).abs() < 2.0 / n as f64, "({x}, {y}): {here}");
                }
            }
        }
    }
}

/// Three curves from one vertex: a signed line and a signed branch. All nodes are zero, and no
/// value exceeds the distance.
#[test]
fn branching_curves() {
    let n = 40;
    let mesh = plate(n);
    let line = through_vertices(&mesh, |p| p[0] == 1.0, |p| p[1]);
    let branch = through_vertices(&mesh, |p| p[1] == 1.0 && p[0] >= 1.0, |p| p[0]);
    let source = SurfaceCurves { curves: vec![line.clone(), branch.clone()], points: Vec::new() };
    let values = zero(&mesh, &source);
    for node in line.nodes.iter().chain(&branch.nodes) {
        let SurfacePoint::Vertex { vertex } = node else { panic!() };
        assert!(values[*vertex as usize].abs() < 1e-6);
    }
    // On the left of the line the branch has no influence.
    for v in mesh.vertices() {
        let [x, y, _] = mesh.position(v);
        if x < 0.9 {
            assert!(
                (values[v.index()] - (x - 1.0)).abs() < 2.0 / n as f64,
                "({x}, {y}): {}",
                values[v.index()]
            );
        }
        let distance = if x > 1.0 { (x - 1.0).min((y - 1.0).abs()) } else { 1.0 - x };
        assert!(values[v.index()].abs() < distance + 2.0 / n as f64, "({x}, {y}): {}", values[v.index()]);
    }
}

fn square_distance(p: [f64; 3]) -> f64 {
    let (x, y) = ((p[0] - 1.0).abs() - 0.5, (p[1] - 1.0).abs() - 0.5);
    if x.max(y) < 0.0 { x.max(y) } else { x.max(0.0).hypot(y.max(0.0)) }
}

/// Long diffusion rounds the corners of a square; preserving the normals of the curve keeps them
/// sharp.
#[test]
fn preserved_normals_keep_corners() {
    let n = 80;
    let mesh = plate(n);
    let mut nodes = Vec::new();
    let corners = [[0.5, 0.5], [1.5, 0.5], [1.5, 1.5], [0.5, 1.5]];
    for i in 0..4 {
        let (a, b) = (corners[i], corners[(i + 1) % 4]);
        for k in 0..n / 2 {
            let s = k as f64 / (n / 2) as f64;
            nodes.push(vertex_at(&mesh, [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), 0.0]));
        }
    }
    nodes.push(nodes[0]);
    let source = SurfaceCurves::from_curve(Curve::signed(nodes));
    for coefficient in [10.0, 100.0] {
        let solver = solver(&mesh, DiffusionTime::Coefficient(coefficient));
        let error = |preserve_source_normals: bool| {
            let options = levels(LevelSets::Free).with_preserve_source_normals(preserve_source_normals);
            let values = solver.solve(&source, &options).unwrap().distance;
            let near: Vec<f64> = mesh
                .vertices()
                .filter(|&v| square_distance(mesh.position(v)).abs() < 0.1)
                .map(|v| values[v] - square_distance(mesh.position(v)))
                .collect();
            (near.iter().map(|e| e * e).sum::<f64>() / near.len() as f64).sqrt()
        };
        let (rounded, kept) = (error(false), error(true));
        println!("square, coefficient {coefficient}: rounded {rounded:.2e}, kept {kept:.2e}");
        assert!(kept < 0.7 * rounded, "kept {kept}, rounded {rounded}");
    }
    // On a straight line the normals need no constraint.
    let line = SurfaceCurves::from_curve(straight(&mesh, [0.7, 0.0, 0.0], [0.7, 2.0, 0.0]));
    let options = SolveOptions::default().with_preserve_source_normals(true);
    let solution = solver(&mesh, PAPER_TIME).solve(&line, &options).unwrap();
    assert!(errors(&mesh, solution.distance.as_slice(), |p| p[0] - 0.7).largest < 1e-7);
    assert_eq!(solution.report.normal_constraints.unwrap().iterations, 0);
    assert!(solution.report.warnings.is_empty());
}

/// Splitting a segment in three changes nothing.
#[test]
fn preserved_normals_do_not_depend_on_segments() {
    let mesh = rough_plate(24);
    let whole = zero_level(&mesh, |p| (p[0] - 1.0).hypot(p[1] - 1.0) - 0.51);
    let options = levels(LevelSets::Free).with_preserve_source_normals(true);
    let mut cut = whole.clone();
    for (curve, before) in cut.curves.iter_mut().zip(&whole.curves) {
        let mut nodes = vec![before.nodes[0]];
        for segment in SurfaceCurves::from_curve(before.clone()).segments(&mesh).unwrap() {
            let eikona_mesh::SegmentHost::Face(face, [a, b]) = segment.host else { panic!("{segment:?}") };
            let at = |s: f64| SurfacePoint::Face {
                vertices: mesh.triangles()[face.index()],
                bary: [0, 1, 2].map(|k| (1.0 - s) * a[k] + s * b[k]),
            };
            nodes.extend([at(0.3), at(0.7)]);
            nodes.push(before.nodes[(nodes.len() + 1) / 3]);
        }
        curve.nodes = nodes;
    }
    let solver = solver(&mesh, DiffusionTime::Coefficient(20.0));
    let [whole, cut] = [whole, cut].map(|source| solver.solve(&source, &options).unwrap());
    assert_eq!(cut.report.source_segments, 3 * whole.report.source_segments);
    let difference = largest_difference(whole.distance.as_slice(), cut.distance.as_slice());
    assert!(difference < 1e-8, "{difference:e}");
}

/// Also for curves much finer than the mesh, whose segments a face can not satisfy one by one, for
/// long diffusion, and in the real form.
#[test]
fn preserved_normals_take_few_iterations() {
    let plate = rough_plate(40);
    let flipped = damage::flip_faces(&plate, 0.4, 2).unwrap().mesh;
    // A third face on every edge of the line x = 1.
    let flat = crate::exact::plate(40);
    let (mut positions, mut faces) = (flat.positions().to_vec(), flat.triangles().to_vec());
    for [a, b] in flat.edges().map(|e| flat.edge_vertices(e)) {
        let ([x, y, _], [u, w, _]) = (flat.position(a), flat.position(b));
        if x == 1.0 && u == 1.0 {
            faces.push([a.0, b.0, positions.len() as u32]);
            positions.push([1.0, 0.5 * (y + w), 0.05]);
        }
    }
    let fins = TriangleMesh::new(positions, faces).unwrap();
    for (name, mesh) in [("plate", &plate), ("flipped", &flipped), ("fins", &fins)] {
        let circle = zero_level(mesh, |p| (p[0] - 1.0).hypot(p[1] - 1.0) - 0.51);
        let points: Vec<[f64; 3]> = (0..3000)
            .map(|i| f64::from(i) / 3000.0 * std::f64::consts::TAU)
            .map(|a| [1.0 + (0.51 + 0.1 * (9.0 * a).sin()) * a.cos(), 1.0 + 0.51 * a.sin(), 0.0])
            .collect();
        let bvh = eikona::spatial::Bvh::new(mesh);
        let kind = eikona_mesh::CurveKind::Signed;
        let fine = eikona::curves::trace_polyline(mesh, &bvh, &points, true, kind, 1e-6).unwrap().curve;
        let mut doubled = circle.clone();
        doubled.curves.extend(circle.curves.clone());
        let fine = SurfaceCurves::from_curve(fine);
        for (curve, source) in [("circle", circle), ("fine", fine), ("doubled", doubled)] {
            for coefficient in [0.1, 1.0, 50.0, 1000.0] {
                let options = levels(LevelSets::Free).with_preserve_source_normals(true);
                let solver = solver(mesh, DiffusionTime::Coefficient(coefficient));
                let report = solver.solve(&source, &options).unwrap().report;
                let kept = report.normal_constraints.clone().unwrap();
                println!("{name}, {curve}, coefficient {coefficient}: {kept:?}");
                assert!(kept.iterations <= 24 && kept.residual <= kept.tolerance, "{kept:?}");
                assert!(
                    !report.all_warnings().any(|w| w.kind() == "tilted_normals"),
                    "{:?}",
                    report.warnings
                );
            }
        }
    }
}

/// Seven tenths of a circle, in two arcs; the gaps are completed.
#[test]
fn two_arcs_of_a_circle() {
    let mesh = rough_plate(64);
    let exact = |p: [f64; 3]| (p[0] - 1.0).hypot(p[1] - 1.0) - 0.5;
    let arcs = broken(&mesh, &zero_level(&mesh, exact), 0.35, 0.15);
    assert_eq!(arcs.curves.len(), 2);
    for coefficient in [1.0, 30.0] {
        let values = solve(&mesh, &arcs, DiffusionTime::Coefficient(coefficient), LevelSets::Free).distance;
        let e = errors(&mesh, values.as_slice(), exact);
        println!("two arcs, coefficient {coefficient}: {e:?}");
        // The chords across the gaps are 0.054 away from the arcs.
        assert!(e.largest < 0.2 && e.l2 < 0.054, "{e:?}");
    }
}

/// More curves through each face than it has vectors: the result is finite, and the report states
/// how well the normals are preserved.
#[test]
fn contradictory_normals() {
    let mesh = rough_plate(6);
    let mut random = eikona_mesh::random::Random::from_seed(4);
    let mut point = || [0, 1, 2].map(|k| if k == 2 { 0.0 } else { 0.1 + 1.8 * random.uniform() });
    let curves = (0..60).map(|_| straight(&mesh, point(), point())).collect();
    let source = SurfaceCurves { curves, points: Vec::new() };
    for coefficient in [1.0, 50.0] {
        let options = levels(LevelSets::Free).with_preserve_source_normals(true);
        let solution =
            solver(&mesh, DiffusionTime::Coefficient(coefficient)).solve(&source, &options).unwrap();
        let kept = solution.report.normal_constraints.clone().unwrap();
        println!("contradictory, coefficient {coefficient}: {kept:?}");
        assert!(solution.distance.as_slice().iter().all(|d| d.is_finite()));
        let warned = solution.report.warnings.iter().any(|w| w.kind() == "tilted_normals");
        assert_eq!(warned, kept.residual > kept.tolerance, "{kept:?}");
    }
}
