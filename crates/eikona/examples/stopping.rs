//! How long solvers take to stop after an observer asks them to, by the phase in which it happens.
//!
//! ```sh
//! cargo run -p eikona --example stopping                # a million faces, 40 stops per method
//! cargo run -p eikona --example stopping -- 100000 10
//! ```

use eikona::contour::plane_cut;
use eikona::mesh::{SurfaceCurves, TriangleMesh, shapes};
use eikona::numeric::observed;
use eikona::{polar_field, signed_heat, winding};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Longest delay and number of stops of one phase.
type Delays = BTreeMap<&'static str, (f64, usize)>;

fn main() {
    let mut arguments = std::env::args().skip(1).map(|word| word.parse().expect("a number is expected"));
    let faces: usize = arguments.next().unwrap_or(1_000_000);
    let stops: usize = arguments.next().unwrap_or(40);
    let side = (faces as f64 / 6.0).sqrt().ceil() as usize;
    let torus = shapes::torus(1.0, 0.4, 3 * side, side).expect("the sizes are valid");
    let cut = plane_cut(&torus, [0.0, 0.0, 0.05], [0.1, 0.2, 1.0]).expect("the plane is valid");
    // Every second piece of the cut is missing. Short gaps keep the linear program short.
    let broken = cut.iter().flat_map(|c| c.nodes.chunks(40).step_by(2)).filter(|n| n.len() > 1);
    let curves = broken.map(|nodes| eikona::mesh::Curve::signed(nodes.iter().copied())).collect();
    let curves = SurfaceCurves { curves, points: Vec::new() };
    println!("{} faces, {} segments", torus.face_count(), curves.segment_count());
    for threads in [1, 2] {
        measure(&format!("signed heat, {threads} threads"), stops, || distance(&torus, &curves, threads));
    }
    measure("winding numbers", stops, || labels(&torus, &curves));
    measure("polar fields", stops, || directions(&torus));
}

/// Returns whether the solve was finished.
fn distance(mesh: &TriangleMesh, curves: &SurfaceCurves, threads: usize) -> bool {
    let options = signed_heat::SolverOptions::default().with_threads(threads);
    let solver = signed_heat::Solver::new(mesh, &options);
    solver.and_then(|solver| solver.solve(curves, &Default::default())).is_ok()
}

fn labels(mesh: &TriangleMesh, curves: &SurfaceCurves) -> bool {
    let solver = winding::Solver::new(mesh, &Default::default());
    solver.and_then(|solver| solver.solve(curves, &Default::default())).is_ok()
}

fn directions(mesh: &TriangleMesh) -> bool {
    let solve = || {
        let solver = polar_field::Solver::new(mesh, &Default::default())?;
        let found = solver.automatic(&Default::default())?;
        let options = polar_field::FieldOptions::default().with_generators(found.generators);
        solver.solve(&found.singularities, &options)
    };
    solve().is_ok()
}

/// Stops the work at evenly spaced times and prints the delays, and the longest silence of each
/// phase: no stop takes longer to be noticed.
fn measure(name: &str, stops: usize, work: impl Fn() -> bool) {
    let start = Instant::now();
    let silences = silences(name, &work);
    let whole = start.elapsed();
    let mut delays = Delays::new();
    for k in 0..stops {
        let after = whole.mul_f64((k as f64 + 0.5) / stops as f64);
        if let Some((phase, delay)) = stopped(after, &work) {
            let (longest, count) = delays.entry(phase).or_default();
            *longest = longest.max(delay.as_secs_f64());
            *count += 1;
        }
    }
    println!("{name}: {:.2} s without a stop", whole.as_secs_f64());
    for (phase, silence) in silences {
        let (longest, count) = delays.get(phase).copied().unwrap_or_default();
        println!(
            "  {phase:<22} longest silence {:>6.1} ms; {count:>3} stops, longest delay {:>6.1} ms",
            1e3 * silence,
            1e3 * longest
        );
    }
}

/// Runs the work and returns the longest time between two calls of the observer, by phase.
fn silences(name: &str, work: impl Fn() -> bool) -> BTreeMap<&'static str, f64> {
    let longest = Arc::new(Mutex::new((BTreeMap::new(), "", Instant::now())));
    let observer = {
        let longest = longest.clone();
        move |phase: &'static str, _: Option<f64>| {
            let (longest, before, last) = &mut *longest.lock().expect("no thread panicked");
            let silence = last.elapsed().as_secs_f64();
            if !before.is_empty() {
                let own = longest.entry(*before).or_insert(0.0);
                *own = silence.max(*own);
            }
            (*before, *last) = (phase, Instant::now());
            ControlFlow::Continue(())
        }
    };
    assert!(observed(observer, work), "{name}: not solved");
    let (longest, ..) = &*longest.lock().expect("no thread panicked");
    longest.clone()
}

/// Returns the last phase and the delay of a stop after this time; `None` if the work was faster.
fn stopped(after: Duration, work: impl Fn() -> bool) -> Option<(&'static str, Duration)> {
    let stop = Arc::new(AtomicBool::new(false));
    let asked = Arc::new(Mutex::new(None));
    let timer = {
        let (stop, asked) = (stop.clone(), asked.clone());
        std::thread::spawn(move || {
            std::thread::sleep(after);
            *asked.lock().expect("no thread panicked") = Some(Instant::now());
            stop.store(true, SeqCst);
        })
    };
    let last = Arc::new(Mutex::new(""));
    let observer = {
        let last = last.clone();
        move |phase: &'static str, _: Option<f64>| {
            *last.lock().expect("no thread panicked") = phase;
            if stop.load(SeqCst) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        }
    };
    let finished = observed(observer, work);
    let end = Instant::now();
    timer.join().expect("no thread panicked");
    let asked = (*asked.lock().expect("no thread panicked"))?;
    let phase = *last.lock().expect("no thread panicked");
    (!finished).then(|| (phase, end.duration_since(asked)))
}
