//! Seams, cracks and T-junctions are found, and stitching joins them.

use crate::shapes::{Random, cube, grid, mesh, moebius, two_tetrahedra};
use eikona_mesh::{
    Face, Fault, MeshError, Quality, Seams, Stitched, SurfacePoint, Topology, TriangleMesh, Vertex, stitch,
    weld,
};

/// Returns a square and two adjacent rectangles of half its height (reports.md F6).
fn squares_of_different_height() -> TriangleMesh {
    let positions = vec![
        [0., 0., 0.],
        [1., 0., 0.],
        [1., 1., 0.],
        [0., 1., 0.],
        [1., 0.5, 0.],
        [2., 0., 0.],
        [2., 0.5, 0.],
        [2., 1., 0.],
    ];
    let faces = vec![[0, 1, 2], [0, 2, 3], [1, 5, 6], [1, 6, 4], [4, 6, 7], [4, 7, 2]];
    mesh(positions, faces)
}

/// Returns a strip of unit height from x = 0 to 1, and one from 1 + gap to 2, with these numbers of
/// rows; the second has its own vertices.
fn strips(rows: [u32; 2], gap: f64) -> TriangleMesh {
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    for (n, x) in rows.into_iter().zip([[0.0, 1.0], [1.0 + gap, 2.0]]) {
        let first = positions.len() as u32;
        for j in 0..=n {
            positions.extend(x.map(|x| [x, f64::from(j) / f64::from(n), 0.0]));
        }
        for j in 0..n {
            let a = first + 2 * j;
            faces.extend([[a, a + 1, a + 3], [a, a + 3, a + 2]]);
        }
    }
    mesh(positions, faces)
}

fn stitched(mesh: &TriangleMesh) -> Stitched {
    let stitched = stitch(mesh, None).expect("not too large");
    assert!(Seams::of(&stitched.mesh).is_empty());
    let again = stitch(&stitched.mesh, None).expect("not too large");
    assert!(!again.is_changed());
    assert_eq!(again.mesh.triangles(), stitched.mesh.triangles());
    for new in stitched.mesh.faces() {
        let old = stitched.provenance.face_parent(new);
        let corners = mesh.face_positions(old);
        assert!(stitched.mesh.face_positions(new).iter().all(|p| in_triangle(*p, corners)), "{new} in {old}");
    }
    stitched
}

/// Returns whether a point is in a triangle to within a thousandth of its size, by comparing areas.
fn in_triangle(p: [f64; 3], corners: [[f64; 3]; 3]) -> bool {
    let area = |t: [[f64; 3]; 3]| {
        let [u, v] = [1, 2].map(|k| [0, 1, 2].map(|i| t[k][i] - t[0][i]));
        let c = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        c.iter().map(|x| x * x).sum::<f64>().sqrt()
    };
    let parts: f64 = (0..3).map(|k| area([p, corners[k], corners[(k + 1) % 3]])).sum();
    (parts / area(corners) - 1.0).abs() < 1e-3
}

/// Returns the faces by the positions of their corners, each from its smallest corner on, sorted.
fn surface(mesh: &TriangleMesh) -> Vec<Vec<[i64; 3]>> {
    let place = |p: [f64; 3]| p.map(|x| (x * 1e9).round() as i64);
    let mut faces: Vec<_> = mesh
        .faces()
        .map(|f| {
            let mut corners = mesh.face_positions(f).map(place).to_vec();
            let least = (0..3).min_by_key(|&k| corners[k]).unwrap();
            corners.rotate_left(least);
            corners
        })
        .collect();
    faces.sort();
    faces
}

#[test]
fn a_vertex_inside_an_edge_is_found_and_inserted() {
    let mesh = squares_of_different_height();
    let seams = Seams::of(&mesh);
    assert!(seams.joints.is_empty());
    let [hanging] = seams.hanging[..] else { panic!("{seams:?}") };
    assert_eq!((hanging.vertex, mesh.edge_vertices(hanging.edge)), (Vertex(4), [Vertex(1), Vertex(2)]));
    assert!(matches!(seams.faults(&mesh)[..], [Fault::HangingVertex { vertex: Vertex(4), gap: 0.0, .. }]));
    let result = stitched(&mesh);
    assert_eq!(result.mesh.triangles()[..3], [[1, 4, 0], [4, 2, 0], [0, 2, 3]]);
    assert_eq!((result.inserted_vertices, result.joined_vertices, result.divided_faces), (1, 0, 1));
    let topology = Topology::of(&result.mesh);
    assert!(topology.is_manifold());
    assert_eq!((topology.boundary_loops.len(), topology.euler_characteristic), (1, 1));
}

