//! Polygons that cross themselves, or have no plane or no finite corners: the result is always
//! defined.

use super::*;
use eikona_mesh::random::Random;
use eikona_mesh::{Fault, PolygonQuality};

#[track_caller]
fn reported(mesh: &PolygonMesh) -> Vec<[u32; 3]> {
    let triangles = triangles_of(mesh).unwrap().swap_remove(0);
    assert_eq!(triangles.len(), mesh.face(0).len() - 2);
    assert_eq!(PolygonQuality::of(mesh).self_crossing, [Face(0)]);
    triangles
}

#[test]
fn a_bow_tie_is_reported() {
    // Equal loops, whose areas cancel, and unequal ones; flat, tilted and far away.
    for top in [1.0, 3.0] {
        let points = [[0., 0.], [1., 1.], [1., 0.], [0., top]];
        reported(&polygon(flat(&points)));
        let tilted = |[x, y]: [f64; 2]| [0.6 * x + 5e5, 0.3 * x + y / 3.0 + 4e6, 0.7 * y - 0.2 * x];
        reported(&polygon(points.map(tilted).to_vec()));
    }
}

#[test]
fn a_pentagram_is_reported() {
    let corner = |k: usize| {
        let (s, c) = (4.0 * std::f64::consts::PI / 5.0 * k as f64).sin_cos();
        [c, s, 0.0]
    };
    reported(&polygon((0..5).map(corner).collect()));
}

#[test]
fn a_figure_eight_that_crosses_at_a_vertex_is_reported() {
    // The second triangle, clockwise, is smaller, equal or larger.
    for size in [0.5, 1.0, 2.0] {
        let mut mesh =
            PolygonMesh::new(flat(&[[-1., 1.], [-1., -1.], [0., 0.], [size, size], [size, -size]]));
        mesh.push_face([0, 1, 2, 3, 4, 2]);
        let parts = triangles_of(&mesh).unwrap();
        assert_eq!(parts[0].len(), 2);
        assert_eq!(PolygonQuality::of(&mesh).self_crossing, [Face(0)]);
    }
}

#[test]
fn a_spiral_that_overlaps_its_own_fan_is_reported() {
    // One and a half turns around the first corner.
    let turn = |k: usize| {
        let (s, c) = (0.5 * std::f64::consts::PI * k as f64).sin_cos();
        [(1.0 + k as f64) * c, (1.0 + k as f64) * s, 0.0]
    };
    reported(&polygon(std::iter::once([0.0; 3]).chain((0..7).map(turn)).collect()));
}

#[test]
fn collinear_or_coincident_corners_give_a_fan() {
    for points in [vec![[1.0, 2.0, 3.0]; 5], (0..5).map(|k| [f64::from(k), 0.5, 0.0]).collect()] {
        let mesh = polygon(points);
        assert_eq!(triangles_of(&mesh).unwrap(), [[[0, 1, 2], [0, 2, 3], [0, 3, 4]]]);
        assert_eq!(PolygonQuality::of(&mesh).collinear, [Face(0)]);
    }
}

#[test]
fn nonfinite_corners_are_a_fault() {
    for bad in [f64::NAN, f64::INFINITY] {
        for k in 0..5 {
            let mut mesh = polygon((0..5).map(|k| [f64::from(k * k), f64::from(k), 0.0]).collect());
            mesh.positions[k][1] = bad;
            let error = mesh.triangulate().unwrap_err();
            let MeshError::Invalid(faults) = &error else { panic!("{error}") };
            assert!(matches!(faults[..], [Fault::NonFinitePosition { .. }]), "{error}");
            PolygonQuality::of(&mesh);
        }
    }
}

#[test]
fn random_corner_lists_never_panic_and_no_triangle_repeats_a_vertex() {
    let mut random = Random::from_seed(5);
    let mut whole = 0;
    for _ in 0..20_000 {
        let mut up_to = |n: u64| (random.next_u64() % n) as u32;
        // Small integers make many corners coincident or collinear.
        let size = 2 + u64::from(up_to(4));
        let points: Vec<Point> =
            (0..9).map(|_| [up_to(size), up_to(size), up_to(2) * up_to(2)].map(f64::from)).collect();
        let n = 3 + up_to(9);
        let mut mesh = PolygonMesh::new(points);
        mesh.push_face((0..n).map(|_| up_to(9)));
        PolygonQuality::of(&mesh);
        let Ok(parts) = triangles_of(&mesh) else { continue };
        whole += 1;
        let n = n as usize;
        let distinct = mesh.face(0).iter().collect::<std::collections::HashSet<_>>().len();
        assert!(parts[0].len() <= n - 2);
        if distinct == n {
            assert_eq!(parts[0].len(), n - 2);
        }
        for [a, b, c] in &parts[0] {
            assert!(a != b && b != c && c != a, "{:?}: {:?}", mesh.face(0), parts[0]);
        }
    }
    assert!(whole > 2000, "{whole}");
}
