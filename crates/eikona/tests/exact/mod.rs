//! Shorthands for the signed heat solver, error norms, and sources from closed formulas.
#![allow(dead_code)] // each test file uses a part of this

use eikona::contour::isolines;
use eikona::signed_heat::{DiffusionTime, LevelSets, Solution, SolveOptions, Solver, SolverOptions};
use eikona_mesh::damage::jitter_with;
use eikona_mesh::shapes::{self, Diagonal};
use eikona_mesh::{Curve, CurveKind, Face, SurfaceCurves, SurfacePoint, TriangleMesh, Vertex};

pub const PAPER_TIME: DiffusionTime = DiffusionTime::Coefficient(1.0);

pub fn solver(mesh: &TriangleMesh, time: DiffusionTime) -> Solver {
    Solver::new(mesh, &SolverOptions::default().with_time(time)).unwrap()
}

pub fn levels(level_sets: LevelSets) -> SolveOptions {
    SolveOptions::default().with_level_sets(level_sets)
}

pub fn solve(
    mesh: &TriangleMesh,
    source: &SurfaceCurves,
    time: DiffusionTime,
    level_sets: LevelSets,
) -> Solution {
    solver(mesh, time).solve(source, &levels(level_sets)).unwrap()
}

/// The distance with the paper's time and no constraint.
pub fn free(mesh: &TriangleMesh, source: &SurfaceCurves) -> Vec<f64> {
    solve(mesh, source, PAPER_TIME, LevelSets::Free).distance.into_vec()
}

/// The distance with the paper's time and zero at every node.
pub fn zero(mesh: &TriangleMesh, source: &SurfaceCurves) -> Vec<f64> {
    solve(mesh, source, PAPER_TIME, LevelSets::Zero).distance.into_vec()
}

/// Errors of vertex values against a function of the position.
#[derive(Clone, Copy, Debug)]
pub struct Errors {
    /// Root mean square over the area, divided by the range of the exact values (SHM section 9.1).
    pub l2: f64,
    pub largest: f64,
}

pub fn errors(mesh: &TriangleMesh, values: &[f64], exact: impl Fn([f64; 3]) -> f64) -> Errors {
    let areas = vertex_areas(mesh);
    let (mut sum, mut total, mut largest) = (0.0, 0.0, 0.0f64);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for v in mesh.vertices() {
        let truth = exact(mesh.position(v));
        (low, high) = (low.min(truth), high.max(truth));
        let error = (values[v.index()] - truth).abs();
        assert!(error.is_finite(), "{v} at {:?}: {}", mesh.position(v), values[v.index()]);
        sum += areas[v.index()] * error * error;
        total += areas[v.index()];
        largest = largest.max(error);
    }
    Errors { l2: (sum / total).sqrt() / (high - low), largest }
}

/// A third of the area of the faces around each vertex.
pub fn vertex_areas(mesh: &TriangleMesh) -> Vec<f64> {
    let mut areas = vec![0.0; mesh.vertex_count()];
    for f in mesh.faces() {
        for v in mesh.face_vertices(f) {
            areas[v.index()] += face_area(mesh, f) / 3.0;
        }
    }
    areas
}

pub fn face_area(mesh: &TriangleMesh, f: Face) -> f64 {
    let [a, b, c] = mesh.face_positions(f);
    0.5 * norm(cross(sub(b, a), sub(c, a)))
}

pub fn mean_edge_length(mesh: &TriangleMesh) -> f64 {
    let sum: f64 = mesh
        .edges()
        .map(|e| {
            let [a, b] = mesh.edge_vertices(e).map(|v| mesh.position(v));
            norm(sub(b, a))
        })
        .sum();
    sum / mesh.edge_count() as f64
}

/// The zero level set of a function, as oriented curves with the negative side on the left.
pub fn zero_level(mesh: &TriangleMesh, function: impl Fn([f64; 3]) -> f64) -> SurfaceCurves {
    let values: Vec<f64> = mesh.positions().iter().map(|&p| function(p)).collect();
    let mut sets = isolines(mesh, &values.into(), &[0.0]).unwrap();
    SurfaceCurves { curves: sets.remove(0).curves, points: Vec::new() }
}

