//! The automatic choices of the defaults. On broken curves with known distances, no explicit choice
//! is better (SHM section 9.5.3).

#[path = "../examples/broken_curves/breaking.rs"]
#[allow(dead_code)] // the example uses more kinds of damage
mod breaking;
mod exact;
#[path = "../examples/broken_curves/surfaces.rs"]
mod surfaces;
#[path = "../examples/broken_curves/truth.rs"]
#[allow(dead_code)] // the example uses more of it
mod truth;

use breaking::{Damage, Whole};
use eikona::geometry::{lay_out, mean_edge_length as mean_edge};
use eikona::signed_heat::{DiffusionTime, LevelSets, Solution, SolveOptions, Solver, SolverOptions};
use eikona_mesh::random::Random;
use eikona_mesh::{Curve, SurfaceCurves, TriangleMesh, Vertex, damage, shapes};
use exact::{broken, plate, reversed, rough_plate, unsigned, zero_level};
use truth::{Fine, error, vertex_areas};

fn default_solve(mesh: &TriangleMesh, source: &SurfaceCurves) -> Solution {
    let solver = Solver::new(mesh, &SolverOptions::default()).unwrap();
    solver.solve(source, &SolveOptions::default()).unwrap()
}

fn circle(mesh: &TriangleMesh, radius: f64) -> SurfaceCurves {
    zero_level(mesh, |p| (p[0] - 1.0).hypot(p[1] - 1.0) - radius)
}

fn together(sources: impl IntoIterator<Item = SurfaceCurves>) -> SurfaceCurves {
    let curves = sources.into_iter().flat_map(|s| s.curves).collect();
    SurfaceCurves { curves, points: Vec::new() }
}

#[test]
fn closed_curves_are_constrained_exactly() {
    let mesh = rough_plate(30);
    let closed = circle(&mesh, 0.51);
    let line = zero_level(&mesh, |p| p[0] - 0.93);
    // The same loop as single segments, in shuffled order and direction.
    let nodes = &closed.curves[0].nodes;
    let mut segments: Vec<Curve> = nodes.windows(2).map(|w| Curve::signed(w.iter().copied())).collect();
    segments.reverse();
    let segments = SurfaceCurves { curves: segments, points: Vec::new() };
    for (name, source) in [("closed", &closed), ("from rim to rim", &line), ("single segments", &segments)] {
        let found = default_solve(&mesh, source);
        assert_eq!(found.report.level_sets.level_sets, LevelSets::Zero, "{name}");
        assert_eq!(found.report.time.coefficient, 1.0, "{name}");
        let zero = exact::solve(&mesh, source, DiffusionTime::Coefficient(1.0), LevelSets::Zero);
        assert_eq!(found.distance.as_slice(), zero.distance.as_slice(), "{name}");
    }
}

#[test]
fn consistent_pieces_get_a_stiff_penalty() {
    let mesh = rough_plate(40);
    let whole = circle(&mesh, 0.51);
    let gaps = broken(&mesh, &whole, 0.1, 0.1);
    let found = default_solve(&mesh, &gaps);
    let chosen = &found.report.level_sets;
    assert!(matches!(chosen.level_sets, LevelSets::Soft(w) if w > 100.0), "{chosen:?}");
    assert!(chosen.reason.contains("gaps") && chosen.reason.contains("agree"), "{}", chosen.reason);
    assert_eq!(found.report.time.coefficient, 1.5);
    let missed = found.report.constraint_violation.unwrap();
    assert!(missed < 0.1 * exact::mean_edge_length(&mesh), "{missed}");
    // Asking for the weight in the report gives the same result.
    let time = DiffusionTime::Coefficient(1.5);
    let again = exact::solve(&mesh, &gaps, time, chosen.level_sets);
    assert!(exact::largest_difference(again.distance.as_slice(), found.distance.as_slice()) < 1e-9);
}

