//! Fields with prescribed singularities, checked on loops around them and at the singular points.

mod plane;

use eikona::mesh::random::Random;
use eikona::mesh::{Face, SurfacePoint, TriangleMesh, Vertex, damage, shapes};
use eikona::polar_field::{FieldOptions, Place, Singularity, Solver, SolverOptions};
use plane::in_plane;

/// A point inside an element of this kind, away from the boundary and from used elements.
fn place(mesh: &TriangleMesh, kind: usize, random: &mut Random) -> Place {
    loop {
        let f = Face(random.below(mesh.face_count()) as u32);
        let corners = mesh.face_vertices(f);
        if corners.iter().any(|v| mesh.is_boundary_vertex(*v)) {
            continue;
        }
        let vertices = corners.map(|v| v.0);
        return Place::Point(match kind {
            0 => SurfacePoint::Vertex { vertex: vertices[0] },
            1 => SurfacePoint::Edge { vertices: [vertices[0], vertices[1]], t: random.range(0.15, 0.85) },
            _ => {
                let weights = [random.range(0.2, 1.0), random.range(0.2, 1.0), random.range(0.2, 1.0)];
                let sum: f64 = weights.iter().sum();
                SurfacePoint::Face { vertices, bary: weights.map(|w| w / sum) }
            }
        });
    }
}

/// On a flat mesh the vectors can be compared directly: around each singularity they turn by its
/// index, whatever is inside the loop.
#[test]
fn vectors_turn_around_singular_points_of_a_flat_disk() {
    let disk = shapes::disk(16, 8, 1.0).unwrap();
    let solver = Solver::new(&disk, &SolverOptions::default()).unwrap();
    let mut random = Random::from_seed(5);
    let mut loops = 0;
    for degree in [1u32, 2, 4] {
        for turns in [1.0, -1.0, 2.0] {
            let index = turns / f64::from(degree);
            for (kind, centre) in [[0.3, 0.1], [-0.25, 0.3], [0.1, -0.4]].into_iter().enumerate() {
                let SurfacePoint::Face { vertices, .. } = in_plane(&disk, centre) else { unreachable!() };
                let point = match kind {
                    0 => SurfacePoint::Vertex { vertex: vertices[0] },
                    1 => {
                        SurfacePoint::Edge { vertices: [vertices[0], vertices[1]], t: random.range(0.2, 0.8) }
                    }
                    _ => SurfacePoint::Face { vertices, bary: [0.5, 0.2, 0.3] },
                };
                let given = [
                    Singularity { place: Place::Point(point), index },
                    Singularity { place: Place::Boundary(0), index: 1.0 - index },
                ];
                let options = FieldOptions::default().with_degree(degree);
                let field = solver.solve(&given, &options).unwrap();
                assert!(field.report.aliased.is_empty(), "{:?}", field.report);
                let [x, y, _] = point.locate(&disk).unwrap().position(&disk);
                for radius in [0.15, 0.3, 0.5] {
                    let angles: Vec<f64> = (0..500)
                        .map(|i| {
                            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 500.0).sin_cos();
                            let at = in_plane(&disk, [x + radius * cos, y + radius * sin]);
                            let vectors = field.vectors_at(at).unwrap();
                            assert_eq!(vectors.len(), degree as usize);
                            assert!(vectors.iter().all(|v| (v[0].hypot(v[1]) - 1.0).abs() < 1e-12));
                            f64::from(degree) * vectors[0][1].atan2(vectors[0][0])
                        })
                        .collect();
                    let step = |a: f64, b: f64| {
                        let d = b - a;
                        d - std::f64::consts::TAU * (d / std::f64::consts::TAU).round()
                    };
                    let turned: f64 = (0..500).map(|i| step(angles[i], angles[(i + 1) % 500])).sum();
                    assert!(
                        (turned / std::f64::consts::TAU - turns).abs() < 1e-9,
                        "{degree} {turns} {kind} {radius}"
                    );
                    loops += 1;
                }
            }
        }
    }
    assert_eq!(loops, 81);
}

