//! The descent methods on one surface of genus 2 at three resolutions (RS figure 5): energies after
//! 10, 30 and 100 steps, seconds, and the mean step size. The finer the mesh, the less a step in L2
//! or H1 achieves.
//!
//! ```sh
//! cargo run --release -p eikona --example descent_methods             # 30 steps, 60 s per run
//! cargo run --release -p eikona --example descent_methods -- 100 30   # steps, seconds per run
//! cargo run --release -p eikona --example descent_methods -- 30 15 off  # without remeshing
//! cargo run --release -p eikona --example descent_methods -- 10 30 on trefoil  # a knotted tube
//! ```

use eikona::mesh::{TriangleMesh, shapes};
use eikona::repulsive::{Flow, FlowOptions, Method, Remeshing};
use std::time::Instant;

const MILESTONES: [usize; 3] = [10, 30, 100];

/// What a run did.
struct Run {
    steps: usize,
    first: f64,
    /// Energies after [`MILESTONES`] steps, as far as it came.
    energies: [Option<f64>; 3],
    seconds: f64,
    /// The mean length of steps, in units of the direction.
    step_size: f64,
}

fn run(mesh: &TriangleMesh, options: &FlowOptions, steps: usize, seconds: f64) -> Run {
    let mut flow = Flow::new(mesh, options).expect("the surface is valid");
    let first = flow.energy();
    let (start, mut done, mut sizes, mut energies) = (Instant::now(), 0, 0.0, [None; 3]);
    while done < steps && start.elapsed().as_secs_f64() < seconds {
        let Some(step) = flow.step().expect("nothing stops it") else { break };
        done += 1;
        sizes += step.step_size;
        if let Some(k) = MILESTONES.iter().position(|milestone| *milestone == done) {
            energies[k] = Some(step.energy);
        }
    }
    let step_size = sizes / done.max(1) as f64;
    Run { steps: done, first, energies, seconds: start.elapsed().as_secs_f64(), step_size }
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let steps: usize = arguments.next().map_or(30, |word| word.parse().expect("a number is expected"));
    let seconds: f64 = arguments.next().map_or(60.0, |word| word.parse().expect("a number is expected"));
    let remeshing = match arguments.next().as_deref() {
        Some("off") => Remeshing::Off,
        _ => Remeshing::Uniform { length: None },
    };
    let knotted = arguments.next().as_deref() == Some("trefoil");
    let surface = |levels: u32| match knotted {
        // Faces are about equilateral.
        true => shapes::trefoil_tube(0.4, 28 << levels, (9 << levels) / 4),
        false => shapes::chain_of_genus(2, levels),
    };
    println!("| method | faces | steps | start | 10 | 30 | 100 | s per step | mean step |");
    println!("|---|---|---|---|---|---|---|---|---|");
    for method in Method::ALL {
        for levels in 2..=4 {
            let mesh = surface(levels).expect("the size is valid");
            let options =
                FlowOptions::default().with_method(method).with_remeshing(remeshing).with_threads(2);
            let run = run(&mesh, &options, steps, seconds);
            let energies = run.energies.map(|x| x.map_or("".to_string(), |x| format!("{x:.1}")));
            println!(
                "| {method} | {} | {} | {:.1} | {} | {:.3} | {:.1e} |",
                mesh.face_count(),
                run.steps,
                run.first,
                energies.join(" | "),
                run.seconds / run.steps.max(1) as f64,
                run.step_size
            );
        }
    }
}
