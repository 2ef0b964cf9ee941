//! `eikona winding`: inside or outside of curves on a surface.

use crate::exit::Failure;
use crate::input::{MeshArguments, MeshInput};
use crate::make::curve_format;
use crate::number::within;
use crate::picture::{PictureArguments, check_picture_path};
use crate::seams::warn_of_seams;
use crate::session::{General, Session, check_outputs};
use crate::source::{SourceArguments, files_read, read_source};
use crate::winding_file::{Formats, write_outputs};
use clap::{Args, ValueEnum};
use eikona::winding::{
    Completion, CompletionReport, CompletionShape, Diagnosis, EPSILONS, Orientation, Reference, Winding,
    WindingOptions, surface_winding_number,
};
use eikona_mesh::{Face, SurfaceCurves};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Arguments of `eikona winding`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example (the first line makes the files):
  eikona make torus -o torus.ply --curve-out cut.json --cut axis=x,at=0.9
  eikona winding torus.ply --curve cut.json -o labels.ply --render labels.png

Where curves cross faces the mesh is cut along them, and across their gaps along what completes them (--completion-shape); the output is
the cut mesh, with the field `parent`. Labels for the faces of
your own mesh: --input-labels. Faces have the numbers of your file, from 0, also where polygons are cut into triangles and faces are
dropped.")]
// Curves without two sides bound nothing: what asks for them is refused, and need not be offered.
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

const CURVE_HELP: &str = "A file of curves: JSON of eikona, OBJ with `l` lines, or the text formats of signed-heat-demo and SWN; may be \
repeated. Without it, the `l` lines of the mesh's own OBJ file are taken";

/// How the winding number is computed.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Method")]
pub struct MethodArguments {
    /// Take the nonbounding part off everywhere (full), or only along the curve, as the authors'
    /// program does
    #[arg(long, value_enum, default_value = "full")]
    pub completion: CompletionName,
    /// What completes the curve in its gaps: shortest paths across faces (straight), or paths along
    /// edges of the mesh (edges)
    #[arg(long, value_enum, value_name = "SHAPE", default_value = "straight")]
    pub completion_shape: ShapeName,
    /// Cost of a nonbounding loop along the curve, as a share of its cost elsewhere: from 1e-9 to 1
    #[arg(long, value_name = "SHARE", default_value = "0.01", allow_hyphen_values = true, value_parser = parse_epsilon)]
    pub epsilon: f64,
    /// The face of the file (numbered from 0; of a polygon its first triangle) whose label is 0.
    /// Without it: the label that covers most of the area is 0
    #[arg(long, value_name = "FACE")]
    pub reference: Option<u32>,
    /// Leave open pieces of the curve with fewer than 8 edges as they are. Without it they are
    /// bisected, as short pieces have little effect otherwise
    #[arg(long)]
    pub keep_short: bool,
    /// Solve on intrinsic Delaunay triangles: better where faces are badly shaped
    #[arg(long)]
    pub delaunay: bool,
    /// Look for stretches of the curve that seem reversed: if there are few (auto), always or never
    #[arg(long, value_enum, value_name = "WHEN", default_value = "auto")]
    pub diagnose: DiagnosisName,
}

/// See [`Diagnosis`].
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum DiagnosisName {
    /// If the curve has at most 32 stretches
    Auto,
    /// Always
    Always,
    /// Never
    Never,
}

/// See [`Completion`].
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum CompletionName {
    /// Everywhere
    Full,
    /// Only at vertices of the curve
    Curve,
}

/// See [`CompletionShape`].
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum ShapeName {
    /// Shortest paths across faces; the mesh is cut there
    Straight,
    /// Paths along edges
    Edges,
}

/// What is written.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Outputs")]
pub struct OutputArguments {
    /// The mesh with `label`, `margin` and `parent` (the face of your file) at its faces (.ply,
    /// .vtp); with the winding number at its corners as homogeneous texture coordinates u/v (.obj);
    /// cut open between regions, with colours and `label` at its vertices (.glb, .gltf); label,
    /// margin and parent of each face (.csv); or the labels alone (.npy)
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// The mesh cut open between regions: with `label` and `parent` at its faces (.ply, .vtp), with
    /// `label` at its vertices (.glb, .gltf), with the colours of the regions (these, .obj, .off),
    /// or bare (.stl)
    #[arg(long, value_name = "OUT")]
    pub split: Option<PathBuf>,
    /// A label for each face of your file: where it was cut, that of the larger part; where it was
    /// dropped, none (.csv: nothing behind the comma; .npy, int32: -2147483648)
    #[arg(long, value_name = "OUT")]
    pub input_labels: Option<PathBuf>,
    /// The completed boundary of the regions, as lines of an OBJ file
    #[arg(long, value_name = "OBJ")]
    pub bounding: Option<PathBuf>,
    /// The completed loops that bound nothing, as lines of an OBJ file
    #[arg(long, value_name = "OBJ")]
    pub nonbounding: Option<PathBuf>,
    /// The part of the curve itself that bounds, as lines of an OBJ file
    #[arg(long, value_name = "OBJ")]
    pub bounding_part: Option<PathBuf>,
    /// The part of the curve itself that bounds nothing, as lines of an OBJ file
    #[arg(long, value_name = "OBJ")]
    pub nonbounding_part: Option<PathBuf>,
    /// The curves with the stretches that look reversed turned over (.json); see --diagnose
    #[arg(long, value_name = "JSON")]
    pub suggested: Option<PathBuf>,
    /// A picture of the regions, their completed boundary (thin) and the curves
    #[arg(long, value_name = "PNG")]
    pub render: Option<PathBuf>,
    /// A picture of the winding number before it is rounded, with its jumps, and the curves
    #[arg(long, value_name = "PNG")]
    pub render_values: Option<PathBuf>,
}

