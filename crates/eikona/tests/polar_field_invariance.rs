//! Fields do not depend on numbering, orientation, position or size of the mesh, and follow their
//! singularities.

mod frames;
mod plane;

use eikona::mesh::shapes;
use eikona::mesh::{Face, Halfedge, SurfacePoint, TriangleMesh, Vertex, damage};
use eikona::polar_field::{FieldOptions, Place, PolarField, Singularity, Solver, SolverOptions};
use frames::{angle_in_face, dot, sub, wrapped};
use plane::in_plane;

fn solve(mesh: &TriangleMesh, given: &[Singularity], degree: u32) -> PolarField {
    let solver = Solver::new(mesh, &SolverOptions::default()).unwrap();
    let field = solver.solve(given, &FieldOptions::default().with_degree(degree)).unwrap();
    assert!(field.report.aliased.is_empty() && field.report.unplaced.is_empty(), "{:?}", field.report);
    field
}

/// A sphere with singularities at a vertex, in two edges and in two faces, whose indices times N
/// add up to 2N.
fn scene(degree: u32) -> (TriangleMesh, Vec<Singularity>) {
    let sphere = damage::jitter(&shapes::icosphere(2).unwrap(), 0.2, 6).unwrap();
    let face = |f: usize| sphere.triangles()[f];
    let edge = |f: usize, t: f64| SurfacePoint::Edge { vertices: [face(f)[0], face(f)[1]], t };
    let inside = |f: usize, bary: [f64; 3]| SurfacePoint::Face { vertices: face(f), bary };
    let rest = 2 * i64::from(degree) - 3;
    let points = [
        (SurfacePoint::Vertex { vertex: face(10)[2] }, 1),
        (edge(80, 0.3), -1),
        (edge(150, 0.6), 2),
        (inside(220, [0.2, 0.3, 0.5]), rest),
        (inside(290, [0.6, 0.3, 0.1]), 1),
    ];
    let index = |turns: i64| turns as f64 / f64::from(degree);
    let given =
        points.into_iter().map(|(p, turns)| Singularity { place: Place::Point(p), index: index(turns) });
    (sphere.clone(), given.collect())
}

/// The singularities on a mesh whose vertices have other numbers, with the vertices of each element
/// named in another order.
fn renumbered(given: &[Singularity], number: impl Fn(u32) -> u32) -> Vec<Singularity> {
    let moved = |point: SurfacePoint| match point {
        SurfacePoint::Vertex { vertex } => SurfacePoint::Vertex { vertex: number(vertex) },
        SurfacePoint::Edge { vertices: [a, b], t } => {
            SurfacePoint::Edge { vertices: [number(b), number(a)], t: 1.0 - t }
        }
        SurfacePoint::Face { vertices: [a, b, c], bary: [x, y, z] } => {
            SurfacePoint::Face { vertices: [b, c, a].map(&number), bary: [y, z, x] }
        }
    };
    let place = |place: Place| match place {
        Place::Point(point) => Place::Point(moved(point)),
        boundary => boundary,
    };
    given.iter().map(|s| Singularity { place: place(s.place), index: s.index }).collect()
}

/// A field relative to the first side of each face of a mesh: the angle of its N-th power at a
/// point of the face. `corner` gives the corner of the field's mesh for each corner of that mesh;
/// if the faces of one are flipped, angles are measured the other way round.
fn angles(field: &PolarField, mesh: &TriangleMesh, corner: impl Fn(Halfedge) -> Halfedge) -> Vec<f64> {
    let weights = [0.2, 0.5, 0.3];
    let of_face = |f: Face| {
        let corners = [0, 1, 2].map(|k| corner(f.halfedge(k)));
        let other = corners[0].face();
        let mut there = [0.0; 3];
        (0..3).for_each(|k| there[corners[k].side()] = weights[k]);
        let own = field.mesh();
        let [a, b] = [corners[0], corners[1]].map(|c| own.position(own.origin(c)));
        let angle = field.power_at(other, there).arg()
            - f64::from(field.degree()) * angle_in_face(own, other, sub(b, a));
        if corners[0].next() == corners[1] { angle } else { -angle }
    };
    mesh.faces().map(of_face).collect()
}

/// The largest difference of two fields, after the best rotation of all directions by one angle.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| wrapped(a - b)).collect();
    assert!(!differences.is_empty() && differences.iter().all(|d| d.is_finite()));
    let off: Vec<f64> = differences.iter().map(|d| wrapped(d - differences[0])).collect();
    let (low, high) = off.iter().fold((0.0, 0.0), |(low, high): (f64, f64), d| (low.min(*d), high.max(*d)));
    0.5 * (high - low)
}

#[test]
fn numbers_do_not_matter() {
    for degree in [1, 2, 4] {
        let (mesh, given) = scene(degree);
        let before = angles(&solve(&mesh, &given, degree), &mesh, |h| h);
        for seed in 0..4 {
            // Vertices and faces are renumbered, and every face starts at another corner.
            let shuffled = damage::shuffle(&mesh, seed).unwrap();
            let mut number = vec![0; mesh.vertex_count()];
            for (new, old) in shuffled.source_vertex.iter() {
                number[old.index()] = new.0;
            }
            let mut corner = vec![Halfedge(0); mesh.halfedge_count()];
            for (new, old) in shuffled.source_corner.iter() {
                corner[old.index()] = Halfedge(new.0);
            }
            let moved = renumbered(&given, |v| number[v as usize]);
            let after = angles(&solve(&shuffled.mesh, &moved, degree), &mesh, |h| corner[h.index()]);
            let distance = distance(&before, &after);
            assert!(distance < 1e-9, "N {degree}, shuffle {seed}: {distance:e}");
        }
    }
}

