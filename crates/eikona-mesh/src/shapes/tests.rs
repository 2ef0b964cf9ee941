use super::*;
use crate::error::MeshError;
use crate::mesh::TriangleMesh;
use crate::vector::{Vec3, add, cross, distance, dot, norm, scale, sub};
use std::f64::consts::{PI, TAU};

fn chi(mesh: &TriangleMesh) -> i64 {
    mesh.vertex_count() as i64 - mesh.edge_count() as i64 + mesh.face_count() as i64
}

fn boundary_edges(mesh: &TriangleMesh) -> usize {
    mesh.edges().filter(|&e| mesh.is_boundary_edge(e)).count()
}

fn area_vectors(mesh: &TriangleMesh) -> impl Iterator<Item = Vec3> {
    mesh.faces().map(|f| {
        let [a, b, c] = mesh.face_positions(f);
        scale(cross(sub(b, a), sub(c, a)), 0.5)
    })
}

fn area(mesh: &TriangleMesh) -> f64 {
    area_vectors(mesh).map(norm).sum()
}

fn volume(mesh: &TriangleMesh) -> f64 {
    mesh.faces().map(|f| mesh.face_positions(f)).map(|[a, b, c]| dot(a, cross(b, c)) / 6.0).sum()
}

/// Returns the smallest angle in degrees.
fn smallest_angle(mesh: &TriangleMesh) -> f64 {
    let mut smallest = 180.0f64;
    for f in mesh.faces() {
        let p = mesh.face_positions(f);
        for k in 0..3 {
            let (u, v) = (sub(p[(k + 1) % 3], p[k]), sub(p[(k + 2) % 3], p[k]));
            smallest = smallest.min(norm(cross(u, v)).atan2(dot(u, v)).to_degrees());
        }
    }
    smallest
}

/// Asserts that every edge has at most two faces, every vertex one fan, and no face zero area.
#[track_caller]
fn assert_valid(mesh: &TriangleMesh) {
    assert!(mesh.edges().all(|e| mesh.edge_halfedges(e).len() <= 2), "an edge is not manifold");
    assert!(mesh.positions().iter().flatten().all(|x| x.is_finite()));
    for v in mesh.vertices() {
        let corners = mesh.vertex_corners(v);
        let mut reached = vec![false; corners.len()];
        let mut to_visit = vec![0];
        while let Some(i) = to_visit.pop() {
            if std::mem::replace(&mut reached[i], true) {
                continue;
            }
            let mine = mesh.face_edges(corners[i].face());
            for (j, c) in corners.iter().enumerate() {
                let shared = mesh
                    .face_edges(c.face())
                    .into_iter()
                    .any(|e| mine.contains(&e) && mesh.edge_vertices(e).contains(&v));
                if shared {
                    to_visit.push(j);
                }
            }
        }
        assert!(!corners.is_empty() && reached.iter().all(|&r| r), "{v} is unreferenced or has several fans");
    }
    for f in mesh.faces() {
        let [a, b, c] = mesh.face_positions(f);
        let height_ratio = norm(cross(sub(b, a), sub(c, a)));
        let longest = distance(a, b).max(distance(b, c)).max(distance(c, a));
        assert!(height_ratio > 1e-9 * longest * longest, "{f} has zero area");
    }
}

fn is_oriented(mesh: &TriangleMesh) -> bool {
    mesh.edges().all(|e| match *mesh.edge_halfedges(e) {
        [a, b] => mesh.origin(a) == mesh.tip(b),
        _ => true,
    })
}

#[track_caller]
fn assert_closed(mesh: &TriangleMesh, euler: i64, counts: [usize; 3]) {
    assert_eq!([mesh.vertex_count(), mesh.edge_count(), mesh.face_count()], counts);
    assert_eq!(chi(mesh), euler);
    assert_eq!(boundary_edges(mesh), 0);
    assert_valid(mesh);
}

