//! `eikona bench winding`: times winding numbers of closed or broken loops, one bounding and the
//! others nonbounding, on a torus and a double torus.

use crate::bench::{megabytes, output_json, parse_faces, print_json, printed, this_program};
use crate::exit::Failure;
use crate::report::peak_memory_bytes;
use crate::session::{General, Session, print_bytes};
use clap::{Args, ValueEnum};
use eikona::contour::plane_cut;
use eikona::winding::{Solver, SolverOptions, Winding, WindingOptions};
use eikona_mesh::{Curve, Face, SurfaceCurves, TriangleMesh, Vertex, damage, shapes};
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use std::time::Instant;

/// Arguments of `eikona bench winding`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  eikona bench winding --faces 50000,200000
  eikona bench winding --shape double-torus --faces 35000 --curve broken --json > bench.json")]
pub struct WindingBench {
    /// Approximate number of faces, one or several sizes
    #[arg(long, value_name = "N,..", value_delimiter = ',', default_value = "20000,100000", allow_negative_numbers = true, value_parser = parse_faces)]
    pub faces: Vec<usize>,
    /// Surface: a torus with curves along edges, or a double torus with curves across faces
    #[arg(long, value_enum, default_value = "torus")]
    pub shape: Surface,
    /// Closed loops, loops with a quarter of each missing, or both in turn
    #[arg(long, value_enum, default_value = "both")]
    pub curve: State,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// Measure one size in this process and print its numbers as JSON.
    #[arg(long, hide = true)]
    pub in_this_process: bool,
}

/// Benchmark surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Surface {
    /// The torus with radii 1 and 0.4 and jittered vertices; a loop around the tube, one around the
    /// hole, and the boundary of a disk
    Torus,
    /// A surface of genus 2; loops around two tubes, one around a hole, and the boundary of a disk
    DoubleTorus,
}

/// State of the curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum State {
    /// Closed loops
    Closed,
    /// Loops with a quarter missing, in three gaps
    Broken,
    /// Both
    Both,
}

/// Results for one size. Times in seconds.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Run {
    shape: String,
    curve: String,
    faces: usize,
    threads: usize,
    segments: usize,
    endpoints: usize,
    construct: f64,
    /// Phases of the first solve.
    phases: Vec<(String, f64)>,
    first: f64,
    /// Second solve of the same curve, which reuses what the solver caches.
    later: f64,
    /// Objective of the linear program.
    objective: Option<f64>,
    gap: Option<f64>,
    /// Share of faces with the same label at their centroid as for the closed loops.
    right: f64,
    peak_memory_bytes: Option<u64>,
}

fn name(value: impl ValueEnum) -> String {
    value.to_possible_value().map_or(String::new(), |v| v.get_name().to_string())
}

/// Runs the command and returns the exit code.
pub fn run(arguments: &WindingBench, general: &General) -> Result<u8, Failure> {
    let threads = general.threads.map_or(1, usize::from);
    if arguments.in_this_process {
        return match (arguments.faces.as_slice(), arguments.curve) {
            (&[faces], state @ (State::Closed | State::Broken)) => {
                printed(&measure(arguments.shape, state, faces, threads)?)
            }
            _ => Err(Failure::Usage(
                "--in-this-process measures one size and one state; give --faces N and --curve closed or \
                 --curve broken"
                    .into(),
            )),
        };
    }
    let mut session = Session::new("bench", general);
    session.check_report()?;
    let states = match arguments.curve {
        State::Both => vec![State::Closed, State::Broken],
        one => vec![one],
    };
    let mut runs = Vec::new();
    for &faces in &arguments.faces {
        for &state in &states {
            let mut command = this_program()?;
            command.args(["bench", "winding", "--in-this-process", "--faces", &faces.to_string()]);
            command.args(["--shape", &name(arguments.shape), "--curve", &name(state)]);
            command.args(["--threads", &threads.to_string()]);
            let title = format!("{faces} faces, {}", name(state));
            let run: Run = session.phase(&title, || output_json(&mut command))?;
            if !arguments.json {
                print_bytes(table(&run).as_bytes())?;
            }
            runs.push(run);
        }
    }
    print_json("winding", &runs, arguments.json, &mut session)?;
    session.finish()
}

fn measure(shape: Surface, state: State, faces: usize, threads: usize) -> Result<Run, Failure> {
    let (mesh, loops) = match shape {
        Surface::Torus => torus(faces)?,
        Surface::DoubleTorus => double_torus(faces)?,
    };
    let curves = match state {
        State::Broken => broken(&loops),
        State::Closed | State::Both => loops.clone(),
    };
    let curves = SurfaceCurves { curves, points: Vec::new() };
    let options = WindingOptions::default();
    let start = Instant::now();
    let solver = Solver::new(&mesh, &SolverOptions::default().with_threads(threads))?;
    let construct = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let winding = solver.solve(&curves, &options)?;
    let first = start.elapsed().as_secs_f64();
    let start = Instant::now();
    solver.solve(&curves, &options)?;
    let later = start.elapsed().as_secs_f64();
    let peak_memory_bytes = peak_memory_bytes();
    let whole = solver.solve(&SurfaceCurves { curves: loops, points: Vec::new() }, &options)?;
    let program = winding.report.program.as_ref();
    Ok(Run {
        shape: name(shape),
        curve: name(state),
        faces: mesh.face_count(),
        threads,
        segments: curves.segment_count(),
        endpoints: winding.endpoints.len(),
        construct,
        phases: winding.report.phases.0.iter().map(|(n, d)| (n.to_string(), d.as_secs_f64())).collect(),
        first,
        later,
        objective: program.map(|p| p.objective),
        gap: program.map(|p| p.certificate.gap),
        right: agreement(&mesh, &winding, &whole),
        peak_memory_bytes,
    })
}

