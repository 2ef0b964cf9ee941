//! Signed distance to a broken circle on a sphere, step by step: `cargo run -p eikona --example
//! signed_distance`.

use eikona::contour::plane_cut;
use eikona::mesh::{Curve, SurfaceCurves, shapes};
use eikona::signed_heat::{DiffusionTime, SolveOptions, Solver, SolverOptions};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let sphere = shapes::geodesic_sphere(40)?;
    // The circle z = 0.3, with the south on its left; every other tenth of it is kept.
    let circle = plane_cut(&sphere, [0.0, 0.0, 0.3], [0.0, 0.0, 1.0])?.remove(0);
    let tenth = circle.nodes.len() / 10;
    let pieces = circle.nodes.chunks(tenth).step_by(2).filter(|piece| piece.len() > 1);
    let broken = SurfaceCurves {
        curves: pieces.map(|piece| Curve::signed(piece.iter().copied())).collect(),
        points: Vec::new(),
    };

    let time = DiffusionTime::Automatic.for_source(&sphere, &broken);
    let solver = Solver::new(&sphere, &SolverOptions::default().with_time(time))?;
    let solution = solver.solve(&broken, &SolveOptions::default().with_confidence(true))?;

    let exact = |z: f64| z.clamp(-1.0, 1.0).asin() - 0.3f64.asin();
    let worst = sphere
        .vertices()
        .map(|v| (solution.distance[v] - exact(sphere.position(v)[2])).abs())
        .fold(0.0, f64::max);
    println!("{} pieces, largest error {worst:.4}, t: {}", broken.curves.len(), solution.report.time.reason);
    for (phase, duration) in &solution.report.phases.0 {
        println!("  {phase:12} {:7.2} ms", duration.as_secs_f64() * 1e3);
    }
    Ok(())
}
