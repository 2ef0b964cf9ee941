//! Level set constraints: the distance on the curves themselves.

mod exact;

use eikona::signed_heat::LevelSets;
use eikona_mesh::{
    Curve, Located, SurfaceCurves, SurfacePoint, TriangleMesh, damage,
    shapes::{self, Diagonal},
};
use exact::*;

fn values_at_nodes(mesh: &TriangleMesh, source: &SurfaceCurves, values: &[f64]) -> Vec<f64> {
    source
        .curves
        .iter()
        .flat_map(|c| &c.nodes)
        .chain(&source.points)
        .map(|p| p.locate(mesh).unwrap().interpolate(mesh, values))
        .collect()
}

/// Curves with linearly dependent rows: duplicated curves, a third curve between them, many nodes
/// in one face, crossings, a point on a curve.
fn dependent_rows(mesh: &TriangleMesh) -> SurfaceCurves {
    let mut source = zero_level(mesh, |p| (p[0] - 0.9).hypot(p[1] - 0.6) - 0.4);
    let doubled = source.curves.clone();
    source.curves.extend(doubled);
    source.curves.extend(zero_level(mesh, |p| p[0] + 0.2 * p[1] - 0.8).curves);
    let face = mesh.triangles()[77];
    let inside = |a: f64, b: f64| SurfacePoint::Face { vertices: face, bary: [a, b, 1.0 - a - b] };
    source.curves.push(Curve::signed([
        inside(0.1, 0.1),
        inside(0.3, 0.2),
        inside(0.5, 0.2),
        inside(0.2, 0.6),
        inside(0.1, 0.4),
    ]));
    source.points.push(source.curves[0].nodes[3]);
    source
}

/// Zero exactly at vertices and isolated points, in all cases; along consistent curves that cross
/// faces, up to a small share of the square of the edge length.
#[test]
fn zero_is_zero_along_the_curves() {
    let grid = shapes::grid(36, 24, 1.8, 1.2, Diagonal::Alternating).unwrap();
    let rough = damage::jitter(&grid, 0.25, 5).unwrap();
    let sphere = damage::jitter(&shapes::geodesic_sphere(16).unwrap(), 0.2, 6).unwrap();
    let on_sphere = zero_level(&sphere, |p| p[2] - 0.3 + 0.4 * p[0] * p[1]);
    let with_vertices = |mesh: &TriangleMesh| {
        let mut source = dependent_rows(mesh);
        let edge = mesh.edge_vertices(mesh.face_edges(mesh.faces().nth(300).unwrap())[0]);
        source.curves.push(Curve::signed(edge));
        source
    };
    for (name, mesh, source, contradictory) in [
        ("plate", &grid, with_vertices(&grid), true),
        ("rough plate", &rough, with_vertices(&rough), true),
        ("sphere", &sphere, on_sphere.clone(), false),
        ("broken on sphere", &sphere, broken(&sphere, &on_sphere, 0.1, 0.05), false),
    ] {
        let solution = solve(mesh, &source, PAPER_TIME, LevelSets::Zero);
        let distance = solution.distance.as_slice();
        let exact = source
            .curves
            .iter()
            .flat_map(|c| &c.nodes)
            .filter(|p| matches!(p, SurfacePoint::Vertex { .. }))
            .chain(&source.points)
            .map(|p| p.locate(mesh).unwrap().interpolate(mesh, distance).abs())
            .fold(0.0, f64::max);
        let at_nodes = largest(&values_at_nodes(mesh, &source, distance));
        let edge = mean_edge_length(mesh);
        println!("{name}: exact constraints {exact:.1e}, along the curves {:.1e} edges", at_nodes / edge);
        assert!(exact < 1e-6 * largest(distance), "{name}: {exact:e}");
        assert!(contradictory || at_nodes < 0.5 * edge * edge, "{name}: {at_nodes}, edges of length {edge}");
        assert!(solution.report.constraint_violation.unwrap() >= at_nodes * 0.999);
        assert!(largest(distance) > 0.3, "{name}: flattened");
    }
}

