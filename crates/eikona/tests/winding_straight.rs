//! Straightened completions across faces, with known paths on the sphere, the plane, the cylinder
//! and the torus.

mod regions;
mod smooth;

use eikona::contour::plane_cut;
use eikona::curves::trace_polyline;
use eikona::mesh::random::Random;
use eikona::mesh::{Curve, CurveKind, Face, SurfaceCurves, SurfacePoint, TriangleMesh, damage, shapes};
use eikona::spatial::Bvh;
use eikona::winding::{CompletionShape, Winding, WindingOptions, surface_winding_number};
use regions::{boundary_of, centre};
use smooth::{area_of, length};
use std::f64::consts::{PI, TAU};

fn solve_as(mesh: &TriangleMesh, curves: &[Curve], completion_shape: CompletionShape) -> Winding {
    let curves = SurfaceCurves { curves: curves.to_vec(), points: Vec::new() };
    let options = WindingOptions::default().with_completion_shape(completion_shape);
    surface_winding_number(mesh, &curves, &options).unwrap()
}

/// Returns the straightened result, after comparing it with the one on edges.
fn solve(mesh: &TriangleMesh, curves: &[Curve]) -> Winding {
    let edges = solve_as(mesh, curves, CompletionShape::Edges);
    let straight = solve_as(mesh, curves, CompletionShape::Straight);
    smooth::check(mesh, &edges, &straight);
    straight
}

fn position(mesh: &TriangleMesh, node: &SurfacePoint) -> [f64; 3] {
    node.locate(mesh).unwrap().position(mesh)
}

/// Returns the pieces of a curve between nodes that `is_kept` accepts.
fn broken(mesh: &TriangleMesh, curve: &Curve, is_kept: impl Fn([f64; 3]) -> bool) -> Vec<Curve> {
    let closed = curve.nodes.first() == curve.nodes.last();
    let mut nodes = curve.nodes.clone();
    let kept = |node: &SurfacePoint| is_kept(position(mesh, node));
    if closed {
        nodes.pop();
        let first = nodes.iter().position(|node| !kept(node)).unwrap();
        nodes.rotate_left(first);
    }
    let runs = nodes.chunk_by(|a, b| kept(a) == kept(b)).filter(|run| run.len() > 1 && kept(&run[0]));
    runs.map(|run| Curve { nodes: run.to_vec(), ..curve.clone() }).collect()
}

fn angle(p: [f64; 3]) -> f64 {
    p[1].atan2(p[0])
}

/// Prints the errors of successive refinements by two and the observed orders; the last orders must
/// be at least `order`.
fn converges(name: &str, errors: &[f64], order: f64) {
    assert!(errors.len() >= 4);
    println!("{name}: errors {}", errors.iter().map(|e| format!("{e:.2e} ")).collect::<String>());
    let orders: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
    println!("{name}: orders {orders:.2?}");
    let mean = (errors[0] / errors[errors.len() - 1]).log2() / (errors.len() - 1) as f64;
    assert!(mean > order, "{name}: {mean}");
}

/// Returns the face whose centre is highest.
fn top(w: &Winding) -> Face {
    let height = |f: &Face| centre(&w.mesh, *f)[2];
    w.mesh.faces().max_by(|a, b| height(a).total_cmp(&height(b))).unwrap()
}

