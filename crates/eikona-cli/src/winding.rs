//! `eikona winding`: inside or outside of curves on a surface.

use crate::exit::Failure;
use crate::input::{MeshArguments, MeshInput};
use crate::number::above_zero;
use crate::picture::{Drawing, PictureArguments, check_picture_path, draw};
use crate::session::{General, Session, check_distinct, check_output};
use crate::source::{SourceArguments, read_source};
use clap::{Args, ValueEnum};
use eikona::contour::{obj_lines, polylines};
use eikona::winding::{
    Completion, Diagnosis, Orientation, Reference, Winding, WindingOptions, surface_winding_number,
};
use eikona_mesh::io::{MeshFormat, MeshOut, stage_mesh};
use eikona_mesh::{Curve, Face, SurfaceCurves, Vertex};
use serde_json::json;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Arguments of `eikona winding`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example (the first line makes the files):
  eikona make torus -o torus.ply --curve-out cut.json --cut axis=x,at=0.9
  eikona winding torus.ply --curve cut.json -o labels.ply --render labels.png

Where curves cross faces the mesh is cut along them; the output is the cut mesh, with the field `parent`.")]
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

/// How the winding number is computed.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Method")]
pub struct MethodArguments {
    /// Take the nonbounding part off everywhere (full), or only along the curve, as the authors' program does
    #[arg(long, value_enum, default_value = "full")]
    pub completion: CompletionName,
    /// Cost of a nonbounding loop along the curve, as a share of its cost elsewhere
    #[arg(long, value_name = "SHARE", default_value = "0.01", allow_hyphen_values = true, value_parser = above_zero)]
    pub epsilon: f64,
    /// The face (numbered from 0) whose label is 0. Without it: the label that covers most of the area is 0
    #[arg(long, value_name = "FACE")]
    pub reference: Option<u32>,
    /// Leave open pieces of the curve with fewer than 8 edges as they are. Without it they are bisected, as short pieces have
    /// little effect otherwise
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

/// What is written.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Outputs")]
pub struct OutputArguments {
    /// The mesh with `label`, `margin` and `parent` (the face of the input) at its faces (.ply, .vtp); with the winding number at its corners as homogeneous texture
    /// coordinates u/v (.obj); or label and margin of each face (.csv)
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// The completed boundary of the regions, as lines of an OBJ file
    #[arg(long, value_name = "OBJ")]
    pub bounding: Option<PathBuf>,
    /// The completed loops that bound nothing, as lines of an OBJ file
    #[arg(long, value_name = "OBJ")]
    pub nonbounding: Option<PathBuf>,
    /// A picture of the regions and the curves
    #[arg(long, value_name = "PNG")]
    pub render: Option<PathBuf>,
}

/// Formats of the main output.
#[derive(Clone, Copy, Debug)]
enum Format {
    /// Values at faces.
    Faces,
    /// Texture coordinates at corners.
    Corners,
    Csv,
}

fn format_of(path: &Path) -> Result<Format, Failure> {
    let is = |end: &str| path.extension().is_some_and(|e| e.eq_ignore_ascii_case(end));
    match MeshFormat::from_path(path) {
        _ if is("csv") => Ok(Format::Csv),
        Some(MeshFormat::Ply | MeshFormat::Vtp) => Ok(Format::Faces),
        Some(MeshFormat::Obj) => Ok(Format::Corners),
        _ => Err(Failure::Usage(format!(
            "{}: regions can be written as .ply, .vtp, .obj or .csv; choose one of these",
            path.display()
        ))),
    }
}

/// Runs the verb. Gives the exit code.
pub fn run(arguments: &WindingArguments, general: &General) -> Result<u8, Failure> {
    let mut session = Session::new("winding", general);
    let format = check_arguments(arguments, general)?;
    let input = MeshInput::read(&arguments.mesh, &mut session)?;
    input.require_faces()?;
    let (curves, _) = read_source(&arguments.source, &input, &mut session)?;
    let winding = solve(arguments, &input, &curves, &mut session)?;
    write_outputs(arguments, format, &winding, &curves, &mut session)?;
    session.finish()
}

/// What can be refused before any work is done.
fn check_arguments(arguments: &WindingArguments, general: &General) -> Result<Option<Format>, Failure> {
    let outputs = &arguments.outputs;
    let lines = [outputs.bounding.as_deref(), outputs.nonbounding.as_deref()];
    let others = [outputs.output.as_deref(), outputs.render.as_deref(), general.report.as_deref()];
    let paths: Vec<&Path> = lines.into_iter().chain(others).flatten().collect();
    if paths.is_empty() {
        return Err(Failure::Usage(
            "nothing would be written; give -o OUT.ply, --render OUT.png, --bounding OUT.obj or --report R.json".into(),
        ));
    }
    check_distinct(paths.iter().copied())?;
    paths.iter().try_for_each(|path| check_output(path))?;
    for path in lines.into_iter().flatten() {
        if MeshFormat::from_path(path) != Some(MeshFormat::Obj) {
            return Err(Failure::Usage(format!("{}: loops are written as .obj; name it so", path.display())));
        }
    }
    outputs.render.as_deref().map_or(Ok(()), check_picture_path)?;
    outputs.output.as_deref().map(format_of).transpose()
}

fn solve(
    arguments: &WindingArguments,
    input: &MeshInput,
    curves: &SurfaceCurves,
    session: &mut Session,
) -> Result<Winding, Failure> {
    let method = &arguments.method;
    let options = WindingOptions {
        completion: match method.completion {
            CompletionName::Full => Completion::Full,
            CompletionName::Curve => Completion::Curve,
        },
        epsilon: method.epsilon,
        reference: method.reference.map_or(Reference::LargestArea, |face| Reference::Face(Face(face))),
        split_short: !method.keep_short,
        intrinsic_delaunay: method.delaunay,
        diagnosis: match method.diagnose {
            DiagnosisName::Auto => Diagnosis::Automatic,
            DiagnosisName::Always => Diagnosis::Always,
            DiagnosisName::Never => Diagnosis::Never,
        },
    };
    let winding = session.unmeasured("solve", || surface_winding_number(&input.mesh, curves, &options))?;
    let report = &winding.report;
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
            ("residual", json!(report.residual)),
            ("objective", json!(program.map(|p| p.objective))),
            ("gap", json!(program.map(|p| p.certificate.gap))),
            ("pivots", json!(program.map(|p| p.statistics.pivots))),
            ("levels", json!(program.map(|p| p.statistics.levels))),
            ("orientation", json!(report.orientation.as_ref().map(orientation_json))),
        ]
        .map(|(key, value)| (key.to_string(), value)),
    );
    session.note(&format!(
        "labels {regions:?}; {bounding} loops bound, {nonbounding} do not; the curve has {} open ends inside the surface",
        winding.endpoints.len()
    ));
    Ok(winding)
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