/// A polyline in space, traced over the faces, is not an isoline of any function that is linear in
/// every face. With exact constraints at every node, the distance would be flat along the strip of
/// faces that it crosses.
#[test]
fn zero_does_not_lock_on_a_polyline() {
    for frequency in [20, 40] {
        let mesh = shapes::geodesic_sphere(frequency).unwrap();
        let points = shapes::latitude_circle(0.3f64.asin(), 200).unwrap();
        let bvh = eikona::spatial::Bvh::new(&mesh);
        let kind = eikona_mesh::CurveKind::Signed;
        let curve = eikona::curves::trace_polyline(&mesh, &bvh, &points, true, kind, 1e-6).unwrap().curve;
        let source = SurfaceCurves::from_curve(curve.reversed());
        let exact = |p: [f64; 3]| 0.3f64.asin() - p[2].clamp(-1.0, 1.0).asin();
        let error = |level_sets| {
            errors(&mesh, solve(&mesh, &source, PAPER_TIME, level_sets).distance.as_slice(), exact).l2
        };
        let free = error(LevelSets::Free);
        for level_sets in [LevelSets::Zero, LevelSets::PerComponent] {
            let held = error(level_sets);
            println!("frequency {frequency}, {level_sets:?}: {held:.2e}, free {free:.2e}");
            assert!(held < 1.5 * free, "{level_sets:?}: {held:e}, free {free:e}");
        }
    }
}

/// Two concentric circles, the outer one reversed: outside it the distance decreases again. Their
/// levels differ by the distance between them.
#[test]
fn per_component_finds_the_level_of_each_curve() {
    let mesh = shapes::disk(60, 6, 1.0).unwrap();
    let radius = |p: [f64; 3]| p[0].hypot(p[1]);
    // Both have the smaller radius on the left, so the distance grows by 0.4 from the first to the
    // second.
    let mut source = zero_level(&mesh, |p| radius(p) - 0.31);
    source.curves.extend(zero_level(&mesh, |p| radius(p) - 0.71).curves);
    // An isolated point has no level, and no entry among those of the curves.
    let mut with_point = source.clone();
    with_point.points.push(eikona_mesh::Vertex(0).into());
    let levels = solve(&mesh, &with_point, PAPER_TIME, LevelSets::PerComponent).report.levels;
    assert_eq!(levels.len(), 2);
    let solution = solve(&mesh, &source, PAPER_TIME, LevelSets::PerComponent);
    let report = &solution.report;
    assert_eq!(report.levels.len(), 2);
    let difference = report.levels[1] - report.levels[0];
    assert!((difference - 0.4).abs() < 2e-3, "{:?}", report.levels);
    for (curve, level) in source.curves.iter().zip(&report.levels) {
        let own = SurfaceCurves::from_curve(curve.clone());
        for value in values_at_nodes(&mesh, &own, solution.distance.as_slice()) {
            assert!((value - level).abs() < 1e-4, "{value} on the curve of level {level}");
        }
    }
    // The shift: the length-weighted mean over both curves is zero.
    let mean = (0.31 * report.levels[0] + 0.71 * report.levels[1]) / (0.31 + 0.71);
    assert!(mean.abs() < 1e-3, "{mean}");
    let e = errors(&mesh, solution.distance.as_slice(), |p| radius(p) - (0.31 * 0.31 + 0.71 * 0.71) / 1.02);
    assert!(e.l2 < 5e-3, "{e:?}");
    // Zero on both is incompatible with a unit gradient in between.
    let flattened = solve(&mesh, &source, PAPER_TIME, LevelSets::Zero);
    let between =
        values_at_nodes(&mesh, &zero_level(&mesh, |p| radius(p) - 0.51), flattened.distance.as_slice());
    assert!(largest(&between) < 0.1);
}

