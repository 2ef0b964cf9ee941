//! Shapes with known areas, from every first corner, in both orientations, at other positions and
//! scales.

use super::*;
use eikona_mesh::PolygonQuality;

const L: [[f64; 2]; 6] = [[2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.], [0., 0.]];
const U: [[f64; 2]; 8] = [[0., 0.], [3., 0.], [3., 3.], [2., 3.], [2., 1.], [1., 1.], [1., 3.], [0., 3.]];
const CHEVRON: [[f64; 2]; 4] = [[0., 0.], [2., 1.], [0., 2.], [1., 1.]];

/// Ten corners, alternately at distance 2 and 0.5.
fn star() -> Vec<[f64; 2]> {
    let corner = |k: usize| {
        let (s, c) = (std::f64::consts::PI * k as f64 / 5.0).sin_cos();
        let r = if k.is_multiple_of(2) { 2.0 } else { 0.5 };
        [r * c, r * s]
    };
    (0..10).map(corner).collect()
}

fn shapes() -> Vec<(Vec<[f64; 2]>, f64)> {
    vec![
        (L.to_vec(), 3.0),
        // Three 1 x 3 strips around a 1 x 2 gap.
        (U.to_vec(), 7.0),
        // A triangle of base 2 and height 2 minus one of height 1: 2 - 1.
        (CHEVRON.to_vec(), 1.0),
        // Ten triangles with sides 2 and 0.5 at an angle of 36 degrees.
        (star(), 5.0 * (std::f64::consts::PI / 5.0).sin()),
    ]
}

/// Returns all rotations of the corner list, in both orientations.
fn variants(points: &[Point]) -> Vec<Vec<Point>> {
    let n = points.len();
    let mut all = Vec::new();
    for first in 0..n {
        let forward: Vec<Point> = (0..n).map(|k| points[(first + k) % n]).collect();
        all.push(forward.iter().rev().copied().collect());
        all.push(forward);
    }
    all
}

#[track_caller]
fn check_everywhere(map: impl Fn(Point) -> Point, area_factor: f64) {
    for (points, area) in shapes() {
        let mapped: Vec<Point> = flat(&points).into_iter().map(&map).collect();
        for variant in variants(&mapped) {
            let mesh = polygon(variant);
            covered(&mesh, points.len() - 2, area * area_factor);
            assert!(is_disk(&mesh));
            let quality = PolygonQuality::of(&mesh);
            assert_eq!((quality.nonconvex.len(), quality.self_crossing.len()), (1, 0));
            assert!(quality.nonplanar.is_empty(), "{}", quality.largest_deviation);
        }
    }
}

// reports.md F2
#[test]
fn nonconvex_polygons_are_covered_from_every_first_corner_in_both_orientations() {
    check_everywhere(|p| p, 1.0);
}

#[test]
fn nonconvex_polygons_are_covered_in_every_coordinate_plane() {
    check_everywhere(|[x, y, _]| [y, 0.0, x], 1.0);
    check_everywhere(|[x, y, _]| [0.0, y, x], 1.0);
}

#[test]
fn nonconvex_polygons_are_covered_tilted_in_space() {
    // Two orthonormal vectors.
    let (u, v) = ([2. / 3., 2. / 3., 1. / 3.], [-2. / 3., 1. / 3., 2. / 3.]);
    check_everywhere(|[x, y, _]| [0, 1, 2].map(|k| 0.3 + x * u[k] + y * v[k]), 1.0);
}

#[test]
fn nonconvex_polygons_are_covered_at_utm_coordinates() {
    check_everywhere(|[x, y, z]| [x + 500_000.25, y + 4_649_776.125, z + 80.0], 1.0);
}

#[test]
fn nonconvex_polygons_are_covered_at_any_scale() {
    for scale in [1e-70, 1e-6, 1e6, 1e70] {
        check_everywhere(|p| p.map(|x| x * scale), scale * scale);
    }
}

#[test]
fn extreme_scales_give_the_triangles_of_scale_one() {
    let usual = triangles_of(&polygon(flat(&U))).unwrap();
    for exponent in [-1000, -500, 500, 1000] {
        let scaled = flat(&U).iter().map(|p| p.map(|x| x * 2.0f64.powi(exponent))).collect();
        assert_eq!(triangles_of(&polygon(scaled)).unwrap(), usual, "2^{exponent}");
    }
}