impl OutputArguments {
    /// The names of files of lines: completed loops and parts of the curve, those that bound first.
    pub fn lines(&self) -> [Option<&Path>; 4] {
        [&self.bounding, &self.nonbounding, &self.bounding_part, &self.nonbounding_part]
            .map(|path| path.as_deref())
    }
}

fn parse_epsilon(text: &str) -> Result<f64, String> {
    within(text, &EPSILONS)
}

/// Runs the verb. Gives the exit code.
pub fn run(arguments: &WindingArguments, general: &General) -> Result<u8, Failure> {
    let mut session = Session::new("winding", general);
    let source = &arguments.source;
    let formats = check_arguments(arguments, general)?;
    let input = MeshInput::read(&arguments.mesh, &mut session)?;
    input.require_faces()?;
    if source.curve.is_empty() && input.file.lines.is_empty() {
        return Err(Failure::Usage(
            "there is no curve; give --curve FILE (or `l` lines in the OBJ file of the mesh)".into(),
        ));
    }
    let reference = reference(&arguments.method, &input)?;
    let (curves, _) = read_source(source, &input, &mut session)?;
    warn_of_seams(&input.mesh, &curves, &mut session);
    let winding = solve(arguments, (&input, reference), &curves, &mut session)?;
    write_outputs(arguments, &formats, &winding, (&input, &curves), &mut session)?;
    session.finish()
}

/// What can be refused before any work is done.
fn check_arguments(arguments: &WindingArguments, general: &General) -> Result<Formats, Failure> {
    let source = &arguments.source;
    if !source.points.is_empty() || source.unsigned {
        let flag = if source.unsigned { "--unsigned" } else { "--points" };
        return Err(Failure::Usage(format!(
            "{flag}: points and curves without direction bound nothing; winding takes oriented curves only"
        )));
    }
    let outputs = &arguments.outputs;
    if let Some(path) = &outputs.suggested {
        curve_format(path)?;
        if let DiagnosisName::Never = arguments.method.diagnose {
            return Err(Failure::Usage("--suggested and --diagnose never exclude each other".into()));
        }
    }
    let pictures = [outputs.render.as_deref(), outputs.render_values.as_deref()];
    let files = [&outputs.output, &outputs.split, &outputs.input_labels, &outputs.suggested];
    let files = files.map(|path| path.as_deref());
    let others = outputs.lines().into_iter().chain(pictures).chain([general.report.as_deref()]);
    let paths: Vec<&Path> = files.into_iter().chain(others).flatten().collect();
    if paths.is_empty() {
        return Err(Failure::Usage(
            "nothing would be written; give -o OUT.ply, --render OUT.png, --bounding OUT.obj or --report R.json".into(),
        ));
    }
    check_outputs(&paths, &files_read(&arguments.mesh, &arguments.source))?;
    if let (Some(flag), [None, None]) = (arguments.picture.given(), pictures) {
        return Err(Failure::Usage(format!(
            "{flag} is for a picture; give --render OUT.png or --render-values OUT.png with it"
        )));
    }
    if let (Some(flag), None) = (arguments.picture.about_values(), &outputs.render_values) {
        return Err(Failure::Usage(format!(
            "{flag} is for values, but --render shows regions, which have colours of their own; give --render-values OUT.png \
             with it"
        )));
    }
    pictures.into_iter().flatten().try_for_each(check_picture_path)?;
    Formats::of(outputs)
}

fn reference(method: &MethodArguments, input: &MeshInput) -> Result<Reference, Failure> {
    let Some(face) = method.reference else { return Ok(Reference::LargestArea) };
    let triangle = input.triangle_of(Face(face));
    triangle.map(Reference::Face).map_err(|e| Failure::Usage(format!("--reference {face}: {e}")))
}

