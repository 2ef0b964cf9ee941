//! Polygons that visit a vertex twice: bridges to holes, pinches, dead ends.

use super::*;
use eikona_mesh::{Fault, PolygonQuality, drop_broken_polygons};

fn mesh_of(points: &[[f64; 2]], corners: &[u32]) -> PolygonMesh {
    let mut mesh = PolygonMesh::new(flat(points));
    mesh.push_face(corners.iter().copied());
    mesh
}

/// Checks `covered` from every first corner and in both orientations, and that the repair keeps the
/// polygon.
#[track_caller]
fn covered_from_everywhere(points: &[[f64; 2]], corners: &[u32], count: usize, area: f64) {
    for first in 0..corners.len() {
        let mut turned = corners.to_vec();
        turned.rotate_left(first);
        for _ in 0..2 {
            turned.reverse();
            let mesh = mesh_of(points, &turned);
            covered(&mesh, count, area);
            assert_eq!(PolygonQuality::of(&mesh).self_crossing, []);
            assert_eq!(drop_broken_polygons(&mesh).mesh, mesh);
        }
    }
}

/// A square of side 3 with a square hole of side 1 in its middle.
const RING: [[f64; 2]; 8] = [[0., 0.], [3., 0.], [3., 3.], [0., 3.], [1., 1.], [1., 2.], [2., 2.], [2., 1.]];

// reports.md F22
#[test]
fn a_keyhole_polygon_is_the_square_without_its_hole() {
    covered_from_everywhere(&RING, &[0, 1, 2, 3, 0, 4, 5, 6, 7, 4], 8, 8.0);
}

#[test]
fn the_bridge_may_have_vertices_of_its_own() {
    // Halfway along the bridge, traversed in both directions.
    let mut points = RING.to_vec();
    points.push([0.5, 0.5]);
    covered_from_everywhere(&points, &[0, 1, 2, 3, 0, 8, 4, 5, 6, 7, 4, 8], 10, 8.0);
    // Coordinates repeated under other indices.
    points[8] = RING[0];
    points.push(RING[4]);
    covered_from_everywhere(&points, &[0, 1, 2, 3, 8, 9, 5, 6, 7, 4], 8, 8.0);
}

#[test]
fn several_holes_may_be_bridged_to_one_vertex_or_to_each_other() {
    // Holes of area 1 at (1,1), (3,1), (5,1) in a 7 x 3 box.
    let mut points = vec![[0., 0.], [7., 0.], [7., 3.], [0., 3.]];
    for x in [1., 3., 5.] {
        points.extend([[x, 1.], [x, 2.], [x + 1., 2.], [x + 1., 1.]]);
    }
    // In a row: from corner 0 to the first, from that one to the next.
    let row = [
        0, 1, 2, 3, 0, 4, 5, 6, // to the far side of the first hole
        9, 10, 13, 14, 15, 12, 13, 10, 11, 8, 9, // the second, bridged to the third
        6, 7, 4,
    ];
    covered_from_everywhere(&points, &row, row.len() - 2, 21.0 - 3.0);
    // The first hole from corner 0, the third from corner 1, the second from the first.
    let two = [0, 1, 15, 12, 13, 14, 15, 1, 2, 3, 0, 4, 5, 6, 9, 10, 11, 8, 9, 6, 7, 4];
    covered_from_everywhere(&points, &two, two.len() - 2, 18.0);
}

#[test]
fn two_holes_may_be_bridged_to_the_same_corner() {
    let points = [
        [0., 0.],
        [9., 0.],
        [9., 9.],
        [0., 9.],
        // a triangle low and to the right, one high and to the left
        [4., 1.],
        [4., 2.],
        [6., 2.],
        [1., 4.],
        [2., 6.],
        [2., 4.],
    ];
    // Both triangles clockwise: areas 1.
    let corners = [0, 1, 2, 3, 0, 7, 8, 9, 7, 0, 4, 5, 6, 4];
    covered_from_everywhere(&points, &corners, 12, 81.0 - 1.0 - 1.0);
}

