//! `eikona bench repulse`: times energies, the inner product and steps of the flow on two linked
//! rings.

use crate::bench::{megabytes, output_json, parse_faces, print_json, printed, this_program};
use crate::exit::Failure;
use crate::report::peak_memory_bytes;
use crate::session::{General, Session, print_bytes};
use clap::Args;
use eikona::numeric::observed;
use eikona::repulsive::{
    EnergyOptions, Flow, FlowOptions, Metric, MetricOptions, Pairs, Quantity, tangent_point_energy,
};
use eikona::spatial::{self_distance, self_intersections};
use eikona_mesh::{TriangleMesh, shapes};
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Arguments of `eikona bench repulse`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  eikona bench repulse --faces 5000
  eikona bench repulse --faces 5000,20000,80000,320000 --json > bench.json")]
pub struct RepulseBench {
    /// Approximate number of faces, one or several sizes
    #[arg(long, value_name = "N,..", value_delimiter = ',', default_value = "5000,20000,80000", allow_negative_numbers = true, value_parser = parse_faces)]
    pub faces: Vec<usize>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// Measure one size in this process and print its numbers as JSON.
    #[arg(long, hide = true)]
    pub in_this_process: bool,
}

/// Results for one size. Times in seconds.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Run {
    faces: usize,
    threads: usize,
    energies: Vec<Energy>,
    /// Kernel matrices and factor of the inner product.
    metric: f64,
    product: f64,
    /// Solve for the gradient of the energy, to 1 %.
    solve: f64,
    iterations: usize,
    /// Steps that keep area and volume, without collision detection and with it.
    steps: Vec<Step>,
    self_distance: f64,
    self_intersections: f64,
    peak_memory_bytes: Option<u64>,
}

/// The energy and its differential.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Energy {
    separation: f64,
    seconds: f64,
    /// Share by which the energy and the norm of the differential differ from the sums over all
    /// pairs; only for small meshes.
    off: Option<[f64; 2]>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct Step {
    collisions: bool,
    seconds: f64,
    phases: Vec<(String, f64)>,
    iterations: usize,
    backtracks: usize,
    energy: f64,
}

/// Most faces whose pairs are all summed.
const ALL_PAIRS: usize = 25_000;

/// Runs the command and returns the exit code.
pub fn run(arguments: &RepulseBench, general: &General) -> Result<u8, Failure> {
    let threads = general.threads.map_or(1, usize::from);
    if let (Some(&faces), true) = (arguments.faces.first(), arguments.in_this_process) {
        return printed(&measure(faces, threads)?);
    }
    let mut session = Session::new("bench", general);
    session.check_report()?;
    let mut runs = Vec::new();
    for &faces in &arguments.faces {
        let mut command = this_program()?;
        command.args(["bench", "repulse", "--faces", &faces.to_string()]);
        command.args(["--in-this-process", "--threads", &threads.to_string()]);
        let run: Run = session.phase(&format!("{faces} faces"), || output_json(&mut command))?;
        if !arguments.json {
            print_bytes(table(&run).as_bytes())?;
        }
        runs.push(run);
    }
    print_json("repulse", &runs, arguments.json, &mut session)?;
    session.finish()
}

/// Two rings, each through the hole of the other.
fn linked_rings(faces: usize) -> Result<TriangleMesh, Failure> {
    let around = ((faces as f64 / 10.0).sqrt().round() as usize).max(6);
    Ok(shapes::linked_rings(2, 0.3, 5 * around / 2, around)?)
}

