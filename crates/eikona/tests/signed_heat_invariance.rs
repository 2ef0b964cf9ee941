//! Invariance of the result under changes of numbering, scale, position and orientation.

mod exact;

use eikona::numeric::NumericError;
use eikona::signed_heat::{
    DiffusionTime, LevelSets, SignConvention, SignedHeatError, Solution, SolveOptions, Solver, SolverOptions,
    signed_distance,
};
use eikona_mesh::{
    Curve, SurfaceCurves, SurfacePoint, TriangleMesh, Vertex, VertexField, damage,
    shapes::{self, Diagonal},
};
use exact::*;

const ALL_LEVEL_SETS: [LevelSets; 5] =
    [LevelSets::Automatic, LevelSets::Free, LevelSets::Zero, LevelSets::PerComponent, LevelSets::Soft(5.0)];

/// An irregular torus with a closed curve across faces, an open one along edges, an unsigned one
/// and a point.
fn scene() -> (TriangleMesh, SurfaceCurves) {
    let mesh = damage::jitter(&shapes::torus(1.0, 0.45, 40, 20).unwrap(), 0.2, 8).unwrap();
    let mut source = zero_level(&mesh, |p| p[0] + 0.2 * p[2] - 0.3);
    let mut other = zero_level(&mesh, |p| p[0] + 0.1 * p[1] + 0.5);
    other.curves.truncate(1);
    other.curves[0].nodes.truncate(12);
    source.curves.extend(unsigned(other).curves);
    source.points.push(Vertex(5).into());
    source.points.push(SurfacePoint::Face { vertices: mesh.triangles()[700], bary: [0.2, 0.5, 0.3] });
    (mesh, source)
}

fn signed_only(mut source: SurfaceCurves) -> SurfaceCurves {
    source.curves.retain(|c| c.kind == eikona_mesh::CurveKind::Signed);
    source.points.clear();
    source
}

/// Carries the curves to a mesh whose vertex `number[v]` is vertex v of the old one.
fn renumbered(source: &SurfaceCurves, number: &VertexField<u32>) -> SurfaceCurves {
    let new = |v: u32| number[Vertex(v)];
    let place = |p: &SurfacePoint| match *p {
        SurfacePoint::Vertex { vertex } => SurfacePoint::Vertex { vertex: new(vertex) },
        SurfacePoint::Edge { vertices, t } => SurfacePoint::Edge { vertices: vertices.map(new), t },
        SurfacePoint::Face { vertices, bary } => SurfacePoint::Face { vertices: vertices.map(new), bary },
    };
    SurfaceCurves {
        curves: source
            .curves
            .iter()
            .map(|c| Curve { nodes: c.nodes.iter().map(place).collect(), ..c.clone() })
            .collect(),
        points: source.points.iter().map(place).collect(),
    }
}

fn assert_same(name: &str, a: &[f64], b: &[f64], tolerance: f64) {
    let difference = largest_difference(a, b) / largest(a);
    assert!(difference <= tolerance, "{name}: {difference:e}");
    assert!(largest(a) > 0.0, "{name}: all zero");
}

#[test]
fn reversed_curves_negate_the_distance() {
    let (mesh, source) = scene();
    let source = signed_only(source);
    for level_sets in ALL_LEVEL_SETS {
        let solver = solver(&mesh, PAPER_TIME);
        let there = solver.solve(&source, &levels(level_sets)).unwrap().distance.into_vec();
        let back = solver.solve(&reversed(&source), &levels(level_sets)).unwrap().distance.into_vec();
        let negated: Vec<f64> = back.iter().map(|x| -x).collect();
        assert_same(&format!("{level_sets:?}"), &there, &negated, 1e-7);
        let left_positive = levels(level_sets).with_sign(SignConvention::LeftPositive);
        let other = solver.solve(&source, &left_positive).unwrap().distance.into_vec();
        let negated: Vec<f64> = other.iter().map(|x| -x).collect();
        assert_same(&format!("left positive, {level_sets:?}"), &there, &negated, 1e-12);
    }
}

