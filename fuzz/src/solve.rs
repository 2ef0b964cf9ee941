//! The signed heat solver on small meshes of any shape, with any curves and options.

use crate::choices::Choices;
use eikona::contour::isolines;
use eikona::curves::{CurveReport, straighten_curve, trace_curve};
use eikona::signed_heat::{
    DiffusionTime, LevelSets, SignConvention, Solution, SolveOptions, Solver, SolverOptions,
};
use eikona_mesh::{Curve, CurveKind, Face, SurfaceCurves, SurfacePoint, TriangleMesh, Vertex};
use std::hint::black_box;

const MOST_VERTICES: usize = 40;
const MOST_FACES: usize = 60;

/// Builds a solver and solves for every kind of level sets.
///
/// # Panics
/// If a solution has an infinite value, or a NaN without a warning.
pub fn check(bytes: &[u8]) {
    let mut choices = Choices::new(bytes);
    let solver_options = solver_options(&mut choices);
    let solve_options = solve_options(&mut choices);
    let weight =
        if choices.below(4) == 3 { choices.wild_float() } else { 10f64.powi(choices.below(13) as i32 - 6) };
    let Ok(mesh) = mesh(&mut choices) else { return };
    let mut source = source(&mut choices, &mesh);
    check_contours(&mesh, &mut source, choices.of([false, true]));
    let solver = match Solver::new(&mesh, &solver_options) {
        Ok(solver) => solver,
        Err(fault) => return assert!(!fault.to_string().is_empty()),
    };
    for level_sets in [
        LevelSets::Automatic,
        LevelSets::Free,
        LevelSets::Zero,
        LevelSets::PerComponent,
        LevelSets::Soft(weight),
    ] {
        match solver.solve(&source, &solve_options.with_level_sets(level_sets)) {
            Ok(solution) => {
                check_solution(&mesh, &solution);
                black_box(isolines(&mesh, &solution.distance, &[0.0, 0.5]).ok());
            }
            Err(fault) => assert!(!fault.to_string().is_empty()),
        }
    }
}

/// Checks reports and tracing of curves on degenerate meshes; with `keep` the traced curves replace
/// the source.
fn check_contours(mesh: &TriangleMesh, source: &mut SurfaceCurves, keep: bool) {
    if let Ok(report) = CurveReport::of(mesh, source) {
        black_box(report.warnings(source));
    }
    for curve in &mut source.curves {
        if let Ok(traced) = trace_curve(mesh, curve) {
            black_box(straighten_curve(mesh, &traced.curve).ok());
            let traced = SurfaceCurves::from_curve(traced.curve);
            if let Err(fault) = traced.segments(mesh) {
                panic!("a traced curve is refused: {fault}\n{traced:?}");
            }
            if keep && let Some(traced) = traced.curves.into_iter().next() {
                *curve = traced;
            }
        }
    }
}

fn check_solution(mesh: &TriangleMesh, solution: &Solution) {
    let report = &solution.report;
    let warned = report.all_warnings().any(|w| w.to_string().contains("NaN"));
    for v in mesh.vertices() {
        let distance = solution.distance[v];
        assert!(
            distance.is_finite() || (distance.is_nan() && warned),
            "{v} has distance {distance}: {report:?}"
        );
        if let Some(confidence) = &solution.confidence {
            let (to_data, confidence) = (confidence.distance_to_data[v], confidence.confidence[v]);
            assert!(to_data >= 0.0 || to_data.is_nan(), "{v} is {to_data} from data");
            assert!(to_data.is_finite() || to_data.is_nan(), "{v} is {to_data} from data");
            assert!((0.0..=1.0 + 1e-9).contains(&confidence) || confidence.is_nan(), "{v}: {confidence}");
            assert!(!confidence.is_nan() || distance.is_nan(), "{v}: confidence NaN, distance {distance}");
        }
    }
    for f in mesh.faces() {
        assert!(solution.gradient[f].iter().all(|x| x.is_finite()), "{f}: {:?}", solution.gradient[f]);
    }
    let measured = [
        report.diffusion_residual,
        report.integration_residual,
        report.constraint_violation.unwrap_or(0.0),
        report.time.time,
    ];
    assert!(measured.iter().all(|x| x.is_finite()), "{measured:?}: {report:?}");
    // Curves without length have none.
    let announced = |x: &f64| !x.is_infinite();
    assert!(report.levels.iter().all(announced), "{:?}: {report:?}", report.levels);
}

