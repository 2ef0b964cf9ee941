//! Polylines whose nodes lie far apart on curved surfaces: they take the shortest path, whose
//! length is known in closed form, or a warning names the segment.

mod shapes;
use eikona::contour::polylines;
use eikona::curves::{
    DEFAULT_TOLERANCE, Traced, shortest_vertex_path, straighten_curve, trace_curve, trace_polyline,
};
use eikona::spatial::Bvh;
use eikona_mesh::damage::{flip_faces, shuffle};
use eikona_mesh::shapes::{Ends, cube_sphere, cuboid, cylinder, geodesic_sphere, torus, uv_sphere};
use eikona_mesh::{Curve, CurveKind, SurfaceCurves, SurfacePoint, TriangleMesh, Vertex};
use shapes::{DATA, Random, cube, moebius, read_mesh};
use std::f64::consts::{PI, TAU};

type Point = [f64; 3];

fn trace(mesh: &TriangleMesh, points: &[Point], closed: bool) -> (Traced, Vec<Point>) {
    let bvh = Bvh::new(mesh);
    let traced = trace_polyline(mesh, &bvh, points, closed, CurveKind::Signed, DEFAULT_TOLERANCE).unwrap();
    let segments = SurfaceCurves::from_curve(traced.curve.clone()).segments(mesh).unwrap();
    assert_eq!(segments.len(), traced.curve.nodes.len() - 1, "no segment of length zero");
    let path = polylines(mesh, [&traced.curve]).unwrap().remove(0);
    (traced, path)
}

fn dot(p: Point, q: Point) -> f64 {
    (0..3).map(|k| p[k] * q[k]).sum()
}

fn cross(p: Point, q: Point) -> Point {
    [0, 1, 2].map(|k| p[(k + 1) % 3] * q[(k + 2) % 3] - p[(k + 2) % 3] * q[(k + 1) % 3])
}

fn length(path: &[Point]) -> f64 {
    path.windows(2).map(|p| (0..3).map(|k| (p[0][k] - p[1][k]).powi(2)).sum::<f64>().sqrt()).sum()
}

fn unit(p: Point) -> Point {
    let l = dot(p, p).sqrt();
    p.map(|x| x / l)
}

/// Returns the length on the unit sphere of the polygon with these corners.
fn arcs(corners: &[Point]) -> f64 {
    corners.windows(2).map(|p| dot(cross(p[0], p[1]), cross(p[0], p[1])).sqrt().atan2(dot(p[0], p[1]))).sum()
}

/// Returns the solid angle on the left of a closed polygon, modulo 4 pi (van Oosterom and Strackee
/// 1983).
fn solid_angle(path: &[Point]) -> f64 {
    let apex = unit([0.123, 0.456, 0.789]);
    let triangle = |p: &[Point]| {
        let [a, b] = [unit(p[0]), unit(p[1])];
        2.0 * dot(apex, cross(a, b)).atan2(1.0 + dot(apex, a) + dot(a, b) + dot(b, apex))
    };
    path.windows(2).map(triangle).sum::<f64>().rem_euclid(2.0 * TAU)
}

/// Returns nodes on the circle at this height of the unit sphere, rotated at random.
fn circle(n: usize, z: f64, seed: u64) -> Vec<Point> {
    let mut random = Random(seed);
    let axis = unit(if seed == 0 { [0.0, 0.0, 1.0] } else { random.point(-1.0, 1.0) });
    let u = unit(cross(axis, if axis[2].abs() < 0.9 { [0.0, 0.0, 1.0] } else { [0.0, -1.0, 0.0] }));
    let v = cross(axis, u);
    let r = (1.0 - z * z).sqrt();
    let node = |i: usize| {
        let (s, c) = (TAU * i as f64 / n as f64).sin_cos();
        [0, 1, 2].map(|k| z * axis[k] + r * (c * u[k] + s * v[k]))
    };
    (0..n).map(node).collect()
}

