//! Thin faces: accuracy of their angles and of distances on them, and warnings.

mod exact;

use eikona::Warning;
use eikona::geometry::Triangle;
use eikona::signed_heat::{LevelSets, SignedHeatError, SolveOptions, Solver, SolverOptions};
use eikona_mesh::{Curve, Face, SurfaceCurves, SurfacePoint, TriangleMesh, Vertex, shapes};
use exact::zero_level;

/// A strip of 40 columns of this width, 1 high.
fn strip(width: f64) -> TriangleMesh {
    cells(40, 1, width)
}

/// A strip of columns of this width, of height 1 divided into `rows`.
fn cells(columns: usize, rows: usize, width: f64) -> TriangleMesh {
    shapes::grid(columns, rows, columns as f64 * width, 1.0, shapes::Diagonal::Alternating).unwrap()
}

/// Largest error of the distance to a line across a mesh of height 1, and the warnings.
fn solved(mesh: &TriangleMesh, level_sets: LevelSets) -> (f64, Vec<Warning>) {
    let line = 0.45;
    let source = zero_level(mesh, |p| p[1] - line);
    let solver = Solver::new(mesh, &SolverOptions::default()).unwrap();
    let options = SolveOptions::default().with_level_sets(level_sets);
    let solution = solver.solve(&source, &options).unwrap();
    let error = |v: Vertex| (solution.distance[v].abs() - (line - mesh.position(v)[1]).abs()).abs();
    let error = mesh.vertices().map(error).fold(0.0, |m, e| if e.is_nan() { e } else { f64::max(m, e) });
    (error, solution.report.all_warnings().cloned().collect())
}

#[test]
fn thin_faces_keep_the_digits_of_their_cotangents() {
    // A right triangle of legs 1 and w, along the axes and rotated: cotangents 0, w and 1 / w. From
    // lengths alone the error of the second would be 1e-16 / w.
    for w in [1e-3, 1e-5, 1e-7] {
        for turn in [0.0f64, 0.4] {
            let place =
                |x: f64, y: f64| [x * turn.cos() - y * turn.sin(), x * turn.sin() + y * turn.cos(), 0.0];
            let positions = vec![place(0.0, 0.0), place(w, 0.0), place(0.0, 1.0)];
            let mesh = TriangleMesh::new(positions, vec![[0, 1, 2]]).unwrap();
            let t = Triangle::of_face(&mesh, Face(0));
            // Rotating rounds the coordinates by 1e-16 of their size.
            let exact = 1e-15 / w;
            assert!(!t.mollified && t.cotangent(0).abs() < 1e-15, "{w} {turn} {}", t.cotangent(0));
            assert!((t.cotangent(2) * w - 1.0).abs() < 10.0 * exact);
            assert!((t.cotangent(1) / w - 1.0).abs() < 10.0 * exact, "{w} {turn} {}", t.cotangent(1));
            assert!((t.area / (0.5 * w) - 1.0).abs() < 10.0 * exact);
        }
    }
}

#[test]
fn distances_on_slivers_keep_their_digits() {
    // Without refinement the errors grow to 0.3. Mild slivers are not refined and keep eight
    // digits.
    let all = [
        LevelSets::Automatic,
        LevelSets::Zero,
        LevelSets::PerComponent,
        LevelSets::Free,
        LevelSets::Soft(3.0),
    ];
    for (columns, rows) in [(40, 1), (40, 2), (40, 5), (200, 20)] {
        for width in [1e-2, 1e-4, 1e-5, 1e-6, 3e-7, 1e-7, 5e-8, 3e-8] {
            for level_sets in all {
                let (error, warnings) = solved(&cells(columns, rows, width), level_sets);
                let name = format!("{columns} x {rows}, width {width}, {level_sets:?}");
                assert!(error < 1e-8, "{name}: {error}");
                assert_eq!(warnings, [], "{name}");
            }
        }
    }
}

#[test]
fn errors_that_refinement_leaves_raise_a_warning() {
    let (error, warnings) = solved(&cells(400, 100, 1.5e-8), LevelSets::Free);
    assert!(
        matches!(warnings[..], [Warning::SliverErrors { count: 80000, first: Face(0), .. }]),
        "{error} {warnings:?}"
    );
    assert!(error > 1e-3, "no error to warn about: {error}");
}