#[track_caller]
fn assert_solid(mesh: &TriangleMesh, euler: i64, counts: [usize; 3]) {
    assert_closed(mesh, euler, counts);
    assert!(is_oriented(mesh) && volume(mesh) > 0.0, "not outward oriented");
}

#[test]
fn spheres_have_their_counts_and_unit_radius() {
    for n in [1, 2, 3, 4, 7, 20] {
        let sphere = geodesic_sphere(n).unwrap();
        assert_solid(&sphere, 2, [10 * n * n + 2, 30 * n * n, 20 * n * n]);
        assert!(smallest_angle(&sphere) > 53.0, "{n}: {}", smallest_angle(&sphere));
        let cube = cube_sphere(n).unwrap();
        assert_solid(&cube, 2, [6 * n * n + 2, 18 * n * n, 12 * n * n]);
        assert!(smallest_angle(&cube) > 30.0, "{n}: {}", smallest_angle(&cube));
        for p in sphere.positions().iter().chain(cube.positions()) {
            assert!((norm(*p) - 1.0).abs() < 1e-15);
        }
    }
    for k in 0..5 {
        let q = 4usize.pow(k);
        let sphere = icosphere(k).unwrap();
        assert_solid(&sphere, 2, [10 * q + 2, 30 * q, 20 * q]);
        let finer = icosphere(k + 1).unwrap();
        assert_eq!(sphere.positions(), &finer.positions()[..sphere.vertex_count()]);
    }
    for (m, p) in [(3, 1), (4, 2), (17, 9)] {
        assert_solid(&uv_sphere(m, p).unwrap(), 2, [m * p + 2, 3 * m * p, 2 * m * p]);
    }
    assert_eq!(geodesic_sphere(158).unwrap().face_count(), 499_280);
    assert_valid(&bumpy_sphere(30, 0.9, 12.0).unwrap());
}

#[test]
fn solids_are_closed() {
    assert_solid(&tetrahedron().unwrap(), 2, [4, 6, 4]);
    assert_solid(&octahedron().unwrap(), 2, [6, 12, 8]);
    assert_solid(&icosahedron().unwrap(), 2, [12, 30, 20]);
    for cells in [[1, 1, 1], [1, 2, 3], [3, 1, 2], [4, 5, 2], [1, 1, 9]] {
        let [a, b, c] = cells;
        let s = a * b + b * c + c * a;
        let mesh = cuboid([1.0, 2.0, 0.5], cells).unwrap();
        assert_solid(&mesh, 2, [2 * s + 2, 6 * s, 4 * s]);
        assert!((volume(&mesh) - 1.0).abs() < 1e-13 && (area(&mesh) - 7.0).abs() < 1e-13);
    }
    for sectors in [3, 4, 7, 13, 48, 100] {
        let mesh = cylinder(1.0, 2.0, sectors, 3, Ends::Capped).unwrap();
        assert_valid(&mesh);
        assert_eq!((chi(&mesh), boundary_edges(&mesh)), (2, 0));
        assert!(is_oriented(&mesh));
        let polygon = 0.5 * sectors as f64 * (TAU / sectors as f64).sin();
        assert!((volume(&mesh) - 2.0 * polygon).abs() < 1e-12);
    }
}