#[test]
fn a_slightly_nonplanar_l_is_covered_and_reported_as_nonplanar() {
    for variant in variants(&flat(&L)) {
        let mut bent = polygon(variant);
        bent.positions.iter_mut().enumerate().for_each(|(k, p)| p[2] += 0.01 * (k as f64 * 2.3).sin());
        let triangles = triangles_of(&bent).unwrap().swap_remove(0);
        assert_eq!(triangles.len(), 4);
        let normal = area_vector(&corners_of(&bent, 0));
        for t in triangles {
            assert!(dot(area_vector(&t.map(|v| bent.positions[v as usize])), normal) > 0.0);
        }
        let quality = PolygonQuality::of(&bent);
        assert_eq!((quality.nonplanar.len(), quality.self_crossing.len()), (1, 0));
        assert!(quality.largest_deviation > 1e-3 && quality.largest_deviation < 1e-2);
    }
}

#[test]
fn convex_polygons_keep_the_fan_from_their_first_corner() {
    for n in [4, 5, 6, 17, 1000] {
        for turn in 0..5 {
            let corner = |k: u32| {
                let angle = std::f64::consts::TAU * f64::from(k) / f64::from(n) + f64::from(turn);
                let (s, c) = angle.sin_cos();
                // An ellipse in a tilted plane.
                [3.0 * c, s, 0.5 * c - 0.25 * s + 7.0]
            };
            let mesh = polygon((0..n).map(corner).collect());
            let fan: Vec<[u32; 3]> = (1..n - 1).map(|k| [0, k, k + 1]).collect();
            assert_eq!(triangles_of(&mesh).unwrap(), [fan]);
            assert!(PolygonQuality::of(&mesh).nonconvex.is_empty());
        }
    }
}

#[test]
fn a_quadrilateral_uses_its_second_corner_only_if_the_first_one_folds() {
    let [a, b, c, d] = CHEVRON;
    // The reflex corner is d: only the diagonal b-d lies inside.
    assert_eq!(triangles_of(&polygon(flat(&[a, b, c, d]))).unwrap(), [[[1, 2, 3], [1, 3, 0]]]);
    assert_eq!(triangles_of(&polygon(flat(&[d, a, b, c]))).unwrap(), [[[0, 1, 2], [0, 2, 3]]]);
    assert_eq!(triangles_of(&polygon(flat(&[c, d, a, b]))).unwrap(), [[[1, 2, 3], [1, 3, 0]]]);
    assert_eq!(triangles_of(&polygon(flat(&[b, c, d, a]))).unwrap(), [[[0, 1, 2], [0, 2, 3]]]);
}

#[test]
fn collinear_corners_give_no_degenerate_triangle() {
    // A square with the midpoints of its sides, and with two more corners on one side.
    let square = [[0., 0.], [1., 0.], [2., 0.], [2., 1.], [2., 2.], [1., 2.], [0., 2.], [0., 1.]];
    let side = [[0., 0.], [1., 0.], [2., 0.], [3., 0.], [3., 3.], [0., 3.]];
    // A triangle with a corner on a side, as a quadrilateral.
    let triangle = [[0., 0.], [1., 0.], [2., 0.], [0., 2.]];
    let tilt = |[x, y]: [f64; 2]| [0.6 * x - 0.1 * y, 0.3 * x + y / 3.0, 0.7 * y - 0.2 * x];
    for (points, area) in [(&square[..], 4.0), (&side[..], 9.0), (&triangle[..], 2.0)] {
        for variant in variants(&flat(points)) {
            covered(&polygon(variant), points.len() - 2, area);
        }
        let tilted: Vec<Point> = points.iter().map(|&p| tilt(p)).collect();
        for variant in variants(&tilted) {
            let mesh = polygon(variant);
            let area = norm(area_vector(&corners_of(&mesh, 0)));
            for t in covered(&mesh, points.len() - 2, area) {
                let t = t.map(|v| mesh.positions[v as usize]);
                assert!(norm(area_vector(&t)) > 1e-3 * area, "sliver {t:?}");
            }
        }
    }
}

#[test]
fn parents_and_corners_are_right_among_other_polygons() {
    let mut points = flat(&L);
    points.push([3., 0., 0.]);
    points.push([3., 1., 0.]);
    let mut mesh = PolygonMesh::new(points);
    mesh.push_face([0, 6, 7]);
    mesh.push_face([0, 1, 2, 3, 4, 5]);
    mesh.push_face([0, 7, 1]);
    let (triangles, provenance) = mesh.triangulate().unwrap();
    assert!(provenance.face_parents().eq([0, 1, 1, 1, 1, 2].map(Face)));
    assert_eq!(triangles.triangles()[0], [0, 6, 7]);
    assert_eq!(triangles.triangles()[5], [0, 7, 1]);
    assert!(triangles.triangles()[1..5].iter().flatten().all(|v| *v < 6));
}
