//! `eikona winding`: labels the regions inside and outside of curves on a surface.

mod arguments;
mod outputs;

pub use arguments::WindingArguments;

use crate::exit::Failure;
use crate::input::MeshInput;
use crate::make::curve_format;
use crate::picture::check_picture_path;
use crate::seams::warn_of_seams;
use crate::session::{General, Session, check_outputs};
use crate::source::{files_read, read_source};
use arguments::MethodArguments;
use eikona::winding::{
    CompletionReport, Diagnosis, Orientation, Reference, Solver, SolverOptions, Winding, WindingOptions,
};
use eikona_mesh::{Face, SurfaceCurves};
use outputs::{Formats, write_outputs};
use serde_json::json;
use std::path::Path;

/// Runs the command and returns the exit code.
pub fn run(arguments: &WindingArguments, general: &General) -> Result<u8, Failure> {
    let mut session = Session::new("winding", general);
    let source = &arguments.source;
    let formats = check_arguments(arguments, general)?;
    let input = MeshInput::read(&arguments.mesh, &mut session)?;
    input.require_faces()?;
    if source.curve.is_empty() && input.file.lines.is_empty() {
        return Err(Failure::Usage(
            "there is no curve; give --curve FILE, or add `l` lines to the mesh's OBJ file".into(),
        ));
    }
    let reference = reference(&arguments.method, &input)?;
    let (curves, _) = read_source(source, &input, &mut session)?;
    warn_of_seams(&input.mesh, &curves, &mut session);
    let winding = solve(arguments, (&input, reference), &curves, &mut session)?;
    write_outputs(arguments, &formats, &winding, (&input, &curves), &mut session)?;
    session.finish()
}

/// Checks the arguments before any work.
fn check_arguments(arguments: &WindingArguments, general: &General) -> Result<Formats, Failure> {
    let source = &arguments.source;
    if !source.points.is_empty() || source.unsigned {
        let flag = if source.unsigned { "--unsigned" } else { "--points" };
        return Err(Failure::Usage(format!(
            "{flag}: points and unsigned curves bound no region; give oriented curves with --curve FILE"
        )));
    }
    let outputs = &arguments.outputs;
    if let Some(path) = &outputs.suggested {
        curve_format(path)?;
        if let Diagnosis::Never = arguments.method.diagnose {
            return Err(Failure::Usage(
                "--suggested needs the diagnosis that --diagnose never turns off; \
             leave one of them out"
                    .into(),
            ));
        }
    }
    let pictures = [outputs.render.as_deref(), outputs.render_values.as_deref()];
    let files = [&outputs.output, &outputs.split, &outputs.input_labels, &outputs.suggested];
    let files = files.map(|path| path.as_deref());
    let others = outputs.lines().into_iter().chain(pictures).chain([general.report.as_deref()]);
    let paths: Vec<&Path> = files.into_iter().chain(others).flatten().collect();
    if paths.is_empty() {
        return Err(Failure::Usage(
            "no output is given; add -o OUT.ply, --render OUT.png, --bounding OUT.obj or --report R.json"
                .into(),
        ));
    }
    check_outputs(&paths, &files_read(&arguments.mesh, &arguments.source))?;
    if let (Some(flag), [None, None]) = (arguments.picture.given(), pictures) {
        return Err(Failure::Usage(format!(
            "{flag} has no effect without a picture; add --render OUT.png or --render-values OUT.png"
        )));
    }
    if let (Some(flag), None) = (arguments.picture.about_values(), &outputs.render_values) {
        return Err(Failure::Usage(format!(
            "{flag} has no effect on --render, which shows regions in fixed colours; add --render-values \
             OUT.png"
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
    let options = WindingOptions::default()
        .with_completion(method.completion)
        .with_completion_shape(method.completion_shape)
        .with_epsilon(method.epsilon)
        .with_reference(reference)
        .with_split_short(!method.keep_short)
        .with_intrinsic_delaunay(method.delaunay)
        .with_diagnosis(match method.diagnose {
            Diagnosis::Automatic if arguments.outputs.suggested.is_some() => Diagnosis::Always,
            other => other,
        });
    let solver_options =
        SolverOptions::default().with_threads(session.threads()).with_memory_limit(method.memory_limit);
    let solver = session.solver("prepare", || Solver::new(&input.mesh, &solver_options))?;
    let winding = session.solver("solve", || solver.solve(curves, &options))?;
    let report = &winding.report;
    if let (Some(path), None) = (&arguments.outputs.suggested, &report.orientation) {
        let reason = report.orientation_unchecked.as_ref();
        return Err(Failure::Failed(format!(
            "{}: cannot suggest a curve{}; leave --suggested out",
            path.display(),
            reason.map_or(String::new(), |reason| format!(": {reason}"))
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
        "{}; {} regions, {} no region; the curve has {} inside the surface",
        shown_labels(&regions),
        loops(bounding, "completed loop bounds", "completed loops bound"),
        loops(nonbounding, "bounds", "bound"),
        loops(winding.endpoints.len(), "open end", "open ends"),
    ));
    if let Some(completion) = report.completion.as_ref().filter(|c| c.straightened > 0) {
        session.note(&format!(
            "straightened {} of the completion, length {:.6} before and {:.6} after",
            loops(completion.straightened, "piece", "pieces"),
            completion.length_before,
            completion.length_after,
        ));
    }
    Ok(winding)
}

/// Formats sorted labels: all of them if there are few, else their range.
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
        "on_edges": completion.on_edges,
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