#[test]
fn prescriptions_that_can_not_be_met_are_refused() {
    let sphere = shapes::icosphere(2).unwrap();
    let solver = Solver::new(&sphere, &SolverOptions::default()).unwrap();
    let at = |vertex, index| Singularity { place: Place::Point(SurfacePoint::Vertex { vertex }), index };
    let fault = |given: &[Singularity], degree| {
        solver.solve(given, &FieldOptions::default().with_degree(degree)).unwrap_err().to_string()
    };
    let message = fault(&[at(0, 0.25), at(5, 1.0)], 4);
    assert!(
        message.contains("add up to 1.25 instead of its Euler characteristic 2: +0.75 is missing"),
        "{message}"
    );
    let message = fault(&[at(0, 0.3)], 4);
    assert!(
        message.contains(
            "singularity 0 has index 0.3, which is not a whole multiple of 1/4; choose 0.25 or 0.5"
        ),
        "{message}"
    );
    assert!(fault(&[at(0, f64::NAN)], 4).contains("singularity 0 has index NaN"));
    assert!(fault(&[at(0, -1e9)], 4).contains("choose one of at most 1000000/4 in magnitude"));
    // Three decimals of a third are a third.
    let thirds = FieldOptions::default().with_degree(3);
    assert!(solver.solve(&[at(0, 0.333), at(5, 1.667)], &thirds).unwrap().report.residual < 1e-10);
    assert!(
        fault(&[at(7, 1.0), at(7, 1.0)], 1).contains("singularity 1 is on vertex 7, which has another one")
    );
    assert!(fault(&[at(100_000, 2.0)], 1).contains("singularity 0: vertex 100000 does not exist"));
    assert!(fault(&[at(0, 2.0)], 0).contains("N = 0 is out of range"));
    let [a, b, c] = sphere.triangles()[7];
    let on = |point, index| Singularity { place: Place::Point(point), index };
    let inside = |index| on(SurfacePoint::Face { vertices: [a, b, c], bary: [0.3, 0.3, 0.4] }, index);
    let on_edge = |i: u32, j: u32, index| on(SurfacePoint::Edge { vertices: [i, j], t: 0.4 }, index);
    let message = fault(&[on_edge(b, c, 1.0), inside(1.0)], 1);
    assert!(
        message.contains("singularity 1 is inside face 7 and singularity 0 on its own edge"),
        "{message}"
    );
    // Indices of zero do not count; three edges of a face do.
    let options = FieldOptions::default().with_degree(1);
    assert!(solver.solve(&[on_edge(b, c, 0.0), inside(2.0)], &options).is_ok());
    let around = [on_edge(a, b, 1.0), on_edge(b, c, 1.0), on_edge(c, a, 1.0), at(90, -1.0)];
    let message = fault(&around, 1);
    assert!(message.contains("determine the scale in face 7 more than once"), "{message}");
    let ring = Singularity { place: Place::Boundary(0), index: 0.0 };
    assert!(fault(&[ring], 1).contains("the mesh has 0 boundary loops"));
    let options = FieldOptions::default().with_generators(vec![1.0]);
    assert!(
        solver
            .solve(&[at(0, 2.0)], &options)
            .unwrap_err()
            .to_string()
            .contains("1 index is given for homology generators, but the surface has 0 generators")
    );

    let fault = |mesh: &TriangleMesh| Solver::new(mesh, &SolverOptions::default()).unwrap_err().to_string();
    let band = shapes::moebius_band(1.0, 0.5, 20, 3).unwrap();
    assert!(fault(&band).contains("component 0 (from face 0) is not orientable"));
    let corners = vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [0., -1., 0.]];
    let fin = TriangleMesh::new(corners, vec![[0, 1, 2], [0, 1, 3], [0, 1, 4]]).unwrap();
    assert!(fault(&fin).contains("(vertex 0 to vertex 1) has 3 faces"));
    let flat = TriangleMesh::new(vec![[0., 0., 0.], [1., 0., 0.], [2., 0., 0.]], vec![[0, 1, 2]]).unwrap();
    assert!(fault(&flat).contains("face 0 has no area"));
    let disk = shapes::disk(3, 6, 1.0).unwrap();
    let solver = Solver::new(&disk, &SolverOptions::default()).unwrap();
    let rim = (0..disk.vertex_count() as u32).find(|v| disk.is_boundary_vertex(Vertex(*v))).unwrap();
    let message = solver.solve(&[at(rim, 1.0)], &FieldOptions::default()).unwrap_err().to_string();
    assert!(message.contains("which is on the boundary; move it inside"), "{message}");
}