#[test]
fn tori_tubes_and_chains_are_closed() {
    for (nu, nv) in [(3, 3), (4, 3), (3, 5), (30, 12)] {
        let counts = [nu * nv, 3 * nu * nv, 2 * nu * nv];
        assert_solid(&torus(1.0, 0.4, nu, nv).unwrap(), 0, counts);
    }
    assert_solid(&trefoil_tube(0.4, 200, 16).unwrap(), 0, [3200, 9600, 6400]);
    assert_solid(&figure_eight_tube(0.2, 300, 12).unwrap(), 0, [3600, 10_800, 7200]);
    assert_solid(&linked_rings(4, 0.25, 24, 10).unwrap(), 0, [960, 2880, 1920]);
    for genus in 1..6 {
        for levels in 1..4 {
            let q = (26 * genus + 14) * 4usize.pow(levels);
            let mesh = chain_of_genus(genus, levels).unwrap();
            assert_solid(&mesh, 2 - 2 * genus as i64, [q + 2 - 2 * genus, 3 * q, 2 * q]);
            assert!(smallest_angle(&mesh) > 20.0, "{genus} {levels}: {}", smallest_angle(&mesh));
        }
    }
    for levels in 1..4 {
        let q = 110 * 4usize.pow(levels);
        let mesh = clay_animal(levels).unwrap();
        assert_solid(&mesh, 2, [q + 2, 3 * q, 2 * q]);
        assert!(smallest_angle(&mesh) > 10.0, "{}", smallest_angle(&mesh));
        let q = 226 * 4usize.pow(levels);
        assert_solid(&handcuffs(levels).unwrap(), -2, [q - 2, 3 * q, 2 * q]);
        let q = 134 * 4usize.pow(levels);
        assert_solid(&joined_rings(levels).unwrap(), -2, [q - 2, 3 * q, 2 * q]);
        let q = 336 * 4usize.pow(levels);
        assert_solid(&borromean_rings(levels).unwrap(), 0, [q, 3 * q, 2 * q]);
        for (knot, q) in [(TunnelKnot::Trefoil, 704), (TunnelKnot::FigureEight, 928)] {
            let q = q * 4usize.pow(levels);
            assert_solid(&knotted_tunnel(knot, levels).unwrap(), 0, [q, 3 * q, 2 * q]);
        }
    }
}

#[test]
fn one_sided_surfaces_are_closed_and_nonorientable() {
    for (nu, nv) in [(3, 3), (4, 4), (5, 3), (40, 17)] {
        let bottle = klein_bottle(2.5, nu, nv).unwrap();
        assert_closed(&bottle, 0, [nu * nv, 3 * nu * nv, 2 * nu * nv]);
        assert!(!is_oriented(&bottle));
        let band = moebius_band(1.0, 0.6, nu, nv).unwrap();
        assert_valid(&band);
        assert_eq!((chi(&band), boundary_edges(&band)), (0, 2 * nu));
        assert!(!is_oriented(&band));
    }
    for n in [2, 3, 4, 15, 40] {
        let plane = projective_plane(n).unwrap();
        assert_closed(&plane, 1, [3 * n * n + 1, 9 * n * n, 6 * n * n]);
        assert!(!is_oriented(&plane));
    }
    assert!(smallest_angle(&projective_plane(40).unwrap()) > 20.0);
}

/// The seam of Boy's surface closes: opposite points of the unit circle coincide in space, so edges
/// across the rim are as short as the others.
#[test]
fn boy_surface_is_smooth_across_its_rim() {
    let longest = |n: usize| {
        let mesh = projective_plane(n).unwrap();
        let length = |e| {
            let [a, b] = mesh.edge_vertices(e).map(|v| mesh.position(v));
            distance(a, b)
        };
        mesh.edges().map(length).fold(0.0, f64::max)
    };
    let ratio = longest(20) / longest(40);
    assert!((1.8..2.2).contains(&ratio), "{ratio}");
}