fn solve(
    arguments: &WindingArguments,
    (input, reference): (&MeshInput, Reference),
    curves: &SurfaceCurves,
    session: &mut Session,
) -> Result<Winding, Failure> {
    let method = &arguments.method;
    let options = WindingOptions {
        completion: match method.completion {
            CompletionName::Full => Completion::Full,
            CompletionName::Curve => Completion::Curve,
        },
        completion_shape: match method.completion_shape {
            ShapeName::Straight => CompletionShape::Straight,
            ShapeName::Edges => CompletionShape::Edges,
        },
        epsilon: method.epsilon,
        reference,
        split_short: !method.keep_short,
        intrinsic_delaunay: method.delaunay,
        diagnosis: match method.diagnose {
            DiagnosisName::Auto if arguments.outputs.suggested.is_some() => Diagnosis::Always,
            DiagnosisName::Auto => Diagnosis::Automatic,
            DiagnosisName::Always => Diagnosis::Always,
            DiagnosisName::Never => Diagnosis::Never,
        },
    };
    let winding = session.unmeasured("solve", || surface_winding_number(&input.mesh, curves, &options))?;
    let report = &winding.report;
    if let (Some(path), None) = (&arguments.outputs.suggested, &report.orientation) {
        let mut reasons = report.warnings.iter().filter(|w| w.starts_with("the orientation"));
        return Err(Failure::Failed(format!(
            "{}: no curve can be suggested{}; leave --suggested out",
            path.display(),
            reasons.next().map_or(String::new(), |reason| format!(", as {reason}"))
        )));
    }
    session.report.phases_of("solve", &report.phases);
    report.warnings.iter().for_each(|warning| session.warn(warning));
    let mut regions: Vec<i32> = winding.labels.as_slice().to_vec();
    regions.sort_unstable();
    regions.dedup();
    let (bounding, nonbounding) = (winding.bounding_loops.len(), winding.nonbounding_loops.len());
    let program = report.program.as_ref();
    session.report.result.extend(
        [
            ("labels", json!(regions)),
            ("endpoints", json!(winding.endpoints.len())),
            ("bounding_loops", json!(bounding)),
            ("nonbounding_loops", json!(nonbounding)),
            ("largest_nonbounding", json!(report.largest_nonbounding)),
            ("farthest_from_whole", json!(report.farthest_from_whole)),
            ("uncertain_area", json!(report.uncertain_area)),
            ("residual", json!(report.residual)),
            ("objective", json!(program.map(|p| p.objective))),
            ("gap", json!(program.map(|p| p.certificate.gap))),
            ("pivots", json!(program.map(|p| p.statistics.pivots))),
            ("levels", json!(program.map(|p| p.statistics.levels))),
            ("completion", json!(report.completion.as_ref().map(completion_json))),
            ("orientation", json!(report.orientation.as_ref().map(orientation_json))),
        ]
        .map(|(key, value)| (key.to_string(), value)),
    );
    let loops =
        |n: usize, one: &str, many: &str| if n == 1 { format!("1 {one}") } else { format!("{n} {many}") };
    session.note(&format!(
        "{}; {} regions, {} nothing; the curve has {} inside the surface",
        shown_labels(&regions),
        loops(bounding, "completed loop bounds", "completed loops bound"),
        loops(nonbounding, "bounds", "bound"),
        loops(winding.endpoints.len(), "open end", "open ends"),
    ));
    if let Some(completion) = report.completion.as_ref().filter(|c| c.straightened > 0) {
        session.note(&format!(
            "{} of the completion straightened, from {:.6} to {:.6} long",
            loops(completion.straightened, "piece", "pieces"),
            completion.length_before,
            completion.length_after,
        ));
    }
    Ok(winding)
}

/// These labels, which are sorted, one by one if they are few.
fn shown_labels(regions: &[i32]) -> String {
    const FEW: usize = 10;
    match regions {
        [low, .., high] if regions.len() > FEW => {
            format!("{} labels from {low} to {high}", regions.len())
        }
        _ => format!("labels {regions:?}"),
    }
}

fn completion_json(completion: &CompletionReport) -> serde_json::Value {
    json!({
        "pieces": completion.pieces,
        "straightened": completion.straightened,
        "kept": completion.kept,
        "length_before": completion.length_before,
        "length_after": completion.length_after,
    })
}

fn orientation_json(orientation: &Orientation) -> serde_json::Value {
    let segments: Vec<[usize; 2]> = orientation.reversed.iter().map(|s| [s.curve, s.node]).collect();
    json!({
        "stretches": orientation.stretches,
        "reversed": segments,
        "energy_saved": orientation.energy_saved,
        "changed_area": orientation.changed_area,
    })
}