fn write_outputs(
    arguments: &WindingArguments,
    format: Option<Format>,
    winding: &Winding,
    curves: &SurfaceCurves,
    session: &mut Session,
) -> Result<(), Failure> {
    let outputs = &arguments.outputs;
    let labels: Vec<f64> = winding.labels.as_slice().iter().map(|&l| f64::from(l)).collect();
    let margin = winding.margin.as_slice();
    let parents: Vec<f64> = match &winding.face_parent {
        Some(parents) => parents.iter().map(|f| f.index() as f64).collect(),
        None => (0..labels.len()).map(|f| f as f64).collect(),
    };
    if let (Some(path), Some(format)) = (&outputs.output, format) {
        let mut out = MeshOut::from(&winding.mesh);
        let uvs: Vec<[f64; 2]>;
        match format {
            Format::Csv => {
                let mut text = String::from("label,margin,parent\n");
                for ((label, margin), parent) in labels.iter().zip(margin).zip(&parents) {
                    let _ = writeln!(text, "{label},{margin},{parent}");
                }
                session.output("regions", path, text.into_bytes())?;
            }
            Format::Faces | Format::Corners => {
                if let Format::Corners = format {
                    // (w, 1), or (0, 0) where there is no value: interpolated linearly and divided at each pixel.
                    let values = winding.values.as_slice().iter();
                    uvs = values.map(|&w| if w.is_nan() { [0.0, 0.0] } else { [w, 1.0] }).collect();
                    out.corner_uvs = Some(&uvs);
                } else {
                    out.face_scalars = vec![("label", &labels), ("margin", margin), ("parent", &parents)];
                }
                let (file, left_out) = stage_mesh(path, &out).map_err(Failure::writing)?;
                session.staged_output("regions", path, file);
                for sentence in left_out {
                    session.warn(format!("{}: {sentence}", path.display()));
                }
            }
        }
    }
    for (path, loops) in
        [(&outputs.bounding, &winding.bounding_loops), (&outputs.nonbounding, &winding.nonbounding_loops)]
    {
        if let Some(path) = path {
            let curve = |nodes: &Vec<Vertex>| Curve::signed(nodes.iter().copied());
            let loops = SurfaceCurves { curves: loops.iter().map(curve).collect(), points: Vec::new() };
            let lines = polylines(&winding.mesh, &loops).and_then(|lines| obj_lines(&lines));
            let text = lines.map_err(|e| Failure::Failed(format!("{}: {e}", path.display())))?;
            session.output("loops", path, text.into_bytes())?;
        }
    }
    if let Some(path) = &outputs.render {
        let labels: Vec<i64> = winding.labels.as_slice().iter().map(|&l| i64::from(l)).collect();
        let drawing = Drawing { labels: Some(&labels), curves: Some(curves), ..Drawing::default() };
        let png = session.phase("render", || draw(&winding.mesh, &drawing, &arguments.picture))?;
        session.output("picture", path, png)?;
    }
    Ok(())
}