#[test]
fn flat_shapes_have_their_counts_area_and_normal() {
    let upward = |mesh: &TriangleMesh| area_vectors(mesh).all(|a| a[2] > 0.0);
    for diagonal in [Diagonal::Uniform, Diagonal::Alternating, Diagonal::Shorter] {
        let mesh = grid(5, 4, 2.0, 3.0, diagonal).unwrap();
        assert_valid(&mesh);
        assert_eq!([mesh.vertex_count(), mesh.edge_count(), mesh.face_count()], [30, 69, 40]);
        assert!((area(&mesh) - 6.0).abs() < 1e-14 && upward(&mesh));
    }
    for (n, s) in [(1, 3), (1, 6), (2, 3), (5, 5), (12, 6), (6, 9)] {
        let mesh = disk(n, s, 2.0).unwrap();
        assert_valid(&mesh);
        let counts = [1 + s * n * (n + 1) / 2, s * n * (3 * n + 1) / 2, s * n * n];
        assert_eq!([mesh.vertex_count(), mesh.edge_count(), mesh.face_count()], counts);
        let polygon = 2.0 * (n * s) as f64 * (TAU / (n * s) as f64).sin();
        assert!((area(&mesh) - polygon).abs() < 1e-12 && upward(&mesh));
        let lifted = cone(1.0, 2.0, n, s).unwrap();
        assert_valid(&lifted);
        assert!(lifted.positions().iter().all(|p| (p[2] - 2.0 * (1.0 - p[0].hypot(p[1]))).abs() < 1e-14));
        assert!(upward(&lifted) && boundary_edges(&lifted) == n * s);
    }
    assert!(
        smallest_angle(&disk(40, 6, 1.0).unwrap()) > 42.0,
        "{}",
        smallest_angle(&disk(40, 6, 1.0).unwrap())
    );
    let ring = annulus(0.25, 1.0, 8, 36).unwrap();
    assert_valid(&ring);
    assert_eq!((chi(&ring), boundary_edges(&ring)), (0, 72));
    assert!(upward(&ring) && smallest_angle(&ring) > 35.0, "{}", smallest_angle(&ring));
    let mesh = strip(7, 3).unwrap();
    assert_eq!([mesh.vertex_count(), mesh.edge_count(), mesh.face_count()], [32, 73, 42]);
    assert!(upward(&mesh));
    for e in mesh.edges() {
        let [a, b] = mesh.edge_vertices(e).map(|v| mesh.position(v));
        assert!((distance(a, b) - 1.0).abs() < 1e-14);
    }
}

#[test]
fn plates_lack_exactly_their_holes() {
    let holes = [
        Hole::Disk { centre: [0.7, 0.52], radius: 0.3 },
        Hole::Disk { centre: [1.61, 0.5], radius: 0.21 },
        Hole::Rectangle { min: [2.1, 0.2], max: [2.7, 0.8] },
    ];
    let missing = PI * (0.3f64.powi(2) + 0.21f64.powi(2)) + 0.36;
    let mut errors = Vec::new();
    for n in [20, 40, 80] {
        let mesh = grid_with_holes(3 * n, n, 3.0, 1.0, &holes).unwrap();
        assert_valid(&mesh);
        assert_eq!(chi(&mesh), -2);
        assert!(area_vectors(&mesh).all(|a| a[2] > 0.0));
        assert!(smallest_angle(&mesh) > 7.0, "{n}: {}", smallest_angle(&mesh));
        errors.push((area(&mesh) - (3.0 - missing)).abs());
    }
    assert!(errors[2] < errors[0] / 8.0 && errors[2] < 2e-3, "{errors:?}");
    // Rims of round holes lie on the circle.
    let mesh = grid_with_holes(40, 40, 1.0, 1.0, &[Hole::Disk { centre: [0.5, 0.5], radius: 0.3 }]).unwrap();
    let mut rim = 0;
    for v in mesh.edges().filter(|&e| mesh.is_boundary_edge(e)).flat_map(|e| mesh.edge_vertices(e)) {
        let p = mesh.position(v);
        if p[0] > 0.0 && p[0] < 1.0 && p[1] > 0.0 && p[1] < 1.0 {
            assert!(((p[0] - 0.5).hypot(p[1] - 0.5) - 0.3).abs() < 1e-14);
            rim += 1;
        }
    }
    assert!(rim > 100, "{rim}");
    assert_eq!(chi(&grid_with_holes(9, 9, 1.0, 1.0, &[]).unwrap()), 1);
    for bad in [
        Hole::Disk { centre: [0.5, 0.5], radius: 0.001 },
        Hole::Disk { centre: [0.5, 0.5], radius: 3.0 },
        Hole::Disk { centre: [0.0, 0.5], radius: 0.2 },
        Hole::Disk { centre: [f64::NAN, 0.5], radius: 0.2 },
        Hole::Rectangle { min: [0.5, 0.5], max: [0.4, 0.6] },
    ] {
        let refused = grid_with_holes(20, 20, 1.0, 1.0, &[bad]);
        assert!(matches!(refused, Err(MeshError::Parameter { .. })), "{bad:?}");
    }
}