fn solver_options(choices: &mut Choices) -> SolverOptions {
    let time = match choices.below(4) {
        0 => DiffusionTime::Coefficient(1.0),
        1 => DiffusionTime::Automatic,
        2 => DiffusionTime::Coefficient(choices.wild_float()),
        _ => DiffusionTime::Coefficient(10f64.powi(choices.below(41) as i32 - 20)),
    };
    let threads = if choices.below(16) == 15 { 2 } else { 1 };
    let memory_limit = choices.of([None, None, None, None, None, None, None, Some(0), Some(1 << 30)]);
    SolverOptions::default().with_time(time).with_threads(threads).with_memory_limit(memory_limit)
}

fn solve_options(choices: &mut Choices) -> SolveOptions {
    SolveOptions::default()
        .with_level_sets(LevelSets::Free)
        .with_preserve_source_normals(choices.of([false, true]))
        .with_sign(choices.of([SignConvention::LeftNegative, SignConvention::LeftPositive]))
        .with_confidence(choices.of([false, true]))
}

/// Builds a patch of a grid, a strip that may be twisted, or arbitrary faces; then corrupts some
/// positions and faces.
pub(crate) fn mesh(choices: &mut Choices) -> Result<TriangleMesh, eikona_mesh::MeshError> {
    let mut positions: Vec<[f64; 3]> = Vec::new();
    let mut faces: Vec<[u32; 3]> = Vec::new();
    match choices.below(3) {
        0 => {
            let (nx, ny) = (1 + choices.below(6), 1 + choices.below(5));
            for y in 0..=ny {
                positions.extend((0..=nx).map(|x| [x as f64, y as f64, 0.2 * (x * y) as f64]));
            }
            for y in 0..ny {
                for x in 0..nx {
                    let v = (y * (nx + 1) + x) as u32;
                    let up = v + nx as u32 + 1;
                    faces.extend([[v, v + 1, up + 1], [v, up + 1, up]]);
                }
            }
        }
        1 => {
            let n = 3 + choices.below(15) as u32;
            let twisted = choices.of([false, true]);
            for i in 0..n {
                let a = f64::from(i) / f64::from(n) * std::f64::consts::TAU;
                let half = if twisted { 0.5 * a } else { 0.0 };
                for side in [-0.4, 0.4] {
                    let r = 2.0 + side * half.cos();
                    positions.push([r * a.cos(), r * a.sin(), side * half.sin()]);
                }
            }
            for i in 0..n {
                let (a, b) = (2 * i, 2 * i + 1);
                let (c, d) = match (i + 1 == n, twisted) {
                    (false, _) => (a + 2, b + 2),
                    (true, false) => (0, 1),
                    (true, true) => (1, 0),
                };
                faces.extend([[a, c, b], [b, c, d]]);
            }
        }
        _ => {
            let n = 3 + choices.below(MOST_VERTICES - 2);
            for _ in 0..n {
                let p = [choices.share(), choices.share(), choices.share()];
                positions.push(p);
            }
            for _ in 0..choices.below(MOST_FACES + 1) {
                faces.push([0; 3].map(|_: u32| choices.below(n) as u32));
            }
        }
    }
    for _ in 0..choices.below(8) {
        spoil(choices, &mut positions, &mut faces);
    }
    TriangleMesh::new(positions, faces)
}

pub(crate) fn spoil(choices: &mut Choices, positions: &mut Vec<[f64; 3]>, faces: &mut Vec<[u32; 3]>) {
    let (v, u, w) =
        (choices.below(positions.len()), choices.below(positions.len()), choices.below(positions.len()));
    match choices.below(10) {
        0 => positions[v] = positions[u],
        1 => {
            let t = choices.wild_float();
            positions[v] = [0, 1, 2].map(|k| (1.0 - t) * positions[u][k] + t * positions[w][k]);
        }
        2 => positions[v][choices.below(3)] = choices.wild_float(),
        3 => {
            let scale = choices.wild_float();
            positions.iter_mut().flatten().for_each(|x| *x *= scale);
        }
        4 => {
            let (axis, scale) = (choices.below(3), choices.wild_float());
            positions.iter_mut().for_each(|p| p[axis] *= scale);
        }
        5 => {
            let shift = choices.wild_float();
            positions.iter_mut().for_each(|p| p[0] += shift);
        }
        6 if faces.len() < MOST_FACES => faces.push([v, u, w].map(|i| i as u32)),
        7 if !faces.is_empty() => {
            let f = choices.below(faces.len());
            faces[f].swap(0, 1);
        }
        8 if !faces.is_empty() => {
            let f = choices.below(faces.len());
            faces.swap_remove(f);
        }
        _ => positions.push([choices.share(); 3]),
    }
}

