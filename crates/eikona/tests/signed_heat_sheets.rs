//! Sheets connected only at vertices, or at nonmanifold edges: continuation of the distance from
//! one to the next.

mod exact;

use eikona::signed_heat::{DiffusionTime, LevelSets};
use eikona_mesh::{
    Curve, SurfaceCurves, TriangleMesh, Vertex,
    shapes::{self, Diagonal},
};
use exact::*;

/// A strip of half units with a fin of height 1 on its edge at x = 1.5.
fn strip_with_fin(flip: impl Fn(usize) -> bool) -> TriangleMesh {
    let strip = shapes::grid(6, 1, 3.0, 0.5, Diagonal::Uniform).unwrap();
    let (mut positions, mut faces) = (strip.positions().to_vec(), strip.triangles().to_vec());
    let mut below = [[1.5, 0.0, 0.0], [1.5, 0.5, 0.0]].map(|p| vertex_at(&strip, p).0);
    for z in [0.5, 1.0] {
        let above = [positions.len() as u32, positions.len() as u32 + 1];
        positions.extend([[1.5, 0.0, z], [1.5, 0.5, z]]);
        faces.push([below[0], below[1], above[1]]);
        faces.push([below[0], above[1], above[0]]);
        below = above;
    }
    let faces = faces
        .into_iter()
        .enumerate()
        .map(|(i, [a, b, c])| if flip(i) { [a, c, b] } else { [a, b, c] })
        .collect();
    TriangleMesh::new(positions, faces).unwrap()
}

/// The line x = 0, downwards: the strip is on its left, so the distance is -x, and continues up the
/// fin.
#[test]
fn fin_on_a_strip() {
    let orientations: [(&str, fn(usize) -> bool); 4] = [
        ("as made", |_| false),
        ("fin reversed", |i| i >= 12),
        ("one face of the fin reversed", |i| i == 13),
        ("behind the fin reversed", |i| (6..12).contains(&i)),
    ];
    for (name, flip) in orientations {
        let mesh = strip_with_fin(flip);
        let curve = [[0.0, 0.5, 0.0], [0.0, 0.0, 0.0]].map(|p| vertex_at(&mesh, p));
        let source = SurfaceCurves::from_curve(Curve::signed(curve));
        for level_sets in [LevelSets::Free, LevelSets::Zero] {
            let solution = solve(&mesh, &source, PAPER_TIME, level_sets);
            assert!(solution.report.preparation.real_frames);
            for v in mesh.vertices() {
                let [x, _, z] = mesh.position(v);
                let d = solution.distance[v];
                assert!((d + (x + z)).abs() < 1e-7, "{name}, {level_sets:?}: {d} at x = {x}, z = {z}");
            }
        }
    }
}

/// A curve along the edge of the fin itself. A normal decides which sheets are on the left, not the
/// orientation of their faces; the fin, which is on neither side, rises along the normal and counts
/// as left.
#[test]
fn curve_along_the_edge_of_the_fin() {
    let orientations: [(&str, fn(usize) -> bool); 5] = [
        ("as made", |_| false),
        ("left of the fin reversed", |i| i < 6),
        ("right of the fin reversed", |i| (6..12).contains(&i)),
        ("fin reversed", |i| i >= 12),
        ("one face beside the seam reversed", |i| i == 5),
    ];
    for (name, flip) in orientations {
        let mesh = strip_with_fin(flip);
        let nodes = [[1.5, 0.0, 0.0], [1.5, 0.5, 0.0]].map(|p| vertex_at(&mesh, p));
        let ask = |nodes: [Vertex; 2], up: Option<[f64; 3]>| {
            let source = SurfaceCurves::from_curve(Curve { up, ..Curve::signed(nodes) });
            solve(&mesh, &source, PAPER_TIME, LevelSets::Zero)
        };
        for up in [1.0, -1.0] {
            let there = if up > 0.0 { nodes } else { [nodes[1], nodes[0]] };
            let with_up = ask(there, Some([0.0, 0.0, up])).distance;
            for v in mesh.vertices() {
                let [x, _, z] = mesh.position(v);
                // With curve and normal reversed, left stays left, but the fin rises against the
                // normal.
                let expected = x - 1.5 - up * z;
                assert!(
                    (with_up[v] - expected).abs() < 1e-6,
                    "{name}, {up}, {v}: {}, expected {expected}",
                    with_up[v]
                );
            }
        }
        // Without a normal the sides of the strip still differ; there is a warning if orientations
        // disagree.
        let without_up = ask(nodes, None);
        let [left, right] = [[0.0; 3], [3.0, 0.0, 0.0]].map(|p| without_up.distance[vertex_at(&mesh, p)]);
        assert!((left.abs() - 1.5).abs() < 1e-6 && (left + right).abs() < 1e-6, "{name}: {left} {right}");
        let warned = without_up.report.all_warnings().any(|text| text.kind() == "undetermined_side");
        assert_eq!(warned, name.contains("left of") || name.contains("right of"), "{name}");
    }
}

