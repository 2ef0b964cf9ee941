//! Tests of streamlines on fields whose lines are known in closed form.
//!
//! A field of direction `z^q` is constant in the chart `w = z^(1 - q)` (`log z` if q = 1): its
//! streamlines are straight there. If the N-th power is `z^n` or its conjugate, the values of the
//! field represent it exactly on any mesh of the plane, so only the steps are to blame for errors.

use crate::polar_field::field::polar;
use crate::polar_field::{FieldOptions, Place, PolarField, Singularity, Solver};
use eikona_mesh::shapes::{self, Diagonal};
use eikona_mesh::{SurfacePoint, TriangleMesh};
use eikona_numeric::Complex;
use std::f64::consts::TAU;

/// A sequence of numbers from -1 to 1 without pattern.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// A square from -1 to 1 with triangles of many shapes.
fn square(cells: usize) -> TriangleMesh {
    let grid = shapes::grid(cells, cells, 2.0, 2.0, Diagonal::Alternating).unwrap();
    let low = [0, 1].map(|k| grid.positions().iter().map(|p| p[k]).fold(f64::INFINITY, f64::min));
    let mut random = noise(7);
    let moved = grid.positions().iter().map(|p| {
        let [x, y] = [p[0] - low[0] - 1.0, p[1] - low[1] - 1.0];
        let aside = if x.abs().max(y.abs()) < 1.0 - 1e-9 { 0.5 / cells as f64 } else { 0.0 };
        [x + aside * random(), y + aside * random(), 0.0]
    });
    TriangleMesh::new(moved.collect(), grid.triangles().to_vec()).unwrap()
}

/// A field with other values: in each face the given power of a linear field, by its corners.
fn field_of(
    mesh: &TriangleMesh,
    degree: u32,
    power: u32,
    mut base: impl FnMut([f64; 3]) -> Complex,
) -> PolarField {
    let whole = [Singularity { place: Place::Boundary(0), index: 1.0 }];
    let options = FieldOptions::default().with_degree(degree);
    let mut field = Solver::new(mesh, &Default::default()).unwrap().solve(&whole, &options).unwrap();
    for face in mesh.faces() {
        let [along, _, _] = field.domain.bevel.frame(face);
        let turn = along[1].atan2(along[0]) * f64::from(degree) / f64::from(power);
        field.values.powers[face] = power;
        for k in 0..3 {
            let corner = mesh.triangles()[face.index()][k] as usize;
            field.values.base[face.halfedge(k).index()] = base(mesh.positions()[corner]) * polar(1.0, -turn);
        }
    }
    field
}

/// The points of a line in the chart in which it is straight, without jumps of the argument.
fn in_chart(points: &[[f64; 3]], centre: [f64; 2], q: f64) -> Vec<[f64; 2]> {
    let mut angle = 0.0;
    let mut before = [1.0, 0.0];
    let chart = |p: &[f64; 3]| {
        let [x, y] = [p[0] - centre[0], p[1] - centre[1]];
        angle += (before[0] * y - before[1] * x).atan2(before[0] * x + before[1] * y);
        before = [x, y];
        let (log, turned) = (x.hypot(y).ln(), angle);
        if q == 1.0 {
            return [log, turned];
        }
        let size = ((1.0 - q) * log).exp();
        [size * ((1.0 - q) * turned).cos(), size * ((1.0 - q) * turned).sin()]
    };
    points.iter().map(chart).collect()
}

/// The largest distance of points from the line through the first and the last, relative to theirs.
fn bend(points: &[[f64; 2]]) -> f64 {
    let (a, b) = (points[0], points[points.len() - 1]);
    let whole = [b[0] - a[0], b[1] - a[1]];
    let aside = |p: &[f64; 2]| ((p[0] - a[0]) * whole[1] - (p[1] - a[1]) * whole[0]).abs();
    points.iter().map(aside).fold(0.0, f64::max) / (whole[0].powi(2) + whole[1].powi(2))
}