#[test]
fn position_and_size_do_not_matter() {
    let degree = 4;
    let (mesh, given) = scene(degree);
    let before = angles(&solve(&mesh, &given, degree), &mesh, |h| h);
    let (sin, cos) = 0.7f64.sin_cos();
    for (scale, shift) in [(1.0, 100.0), (1e-8, 0.0), (1e8, 0.0), (1e-200, 0.0), (1e200, 0.0)] {
        let moved = |p: &[f64; 3]| {
            let [x, y, z] = *p;
            let [y, z] = [cos * y - sin * z, sin * y + cos * z];
            [cos * x - sin * z, y, sin * x + cos * z].map(|x| scale * (x + shift))
        };
        let mesh = mesh.with_positions(mesh.positions().iter().map(moved).collect()).unwrap();
        let field = solve(&mesh, &given, degree);
        let distance = distance(&before, &angles(&field, &mesh, |h| h));
        assert!(distance < 1e-9, "{scale:e}: {distance:e}");
        for vector in field.vectors_at(SurfacePoint::Vertex { vertex: 5 }).unwrap() {
            assert!((dot(vector, vector) - 1.0).abs() < 1e-12, "{scale:e}: {vector:?}");
        }
    }
}

/// Indices do not depend on the orientation, and a mesh with some faces flipped is put in order.
#[test]
fn orientation_does_not_matter() {
    for degree in [1, 4] {
        let (mesh, given) = scene(degree);
        let before = angles(&solve(&mesh, &given, degree), &mesh, |h| h);
        for keep in [0, 3, 7] {
            let flipped = mesh.with_flipped_faces(|f| keep == 0 || f.index() % keep == 1);
            let field = solve(&flipped, &given, degree);
            let own = field.mesh();
            let corner = |h: Halfedge| {
                let v = mesh.origin(h);
                let k = own.face_vertices(h.face()).iter().position(|w: &Vertex| *w == v).unwrap();
                h.face().halfedge(k)
            };
            let distance = distance(&before, &angles(&field, &mesh, corner));
            assert!(distance < 1e-9, "N {degree}: {distance:e}");
        }
    }
}

/// Moves a singularity across a face to an edge and along it to a vertex. Far away, the field
/// changes in proportion with the steps, but for jumps from face to edge and from edge to vertex:
/// there the singularity seems to move by 0.1 and 0.3 edge lengths at once.
#[test]
fn fields_follow_their_singularities() {
    let mut jumps = Vec::new();
    for rings in [8, 16] {
        let disk = shapes::disk(rings, 6, 1.0).unwrap();
        let solver = Solver::new(&disk, &SolverOptions::default()).unwrap();
        let [x, y] = [0.23, 0.11];
        let SurfacePoint::Face { vertices: [i, j, k], .. } = in_plane(&disk, [x, y]) else { unreachable!() };
        let field = |point: SurfacePoint| {
            let given = [
                Singularity { place: Place::Boundary(0), index: 0.0 },
                Singularity { place: Place::Point(point), index: 1.0 },
            ];
            let field = solver.solve(&given, &FieldOptions::default().with_degree(1)).unwrap();
            let far = |f: &Face| {
                let [u, v, _] = disk.position(disk.face_vertices(*f)[0]);
                (u - x).hypot(v - y) > 0.4
            };
            let angle =
                |f: Face| field.power_at(f, [0.2, 0.5, 0.3]).arg() - angle_in_face(&disk, f, [1.0, 0.0, 0.0]);
            disk.faces().filter(far).map(angle).collect::<Vec<f64>>()
        };
        let inside = |c: f64| {
            let half = 0.5 * (1.0 - c);
            SurfacePoint::Face { vertices: [i, j, k], bary: [half, half, c] }
        };
        let edge = |t: f64| SurfacePoint::Edge { vertices: [i, j], t };
        let vertex = |vertex: u32| SurfacePoint::Vertex { vertex };
        let change = |a: SurfacePoint, b: SurfacePoint| distance(&field(a), &field(b));
        let length = change(vertex(i), vertex(j));
        for at in [0.6, 0.3, 0.1, 1e-3] {
            for step in [0.1 * at, 1e-3 * at] {
                for point in [&inside as &dyn Fn(f64) -> SurfacePoint, &edge] {
                    let rate = change(point(at), point(at - step)) / step / length;
                    // Close to the edge or vertex, the angles of the targets change faster.
                    let most = if at > 0.05 { 1.0 } else { 4.0 };
                    assert!(rate < most, "{rings} rings at {at}, step {step}: {rate}");
                }
            }
        }
        let to_edge = change(inside(1e-7), edge(0.5)) / length;
        let to_vertex = change(edge(1e-7), vertex(i)) / length;
        println!(
            "{rings} rings: an edge length {length:.3}, to the edge {to_edge:.3}, to the vertex {to_vertex:.3}"
        );
        jumps.push((length, to_edge, to_vertex));
    }
    // An edge length and with it the jumps vanish with refinement.
    assert!(jumps[1].0 < 0.6 * jumps[0].0, "{jumps:?}");
    assert!(jumps.iter().all(|(_, edge, vertex)| *edge < 0.15 && *vertex < 0.35), "{jumps:?}");
}
