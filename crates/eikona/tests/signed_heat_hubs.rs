//! Vertices and edges with very many faces: no cost grows with the square of their number.

use eikona::mesh::{Curve, SurfaceCurves, TriangleMesh, Vertex};
use eikona::signed_heat::{SolveOptions, Solver, SolverOptions};
use std::f64::consts::TAU;

/// Triangles around one common edge, from (0, 0, 0) to (0, 0, 1).
fn book(pages: usize) -> TriangleMesh {
    let mut positions = vec![[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    positions.extend((0..pages).map(|i| {
        let angle = TAU * i as f64 / pages as f64;
        [angle.cos(), angle.sin(), 0.5]
    }));
    let faces = (0..pages as u32).map(|i| [0, 1, i + 2]).collect();
    TriangleMesh::new(positions, faces).unwrap()
}

#[test]
fn factor_of_a_book_is_linear_in_its_pages() {
    let solve = |pages: usize| {
        let mesh = book(pages);
        let solver = Solver::new(&mesh, &SolverOptions::default()).unwrap();
        solver.solve(&SurfaceCurves::from_point(Vertex(0)), &SolveOptions::default()).unwrap()
    };
    let (small, large) = (solve(500), solve(2000));
    let bytes = |s: &eikona::signed_heat::Solution| s.report.preparation.factor_bytes as f64;
    assert!(small.report.preparation.real_frames);
    assert!(bytes(&large) < 5.0 * bytes(&small), "{} and {} bytes", bytes(&small), bytes(&large));
    // The result is the same on all pages.
    let outer = &large.distance.as_slice()[2..];
    assert!(outer.iter().all(|d| (d - outer[0]).abs() < 1e-9 && *d > 0.0));
}

#[test]
fn unsigned_star_at_a_hub_of_many_faces() {
    let n = 20_000;
    let mut positions = vec![[0.0; 3]];
    positions.extend((0..n).map(|i| {
        let angle = TAU * i as f64 / n as f64;
        [angle.cos(), angle.sin(), 0.0]
    }));
    let faces = (0..n as u32).map(|i| [0, i + 1, (i + 1) % n as u32 + 1]).collect();
    let mesh = TriangleMesh::new(positions, faces).unwrap();
    // Back and forth along every hundredth spoke: the hub is an end of 400 segments, and the rim is
    // one curve.
    let spokes = (0..n as u32).step_by(100).map(|i| Curve::unsigned([Vertex(0), Vertex(i + 1)]));
    let rim = Curve::unsigned((0..=n as u32).map(|i| Vertex(i % n as u32 + 1)));
    let source = SurfaceCurves { curves: spokes.chain([rim]).collect(), points: Vec::new() };
    let solver = Solver::new(&mesh, &SolverOptions::default()).unwrap();
    let solution = solver.solve(&source, &SolveOptions::default()).unwrap();
    assert!(solution.distance.as_slice().iter().all(|d| d.abs() < 1e-6), "every vertex is on the source");
}