#[test]
fn lines_of_powers_are_straight_in_their_chart() {
    let mesh = square(9);
    // The zero is inside a face, inside an edge, at a vertex, or outside of the square.
    let middle = mesh.triangles()[80].map(|v| mesh.positions()[v as usize]);
    let inside = [0, 1].map(|k| 0.2 * middle[0][k] + 0.5 * middle[1][k] + 0.3 * middle[2][k]);
    let between = [0, 1].map(|k| 0.4 * middle[0][k] + 0.6 * middle[1][k]);
    let corner = [middle[2][0], middle[2][1]];
    // N, the power in each face, and the index of its base.
    let forms = [
        (1, 1, 0.0),
        (1, 1, 1.0),
        (1, 1, -1.0),
        (1, 2, 1.0),
        (1, 3, 1.0),
        (1, 2, -1.0),
        (2, 1, 1.0),
        (2, 1, -1.0),
        (2, 3, 1.0),
        (4, 1, 1.0),
        (4, 1, -1.0),
        (4, 5, -1.0),
        (3, 1, 1.0),
    ];
    for (degree, power, sign) in forms {
        let q = sign * f64::from(power) / f64::from(degree);
        for centre in [inside, between, corner, [1.3, -1.2]] {
            let field = field_of(&mesh, degree, power, |p| match sign {
                0.0 => Complex { re: 0.6, im: -0.8 },
                _ => Complex { re: p[0] - centre[0], im: sign * (p[1] - centre[1]) },
            });
            for face in [12, 50, 79, 82, 130] {
                let start = SurfacePoint::Face { vertices: mesh.triangles()[face], bary: [0.3, 0.4, 0.3] };
                for k in 0..degree {
                    let line = field.streamline_from(start, k, 3.0).unwrap();
                    let points = line.positions(&mesh);
                    let off = bend(&in_chart(&points, centre, q));
                    assert!(off < 5e-6, "N = {degree}, q = {q}, face {face}, direction {k}: {off:e}");
                }
            }
        }
    }
}

#[test]
fn lines_around_a_centre_are_closed_circles() {
    let mesh = square(9);
    let field = field_of(&mesh, 1, 1, |p| Complex { re: -p[1], im: p[0] });
    let mut count = 0;
    for vertices in mesh.triangles() {
        let corners = vertices.map(|v| mesh.positions()[v as usize]);
        let middle = [0, 1].map(|k| (corners[0][k] + corners[1][k] + corners[2][k]) / 3.0);
        let radius = middle[0].hypot(middle[1]);
        if !(0.1..0.97).contains(&radius) {
            continue;
        }
        let third = 1.0 / 3.0;
        let start = SurfacePoint::Face { vertices: *vertices, bary: [third, third, 1.0 - 2.0 * third] };
        let line = field.streamline_from(start, 0, f64::INFINITY).unwrap();
        let points = line.positions(&mesh);
        let turn = |w: &[[f64; 3]]| {
            let (a, b) = (w[0], w[1]);
            (a[0] * b[1] - a[1] * b[0]).atan2(a[0] * b[0] + a[1] * b[1])
        };
        let turns = points.windows(2).map(turn).sum::<f64>() / TAU;
        let off = points.iter().map(|p| (p[0].hypot(p[1]) / radius - 1.0).abs()).fold(0.0, f64::max);
        assert!(line.is_closed() && off < 1e-5 && (turns - 1.0).abs() < 1e-9, "{radius}: {off:e}, {turns}");
        count += 1;
    }
    assert!(count > 100);
}

#[test]
fn lines_run_along_the_field_on_both_sides_of_their_start() {
    // The reverse of a vector, or of one of three directions, is no direction of the field.
    let mesh = square(9);
    for degree in [1, 2, 3, 4] {
        let field = field_of(&mesh, degree, 1, |_| Complex { re: 1.0, im: 0.0 });
        let start = SurfacePoint::Face { vertices: mesh.triangles()[80], bary: [0.3, 0.4, 0.3] };
        let points = field.streamline_from(start, 0, f64::INFINITY).unwrap().positions(&mesh);
        let ends = [points[0], points[points.len() - 1]].map(|p| p[0].abs());
        assert!(ends.iter().all(|x| (x - 1.0).abs() < 1e-9), "N = {degree}: {ends:?}");
        assert!((points[0][0] - points[points.len() - 1][0]).abs() > 1.9);
    }
    let field = field_of(&mesh, 1, 1, |_| Complex { re: 1.0, im: 0.0 });
    let lines = field.streamlines(&Default::default()).unwrap();
    let mut runs = lines
        .iter()
        .flat_map(|line| line.positions(&mesh).windows(2).map(|w| w[1][0] - w[0][0]).collect::<Vec<_>>());
    assert!(!lines.is_empty() && runs.all(|run| run >= 0.0));
}

#[test]
fn lines_end_where_directions_jump_from_face_to_face() {
    let mesh = square(9);
    // In some of these, walks around a vertex, or to and fro across an edge, have no length.
    for seed in [0, 4, 28, 60, 88, 89, 90, 91, 112] {
        let mut random = noise(seed);
        let (degree, power) = (1 + (seed % 4) as u32, 1 + (seed / 4 % 3) as u32);
        let field = field_of(&mesh, degree, power, |_| Complex { re: random(), im: random() });
        for face in (0..mesh.face_count()).step_by(7) {
            let start = SurfacePoint::Face { vertices: mesh.triangles()[face], bary: [0.3, 0.4, 0.3] };
            let line = field.streamline_from(start, 0, 3.0).unwrap();
            assert!(line.nodes.len() < 20_000, "seed {seed}, face {face}: {}", line.nodes.len());
        }
    }
}
