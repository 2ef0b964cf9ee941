//! Remeshing: quality, shape, topology, boundaries, collisions, and data that follows.

use eikona::mesh::shapes::Diagonal;
use eikona::mesh::{Topology, TriangleMesh, Vertex, shapes};
use eikona::remesh::{RemeshError, RemeshOptions, Remeshed, remesh};
use eikona::repulsive::Quantity;
use eikona::spatial::{self_distance, self_intersections};

type Vec3 = [f64; 3];

fn run(mesh: &TriangleMesh, length: f64, options: &RemeshOptions) -> Remeshed {
    remesh(mesh, &vec![length; mesh.vertex_count()], options).unwrap()
}

fn moved(mesh: &TriangleMesh, map: impl Fn(Vec3) -> Vec3) -> TriangleMesh {
    mesh.with_positions(mesh.positions().iter().map(|&p| map(p)).collect()).unwrap()
}

fn together(a: &TriangleMesh, b: &TriangleMesh) -> TriangleMesh {
    let count = a.vertex_count() as u32;
    let faces = b.triangles().iter().map(|t| t.map(|v| v + count));
    TriangleMesh::new(
        [a.positions(), b.positions()].concat(),
        a.triangles().iter().copied().chain(faces).collect(),
    )
    .unwrap()
}

fn square(cells: usize) -> TriangleMesh {
    shapes::grid(cells, cells, 1.0, 1.0, Diagonal::Alternating).unwrap()
}

fn euler(mesh: &TriangleMesh) -> i64 {
    mesh.vertex_count() as i64 - mesh.edge_count() as i64 + mesh.face_count() as i64
}

