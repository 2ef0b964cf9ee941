//! Random simple polygons: the triangles cover them exactly.

use super::*;
use eikona_mesh::PolygonQuality;
use eikona_mesh::random::Random;

fn side(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Joins random points into a simple polygon: where two edges cross, reverses the part between
/// them, which shortens the polygon, until none cross.
fn simple_polygon(n: usize, random: &mut Random) -> Vec<[f64; 2]> {
    let mut points: Vec<[f64; 2]> = (0..n).map(|_| [random.uniform(), random.uniform()]).collect();
    let crossing = |points: &[[f64; 2]]| {
        for i in 0..n {
            for j in i + 2..n {
                let [a, b, c, d] = [i, i + 1, j, j + 1].map(|k| points[k % n]);
                if side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0 {
                    return Some((i, j));
                }
            }
        }
        None
    };
    while let Some((i, j)) = crossing(&points) {
        points[i + 1..=j].reverse();
    }
    points
}

#[test]
fn triangle_areas_of_random_simple_polygons_sum_to_their_area() {
    let mut random = Random::from_seed(11);
    for round in 0..400 {
        let n = 4 + round % 60;
        let points = simple_polygon(n, &mut random);
        let mut frame = || [0, 1, 2].map(|_| random.range(-1.0, 1.0));
        let (u, v, shift) = (frame(), frame(), frame());
        for tilted in [false, true] {
            let place = |&[x, y]: &[f64; 2]| {
                if tilted { [0, 1, 2].map(|k| 100.0 * shift[k] + x * u[k] + y * v[k]) } else { [x, y, 0.0] }
            };
            let mesh = polygon(points.iter().map(place).collect());
            let triangles = triangles_of(&mesh).unwrap().swap_remove(0);
            assert_eq!(triangles.len(), n - 2);
            let normal = area_vector(&corners_of(&mesh, 0));
            let area = norm(normal);
            let mut sum = 0.0;
            for t in triangles {
                let part = dot(area_vector(&t.map(|v| mesh.positions[v as usize])), normal) / area;
                // In space, rounding may flip needles.
                assert!(part > if tilted { -1e-12 } else { 0.0 }, "{part}");
                sum += part.abs();
            }
            assert!((sum - area).abs() < 1e-10 * area, "{sum} instead of {area}");
            assert!(is_disk(&mesh));
            assert_eq!(PolygonQuality::of(&mesh).self_crossing, []);
        }
    }
}

/// Returns the outline of a random tree of unit cells, with a corner at each lattice point: many
/// collinear corners, and places where the outline visits a point twice.
fn cells(count: usize, random: &mut Random) -> Vec<[f64; 2]> {
    let mut tree = vec![[0i64, 0]];
    let steps = [[1, 0], [0, 1], [-1, 0], [0, -1]];
    while tree.len() < count {
        let from = tree[(random.next_u64() % tree.len() as u64) as usize];
        let step = steps[(random.next_u64() % 4) as usize];
        // Cells of even coordinates, and the gaps between them that the tree crosses.
        let cell = [from[0] + 2 * step[0], from[1] + 2 * step[1]];
        if from[0] % 2 == 0 && from[1] % 2 == 0 && !tree.contains(&cell) {
            tree.push([from[0] + step[0], from[1] + step[1]]);
            tree.push(cell);
        }
    }
    // Walk along the boundary with the cells on the left.
    let inside = |x: i64, y: i64| tree.contains(&[x, y]);
    let start = *tree.iter().min().unwrap();
    let (mut at, mut direction) = (start, [1i64, 0i64]);
    let mut outline = Vec::new();
    loop {
        outline.push([at[0] as f64, at[1] as f64]);
        at = [at[0] + direction[0], at[1] + direction[1]];
        // The cell ahead on the left and the one ahead on the right, by their lower left corners.
        let [dx, dy] = direction;
        let left = [at[0] + (dx - dy - 1) / 2, at[1] + (dx + dy - 1) / 2];
        let right = [at[0] + (dx + dy - 1) / 2, at[1] + (dy - dx - 1) / 2];
        if inside(right[0], right[1]) {
            direction = [dy, -dx];
        } else if !inside(left[0], left[1]) {
            direction = [-dy, dx];
        }
        if at == start && direction == [1, 0] {
            return outline;
        }
    }
}

#[test]
fn outlines_of_random_cells_with_many_collinear_corners_are_covered() {
    let mut random = Random::from_seed(3);
    for round in 0..60 {
        let count = 2 * (2 + round) + 1;
        let outline = cells(count, &mut random);
        let mesh = polygon(flat(&outline));
        covered(&mesh, outline.len() - 2, count as f64);
        assert_eq!(PolygonQuality::of(&mesh).self_crossing, []);
    }
}
