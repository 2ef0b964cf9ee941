//! Arguments of `eikona winding`.

use crate::input::MeshArguments;
use crate::number::{bytes, named, within};
use crate::picture::PictureArguments;
use crate::source::SourceArguments;
use clap::Args;
use eikona::winding::{Completion, CompletionShape, Diagnosis, EPSILON_RANGE};
use std::path::{Path, PathBuf};

/// Arguments of `eikona winding`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example (the first line makes the files):
  eikona make torus -o torus.ply --curve-out cut.json --cut axis=x,at=0.9
  eikona winding torus.ply --curve cut.json -o labels.ply --render labels.png

The output is the mesh cut along the curves, and along their completion in the gaps (--completion-shape). The
field `parent` maps its faces to yours; --input-labels writes labels for the faces of your own mesh. Face
numbers are those of your file, from 0, even if polygons are triangulated or faces are dropped.")]
// Points and unsigned curves bound nothing, so these options are refused and the help hides them.
#[command(mut_arg("points", |arg| arg.hide(true)), mut_arg("unsigned", |arg| arg.hide(true)))]
#[command(mut_arg("curve", |arg| arg.help(CURVE_HELP)))]
pub struct WindingArguments {
    #[command(flatten)]
    pub mesh: MeshArguments,
    #[command(flatten)]
    pub source: SourceArguments,
    #[command(flatten)]
    pub method: MethodArguments,
    #[command(flatten)]
    pub outputs: OutputArguments,
    #[command(flatten)]
    pub picture: PictureArguments,
}

const CURVE_HELP: &str = "Curve file: eikona's JSON, OBJ with `l` lines, or the text formats of \
 signed-heat-demo and SWN; may be repeated. Without it, the `l` lines of the mesh's own OBJ file are used";

/// Options of the method.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Method")]
pub struct MethodArguments {
    /// Where to remove the nonbounding part: everywhere (full), or only along the curve, as in the
    /// authors' program
    #[arg(long, value_name = "full|curve", default_value = "full", value_parser = named::<Completion>)]
    pub completion: Completion,
    /// How to complete the curve in its gaps: by shortest paths across faces (straight) or by paths
    /// along mesh edges (edges)
    #[arg(long, value_name = "straight|edges", default_value = "straight", value_parser = named::<CompletionShape>)]
    pub completion_shape: CompletionShape,
    /// Cost of nonbounding loops along the curve, relative to elsewhere: from 1e-9 to 1
    #[arg(long, value_name = "SHARE", default_value = "0.01", allow_hyphen_values = true, value_parser = parse_epsilon)]
    pub epsilon: f64,
    /// Face with label 0, by its number in the file, from 0; the first triangle for a polygon.
    /// Without it, the label of the largest area is 0
    #[arg(long, value_name = "FACE")]
    pub reference: Option<u32>,
    /// Do not refine open pieces of the curve with fewer than 8 edges. By default they are
    /// bisected, since short pieces have little effect otherwise
    #[arg(long)]
    pub keep_short: bool,
    /// Solve on the intrinsic Delaunay triangulation, which helps if faces are badly shaped
    #[arg(long)]
    pub delaunay: bool,
    /// Stop before a factorisation if its predicted memory exceeds SIZE, such as 2GiB or 500MB
    #[arg(long, value_name = "SIZE", allow_hyphen_values = true, value_parser = bytes)]
    pub memory_limit: Option<usize>,
    /// Find stretches of the curve that look reversed: if the curve has at most 32 stretches
    /// (auto), always, or never
    #[arg(long, value_name = "auto|always|never", default_value = "auto", value_parser = named::<Diagnosis>)]
    pub diagnose: Diagnosis,
}

/// Output files.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Outputs")]
pub struct OutputArguments {
    /// Write the mesh with `label`, `margin` and `parent` (the face of your file) per face (.ply,
    /// .vtp); with the winding number per corner as homogeneous texture coordinates u/v (.obj); or
    /// cut open between regions, with colours and `label` per vertex (.glb, .gltf). Without the
    /// mesh: label, margin and parent per face (.csv), or labels (.npy)
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// Write the mesh cut open between regions: with `label` and `parent` per face (.ply, .vtp),
    /// with `label` per vertex (.glb, .gltf), with the colours of the regions (all of these, .obj,
    /// .off), or without data (.stl)
    #[arg(long, value_name = "OUT")]
    pub split: Option<PathBuf>,
    /// Write one label per face of your file (.csv, .npy). A cut face has the label of most of its
    /// area; a dropped face has none (.csv: empty; .npy, int32: -2147483648)
    #[arg(long, value_name = "OUT")]
    pub input_labels: Option<PathBuf>,
    /// Write the completed boundary of the regions as OBJ lines
    #[arg(long, value_name = "OBJ")]
    pub bounding: Option<PathBuf>,
    /// Write the completed nonbounding loops as OBJ lines
    #[arg(long, value_name = "OBJ")]
    pub nonbounding: Option<PathBuf>,
    /// Write the bounding part of the curve as OBJ lines
    #[arg(long, value_name = "OBJ")]
    pub bounding_part: Option<PathBuf>,
    /// Write the nonbounding part of the curve as OBJ lines
    #[arg(long, value_name = "OBJ")]
    pub nonbounding_part: Option<PathBuf>,
    /// Write the curves with stretches that look reversed turned around (.json, .obj or .txt); see
    /// --diagnose
    #[arg(long, value_name = "JSON")]
    pub suggested: Option<PathBuf>,
    /// Draw the regions, their completed boundary (thin) and the curves
    #[arg(long, value_name = "PNG")]
    pub render: Option<PathBuf>,
    /// Draw the winding number before rounding, with its jumps, and the curves
    #[arg(long, value_name = "PNG")]
    pub render_values: Option<PathBuf>,
}

impl OutputArguments {
    /// Paths of the OBJ outputs: completed loops, then parts of the curve, each with the bounding
    /// ones first.
    pub fn lines(&self) -> [Option<&Path>; 4] {
        [&self.bounding, &self.nonbounding, &self.bounding_part, &self.nonbounding_part]
            .map(|path| path.as_deref())
    }
}

fn parse_epsilon(text: &str) -> Result<f64, String> {
    within(text, &EPSILON_RANGE)
}
