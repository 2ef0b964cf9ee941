//! Trivial connections, and what power-linear fields gain over them.

use eikona::mesh::random::Random;
use eikona::mesh::{SurfacePoint, Topology, TriangleMesh, damage, shapes};
use eikona::polar_field::{
    AutomaticOptions, FieldOptions, Place, PolarField, PolarFieldError, Singularity, Solver,
};

fn at(vertex: usize, index: f64) -> Singularity {
    Singularity { place: Place::Point(SurfacePoint::Vertex { vertex: vertex as u32 }), index }
}

/// The turn of the power across each edge beyond parallel transport, from unfolded neighbours.
fn squared_jumps(field: &PolarField) -> f64 {
    let mesh = field.mesh();
    let n = f64::from(field.degree());
    let mut sum = 0.0;
    for e in mesh.edges() {
        let &[h, twin] = mesh.edge_halfedges(e) else { continue };
        let side = |h: eikona::mesh::Halfedge| {
            let [a, b] = [mesh.origin(h), mesh.tip(h)].map(|v| mesh.position(v));
            let along: [f64; 3] = std::array::from_fn(|k| b[k] - a[k]);
            let [p, q, r] = mesh.face_positions(h.face());
            let [u, w] = [q, r].map(|x| -> [f64; 3] { std::array::from_fn(|k| x[k] - p[k]) });
            let normal = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]];
            let vertices = mesh.face_vertices(h.face()).map(|v| v.0);
            let third = SurfacePoint::Face { vertices, bary: [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0] };
            let v = field.vectors_at(third).unwrap()[0];
            let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            let cross = [
                along[1] * v[2] - along[2] * v[1],
                along[2] * v[0] - along[0] * v[2],
                along[0] * v[1] - along[1] * v[0],
            ];
            (dot(cross, normal) / dot(normal, normal).sqrt()).atan2(dot(along, v))
        };
        // The twin's side runs the other way, which adds half a turn.
        let turn = n * (side(h) - side(twin) - std::f64::consts::PI);
        sum += (turn - std::f64::consts::TAU * (turn / std::f64::consts::TAU).round()).powi(2);
    }
    sum
}

#[test]
fn indices_are_those_prescribed_on_every_topology() {
    let surfaces: [(&str, TriangleMesh); 4] = [
        ("sphere", damage::jitter(&shapes::icosphere(3).unwrap(), 0.2, 1).unwrap()),
        ("torus", damage::jitter(&shapes::torus(1.0, 0.4, 30, 12).unwrap(), 0.2, 1).unwrap()),
        ("genus 2", shapes::chain_of_genus(2, 2).unwrap()),
        ("annulus", shapes::annulus(0.4, 1.0, 6, 24).unwrap()),
    ];
    let mut random = Random::from_seed(11);
    for (name, mesh) in surfaces {
        let topology = Topology::of(&mesh);
        let solver = Solver::new(&mesh, &Default::default()).unwrap();
        for degree in [1, 2, 4] {
            let n = f64::from(degree);
            let on_boundary =
                |v: u32| topology.boundary_loops.iter().any(|l| l.vertices.iter().any(|u| u.0 == v));
            let mut inner: Vec<u32> = (0..mesh.vertex_count() as u32).filter(|&v| !on_boundary(v)).collect();
            let mut take = || inner.swap_remove((random.uniform() * inner.len() as f64) as usize) as usize;
            let chi = topology.euler_characteristic as f64;
            let mut prescribed = vec![at(take(), 1.0 / n), at(take(), -1.0 / n)];
            // One turn of the power each, so that every index shows from face to face.
            prescribed.extend((0..(chi.abs() * n) as usize).map(|_| at(take(), chi.signum() / n)));
            if !topology.boundary_loops.is_empty() {
                prescribed.push(Singularity { place: Place::Boundary(1), index: 1.0 / n });
                prescribed.push(at(take(), -1.0 / n));
            }
            // Of the smoothest field, and one turn more along one of them: others twist the field
            // so much that indices do not show from face to face.
            let automatic = AutomaticOptions::default().with_degree(degree);
            let mut generators = solver.automatic(&automatic).unwrap().generators;
            generators.iter_mut().take(1).for_each(|index| *index += 1.0 / n);
            let options = FieldOptions::default().with_degree(degree).with_generators(generators);
            let field = solver.trivial_connection(&prescribed, &options).unwrap();
            assert!(field.report.residual < 1e-9 && field.report.closure < 1e-9, "{name}");
            let wanted: Vec<f64> = prescribed.iter().map(|s| s.index).collect();
            assert_eq!(field.report.measured, wanted, "{name}, N = {degree}");
            assert!(field.report.aliased.is_empty(), "{name}, N = {degree}: {:?}", field.report.aliased);
        }
    }
}