/// A noisy curve: its values have a spread without constraint, none with an exact one, and one in
/// between with a penalty.
fn noisy_curve(mesh: &TriangleMesh) -> SurfaceCurves {
    zero_level(mesh, |p| p[1] - 0.6 + 0.04 * (25.0 * p[0]).sin())
}

/// Root mean square of the values on the curve.
fn spread(mesh: &TriangleMesh, source: &SurfaceCurves, values: &[f64]) -> f64 {
    let at = values_at_nodes(mesh, source, values);
    (at.iter().map(|x| x * x).sum::<f64>() / at.len() as f64).sqrt()
}

#[test]
fn soft_lies_between_free_and_zero() {
    let grid = shapes::grid(54, 36, 1.8, 1.2, Diagonal::Alternating).unwrap();
    let mesh = damage::jitter_with(&grid, 0.2, 5, &|p| [p[0], p[1], 0.0]).unwrap();
    let source = noisy_curve(&mesh);
    let solver = solver(&mesh, PAPER_TIME);
    let with = |level_sets| {
        let solution = solver.solve(&source, &levels(level_sets)).unwrap();
        let values = solution.distance.into_vec();
        // The violation in the report is the actual one.
        let at_nodes = largest(&values_at_nodes(&mesh, &source, &values));
        match (level_sets, solution.report.constraint_violation) {
            (LevelSets::Free, violation) => assert_eq!(violation, None),
            (_, violation) => {
                let violation = violation.unwrap();
                assert!(
                    violation >= at_nodes * 0.999999 && violation < 2.0 * at_nodes,
                    "{violation} {at_nodes}"
                );
            }
        }
        values
    };
    let (free, zero) = (with(LevelSets::Free), with(LevelSets::Zero));
    let weights = [1e-7, 1e-3, 1.0, 30.0, 1e3, 1e12];
    let soft: Vec<Vec<f64>> = weights.iter().map(|&w| with(LevelSets::Soft(w))).collect();
    assert!(largest_difference(&free, &zero) > 1e-3, "the curve is not noisy enough");
    let at_zero = spread(&mesh, &source, &zero);
    assert!(largest_difference(&soft[0], &free) < 1e-6, "{}", largest_difference(&soft[0], &free));
    let spreads: Vec<f64> = soft.iter().map(|s| spread(&mesh, &source, s)).collect();
    println!("soft: free {:.2e}, penalties {spreads:?}", spread(&mesh, &source, &free));
    assert!(spreads.windows(2).all(|s| s[1] <= s[0]), "{spreads:?}");
    assert!(spreads[1] > at_zero && at_zero > spreads[5], "zero {at_zero:e}, penalties {spreads:?}");
}

/// Two lines at distance d on a rectangle, both drawn to zero: the values on them are -a and a with
/// a = 1 / (2 / d + weight / sqrt(area)), for any mesh and unit.
#[test]
fn soft_weight_has_a_closed_form() {
    for weight in [0.5, 10.0, 200.0] {
        for (n, scale) in [(10, 1.0), (30, 1.0), (60, 1.0), (30, 1e6), (30, 1e-6)] {
            let grid = shapes::grid(3 * n, 2 * n, 1.8 * scale, 1.2 * scale, Diagonal::Alternating).unwrap();
            let mesh = damage::jitter_with(&grid, 0.1, 5, &|p| [p[0], p[1], 0.0]).unwrap();
            let area: f64 = mesh.faces().map(|f| face_area(&mesh, f)).sum::<f64>() / (scale * scale);
            let line = |y: f64| zero_level(&mesh, |p| p[1] / scale - y);
            let mut source = line(0.43);
            source.curves.extend(line(0.83).curves);
            let values = solve(&mesh, &source, PAPER_TIME, LevelSets::Soft(weight)).distance.into_vec();
            let exact = 1.0 / (2.0 / 0.4 + weight / area.sqrt());
            for (y, sign) in [(0.43, -1.0), (0.83, 1.0)] {
                let at = values_at_nodes(&mesh, &line(y), &values);
                let mean = at.iter().sum::<f64>() / at.len() as f64 / scale;
                // A kink at a line inside faces is spread over one face.
                let row = 0.6 / n as f64;
                assert!(
                    (mean * sign - exact).abs() < 0.1 * row,
                    "weight {weight}, {n} rows, unit {scale}: {mean}, expected {exact}"
                );
            }
        }
    }
}

