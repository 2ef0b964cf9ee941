//! Validation reports every fault; quality agrees with closed formulas.

use crate::shapes::{book, cube, grid, mesh};
use eikona_mesh::{Edge, Face, Fault, Quality, TriangleMesh, Vertex, validate};

#[test]
fn valid_meshes_have_no_faults() {
    assert_eq!(validate(&cube()), []);
    assert_eq!(validate(&grid(3, 3)), []);
}

#[test]
fn every_fault_is_reported_in_order() {
    let positions = vec![
        [0., 0., 0.],
        [1., 0., 0.],
        [0., 1., 0.],
        [1., 1., 0.],
        [-0., 0., 0.], // 4: on vertex 0
        [2., 0., 0.],
        [7., 7., 7.], // 6: unreferenced
        [5., 5., 1.],
        [6., 5., 1.],
    ];
    let faces = vec![
        [0, 1, 2],
        [1, 2, 3], // runs along edge 1 2 as the first face does
        [4, 1, 5], // three collinear points; touches vertex 1 with a second fan
        [2, 1, 0], // the first face again: edge 1 2 has three faces
        [7, 8, 3],
    ];
    let faults = validate(&mesh(positions, faces));
    let v = Vertex;
    assert_eq!(
        faults,
        [
            Fault::UnreferencedVertex { vertex: v(6) },
            Fault::CoincidentVertices { vertex: v(4), first: v(0) },
            Fault::ZeroArea { face: Face(2), area: 0.0 },
            Fault::DuplicateFace { face: Face(3), first: Face(0) },
            Fault::NonmanifoldEdge { edge: Edge(1), vertices: [v(1), v(2)], faces: 3 },
            Fault::NonmanifoldVertex { vertex: v(1), fans: 2 },
            Fault::NonmanifoldVertex { vertex: v(3), fans: 2 },
        ]
    );
    let twisted =
        mesh(vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., 1., 0.]], vec![[0, 1, 2], [1, 2, 3]]);
    assert_eq!(
        validate(&twisted),
        [Fault::InconsistentOrientation { edge: Edge(1), vertices: [v(1), v(2)] }]
    );
    assert!(validate(&book(3)).contains(&Fault::NonmanifoldEdge {
        edge: Edge(0),
        vertices: [v(0), v(1)],
        faces: 3
    }));
}

fn triangle(apex: [f64; 3]) -> TriangleMesh {
    mesh(vec![[0., 0., 0.], [1., 0., 0.], apex], vec![[0, 1, 2]])
}

#[test]
fn zero_area_begins_at_the_documented_bound() {
    // Area h / 2, longest edge 1.
    let zero_area = |h: f64| Quality::of(&triangle([0.5, h, 0.])).zero_area_faces;
    assert_eq!((zero_area(1.9e-14), zero_area(2.1e-14)), (1, 0));
}

fn near(a: Option<f64>, b: f64) -> bool {
    a.is_some_and(|a| (a - b).abs() <= 1e-12 * b.abs().max(1.0))
}

#[test]
fn quality_of_single_triangles() {
    let equilateral = Quality::of(&triangle([0.5, 0.75f64.sqrt(), 0.]));
    assert!(near(equilateral.min_angle_deg, 60.0) && near(equilateral.max_angle_deg, 60.0));
    assert!(near(equilateral.aspect_ratio.map(|r| r.max), 1.0));
    assert!(near(Some(equilateral.area), 0.75f64.sqrt() / 2.0));
    assert_eq!(equilateral.bounding_box, Some([[0., 0., 0.], [1., 0.75f64.sqrt(), 0.]]));

    let right = Quality::of(&triangle([0., 1., 0.]));
    assert!(near(right.min_angle_deg, 45.0) && near(right.max_angle_deg, 90.0));
    // Inradius 1 / (2 + sqrt 2), longest edge sqrt 2.
    assert!(near(right.aspect_ratio.map(|r| r.mean), (2.0 + 2f64.sqrt()) / 6f64.sqrt()));
    assert!(near(right.edge_length.map(|r| r.mean), (2.0 + 2f64.sqrt()) / 3.0));

    // A needle: the angle at the far end is the height over the length, to full relative accuracy.
    let needle = mesh(vec![[0., 0., 0.], [1e9, 0., 0.], [0., 1e-3, 0.]], vec![[0, 1, 2]]);
    let angle = Quality::of(&needle).min_angle_deg.map(|a| a.to_radians() / 1e-12);
    assert!(near(angle, 1.0));
}