fn length(mesh: &TriangleMesh, [a, b]: [Vertex; 2]) -> f64 {
    let [a, b] = [a, b].map(|v| mesh.position(v));
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

fn lengths(mesh: &TriangleMesh) -> Vec<f64> {
    let mut lengths: Vec<f64> = mesh.edges().map(|e| length(mesh, mesh.edge_vertices(e))).collect();
    lengths.sort_by(f64::total_cmp);
    lengths
}

/// The smallest angle of each face in degrees, in increasing order.
fn angles(mesh: &TriangleMesh) -> Vec<f64> {
    let smallest = |f| {
        let corners = mesh.face_vertices(f);
        let [a, b, c] = [0, 1, 2].map(|k| length(mesh, [corners[k], corners[(k + 1) % 3]]));
        let angle =
            |a: f64, b: f64, c: f64| ((a * a + b * b - c * c) / (2.0 * a * b)).clamp(-1.0, 1.0).acos();
        angle(a, b, c).min(angle(b, c, a)).min(angle(c, a, b)).to_degrees()
    };
    let mut angles: Vec<f64> = mesh.faces().map(smallest).collect();
    angles.sort_by(f64::total_cmp);
    angles
}

fn is_manifold(mesh: &TriangleMesh) -> bool {
    let topology = Topology::of(mesh);
    topology.nonmanifold_edges.is_empty() && topology.nonmanifold_vertices.is_empty()
}

/// A surface with uneven faces: steep stretching in one direction.
fn uneven(mesh: &TriangleMesh) -> TriangleMesh {
    moved(mesh, |[x, y, z]| [x, y, z + 0.6 * (2.0 * x).sin()])
}

#[test]
fn faces_get_even_and_the_surface_keeps_its_shape() {
    for (name, mesh) in [
        ("sphere", shapes::icosphere(4).unwrap()),
        ("torus", shapes::torus(1.0, 0.4, 90, 12).unwrap()),
        ("wave", uneven(&shapes::icosphere(4).unwrap())),
        ("rings", shapes::linked_rings(2, 0.3, 60, 24).unwrap()),
    ] {
        let before = lengths(&mesh);
        let mean = before.iter().sum::<f64>() / before.len() as f64;
        let done = run(&mesh, mean, &RemeshOptions::default());
        assert!(is_manifold(&done.mesh), "{name}");
        assert_eq!(euler(&done.mesh), euler(&mesh), "{name}");
        assert!(done.mesh.is_consistently_oriented(), "{name}");
        assert!(self_intersections(&done.mesh, 1).unwrap().is_empty(), "{name}");
        for quantity in [Quantity::Area, Quantity::Volume] {
            let [old, new] = [&mesh, &done.mesh].map(|mesh| quantity.of(mesh));
            assert!((new / old - 1.0).abs() < 0.02, "{name} {quantity:?}: {old} became {new}");
        }
        let (lengths, angles) = (lengths(&done.mesh), angles(&done.mesh));
        let [low, high] = [0.01, 0.99].map(|share| lengths[(share * lengths.len() as f64) as usize] / mean);
        assert!(low > 0.5 && high < 1.5, "{name}: lengths {low} to {high}");
        let few = angles[angles.len() / 100];
        assert!(few > 20.0, "{name}: one face in a hundred has an angle below {few} degrees");
    }
}

#[test]
fn orientation_does_not_matter() {
    let mesh = uneven(&shapes::icosphere(3).unwrap());
    let mixed = mesh.with_flipped_faces(|f| f.0 % 3 == 0);
    let [one, other] = [&mesh, &mixed].map(|mesh| run(mesh, 0.2, &RemeshOptions::default()));
    assert!(is_manifold(&other.mesh));
    assert_eq!(euler(&other.mesh), 2);
    let area = Quantity::Area.of(&mesh);
    for done in [one, other] {
        let off = Quantity::Area.of(&done.mesh) / area - 1.0;
        assert!(off.abs() < 0.01, "{off}");
        assert!(self_intersections(&done.mesh, 1).unwrap().is_empty());
    }
}

#[test]
fn boundaries_keep_their_corners() {
    let square = square(9);
    for length in [0.03, 0.1, 0.4] {
        let done = run(&square, length, &RemeshOptions::default());
        assert!(is_manifold(&done.mesh));
        assert_eq!(euler(&done.mesh), 1);
        let [old, new] = [&square, &done.mesh].map(|mesh| Quantity::Area.of(mesh));
        assert!((old - new).abs() < 1e-12, "{length}: {old} became {new}");
        assert!(angles(&done.mesh)[0] > 15.0, "{length}: {}", angles(&done.mesh)[0]);
    }
}

#[test]
fn fixed_vertices_stay() {
    let mesh = uneven(&shapes::icosphere(3).unwrap());
    let fixed: Vec<Vertex> = [3, 77, 200, 201].map(Vertex).to_vec();
    for length in [0.08, 0.5] {
        let done = run(&mesh, length, &RemeshOptions::default().with_fixed(fixed.clone()));
        let [before, after] = [(&mesh, &fixed), (&done.mesh, &done.fixed)]
            .map(|(mesh, fixed)| fixed.iter().map(|v| mesh.position(*v)).collect::<Vec<_>>());
        assert_eq!(before, after);
    }
}

#[test]
fn sheets_that_nearly_touch_stay_apart() {
    // Two wavy sheets, much closer to each other than their faces are wide.
    let sheet = |cells: usize, height: f64| {
        moved(&square(cells), |[x, y, _]| [x, y, 0.08 * (7.0 * x).sin() * (6.0 * y).cos() + height])
    };
    for gap in [0.05, 0.01, 0.002] {
        let sheets = together(&sheet(96, 0.0), &sheet(85, gap));
        assert!(self_intersections(&sheets, 1).unwrap().is_empty());
        let done = run(&sheets, 0.09, &RemeshOptions::default());
        assert!(done.counts.changed());
        assert!(self_intersections(&done.mesh, 1).unwrap().is_empty(), "{gap}");
        assert!(self_distance(&done.mesh, 1).unwrap() > 0.0);
        // Without the tests of collisions the closer ones do touch.
        let careless = run(&sheets, 0.09, &RemeshOptions::default().with_collisions(false));
        let touching = !self_intersections(&careless.mesh, 1).unwrap().is_empty();
        assert_eq!(touching, gap < 0.005, "{gap}");
    }
}

#[test]
fn data_follow_the_surface() {
    let mesh = uneven(&shapes::icosphere(4).unwrap());
    let done = run(&mesh, 0.1, &RemeshOptions::default());
    let faces = done.mesh.triangles();
    let heights: Vec<Vec3> = mesh.positions().to_vec();
    let pulled = done.places.pull_vertices(&mesh, &heights);
    for (p, q) in done.mesh.positions().iter().zip(&pulled) {
        assert!((0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt() < 0.02, "{p:?} {q:?}");
    }
    // Halves with different values: they meet at x = 0, and nothing in between comes up.
    let side = |points: [Vec3; 3]| points.iter().map(|p| p[0]).sum::<f64>() > 0.0;
    let parents = done.places.parents(&mesh, faces);
    let corners: Vec<[[f64; 1]; 3]> =
        mesh.faces().map(|f| [[if side(mesh.face_positions(f)) { 1.0 } else { -1.0 }]; 3]).collect();
    let pulled = done.places.pull_corners(&mesh, faces, &corners);
    for ((f, parent), values) in done.mesh.faces().zip(parents).zip(pulled) {
        let near = done.mesh.face_positions(f).iter().all(|p| p[0].abs() < 0.15);
        assert!(near || side(done.mesh.face_positions(f)) == side(mesh.face_positions(parent)));
        for value in values {
            assert!(value[0].abs() > 1.0 - 1e-12, "{value:?}");
            assert!((value[0] - values[0][0]).abs() < 1e-12, "a face has values of both sides: {values:?}");
        }
    }
}

#[test]
fn threads_do_not_matter() {
    let mesh = uneven(&shapes::icosphere(3).unwrap());
    let on = |threads: usize| run(&mesh, 0.06, &RemeshOptions::default().with_threads(threads));
    let one = on(1);
    for threads in [2, 3] {
        let other = on(threads);
        assert_eq!(one.mesh.positions(), other.mesh.positions());
        assert_eq!(one.mesh.triangles(), other.mesh.triangles());
        assert_eq!(one.places, other.places);
    }
}

#[test]
fn small_surfaces_do_not_vanish() {
    for mesh in [shapes::icosphere(1).unwrap(), shapes::torus(1.0, 0.3, 8, 4).unwrap()] {
        let done = run(&mesh, 100.0, &RemeshOptions::default());
        assert!(done.mesh.face_count() >= 4);
        assert_eq!(euler(&done.mesh), euler(&mesh));
        assert!(is_manifold(&done.mesh));
        assert!(self_intersections(&done.mesh, 1).unwrap().is_empty());
    }
}

#[test]
fn faults_name_the_element() {
    let mesh = shapes::icosphere(1).unwrap();
    let options = RemeshOptions::default();
    let fault =
        |sizes: &[f64], options: &RemeshOptions| remesh(&mesh, sizes, options).unwrap_err().to_string();
    assert!(fault(&[0.1; 41], &options).contains("41 lengths are given for 42 vertices"));
    let mut sizes = [0.1; 42];
    sizes[7] = -1.0;
    assert!(fault(&sizes, &options).contains("vertex 7 is -1"), "{}", fault(&sizes, &options));
    assert!(fault(&[f64::NAN; 42], &options).contains("NaN"));
    let options = options.with_fixed(vec![Vertex(42)]);
    assert!(fault(&[0.1; 42], &options).contains("42 vertices"));
    let book = TriangleMesh::new(
        vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [0., -1., 0.]],
        vec![[0, 1, 2], [0, 1, 3], [0, 1, 4]],
    )
    .unwrap();
    let fault = remesh(&book, &[0.1; 5], &RemeshOptions::default()).unwrap_err();
    assert!(matches!(fault, RemeshError::Nonmanifold { .. }), "{fault}");
}

#[test]
fn a_huge_face_among_small_ones_is_split_in_many_rounds() {
    let dust = moved(&shapes::icosphere(4).unwrap(), |p| p.map(|x| 1e-3 * x));
    let wall = TriangleMesh::new(vec![[1., 0., 0.], [9., 3., 1.], [2., 9., 4.]], vec![[0, 1, 2]]).unwrap();
    let both = together(&dust, &wall);
    let done = run(&both, 1e-4, &RemeshOptions::default().with_rounds(1));
    assert!(is_manifold(&done.mesh));
    // The wall is still far from done, but no more than a few times as many faces are made.
    assert!(done.counts.splits > 10_000 && done.mesh.face_count() < 100_000, "{:?}", done.counts);
    let lengths = lengths(&done.mesh);
    let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
    assert!(mean > 1e-4);
}