// reports.md F1
#[test]
fn a_great_circle_of_any_number_of_nodes_converges_to_its_length_and_halves_the_sphere() {
    for n in [3, 4, 5, 6, 8, 16] {
        for seed in 0..4 {
            let mut errors = Vec::new();
            for frequency in [4, 10, 20, 40] {
                let mesh = geodesic_sphere(frequency).unwrap();
                let (traced, path) = trace(&mesh, &circle(n, 0.0, seed), true);
                let error = (length(&path) / TAU - 1.0).abs();
                let share = solid_angle(&path) / (2.0 * TAU);
                let h = 1.0 / frequency as f64;
                assert!(error < 0.2 * h * h, "{n} nodes, frequency {frequency}: {error}");
                // The plane of a wide turn is as accurate as the normals of single faces.
                assert!((share - 0.5).abs() < 0.1 * h, "{n} nodes, frequency {frequency}: {share}");
                assert!(traced.warnings().is_empty(), "{:?}", traced.warnings());
                errors.push(error);
            }
            assert!(errors[3] < 0.05 * errors[0], "{n} nodes: {errors:?}");
        }
    }
}

#[test]
fn polygons_of_great_arcs_have_their_length_and_area() {
    let mesh = geodesic_sphere(20).unwrap();
    for seed in 0..60 {
        let n = 3 + seed as usize % 4;
        let height = Random(seed).unit();
        let mut corners = circle(n, 0.95 * height, seed);
        // Nodes off the surface are projected along the radius.
        let nodes: Vec<Point> =
            corners.iter().map(|p| p.map(|x| [0.9, 1.0, 1.1][seed as usize % 3] * x)).collect();
        let (traced, path) = trace(&mesh, &nodes, true);
        corners.push(corners[0]);
        let exact = arcs(&corners);
        assert!((length(&path) / exact - 1.0).abs() < 4e-3, "{n} {height}: {} {exact}", length(&path));
        let area = solid_angle(&path) - solid_angle(&corners);
        assert!(area.abs() < 0.08, "{n} {height}: {area}");
        assert!(traced.warnings().is_empty(), "{:?}", traced.warnings());
    }
}

#[test]
fn great_arcs_cross_poles_and_follow_boundaries() {
    let meshes = [uv_sphere(64, 31).unwrap(), cube_sphere(20).unwrap()];
    for (m, mesh) in meshes.iter().enumerate() {
        for seed in 0..30 {
            let mut corners = circle(3 + seed as usize % 2, 0.6 * Random(seed + 7).unit(), seed);
            corners[0] = mesh.positions()[if seed % 3 == 0 { 0 } else { seed as usize * 20 }];
            let (traced, path) = trace(mesh, &corners, false);
            let share = length(&path) / arcs(&corners);
            assert!((share - 1.0).abs() < 1e-2, "mesh {m}, seed {seed}: {share} {:?}", traced.warnings());
        }
    }
    let upper = |f: &[u32; 3]| f.iter().all(|&v| meshes[0].position(Vertex(v))[2] > -1e-9);
    let faces = meshes[0].triangles().iter().copied().filter(upper).collect();
    let hemisphere = TriangleMesh::new(meshes[0].positions().to_vec(), faces).unwrap();
    for (turn, z) in [(1.0, 0.0), (2.0, 0.0), (2.5, 0.0), (2.0, 0.05), (2.5, 0.5)] {
        let node = |a: f64| unit([a.cos(), a.sin(), z]);
        let nodes = [node(0.1), node(0.1 + turn)];
        let (_, path) = trace(&hemisphere, &nodes, false);
        let share = length(&path) / arcs(&nodes);
        assert!((share - 1.0).abs() < 5e-3, "hemisphere {turn} {z}: {share}");
    }
}

