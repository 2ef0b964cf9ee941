//! `eikona bench sdf`: time, accuracy and memory on meshes with a known answer, optionally compared
//! with potpourri3d on the same mesh and curve. Each size runs in its own process.

use crate::bench::case::{Case, Shape};
use crate::bench::peer::{find_module, with_folder};
use crate::bench::{megabytes, output_json, parse_faces, print_json, printed, this_program};
use crate::exit::Failure;
use crate::report::peak_memory_bytes;
use crate::session::{General, Session, print_bytes};
use clap::{Args, ValueEnum};
use eikona::signed_heat::{DiffusionTime, LevelSets, SolveOptions, Solver, SolverOptions};
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// Arguments of `eikona bench sdf`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  eikona bench sdf --faces 5000
  eikona bench sdf --faces 20000,100000,500000 --peer potpourri3d --json > bench.json")]
pub struct SdfBench {
    /// Approximate number of faces, one or several sizes
    #[arg(long, value_name = "N,..", value_delimiter = ',', default_value = "20000,100000", allow_negative_numbers = true, value_parser = parse_faces)]
    pub faces: Vec<usize>,
    /// Surface: a sphere with the circle z = 0.3, or a torus with its two circles z = 0
    #[arg(long, value_enum, default_value = "sphere")]
    pub shape: Shape,
    /// Diffusion time, as for sdf
    #[arg(long, value_name = "auto|smooth|COEFF", default_value = "auto", allow_hyphen_values = true, value_parser = crate::number::named::<DiffusionTime>)]
    pub time: DiffusionTime,
    /// Number of later solves, of which the median is reported
    #[arg(long, value_name = "N", default_value = "3", value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub repeats: u16,
    /// Also time another program on the same mesh and curve
    #[arg(long, value_enum)]
    pub peer: Option<Peer>,
    /// Python interpreter that has the other program
    #[arg(long, value_name = "PATH", default_value = "python3")]
    pub python: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// Measure one size in this process and print its numbers as JSON.
    #[arg(long, hide = true)]
    pub in_this_process: bool,
    /// Write the mesh, the curve and the exact distance into this folder instead of measuring.
    #[arg(long, hide = true)]
    pub export: Option<PathBuf>,
}

/// Programs to compare with.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Peer {
    /// The Python package potpourri3d
    Potpourri3d,
}

/// Results for one size.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Run {
    shape: String,
    faces: usize,
    vertices: usize,
    /// One complex unknown per edge plus one real unknown per vertex.
    unknowns: usize,
    source_segments: usize,
    threads: usize,
    /// Seconds per phase of the construction.
    construct_phases: Vec<(String, f64)>,
    construct: f64,
    modes: Vec<Mode>,
    factor_bytes: usize,
    peak_memory_bytes: Option<u64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    potpourri3d: Option<PeerRun>,
}

/// Times of one constraint mode in seconds. `l2_error` is sqrt(sum A (phi - phi0)² / sum A),
/// divided by the range of phi0.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Mode {
    mode: String,
    first: f64,
    later: f64,
    l2_error: f64,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct PeerRun {
    construct: f64,
    modes: Vec<Mode>,
    peak_memory_bytes: Option<u64>,
}

/// Runs the command and returns the exit code.
pub fn run(arguments: &SdfBench, general: &General) -> Result<u8, Failure> {
    if let (Some(&faces), Some(folder)) = (arguments.faces.first(), &arguments.export) {
        return Case::new(arguments.shape, faces)?.export(folder).map(|()| 0);
    }
    if let (Some(&faces), true) = (arguments.faces.first(), arguments.in_this_process) {
        let run = measure(&Case::new(arguments.shape, faces)?, arguments, general)?;
        return printed(&run);
    }
    let mut session = Session::new("bench", general);
    session.check_report()?;
    if arguments.peer.is_some() {
        find_module(&arguments.python, "potpourri3d", "potpourri3d")?;
    }
    let mut runs = Vec::new();
    for &faces in &arguments.faces {
        let name = format!("{faces} faces");
        let mut run = session.phase(&name, || measure_apart(faces, arguments, general))?;
        if arguments.peer.is_some() {
            let name = format!("{faces} faces, potpourri3d");
            run.potpourri3d = Some(
                session.phase(&name, || with_folder(|folder| run_peer(folder, faces, &run, arguments)))?,
            );
        }
        if !arguments.json {
            print_bytes(table(&run).as_bytes())?;
        }
        runs.push(run);
    }
    print_json("sdf", &runs, arguments.json, &mut session)?;
    session.finish()
}