/// A loop that is counter-clockwise seen from outside has a negative inside; a positive one with
/// the convention of other programs.
#[test]
fn left_of_a_curve_is_negative() {
    let mesh = shapes::grid(4, 4, 4.0, 4.0, Diagonal::Uniform).unwrap();
    let v = |x: u32, y: u32| Vertex(5 * x + y);
    assert_eq!(mesh.position(v(3, 1)), [3.0, 1.0, 0.0]);
    let ring = [v(1, 1), v(2, 1), v(3, 1), v(3, 2), v(3, 3), v(2, 3), v(1, 3), v(1, 2), v(1, 1)];
    let source = SurfaceCurves::from_curve(Curve::signed(ring));
    let inside = v(2, 2);
    let solver = solver(&mesh, PAPER_TIME);
    assert!(solver.solve(&source, &SolveOptions::default()).unwrap().distance[inside] < -0.5);
    assert!(solver.solve(&source, &SolveOptions::default()).unwrap().distance[v(0, 0)] > 0.5);
    let left_positive = SolveOptions::default().with_sign(SignConvention::LeftPositive);
    assert!(solver.solve(&source, &left_positive).unwrap().distance[inside] > 0.5);
}

#[test]
fn scale_changes_nothing_but_the_unit() {
    let (mesh, source) = scene();
    for time in [PAPER_TIME, DiffusionTime::Automatic] {
        for level_sets in ALL_LEVEL_SETS {
            let before = solve(&mesh, &source, time, level_sets).distance.into_vec();
            for scale in [1e-8, 1e8] {
                let positions = mesh.positions().iter().map(|p| p.map(|x| scale * x)).collect();
                let scaled = mesh.with_positions(positions).unwrap();
                let after = solve(&scaled, &source, time, level_sets).distance.into_vec();
                let after: Vec<f64> = after.iter().map(|x| x / scale).collect();
                assert_same(&format!("{time:?}, {level_sets:?}, scale {scale:e}"), &before, &after, 1e-9);
            }
        }
    }
}

#[test]
fn numbering_changes_nothing() {
    let (mesh, source) = scene();
    let shuffled = damage::shuffle(&mesh, 17).unwrap();
    let mut number = VertexField::constant(mesh.vertex_count(), 0);
    for (new, &old) in shuffled.source_vertex.iter() {
        number[old] = new.0;
    }
    let moved = renumbered(&source, &number);
    for level_sets in ALL_LEVEL_SETS {
        let before = solve(&mesh, &source, PAPER_TIME, level_sets).distance;
        let after = solve(&shuffled.mesh, &moved, PAPER_TIME, level_sets).distance;
        let after: Vec<f64> = mesh.vertices().map(|v| after[Vertex(number[v])]).collect();
        // Constrained fits stop at a tolerance; free ones are direct.
        assert_same(&format!("{level_sets:?}"), before.as_slice(), &after, tolerance(level_sets));
    }
}

fn tolerance(level_sets: LevelSets) -> f64 {
    match level_sets {
        LevelSets::Free | LevelSets::Soft(_) => 1e-10,
        LevelSets::Automatic | LevelSets::Zero | LevelSets::PerComponent => 1e-6,
    }
}

#[test]
fn rigid_motion_changes_nothing() {
    let (mesh, source) = scene();
    let (c, s) = (0.6, 0.8);
    let rotated = |p: [f64; 3]| {
        let q = [c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]];
        [q[0] + 3.0, c * q[1] - s * q[2] - 2.0, s * q[1] + c * q[2] + 0.5]
    };
    let moved = mesh.with_positions(mesh.positions().iter().map(|&p| rotated(p)).collect()).unwrap();
    for level_sets in ALL_LEVEL_SETS {
        let before = solve(&mesh, &source, PAPER_TIME, level_sets).distance;
        let after = solve(&moved, &source, PAPER_TIME, level_sets).distance;
        assert_same(&format!("{level_sets:?}"), before.as_slice(), after.as_slice(), tolerance(level_sets));
    }
}