/// Two rings of pieces, one the offset of the other: zero on both would flatten the distance
/// between them.
#[test]
fn adjacent_pieces_hardly_change_the_slope() {
    let mesh = rough_plate(40);
    let edge = exact::mean_edge_length(&mesh);
    let rings = [0.5 - edge, 0.5 + edge].map(|r| broken(&mesh, &circle(&mesh, r), 0.3, 0.03));
    let source = together(rings);
    let found = default_solve(&mesh, &source);
    let chosen = &found.report.level_sets;
    let LevelSets::Soft(weight) = chosen.level_sets else { panic!("{chosen:?}") };
    assert!(chosen.reason.contains("contradict"), "{}", chosen.reason);
    // The force on the curves: the weight over the square root of the area, times the root mean
    // square along the curves.
    let levels: f64 =
        found.report.levels.iter().map(|l| l * l).sum::<f64>() / found.report.levels.len() as f64;
    let force = weight / 2.0 * levels.sqrt();
    assert!((0.07..0.23).contains(&force), "{force}");
    let slope = |values: &[f64]| {
        let at = |r: f64| {
            exact::vertex_areas(&mesh).iter().zip(mesh.positions()).zip(values).fold(
                [0.0; 2],
                |[sum, total], ((area, p), value)| {
                    let near = ((p[0] - 1.0).hypot(p[1] - 1.0) - r).abs() < 0.5 * edge;
                    if near { [sum + area * value, total + area] } else { [sum, total] }
                },
            )
        };
        let [inner, outer] = [at(0.5 - edge), at(0.5 + edge)].map(|[sum, total]| sum / total);
        (outer - inner) / (2.0 * edge)
    };
    let zero = exact::solve(&mesh, &source, DiffusionTime::Coefficient(2.0), LevelSets::Zero);
    let [held, flat] = [&found, &zero].map(|s| slope(s.distance.as_slice()));
    assert!(held > 0.6 && flat < 0.3, "{held} and {flat}");
}

#[test]
fn curves_at_different_levels_keep_their_levels() {
    let mesh = rough_plate(40);
    let rings = || [0.2, 0.5, 0.8].map(|r| circle(&mesh, r));
    let whole = together(rings());
    let gaps = together(rings().map(|ring| broken(&mesh, &ring, 0.2, 0.1)));
    for (name, source) in [("whole", &whole), ("broken", &gaps)] {
        let found = default_solve(&mesh, source);
        let chosen = &found.report.level_sets;
        assert_eq!(chosen.level_sets, LevelSets::PerComponent, "{name}: {}", chosen.reason);
        let radius = |p: [f64; 3]| (p[0] - 1.0).hypot(p[1] - 1.0);
        let time = DiffusionTime::Coefficient(found.report.time.coefficient);
        // Up to a constant, which puts the zero between the curves.
        let truth: Vec<f64> = mesh.positions().iter().map(|&p| radius(p)).collect();
        let off = |s: &Solution| error(&vertex_areas(&mesh), &truth, s.distance.as_slice(), true).rms;
        let free = off(&exact::solve(&mesh, source, time, LevelSets::Free));
        let zero = off(&exact::solve(&mesh, source, time, LevelSets::Zero));
        let found = off(&found);
        println!("{name}: {found:.4}, free {free:.4}, zero {zero:.4}");
        assert!(found < 1.05 * free && found < 0.3 * zero, "{name}: {found}, free {free}, zero {zero}");
    }
    // Two circles of opposite directions bound a ring: both are at zero.
    let ring = together([circle(&mesh, 0.8), reversed(&circle(&mesh, 0.4))]);
    assert_eq!(default_solve(&mesh, &ring).report.level_sets.level_sets, LevelSets::Zero);
}

/// Closed curves that cross bound regions together. The field turns between them, so the levels of
/// the free fit are meaningless.
#[test]
fn crossing_closed_curves_are_at_zero() {
    let mesh = rough_plate(40);
    let disk = |x: f64, y: f64, r: f64| zero_level(&mesh, |p| (p[0] - x).hypot(p[1] - y) - r);
    let large = || disk(0.6, 0.6, 0.5);
    let small = || disk(0.9, 0.6, 0.25);
    let apart = disk(1.1, 1.1, 0.15);
    for (name, source) in
        [("two", together([large(), small()])), ("three", together([large(), small(), apart]))]
    {
        let found = default_solve(&mesh, &source);
        let chosen = &found.report.level_sets;
        assert_eq!(chosen.level_sets, LevelSets::Zero, "{name}: {}", chosen.reason);
        // Positive outside the union of the disks; negative inside, far from the arc of the small
        // one.
        let off = |p: [f64; 3], [x, y, r]: [f64; 3]| (p[0] - x).hypot(p[1] - y) - r;
        for v in mesh.vertices() {
            let p = mesh.position(v);
            let [large, small] = [[0.6, 0.6, 0.5], [0.9, 0.6, 0.25]].map(|disk| off(p, disk));
            let apart = off(p, [1.1, 1.1, 0.15]);
            let d = found.distance[v];
            assert!(large.min(small).min(apart) < 0.05 || d > 0.0, "{name}: {d} at {p:?}");
            assert!(large > -0.05 || small < 0.2 || d < 0.0, "{name}: {d} at {p:?}");
        }
    }
}

