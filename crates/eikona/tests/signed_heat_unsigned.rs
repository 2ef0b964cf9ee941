//! Sources without sides on flat plates, where the distance is known: open and closed curves, along
//! edges and across faces, points anywhere, and combinations with signed curves.

mod exact;

use eikona::signed_heat::{DiffusionTime, LevelSets};
use eikona_mesh::{Curve, SurfaceCurves, SurfacePoint, TriangleMesh};
use exact::*;

/// A mesh, a source and the exact distance, at one resolution.
type Case = (TriangleMesh, SurfaceCurves, Box<dyn Fn([f64; 3]) -> f64>);

/// Minimum orders at the paper's time and at the automatic one, and the maximum of the last L2
/// error in edge lengths.
struct Wanted {
    orders: [f64; 2],
    edges: [f64; 2],
}

fn falls(name: &str, level_sets: LevelSets, wanted: Wanted, at: impl Fn(usize) -> Case) {
    let mut tables = [Vec::new(), Vec::new()];
    for n in [16, 32, 64, 128, 192] {
        let (mesh, source, exact) = at(n);
        let h = mean_edge_length(&mesh);
        for (table, time) in tables.iter_mut().zip([PAPER_TIME, DiffusionTime::Automatic]) {
            let solution = solve(&mesh, &source, time, level_sets);
            let e = errors(&mesh, solution.distance.as_slice(), &exact);
            let c = solution.report.time.coefficient;
            println!("{name}, {level_sets:?}, n {n}, t {c:.1}: L2 {:.2e}, {:.2} edges", e.l2, e.largest / h);
            table.push((h, e.l2));
        }
    }
    for (k, table) in tables.iter().enumerate() {
        let (order, last) = (observed_order(table), table[table.len() - 1]);
        let time = ["paper's time", "automatic"][k];
        println!("{name}, {level_sets:?}, {time}: order {order:.2}, {:.2} edges", last.1 / last.0);
        assert!(order >= wanted.orders[k], "{name}, {time}: order {order}");
        assert!(last.1 <= wanted.edges[k] * last.0, "{name}, {time}: {} edges", last.1 / last.0);
    }
}

/// Around the ends of a curve, and at its corners, diffusion mixes directions within sqrt(t): at
/// the automatic time, with t in proportion to h, half an order remains at best.
const WITH_ENDS: Wanted = Wanted { orders: [0.45, 0.2], edges: [2.0, 4.0] };
const WITHOUT_ENDS: Wanted = Wanted { orders: [0.7, 0.7], edges: [1.0, 1.0] };

const ENDS: [[f64; 3]; 2] = [[0.6, 0.8, 0.0], [1.4, 1.2, 0.0]];

#[test]
fn unsigned_segment_across_faces() {
    for level_sets in [LevelSets::Free, LevelSets::Zero] {
        falls("unsigned across faces", level_sets, WITH_ENDS, |n| {
            let mesh = rough_plate(n);
            let source = unsigned(SurfaceCurves::from_curve(straight(&mesh, ENDS[0], ENDS[1])));
            (mesh, source, Box::new(|p| distance_to_segment(p, ENDS[0], ENDS[1])))
        });
    }
}

#[test]
fn unsigned_segment_along_edges() {
    for level_sets in [LevelSets::Free, LevelSets::Zero] {
        falls("unsigned along edges", level_sets, WITH_ENDS, |n| {
            let mesh = plate(n);
            let curve = through_vertices(&mesh, |p| p[1] == 1.0 && (0.5..=1.5).contains(&p[0]), |p| p[0]);
            let source = unsigned(SurfaceCurves::from_curve(curve));
            (mesh, source, Box::new(|p| distance_to_segment(p, [0.5, 1.0, 0.0], [1.5, 1.0, 0.0])))
        });
    }
}