#[test]
fn mesh_of_flat_faces_is_refused_by_height() {
    // At a width of 5e-9 every face has a nonzero area, 2.5e-9.
    let refused = Solver::new(&strip(5e-9), &SolverOptions::default()).unwrap_err();
    assert_eq!(refused, SignedHeatError::NoArea);
    let text = refused.to_string();
    assert!(text.contains("a height below 1e-8 of its longest edge") && text.contains("remesh"), "{text}");
}

#[test]
fn few_slivers_in_a_good_mesh_raise_no_warning() {
    // A grid of unit squares with a second vertex 1e-7 away from one of them: two faces of that
    // height.
    let mesh = shapes::grid(6, 4, 6.0, 4.0, shapes::Diagonal::Alternating).unwrap();
    let inner = mesh.vertices().find(|v| mesh.position(*v) == [3.0, 2.0, 0.0]).unwrap();
    let mut positions = mesh.positions().to_vec();
    positions.push([3.0 + 1e-7, 2.0, 0.0]);
    let new = positions.len() as u32 - 1;
    // Faces on the right of the vertex use the new one; two slivers connect both.
    let center = |f: &[u32; 3]| f.iter().map(|v| mesh.position(Vertex(*v))[0]).sum::<f64>() / 3.0;
    let mut faces = Vec::new();
    for f in mesh.triangles() {
        let on_right = f.contains(&inner.0) && center(f) > 3.0;
        faces.push(if on_right { f.map(|v| if v == inner.0 { new } else { v }) } else { *f });
    }
    let above = mesh.vertices().find(|v| mesh.position(*v) == [3.0, 3.0, 0.0]).unwrap();
    let below = mesh.vertices().find(|v| mesh.position(*v) == [3.0, 1.0, 0.0]).unwrap();
    faces.extend([[inner.0, new, above.0], [new, inner.0, below.0]]);
    let mesh = TriangleMesh::new(positions, faces).unwrap();
    let line: Vec<Vertex> = mesh.vertices().filter(|v| mesh.position(*v)[0] == 1.0).collect();
    let solver = Solver::new(&mesh, &SolverOptions::default()).unwrap();
    let solution =
        solver.solve(&SurfaceCurves::from_curve(Curve::signed(line)), &SolveOptions::default()).unwrap();
    assert_eq!(solution.report.all_warnings().count(), 0);
    for v in mesh.vertices() {
        assert!(
            (solution.distance[v] - (mesh.position(v)[0] - 1.0)).abs() < 1e-7,
            "{v} {}",
            solution.distance[v]
        );
    }
}

#[test]
fn degenerate_faces_are_counted_and_the_first_named() {
    let mut positions = strip(1.0).positions().to_vec();
    positions.push([0.5, 0.0, 0.0]);
    let new = positions.len() as u32 - 1;
    let strip = strip(1.0);
    let [a, b] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
        .map(|p| strip.vertices().find(|v| strip.position(*v) == p).unwrap().0);
    let mut faces = strip.triangles().to_vec();
    faces.push([a, new, b]);
    let mesh = TriangleMesh::new(positions, faces).unwrap();
    let solver = Solver::new(&mesh, &SolverOptions::default()).unwrap();
    let source = SurfaceCurves::from_point(Vertex(a));
    let report = solver.solve(&source, &SolveOptions::default()).unwrap().report;
    let warnings: Vec<&Warning> = report.all_warnings().collect();
    assert_eq!(warnings, [&Warning::DegenerateFaces { count: 1, first: Face(80) }]);
    assert_eq!(
        warnings[0].to_string(),
        "1 degenerate face (first: face 80); edge lengths were perturbed by at most 1e-7 of the longest edge of each"
    );
}

#[test]
fn points_at_all_vertices_raise_no_warning() {
    // A regression: violations of 1.1e-18 once raised a warning.
    for n in [1, 5] {
        let mesh = shapes::grid(n, n, 1.0, 1.0, shapes::Diagonal::Alternating).unwrap();
        let points = mesh.vertices().map(SurfacePoint::from).collect();
        let source = SurfaceCurves { curves: Vec::new(), points };
        let solver = Solver::new(&mesh, &SolverOptions::default()).unwrap();
        let solution = solver.solve(&source, &SolveOptions::default()).unwrap();
        assert_eq!(solution.report.all_warnings().next(), None);
        assert!(solution.distance.as_slice().iter().all(|d| d.abs() < 1e-15));
    }
}
