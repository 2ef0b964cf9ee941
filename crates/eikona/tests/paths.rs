//! Shortest paths: exact lengths on flat meshes and a cube, and properties that hold everywhere.

mod shapes;
use eikona::contour::polylines;
use eikona::curves::{shortest_vertex_path, straighten_curve};
use eikona_mesh::{Curve, SurfaceCurves, TriangleMesh, Vertex};
use shapes::{DATA, Random, cube, flat_grid, read_mesh, rough_grid, sphere, torus};

fn length(mesh: &TriangleMesh, curve: &Curve) -> f64 {
    let points = polylines(mesh, [curve]).unwrap().remove(0);
    points.windows(2).map(|p| (0..3).map(|k| (p[0][k] - p[1][k]).powi(2)).sum::<f64>().sqrt()).sum()
}

/// Returns the lengths before and after straightening the edge path between two vertices.
fn shorten(mesh: &TriangleMesh, a: u32, b: u32) -> (f64, f64) {
    let path = Curve::signed(shortest_vertex_path(mesh, &[Vertex(a), Vertex(b)]).unwrap());
    let straight = straighten_curve(mesh, &path).unwrap();
    assert_eq!(straight.nodes.first(), path.nodes.first());
    assert_eq!(straight.nodes.last(), path.nodes.last());
    if path.nodes.len() > 1 && a != b {
        SurfaceCurves::from_curve(straight.clone()).segments(mesh).unwrap();
    }
    let lengths = (length(mesh, &path), length(mesh, &straight));
    assert!(lengths.1 <= lengths.0);
    lengths
}

fn vertex_at(mesh: &TriangleMesh, p: [f64; 3]) -> u32 {
    let d = |q: &[f64; 3]| (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>();
    let nearest = mesh.vertices().min_by(|&a, &b| d(&mesh.position(a)).total_cmp(&d(&mesh.position(b))));
    nearest.unwrap().0
}

#[test]
fn on_flat_meshes_paths_become_straight_lines() {
    let rough = rough_grid(30, 3);
    let rough = rough.with_positions(rough.positions().iter().map(|p| [p[0], p[1], 0.0]).collect()).unwrap();
    for mesh in [flat_grid(30), rough] {
        let mut random = Random(9);
        for _ in 0..60 {
            let [a, b] = [0; 2].map(|_| (random.next() % mesh.vertex_count() as u64) as u32);
            if a == b {
                continue;
            }
            let (p, q) = (mesh.position(Vertex(a)), mesh.position(Vertex(b)));
            let exact = (p[0] - q[0]).hypot(p[1] - q[1]);
            let (before, after) = shorten(&mesh, a, b);
            assert!((after - exact).abs() < 1e-11, "{a} to {b}: {before} to {after}, exact {exact}");
        }
    }
}

#[test]
fn a_path_over_the_edge_of_a_cube_is_straight_in_the_net() {
    let mesh = cube(8);
    // From the centre of the top to the centre of a side, unfolded: 1. Off the centre: along the
    // diagonal of the net.
    let (_, across) = shorten(&mesh, vertex_at(&mesh, [0.5, 0.5, 1.0]), vertex_at(&mesh, [1.0, 0.5, 0.5]));
    assert!((across - 1.0).abs() < 1e-12);
    let (before, askew) =
        shorten(&mesh, vertex_at(&mesh, [0.5, 0.25, 1.0]), vertex_at(&mesh, [1.0, 0.75, 0.5]));
    println!("cube: {before} to {askew}");
    assert!((askew - 1.25f64.sqrt()).abs() < 1e-12, "{askew}");
}

#[test]
fn around_a_hole_the_path_touches_its_corners() {
    let mesh = flat_grid(20);
    let keep: Vec<[u32; 3]> = mesh
        .triangles()
        .iter()
        .copied()
        .filter(|f| {
            let p = f.map(|v| mesh.position(Vertex(v)));
            let c = [0, 1].map(|k| (p[0][k] + p[1][k] + p[2][k]) / 3.0);
            !((c[0] - 0.5).abs() < 0.2 && (c[1] - 0.5).abs() < 0.2)
        })
        .collect();
    let mesh = TriangleMesh::new(mesh.positions().to_vec(), keep).unwrap();
    let (_, found) = shorten(&mesh, vertex_at(&mesh, [0.1, 0.5, 0.0]), vertex_at(&mesh, [0.9, 0.5, 0.0]));
    let exact = 2.0 * 0.2 * 2f64.sqrt() + 0.4;
    assert!((found - exact).abs() < 1e-12, "{found} {exact}");
}

#[test]
fn on_the_sphere_paths_become_great_circles() {
    let mesh = sphere(4);
    let mut random = Random(4);
    for _ in 0..40 {
        let [a, b] = [0; 2].map(|_| (random.next() % mesh.vertex_count() as u64) as u32);
        let (p, q) = (mesh.position(Vertex(a)), mesh.position(Vertex(b)));
        let exact = (0..3).map(|k| p[k] * q[k]).sum::<f64>().clamp(-1.0, 1.0).acos();
        if a != b {
            let (_, after) = shorten(&mesh, a, b);
            assert!(after < 1.01 * exact && after > 0.99 * exact, "{after} {exact}");
        }
    }
}

#[test]
fn straight_paths_are_unchanged_and_no_path_gets_longer() {
    for (seed, mesh) in [rough_grid(25, 5), torus(30, 15, 0.3), sphere(3)].into_iter().enumerate() {
        let mut random = Random(seed as u64);
        for _ in 0..20 {
            // A long detour through five vertices.
            let through: Vec<Vertex> =
                (0..5).map(|_| Vertex((random.next() % mesh.vertex_count() as u64) as u32)).collect();
            let path = Curve::signed(shortest_vertex_path(&mesh, &through).unwrap());
            let once = straighten_curve(&mesh, &path).unwrap();
            let twice = straighten_curve(&mesh, &once).unwrap();
            let [l0, l1, l2] = [&path, &once, &twice].map(|c| length(&mesh, c));
            assert!(l1 <= l0 && l2 <= l1 && l2 > 0.999 * l1, "{l0} {l1} {l2}");
        }
    }
}

#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn paths_on_meshes_of_the_data_folder() {
    let mut run = 0;
    for name in [
        "closed/bunny.obj",
        "closed/fertility.off",
        "boundary/lilium.obj",
        "badquality/chassis.off",
        "badquality/capsule.obj",
        "nonmanifold/screwdriver.obj",
        "nonorientable/klein_bottle_2.obj",
    ] {
        let mesh = read_mesh(format!("{DATA}/{name}")).expect(name);
        run += 1;
        let mut random = Random(11);
        let start = std::time::Instant::now();
        let mut sums = (0.0, 0.0);
        for _ in 0..20 {
            let [a, b] = [0; 2].map(|_| (random.next() % mesh.vertex_count() as u64) as u32);
            if a == b || shortest_vertex_path(&mesh, &[Vertex(a), Vertex(b)]).is_err() {
                continue;
            }
            let (before, after) = shorten(&mesh, a, b);
            sums = (sums.0 + before, sums.1 + after);
        }
        println!("{name}: {:.4} to {:.4} in {:?}", sums.0, sums.1, start.elapsed());
    }
    println!("paths on {run} files");
}