fn measure(case: &Case, arguments: &SdfBench, general: &General) -> Result<Run, Failure> {
    let threads = general.threads.map_or(1, usize::from);
    let start = Instant::now();
    let options = SolverOptions::default().with_time(arguments.time).with_threads(threads);
    let solver = Solver::new(&case.mesh, &options)?;
    let construct = start.elapsed().as_secs_f64();
    let modes = [
        ("auto", LevelSets::Automatic),
        ("free", LevelSets::Free),
        ("zero", LevelSets::Zero),
        ("per-component", LevelSets::PerComponent),
        ("soft", LevelSets::Soft(100.0)),
    ];
    let mut measured = Vec::new();
    let mut preparation = None;
    let mut source_segments = 0;
    for (name, level_sets) in modes {
        let options = SolveOptions::default().with_level_sets(level_sets);
        let mut seconds = Vec::new();
        let mut l2_error = f64::NAN;
        for _ in 0..=arguments.repeats {
            let start = Instant::now();
            let solution = solver.solve(&case.source, &options)?;
            seconds.push(start.elapsed().as_secs_f64());
            l2_error = case.l2_error(solution.distance.as_slice());
            source_segments = solution.report.source_segments;
            preparation.get_or_insert(solution.report.preparation);
        }
        let first = seconds.remove(0);
        seconds.sort_by(f64::total_cmp);
        measured.push(Mode { mode: name.into(), first, later: seconds[seconds.len() / 2], l2_error });
    }
    let preparation = preparation.unwrap_or_default();
    let phases = preparation.phases.0.iter().map(|(n, d)| (n.to_string(), d.as_secs_f64())).collect();
    Ok(Run {
        shape: arguments.shape.name().into(),
        faces: case.mesh.face_count(),
        vertices: case.mesh.vertex_count(),
        unknowns: case.mesh.edge_count() + case.mesh.vertex_count(),
        source_segments,
        threads,
        construct_phases: phases,
        construct,
        modes: measured,
        factor_bytes: preparation.factor_bytes,
        peak_memory_bytes: peak_memory_bytes(),
        potpourri3d: None,
    })
}

/// A command that runs this program for one size.
fn for_one_size(faces: usize, arguments: &SdfBench) -> Result<Command, Failure> {
    let time = arguments.time.to_string();
    let mut command = this_program()?;
    command.args(["bench", "sdf", "--faces", &faces.to_string(), "--shape", arguments.shape.name()]);
    command.args(["--time", &time, "--repeats", &arguments.repeats.to_string()]);
    Ok(command)
}

fn measure_apart(faces: usize, arguments: &SdfBench, general: &General) -> Result<Run, Failure> {
    let mut command = for_one_size(faces, arguments)?;
    command.arg("--in-this-process");
    command.args(["--threads", &general.threads.unwrap_or(1).to_string()]);
    output_json(&mut command)
}

fn run_peer(folder: &Path, faces: usize, ours: &Run, arguments: &SdfBench) -> Result<PeerRun, Failure> {
    let exported = for_one_size(faces, arguments)?.arg("--export").arg(folder).status();
    if !exported.is_ok_and(|s| s.success()) {
        return Err(Failure::Failed(format!(
            "{}: cannot export the mesh of {} faces to this folder",
            folder.display(),
            ours.faces
        )));
    }
    // The other program has no automatic time; its default is the paper's.
    let time = match arguments.time {
        DiffusionTime::Coefficient(c) => c,
        _ => 1.0,
    };
    let mut command = Command::new(&arguments.python);
    command.args(["-c", include_str!("peer_potpourri3d.py")]).arg(folder);
    command.args([time.to_string(), arguments.repeats.to_string()]);
    output_json(&mut command)
}

fn table(run: &Run) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{} with {} faces, {} vertices, {} unknowns, source of {} segments, {} thread(s)",
        run.shape, run.faces, run.vertices, run.unknowns, run.source_segments, run.threads
    );
    let phases: Vec<String> = run.construct_phases.iter().map(|(name, s)| format!("{name} {s:.3}")).collect();
    let _ = writeln!(text, "  construct      {:>8.3} s  ({})", run.construct, phases.join(", "));
    for mode in &run.modes {
        let _ = writeln!(
            text,
            "  {:<14} {:>8.3} s first, {:>7.3} s later, L2 error {:.2e}",
            mode.mode, mode.first, mode.later, mode.l2_error
        );
    }
    let factors = megabytes(Some(run.factor_bytes as u64));
    let _ = writeln!(text, "  memory         peak {}, factors {factors}", megabytes(run.peak_memory_bytes));
    let Some(peer) = &run.potpourri3d else { return text };
    let _ = writeln!(
        text,
        "  potpourri3d    {:>8.3} s construct, peak {}",
        peer.construct,
        megabytes(peer.peak_memory_bytes)
    );
    for theirs in &peer.modes {
        let Some(ours) = run.modes.iter().find(|m| m.mode == theirs.mode) else { continue };
        let (answer, their_answer) = (run.construct + ours.first, peer.construct + theirs.first);
        let _ = writeln!(
            text,
            "    {:<12} {:>8.3} s first, {:>7.3} s later, L2 error {:.2e}: construct + first {:.1}x, later \
             {:.1}x as long as ours",
            theirs.mode,
            theirs.first,
            theirs.later,
            theirs.l2_error,
            their_answer / answer,
            theirs.later / ours.later
        );
    }
    text
}
