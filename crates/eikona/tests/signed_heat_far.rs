//! Distances far from the source, where the diffused vectors have underflowed.

mod exact;

use eikona::signed_heat::{DiffusionTime, LevelSets};
use eikona_mesh::{
    SurfaceCurves,
    shapes::{self, Diagonal},
};
use exact::*;

/// Largest relative error on a strip of unit squares, from the line x = 2, and the number of
/// stages.
fn strip(columns: usize, level_sets: LevelSets) -> (f64, usize) {
    let mesh = shapes::grid(columns, 10, columns as f64, 10.0, Diagonal::Alternating).unwrap();
    let curve = through_vertices(&mesh, |p| p[0] == 2.0, |p| p[1]);
    let solution = solve(&mesh, &SurfaceCurves::from_curve(curve), PAPER_TIME, level_sets);
    let worst = mesh
        .vertices()
        .map(|v| {
            let exact = mesh.position(v)[0] - 2.0; // upwards: the smaller x on the left
            (solution.distance[v] - exact).abs() / exact.abs().max(1.0)
        })
        .fold(0.0, f64::max);
    println!("{columns} columns, {level_sets:?}: {} stages, {worst:.1e}", solution.report.stages);
    assert!(!worst.is_nan() && solution.distance.as_slice().iter().all(|d| d.is_finite()));
    (worst, solution.report.stages)
}

#[test]
fn strip_of_1000_columns() {
    for level_sets in [LevelSets::Free, LevelSets::Zero] {
        let (worst, stages) = strip(1000, level_sets);
        assert!(worst < 1e-3 && stages > 1, "{worst}, {stages} stages");
    }
}

#[test]
fn strip_of_5000_columns() {
    assert!(strip(5000, LevelSets::Free).0 < 1e-3);
}

#[test]
fn strip_of_20000_columns() {
    assert!(strip(20000, LevelSets::Free).0 < 1e-3);
}

/// All diagonals in one direction, source across faces in the middle.
#[test]
fn line_across_the_faces_of_a_long_strip() {
    let mesh = shapes::grid(3000, 8, 3000.0, 8.0, Diagonal::Uniform).unwrap();
    let exact = |p: [f64; 3]| p[0] - 1500.3;
    let solution = solve(&mesh, &zero_level(&mesh, exact), PAPER_TIME, LevelSets::Free);
    let e = errors(&mesh, solution.distance.as_slice(), exact);
    assert!(e.largest < 1e-3, "{e:?}");
    assert!(solution.report.stages > 2);
}

/// A small circle around the pole of a sphere of 499,280 faces; the diffused vectors underflow long
/// before the other pole.
#[test]
fn tiny_circle_on_the_sphere() {
    let mesh = shapes::geodesic_sphere(158).unwrap();
    let exact = |p: [f64; 3]| p[2].clamp(-1.0, 1.0).asin() - 0.999f64.asin();
    let solution = solve(&mesh, &zero_level(&mesh, exact), PAPER_TIME, LevelSets::Free);
    let e = errors(&mesh, solution.distance.as_slice(), exact);
    println!("tiny circle: {} stages, {e:?}", solution.report.stages);
    assert!(solution.report.stages > 1, "no underflow");
    assert!(e.l2 <= 2e-3, "{e:?}");
}

/// Times far below h^2 follow the edges rather than the surface, so the distance is off by a few
/// percent; but it is never flat.
#[test]
fn tiny_time_underflows_and_stays_finite() {
    let mesh = shapes::geodesic_sphere(32).unwrap();
    let exact = |p: [f64; 3]| p[2].clamp(-1.0, 1.0).asin() - 0.99f64.asin();
    let source = zero_level(&mesh, exact);
    for coefficient in [1e-2, 1e-4, 1e-8] {
        let solution = solve(&mesh, &source, DiffusionTime::Coefficient(coefficient), LevelSets::Free);
        let e = errors(&mesh, solution.distance.as_slice(), exact);
        println!("coefficient {coefficient:e}: {} stages, {e:?}", solution.report.stages);
        assert!(e.l2 <= 0.15, "{coefficient:e}: {e:?}");
    }
}

/// Far from the source the gradient still has length 1.
#[test]
fn gradient_stays_unit_far_away() {
    let mesh = shapes::geodesic_sphere(71).unwrap();
    let source = zero_level(&mesh, |p| p[2] - 0.999);
    let solution = solve(&mesh, &source, DiffusionTime::Coefficient(0.05), LevelSets::Zero);
    let unit = mesh.faces().filter(|&f| (norm(solution.gradient[f]) - 1.0).abs() < 1e-12).count();
    assert!(unit == mesh.face_count(), "{unit} of {} faces", mesh.face_count());
}