/// For a cap with a broken boundary, the completion cuts off the area between the circle and the
/// great circles through open ends: per gap it leaves the spherical triangle with the pole.
#[test]
fn gaps_of_a_circle_on_the_sphere_are_closed_by_great_circles() {
    for (height, gaps) in [(0.5f64, 3.0), (0.0, 2.0), (0.7, 1.0)] {
        let mut errors = Vec::new();
        for frequency in [5, 10, 20, 40] {
            let sphere = damage::jitter(&shapes::geodesic_sphere(frequency).unwrap(), 0.1, 3).unwrap();
            let unit = |p: [f64; 3]| p.map(|x| x / (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt());
            let sphere =
                sphere.with_positions(sphere.positions().iter().map(|p| unit(*p)).collect()).unwrap();
            let circle = plane_cut(&sphere, [0.0, 0.0, height + 1e-4], [0.0, 0.0, 1.0]).unwrap().remove(0);
            let share = |p: [f64; 3]| (gaps * (angle(p) + PI) / TAU).rem_euclid(1.0);
            let pieces = broken(&sphere, &circle, |p| share(p) > 0.3);
            assert_eq!(pieces.len(), gaps as usize);
            let w = solve(&sphere, &pieces);
            let inside = w.labels[top(&w)];
            let found = area_of(&w.mesh, |f| w.labels[f] == inside);
            // Ends in order around the circle, where a gap starts and the next piece ends it.
            let colatitude = (height + 1e-4).acos();
            let (mut kept, mut triangles) = (0.0, 0.0);
            let end = |node: Option<&SurfacePoint>| angle(position(&sphere, node.unwrap()));
            let step = angle(position(&sphere, &pieces[0].nodes[1])) - end(pieces[0].nodes.first());
            let turn = |from: f64, to: f64| ((to - from) * step.sin().signum()).rem_euclid(TAU);
            for (i, piece) in pieces.iter().enumerate() {
                let next = &pieces[(i + 1) % pieces.len()];
                let [first, last] = [end(piece.nodes.first()), end(piece.nodes.last())];
                kept += turn(first, last);
                let gap = turn(last, end(next.nodes.first()));
                let base = f64::atan2(1.0, colatitude.cos() * (0.5 * gap).tan());
                triangles += gap + 2.0 * base - PI;
            }
            let exact = kept * (1.0 - colatitude.cos()) + triangles;
            errors.push((found - exact).abs() / exact);
        }
        converges(&format!("cap above {height}"), &errors, 1.5);
    }
}

/// Returns twice the area of a polygon in the plane.
fn twice_area(polygon: &[[f64; 3]]) -> f64 {
    let next = |i: usize| polygon[(i + 1) % polygon.len()];
    (0..polygon.len()).map(|i| polygon[i][0] * next(i)[1] - polygon[i][1] * next(i)[0]).sum()
}

fn is_inside(polygon: &[[f64; 3]], p: [f64; 3]) -> bool {
    let mut inside = false;
    for (i, a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        if (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) {
            inside = !inside;
        }
    }
    inside
}

/// Returns pieces of a circle in the plane with the given number of twentieths left between gaps,
/// traced over a mesh, and the polygon that they form with chords across the gaps.
fn circle_with_gaps(
    mesh: &TriangleMesh,
    points: usize,
    (gaps, kept): (usize, usize),
) -> (Vec<Curve>, Vec<[f64; 3]>) {
    let at = |i: usize| {
        let a = TAU * i as f64 / points as f64;
        [0.013 + 0.62 * a.cos(), -0.007 + 0.62 * a.sin(), 0.0]
    };
    let (mut pieces, mut polygon) = (Vec::new(), Vec::new());
    for gap in 0..gaps {
        let (first, last) = (gap * points / gaps, (gap * points + points * kept / 20) / gaps);
        let line: Vec<[f64; 3]> = (first..=last).map(at).collect();
        polygon.extend(&line);
        let traced = trace_polyline(mesh, &Bvh::new(mesh), &line, false, CurveKind::Signed, 1e-9);
        pieces.push(traced.unwrap().curve);
    }
    (pieces, polygon)
}

/// In the plane the completed region is a polygon, whatever the mesh: chords cut segments off the
/// circle.
#[test]
fn gaps_of_a_circle_in_the_plane_are_closed_by_chords() {
    for (gaps, kept) in [(1, 17), (2, 14), (5, 14)] {
        let mut errors = Vec::new();
        for n in [10, 20, 40, 80] {
            let grid = shapes::grid(n, n, 3.0, 3.0, shapes::Diagonal::Alternating).unwrap();
            let middle = [0, 1].map(|k| {
                let x = grid.positions().iter().map(|p| p[k]);
                0.5 * (x.clone().fold(f64::INFINITY, f64::min) + x.fold(f64::NEG_INFINITY, f64::max))
            });
            let moved = grid.positions().iter().map(|p| [p[0] - middle[0], p[1] - middle[1], 0.0]).collect();
            let grid = grid.with_positions(moved).unwrap();
            let (pieces, polygon) = circle_with_gaps(&grid, 10 * n, (gaps, kept));
            let w = solve(&grid, &pieces);
            let found = area_of(&w.mesh, |f| w.labels[f] == 1);
            let exact = 0.5 * twice_area(&polygon);
            assert!((found - exact).abs() < 1e-7 * exact, "{gaps} gaps, {n}: {found} for {exact}");
            // Labels of points and of whole faces follow it.
            let mut near = 0;
            let of_faces = w.input_labels();
            for f in grid.faces() {
                let corners = grid.face_positions(f);
                for weights in [[0.8, 0.1, 0.1], [0.1, 0.8, 0.1], [0.1, 0.1, 0.8], [1.0 / 3.0; 3]] {
                    let p = [0, 1, 2].map(|k| (0..3).map(|c| weights[c] * corners[c][k]).sum());
                    let inside = is_inside(&polygon, p);
                    assert_eq!(w.label_at(f, weights), Some(i32::from(inside)), "{f} {weights:?}");
                    near += usize::from(inside != (of_faces[f] == 1));
                }
            }
            assert!(near > 0, "some points lie across the boundary from most of their face");
            let arc = TAU * kept as f64 / 20.0;
            let gap = (TAU - arc) / gaps as f64;
            let circle = 0.5 * 0.62f64.powi(2) * (arc + gaps as f64 * gap.sin());
            errors.push((found - circle).abs() / circle);
        }
        converges(&format!("disk with {gaps} gaps"), &errors, 1.5);
    }
}

/// Around a cylinder a circle is already straight, and so is every completion of it: the prism is
/// divided exactly there.
#[test]
fn gaps_of_a_circle_around_a_cylinder_are_closed_at_its_height() {
    let sectors = 40;
    let cylinder = shapes::cylinder(0.5, 2.0, sectors, 30, shapes::Ends::Open).unwrap();
    let low = cylinder.positions().iter().map(|p| p[2]).fold(f64::INFINITY, f64::min);
    let circle = plane_cut(&cylinder, [0.0, 0.0, low + 0.777], [0.0, 0.0, 1.0]).unwrap().remove(0);
    for gaps in [1.0, 3.0] {
        let share = |p: [f64; 3]| (gaps * (angle(p) + PI) / TAU).rem_euclid(1.0);
        let w = solve(&cylinder, &broken(&cylinder, &circle, |p| share(p) > 0.3));
        let above = w.labels[top(&w)];
        let below = area_of(&w.mesh, |f| w.labels[f] != above);
        let exact = 0.777 * sectors as f64 * (PI / sectors as f64).sin();
        assert!((below - exact).abs() < 1e-9, "{below} for {exact}");
    }
}

fn torus(n: usize) -> TriangleMesh {
    // Vertices off the parallels and meridians, but on the torus.
    let torus = damage::jitter(&shapes::torus(1.0, 0.4, 2 * n, n).unwrap(), 0.2, 5).unwrap();
    let onto = |p: &[f64; 3]| {
        let r = p[0].hypot(p[1]);
        let (x, z) = (r - 1.0, p[2]);
        let h = x.hypot(z);
        let r_new = 1.0 + 0.4 * x / h;
        [p[0] / r * r_new, p[1] / r * r_new, 0.4 * z / h]
    };
    torus.with_positions(torus.positions().iter().map(onto).collect()).unwrap()
}

/// A plane through the axis cuts a torus in two circles around the tube, which are geodesics. Each
/// broken circle is completed to itself, and half of the torus lies on each side.
#[test]
fn gaps_of_circles_around_the_tube_are_closed_along_them() {
    let mut errors = Vec::new();
    for n in [10, 20, 40, 80] {
        let torus = torus(n);
        let normal = [-0.3f64.sin(), 0.3f64.cos(), 0.0];
        let circles = plane_cut(&torus, [0.0; 3], normal).unwrap();
        assert_eq!(circles.len(), 2);
        let around_tube = |p: [f64; 3]| p[2].atan2(p[0].hypot(p[1]) - 1.0);
        let is_kept = |p: [f64; 3]| (2.0 * (around_tube(p) + PI) / TAU).rem_euclid(1.0) > 0.2;
        let pieces: Vec<Curve> = circles.iter().flat_map(|c| broken(&torus, c, is_kept)).collect();
        let w = solve(&torus, &pieces);
        let half = 0.5 * 4.0 * PI * PI * 0.4;
        let side = |f: Face| {
            let c = centre(&w.mesh, f);
            normal[0] * c[0] + normal[1] * c[1] > 0.0
        };
        let wrong = area_of(&w.mesh, |f| side(f) == (w.labels[f] == 0));
        let found = area_of(&w.mesh, |f| w.labels[f] == 0);
        let wrong = wrong.min(area_of(&w.mesh, |_| true) - wrong);
        println!("{n}: {:.2e} of the half on the wrong side", wrong / half);
        errors.push((found - half).abs() / half);
    }
    converges("half of the torus", &errors, 1.5);
}

/// The loop that contains one of them is completed to the whole circle.
#[test]
fn a_broken_circle_around_the_tube_is_completed_to_its_length() {
    let mut errors = Vec::new();
    for n in [10, 20, 40, 80] {
        let torus = torus(n);
        let circle = plane_cut(&torus, [0.0; 3], [-0.3f64.sin(), 0.3f64.cos(), 0.0]).unwrap().remove(0);
        let around_tube = |p: [f64; 3]| p[2].atan2(p[0].hypot(p[1]) - 1.0);
        let is_kept = |p: [f64; 3]| (2.0 * (around_tube(p) + PI) / TAU).rem_euclid(1.0) > 0.3;
        let pieces = broken(&torus, &circle, is_kept);
        let w = solve(&torus, &pieces);
        let edges = solve_as(&torus, &pieces, CompletionShape::Edges);
        assert_eq!((w.nonbounding_loops.len(), edges.nonbounding_loops.len()), (1, 1));
        let exact = TAU * 0.4;
        let [found, before] = [&w, &edges].map(|w| length(&w.mesh, &w.nonbounding_loops));
        assert!(before > 1.001 * found, "on edges it zigzags: {before} against {found}");
        errors.push((found - exact).abs() / exact);
    }
    converges("length of the circle", &errors, 1.5);
}

/// Curves with random gaps on surfaces of many kinds, also one-sided and with flipped faces: the
/// properties of [`smooth::check`] hold for all.
#[test]
fn straightened_completions_agree_with_those_on_edges() {
    let pinched = {
        // Two tori that share a vertex.
        let one = shapes::torus(1.0, 0.4, 24, 12).unwrap();
        let n = one.vertex_count() as u32;
        let mut positions = one.positions().to_vec();
        let first = positions[0];
        positions.extend(one.positions()[1..].iter().map(|p| [2.0 * first[0] - p[0], p[1], p[2]]));
        let mut faces = one.triangles().to_vec();
        faces.extend(one.triangles().iter().map(|t| t.map(|v| if v == 0 { 0 } else { v + n - 1 })));
        TriangleMesh::new(positions, faces).unwrap()
    };
    let surfaces = [
        torus(20),
        damage::flip_faces(&torus(16), 0.4, 2).unwrap().mesh,
        shapes::chain_of_genus(2, 3).unwrap(),
        shapes::cylinder(0.5, 2.0, 30, 20, shapes::Ends::Open).unwrap(),
        shapes::klein_bottle(2.0, 60, 20).unwrap(),
        shapes::moebius_band(1.0, 0.5, 60, 10).unwrap(),
        damage::holes(&torus(20), 5, 2, 3).unwrap().mesh,
        pinched,
    ];
    let (mut straightened, mut kept) = (0, 0);
    for (s, mesh) in surfaces.iter().enumerate() {
        for draw in 0..4 {
            let mut random = Random::from_seed(draw + 10 * s as u64);
            let middle = centre(mesh, Face(random.below(mesh.face_count()) as u32));
            let reach = random.range(0.4, 0.9);
            let is_inside = |f: Face| {
                let c = centre(mesh, f);
                (0..3).map(|k| (c[k] - middle[k]).powi(2)).sum::<f64>() < reach * reach
            };
            let mut keep = true;
            let sides: Vec<Curve> = boundary_of(mesh, is_inside)
                .into_iter()
                .filter(|_| {
                    keep ^= random.below(6) == 0;
                    keep
                })
                .collect();
            if sides.is_empty() {
                continue;
            }
            let w = solve(mesh, &sides);
            if let Some(report) = w.report.completion {
                straightened += report.straightened;
                kept += report.on_edges;
            }
        }
    }
    println!("{straightened} pieces straightened, {kept} kept");
    assert!(straightened > 100 && kept < straightened / 4, "{straightened} {kept}");
}
