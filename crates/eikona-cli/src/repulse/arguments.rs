//! Arguments of `eikona repulse`.

use super::animation::{DEFAULT_RATE, parse_rate};
use crate::input::{MeshArguments, parse_format};
use crate::quadrature::QuadratureKind;
use clap::Args;
use eikona::repulsive::Quantity;
use eikona_mesh::io::MeshFormat;
use std::path::PathBuf;

/// Arguments of `eikona repulse`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example (the first line makes the mesh):
  eikona make torus -o torus.ply
  eikona repulse torus.ply -o run --until steps=10

Instead of a mesh, a scene (.txt or .toml) can say what moves, what stays, around which obstacles and for how long:
docs/scenes.md has both grammars.

Each step lowers the tangent-point energy (see eikona energy) by the steepest descent in a fractional Sobolev inner
product, keeps the quantities of --keep, and is so short that the surface never touches itself; then the surface is
remeshed. The folder has log.csv
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
    /// Quantities that keep their value: area, volume, both with a comma, or none [default: area]
    #[arg(long, value_name = "area,volume|none", value_parser = parse_keep, help_heading = "Method")]
    pub keep: Option<Keep>,
    /// The exponent p, above 2: alpha = p, beta = 2p [default: 6]
    #[arg(long, value_name = "P", allow_hyphen_values = true, help_heading = "Method")]
    pub p: Option<f64>,
    /// How the energy of two faces is integrated: adaptive (subdivided where they are close) or
    /// midpoint, as published [default: adaptive; midpoint for P below 4]
    #[arg(
        long,
        value_name = "adaptive|midpoint",
        value_enum,
        hide_possible_values = true,
        help_heading = "Method"
    )]
    pub quadrature: Option<QuadratureKind>,
    /// Do not look for collisions: faster, but the surface may pass through itself
    #[arg(long, help_heading = "Method")]
    pub no_collisions: bool,
    /// Remesh after each step: off, uniform, or adaptive, with shorter edges where the surface is
    /// curved or close to itself [default: uniform]
    #[arg(
        long,
        value_name = "off|uniform|adaptive",
        value_enum,
        hide_possible_values = true,
        help_heading = "Method"
    )]
    pub remesh: Option<RemeshKind>,
    /// The length that remeshing gives to edges [default: their mean length at the start]
    #[arg(long, value_name = "L", value_parser = parse_length, allow_hyphen_values = true, help_heading = "Method")]
    pub edge_length: Option<f64>,
    /// Write every K-th frame, and the last [default: 1]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u64).range(1..), help_heading = "Outputs")]
    pub frames_every: Option<u64>,
    /// Format of the frames: ply, obj, glb, vtp, off, stl or gltf. Colours and values of the input
    /// follow the surface in PLY, VTP and GLB, texture coordinates in PLY, OBJ and GLB
    #[arg(long, value_name = "FORMAT", value_parser = parse_format, default_value = "ply",
        hide_default_value = true, help_heading = "Outputs")]
    pub frames: MeshFormat,
    /// Write the frames without colours, values and texture coordinates of the input
    #[arg(long, help_heading = "Outputs")]
    pub no_data: bool,
    /// At the end, write the frames as animation.glb too: one mesh with a morph target per frame,
    /// FPS frames per second. Needs --remesh off
    #[arg(long, value_name = "FPS", num_args = 0..=1, require_equals = true,
        default_missing_value = DEFAULT_RATE, value_parser = parse_rate, help_heading = "Outputs")]
    pub animation: Option<f64>,
    /// Write a checkpoint every K steps, and at the end [default: 10]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u64).range(1..), help_heading = "Outputs")]
    pub checkpoint_every: Option<u64>,
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
pub struct Keep(pub Vec<Quantity>);

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

/// Whether and how to remesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum RemeshKind {
    /// Not at all.
    Off,
    /// To edges of one length.
    #[default]
    Uniform,
    /// To shorter edges where the surface is curved or close to itself.
    Adaptive,
}

fn parse_length(text: &str) -> Result<f64, String> {
    let length = text.parse::<f64>().ok().filter(|x| *x > 0.0 && x.is_finite());
    length.ok_or_else(|| "expected a length above 0, in the unit of the mesh".into())
}
