//! `eikona bench field`: times polar fields with eight singularities of mixed kinds on a torus,
//! edits of them, and an automatic field.

use crate::bench::peer::{find_module, with_folder, write_doubles, write_mesh};
use crate::bench::{megabytes, output_json, parse_faces, print_json, printed, this_program};
use crate::exit::Failure;
use crate::report::peak_memory_bytes;
use crate::session::{General, Session, print_bytes};
use clap::{Args, ValueEnum};
use eikona::polar_field::{
    AutomaticOptions, FieldOptions, Place, PolarField, PolarFieldError, Singularity, Solver, SolverOptions,
};
use eikona_mesh::{SurfacePoint, TriangleMesh, damage, shapes};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// Arguments of `eikona bench field`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  eikona bench field --faces 5000
  eikona bench field --faces 40000,200000 --peer adobe-lagrange --json > bench.json")]
pub struct FieldBench {
    /// Approximate number of faces, one or several sizes
    #[arg(long, value_name = "N,..", value_delimiter = ',', default_value = "40000,200000", allow_negative_numbers = true, value_parser = parse_faces)]
    pub faces: Vec<usize>,
    /// Also run another program on the same mesh; may be repeated
    #[arg(long, value_enum)]
    pub peer: Vec<Peer>,
    /// Python interpreter that has the other program
    #[arg(long, value_name = "PATH", default_value = "python3")]
    pub python: PathBuf,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// Measure one size in this process and print its numbers as JSON.
    #[arg(long, hide = true)]
    pub in_this_process: bool,
    /// Write the mesh and an automatic cross field into this folder instead of measuring.
    #[arg(long, hide = true)]
    pub export: Option<PathBuf>,
}

/// Programs to compare with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Peer {
    /// The Python package adobe-lagrange: smoothest cross fields, whose singularities cannot be
    /// prescribed
    AdobeLagrange,
    /// The Python package libigl: the singularities that it counts in our automatic field
    Libigl,
}

impl Peer {
    fn package(self) -> &'static str {
        match self {
            Peer::AdobeLagrange => "adobe-lagrange",
            Peer::Libigl => "libigl",
        }
    }

    fn module(self) -> &'static str {
        match self {
            Peer::AdobeLagrange => "lagrange",
            Peer::Libigl => "igl",
        }
    }
}

/// Results for one size. Times in seconds.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Run {
    faces: usize,
    threads: usize,
    /// Phases of the preparation and of the first solve.
    phases: Vec<(String, f64)>,
    construct: f64,
    first: f64,
    /// One singularity moved to another element: at a vertex, inside an edge, inside a face.
    edits: Vec<(String, f64)>,
    /// A first automatic cross field: construct, prescription and solve.
    automatic: f64,
    automatic_singularities: usize,
    /// The trivial connection with the indices of the automatic field.
    trivial: f64,
    residual: f64,
    closure: f64,
    aliased: usize,
    peak_memory_bytes: Option<u64>,
    /// What other programs printed, by package.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    peers: BTreeMap<String, BTreeMap<String, f64>>,
}

/// Runs the command and returns the exit code.
pub fn run(arguments: &FieldBench, general: &General) -> Result<u8, Failure> {
    let threads = general.threads.map_or(1, usize::from);
    if let (Some(&faces), Some(folder)) = (arguments.faces.first(), &arguments.export) {
        return export(faces, folder).map(|()| 0);
    }
    if let (Some(&faces), true) = (arguments.faces.first(), arguments.in_this_process) {
        return printed(&measure(faces, threads)?);
    }
    let mut session = Session::new("bench", general);
    session.check_report()?;
    for peer in &arguments.peer {
        find_module(&arguments.python, peer.module(), peer.package())?;
    }
    let mut runs = Vec::new();
    for &faces in &arguments.faces {
        let mut command = for_one_size(faces)?;
        command.args(["--in-this-process", "--threads", &threads.to_string()]);
        let mut run: Run = session.phase(&format!("{faces} faces"), || output_json(&mut command))?;
        for &peer in &arguments.peer {
            let name = format!("{faces} faces, {}", peer.package());
            let printed =
                session.phase(&name, || with_folder(|folder| run_peer(folder, faces, peer, arguments)))?;
            run.peers.insert(peer.package().into(), printed);
        }
        if !arguments.json {
            print_bytes(table(&run).as_bytes())?;
        }
        runs.push(run);
    }
    print_json("field", &runs, arguments.json, &mut session)?;
    session.finish()
}

/// A command that runs this program for one size.
fn for_one_size(faces: usize) -> Result<Command, Failure> {
    let mut command = this_program()?;
    command.args(["bench", "field", "--faces", &faces.to_string()]);
    Ok(command)
}

fn run_peer(
    folder: &Path,
    faces: usize,
    peer: Peer,
    arguments: &FieldBench,
) -> Result<BTreeMap<String, f64>, Failure> {
    let exported = for_one_size(faces)?.arg("--export").arg(folder).status();
    if !exported.is_ok_and(|s| s.success()) {
        return Err(Failure::Failed(format!("{}: cannot export the mesh to this folder", folder.display())));
    }
    let mut command = Command::new(&arguments.python);
    command.args(["-c", include_str!("peer_field.py")]).arg(folder).arg(peer.package());
    output_json(&mut command)
}