/// A plate that is rolled up isometrically has the same distances.
#[test]
fn bending_changes_nothing() {
    let plate = shapes::grid(30, 12, 3.0, 1.2, Diagonal::Alternating).unwrap();
    // Along x, a polygon with chords of one column each: every square stays a square, with its
    // diagonal.
    let step = 0.1 / (2.0 * (0.05f64).sin());
    let rolled = |p: [f64; 3]| {
        let turn = (p[0] / 0.1).round() * 0.1;
        [step * turn.cos(), p[1], step * turn.sin()]
    };
    let bent = plate.with_positions(plate.positions().iter().map(|&p| rolled(p)).collect()).unwrap();
    let source = zero_level(&plate, |p| (p[0] - 1.0).hypot(p[1] - 0.5) - 0.37);
    for level_sets in ALL_LEVEL_SETS {
        let flat = solve(&plate, &source, PAPER_TIME, level_sets).distance;
        let rolled = solve(&bent, &source, PAPER_TIME, level_sets).distance;
        assert_same(&format!("{level_sets:?}"), flat.as_slice(), rolled.as_slice(), tolerance(level_sets));
    }
}

#[test]
fn flipped_faces_change_nothing() {
    let (mesh, source) = scene();
    for share in [0.01, 0.3, 0.45] {
        let flipped = damage::flip_faces(&mesh, share, 21).unwrap().mesh;
        for level_sets in ALL_LEVEL_SETS {
            let before = solve(&mesh, &source, PAPER_TIME, level_sets);
            let after = solve(&flipped, &source, PAPER_TIME, level_sets);
            let name = format!("{share} flipped, {level_sets:?}");
            assert_same(&name, before.distance.as_slice(), after.distance.as_slice(), tolerance(level_sets));
            let warned = after.report.all_warnings().any(|w| w.kind() == "faces_flipped");
            assert!(warned, "{name}: no warning");
            assert!(!after.report.preparation.real_frames);
        }
    }
}

/// The same with the real form: a band that is orientable except for one nonmanifold fin far from
/// the source.
#[test]
fn flipped_faces_change_nothing_in_the_real_form() {
    let grid = shapes::grid(12, 4, 12.0, 4.0, Diagonal::Alternating).unwrap();
    let (mut positions, mut faces) = (grid.positions().to_vec(), grid.triangles().to_vec());
    // The fin stands on the edge from (10, 2) to (11, 2).
    let on = |x: f64, y: f64| grid.positions().iter().position(|p| p[0] == x && p[1] == y).unwrap() as u32;
    positions.push([10.5, 2.0, 1.0]);
    faces.push([on(10.0, 2.0), on(11.0, 2.0), positions.len() as u32 - 1]);
    let mesh = TriangleMesh::new(positions, faces).unwrap();
    let source = zero_level(&mesh, |p| 0.9 * (p[0] - 3.3) + 0.1 * p[1]);
    let before = solve(&mesh, &source, PAPER_TIME, LevelSets::Free);
    assert!(before.report.preparation.real_frames);
    for seed in 0..3 {
        let flipped = damage::flip_faces(&mesh, 0.3, seed).unwrap().mesh;
        let after = solve(&flipped, &source, PAPER_TIME, LevelSets::Free);
        assert_same(&format!("seed {seed}"), before.distance.as_slice(), after.distance.as_slice(), 1e-9);
    }
}

fn same_bits(a: &Solution, b: &Solution) -> bool {
    let bits = |s: &Solution| -> Vec<u64> { s.distance.as_slice().iter().map(|x| x.to_bits()).collect() };
    bits(a) == bits(b)
}

#[test]
fn threads_and_repetition_give_the_same_bits() {
    let (mesh, source) = scene();
    let with = |threads| Solver::new(&mesh, &SolverOptions::default().with_threads(threads)).unwrap();
    let (one, two) = (with(1), with(2));
    for level_sets in ALL_LEVEL_SETS {
        let options = levels(level_sets).with_preserve_source_normals(true).with_confidence(true);
        let first = one.solve(&source, &options).unwrap();
        assert!(same_bits(&first, &one.solve(&source, &options).unwrap()), "{level_sets:?}: repeated");
        assert!(same_bits(&first, &two.solve(&source, &options).unwrap()), "{level_sets:?}: two threads");
        assert!(same_bits(&first, &with(1).solve(&source, &options).unwrap()), "{level_sets:?}: new solver");
    }
}