/// The vertices for which `on` holds, as an oriented curve in the order of `along`.
pub fn through_vertices(
    mesh: &TriangleMesh,
    on: impl Fn([f64; 3]) -> bool,
    along: impl Fn([f64; 3]) -> f64,
) -> Curve {
    let mut nodes: Vec<Vertex> = mesh.vertices().filter(|&v| on(mesh.position(v))).collect();
    nodes.sort_by(|&a, &b| along(mesh.position(a)).total_cmp(&along(mesh.position(b))));
    Curve::signed(nodes)
}

/// The pieces of closed curves after alternately keeping a share `keep` of their length and
/// dropping a share `drop`; each curve ends with a gap.
pub fn broken(mesh: &TriangleMesh, whole: &SurfaceCurves, keep: f64, drop: f64) -> SurfaceCurves {
    let mut pieces = Vec::new();
    for curve in &whole.curves {
        let points: Vec<[f64; 3]> =
            curve.nodes.iter().map(|n| n.locate(mesh).unwrap().position(mesh)).collect();
        let steps: Vec<f64> = points.windows(2).map(|w| norm(sub(w[1], w[0]))).collect();
        let total: f64 = steps.iter().sum();
        let mut reached = 0.0;
        let mut piece: Vec<SurfacePoint> = Vec::new();
        for (node, step) in curve.nodes.iter().zip(&steps) {
            let share = reached / total;
            reached += step;
            if share % (keep + drop) < keep && share < 1.0 - drop {
                piece.push(*node);
            } else if !piece.is_empty() {
                pieces.push(Curve::signed(std::mem::take(&mut piece)));
            }
        }
    }
    SurfaceCurves { curves: pieces, points: Vec::new() }
}

pub fn unsigned(mut source: SurfaceCurves) -> SurfaceCurves {
    source.curves.iter_mut().for_each(|c| c.kind = CurveKind::Unsigned);
    source
}

pub fn reversed(source: &SurfaceCurves) -> SurfaceCurves {
    let curves = source.curves.iter().map(|c| c.clone().reversed()).collect();
    SurfaceCurves { curves, points: source.points.clone() }
}

/// The order of convergence of (spacing, error) pairs: the slope of the regression line of their
/// logarithms.
pub fn observed_order(table: &[(f64, f64)]) -> f64 {
    let n = table.len() as f64;
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| table.iter().map(f).sum::<f64>() / n;
    let (x, y) = (mean(&|p| p.0.ln()), mean(&|p| p.1.ln()));
    mean(&|p| (p.0.ln() - x) * (p.1.ln() - y)) / mean(&|p| (p.0.ln() - x).powi(2))
}

pub fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).fold(0.0, |m, (x, y)| {
        assert!(x.is_nan() == y.is_nan(), "{x} and {y}");
        if x.is_nan() { m } else { f64::max(m, (x - y).abs()) }
    })
}

pub fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, x| if x.is_nan() { m } else { m.max(x.abs()) })
}

pub fn distance_to_segment(p: [f64; 3], a: [f64; 3], b: [f64; 3]) -> f64 {
    let (ab, ap) = (sub(b, a), sub(p, a));
    let t = (dot(ab, ap) / dot(ab, ab)).clamp(0.0, 1.0);
    norm(sub(ap, ab.map(|x| t * x)))
}

pub fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}
pub fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
}

pub fn vertex_at(mesh: &TriangleMesh, at: [f64; 3]) -> Vertex {
    mesh.vertices().find(|&v| norm(sub(mesh.position(v), at)) < 1e-9).unwrap()
}

/// [0, 2] x [0, 2], with n squares per side.
pub fn plate(n: usize) -> TriangleMesh {
    shapes::grid(n, n, 2.0, 2.0, Diagonal::Alternating).unwrap()
}

pub fn rough_plate(n: usize) -> TriangleMesh {
    jitter_with(&plate(n), 0.25, 3, &|p| [p[0], p[1], 0.0]).unwrap()
}

/// The straight line between two points of a flat mesh, with nodes on the edges it crosses.
pub fn straight(mesh: &TriangleMesh, a: [f64; 3], b: [f64; 3]) -> Curve {
    let bvh = eikona::spatial::Bvh::new(mesh);
    eikona::curves::trace_polyline(mesh, &bvh, &[a, b], false, eikona_mesh::CurveKind::Signed, 1e-6)
        .unwrap()
        .curve
}