fn export(faces: usize, folder: &Path) -> Result<(), Failure> {
    let mesh = torus(faces)?;
    let (field, _) = automatic(&Solver::new(&mesh, &SolverOptions::default())?)?;
    let first = |&vertices: &[u32; 3]| {
        let centroid = SurfacePoint::Face { vertices, bary: [1.0 / 3.0; 3] };
        field.vectors_at(centroid).map(|v| v[0]).map_err(|e| Failure::Failed(e.to_string()))
    };
    let directions: Vec<[f64; 3]> = mesh.triangles().iter().map(first).collect::<Result<_, _>>()?;
    write_mesh(folder, &mesh)?;
    write_doubles(folder, "D.f64", directions.into_iter().flatten())
}

/// A torus with jittered vertices.
fn torus(faces: usize) -> Result<TriangleMesh, Failure> {
    let side = ((faces as f64 / 6.0).sqrt().ceil() as usize).max(8);
    Ok(damage::jitter(&shapes::torus(1.0, 0.4, 3 * side, side)?, 0.2, 1)?)
}

/// Two vertices, three edges and three faces, with indices 1/2 and -1/2. That number `moved` is
/// moved by some faces.
fn mixed(mesh: &TriangleMesh, moved: Option<usize>) -> Vec<Singularity> {
    let place = |i: usize| {
        let face = (i * mesh.face_count() / 8 + if moved == Some(i) { 5 } else { 0 }) % mesh.face_count();
        let [a, b, c] = mesh.triangles()[face];
        Place::Point(match i {
            0 | 1 => SurfacePoint::Vertex { vertex: a },
            2..=4 => SurfacePoint::Edge { vertices: [a, b], t: 0.4 },
            _ => SurfacePoint::Face { vertices: [a, b, c], bary: [0.5, 0.3, 0.2] },
        })
    };
    let index = |i: usize| if i.is_multiple_of(2) { 0.5 } else { -0.5 };
    (0..8).map(|i| Singularity { place: place(i), index: index(i) }).collect()
}

fn automatic(solver: &Solver) -> Result<(PolarField, Vec<Singularity>), PolarFieldError> {
    let found = solver.automatic(&AutomaticOptions::default())?;
    let options = FieldOptions::default().with_generators(found.generators.clone());
    Ok((solver.solve(&found.singularities, &options)?, found.singularities))
}

fn measure(faces: usize, threads: usize) -> Result<Run, Failure> {
    let mesh = torus(faces)?;
    let options = FieldOptions::default();
    let seconds = |start: Instant| start.elapsed().as_secs_f64();
    let start = Instant::now();
    let solver = Solver::new(&mesh, &SolverOptions::default().with_threads(threads))?;
    let construct = seconds(start);
    let start = Instant::now();
    let mut field = solver.solve(&mixed(&mesh, None), &options)?;
    let first = seconds(start);
    let report = field.report.clone();
    let mut edits = Vec::new();
    for (name, moved) in [("vertex", 0), ("edge", 2), ("face", 5)] {
        let start = Instant::now();
        field = solver.edit(&field, &mixed(&mesh, Some(moved)), &options)?;
        edits.push((name.to_string(), seconds(start)));
    }
    let peak_memory_bytes = peak_memory_bytes();
    let start = Instant::now();
    let fresh = Solver::new(&mesh, &SolverOptions::default().with_threads(threads))?;
    let (_, found) = automatic(&fresh)?;
    let automatic = seconds(start);
    let start = Instant::now();
    fresh.trivial_connection(&found, &options)?;
    let phases = report.preparation.0.iter().chain(&report.phases.0);
    Ok(Run {
        faces: mesh.face_count(),
        threads,
        phases: phases.map(|(name, time)| (name.to_string(), time.as_secs_f64())).collect(),
        construct,
        first,
        edits,
        automatic,
        automatic_singularities: found.len(),
        trivial: seconds(start),
        residual: report.residual,
        closure: report.closure,
        aliased: report.aliased.len(),
        peak_memory_bytes,
        peers: BTreeMap::new(),
    })
}

fn table(run: &Run) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "torus with {} faces, N = 4, 8 singularities of mixed kinds, {} thread(s)",
        run.faces, run.threads
    );
    let total = run.construct + run.first;
    let _ = writeln!(
        text,
        "  whole run  {total:>8.3} s  (construct {:.3}, first solve {:.3})",
        run.construct, run.first
    );
    for (name, seconds) in &run.phases {
        let _ = writeln!(text, "    {name:<22} {seconds:>8.3} s");
    }
    let rotation: f64 =
        run.phases.iter().filter(|(name, _)| name != "powers" && name != "scales").map(|(_, s)| s).sum();
    let _ = writeln!(
        text,
        "  phases of the field only, without powers and scales: {rotation:.3} s (the authors state 0.5 s at 25,000 faces)"
    );
    let edits: Vec<String> = run.edits.iter().map(|(name, s)| format!("{name} {s:.3} s")).collect();
    let _ = writeln!(text, "  one singularity moved: {}", edits.join(", "));
    let _ = writeln!(
        text,
        "  automatic cross field, all in all: {:.3} s, {} singularities; trivial connection {:.3} s",
        run.automatic, run.automatic_singularities, run.trivial
    );
    let _ = writeln!(
        text,
        "  residual {:.0e}, closure {:.0e}, {} aliased; peak memory {}",
        run.residual,
        run.closure,
        run.aliased,
        megabytes(run.peak_memory_bytes)
    );
    for (package, printed) in &run.peers {
        let printed: Vec<String> =
            printed.iter().map(|(name, value)| format!("{name}: {value:.3}")).collect();
        let _ = writeln!(text, "  {package}  {}", printed.join(", "));
    }
    text
}
