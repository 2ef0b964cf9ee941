//! `eikona field`: N directions per point, with singularities where they are asked for.

mod outputs;
mod prescription;

use crate::exit::Failure;
use crate::input::{MeshArguments, MeshInput};
use crate::number::bytes;
use crate::picture::{PictureArguments, check_picture_path};
use crate::session::{General, Session, check_outputs};
use crate::warned::Warned;
use clap::Args;
use eikona::polar_field::{FieldOptions, PolarField, Singularity, Solver, SolverOptions};
use eikona_mesh::counted;
use outputs::{FieldFormat, field_format, output_field, output_picture, output_samples};
use prescription::{read_indices, read_points, read_singularities};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Arguments of `eikona field`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example (the first line makes the mesh):
  eikona make torus -o torus.ply
  eikona field torus.ply -n 4 -o cross.rawfield --report report.json

The indices of each component must add up to its Euler characteristic (2 for a sphere, 0 for a torus, 1 for a disk),
boundary loops included. S.json is a list such as
  [{\"vertex\": 3, \"index\": 0.25}, {\"edge\": [3, 7], \"t\": 0.3, \"index\": -0.5},
   {\"face\": [3, 7, 9], \"bary\": [0.2, 0.3, 0.5], \"index\": 1}, {\"boundary\": 0, \"index\": 0}]")]
pub struct FieldArguments {
    #[command(flatten)]
    pub mesh: MeshArguments,
    /// Singularities: a list of points and boundary loops, each with its index, a multiple of 1/N.
    /// Without it, there are none
    #[arg(long, value_name = "S.json", help_heading = "Method")]
    pub singularities: Option<PathBuf>,
    /// Number of directions at each point: 1 for vectors, 2 for lines, 4 for crosses
    #[arg(short = 'n', long, value_name = "N", default_value = "4", help_heading = "Method")]
    pub degree: u32,
    /// Indices along the homology generators, two per handle: a list of multiples of 1/N. Without
    /// it, all are zero
    #[arg(long, value_name = "C.json", help_heading = "Method")]
    pub cycles: Option<PathBuf>,
    /// Stop before a factorisation if its predicted memory exceeds SIZE, such as 2GiB or 500MB
    #[arg(long, value_name = "SIZE", allow_hyphen_values = true, value_parser = bytes, help_heading = "Method")]
    pub memory_limit: Option<usize>,
    /// Write N unit vectors per face, at its centroid: .rawfield (Directional) or .csv
    #[arg(short, long, value_name = "OUT", help_heading = "Outputs")]
    pub output: Option<PathBuf>,
    /// Points at which to evaluate the field: a list of surface points as in S.json, without index
    #[arg(long, value_name = "P.json", requires = "samples", help_heading = "Outputs")]
    pub sample: Option<PathBuf>,
    /// Write the N unit vectors at the points of --sample, with their positions
    #[arg(long, value_name = "V.csv", requires = "sample", help_heading = "Outputs")]
    pub samples: Option<PathBuf>,
    /// Draw the directions and the singular points, red for positive indices and blue for negative
    /// ones
    #[arg(long, value_name = "PNG", help_heading = "Outputs")]
    pub render: Option<PathBuf>,
    #[command(flatten)]
    pub picture: PictureArguments,
}

/// Runs the command and returns the exit code.
pub fn run(arguments: &FieldArguments, general: &General) -> Result<u8, Failure> {
    let mut session = Session::new("field", general);
    let format = check_arguments(arguments, general)?;
    let input = MeshInput::read(&arguments.mesh, &mut session)?;
    input.require_faces()?;
    let given = arguments.singularities.as_deref();
    let singularities = given.map_or(Ok(Vec::new()), |path| read_singularities(path, &input))?;
    let cycles = arguments.cycles.as_deref().map_or(Ok(Vec::new()), read_indices)?;
    let points = arguments.sample.as_deref().map_or(Ok(Vec::new()), |path| read_points(path, &input))?;
    let field = solve(arguments, &input, &singularities, cycles, &mut session)?;
    if let (Some(path), Some(format)) = (&arguments.output, format) {
        output_field(path, format, &field, &mut session)?;
    }
    if let Some(path) = &arguments.samples {
        output_samples(path, &field, &points, &mut session)?;
    }
    if let Some(path) = &arguments.render {
        output_picture(path, &field, &singularities, &arguments.picture, &mut session)?;
    }
    session.finish()
}

/// Checks the arguments before any work.
fn check_arguments(arguments: &FieldArguments, general: &General) -> Result<Option<FieldFormat>, Failure> {
    let outputs = [&arguments.output, &arguments.samples, &arguments.render].map(|path| path.as_deref());
    let outputs: Vec<&Path> = outputs.into_iter().chain([general.report.as_deref()]).flatten().collect();
    if outputs.is_empty() {
        return Err(Failure::Usage(
            "no output is given; add -o OUT.rawfield, --render OUT.png, --sample P.json --samples V.csv or --report \
             R.json"
                .into(),
        ));
    }
    let read = [&arguments.singularities, &arguments.cycles, &arguments.sample];
    let read = read.into_iter().flatten().map(PathBuf::as_path);
    let inputs: Vec<&Path> = std::iter::once(arguments.mesh.mesh.as_path()).chain(read).collect();
    check_outputs(&outputs, &inputs)?;
    if let (Some(flag), None) = (arguments.picture.given(), &arguments.render) {
        return Err(Failure::Usage(format!("{flag} has no effect without a picture; add --render OUT.png")));
    }
    if let Some(flag) = arguments.picture.about_values() {
        return Err(Failure::Usage(format!("{flag} has no effect on a picture of directions; leave it out")));
    }
    arguments.render.as_deref().map_or(Ok(()), check_picture_path)?;
    arguments.output.as_deref().map(field_format).transpose()
}

fn solve(
    arguments: &FieldArguments,
    input: &MeshInput,
    singularities: &[Singularity],
    cycles: Vec<f64>,
    session: &mut Session,
) -> Result<PolarField, Failure> {
    let solver_options =
        SolverOptions::default().with_threads(session.threads()).with_memory_limit(arguments.memory_limit);
    session.report.options.extend(
        [
            ("degree", json!(arguments.degree)),
            ("cycles", json!(cycles)),
            ("threads", json!(solver_options.threads)),
            ("memory_limit", json!(arguments.memory_limit)),
        ]
        .map(|(key, value)| (key.to_string(), value)),
    );
    let options = FieldOptions::default().with_degree(arguments.degree).with_generators(cycles);
    let solver = session.solver("prepare", || Solver::new(&input.mesh, &solver_options))?;
    let field = session.solver("solve", || solver.solve(singularities, &options))?;
    let report = &field.report;
    session.report.phases_of("prepare", &report.preparation);
    session.report.phases_of("solve", &report.phases);
    for warning in &report.warnings {
        session.warn(warning);
    }
    if let Some(first) = report.aliased.iter().find(|a| a.prescribed != 0.0).or(report.aliased.first()) {
        let sentence = format!(
            "{} where the field turns by more than half a turn of its power from face to face (first: {}, whose \
             index {} is seen as {}, with the rest at edges beside it); move large indices from vertices into faces, \
             or spread them over several points",
            counted(report.aliased.len(), "element is aliased,", "elements are aliased,"),
            first.element,
            first.prescribed,
            first.measured
        );
        session.warn(Warned::new("aliased_elements", sentence).with("count", report.aliased.len()));
    }
    if let Some(first) = report.unplaced.first() {
        let sentence = format!(
            "{} exactly at the wanted point (first: in {first}), too close to others or of too large an index; move \
             it away, or refine the mesh there",
            counted(report.unplaced.len(), "singularity is not", "singularities are not")
        );
        session.warn(Warned::new("unplaced_singularities", sentence).with("count", report.unplaced.len()));
    }
    let aliased: Vec<_> = report
        .aliased
        .iter()
        .map(|a| json!({"element": a.element, "prescribed": a.prescribed, "measured": a.measured}))
        .collect();
    session.report.result.extend(
        [
            ("residual", json!(report.residual)),
            ("closure", json!(report.closure)),
            ("energy", json!(report.energy)),
            ("energy_metric", json!("squared gradients + 10 squared jumps")),
            ("measured", json!(report.measured)),
            ("aliased", json!(aliased)),
            ("unplaced", json!(report.unplaced)),
            ("largest_power", json!(report.largest_power)),
            ("scale_rounds", json!(report.scale_rounds)),
            ("scales_at_bound", json!(report.scales_at_bound)),
            ("scales_gave_up", json!(report.scales_gave_up)),
            ("generators", json!(solver.generator_count())),
        ]
        .map(|(key, value)| (key.to_string(), value)),
    );
    session.note(&format!(
        "{} with {}; largest power {}",
        counted(arguments.degree as usize, "direction", "directions"),
        counted(singularities.len(), "prescribed index", "prescribed indices"),
        report.largest_power
    ));
    session.detail(&format!(
        "residuals {:.1e} (rotation) and {:.1e} (closure of phases); energy {:.6e}",
        report.residual, report.closure, report.energy
    ));
    Ok(field)
}