#[test]
fn a_hole_may_touch_the_boundary_at_a_vertex() {
    // A square of side 3; a clockwise triangle of area 1/2 touches corner 0.
    let points = [[0., 0.], [3., 0.], [3., 3.], [0., 3.], [1., 2.], [2., 2.]];
    let area = 9.0 - 0.5 * 2.0;
    covered_from_everywhere(&points, &[0, 1, 2, 3, 0, 4, 5], 5, area);
}

#[test]
fn a_figure_eight_without_crossing_separates_into_two_parts() {
    // Two triangles of areas 1 and 4 that share vertex 2: 1 + 1 triangles instead of 6 - 2.
    let points = [[-1., 1.], [-1., -1.], [0., 0.], [2., -2.], [2., 2.]];
    covered_from_everywhere(&points, &[0, 1, 2, 3, 4, 2], 2, 1.0 + 4.0);
    // Two Ls with a common corner.
    let points = [
        [0., 0.],
        [2., 0.],
        [2., 1.],
        [1., 1.],
        [1., 2.],
        [0., 2.],
        [-2., 0.],
        [-2., -1.],
        [-1., -1.],
        [-1., -2.],
        [0., -2.],
    ];
    covered_from_everywhere(&points, &[0, 1, 2, 3, 4, 5, 0, 6, 7, 8, 9, 10], 8, 6.0);
}

#[test]
fn dead_ends_are_removed() {
    let points = [[0., 0.], [3., 0.], [3., 3.], [0., 3.], [1., 1.], [-1., -1.], [1., 2.]];
    for dead_end in [&[4][..], &[5], &[4, 6, 4], &[4, 2, 4], &[5, 3, 5], &[4, 0, 5]] {
        let corners = [&[0][..], dead_end, &[0, 1, 2, 3]].concat();
        covered_from_everywhere(&points, &corners, 2, 9.0);
    }
}

#[test]
fn a_part_may_follow_a_dead_end() {
    // A triangle of area 1/2 at the end of an edge traversed in both directions.
    let points = [[0., 0.], [3., 0.], [3., 3.], [0., 3.], [-1., 0.], [-2., 0.], [-2., -1.]];
    covered_from_everywhere(&points, &[0, 1, 2, 3, 0, 4, 5, 6, 4], 3, 9.5);
}

#[test]
fn a_polygon_with_a_repeated_vertex_and_no_area_is_a_fault() {
    let points = [[0., 0.], [1., 0.], [2., 0.], [3., 1.]];
    for (corners, vertex) in [
        (&[0, 1, 0, 1][..], 0),
        (&[0, 3, 0, 3], 0),
        (&[0, 1, 2, 1], 1),
        (&[0, 1, 3, 1], 1),
        (&[0, 1, 3, 1, 0, 3], 1),
    ] {
        let mesh = mesh_of(&points, corners);
        let fault = Fault::RepeatedVertex { face: Face(0), vertex: Vertex(vertex) };
        assert_eq!(mesh.triangulate().unwrap_err(), MeshError::Invalid(vec![fault]), "{corners:?}");
        assert_eq!(drop_broken_polygons(&mesh).mesh.face_count(), 0);
    }
}

#[test]
fn successive_corners_at_one_vertex_are_a_fault_even_in_a_keyhole() {
    for corners in [&[0, 1, 1, 2, 3][..], &[0, 1, 2, 3, 0], &[0, 1, 2, 3, 0, 4, 5, 6, 6, 7, 4]] {
        let mesh = mesh_of(&RING, corners);
        let error = mesh.triangulate().unwrap_err();
        let MeshError::Invalid(faults) = &error else { panic!("{error}") };
        assert!(matches!(faults[..], [Fault::RepeatedVertex { .. }]), "{error}");
        // The repair removes the corner, not the polygon.
        let repaired = drop_broken_polygons(&mesh).mesh;
        assert_eq!(repaired.face(0).len(), corners.len() - 1);
        assert!(repaired.triangulate().is_ok());
    }
}