/// The distance does not depend on the subdivision of a curve inside its faces.
#[test]
fn splitting_segments_changes_nothing() {
    let (mesh, source) = scene();
    let source = signed_only(source);
    let mut cut = source.clone();
    for curve in &mut cut.curves {
        let old = curve.nodes.clone();
        curve.nodes = vec![old[0]];
        for pair in old.windows(2) {
            let [a, b] = [pair[0], pair[1]].map(|p| p.locate(&mesh).unwrap());
            if let Some(eikona_mesh::SegmentHost::Face(f, [p, q])) = eikona_mesh::segment_host(&mesh, a, b) {
                let middle = [0, 1, 2].map(|k| 0.3 * p[k] + 0.7 * q[k]);
                curve.nodes.push(eikona_mesh::Located::in_face(&mesh, f, middle).to_surface_point(&mesh));
            }
            curve.nodes.push(pair[1]);
        }
        assert!(curve.nodes.len() > old.len());
    }
    for level_sets in [LevelSets::Automatic, LevelSets::Free, LevelSets::Zero, LevelSets::Soft(5.0)] {
        let before = solve(&mesh, &source, PAPER_TIME, level_sets).distance;
        let after = solve(&mesh, &cut, PAPER_TIME, level_sets).distance;
        assert_same(&format!("{level_sets:?}"), before.as_slice(), after.as_slice(), tolerance(level_sets));
    }
}

/// The automatic time depends on the source only: in one call, and in a solver built before any
/// source is known, for any order of sources.
#[test]
fn automatic_time_follows_the_source() {
    let plate = rough_plate(24);
    let flipped = eikona_mesh::damage::flip_faces(&plate, 0.4, 2).unwrap().mesh;
    for mesh in [&plate, &flipped] {
        let closed = zero_level(mesh, |p| (p[0] - 1.0).hypot(p[1] - 1.0) - 0.51);
        let open = broken(mesh, &closed, 0.3, 0.2);
        let options = SolverOptions::default().with_time(DiffusionTime::Automatic);
        let solver = Solver::new(mesh, &options).unwrap();
        let reasons = [&closed, &open, &closed, &open].map(|source| {
            let kept = solver.solve(source, &SolveOptions::default()).unwrap();
            let once = signed_distance(mesh, source, &options, &SolveOptions::default()).unwrap();
            assert_eq!(kept.distance.as_slice(), once.distance.as_slice());
            assert_eq!(kept.report.time, once.report.time);
            kept.report.time.coefficient
        });
        assert_eq!([reasons[0], reasons[1]], [reasons[2], reasons[3]]);
        assert_eq!(reasons, [1.0, 1.5, 1.0, 1.5]);
        assert_eq!(reasons[0], solver.time().coefficient);
        // The second time counts against the limit.
        let tight = options.with_memory_limit(Some(needed_bytes(&solver, &closed)));
        let tight = Solver::new(mesh, &tight).unwrap();
        // Level sets would need another factor.
        let free = SolveOptions::default().with_level_sets(LevelSets::Free);
        assert!(tight.solve(&closed, &free).is_ok());
        let refused = tight.solve(&open, &free).unwrap_err();
        assert!(matches!(refused, SignedHeatError::Numeric(NumericError::MemoryLimit { .. })), "{refused}");
    }
}

fn needed_bytes(solver: &Solver, source: &SurfaceCurves) -> usize {
    solver.solve(source, &SolveOptions::default()).unwrap().report.preparation.needed_bytes
}

#[test]
fn solvers_are_shared_between_threads() {
    fn shared<T: Send + Sync + 'static>(_: &T) {}
    shared(&solver(&rough_plate(4), DiffusionTime::Automatic));
}