/// Counts the pairs of an edge and a face that cross without a common vertex.
fn crossings(mesh: &TriangleMesh) -> usize {
    let mut found = 0;
    for e in mesh.edges() {
        let ends = mesh.edge_vertices(e);
        let [p, q] = ends.map(|v| mesh.position(v));
        for f in mesh.faces() {
            if mesh.face_vertices(f).iter().any(|v| ends.contains(v)) {
                continue;
            }
            let t = mesh.face_positions(f);
            let apart = (0..3).any(|k| {
                let (low, high) = (p[k].min(q[k]), p[k].max(q[k]));
                t.iter().all(|c| c[k] > high) || t.iter().all(|c| c[k] < low)
            });
            if apart {
                continue;
            }
            let side = |a: Vec3, b: Vec3, c: Vec3, d: Vec3| dot(sub(d, a), cross(sub(b, a), sub(c, a)));
            let split = side(t[0], t[1], t[2], p) * side(t[0], t[1], t[2], q) < 0.0;
            let around = [0, 1, 2].map(|k| side(p, q, t[k], t[(k + 1) % 3]));
            if split && (around.iter().all(|&s| s > 0.0) || around.iter().all(|&s| s < 0.0)) {
                found += 1;
            }
        }
    }
    found
}

#[test]
fn embedded_shapes_do_not_intersect_themselves() {
    let embedded = [
        ("clay_animal", clay_animal(2)),
        ("chain_of_genus", chain_of_genus(2, 2)),
        ("handcuffs", handcuffs(2)),
        ("joined_rings", joined_rings(2)),
        ("borromean_rings", borromean_rings(2)),
        ("trefoil tunnel", knotted_tunnel(TunnelKnot::Trefoil, 1)),
        ("figure-eight tunnel", knotted_tunnel(TunnelKnot::FigureEight, 1)),
        ("trefoil_tube", trefoil_tube(0.45, 160, 10)),
        ("figure_eight_tube", figure_eight_tube(0.25, 220, 8)),
        ("linked_rings", linked_rings(3, 0.3, 24, 8)),
        ("bumpy_sphere", bumpy_sphere(10, 0.9, 9.0)),
    ];
    for (name, mesh) in embedded {
        assert_eq!(crossings(&mesh.unwrap()), 0, "{name}");
    }
    // The test detects crossings where they exist.
    assert!(crossings(&klein_bottle(2.5, 24, 12).unwrap()) > 0);
    assert!(crossings(&trefoil_tube(1.2, 60, 10).unwrap()) > 0);
}

#[test]
fn triangles_at_the_rim_of_a_hole_keep_their_angles_for_any_centre() {
    let mut random = crate::random::Random::from_seed(1);
    let mut smallest = 90.0f64;
    for _ in 0..300 {
        let centre = [random.range(0.4, 0.6), random.range(0.4, 0.6)];
        let hole = Hole::Disk { centre, radius: random.range(0.1, 0.3) };
        let mesh = grid_with_holes(24, 24, 1.0, 1.0, &[hole]).unwrap();
        assert!(area_vectors(&mesh).all(|a| a[2] > 0.0));
        smallest = smallest.min(smallest_angle(&mesh));
    }
    assert!(smallest > 10.0, "{smallest}");
}

