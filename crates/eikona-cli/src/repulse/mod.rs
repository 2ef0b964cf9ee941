//! `eikona repulse`: moves a surface so that it never touches itself.

mod folder;

use crate::exit::Failure;
use crate::input::{MeshArguments, MeshInput};
use crate::picture::{PictureArguments, draw};
use crate::session::{General, Session};
use clap::Args;
use eikona::repulsive::{Exponents, Flow, FlowOptions, Quantity};
use eikona::spatial::self_distance;
use eikona_render::{Coloring, Scene};
use folder::{Row, RunFolder};
use serde_json::json;
use std::path::PathBuf;
use std::time::Instant;

/// Arguments of `eikona repulse`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example (the first line makes the mesh):
  eikona make torus -o torus.ply
  eikona repulse torus.ply -o run --until steps=10

Each step lowers the tangent-point energy (see eikona energy) by the steepest descent in a fractional Sobolev inner
product, keeps the quantities of --keep, and is so short that the surface never touches itself. The folder has log.csv
and log.jsonl with a row per step, frames/000000.ply and so on, and a checkpoint.

Method: Yu, Brakensiek, Schumacher and Crane, Repulsive Surfaces (2021).")]
pub struct RepulseArguments {
    #[command(flatten)]
    pub mesh: MeshArguments,
    /// Output folder: a new or empty one, or that of the run to resume
    #[arg(short, long, value_name = "DIR")]
    pub output: PathBuf,
    /// When to stop: after K steps, at an energy, or after some seconds; the first of several
    /// counts [default: when ten steps lower the energy by less than 0.1 %]
    #[arg(long, value_name = "steps=K|energy=E|seconds=T", value_parser = parse_until)]
    pub until: Vec<Until>,
    /// Continue the run in the folder from its checkpoint
    #[arg(long)]
    pub resume: bool,
    /// Quantities that keep their value: area, volume, both with a comma, or none
    #[arg(long, value_name = "area,volume|none", default_value = "area", value_parser = parse_keep, help_heading = "Method")]
    pub keep: Keep,
    /// The exponent p, above 2: alpha = p, beta = 2p [default: 6]
    #[arg(long, value_name = "P", allow_hyphen_values = true, help_heading = "Method")]
    pub p: Option<f64>,
    /// Do not look for collisions: faster, but the surface may pass through itself
    #[arg(long, help_heading = "Method")]
    pub no_collisions: bool,
    /// Write every K-th frame, and the last
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..), help_heading = "Outputs")]
    pub frames_every: u64,
    /// Write a checkpoint every K steps, and at the end
    #[arg(long, value_name = "K", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..), help_heading = "Outputs")]
    pub checkpoint_every: u64,
    /// Draw each frame that is written as PNG next to it
    #[arg(long, help_heading = "Outputs")]
    pub render: bool,
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Until {
    /// After so many steps.
    Steps(u64),
    /// At this energy or below.
    Energy(f64),
    /// After so many seconds.
    Seconds(f64),
}

fn parse_until(text: &str) -> Result<Until, String> {
    let number = |text: &str| text.parse::<f64>().ok().filter(|x| *x >= 0.0 && x.is_finite());
    match text.split_once('=') {
        Some(("steps", count)) => count.parse().map(Until::Steps).ok(),
        Some(("energy", energy)) => number(energy).map(Until::Energy),
        Some(("seconds", seconds)) => number(seconds).map(Until::Seconds),
        _ => None,
    }
    .ok_or_else(|| "expected steps=K, energy=E or seconds=T with a number of 0 or more".into())
}

/// The quantities to keep.
#[derive(Clone, Debug, PartialEq)]
pub struct Keep(Vec<Quantity>);

fn parse_keep(text: &str) -> Result<Keep, String> {
    if text == "none" {
        return Ok(Keep(Vec::new()));
    }
    let mut found = Vec::new();
    for word in text.split(',') {
        let quantity = match word.trim() {
            "area" => Quantity::Area,
            "volume" => Quantity::Volume,
            _ => return Err("expected area, volume, both with a comma between them, or none".into()),
        };
        if !found.contains(&quantity) {
            found.push(quantity);
        }
    }
    Ok(Keep(found))
}

/// Without `--until`: so many steps have to lower the energy by this share.
const PATIENCE: usize = 10;
const PROGRESS: f64 = 1e-3;