#[test]
fn every_vertex_of_a_seam_is_inserted_on_the_other_side() {
    // reports.md F6: 20 cells meet 21. Only the endpoints coincide.
    for (rows, gap) in
        [[20, 21], [10, 11], [1, 20], [20, 1], [6, 6], [4, 6]].into_iter().flat_map(|r| [(r, 0.0), (r, 1e-7)])
    {
        let input = strips(rows, gap);
        let seams = Seams::of(&input);
        let common = (0..=rows[0]).filter(|j| (j * rows[1]) % rows[0] == 0).count();
        assert_eq!(seams.joints.len(), common, "{rows:?}");
        assert_eq!(seams.hanging.len(), (rows[0] + rows[1] + 2) as usize - 2 * common, "{rows:?}");
        assert!((seams.largest_gap() - gap).abs() < 1e-15);
        let result = stitched(&input);
        let topology = Topology::of(&result.mesh);
        assert!(topology.is_manifold());
        assert_eq!((topology.components.len(), topology.boundary_loops.len()), (1, 1));
        // Each vertex of the seam except its endpoints subdivides a face on the other side.
        let faces = 2 * (rows[0] + rows[1]) as usize + seams.hanging.len();
        assert_eq!(result.mesh.face_count(), faces);
        let area = Quality::of(&result.mesh).area;
        assert!((area - 2.0).abs() < 2e-7 + 1e-12, "{area}");
    }
}

#[test]
fn boundary_corners_may_hang_while_their_edges_contain_others() {
    // A square adjacent to four squares shifted by a half: a pinwheel with vertices at its corners
    // and midpoints.
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    for [x, y] in [[0., 0.], [0.5, -1.], [1., 0.5], [-0.5, 1.], [-1., -0.5]] {
        let first = positions.len() as u32;
        positions.extend([[x, y, 0.], [x + 1., y, 0.], [x + 1., y + 1., 0.], [x, y + 1., 0.]]);
        faces.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }
    let input = mesh(positions, faces);
    // Each corner of the middle square is inside a side of another one, which has a corner inside a
    // side of the middle one.
    assert_eq!(Seams::of(&input).hanging.len(), 8);
    let result = stitched(&input);
    let topology = Topology::of(&result.mesh);
    assert!(topology.is_manifold());
    assert_eq!((topology.components.len(), topology.euler_characteristic), (1, 1));
}

#[test]
fn three_parts_at_one_line_become_a_nonmanifold_edge() {
    // Two joined squares, and a wall of two rectangles on their common side.
    let positions = vec![
        [-1., 0., 0.],
        [0., 0., 0.],
        [0., 2., 0.],
        [-1., 2., 0.],
        [1., 0., 0.],
        [1., 2., 0.],
        [0., 0., 0.],
        [0., 1., 0.],
        [0., 2., 0.],
        [0., 0., 1.],
        [0., 1., 1.],
        [0., 2., 1.],
    ];
    let faces =
        vec![[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2], [6, 7, 10], [6, 10, 9], [7, 8, 11], [7, 11, 10]];
    let result = stitched(&mesh(positions, faces));
    let topology = Topology::of(&result.mesh);
    assert_eq!((topology.components.len(), topology.nonmanifold_edges.len()), (1, 2));
    assert_eq!(result.mesh.face_count(), 10);
}

#[test]
fn clean_meshes_stay_unchanged() {
    for input in [cube(), grid(4, 5), moebius(13, 3), two_tetrahedra(1)] {
        assert!(Seams::of(&input).is_empty());
        let result = stitch(&input, None).expect("not too large");
        assert!(!result.is_changed());
        assert_eq!(result.mesh.triangles(), input.triangles());
        assert_eq!(result.mesh.positions(), input.positions());
        assert!(result.provenance.is_identity());
    }
}

#[test]
fn nearby_boundaries_are_not_cracks() {
    // Ten times the tolerance is an intended gap.
    assert!(Seams::of(&strips([6, 6], 3e-5)).is_empty());
    assert!(Seams::of(&strips([6, 7], 3e-5)).is_empty());
    // A triangle over a square, with a corner on its diagonal.
    let mut positions = vec![[0., 0., 0.], [2., 0., 0.], [2., 2., 0.], [0., 2., 0.]];
    positions.extend([[1., 1., 0.], [3., 0.5, 0.], [3., 1.5, 0.]]);
    assert!(Seams::of(&mesh(positions, vec![[0, 1, 2], [0, 2, 3], [4, 5, 6]])).is_empty());
    // A tiny part next to a large one is not closed upon itself: its own edges determine the scale.
    let mut positions = vec![[0., 0., 0.], [1e7, 0., 0.], [0., 1e7, 0.]];
    positions.extend([
        [-5., 0., 0.],
        [-4., 0., 0.],
        [-5., 1., 0.],
        [-5., -0.5, 0.],
        [-4., -0.5, 0.],
        [-4.5, -2., 0.],
    ]);
    let input = mesh(positions, vec![[0, 1, 2], [3, 4, 5], [6, 7, 8]]);
    assert!(Seams::of(&input).is_empty());
}

