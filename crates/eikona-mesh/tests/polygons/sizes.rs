//! Polygons with so many corners that steps of quadratic time would not end.

use super::*;
use eikona_mesh::PolygonQuality;
use eikona_mesh::random::Random;

#[track_caller]
fn covered_and_simple(name: &str, points: &[[f64; 2]], area: f64) {
    let mesh = polygon(flat(points));
    covered(&mesh, points.len() - 2, area);
    assert_eq!(PolygonQuality::of(&mesh).self_crossing, [], "{name}");
}

fn comb(teeth: usize) -> (Vec<[f64; 2]>, f64) {
    let width = 2 * teeth - 1;
    let mut points = vec![[0., 0.], [width as f64, 0.]];
    for k in (0..teeth).rev() {
        let [left, right] = [2 * k, 2 * k + 1].map(|x| x as f64);
        if k + 1 < teeth {
            points.push([right, 1.]);
        }
        points.extend([[right, 10.], [left, 10.]]);
        if k > 0 {
            points.push([left, 1.]);
        }
    }
    (points, width as f64 + 9.0 * teeth as f64)
}

#[test]
fn a_comb_with_20_000_teeth_is_triangulated() {
    let (points, area) = comb(20_000);
    covered_and_simple("comb", &points, area);
}

#[test]
fn a_comb_with_pointed_teeth_on_a_slope_is_triangulated() {
    // Valleys on a slightly concave arc, so that they are visible to each other.
    let n = 20_000;
    let base = |k: f64| 1.0 + (k / n as f64 - 0.5).powi(2);
    let mut points = vec![[0., 0.], [n as f64, 0.]];
    for k in (0..n).rev() {
        let k = k as f64;
        points.extend([[k + 1.0, base(k + 1.0)], [k + 0.5, 5.0]]);
    }
    points.push([0., base(0.0)]);
    let area = norm(area_vector(&flat(&points)));
    covered_and_simple("pointed comb", &points, area);
}

/// A band of width 1/2 along an Archimedean spiral.
fn spiral(n: usize, turns: f64) -> Vec<[f64; 2]> {
    let at = |k: usize, radius: f64| {
        let angle = std::f64::consts::TAU * turns * k as f64 / n as f64;
        let r = radius + angle / std::f64::consts::TAU;
        [r * angle.cos(), r * angle.sin()]
    };
    (0..n).map(|k| at(k, 1.5)).chain((0..n).rev().map(|k| at(k, 1.0))).collect()
}

#[test]
fn a_spiral_of_500_000_corners_is_triangulated() {
    for turns in [50.0, 1000.0] {
        let points = spiral(250_000, turns);
        let area = norm(area_vector(&flat(&points)));
        covered_and_simple(&format!("spiral of {turns} turns"), &points, area);
    }
}

#[test]
fn a_coastline_of_200_000_corners_is_triangulated() {
    // Random radii around the origin, from a corner that does not see all others.
    let mut random = Random::from_seed(1);
    let corner = |k: usize| {
        let (s, c) = (std::f64::consts::TAU * k as f64 / 200_000.0).sin_cos();
        let r = 1.0 + 0.3 * random.uniform();
        [r * c, r * s]
    };
    let points: Vec<[f64; 2]> = (0..200_000).map(corner).collect();
    let area = norm(area_vector(&flat(&points)));
    covered_and_simple("coastline", &points, area);
}

#[test]
fn a_convex_polygon_of_500_000_corners_is_a_fan() {
    let corner = |k: usize| {
        let (s, c) = (std::f64::consts::TAU * k as f64 / 500_000.0).sin_cos();
        [c, s, 0.0]
    };
    let mesh = polygon((0..500_000).map(corner).collect());
    let triangles = &triangles_of(&mesh).unwrap()[0];
    assert!(triangles.iter().enumerate().all(|(k, t)| *t == [0, k as u32 + 1, k as u32 + 2]));
}

/// Holes per row and column of the plate.
const ROWS: u32 = 100;

/// Traverses hole (i, j) from its lower left corner, and bridges to the holes to the right and, in
/// the first column, above.
fn walk(i: u32, j: u32, corners: &mut Vec<u32>) {
    let h = 4 + 4 * (ROWS * j + i);
    corners.extend([h, h + 1]);
    if i == 0 && j + 1 < ROWS {
        walk(i, j + 1, corners);
        corners.push(h + 1);
    }
    corners.extend([h + 2, h + 3]);
    if i + 1 < ROWS {
        walk(i + 1, j, corners);
        corners.push(h + 3);
    }
    corners.push(h);
}

#[test]
fn a_plate_with_10_000_holes_is_triangulated() {
    let side = 3.0 * f64::from(ROWS) + 1.0;
    let mut points = vec![[0., 0.], [side, 0.], [side, side], [0., side]];
    for hole in 0..ROWS * ROWS {
        let [x, y] = [hole % ROWS, hole / ROWS].map(|k| 1.0 + 3.0 * f64::from(k));
        points.extend([[x, y], [x, y + 1.], [x + 1., y + 1.], [x + 1., y]]);
    }
    let mut corners = vec![0, 1, 2, 3, 0];
    walk(0, 0, &mut corners);
    let mut mesh = PolygonMesh::new(flat(&points));
    mesh.push_face(corners.iter().copied());
    let holes = f64::from(ROWS * ROWS);
    covered(&mesh, corners.len() - 2, side * side - holes);
    assert_eq!(PolygonQuality::of(&mesh).self_crossing, []);
}

#[test]
fn a_tangle_of_500_000_random_corners_is_triangulated() {
    let mut random = Random::from_seed(2);
    let points: Vec<Point> = (0..500_000).map(|_| [random.uniform(), random.uniform(), 0.0]).collect();
    let mesh = polygon(points);
    assert_eq!(mesh.triangulate().unwrap().0.face_count(), 500_000 - 2);
    assert_eq!(PolygonQuality::of(&mesh).self_crossing, [Face(0)]);
}