/// Share of faces with the same label at their centroid in both.
fn agreement(mesh: &TriangleMesh, one: &Winding, other: &Winding) -> f64 {
    let middle = |w: &Winding, f: Face| w.label_at(f, [1.0 / 3.0; 3]);
    let same = mesh.faces().filter(|&f| middle(one, f) == middle(other, f)).count();
    same as f64 / mesh.face_count() as f64
}

fn torus(faces: usize) -> Result<(TriangleMesh, Vec<Curve>), Failure> {
    // 2 nu nv faces of about equal shape.
    let nv = (faces as f64 / 2.0 / 2.5).sqrt().round().max(8.0) as usize;
    let nu = (faces / 2 / nv).max(8);
    let mesh = damage::jitter(&shapes::torus(1.0, 0.4, nu, nv)?, 0.15, 1)?;
    let vertex = |i: usize, j: usize| Vertex(((i % nu) * nv + j % nv) as u32);
    let around_tube = Curve::signed((0..=nv).map(|j| vertex(nu / 8, j)));
    let around_hole = Curve::signed((0..=nu).map(|i| vertex(i, 3 * nv / 4)));
    // A rectangle of the grid, away from both.
    let (i0, i1, j0, j1) = (nu / 2, 3 * nu / 4, nv / 8, 5 * nv / 8);
    let there = (i0..i1).map(|i| vertex(i, j0)).chain((j0..j1).map(|j| vertex(i1, j)));
    let back = (i0 + 1..=i1).rev().map(|i| vertex(i, j1)).chain((j0..=j1).rev().map(|j| vertex(i0, j)));
    Ok((mesh, vec![around_tube, around_hole, Curve::signed(there.chain(back))]))
}

fn double_torus(faces: usize) -> Result<(TriangleMesh, Vec<Curve>), Failure> {
    // 33 792 faces at four levels; each level has four times as many as the one before.
    let levels = (faces as f64 / 132.0).log(4.0).round().clamp(1.0, 8.0);
    let mesh = shapes::chain_of_genus(2, levels as u32)?;
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in mesh.positions() {
        for k in 0..3 {
            (low[k], high[k]) = (low[k].min(p[k]), high[k].max(p[k]));
        }
    }
    let along = |k: usize, share: f64| {
        let mut point = [0.0; 3];
        point[k] = low[k] + share * (high[k] - low[k]);
        point
    };
    let cut = |k: usize, share: f64| {
        let mut normal = [0.0; 3];
        normal[k] = 1.0;
        plane_cut(&mesh, along(k, share), normal)
    };
    // Each cut through an opening goes around two tubes; take one of them.
    let mut loops: Vec<Curve> = [0.271, 0.738]
        .iter()
        .map(|&x| cut(0, x))
        .map(|c| c.map(|mut c| c.swap_remove(0)))
        .collect::<Result<_, _>>()?;
    // A cut through the middle goes around each opening and around the whole; take one opening.
    let mut flat = cut(2, 0.507)?;
    flat.sort_by_key(|c| c.nodes.len());
    loops.extend(flat.into_iter().take(1));
    // A cap at the end.
    loops.extend(cut(0, 0.071)?.into_iter().take(1));
    Ok((mesh, loops))
}

/// Removes a quarter of each loop, in three gaps.
fn broken(loops: &[Curve]) -> Vec<Curve> {
    let mut pieces = Vec::new();
    for whole in loops {
        let n = whole.nodes.len() - 1;
        for k in 0..3 {
            let (from, to) = (k * n / 3, k * n / 3 + n / 4);
            pieces.push(Curve::signed(whole.nodes[from..=to].iter().copied()));
        }
    }
    pieces
}

fn table(run: &Run) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{} with {} faces, {} loops with {} segments in total, {} endpoints, {} thread(s)",
        run.shape, run.faces, run.curve, run.segments, run.endpoints, run.threads
    );
    let _ = writeln!(
        text,
        "  whole run  {:>8.3} s  (construct {:.3}, first solve {:.3}), later {:.3} s",
        run.construct + run.first,
        run.construct,
        run.first,
        run.later
    );
    for (name, seconds) in &run.phases {
        let _ = writeln!(text, "    {name:<22} {seconds:>8.3} s");
    }
    let program = run.objective.zip(run.gap);
    let program = program.map_or(String::new(), |(o, g)| format!("objective {o:.9}, gap {g:.0e}; "));
    let _ = writeln!(
        text,
        "  {program}{:.2} % of the faces labelled as for the closed loops; peak memory {}",
        100.0 * run.right,
        megabytes(run.peak_memory_bytes)
    );
    text
}