#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn sparse_polylines_on_scans_are_hardly_longer_than_straightened_edge_paths() {
    let mut run = 0;
    for name in ["closed/bunny.obj", "closed/spot.obj", "closed/fandisk.obj", "boundary/camelhead.off"] {
        let mesh = read_mesh(format!("{DATA}/{name}")).expect(name);
        run += 1;
        let bvh = Bvh::new(&mesh);
        let mut random = Random(run);
        let (mut worst, mut sums) = (0.0f64, [0.0; 2]);
        for _ in 0..40 {
            let ends = [0; 2].map(|_| Vertex((random.next() % mesh.vertex_count() as u64) as u32));
            let points = ends.map(|v| mesh.position(v));
            let Ok(edges) = shortest_vertex_path(&mesh, &ends) else { continue };
            if edges.len() < 2 {
                continue;
            }
            let traced =
                trace_polyline(&mesh, &bvh, &points, false, CurveKind::Signed, DEFAULT_TOLERANCE).unwrap();
            let straight = straighten_curve(&mesh, &Curve::signed(edges)).unwrap();
            let [ours, other] =
                [&traced.curve, &straight].map(|c| length(&polylines(&mesh, [c]).unwrap()[0]));
            worst = worst.max(ours / other);
            sums = [sums[0] + ours, sums[1] + other];
        }
        println!("{name}: {:.4} against {:.4}, worst {worst:.4}", sums[0], sums[1]);
        assert!(worst < 1.05 && sums[0] < 1.01 * sums[1], "{name}");
    }
    println!("sparse polylines traced on {run} files");
}

#[test]
fn opposite_nodes_take_half_a_great_circle_each_and_a_warning_names_them() {
    for frequency in [4, 10, 20, 40] {
        let mesh = geodesic_sphere(frequency).unwrap();
        for seed in 0..4 {
            let (traced, path) = trace(&mesh, &circle(2, 0.0, seed), true);
            let around = length(&path);
            assert!(around > 0.99 * TAU && around < 1.01 * TAU, "{around}");
            let share = solid_angle(&path) / (2.0 * TAU);
            assert!((share - 0.5).abs() < 0.1, "{share}");
            assert_eq!(traced.ambiguous, [0, 1]);
            let warnings = traced.warnings();
            assert_eq!(warnings.len(), 1);
            assert!(warnings[0].to_string().contains("nodes 0, 1 are ambiguous"), "{warnings:?}");
        }
    }
}

#[test]
fn circles_on_a_torus_stay_on_it() {
    let mesh = torus(1.0, 0.4, 96, 48).unwrap();
    for n in [3, 4, 5] {
        let angles: Vec<f64> = (0..n).map(|i| TAU * i as f64 / n as f64 + 0.1).collect();
        let tube: Vec<Point> = angles.iter().map(|b| [1.0 + 0.4 * b.cos(), 0.0, 0.4 * b.sin()]).collect();
        let inner: Vec<Point> = angles.iter().map(|a| [0.6 * a.cos(), 0.6 * a.sin(), 0.0]).collect();
        // The path over the top between two of three nodes on the outer circle is shorter by less
        // than 5 %.
        let outer: Vec<Point> = angles.iter().map(|a| [1.4 * a.cos(), 1.4 * a.sin(), 0.0]).collect();
        for (nodes, exact) in [(tube, TAU * 0.4), (inner, TAU * 0.6), (outer, TAU * 1.4)] {
            let (traced, path) = trace(&mesh, &nodes, true);
            assert!((length(&path) / exact - 1.0).abs() < 5e-3, "{n} nodes: {} {exact}", length(&path));
            assert!(traced.warnings().is_empty());
        }
    }
}

