//! The signed heat method at the ends of the range of doubles. Found by fuzzing: areas overflowed
//! for sides from 1e77 up, and lost digits from 1e-80 down.

use eikona::mesh::{Curve, SurfaceCurves, TriangleMesh, Vertex, shapes};
use eikona::signed_heat::{LevelSets, SignedHeatError, SolveOptions, Solver, SolverOptions};

/// A grid of 6 x 6 squares of this size, and the line across its middle.
fn grid(size: f64) -> (TriangleMesh, SurfaceCurves) {
    let unit = shapes::grid(6, 6, 6.0, 6.0, shapes::Diagonal::Alternating).unwrap();
    let curve = Curve::signed(unit.vertices().filter(|v: &Vertex| unit.position(*v)[0] == 3.0));
    let positions = unit.positions().iter().map(|p| p.map(|x| x * size)).collect();
    (unit.with_positions(positions).unwrap(), SurfaceCurves::from_curve(curve))
}

#[test]
fn sizes_from_1e_minus_90_to_1e90_give_scaled_results() {
    for size in [1e-90, 1e-80, 1.0, 1e80, 1e90] {
        let (mesh, curve) = grid(size);
        let solver = Solver::new(&mesh, &SolverOptions::default()).unwrap();
        for level_sets in [LevelSets::Free, LevelSets::Zero, LevelSets::PerComponent, LevelSets::Soft(1.0)] {
            let options = SolveOptions::default().with_level_sets(level_sets).with_confidence(true);
            let solution = solver.solve(&curve, &options).unwrap();
            let confidence = solution.confidence.unwrap();
            for v in mesh.vertices() {
                let expected = mesh.position(v)[0] / size - 3.0;
                let distance = solution.distance[v] / size;
                assert!((distance - expected).abs() < 1e-12, "{size:e} {level_sets:?} {v}: {distance}");
                let to_data = confidence.distance_to_data[v] / size;
                assert!((to_data - expected.abs()).abs() < 1e-12, "{size:e} {v}: distance to data {to_data}");
            }
        }
    }
}

#[test]
fn sizes_out_of_range_are_refused() {
    for size in [1e-110, 1e110] {
        let refusal = Solver::new(&grid(size).0, &SolverOptions::default()).unwrap_err();
        assert!(matches!(refusal, SignedHeatError::Scale { .. }), "{size:e}: {refusal}");
    }
}