/// Found by fuzzing: the scales of such a power overflow, except at the centre.
#[test]
fn huge_indices_are_unplaced_instead_of_infinite() {
    let torus = shapes::torus(1.0, 0.4, 6, 4).unwrap();
    let solver = Solver::new(&torus, &SolverOptions::default()).unwrap();
    let at = |face: usize, bary: [f64; 3], index: f64| {
        let vertices = torus.triangles()[face];
        Singularity { place: Place::Point(SurfacePoint::Face { vertices, bary }), index }
    };
    let given = [at(0, [0.5, 0.25, 0.25], 1200.0), at(30, [0.2, 0.3, 0.5], -1200.0)];
    let field = solver.solve(&given, &FieldOptions::default().with_degree(1)).unwrap();
    assert_eq!(field.report.unplaced, ["face 0", "face 30"]);
    assert!(torus.faces().all(|f| field.power_at(f, [0.2, 0.5, 0.3]).re.is_finite()));
}

/// From one face to the other, the N-th power turns by exactly half a turn per unit of its index at
/// the singular point of an edge.
#[test]
fn edge_singularities_are_at_their_points() {
    let disk = damage::jitter(&shapes::disk(8, 8, 1.0).unwrap(), 0.2, 4).unwrap();
    // The jitter moves vertices out of the plane, too.
    let flat = disk.positions().iter().map(|p| [p[0], p[1], 0.0]).collect();
    let disk = disk.with_positions(flat).unwrap();
    let solver = Solver::new(&disk, &SolverOptions::default()).unwrap();
    let mut random = Random::from_seed(3);
    for run in 0..40 {
        let Place::Point(SurfacePoint::Edge { vertices, t }) = place(&disk, 1, &mut random) else {
            unreachable!()
        };
        let degree = [1, 2, 4][run % 3];
        let turns = [1.0, -1.0, 2.0, -2.0][run % 4];
        let index = turns / f64::from(degree);
        let given = [
            Singularity { place: Place::Point(SurfacePoint::Edge { vertices, t }), index },
            Singularity { place: Place::Boundary(0), index: 1.0 - index },
        ];
        let field = solver.solve(&given, &FieldOptions::default().with_degree(degree)).unwrap();
        assert!(field.report.unplaced.is_empty() && field.report.aliased.is_empty(), "{:?}", field.report);
        let edge = disk.find_edge(Vertex(vertices[0]), Vertex(vertices[1])).unwrap();
        let angle = |face: Face, t: f64| {
            let own = disk.face_vertices(face);
            let weights = own.map(|v| match v.0 {
                v if v == vertices[0] => 1.0 - t,
                v if v == vertices[1] => t,
                _ => 0.0,
            });
            let [a, b] = [own[0], own[1]].map(|v| disk.position(v));
            let frame = (b[1] - a[1]).atan2(b[0] - a[0]);
            field.power_at(face, weights).arg() + f64::from(degree) * frame
        };
        let [f, g] = [0, 1].map(|i| disk.edge_halfedges(edge)[i].face());
        let wrapped = |d: f64| d - std::f64::consts::TAU * (d / std::f64::consts::TAU).round();
        // Half a turn per index, here and not before or after.
        let difference = |t: f64| wrapped(angle(f, t) - angle(g, t) - std::f64::consts::PI * turns);
        assert!(difference(t).abs() < 1e-9, "run {run}: {}", difference(t));
        let [before, after] = [t - 1e-4, t + 1e-4].map(difference);
        assert!(before * after < 0.0, "run {run}: {before} {after}");
    }
}