#[test]
fn paths_on_a_cylinder_are_helices() {
    let mesh = cylinder(1.0, 4.0, 96, 40, Ends::Open).unwrap();
    for (turn, rise) in [(1.0, 0.0), (1.6, 0.3), (2.0, 1.5), (2.5, 0.0), (2.8, 3.0)] {
        for start in [0.0f64, 0.4, 2.0] {
            let nodes =
                [[start.cos(), start.sin(), 0.1], [(start + turn).cos(), (start + turn).sin(), 0.1 + rise]];
            let (traced, path) = trace(&mesh, &nodes, false);
            let exact = f64::hypot(turn, rise);
            // The plane cut, an ellipse, is a little longer.
            let share = length(&path) / exact;
            assert!(share > 0.999 && share < 1.02, "{turn} {rise}: {share}");
            assert!(traced.warnings().is_empty(), "{:?}", traced.warnings());
        }
    }
}

#[test]
fn the_spider_reaches_the_fly_over_five_walls() {
    // Dudeney's room, 30 by 12 by 12: 40 feet over five walls, 42 straight up and down, 40.7 over
    // four.
    let mesh = cuboid([30.0, 12.0, 12.0], [30, 12, 12]).unwrap();
    let (traced, path) = trace(&mesh, &[[-15.0, 0.0, 5.0], [15.0, 0.0, -5.0]], false);
    assert!((length(&path) - 40.0).abs() < 1e-9, "{}", length(&path));
    assert_eq!(traced.ambiguous, [0]);
}

#[test]
fn paths_around_a_thin_plate_pass_the_nearest_rim() {
    let mesh = cuboid([1.0, 1.0, 0.02], [20, 20, 1]).unwrap();
    for (top, bottom, exact) in [
        ([0.3, 0.1], [0.3, 0.1], 0.42),
        ([0.3, 0.1], [0.4, 0.1], 0.32),
        ([0.2, 0.42], [-0.2, 0.42], f64::hypot(0.4, 0.18)),
    ] {
        let nodes = [[top[0], top[1], 0.01], [bottom[0], bottom[1], -0.01]];
        let (traced, path) = trace(&mesh, &nodes, false);
        assert!((length(&path) / exact - 1.0).abs() < 1e-9, "{} {exact}", length(&path));
        assert_eq!(traced.replaced.len() + traced.subdivided.len() + traced.shortened.len(), 1);
    }
}

#[test]
fn across_a_plate_from_rim_to_rim_both_sides_are_accepted() {
    let mesh = cuboid([1.0, 1.0, 0.02], [20, 20, 1]).unwrap();
    let (traced, path) = trace(&mesh, &[[-0.5, 0.1, 0.0], [0.5, 0.1, 0.0]], false);
    assert!((length(&path) / 1.02 - 1.0).abs() < 1e-9, "{}", length(&path));
    assert_eq!(traced.ambiguous, [0]);
}

#[test]
fn paths_on_a_cube_are_hardly_longer_than_the_shortest_unfolding() {
    let mesh = cube(9);
    let mut random = Random(3);
    for _ in 0..300 {
        let [a, b, c, d] = [0; 4].map(|_| random.unit());
        // From the top to the side x = 1: unfolded over their common edge, or over the side y = 0
        // or y = 1 adjacent to both.
        let over_edge = f64::hypot(1.0 - a + 1.0 - c, b - d);
        let around = |b: f64, d: f64| f64::hypot(1.0 - a + d, b + 1.0 - c);
        let exact = over_edge.min(around(b, d)).min(around(1.0 - b, 1.0 - d));
        let (_, path) = trace(&mesh, &[[a, b, 1.0], [1.0, d, c]], false);
        let share = length(&path) / exact;
        assert!(share > 1.0 - 1e-9 && share < 1.05 + 1e-9, "{a} {b} {c} {d}: {share}");
    }
}

#[test]
fn paths_on_a_flat_ellipsoid_cross_the_thin_side() {
    let axes = [1.0, 0.8, 0.05];
    let sphere = geodesic_sphere(30).unwrap();
    let positions = sphere.positions().iter().map(|p| [0, 1, 2].map(|k| axes[k] * p[k])).collect();
    let mesh = sphere.with_positions(positions).unwrap();
    let n = 100_000;
    let point =
        |i: usize| [(PI * i as f64 / n as f64).cos(), 0.0, axes[2] * (PI * i as f64 / n as f64).sin()];
    let exact = length(&(0..=n).map(point).collect::<Vec<_>>());
    let (traced, path) = trace(&mesh, &[[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]], false);
    assert!((length(&path) / exact - 1.0).abs() < 0.02);
    assert_eq!(traced.ambiguous, [0], "one path leads over each side");
}