#[test]
fn a_given_tolerance_closes_wider_gaps() {
    let input = strips([5, 7], 1e-3);
    assert!(!stitch(&input, Some(9e-4)).expect("a length").is_changed());
    let result = stitch(&input, Some(1.1e-3)).expect("a length");
    assert_eq!(Topology::of(&result.mesh).boundary_loops.len(), 1);
    assert!((result.largest_gap - 1e-3).abs() < 1e-12);
    for tolerance in [-1.0, f64::NAN, f64::INFINITY] {
        let refused = stitch(&input, Some(tolerance)).map(|_| ());
        assert!(matches!(refused, Err(MeshError::Parameter { name: "tolerance", .. })), "{tolerance}");
    }
}

#[test]
fn points_keep_their_position() {
    let input = strips([3, 5], 0.0);
    let result = stitched(&input);
    let mut random = Random(5);
    let mut number = || random.below(1001) as f64 / 1000.0;
    let position =
        |mesh: &TriangleMesh, point: SurfacePoint| point.locate(mesh).expect("on the mesh").position(mesh);
    let check = |point: SurfacePoint| {
        let (old, new) = (position(&input, point), position(&result.mesh, result.point(point)));
        assert!((0..3).all(|k| (old[k] - new[k]).abs() < 1e-12), "{point:?} {old:?} {new:?}");
    };
    input.vertices().for_each(|v| check(SurfacePoint::Vertex { vertex: v.0 }));
    for _ in 0..20 {
        for e in input.edges() {
            let [a, b] = input.edge_vertices(e).map(|v| v.0);
            check(SurfacePoint::Edge { vertices: [a, b], t: number() });
            check(SurfacePoint::Edge { vertices: [b, a], t: number() });
        }
        for f in input.faces() {
            let [a, b, c] = input.face_vertices(f).map(|v| v.0);
            let (u, v) = (number(), number());
            let bary = [1.0 - u, u * (1.0 - v), u * v];
            check(SurfacePoint::Face { vertices: [b, c, a], bary });
        }
    }
}

/// Returns a grid of `n` columns and rows cut along x = n / 2 into two parts with separate
/// vertices, where each boundary edge at the cut is subdivided at random positions, on one side or
/// on both. Also returns the same surface without the cut.
fn cut_grid(n: u32, random: &mut Random) -> (TriangleMesh, TriangleMesh) {
    let mut places: Vec<Vec<f64>> = Vec::new();
    let mut left = Vec::new();
    for _ in 0..n {
        let mut inside: Vec<f64> =
            (0..random.below(4)).map(|_| (1 + random.below(98)) as f64 / 99.0).collect();
        inside.sort_by(f64::total_cmp);
        inside.dedup();
        left.push(inside.iter().map(|_| random.below(2) == 0).collect::<Vec<_>>());
        places.push(inside);
    }
    let middle = n / 2;
    let part = |side: u32, all: bool| {
        let (mut positions, mut faces) = (Vec::new(), Vec::new());
        let columns = [0..middle, middle..n][side as usize].clone();
        let number = |i: u32, j: u32| (i - columns.start) * (n + 1) + j;
        for i in columns.start..=columns.end {
            positions.extend((0..=n).map(|j| [f64::from(i), f64::from(j), 0.0]));
        }
        for i in columns.clone() {
            for j in 0..n {
                let (a, b, c, d) = (number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1));
                // The side at the cut, and its opposite corner.
                let at_cut = [(i + 1 == middle, b, c, a), (i == middle, d, a, c)][side as usize];
                let mut row = vec![at_cut.1];
                if at_cut.0 {
                    let own = |k: &usize| all || left[j as usize][*k] == (side == 0);
                    let mut inside: Vec<usize> = (0..places[j as usize].len()).filter(own).collect();
                    if side == 1 {
                        inside.reverse();
                    }
                    for k in inside {
                        row.push(positions.len() as u32);
                        positions.push([f64::from(middle), f64::from(j) + places[j as usize][k], 0.0]);
                    }
                }
                row.push(at_cut.2);
                faces.extend(row.windows(2).map(|p| [p[0], p[1], at_cut.3]));
                faces.push(if side == 0 { [a, c, d] } else { [a, b, c] });
            }
        }
        (positions, faces)
    };
    let both = |all: bool| {
        let ((mut positions, mut faces), (others, more)) = (part(0, all), part(1, all));
        let first = positions.len() as u32;
        positions.extend(others);
        faces.extend(more.into_iter().map(|f| f.map(|v| v + first)));
        mesh(positions, faces)
    };
    (both(false), weld(&both(true), 0.0).expect("tolerance").mesh)
}