/// A strip between two lines, and a disk that crosses one of them. The arc of the disk inside the
/// strip shifts the level of the other line in the free fit, which must not be taken for the level
/// of a nested curve.
#[test]
fn a_curve_beside_crossing_ones_is_at_zero() {
    let mesh = rough_plate(40);
    for (left, right, centre, radius) in
        [(0.25, 1.2, 0.4, 0.3), (0.33, 1.15, 0.08, 0.33), (0.2, 1.26, 0.31, 0.13)]
    {
        let to_strip = |p: [f64; 3]| (left - p[0]).max(p[0] - right);
        let to_disk = |p: [f64; 3]| (p[0] - centre).hypot(p[1] - 0.75) - radius;
        let lines = [zero_level(&mesh, |p| left - p[0]), zero_level(&mesh, |p| p[0] - right)];
        let found = default_solve(&mesh, &together(lines.into_iter().chain([zero_level(&mesh, to_disk)])));
        let chosen = &found.report.level_sets;
        assert_eq!(chosen.level_sets, LevelSets::Zero, "radius {radius}: {}", chosen.reason);
        for v in mesh.vertices() {
            let p = mesh.position(v);
            let (strip, disk, d) = (to_strip(p), to_disk(p), found.distance[v]);
            assert!(strip.min(disk) < 0.05 || d > 0.0, "radius {radius}: {d} at {p:?}");
            assert!(strip > -0.05 || disk < 0.2 || d < 0.0, "radius {radius}: {d} at {p:?}");
        }
    }
}

#[test]
fn points_and_unsigned_curves_are_at_zero() {
    let mesh = plate(12);
    let point = SurfaceCurves::from_point(Vertex(40));
    let open = unsigned(broken(&mesh, &circle(&mesh, 0.5), 0.3, 0.2));
    for source in [point, open] {
        let report = default_solve(&mesh, &source).report;
        assert_eq!(report.level_sets.level_sets, LevelSets::Zero);
        assert_eq!(report.time.coefficient, 1.0);
    }
}

/// Each component gets the constraint that it would get alone.
#[test]
fn components_are_chosen_separately() {
    let sphere = damage::jitter(&shapes::geodesic_sphere(14).unwrap(), 0.2, 4).unwrap();
    let far = sphere.with_positions(sphere.positions().iter().map(|p| [p[0] + 5.0, p[1], p[2]]).collect());
    let far = far.unwrap();
    let both = {
        let positions = [sphere.positions(), far.positions()].concat();
        let n = sphere.vertex_count() as u32;
        let moved = far.triangles().iter().map(|f| f.map(|v| v + n));
        TriangleMesh::new(positions, sphere.triangles().iter().copied().chain(moved).collect()).unwrap()
    };
    let whole = |mesh: &TriangleMesh, x: f64| {
        zero_level(mesh, |p| if (p[0] - x).abs() < 2.0 { p[2] - 0.3 } else { 1.0 })
    };
    let source = together([whole(&both, 0.0), broken(&both, &whole(&both, 5.0), 0.2, 0.1)]);
    let found = default_solve(&both, &source);
    assert!(found.report.level_sets.reason.contains("1 other component"), "{:?}", found.report.level_sets);
    let time = DiffusionTime::Coefficient(found.report.time.coefficient);
    let solver = |mesh: &TriangleMesh| Solver::new(mesh, &SolverOptions::default().with_time(time)).unwrap();
    let first = solver(&sphere).solve(&whole(&sphere, 0.0), &SolveOptions::default()).unwrap();
    let second = broken(&far, &whole(&far, 5.0), 0.2, 0.1);
    let second = solver(&far).solve(&second, &SolveOptions::default()).unwrap();
    let alone = [first.distance.into_vec(), second.distance.into_vec()].concat();
    let off = exact::largest_difference(&alone, found.distance.as_slice());
    assert!(off < 1e-7, "{off}");
}