#[test]
fn angles_and_sizes_match_the_docs() {
    let largest_angle = |mesh: &TriangleMesh| {
        let mut largest = 0.0f64;
        for f in mesh.faces() {
            let p = mesh.face_positions(f);
            for k in 0..3 {
                let (u, v) = (sub(p[(k + 1) % 3], p[k]), sub(p[(k + 2) % 3], p[k]));
                largest = largest.max(norm(cross(u, v)).atan2(dot(u, v)).to_degrees());
            }
        }
        largest
    };
    let fine = geodesic_sphere(60).unwrap();
    assert!(smallest_angle(&fine) > 53.0 && largest_angle(&fine) < 72.1);
    let cube = cube_sphere(40).unwrap();
    let areas: Vec<f64> = area_vectors(&cube).map(norm).collect();
    let ratio = areas.iter().copied().fold(0.0, f64::max) / areas.iter().copied().fold(f64::MAX, f64::min);
    assert!(ratio < 2.0);
    let animal = clay_animal(3).unwrap();
    let extent = |k: usize| {
        let coordinates = || animal.positions().iter().map(move |p| p[k]);
        coordinates().fold(f64::MIN, f64::max) - coordinates().fold(f64::MAX, f64::min)
    };
    assert!((extent(0) - 1.1).abs() < 0.1 && (extent(1) - 3.4).abs() < 0.1 && (extent(2) - 3.4).abs() < 0.1);
    for p in animal.positions() {
        let mirrored = [-p[0], p[1], p[2]];
        assert!(animal.positions().iter().any(|q| distance(*q, mirrored) < 1e-12));
    }
}

/// Asserts that halving the edges divides the error by four.
#[track_caller]
fn assert_second_order(exact: f64, measured: impl Fn(usize) -> f64) {
    let errors = [1, 2, 4].map(|n| (measured(n) - exact).abs());
    for w in errors.windows(2) {
        let order = (w[0] / w[1]).log2();
        assert!((1.9..2.1).contains(&order), "order {order}, errors {errors:?}");
    }
}

#[test]
fn area_and_volume_converge_with_order_two() {
    assert_second_order(4.0 * PI, |n| area(&geodesic_sphere(8 * n).unwrap()));
    assert_second_order(4.0 / 3.0 * PI, |n| volume(&geodesic_sphere(8 * n).unwrap()));
    assert_second_order(4.0 * PI, |n| area(&cube_sphere(8 * n).unwrap()));
    assert_second_order(4.0 / 3.0 * PI, |n| volume(&uv_sphere(24 * n, 12 * n - 1).unwrap()));
    assert_second_order(4.0 / 3.0 * PI, |n| volume(&icosphere(2 + n.ilog2()).unwrap()));
    assert_second_order(4.0 * PI * PI * 0.4, |n| area(&torus(1.0, 0.4, 32 * n, 16 * n).unwrap()));
    assert_second_order(2.0 * PI * PI * 0.16, |n| volume(&torus(1.0, 0.4, 32 * n, 16 * n).unwrap()));
    // Pappus: a tube without self-intersection has volume π r² times the length of its curve.
    let length: f64 = trefoil(100_000).unwrap().windows(2).map(|w| distance(w[0], w[1])).sum();
    assert_second_order(PI * 0.16 * length, |n| volume(&trefoil_tube(0.4, 150 * n, 12 * n).unwrap()));
}