fn moved(input: &TriangleMesh, place: impl Fn([f64; 3]) -> [f64; 3]) -> TriangleMesh {
    input.with_positions(input.positions().iter().map(|&p| place(p)).collect()).expect("finite")
}

#[test]
fn random_t_junctions_are_stitched_to_the_conforming_mesh() {
    let mut random = Random(23);
    for _ in 0..40 {
        let n = 2 + random.below(6) as u32;
        let (cut, conforming) = cut_grid(n, &mut random);
        let result = stitched(&cut);
        assert_eq!(surface(&result.mesh), surface(&conforming));
        assert_eq!(result.mesh.vertex_count(), conforming.vertex_count());

        // Scale, position and numbering change nothing.
        for scale in [1e-6, 1e6] {
            let other = stitched(&moved(&cut, |p| p.map(|x| x * scale)));
            assert_eq!(other.mesh.triangles(), result.mesh.triangles());
        }
        let (c, s) = (0.3f64.cos(), 0.3f64.sin());
        let turn = |[x, y, z]: [f64; 3]| [c * x - s * y + 0.3 * z, s * x + c * y, c * z - s * (x + y) + 7.0];
        let other = stitched(&moved(&cut, turn));
        assert_eq!(other.mesh.triangles(), result.mesh.triangles());

        let count = cut.vertex_count();
        let mut order: Vec<u32> = (0..count as u32).collect();
        (1..count).for_each(|i| order.swap(i, random.below(i as u64 + 1) as usize));
        let mut positions = vec![[0.0; 3]; count];
        cut.vertices().for_each(|v| positions[order[v.index()] as usize] = cut.position(v));
        let faces = cut.triangles().iter().rev().map(|f| f.map(|v| order[v as usize])).collect();
        assert_eq!(surface(&stitched(&mesh(positions, faces)).mesh), surface(&conforming));
    }
}

#[test]
fn degenerate_inputs_do_not_take_quadratic_time() {
    const FACES: u32 = 100_000;
    let soup = |place: &dyn Fn(u32) -> [f64; 3]| {
        mesh((0..3 * FACES).map(place).collect(), (0..FACES).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect())
    };
    // All vertices at one point; all triangles at one point; corners of all triangles within the
    // tolerance of one point; and a mesh that is smaller than the tolerance, since one face is far
    // away.
    let corner = |v: u32| [f64::from(v % 3), f64::from(v % 3 / 2), 0.0];
    let near = |v: u32| {
        if v.is_multiple_of(3) { [1e-9 * f64::from(v), 0., 0.] } else { [1.0, f64::from(v) + 1.0, 0.] }
    };
    let far =
        |v: u32| if v < 3 { corner(v).map(|x| 1e12 * x) } else { [f64::from(v), f64::from(v % 2), 0.0] };
    let places: [(&dyn Fn(u32) -> [f64; 3], bool); 4] =
        [(&|_| [0.0; 3], false), (&corner, false), (&near, true), (&far, false)];
    for (place, truncated) in places {
        let input = soup(place);
        let seams = Seams::of(&input);
        assert_eq!(seams.truncated, truncated);
        assert!(seams.joints.len() + seams.hanging.len() <= input.vertex_count());
    }
    let refused = stitch(&soup(&near), None).map(|_| ());
    assert!(matches!(refused, Err(MeshError::Parameter { name: "tolerance", .. })), "{refused:?}");
    let copies = stitch(&soup(&corner), None).expect("not too large");
    assert_eq!((copies.mesh.vertex_count(), copies.mesh.edge_count()), (3, 3));
}

#[test]
fn a_point_in_a_face_with_unchanged_edges_is_unchanged() {
    let input = squares_of_different_height();
    let result = stitched(&input);
    let whole = SurfacePoint::Face { vertices: [0, 2, 3], bary: [0.2, 0.3, 0.5] };
    assert_eq!(result.point(whole), whole);
    let divided = result.point(SurfacePoint::Edge { vertices: [2, 1], t: 0.5 });
    assert_eq!(divided, SurfacePoint::Vertex { vertex: 4 });
    assert_eq!(result.provenance.face_parent(Face(1)), Face(0));
}