pub(crate) fn source(choices: &mut Choices, mesh: &TriangleMesh) -> SurfaceCurves {
    let mut source = SurfaceCurves::default();
    for _ in 0..choices.of([1, 2, 1, 3, 2, 4, 1, 0]) {
        let kind = choices.of([CurveKind::Signed, CurveKind::Signed, CurveKind::Unsigned]);
        let closed = choices.below(3) == 2;
        let up = match choices.below(4) {
            3 => Some([choices.wild_float(), choices.wild_float(), choices.wild_float()]),
            _ => None,
        };
        let mut face = choices.below(mesh.face_count());
        let mut nodes: Vec<SurfacePoint> = Vec::new();
        for _ in 0..choices.of([2, 3, 4, 5, 6, 8, 10, 12, 16, 3, 4, 5, 6, 8, 1, 0]) {
            let next = point(choices, mesh, face);
            nodes.push(next);
            face = match choices.below(10) {
                9 => choices.below(mesh.face_count()),
                _ => next_face(choices, mesh, face, next),
            };
        }
        if closed {
            nodes.extend(nodes.first().copied());
        }
        source.curves.push(Curve { kind, nodes, up });
    }
    for _ in 0..choices.of([0, 1, 0, 2, 0, 3]) {
        let face = choices.below(mesh.face_count());
        source.points.push(point(choices, mesh, face));
    }
    source
}

/// Returns a point, usually in the face; its weights or vertices may be wrong.
fn point(choices: &mut Choices, mesh: &TriangleMesh, face: usize) -> SurfacePoint {
    if face >= mesh.face_count() {
        return SurfacePoint::Vertex { vertex: choices.below(50) as u32 };
    }
    let mut vertices = mesh.triangles()[face];
    vertices.rotate_left(choices.below(3));
    match choices.below(16) {
        0..=4 => SurfacePoint::Vertex { vertex: vertices[0] },
        5..=8 => SurfacePoint::Edge { vertices: [vertices[0], vertices[1]], t: choices.share() },
        9..=12 => {
            let a = choices.share();
            let b = (1.0 - a) * choices.share();
            SurfacePoint::Face { vertices, bary: [a, b, 1.0 - a - b] }
        }
        13 => SurfacePoint::Edge {
            vertices: [vertices[0], vertices[1]],
            t: choices.of([1e-9, 2e-9, 1e-8, 1.0 - 1e-8, 1.0 - 2e-9, -1e-7, 1.0 + 1e-7]),
        },
        14 => {
            let a = choices.of([1e-9, 2e-9, 1e-8, 0.5]);
            let b = choices.of([1e-9, 2e-9, 1e-8, 0.5 - 1e-9]);
            SurfacePoint::Face { vertices, bary: [a, b, 1.0 - a - b] }
        }
        _ => match choices.below(3) {
            0 => SurfacePoint::Vertex { vertex: choices.below(100) as u32 },
            1 => SurfacePoint::Edge {
                vertices: [vertices[0], choices.below(50) as u32],
                t: choices.wild_float(),
            },
            _ => SurfacePoint::Face { vertices, bary: [0; 3].map(|_: u8| choices.wild_float()) },
        },
    }
}

/// Returns the same face, or another one at the point.
fn next_face(choices: &mut Choices, mesh: &TriangleMesh, face: usize, point: SurfacePoint) -> usize {
    let around: Vec<Face> = match point {
        SurfacePoint::Vertex { vertex } if (vertex as usize) < mesh.vertex_count() => {
            mesh.vertex_corners(Vertex(vertex)).iter().map(|c| c.face()).collect()
        }
        SurfacePoint::Edge { vertices: [a, b], .. } => match mesh.find_edge(Vertex(a), Vertex(b)) {
            Some(edge) => mesh.edge_halfedges(edge).iter().map(|h| h.face()).collect(),
            None => Vec::new(),
        },
        _ => Vec::new(),
    };
    match choices.below(around.len() + 1) {
        0 => face,
        i => around[i - 1].index(),
    }
}