#[test]
fn neither_orientation_nor_numbering_nor_scale_matters() {
    let mut runs = 0;
    let spot = read_mesh(format!("{DATA}/closed/spot.obj"));
    let meshes =
        [geodesic_sphere(12).ok(), torus(1.0, 0.4, 40, 20).ok(), Some(cube(6)), Some(moebius(60, 8)), spot];
    for (m, mesh) in meshes.into_iter().flatten().enumerate() {
        let extent = mesh.positions().iter().flatten().fold(0.0f64, |s, x| s.max(x.abs()));
        for seed in 0..12 {
            let mut random = Random(100 * m as u64 + seed);
            let mut nodes: Vec<Point> = (0..4).map(|_| random.point(-extent, extent)).collect();
            nodes.push(mesh.positions()[random.next() as usize % mesh.vertex_count()]);
            let (traced, path) = trace(&mesh, &nodes, seed % 2 == 0);
            let flipped = flip_faces(&mesh, 0.4, seed).unwrap().mesh;
            let (_, again) = trace(&flipped, &nodes, seed % 2 == 0);
            assert_eq!(
                path.len(),
                again.len(),
                "mesh {m}, seed {seed}: {} {}",
                length(&path),
                length(&again)
            );
            let same = |p: &Point, q: &Point| (0..3).all(|k| (p[k] - q[k]).abs() < 1e-9 * extent);
            assert!(path.iter().zip(&again).all(|(p, q)| same(p, q)), "mesh {m}, seed {seed}");
            runs += 1;
            for factor in [1e-6, 1e6] {
                let scaled = |p: &Point| p.map(|x| factor * x);
                let larger = mesh.with_positions(mesh.positions().iter().map(scaled).collect()).unwrap();
                let (scaled_trace, p) =
                    trace(&larger, &nodes.iter().map(scaled).collect::<Vec<_>>(), seed % 2 == 0);
                assert!(
                    (length(&p) / factor / length(&path) - 1.0).abs() < 1e-9,
                    "mesh {m}, seed {seed}, {factor}"
                );
                assert_eq!(scaled_trace.ambiguous, traced.ambiguous);
            }
            if traced.ambiguous.is_empty() {
                let (_, p) = trace(&shuffle(&mesh, seed).unwrap().mesh, &nodes, seed % 2 == 0);
                // Where walks pass vertices, and where strips of regular faces are equally long,
                // the numbering decides.
                assert!((length(&p) / length(&path) - 1.0).abs() < 1e-3, "mesh {m}, seed {seed}");
            }
        }
    }
    println!("{runs} polylines");
}

#[test]
fn curves_of_distant_points_on_the_mesh_take_the_shortest_path() {
    let mesh = geodesic_sphere(20).unwrap();
    let bvh = Bvh::new(&mesh);
    let mut nodes: Vec<SurfacePoint> = circle(3, 0.0, 5)
        .iter()
        .map(|&p| {
            let at = bvh.closest_point(p).unwrap();
            SurfacePoint::Face { vertices: mesh.face_vertices(at.face).map(|v| v.0), bary: at.weights }
        })
        .collect();
    nodes.push(nodes[0]);
    let traced = trace_curve(&mesh, &Curve { nodes, ..Curve::signed([Vertex(0)]) }).unwrap();
    let path = polylines(&mesh, [&traced.curve]).unwrap().remove(0);
    assert!((length(&path) / TAU - 1.0).abs() < 5e-4, "{}", length(&path));
    assert!((solid_angle(&path) / TAU - 1.0).abs() < 5e-3);
}
