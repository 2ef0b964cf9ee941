//! Times fields with eight singularities of mixed kinds on tori:
//!
//! ```sh
//! cargo run --release -p eikona --example field_times            # 5,000 to 200,000 faces
//! cargo run --release -p eikona --example field_times -- 1000000
//! ```

use eikona::mesh::{SurfacePoint, TriangleMesh, damage, shapes};
use eikona::polar_field::{FieldOptions, Place, Singularity, Solver, SolverOptions};
use std::time::Instant;

fn main() {
    let given: Vec<usize> =
        std::env::args().skip(1).map(|word| word.parse().expect("a number is expected")).collect();
    for faces in if given.is_empty() { vec![5_000, 20_000, 40_000, 200_000] } else { given } {
        let side = (faces as f64 / 6.0).sqrt().ceil() as usize;
        let torus = shapes::torus(1.0, 0.4, 3 * side, side).expect("the sizes are valid");
        let torus = damage::jitter(&torus, 0.2, 1).expect("the amount is valid");
        let start = Instant::now();
        let solver = Solver::new(&torus, &SolverOptions::default()).expect("the torus is manifold");
        let prepared = start.elapsed().as_secs_f64();
        let singularities = mixed(&torus, 0);
        let start = Instant::now();
        let options = FieldOptions::default().with_degree(4);
        let field = solver.solve(&singularities, &options).expect("the indices add up to zero");
        let solved = start.elapsed().as_secs_f64();
        let start = Instant::now();
        solver.edit(&field, &mixed(&torus, 1), &options).expect("the indices add up to zero");
        let edited = start.elapsed().as_secs_f64();
        let report = &field.report;
        println!(
            "{} faces: prepared in {prepared:.3} s, solved in {solved:.3} s, one moved {edited:.3} s; residual {:.1e}, \
             closure {:.1e}, {} aliased, {} rounds",
            torus.face_count(),
            report.residual,
            report.closure,
            report.aliased.len(),
            report.scale_rounds
        );
        for (name, time) in report.preparation.0.iter().chain(&report.phases.0) {
            println!("    {name:<16} {:.4} s", time.as_secs_f64());
        }
    }
}

/// Two vertices, three edges and three faces, with indices 1/2 and -1/2; the first is moved by some
/// faces.
fn mixed(mesh: &TriangleMesh, moved: usize) -> Vec<Singularity> {
    let place = |i: usize| {
        let face = (i * mesh.face_count() / 8 + if i == 0 { moved } else { 0 }) % mesh.face_count();
        let [a, b, c] = mesh.triangles()[face];
        match i {
            0 | 1 => SurfacePoint::Vertex { vertex: a },
            2..=4 => SurfacePoint::Edge { vertices: [a, b], t: 0.4 },
            _ => SurfacePoint::Face { vertices: [a, b, c], bary: [0.5, 0.3, 0.2] },
        }
    };
    let index = |i: usize| if i.is_multiple_of(2) { 0.5 } else { -0.5 };
    (0..8).map(|i| Singularity { place: Place::Point(place(i)), index: index(i) }).collect()
}