#[test]
fn no_field_that_is_constant_in_faces_has_smaller_jumps() {
    // Every such field with the same indices differs by an angle per face: the sum of squares is at
    // its least if any such change makes it larger.
    let mesh = damage::jitter(&shapes::torus(1.0, 0.4, 24, 10).unwrap(), 0.2, 4).unwrap();
    let solver = Solver::new(&mesh, &Default::default()).unwrap();
    let prescribed = [at(5, 0.5), at(100, -0.5)];
    let options = FieldOptions::default().with_degree(2).with_generators(vec![0.5, 0.0]);
    let flat = solver.trivial_connection(&prescribed, &options).unwrap();
    let smooth = solver.solve(&prescribed, &options).unwrap();
    let [least, other] = [&flat, &smooth].map(squared_jumps);
    // The power-linear field, read at the centroids, is one of them.
    assert!(least < other, "{least} and {other}");
    assert!(other < 1.2 * least, "they are close: {least} and {other}");
    assert!(smooth.report.energy < flat.report.energy, "the power-linear field turns inside faces too");
}

#[test]
fn singularities_off_vertices_are_refused() {
    let mesh = shapes::icosphere(2).unwrap();
    let solver = Solver::new(&mesh, &Default::default()).unwrap();
    let vertices = mesh.triangles()[3];
    let face = Place::Point(SurfacePoint::Face { vertices, bary: [0.2, 0.3, 0.5] });
    let prescribed = [at(11, 1.0), Singularity { place: face, index: 1.0 }];
    let options = FieldOptions::default().with_degree(1);
    let fault = solver.trivial_connection(&prescribed, &options).map(drop).unwrap_err();
    assert!(matches!(fault, PolarFieldError::NotAtVertex { .. }), "{fault}");
}

#[test]
fn energies_compare_as_in_the_specification() {
    // A sphere of about 1400 faces, N = 1, vertex indices 3 and -1, energies split 10 / printed 50
    // / printed 1: smoothest 0.488 / 56.1 / 0.320, smoothest by the printed energy with a
    // regularizer of 1: 0.650 / 35.7 / 0.457, trivial connection 1.364 / 341 / 0.136, all per face.
    use eikona::polar_field::{Smoothness, SolverOptions};
    let mesh = damage::jitter(&shapes::geodesic_sphere(8).unwrap(), 0.2, 3).unwrap();
    let prescribed = [at(0, 3.0), at(300, -1.0)];
    let options = FieldOptions::default().with_degree(1);
    let printed = SolverOptions::default().with_smoothness(Smoothness::Printed { regularizer: 1.0 });
    let [split, regularized] = [SolverOptions::default(), printed].map(|solver_options| {
        let solver = Solver::new(&mesh, &solver_options).unwrap();
        solver.solve(&prescribed, &options).unwrap().report
    });
    let solver = Solver::new(&mesh, &Default::default()).unwrap();
    let flat = solver.trivial_connection(&prescribed, &options).unwrap().report;
    let faces = mesh.face_count() as f64;
    let energies = [&split, &regularized, &flat].map(|report| {
        let [fifty, one] = report.printed_energy;
        [report.energy / faces, fifty / faces, one / faces]
    });
    println!("{faces} faces: {energies:?}");
    let [s, r, t] = energies;
    assert!(s[0] < r[0] && r[0] < t[0], "gradients and jumps apart");
    assert!(r[1] < s[1] && s[1] < t[1], "as printed");
    assert!(t[2] < s[2] && s[2] < r[2], "as printed, with a factor of 1");
    // The figures of the specification are of another mesh and other places. Its regularized field
    // had other targets.
    let known = [(s, [0.488, 56.1, 0.320]), (t, [1.364, 341.0, 0.136])];
    for (found, expected) in known.iter().flat_map(|(found, known)| found.iter().zip(known)) {
        assert!((0.8..1.25).contains(&(found / expected)), "{found} and {expected}");
    }
    assert!(split.residual < 1e-10 && regularized.residual < 1e-10 && flat.residual < 1e-10);
}

#[test]
fn the_printed_energy_needs_a_regularizer() {
    use eikona::polar_field::{Smoothness, SolverOptions};
    let mesh = shapes::icosphere(2).unwrap();
    for regularizer in [0.0, -1.0, f64::NAN] {
        let options = SolverOptions::default().with_smoothness(Smoothness::Printed { regularizer });
        let fault = Solver::new(&mesh, &options).map(drop).unwrap_err();
        assert!(matches!(fault, PolarFieldError::Regularizer { .. }), "{fault}");
    }
}