#[test]
fn tube_frames_do_not_twist_at_seams() {
    // Neighbouring sections of a knot differ by at most a little more than their equal share of the
    // turn.
    let (along, around) = (300, 16);
    let mesh = trefoil_tube(0.3, along, around).unwrap();
    let p = mesh.positions();
    let widest = |i: usize| {
        let next = (i + 1) % along;
        (0..around).map(|j| distance(p[i * around + j], p[next * around + j])).fold(0.0, f64::max)
    };
    let steps: Vec<f64> = (0..along).map(widest).collect();
    let mean = steps.iter().sum::<f64>() / along as f64;
    let largest = steps.iter().copied().fold(0.0, f64::max);
    assert!(largest < 1.6 * mean, "{largest} {mean}");
    assert!((steps[along - 1] - steps[along - 2]).abs() < 0.05 * mean);
    // A straight open tube keeps its frame, its ends are open, and its area is that of a prism.
    let line = |t: f64| [0.0, 0.0, 3.0 * t];
    let straight = tube(&line, false, 0.5, 6, 8).unwrap();
    assert_eq!((chi(&straight), boundary_edges(&straight)), (0, 16));
    let prism = 3.0 * 8.0 * (PI / 8.0).sin();
    assert!((area(&straight) - prism).abs() < 1e-9, "{}", area(&straight));
    let outward = straight.faces().zip(area_vectors(&straight)).all(|(f, a)| {
        let [p, q, r] = straight.face_positions(f);
        let middle = add(p, add(q, r));
        a[0] * middle[0] + a[1] * middle[1] > 0.0
    });
    assert!(outward);
}

#[test]
fn tubes_reject_curves_without_a_tangent() {
    let bad: [&dyn Fn(f64) -> Vec3; 4] =
        [&|_| [1.0, 0.0, 0.0], &|t| [t, 0.0, 0.0], &|t| [1.0 / (t - 0.5), 0.0, 0.0], &|t| {
            [(t - 0.5).sqrt(), 0.0, 0.0]
        }];
    for curve in bad {
        assert!(matches!(tube(curve, true, 0.1, 10, 8), Err(MeshError::Parameter { name: "curve", .. })));
    }
}

#[test]
fn extreme_parameters_in_range_give_valid_meshes() {
    for scale in [1e-64, 1e-30, 1e30, 1e69] {
        assert_valid(&torus(scale, 0.3 * scale, 8, 6).unwrap());
        assert_valid(&torus(scale, 1e-6 * scale, 8, 6).unwrap());
        assert_valid(&cylinder(scale, scale, 9, 2, Ends::Capped).unwrap());
        assert_valid(&annulus(0.999_999 * scale, scale, 1, 2000).unwrap());
        assert_valid(&cuboid([scale; 3], [2, 1, 1]).unwrap());
        assert_valid(&moebius_band(scale, scale, 30, 4).unwrap());
        assert_valid(&disk(4, 6, scale).unwrap());
    }
    assert_valid(&klein_bottle(1.5, 50, 21).unwrap());
    assert_valid(&linked_rings(3, 0.3, 12, 8).unwrap());
}

#[test]
fn bad_parameters_are_errors_before_memory_is_allocated() {
    let huge = usize::MAX;
    let refused = [
        geodesic_sphere(0),
        geodesic_sphere(huge),
        icosphere(u32::MAX),
        uv_sphere(2, 5),
        uv_sphere(huge, huge),
        cube_sphere(huge),
        bumpy_sphere(5, f64::NAN, 1.0),
        bumpy_sphere(5, 1.0, 1.0),
        cuboid([1.0, -1.0, 1.0], [1; 3]),
        cuboid([1.0; 3], [huge, 1, 1]),
        torus(1.0, 1.0, 8, 8),
        torus(1.0, f64::NAN, 8, 8),
        torus(1.0, 0.5, 2, 8),
        torus(f64::INFINITY, 0.5, 8, 8),
        cylinder(1.0, 1.0, huge, 1, Ends::Capped),
        cylinder(1.0, 0.0, 8, 1, Ends::Open),
        cone(1.0, 1.0, 0, 6),
        cone(1.0, 1.0, huge, 6),
        disk(huge, 6, 1.0),
        annulus(1.0, 1.0, 2, 8),
        annulus(2.0, 1.0, 2, 8),
        grid(0, 3, 1.0, 1.0, Diagonal::Uniform),
        grid(huge, huge, 1.0, 1.0, Diagonal::Uniform),
        strip(huge, 2),
        moebius_band(1.0, 2.0, 8, 2),
        klein_bottle(1.0, 8, 8),
        projective_plane(1),
        projective_plane(huge),
        chain_of_genus(0, 2),
        chain_of_genus(huge, 2),
        chain_of_genus(1, u32::MAX),
        clay_animal(0),
        handcuffs(0),
        joined_rings(0),
        knotted_tunnel(TunnelKnot::Trefoil, 0),
        knotted_tunnel(TunnelKnot::Trefoil, u32::MAX),
        punctured_torus(1.0, 0.4, 0.01, 20, 10),
        punctured_torus(1.0, 0.4, 2.3, 20, 10),
        punctured_torus(1.0, 0.4, f64::NAN, 20, 10),
        borromean_rings(u32::MAX),
        linked_rings(huge, 0.2, 8, 8),
        linked_rings(2, 0.4, 8, 8),
        trefoil_tube(0.0, 10, 10),
        trefoil_tube(0.1, huge, 10),
    ];
    for (i, result) in refused.into_iter().enumerate() {
        assert!(matches!(result, Err(MeshError::Parameter { .. })), "case {i}");
    }
}

