//! Closest points: the tree against brute force over all triangles.

mod shapes;
use eikona::spatial::{Bvh, closest_point_of_triangle};
use eikona_mesh::{Face, TriangleMesh};
use shapes::{Random, cube, rough_grid, sphere};

fn nearest_of_all(mesh: &TriangleMesh, p: [f64; 3]) -> (Face, f64) {
    let mut best = (Face(0), f64::INFINITY);
    for f in mesh.faces() {
        let (_, _, d) = closest_point_of_triangle(p, mesh.face_positions(f));
        if d < best.1 {
            best = (f, d);
        }
    }
    (best.0, best.1.sqrt())
}

fn agree(mesh: &TriangleMesh, points: usize, seed: u64) {
    let bvh = Bvh::new(mesh);
    let mut random = Random(seed);
    for i in 0..points {
        // Vertices are the hardest ties: all their faces are equally near.
        let p = if i % 3 == 0 {
            mesh.positions()[random.next() as usize % mesh.vertex_count()]
        } else {
            random.point(-1.5, 1.5)
        };
        let closest = bvh.closest_point(p).unwrap();
        assert_eq!((closest.face, closest.distance), nearest_of_all(mesh, p));
        let corners = mesh.face_positions(closest.face);
        let again = [0, 1, 2].map(|k| (0..3).map(|c| closest.weights[c] * corners[c][k]).sum::<f64>());
        assert!((0..3).all(|k| (again[k] - closest.position[k]).abs() < 1e-15));
        assert!(closest.weights.iter().all(|w| (0.0..=1.0).contains(w)));
    }
}

#[test]
fn the_tree_agrees_with_brute_force() {
    agree(&sphere(3), 300, 1);
    agree(&rough_grid(20, 2), 300, 2);
    agree(&cube(5), 300, 3);
}

#[test]
fn zero_area_triangles_act_as_segments() {
    let positions = vec![[0., 0., 0.], [1., 0., 0.], [2., 0., 0.], [2., 0., 0.], [0., 1e-13, 0.]];
    let faces = vec![[0, 1, 2], [1, 2, 3], [0, 2, 4]];
    let mesh = TriangleMesh::new(positions, faces).unwrap();
    agree(&mesh, 200, 4);
    let closest = Bvh::new(&mesh).closest_point([1.5, 3.0, 4.0]).unwrap();
    assert!((closest.distance - 5.0).abs() < 1e-12);
    assert!((closest.position[0] - 1.5).abs() < 1e-12);
}

#[test]
fn the_distance_to_a_fine_sphere_converges_to_the_exact_one() {
    let bvh = Bvh::new(&sphere(5));
    let mut random = Random(5);
    for _ in 0..200 {
        let p = random.point(-3.0, 3.0);
        let radius = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!((bvh.closest_point(p).unwrap().distance - (radius - 1.0).abs()).abs() < 1e-3);
    }
}

#[test]
fn empty_meshes_and_infinite_points_have_no_closest_point() {
    let empty = TriangleMesh::new(vec![], vec![]).unwrap();
    assert!(Bvh::new(&empty).closest_point([0.0; 3]).is_none());
    let bvh = Bvh::new(&sphere(0));
    assert!(bvh.closest_point([f64::NAN, 0.0, 0.0]).is_none());
    assert!(bvh.closest_point([f64::INFINITY, 0.0, 0.0]).is_none());
    assert!(bvh.closest_point([1e300, 0.0, 0.0]).is_some());
}

/// Prints the time; the documented figure is half a second per million faces on a quiet machine.
#[test]
fn a_million_faces() {
    let mesh = shapes::flat_grid(708);
    let start = std::time::Instant::now();
    let bvh = Bvh::new(&mesh);
    let built = start.elapsed();
    let mut random = Random(6);
    for _ in 0..10_000 {
        let p = random.point(0.0, 1.0);
        assert!((bvh.closest_point(p).unwrap().distance - p[2]).abs() < 1e-12);
    }
    println!(
        "{} faces: tree in {built:?}, 10000 queries in {:?}",
        mesh.face_count(),
        start.elapsed() - built
    );
    assert!(built.as_secs() < 10);
}
