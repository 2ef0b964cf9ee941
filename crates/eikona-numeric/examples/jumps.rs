//! Times `minimise_jumps` on graphs dual to triangulated tori: `cargo run --example jumps
//! [--simplex | --levels] [name ...]`. Its documentation quotes these times.

#[path = "../tests/jump_instances/mod.rs"]
#[allow(dead_code)]
mod jump_instances;

use eikona_numeric::{JumpMethod, JumpOptions, minimise_jumps};
use jump_instances::*;
use std::time::Instant;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let given = |name: &str| arguments.iter().any(|a| a == name);
    let method = match (given("--simplex"), given("--levels")) {
        (true, _) => Some(JumpMethod::NetworkSimplex),
        (_, true) => Some(JumpMethod::PrimalDual),
        _ => None,
    };
    let names: Vec<&String> = arguments.iter().filter(|a| !a.starts_with("--")).collect();
    let half = Curves { periods: [0.4127, 0.9033], ..BROKEN };
    let instances: Vec<(&str, Box<dyn Fn() -> Instance>)> = vec![
        ("closed-5k", Box::new(|| torus(80, 32, CLOSED, 1))),
        ("broken-5k", Box::new(|| torus(80, 32, BROKEN, 1))),
        ("noisy-5k", Box::new(|| noisy(torus(80, 32, CLOSED, 1), 2))),
        ("closed-50k", Box::new(|| torus(250, 100, CLOSED, 1))),
        ("broken-50k", Box::new(|| torus(250, 100, BROKEN, 1))),
        ("noisy-50k", Box::new(|| noisy(torus(250, 100, CLOSED, 1), 2))),
        ("closed-200k", Box::new(|| torus(500, 200, CLOSED, 1))),
        ("broken-200k", Box::new(|| torus(500, 200, BROKEN, 1))),
        ("noisy-200k", Box::new(|| noisy(torus(500, 200, CLOSED, 1), 2))),
        ("stepped-4-50k", Box::new(|| stepped(torus(250, 100, CLOSED, 1), 4.0, 2))),
        ("stepped-16-50k", Box::new(|| stepped(torus(250, 100, CLOSED, 1), 16.0, 2))),
        ("stepped-64-50k", Box::new(|| stepped(torus(250, 100, CLOSED, 1), 64.0, 2))),
        ("stepped-256-50k", Box::new(|| stepped(torus(250, 100, CLOSED, 1), 256.0, 2))),
        ("closed-500k", Box::new(|| torus(800, 313, CLOSED, 1))),
        ("broken-500k", Box::new(|| torus(800, 313, BROKEN, 1))),
        ("broken-500k-shuffled", Box::new(|| shuffled(&torus(800, 313, BROKEN, 1), 3))),
        ("genus2-closed-35k", Box::new(|| double_torus(146, 60, [CLOSED; 2], 1))),
        ("genus2-broken-35k", Box::new(move || double_torus(146, 60, [BROKEN, half], 1))),
    ];
    println!(
        "{:22} {:>8} {:>8}  method  pivots levels      work seconds     gap  objective",
        "", "nodes", "terms"
    );
    for (name, make) in &instances {
        if !names.is_empty() && !names.iter().any(|n| name.contains(n.as_str())) {
            continue;
        }
        let (nodes, terms) = make();
        let start = Instant::now();
        let options = JumpOptions { method, ..JumpOptions::default() };
        match minimise_jumps(nodes, &terms, &options) {
            Ok(solution) => {
                let s = solution.statistics;
                println!(
                    "{name:22} {nodes:8} {:8} {:>7} {:7} {:6} {:9.2e} {:7.2} {:7.0e}  {:.10}",
                    terms.len(),
                    if s.method == JumpMethod::NetworkSimplex { "simplex" } else { "levels" },
                    s.pivots,
                    s.levels,
                    s.work as f64,
                    start.elapsed().as_secs_f64(),
                    solution.certificate.gap,
                    solution.objective
                );
            }
            Err(error) => println!("{name:22} {error}"),
        }
    }
}