fn measure(faces: usize, threads: usize) -> Result<Run, Failure> {
    let mesh = linked_rings(faces)?;
    let seconds = |start: Instant| start.elapsed().as_secs_f64();
    let options = EnergyOptions::default().with_threads(threads);
    let mut exact = None;
    if mesh.face_count() <= ALL_PAIRS {
        exact = Some(tangent_point_energy(&mesh, &options.with_pairs(Pairs::All))?);
    }
    let mut energies = Vec::new();
    let mut gradient = None;
    for separation in [0.5, options.separation] {
        let start = Instant::now();
        let energy = tangent_point_energy(&mesh, &options.with_separation(separation))?;
        let seconds = seconds(start);
        let off = exact.as_ref().map(|exact| {
            [energy.value / exact.value - 1.0, energy.gradient_norm() / exact.gradient_norm() - 1.0]
        });
        energies.push(Energy { separation, seconds, off });
        gradient = Some(energy.differential);
    }
    let start = Instant::now();
    let metric = Metric::new(&mesh, &MetricOptions::default().with_threads(threads))?;
    let built = seconds(start);
    let forces: Vec<_> = gradient.into_iter().collect();
    let start = Instant::now();
    metric.product(&forces[0])?;
    let product = seconds(start);
    let start = Instant::now();
    let solution = metric.solve(&forces)?;
    let solve = seconds(start);
    drop(metric);
    let mut steps = Vec::new();
    let mut last = mesh.clone();
    for collisions in [false, true] {
        let keep = vec![Quantity::Area, Quantity::Volume];
        let options =
            FlowOptions::default().with_keep(keep).with_threads(threads).with_collisions(collisions);
        let mut flow = Flow::new(&mesh, &options)?;
        // The second step: the first one also analyses the pattern of the factor.
        flow.step()?;
        let start = Instant::now();
        let (done, phases) = timed(|| flow.step());
        let seconds = seconds(start);
        if let Some(done) = done? {
            let (iterations, backtracks) = (done.solver_iterations, done.backtracks);
            steps.push(Step { collisions, seconds, phases, iterations, backtracks, energy: done.energy });
        }
        last = flow.mesh().clone();
    }
    let failed = |fault: eikona::numeric::NumericError| Failure::Failed(fault.to_string());
    let start = Instant::now();
    self_distance(&last, threads).map_err(failed)?;
    let distance = seconds(start);
    let start = Instant::now();
    self_intersections(&last, threads).map_err(failed)?;
    Ok(Run {
        faces: mesh.face_count(),
        threads,
        energies,
        metric: built,
        product,
        solve,
        iterations: solution.iterations,
        steps,
        self_distance: distance,
        self_intersections: seconds(start),
        peak_memory_bytes: peak_memory_bytes(),
    })
}

/// Runs some work and returns how long each phase took that it announced, with the result.
fn timed<R>(work: impl FnOnce() -> R) -> (R, Vec<(String, f64)>) {
    let phases: Arc<Mutex<Vec<(&'static str, Instant)>>> = Arc::default();
    let seen = phases.clone();
    let observer = move |phase: &'static str, _: Option<f64>| {
        let mut seen = seen.lock().unwrap_or_else(PoisonError::into_inner);
        if seen.last().is_none_or(|(last, _)| *last != phase) {
            seen.push((phase, Instant::now()));
        }
        ControlFlow::Continue(())
    };
    let result = observed(observer, work);
    let end = Instant::now();
    let phases = phases.lock().unwrap_or_else(PoisonError::into_inner);
    let ends = phases.iter().skip(1).map(|(_, start)| *start).chain([end]);
    let times = phases.iter().zip(ends).filter(|((name, _), _)| !name.is_empty());
    let times =
        times.map(|((name, start), end)| (name.to_string(), end.duration_since(*start).as_secs_f64()));
    (result, times.collect())
}

fn table(run: &Run) -> String {
    let mut text = String::new();
    let _ = writeln!(text, "linked rings with {} faces, p = 6, {} thread(s)", run.faces, run.threads);
    for energy in &run.energies {
        let off = energy.off.map_or(String::new(), |[value, norm]| {
            format!(" ({:+.3} % off all pairs, its norm {:+.3} %)", 100.0 * value, 100.0 * norm)
        });
        let _ = writeln!(
            text,
            "  energy and differential, separation {:.1} {:>8.3} s{off}",
            energy.separation, energy.seconds
        );
    }
    let _ = writeln!(
        text,
        "  inner product  {:>8.3} s, product {:.4} s, solve {:.3} s in {} iterations",
        run.metric, run.product, run.solve, run.iterations
    );
    for step in &run.steps {
        let _ = writeln!(
            text,
            "  step {} collision detection {:>8.3} s, {} iterations, {} backtracks",
            if step.collisions { "with" } else { "without" },
            step.seconds,
            step.iterations,
            step.backtracks
        );
        for (name, seconds) in &step.phases {
            let _ = writeln!(text, "    {name:<22} {seconds:>8.3} s");
        }
    }
    let _ = writeln!(
        text,
        "  self-distance {:.3} s, self-intersections {:.3} s",
        run.self_distance, run.self_intersections
    );
    let per_face = run.peak_memory_bytes.map_or(0.0, |bytes| bytes as f64 / run.faces as f64 / 1e3);
    let _ = writeln!(text, "  peak memory {}, {per_face:.1} kB per face", megabytes(run.peak_memory_bytes));
    text
}