/// Mean errors over curves with each kind of damage, for the default and for explicit choices.
#[test]
fn no_explicit_choice_is_much_better_than_the_default() {
    let coefficient = DiffusionTime::Coefficient;
    let automatic = (DiffusionTime::Automatic, LevelSets::Automatic);
    let others = [
        (coefficient(1.0), LevelSets::Zero),
        (coefficient(1.0), LevelSets::Free),
        (coefficient(3.0), LevelSets::PerComponent),
        (coefficient(3.0), LevelSets::Soft(3.0)),
        (coefficient(3.0), LevelSets::Soft(10.0)),
    ];
    let damages = [
        (Damage::None, 0.007, 0.001),
        (Damage::OneGap(0.1), 0.009, 0.002),
        (Damage::Halved(4.0), 0.011, 0.003),
        (Damage::Halved(10.0), 0.016, 0.007),
        (Damage::HalvedNoise(8.0, 0.3), 0.022, 0.009),
        (Damage::WithOffsets(8.0, 1.0), 0.012, 0.009),
        (Damage::WithOffsets(8.0, 2.0), 0.017, 0.014),
        (Damage::Nested(8.0, 0.2), 0.025, 0.0),
    ];
    let mut table = vec![vec![[0.0; 2]; 1 + others.len()]; damages.len()];
    let mut cases = 0.0;
    for (_, mesh) in surfaces::surfaces().iter().take(6) {
        let (edge, areas, fine) = (mean_edge(mesh, &lay_out(mesh)), vertex_areas(mesh), Fine::new(mesh));
        let mut times: Vec<DiffusionTime> =
            others.iter().map(|(time, _)| *time).chain([automatic.0]).collect();
        times.dedup();
        let solvers: Vec<(DiffusionTime, Solver)> = times
            .into_iter()
            .map(|time| (time, Solver::new(mesh, &SolverOptions::default().with_time(time)).unwrap()))
            .collect();
        for (k, (_, function)) in surfaces::eigenfunctions(mesh, 2).iter().enumerate() {
            let mut random = Random::from_seed(31 + k as u64);
            let mut sorted = function.clone();
            sorted.sort_by(f64::total_cmp);
            let level = sorted[(random.range(0.2, 0.8) * sorted.len() as f64) as usize] + 1e-9;
            let distance = fine.distance(function, level);
            let whole = Whole { mesh, distance: &distance, edge };
            cases += 1.0;
            for ((damage, ..), row) in damages.iter().zip(&mut table) {
                let source =
                    SurfaceCurves { curves: whole.damaged(*damage, &mut random), points: Vec::new() };
                for ((time, level_sets), cell) in [automatic].iter().chain(&others).zip(row) {
                    let solver = &solvers.iter().find(|(t, _)| t == time).unwrap().1;
                    let options = SolveOptions::default().with_level_sets(*level_sets);
                    let found = solver.solve(&source, &options).unwrap().distance;
                    let nested = matches!(damage, Damage::Nested(..));
                    let e = error(&areas, &distance, found.as_slice(), nested);
                    *cell = [cell[0] + e.rms, cell[1] + e.wrong];
                }
            }
        }
    }
    println!("{cases} curves; root mean square and share of wrong area, default first");
    for ((damage, rms, wrong), row) in damages.iter().zip(table) {
        let row: Vec<[f64; 2]> = row.into_iter().map(|cell| cell.map(|sum| sum / cases)).collect();
        let text: String = row.iter().map(|[rms, wrong]| format!("  {rms:.4} {wrong:.4}")).collect();
        println!("{:28}{text}", format!("{damage:?}"));
        assert!(row[0][0] < *rms && row[0][1] <= *wrong, "{damage:?}: {:?}", row[0]);
        for other in &row[1..] {
            assert!(row[0][0] < 1.12 * other[0], "{damage:?}: {row:?}");
            assert!(row[0][1] < 1.1 * other[1] + 0.001, "{damage:?}: {row:?}");
        }
    }
}