#[test]
fn closed_unsigned_circle() {
    falls("unsigned circle", LevelSets::Zero, WITHOUT_ENDS, |n| {
        let mesh = rough_plate(n);
        let exact = |p: [f64; 3]| (p[0] - 1.0).hypot(p[1] - 1.0) - 0.6;
        let source = unsigned(zero_level(&mesh, exact));
        (mesh, source, Box::new(move |p| exact(p).abs()))
    });
}

/// A circle along edges is not smooth; the distance is that to the polygon.
#[test]
fn closed_unsigned_square_along_edges() {
    falls("unsigned square", LevelSets::Zero, WITH_ENDS, |n| {
        let mesh = plate(n);
        let square = [[0.5, 0.5], [1.5, 0.5], [1.5, 1.5], [0.5, 1.5], [0.5, 0.5]];
        let mut nodes = vec![vertex_at(&mesh, [0.5, 0.5, 0.0])];
        for side in square.windows(2) {
            let steps = n / 2;
            for i in 1..=steps {
                let at = |k: usize| side[0][k] + (side[1][k] - side[0][k]) * i as f64 / steps as f64;
                nodes.push(vertex_at(&mesh, [at(0), at(1), 0.0]));
            }
        }
        let source = SurfaceCurves::from_curve(Curve::unsigned(nodes));
        let exact = move |p: [f64; 3]| {
            square
                .windows(2)
                .map(|s| distance_to_segment(p, [s[0][0], s[0][1], 0.0], [s[1][0], s[1][1], 0.0]))
                .fold(f64::INFINITY, f64::min)
        };
        (mesh, source, Box::new(exact))
    });
}

#[test]
fn points_anywhere() {
    type Place = fn(&TriangleMesh) -> SurfacePoint;
    let vertex: Place = |mesh| vertex_at(mesh, [1.0, 1.0, 0.0]).into();
    let edge: Place = |mesh| {
        let from = vertex_at(mesh, [1.0, 1.0, 0.0]);
        let h = mesh.vertex_corners(from)[0].halfedge();
        SurfacePoint::Edge { vertices: [from.0, mesh.tip(h).0], t: 0.37 }
    };
    let face: Place = |mesh| {
        let f = mesh.vertex_corners(vertex_at(mesh, [1.0, 1.0, 0.0]))[0].face();
        SurfacePoint::Face { vertices: mesh.face_vertices(f).map(|v| v.0), bary: [0.2, 0.3, 0.5] }
    };
    for (name, place) in [("vertex", vertex), ("edge", edge), ("face", face)] {
        for level_sets in [LevelSets::Free, LevelSets::Zero] {
            falls(&format!("point in a {name}"), level_sets, WITHOUT_ENDS, |n| {
                let mesh = plate(n);
                let point = place(&mesh);
                let at = point.locate(&mesh).unwrap().position(&mesh);
                let source = SurfaceCurves::from_point(point);
                (mesh, source, Box::new(move |p| norm(sub(p, at))))
            });
        }
    }
}

/// A ring with a negative inside, with a bar and a point outside.
#[test]
fn signed_and_unsigned_and_points_together() {
    falls("mixed", LevelSets::Zero, WITH_ENDS, |n| {
        let mesh = rough_plate(n);
        let ring = |p: [f64; 3]| (p[0] - 0.6).hypot(p[1] - 0.6) - 0.3;
        let bar = [[1.2, 1.7, 0.0], [1.8, 1.6, 0.0]];
        let mut source = zero_level(&mesh, ring);
        source.curves.extend(unsigned(SurfaceCurves::from_curve(straight(&mesh, bar[0], bar[1]))).curves);
        let point = mesh.vertices().min_by(|&a, &b| {
            let far = |v| norm(sub(mesh.position(v), [1.6, 0.6, 0.0]));
            far(a).total_cmp(&far(b))
        });
        source.points.push(point.unwrap().into());
        let at = mesh.position(point.unwrap());
        let exact = move |p: [f64; 3]| {
            let others = distance_to_segment(p, bar[0], bar[1]).min(norm(sub(p, at)));
            if ring(p) < 0.0 { ring(p) } else { ring(p).min(others) }
        };
        (mesh, source, Box::new(exact))
    });
}