#[test]
fn quality_of_degenerate_and_empty_meshes_is_never_nan() {
    let points = [
        [[0., 0., 0.]; 3],
        [[0., 0., 0.], [1., 0., 0.], [0., 0., 0.]],
        [[0., 0., 0.], [1., 0., 0.], [3., 0., 0.]],
    ];
    for corners in points {
        let quality = Quality::of(&mesh(corners.to_vec(), vec![[0, 1, 2]]));
        assert_eq!((quality.zero_area_faces, quality.area), (1, 0.0));
        assert_eq!((quality.min_angle_deg, quality.aspect_ratio), (Some(0.0), None));
        assert!(!format!("{quality:?}").contains("NaN"));
    }
    let flat = Quality::of(&mesh(points[2].to_vec(), vec![[0, 1, 2]]));
    assert_eq!(flat.max_angle_deg, Some(180.0));
    let empty = Quality::of(&mesh(vec![[1., 2., 3.]], vec![]));
    assert_eq!((empty.edge_length, empty.bounding_box, empty.area), (None, None, 0.0));
    let huge = mesh(vec![[-1.7e308, 0., 0.], [1.7e308, 0., 0.], [0., 1.7e308, 0.]], vec![[0, 1, 2]]);
    assert!(!format!("{:?}", Quality::of(&huge)).contains("NaN"));
    assert!(near(Quality::of(&huge).max_angle_deg, 90.0));
}

#[test]
fn non_delaunay_edges() {
    // Two triangles on the edge from (-1, 0) to (1, 0) with apexes at (0, +-h): opposite angles of
    // 2 atan(1 / h) each.
    let pair = |h: f64| {
        let positions = vec![[-1., 0., 0.], [1., 0., 0.], [0., h, 0.], [0., -h, 0.]];
        Quality::of(&mesh(positions, vec![[0, 1, 2], [1, 0, 3]])).non_delaunay_edges
    };
    assert_eq!((pair(0.999), pair(1.0), pair(1.001)), (1, 0, 0));
    // All diagonals of a square grid lie on the limit, and none counts, whatever the rotation of
    // the grid.
    let flat = grid(20, 20);
    for angle in [0.0, 0.3, 0.7, 1.1] {
        let (s, c) = f64::sin_cos(angle);
        let turned = flat
            .positions()
            .iter()
            .map(|p| [c * p[0] - s * p[1], c * (s * p[0] + c * p[1]), s * (s * p[0] + c * p[1])]);
        let turned = flat.with_positions(turned.collect()).expect("finite");
        assert_eq!(Quality::of(&turned).non_delaunay_edges, 0, "rotated by {angle}");
    }
}

#[test]
fn percentile_interpolates_between_values() {
    // 101 faces: the 1st percentile is the second smallest, the 99th the second largest.
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for k in 0..101u32 {
        let angle = (10.0 + 0.2 * ((k * 37) % 101) as f64).to_radians();
        let x = 10.0 * k as f64;
        positions.extend([[x, 0., 0.], [x + 1., 0., 0.], [x + angle.cos(), angle.sin(), 0.]]);
        faces.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    let quality = Quality::of(&mesh(positions, faces));
    assert!(quality.min_angle_deg.is_some_and(|a| (a - 10.0).abs() < 1e-9));
    assert!(quality.min_angle_percentile_1_deg.is_some_and(|a| (a - 10.2).abs() < 1e-9));
}