/// Free: the length-weighted mean along the curves is zero.
#[test]
fn free_has_mean_zero_on_the_curves() {
    let mesh = damage::jitter(&shapes::geodesic_sphere(12).unwrap(), 0.2, 6).unwrap();
    let source = broken(&mesh, &zero_level(&mesh, |p| p[2] - 0.3 + 0.4 * p[0] * p[1]), 0.1, 0.05);
    let values = free(&mesh, &source);
    let (mut sum, mut total) = (0.0, 0.0);
    for s in source.segments(&mesh).unwrap() {
        let [a, b] = s.ends.map(|p: Located| (p.position(&mesh), p.interpolate(&mesh, &values)));
        sum += norm(sub(b.0, a.0)) * 0.5 * (a.1 + b.1);
        total += norm(sub(b.0, a.0));
    }
    assert!((sum / total).abs() < 1e-12, "{}", sum / total);
    assert!(spread(&mesh, &source, &values) > 1e-4, "the values do not vary");
}

/// The confidence is high near the curve, and low behind a gap.
#[test]
fn confidence_falls_behind_gaps() {
    let mesh = shapes::disk(40, 6, 1.0).unwrap();
    let source = broken(&mesh, &zero_level(&mesh, |p| p[0].hypot(p[1]) - 0.51), 0.35, 0.15);
    let options = levels(LevelSets::Free).with_confidence(true);
    let solution = solver(&mesh, PAPER_TIME).solve(&source, &options).unwrap();
    let confidence = solution.confidence.unwrap();
    let segments = source.segments(&mesh).unwrap();
    let exact = |p: [f64; 3]| {
        segments
            .iter()
            .map(|s| distance_to_segment(p, s.ends[0].position(&mesh), s.ends[1].position(&mesh)))
            .fold(f64::INFINITY, f64::min)
    };
    let e = errors(&mesh, confidence.distance_to_data.as_slice(), exact);
    assert!(e.largest < 0.05, "{e:?}");
    for v in mesh.vertices() {
        let (p, c) = (mesh.position(v), confidence.confidence[v]);
        assert!((0.0..=1.0).contains(&c), "{v}: {c}");
        let off = (p[0].hypot(p[1]) - 0.51).abs();
        if off < 0.02 && exact(p) > 0.15 {
            assert!(c < 0.5, "in a gap, {v}: {c}");
        }
        if exact(p) < 0.05 && (off - exact(p)).abs() < 1e-4 {
            assert!(c > 0.7, "at the curve, {v}: {c}");
        }
    }
}

/// The constant does not depend on the weight: a tiny one reproduces the free fit, with mean zero
/// on the curve.
#[test]
fn soft_constant_at_tiny_weights() {
    let mesh = shapes::grid(150, 150, 150.0, 150.0, Diagonal::Alternating).unwrap();
    let source = zero_level(&mesh, |p| (p[0] - 75.0).hypot(p[1] - 75.0) - 5.2);
    let solver = solver(&mesh, PAPER_TIME);
    let with = |level_sets| solver.solve(&source, &levels(level_sets)).unwrap().distance.into_vec();
    let free = with(LevelSets::Free);
    for weight in [1e-9, 1e-7, 1e-5] {
        let off = largest_difference(&with(LevelSets::Soft(weight)), &free);
        assert!(off < 1e-3, "weight {weight:e}: off by {off}");
    }
}
