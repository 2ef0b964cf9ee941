//! Steps until the Willmore energy is within 1 % of its least: of perturbed spheres (16 pi) and
//! tori (8 pi^2, the Clifford torus) at three resolutions, by the Willmore method, and with the
//! Willmore energy as a penalty on the tangent-point energy.
//!
//! ```sh
//! cargo run --release -p eikona --example willmore         # 200 steps at most
//! cargo run --release -p eikona --example willmore -- 50
//! ```

use eikona::mesh::{TriangleMesh, shapes};
use eikona::repulsive::{Flow, FlowOptions, Method, Potential, Remeshing};
use std::f64::consts::PI;
use std::time::Instant;

fn perturbed(mesh: &TriangleMesh) -> TriangleMesh {
    let bump = |p: &[f64; 3]| 0.08 * ((3.0 * p[0]).sin() + (4.0 * p[1] + 1.0).sin() * (3.0 * p[2]).cos());
    let positions = mesh.positions().iter().map(|p| p.map(|x| x * (1.0 + bump(p)))).collect();
    mesh.with_positions(positions).expect("numbers are finite")
}

/// Returns the number of steps, the mean step size, the seconds, and the energy at the end.
fn run(mesh: &TriangleMesh, options: &FlowOptions, goal: f64, most: usize) -> (usize, f64, f64, f64) {
    let energy = |flow: &Flow| Potential::willmore(1.0).value(flow.mesh()).expect("faces have areas");
    let mut flow = Flow::new(mesh, options).expect("the surface is valid");
    let (start, mut steps, mut sizes) = (Instant::now(), 0, 0.0);
    while steps < most && energy(&flow) > goal {
        let Some(step) = flow.step().expect("nothing stops it") else { break };
        steps += 1;
        sizes += step.step_size;
    }
    (steps, sizes / steps.max(1) as f64, start.elapsed().as_secs_f64(), energy(&flow))
}

fn main() {
    let most = std::env::args().nth(1).map_or(200, |word| word.parse().expect("a number is expected"));
    println!("| surface | method | faces | steps | mean step | seconds | Willmore energy / least |");
    println!("|---|---|---|---|---|---|---|");
    for levels in 3..=5 {
        let sphere = perturbed(&shapes::icosphere(levels).expect("the size is valid"));
        let (nu, nv) = (6 << levels, 2 << levels);
        let torus = perturbed(&shapes::torus(1.0, 0.45, nu, nv).expect("the size is valid"));
        for (what, mesh, least) in [("sphere", sphere, 16.0 * PI), ("torus", torus, 8.0 * PI * PI)] {
            let options = FlowOptions::default().with_threads(2).with_remeshing(Remeshing::Off);
            let penalty = |weight: f64| options.clone().with_potentials(vec![Potential::willmore(weight)]);
            let methods = [
                ("willmore", options.clone().with_method(Method::Willmore)),
                ("hs, weight 10", penalty(10.0)),
                ("hs, weight 1000", penalty(1000.0)),
            ];
            for (method, options) in methods {
                let (steps, size, seconds, energy) = run(&mesh, &options, 1.01 * least, most);
                let faces = mesh.face_count();
                let share = energy / least;
                println!(
                    "| {what} | {method} | {faces} | {steps} | {size:.1e} | {seconds:.1} | {share:.4} |"
                );
            }
        }
    }
}
