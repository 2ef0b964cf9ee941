//! Thin faces: how exact their angles are, what is computed on them, and what is said.

use eikona::geometry::Triangle;
use eikona::signed_heat::{SignedHeatError, SolveOptions, Solver, SolverOptions};
use eikona_mesh::{Curve, Face, SurfaceCurves, SurfacePoint, TriangleMesh, Vertex, shapes};

/// reports.md F26: a strip of 40 columns of this width, 1 high.
fn strip(width: f64) -> TriangleMesh {
    shapes::grid(40, 1, 40.0 * width, 1.0, shapes::Diagonal::Alternating).unwrap()
}

/// The line at half the height, through all faces, from small x to large.
fn middle(mesh: &TriangleMesh) -> SurfaceCurves {
    let across = |e: &eikona_mesh::Edge| {
        let [a, b] = mesh.edge_vertices(*e).map(|v| mesh.position(v)[1]);
        a != b
    };
    let x = |e: &eikona_mesh::Edge| {
        let [a, b] = mesh.edge_vertices(*e).map(|v| mesh.position(v)[0]);
        a + b
    };
    let mut edges: Vec<_> = mesh.edges().filter(across).collect();
    edges.sort_by(|a, b| x(a).total_cmp(&x(b)));
    let node = |e| SurfacePoint::Edge { vertices: mesh.edge_vertices(e).map(|v| v.0), t: 0.5 };
    SurfaceCurves::from_curve(Curve::signed(edges.into_iter().map(node)))
}

/// The largest error on the strip, and the warnings.
fn solved(width: f64) -> (f64, Vec<String>) {
    let mesh = strip(width);
    let solver = Solver::new(&mesh, &SolverOptions::default()).unwrap();
    let solution = solver.solve(&middle(&mesh), &SolveOptions::default()).unwrap();
    let error = |v: Vertex| (solution.distance[v] - (0.5 - mesh.position(v)[1])).abs();
    let error = mesh.vertices().map(error).fold(0.0, f64::max);
    (error, solution.report.all_warnings().map(|w| w.to_string()).collect())
}

#[test]
fn thin_faces_keep_the_digits_of_their_cotangents() {
    // A right triangle of legs 1 and w, laid along the axes and turned: cotangents 0, w and 1 / w. From lengths alone the second
    // would be off by 1e-16 / w.
    for w in [1e-3, 1e-5, 1e-7] {
        for turn in [0.0f64, 0.4] {
            let place =
                |x: f64, y: f64| [x * turn.cos() - y * turn.sin(), x * turn.sin() + y * turn.cos(), 0.0];
            let positions = vec![place(0.0, 0.0), place(w, 0.0), place(0.0, 1.0)];
            let mesh = TriangleMesh::new(positions, vec![[0, 1, 2]]).unwrap();
            let t = Triangle::of_face(&mesh, Face(0));
            // The coordinates are rounded where they are turned, by 1e-16 of their size.
            let exact = 1e-15 / w;
            assert!(!t.mollified && t.cotangent(0).abs() < 1e-15, "{w} {turn} {}", t.cotangent(0));
            assert!((t.cotangent(2) * w - 1.0).abs() < 10.0 * exact);
            assert!((t.cotangent(1) / w - 1.0).abs() < 10.0 * exact, "{w} {turn} {}", t.cotangent(1));
            assert!((t.area / (0.5 * w) - 1.0).abs() < 10.0 * exact);
        }
    }
}

#[test]
fn distances_on_slivers_are_right_or_warned_of() {
    for width in [1e-2, 1e-4, 1e-5] {
        let (error, warnings) = solved(width);
        assert!(error < 1e-6, "width {width}: {error}");
        assert_eq!(warnings, [""; 0], "width {width}");
    }
    for width in [1e-6, 3e-7, 1e-7, 5e-8] {
        let (error, warnings) = solved(width);
        let [warning] = &warnings[..] else { panic!("width {width}: {error} {warnings:?}") };
        assert!(warning.starts_with("80 slivers (first: 0): distances"), "{warning}");
        // What is said is right to an order of magnitude; rounding is no better known.
        let said: f64 = warning.split("about ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        assert!(error < 12.0 * said, "width {width}: {error}, but {warning}");
    }
}

#[test]
fn a_mesh_of_flat_faces_only_is_refused_without_a_word_of_zero_area() {
    // reports.md F26: at 5e-9 every face has an area, of 2.5e-9.
    let refused = Solver::new(&strip(5e-9), &SolverOptions::default()).unwrap_err();
    assert_eq!(refused, SignedHeatError::NoArea);
    let text = refused.to_string();
    assert!(text.contains("a height below 1e-8 of its longest edge") && text.contains("remesh"), "{text}");
}

#[test]
fn a_few_slivers_in_a_good_mesh_lose_nothing_that_is_worth_a_warning() {
    // A grid of unit squares with one vertex beside another, 1e-7 away: two faces of that height.
    let mesh = shapes::grid(6, 4, 6.0, 4.0, shapes::Diagonal::Alternating).unwrap();
    let inner = mesh.vertices().find(|v| mesh.position(*v) == [3.0, 2.0, 0.0]).unwrap();
    let mut positions = mesh.positions().to_vec();
    positions.push([3.0 + 1e-7, 2.0, 0.0]);
    let new = positions.len() as u32 - 1;
    // Faces on the right of the vertex go to the new one; two slivers join both.
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
fn degenerate_faces_are_counted_with_the_first_of_them() {
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
    let warnings = solver.solve(&source, &SolveOptions::default()).unwrap().report;
    let warnings: Vec<_> = warnings.all_warnings().collect();
    let expected = "1 degenerate face (first: 80); edge lengths were perturbed by at most 1e-7 of the longest edge of each";
    assert!(warnings.contains(&expected), "{warnings:?}");
}

#[test]
fn points_at_all_vertices_give_no_warning_of_level_sets() {
    // reports.md C: "level sets are held but for 1.1e-18".
    for n in [1, 5] {
        let mesh = shapes::grid(n, n, 1.0, 1.0, shapes::Diagonal::Alternating).unwrap();
        let points = mesh.vertices().map(SurfacePoint::from).collect();
        let source = SurfaceCurves { curves: Vec::new(), points };
        let solver = Solver::new(&mesh, &SolverOptions::default()).unwrap();
        let solution = solver.solve(&source, &SolveOptions::default()).unwrap();
        assert_eq!(solution.report.all_warnings().map(|w| w.to_string()).collect::<Vec<_>>(), [""; 0]);
        assert!(solution.distance.as_slice().iter().all(|d| d.abs() < 1e-15));
    }
}