/// Runs the command and returns the exit code.
pub fn run(arguments: &RepulseArguments, general: &General) -> Result<u8, Failure> {
    let mut session = Session::new("repulse", general);
    session.check_report()?;
    let exponents = arguments.p.map_or(Ok(Exponents::default()), Exponents::of_power)?;
    let options = FlowOptions::default()
        .with_exponents(exponents)
        .with_keep(arguments.keep.0.clone())
        .with_collisions(!arguments.no_collisions)
        .with_threads(session.threads());
    let input = MeshInput::read(&arguments.mesh, &mut session)?;
    input.require_faces()?;
    // A checkpoint continues only with the same.
    let settings = json!({
        "alpha": exponents.alpha,
        "beta": exponents.beta,
        "keep": options.keep,
        "collisions": options.collisions,
        "vertices": input.mesh.vertex_count(),
        "faces": input.mesh.face_count(),
        "area": Quantity::Area.of(&input.mesh),
    });
    session.report.options.extend(
        [("flow", settings.clone()), ("threads", json!(options.threads))]
            .map(|(key, value)| (key.to_string(), value)),
    );
    let (mut folder, mut flow) = if arguments.resume {
        let (folder, state) = RunFolder::resume(&arguments.output, &settings)?;
        let flow = session.solver("energy", || Flow::resume(state, &options))?;
        session.note(&format!("continuing after step {}", folder.step()));
        (folder, flow)
    } else {
        // The energy comes first, so that a mesh that is refused leaves no folder.
        let flow = session.solver("energy", || Flow::new(&input.mesh, &options))?;
        (RunFolder::create(&arguments.output, &settings)?, flow)
    };
    let started = Instant::now();
    let before = folder.seconds();
    let first_energy = folder.first_energy().unwrap_or(flow.energy());
    let mut recent = vec![flow.energy()];
    if folder.step() == 0 && !arguments.resume {
        let row = Row::of(&flow, 0, 0.0, 0.0, 0, distance(&flow, &options)?);
        folder.log(&row, json!({}))?;
        write_frame(&mut folder, &flow, arguments)?;
        folder.checkpoint(&flow.state())?;
    }
    let reason = loop {
        let step = folder.step();
        let seconds = before + started.elapsed().as_secs_f64();
        if let Some(reason) = reached(&arguments.until, step, flow.energy(), seconds) {
            break reason;
        }
        let settled = arguments.until.is_empty()
            && recent.len() > PATIENCE
            && recent[recent.len() - 1 - PATIENCE] - flow.energy() < PROGRESS * flow.energy();
        if settled {
            break "settled";
        }
        let name = format!("step {}", step + 1);
        let Some(done) = session.solver(&name, || flow.step())? else { break "minimum" };
        recent.push(done.energy);
        let seconds = before + started.elapsed().as_secs_f64();
        let row = Row::of(
            &flow,
            step + 1,
            seconds,
            done.step_size,
            done.solver_iterations,
            distance(&flow, &options)?,
        );
        let more = json!({
            "descent": done.descent,
            "backtracks": done.backtracks,
            "limited_by_collision": done.limited_by_collision,
            "deviation": done.deviation,
        });
        session.detail(&format!(
            "step {}: energy {:.6}, length {:.3e}",
            step + 1,
            done.energy,
            done.step_size
        ));
        folder.log(&row, more)?;
        if (step + 1).is_multiple_of(arguments.frames_every) {
            write_frame(&mut folder, &flow, arguments)?;
        }
        if (step + 1).is_multiple_of(arguments.checkpoint_every) {
            folder.checkpoint(&flow.state())?;
        }
    };
    if !folder.has_frame() {
        write_frame(&mut folder, &flow, arguments)?;
    }
    folder.checkpoint(&flow.state())?;
    session.report.phase("flow", started.elapsed());
    session.report.result.extend(
        [
            ("steps", json!(folder.step())),
            ("stopped_by", json!(reason)),
            ("first_energy", json!(first_energy)),
            ("energy", json!(flow.energy())),
            ("area", json!(Quantity::Area.of(flow.mesh()))),
            ("volume", json!(Quantity::Volume.of(flow.mesh()))),
            ("self_distance", json!(distance(&flow, &options)?)),
            ("frames", json!(folder.frames())),
        ]
        .map(|(key, value)| (key.to_string(), value)),
    );
    session.note(&format!(
        "{} steps to energy {} from {first_energy} ({}); {} holds the run",
        folder.step(),
        flow.energy(),
        match reason {
            "settled" => "ten steps lowered it by less than 0.1 %",
            "minimum" => "no step lowers it further",
            _ => "as asked",
        },
        arguments.output.display(),
    ));
    session.finish()
}

fn distance(flow: &Flow, options: &FlowOptions) -> Result<f64, Failure> {
    self_distance(flow.mesh(), options.threads).map_err(|fault| Failure::Failed(fault.to_string()))
}

fn reached(until: &[Until], step: u64, energy: f64, seconds: f64) -> Option<&'static str> {
    until.iter().find_map(|until| match until {
        Until::Steps(count) => (step >= *count).then_some("steps"),
        Until::Energy(bound) => (energy <= *bound).then_some("energy"),
        Until::Seconds(bound) => (seconds >= *bound).then_some("seconds"),
    })
}

fn write_frame(folder: &mut RunFolder, flow: &Flow, arguments: &RepulseArguments) -> Result<(), Failure> {
    let picture = match arguments.render {
        true => Some(draw(Scene::new(flow.mesh(), Coloring::default()), &PictureArguments::default())?),
        false => None,
    };
    folder.frame(flow.mesh(), picture)
}