/// Where the seam twists and the sheets with it, each stays on its side.
#[test]
fn sheets_of_a_twisted_seam_keep_their_sides() {
    // Three sheets at 120 degrees along an axis, twisted by two full turns.
    let (steps, width) = (120, 3);
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    for i in 0..=steps {
        positions.push([0.0, 0.0, 0.05 * f64::from(i)]);
    }
    for sheet in 0..3u32 {
        let base = positions.len() as u32;
        for i in 0..=steps {
            let a = std::f64::consts::TAU * (2.0 * f64::from(i) / f64::from(steps) + f64::from(sheet) / 3.0);
            for j in 1..=width {
                let r = 0.05 * f64::from(j);
                positions.push([r * a.cos(), r * a.sin(), 0.05 * f64::from(i)]);
            }
        }
        let at = |i: i32, j: i32| if j == 0 { i as u32 } else { base + (width * i + j - 1) as u32 };
        for (i, j) in (0..steps).flat_map(|i| (0..width).map(move |j| (i, j))) {
            // Every third face has the opposite orientation.
            for [a, b, c] in
                [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
            {
                faces.push(if faces.len() % 3 == 0 { [a, b, c] } else { [a, c, b] });
            }
        }
    }
    let mesh = TriangleMesh::new(positions, faces).unwrap();
    let curve = Curve { up: Some([0.0, 1.0, 0.0]), ..Curve::signed((0..=steps as u32).map(Vertex)) };
    let solution = solve(&mesh, &SurfaceCurves::from_curve(curve), PAPER_TIME, LevelSets::Zero);
    let per_sheet = ((steps + 1) * width) as usize;
    let first = (steps + 1) as usize;
    for sheet in 0..3 {
        let range = first + sheet * per_sheet..first + (sheet + 1) * per_sheet;
        let negative = solution.distance.as_slice()[range.clone()].iter().filter(|d| **d < 0.0).count();
        assert!(
            negative == 0 || negative == per_sheet,
            "sheet {sheet}: {negative} of {per_sheet} are negative"
        );
    }
}

/// Two squares that share a single corner, with a line in the first: mesh, source, and the exact
/// distance, which is that of a point source behind the corner.
fn two_squares(direction: f64) -> (TriangleMesh, SurfaceCurves, impl Fn([f64; 3]) -> f64) {
    let n = 24;
    let square = shapes::grid(n, n, 1.0, 1.0, Diagonal::Alternating).unwrap();
    let corner = vertex_at(&square, [1.0, 1.0, 0.0]);
    let (mut positions, mut faces) = (square.positions().to_vec(), square.triangles().to_vec());
    let base = positions.len() as u32;
    // The second square starts at (1, 1); its own first vertex becomes the corner.
    positions.extend(square.positions()[1..].iter().map(|p| [p[0] + 1.0, p[1] + 1.0, 0.0]));
    let number = |v: u32| if v == 0 { corner.0 } else { base + v - 1 };
    faces.extend(square.triangles().iter().map(|f| f.map(number)));
    let mesh = TriangleMesh::new(positions, faces).unwrap();
    let mut source = zero_level(&mesh, |p| direction * (p[0] - 0.3));
    source.curves.retain(|c| c.nodes.len() > n);
    let exact = move |p: [f64; 3]| {
        let behind = p[0].max(p[1]) > 1.0;
        direction * if behind { 0.7 + (p[0] - 1.0).hypot(p[1] - 1.0) } else { p[0] - 0.3 }
    };
    (mesh, source, exact)
}

/// Behind the corner the distance keeps its sign, and its magnitude grows.
#[test]
fn distance_continues_through_a_vertex() {
    for direction in [1.0, -1.0] {
        let (mesh, source, exact) = two_squares(direction);
        for level_sets in [LevelSets::Free, LevelSets::Zero] {
            let solution = solve(&mesh, &source, PAPER_TIME, level_sets);
            for v in mesh.vertices() {
                let (d, expected) = (solution.distance[v], exact(mesh.position(v)));
                assert!((d - expected).abs() < 0.25 * expected.abs() + 0.01, "{v}: {d}, expected {expected}");
            }
        }
    }
}

/// Behind the corner the distance is that from a point.
#[test]
fn distance_behind_a_vertex_is_that_from_a_point() {
    let (mesh, source, exact) = two_squares(1.0);
    let e = errors(&mesh, &free(&mesh, &source), exact);
    assert!(e.largest < 0.1 * 2f64.sqrt(), "{e:?}");
}

#[test]
fn two_tetrahedra_at_a_vertex() {
    let positions = vec![
        [0.0, 0.0, 0.0],
        [1.0, 0.0, -1.0],
        [-0.5, 0.8, -1.0],
        [-0.5, -0.8, -1.0],
        [1.0, 0.0, 1.0],
        [-0.5, 0.8, 1.0],
        [-0.5, -0.8, 1.0],
    ];
    let faces = vec![
        [0, 1, 2],
        [0, 2, 3],
        [0, 3, 1],
        [1, 3, 2], // below
        [0, 5, 4],
        [0, 6, 5],
        [0, 4, 6],
        [4, 5, 6],
    ];
    let mesh = TriangleMesh::new(positions, faces).unwrap();
    let ring = Curve::signed([1, 2, 3, 1].map(Vertex));
    let there = solve(&mesh, &SurfaceCurves::from_curve(ring.clone()), PAPER_TIME, LevelSets::Zero).distance;
    let back =
        solve(&mesh, &SurfaceCurves::from_curve(ring.reversed()), PAPER_TIME, LevelSets::Zero).distance;
    for v in [0, 4, 5, 6].map(Vertex) {
        assert!(there[v].abs() > 0.5 && (there[v] + back[v]).abs() < 1e-7, "{v}: {}", there[v]);
        assert_eq!(there[v] > 0.0, there[Vertex(0)] > 0.0, "{v}: the sign changed behind the vertex");
    }
    assert!((4..7).all(|v| there[Vertex(v)].abs() > there[Vertex(0)].abs() + 0.8));
}

/// A line at an angle to the edge with the fin: isolines stay straight behind the edge, on the
/// plate and on the unfolded fin.
#[test]
fn slanted_line_on_a_plate_with_a_fin() {
    let plate = shapes::grid(20, 20, 2.0, 2.0, Diagonal::Alternating).unwrap();
    let (mut positions, mut faces) = (plate.positions().to_vec(), plate.triangles().to_vec());
    let mut below: Vec<u32> = (0..=20).map(|j| vertex_at(&plate, [1.0, 0.1 * j as f64, 0.0]).0).collect();
    for row in 1..=5 {
        let above: Vec<u32> = (0..=20).map(|j| positions.len() as u32 + j).collect();
        positions.extend((0..=20).map(|j| [1.0, 0.1 * j as f64, 0.1 * row as f64]));
        for j in 0..20 {
            faces.push([below[j], below[j + 1], above[j + 1]]);
            faces.push([below[j], above[j + 1], above[j]]);
        }
        below = above;
    }
    let mesh = TriangleMesh::new(positions, faces).unwrap();
    // Unfolded, the fin lies over x > 1, to the right of the line.
    let exact = |p: [f64; 3]| 0.8 * (p[0] + p[2]) + 0.6 * p[1] - 0.7;
    let mut source = zero_level(&mesh, |p| if p[0] < 0.95 { exact(p) } else { 1.0 });
    source.curves.retain(|c| c.nodes.len() > 10);
    let e = errors(&mesh, solve(&mesh, &source, PAPER_TIME, LevelSets::Free).distance.as_slice(), exact);
    println!("slanted line before a fin: {e:?}");
    assert!(e.largest < 0.02, "{e:?}");
}

/// Squares of 2 x 2 cells, given by their lower left corners, with coincident corners merged.
fn squares(corners: impl Iterator<Item = [f64; 2]>) -> TriangleMesh {
    let square = shapes::grid(2, 2, 1.0, 1.0, Diagonal::Alternating).unwrap();
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    let mut index = std::collections::HashMap::new();
    for corner in corners {
        let moved: Vec<u32> = square
            .positions()
            .iter()
            .map(|p| {
                let p = [p[0] + corner[0], p[1] + corner[1], 0.0];
                *index.entry(p.map(f64::to_bits)).or_insert_with(|| {
                    positions.push(p);
                    positions.len() as u32 - 1
                })
            })
            .collect();
        faces.extend(square.triangles().iter().map(|t| t.map(|v| moved[v as usize])));
    }
    TriangleMesh::new(positions, faces).unwrap()
}

/// The distance passes vertices at which sheets are connected, with its sign, for one more
/// diffusion whatever the number of sheets.
#[test]
fn chain_of_2000_sheets() {
    let mesh = squares((0..2000).map(|k| [f64::from(k); 2]));
    let at = |x: f64, y: f64| vertex_at(&mesh, [x, y, 0.0]);
    // Across the square in the middle; the start of the chain is on the left.
    let curve = Curve::signed([at(1001.0, 1000.0), at(1000.5, 1000.5), at(1000.0, 1001.0)]);
    let solution = solve(&mesh, &SurfaceCurves::from_curve(curve), PAPER_TIME, LevelSets::Free);
    assert!(solution.report.stages <= 4, "{} solves", solution.report.stages);
    let joint = |k: i32| solution.distance[at(f64::from(k), f64::from(k))];
    let step = joint(1002) - joint(1001);
    assert!((step - 2f64.sqrt()).abs() < 0.2, "{step}");
    for k in 1001..2000 {
        assert!((joint(k + 1) - joint(k) - step).abs() < 1e-6, "{k}: {} {}", joint(k), joint(k + 1));
        assert!(
            (joint(2001 - k) + joint(k)).abs() < 1e-9 * joint(k),
            "{k}: {} {}",
            joint(2001 - k),
            joint(k)
        );
    }
}

/// Twenty thousand triangles that share a single vertex, and a point at the end of one of them.
#[test]
fn flower_of_20000_petals() {
    let mut positions = vec![[0.0; 3]];
    let mut faces = Vec::new();
    for i in 0..20_000u32 {
        let (sin, cos) = f64::from(i).sin_cos();
        let tip = |across: f64| [cos - across * sin, sin + across * cos, 0.0];
        positions.extend([tip(-0.3), tip(0.3)]);
        faces.push([0, 2 * i + 1, 2 * i + 2]);
    }
    let mesh = TriangleMesh::new(positions, faces).unwrap();
    let source = SurfaceCurves { curves: Vec::new(), points: vec![Vertex(1).into()] };
    let solution = solve(&mesh, &source, PAPER_TIME, LevelSets::Free);
    assert!(solution.report.stages <= 3);
    let petal = |i: usize| solution.distance[Vertex(i as u32)] - solution.distance[Vertex(0)];
    assert!(solution.distance[Vertex(1)].abs() < 1e-12 && solution.distance[Vertex(0)] > 0.5);
    for i in 3..mesh.vertex_count() {
        assert!((petal(i) - petal(3)).abs() < 1e-9 && petal(i) > 0.8, "{i}: {} {}", petal(i), petal(3));
    }
}

/// A sheet that is entered on both sides of zero passes each sign to the sheets nearest to it.
#[test]
fn sheet_entered_from_both_sides() {
    // A row of three squares; a square on a corner at each end; between these a sheet that touches
    // both; and one more at each end.
    let row = shapes::grid(6, 2, 3.0, 1.0, Diagonal::Alternating).unwrap();
    let mesh = squares([[-1.0, 1.0], [3.0, 1.0], [-1.0, 4.0], [3.0, 4.0]].into_iter());
    let (mut positions, mut faces) = (mesh.positions().to_vec(), mesh.triangles().to_vec());
    let mut glue = |points: &[[f64; 3]], triangles: &[[u32; 3]], at: &[[f64; 2]]| {
        let numbers: Vec<u32> = points
            .iter()
            .map(|p| {
                let same = |q: &[f64; 3]| q[..2] == p[..2];
                match positions.iter().position(same).filter(|_| at.contains(&[p[0], p[1]])) {
                    Some(i) => i as u32,
                    None => {
                        positions.push(*p);
                        positions.len() as u32 - 1
                    }
                }
            })
            .collect();
        faces.extend(triangles.iter().map(|t| t.map(|v| numbers[v as usize])));
    };
    // The row lies on [0, 3] x [0, 1]; the sheet above on [0, 3] x [2, 4].
    glue(row.positions(), row.triangles(), &[[0.0, 1.0], [3.0, 1.0]]);
    let above: Vec<[f64; 3]> = row.positions().iter().map(|p| [p[0], 2.0 + 2.0 * p[1], 0.0]).collect();
    glue(&above, row.triangles(), &[[0.0, 2.0], [3.0, 2.0], [0.0, 4.0], [3.0, 4.0]]);
    let mesh = TriangleMesh::new(positions, faces).unwrap();
    let middle = through_vertices(&mesh, |p| p[0] == 1.5 && p[1] <= 1.0, |p| p[1]);
    let solution = solve(&mesh, &SurfaceCurves::from_curve(middle), PAPER_TIME, LevelSets::Free);
    assert!(solution.report.stages <= 3);
    // The curve runs upwards: smaller x is on the left and negative. The field points to the
    // entrances on that side, and away from those on the other.
    for (sign, entrance, low) in [
        (-1.0, [0.0, 1.0, 0.0], [-1.0, 1.0]),
        (1.0, [3.0, 1.0, 0.0], [3.0, 1.0]),
        (-1.0, [0.0, 4.0, 0.0], [-1.0, 4.0]),
        (1.0, [3.0, 4.0, 0.0], [3.0, 4.0]),
    ] {
        for f in mesh.faces() {
            let [a, b, c] = mesh.face_positions(f);
            let middle = [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0);
            if (0..2).all(|k| middle[k] > low[k] && middle[k] < low[k] + 1.0) {
                let away = dot(solution.gradient[f], sub(middle, entrance)) / norm(sub(middle, entrance));
                assert!(sign * away > 0.7, "{entrance:?}: {away} at {middle:?}");
            }
        }
    }
}

/// Two hundred curves through a vertex of 20,000 faces, on an inconsistently oriented mesh: the
/// side of each curve is transported across the vertex.
#[test]
fn curves_through_a_hub_of_many_faces() {
    let n = 20_000u32;
    let angle = |i: u32| f64::from(i) / f64::from(n) * std::f64::consts::TAU;
    let mut positions = vec![[0.0; 3]];
    positions.extend((0..n).map(|i| [angle(i).cos(), angle(i).sin(), 0.0]));
    // Every third face has the opposite orientation, and an edge of the rim has two additional
    // faces.
    let rim = |i: u32| 1 + i % n;
    let mut faces: Vec<[u32; 3]> =
        (0..n).map(|i| if i % 3 == 1 { [0, rim(i + 1), rim(i)] } else { [0, rim(i), rim(i + 1)] }).collect();
    for z in [1e-3, -1e-3] {
        faces.push([rim(1), rim(0), positions.len() as u32]);
        positions.push([1.001, 0.0, z]);
    }
    let mesh = TriangleMesh::new(positions, faces).unwrap();
    let across = Curve::signed([rim(n / 2), 0, rim(0)].map(Vertex));
    let source = SurfaceCurves { curves: vec![across; 200], points: Vec::new() };
    let solution = solve(&mesh, &source, DiffusionTime::Coefficient(10.0), LevelSets::Zero);
    assert!(solution.report.preparation.real_frames);
    for v in mesh.vertices().filter(|&v| mesh.position(v)[1].abs() > 0.1) {
        // Most faces are counter-clockwise, so left is above.
        let y = mesh.position(v)[1];
        assert!((solution.distance[v] + y).abs() < 0.2, "{v} at {y}: {}", solution.distance[v]);
    }
}

/// A strip of 12 x 1 and a second one above it that shares only the vertices (2, 1) and (10, 1).
/// Returns the mesh, one strip, and the number in the mesh of each vertex of the second.
fn two_strips(cells: usize) -> (TriangleMesh, TriangleMesh, Vec<Vertex>) {
    let strip = shapes::grid(12 * cells, cells, 12.0, 1.0, Diagonal::Alternating).unwrap();
    let (mut positions, mut faces) = (strip.positions().to_vec(), strip.triangles().to_vec());
    let upper: Vec<Vertex> = strip
        .positions()
        .iter()
        .map(|p| {
            if p[1] == 0.0 && (p[0] == 2.0 || p[0] == 10.0) {
                return vertex_at(&strip, [p[0], 1.0, 0.0]);
            }
            positions.push([p[0], p[1] + 1.0, 0.0]);
            Vertex(positions.len() as u32 - 1)
        })
        .collect();
    faces.extend(strip.triangles().iter().map(|t| t.map(|v| upper[v as usize].0)));
    (TriangleMesh::new(positions, faces).unwrap(), strip, upper)
}

/// A sheet attached at two vertices is entered where the distance arrives first, and does not
/// influence the surface that it is attached to.
#[test]
fn sheet_attached_at_two_vertices() {
    for cells in [1, 4] {
        let (mesh, strip, upper) = two_strips(cells);
        let source = SurfaceCurves::from_curve(through_vertices(&strip, |p| p[0] == 0.0, |p| p[1]));
        for level_sets in [LevelSets::Free, LevelSets::Zero, LevelSets::PerComponent, LevelSets::Soft(1.0)] {
            let distance = solve(&mesh, &source, PAPER_TIME, level_sets).distance;
            for v in strip.vertices() {
                let x = strip.position(v)[0];
                assert!((distance[v].abs() - x).abs() < 1e-9, "{level_sets:?} at {x}: {}", distance[v]);
            }
            for v in strip.vertices() {
                let [x, y, _] = strip.position(v);
                let expected = 2.0 + (x - 2.0).hypot(y);
                let d = distance[upper[v.index()]].abs();
                assert!(
                    (d - expected).abs() < 0.9,
                    "{level_sets:?} above at {x} {y}: {d}, expected {expected}"
                );
            }
        }
    }
}

/// On random heaps of triangles that meet at vertices and edges, flipping faces changes nothing. In
/// some heaps the vectors that enter a triangle at its three corners cancel.
#[test]
fn flipped_faces_change_nothing_in_heaps_of_triangles() {
    struct Xorshift(u64);
    impl Xorshift {
        fn next(&mut self) -> u64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            self.0 >> 11
        }
        fn below(&mut self, k: usize) -> usize {
            self.next() as usize % k
        }
        fn coordinate(&mut self) -> f64 {
            self.next() as f64 / (1u64 << 52) as f64 - 1.0
        }
    }
    let mut worst = (0.0f64, 0);
    for seed in 1..8000u64 {
        let mut random = Xorshift(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
        (0..5).for_each(|_| _ = random.next());
        let (vertices, count) = (3 + random.below(12), 1 + random.below(12));
        let positions: Vec<[f64; 3]> = (0..vertices).map(|_| [0; 3].map(|_| random.coordinate())).collect();
        let mut seen = std::collections::HashSet::new();
        let faces: Vec<[u32; 3]> = (0..count)
            .map(|_| [0; 3].map(|_| random.below(vertices) as u32))
            .filter(|f| {
                let mut sorted = *f;
                sorted.sort_unstable();
                sorted[0] < sorted[1] && sorted[1] < sorted[2] && seen.insert(sorted)
            })
            .collect();
        if faces.is_empty() {
            continue;
        }
        let flipped = faces.iter().map(|&[a, b, c]| if random.below(2) == 0 { [a, b, c] } else { [a, c, b] });
        let flipped = TriangleMesh::new(positions.clone(), flipped.collect()).unwrap();
        let source = SurfaceCurves { curves: Vec::new(), points: vec![Vertex(faces[0][0]).into()] };
        let mesh = TriangleMesh::new(positions, faces).unwrap();
        let [a, b] = [&mesh, &flipped].map(|m| free(m, &source));
        for (a, b) in a.iter().zip(&b) {
            assert_eq!(a.is_nan(), b.is_nan(), "seed {seed}");
            if (a - b).abs() > worst.0 {
                worst = ((a - b).abs(), seed);
            }
        }
    }
    println!("flipped faces: {worst:?}");
    assert!(worst.0 < 1e-6, "difference {:e} in the heap of seed {}", worst.0, worst.1);
}

/// Where normals cancel there is no distance, and the warning gives this reason.
#[test]
fn cancelled_normals_are_distinguished_from_no_source() {
    let mut positions = vec![[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
    let angles = (0..3).map(|k| f64::from(k) * std::f64::consts::TAU / 3.0);
    positions.extend(angles.map(|a| [a.cos(), a.sin(), 0.5]));
    let pages = TriangleMesh::new(positions, vec![[0, 1, 2], [0, 1, 3], [0, 1, 4]]).unwrap();
    let spine = SurfaceCurves::from_curve(Curve::signed([Vertex(0), Vertex(1)]));
    let face = TriangleMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
    let corners = SurfaceCurves { curves: Vec::new(), points: [0, 1, 2].map(|v| Vertex(v).into()).to_vec() };
    for (mesh, source) in [(pages, spine), (face, corners)] {
        let solution = solve(&mesh, &source, PAPER_TIME, LevelSets::Free);
        if solution.distance.as_slice().iter().any(|d| d.is_nan()) {
            let warned = solution.report.all_warnings().any(|w| w.kind() == "cancelled_component");
            assert!(warned, "{:?}", solution.report.warnings);
        }
    }
}