#[test]
fn every_registered_shape_has_valid_defaults() {
    let mut made = 0;
    for shape in shape_descriptions() {
        let mesh = make(shape.name, &[]).unwrap_or_else(|e| panic!("{}: {e}", shape.name));
        assert_valid(&mesh);
        let again = make(&shape.name.replace('_', "-"), &[]).unwrap();
        assert_eq!((mesh.positions(), mesh.triangles()), (again.positions(), again.triangles()));
        // Every parameter is read: an invalid value is refused under its own name.
        for parameter in shape.parameters {
            match make(shape.name, &[(parameter.name, "nonsense")]) {
                Err(MeshError::Parameter { name, .. }) => assert_eq!(name, parameter.name),
                other => panic!("{} {}: {other:?}", shape.name, parameter.name),
            }
        }
        made += 1;
    }
    assert_eq!(made, shape_names().len());
    assert!(made >= 25);
}

#[test]
fn a_punctured_torus_has_one_loop_at_its_side() {
    let mesh = punctured_torus(1.0, 0.4, 0.5, 48, 24).unwrap();
    // 0.5 of 2 pi 1.4 and of 2 pi 0.4 are 3 and 5 cells.
    assert_eq!(mesh.face_count(), 2 * 48 * 24 - 2 * 3 * 5);
    assert_eq!(mesh.vertex_count(), 48 * 24 - 2 * 4);
    assert_valid(&mesh);
    assert!(is_oriented(&mesh));
    let boundary = mesh.edges().filter(|e| mesh.is_boundary_edge(*e)).count();
    assert_eq!(boundary, 2 * (3 + 5));
    let rim = mesh.vertices().filter(|v| mesh.is_boundary_vertex(*v));
    assert!(rim.map(|v| mesh.position(v)).all(|p| p[0] > 1.2 && p[1].abs() < 0.4 && p[2].abs() < 0.4));
}

#[test]
fn unknown_names_list_the_known_ones() {
    let Err(MeshError::UnknownName { known, .. }) = make("tetrahedorn", &[]) else { panic!() };
    assert_eq!(known[0], "tetrahedron");
    assert_eq!(known.len(), shape_names().len());
    let Err(MeshError::UnknownName { what, known, .. }) = make("torus", &[("mayor", "2")]) else { panic!() };
    assert_eq!((what, known[0], known.len()), ("parameter", "major", 4));
    assert!(matches!(
        make("torus", &[("nu", "8"), ("nu", "9")]),
        Err(MeshError::Parameter { name: "nu", .. })
    ));
    assert!(matches!(make("torus", &[("nu", "-8")]), Err(MeshError::Parameter { name: "nu", .. })));
    assert!(make(&"x".repeat(100_000), &[]).is_err());
}
