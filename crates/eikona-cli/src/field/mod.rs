//! `eikona field`: N directions per point, with singularities where they are asked for.

mod guides;
mod outputs;
mod per_face;
pub mod prescription;

use crate::exit::Failure;
use crate::input::{MeshArguments, MeshInput};
use crate::number::{above_zero, bytes};
use crate::picture::{PictureArguments, check_picture_path};
use crate::session::{General, Session, check_outputs};
use crate::stored_field::{read_stored_field, restored_field};
use crate::warned::Warned;
use clap::Args;
use eikona::polar_field::{
    AutomaticOptions, FieldOptions, FieldReport, Followed, Guide, PolarField, Prescription, Solver,
    SolverOptions, StreamlineOptions,
};
use eikona_mesh::counted;
use guides::{Alignment, Automatic, files, output_prescription, parse_alignment, read_guides};
use outputs::{output_picture, output_samples, output_streamlines};
use per_face::{
    FieldFormat, field_format, output_field, output_matching, output_split, output_stored,
    output_vertex_list, split_format,
};
use prescription::{is_sings, read_indices, read_points, read_singularities};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Arguments of `eikona field`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example (the first line makes the mesh):
  eikona make torus -o torus.ply
  eikona field torus.ply -n 4 --auto -o cross.rawfield --render cross.png

The indices of each component must add up to its Euler characteristic (2 for a sphere, 0 for a torus, 1 for a disk),
boundary loops included. S.json is a list such as
  [{\"vertex\": 3, \"index\": 0.25}, {\"edge\": [3, 7], \"t\": 0.3, \"index\": -0.5},
   {\"face\": [3, 7, 9], \"bary\": [0.2, 0.3, 0.5], \"index\": 1}, {\"boundary\": 0, \"index\": 0}]")]
pub struct FieldArguments {
    #[command(flatten)]
    pub mesh: MeshArguments,
    /// Singularities: a list of points and boundary loops, each with its index, a multiple of 1/N
    /// (.json), or vertices with their index times N (.sings, Directional).
    /// Without it and --auto, there are none
    #[arg(long, value_name = "S.json", help_heading = "Method")]
    pub singularities: Option<PathBuf>,
    /// Take the singularities of the smoothest field, near what --align names; `curvature` follows
    /// the principal curvatures where they differ
    #[arg(
        long,
        value_name = "HOW",
        value_enum,
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "smoothest",
        conflicts_with_all = ["singularities", "cycles"],
        help_heading = "Method"
    )]
    pub auto: Option<Automatic>,
    /// Number of directions at each point: 1 for vectors, 2 for lines, 4 for crosses
    #[arg(short = 'n', long, value_name = "N", default_value = "4", help_heading = "Method")]
    pub degree: u32,
    /// Read a field that -o wrote as .npz or .json on this mesh, instead of computing one
    #[arg(
        long,
        value_name = "FIELD",
        conflicts_with_all = ["singularities", "auto", "degree", "cycles", "align", "save_cycles"],
        help_heading = "Method"
    )]
    pub field: Option<PathBuf>,
    /// Indices along the homology generators, two per handle: a list of multiples of 1/N. Without
    /// it, all are zero
    #[arg(long, value_name = "C.json", help_heading = "Method")]
    pub cycles: Option<PathBuf>,
    /// Make one of the directions tangent to the curves of a file (as for `eikona sdf`), to the
    /// boundary, or to creases, edges at which the surface bends by more than DEG degrees (30); may
    /// be repeated
    #[arg(long, value_name = "CURVE|boundary|creases[=DEG]", value_parser = parse_alignment, help_heading = "Method")]
    pub align: Vec<Alignment>,
    /// Follow --align with this weight relative to the smoothness, the same at every resolution,
    /// instead of exactly
    #[arg(long, value_name = "W", requires = "align", value_parser = above_zero, allow_hyphen_values = true, help_heading = "Method")]
    pub align_weight: Option<f64>,
    /// Compute the trivial connection instead, which is constant in each face and has the least
    /// rotation across edges: for comparison, with singularities at vertices only
    #[arg(long, conflicts_with_all = ["align", "field"], help_heading = "Method")]
    pub trivial: bool,
    /// Stop before a factorisation if its predicted memory exceeds SIZE, such as 2GiB or 500MB
    #[arg(long, value_name = "SIZE", allow_hyphen_values = true, value_parser = bytes, help_heading = "Method")]
    pub memory_limit: Option<usize>,
    /// Write N unit vectors per face, at its centroid: .rawfield (Directional), .csv, .npy (shape
    /// F, N, 3), with the mesh (.vtp, .ply), or .rosy (QuadWild), which is for N = 4; or the field
    /// itself without loss, for --field: .npz, .json
    #[arg(short, long, value_name = "OUT", help_heading = "Outputs")]
    pub output: Option<PathBuf>,
    /// Write the mesh split at singular points, so that each is a vertex. Vectors per face,
    /// --save-matching and .sings are then those of this mesh
    #[arg(long, value_name = "MESH", help_heading = "Outputs")]
    pub split: Option<PathBuf>,
    /// Points at which to evaluate the field: a list of surface points as in S.json, without index
    #[arg(long, value_name = "P.json", requires = "samples", help_heading = "Outputs")]
    pub sample: Option<PathBuf>,
    /// Write the N unit vectors at the points of --sample, with their positions
    #[arg(long, value_name = "V.csv", requires = "sample", help_heading = "Outputs")]
    pub samples: Option<PathBuf>,
    /// Give the vectors of --samples the length of the interpolation, which falls to zero at
    /// singular points, instead of 1
    #[arg(long, requires = "samples", help_heading = "Outputs")]
    pub scaled: bool,
    /// Write how the vectors of neighbouring faces continue each other (Directional)
    #[arg(long, value_name = "M.matching", help_heading = "Outputs")]
    pub save_matching: Option<PathBuf>,
    /// Write the singularities that were used, to be edited and read again: .json, or .sings
    /// (Directional), which is for vertices only
    #[arg(long, value_name = "S.json", help_heading = "Outputs")]
    pub save_singularities: Option<PathBuf>,
    /// Write the indices of the homology generators that were used
    #[arg(long, value_name = "C.json", help_heading = "Outputs")]
    pub save_cycles: Option<PathBuf>,
    /// Write evenly spaced streamlines as OBJ polylines
    #[arg(long, value_name = "L.obj", help_heading = "Outputs")]
    pub streamlines: Option<PathBuf>,
    /// Distance between streamlines of about the same direction, in the unit of the mesh; default:
    /// a 50th of the root of the area
    #[arg(long, value_name = "D", value_parser = above_zero, allow_hyphen_values = true, help_heading = "Outputs")]
    pub separation: Option<f64>,
    /// Draw streamlines and the singular points, red for positive indices and blue for negative
    /// ones
    #[arg(long, value_name = "PNG", help_heading = "Outputs")]
    pub render: Option<PathBuf>,
    /// Draw marks at faces instead of streamlines
    #[arg(long, requires = "render", help_heading = "Outputs")]
    pub glyphs: bool,
    #[command(flatten)]
    pub picture: PictureArguments,
}

/// Runs the command and returns the exit code.
pub fn run(arguments: &FieldArguments, general: &General) -> Result<u8, Failure> {
    let mut session = Session::new("field", general);
    let format = check_arguments(arguments, general)?;
    let input = MeshInput::read(&arguments.mesh, &mut session)?;
    input.require_faces()?;
    let mut prescription = Prescription::default();
    if let Some(path) = &arguments.singularities {
        prescription.singularities = read_singularities(path, arguments.degree, &input)?;
    }
    if let Some(path) = &arguments.cycles {
        prescription.generators = read_indices(path)?;
    }
    let points = arguments.sample.as_deref().map_or(Ok(Vec::new()), |path| read_points(path, &input))?;
    let guides = read_guides(&arguments.align, &input, &mut session)?;
    let (field, prescription) = match &arguments.field {
        Some(path) => restore(path, &input, &mut session)?,
        None => solve(arguments, &input, prescription, guides, &mut session)?,
    };
    if format == Some(FieldFormat::Rosy) && field.degree() != 4 {
        return Err(Failure::Usage(format!(
            ".rosy files are for N = 4, but this field has N = {}; write .rawfield",
            field.degree()
        )));
    }
    output_per_face(arguments, format, &field, &mut session)?;
    // With --split, a list of vertices is one of the split mesh, written above.
    let in_split = |path: &&Path| arguments.split.is_some() && is_sings(path);
    let singularities_file = arguments.save_singularities.as_deref().filter(|path| !in_split(path));
    let saved = [singularities_file, arguments.save_cycles.as_deref()];
    output_prescription(saved, &prescription, field.degree(), &input, &mut session)?;
    if let Some(path) = &arguments.samples {
        output_samples(path, &field, &points, arguments.scaled, &mut session)?;
    }
    let is_drawn = arguments.render.is_some() && !arguments.glyphs;
    let lines = if arguments.streamlines.is_some() || is_drawn {
        let options = StreamlineOptions::default().with_separation(arguments.separation);
        session.solver("streamlines", || field.streamlines(&options))?
    } else {
        Vec::new()
    };
    if let Some(path) = &arguments.streamlines {
        output_streamlines(path, &field, &lines, &mut session)?;
    }
    if let Some(path) = &arguments.render {
        let lines = is_drawn.then_some(lines.as_slice());
        output_picture(path, &field, lines, &arguments.picture, &mut session)?;
    }
    session.finish()
}

/// Checks the arguments before any work.
fn check_arguments(arguments: &FieldArguments, general: &General) -> Result<Option<FieldFormat>, Failure> {
    let outputs = [
        &arguments.output,
        &arguments.split,
        &arguments.samples,
        &arguments.streamlines,
        &arguments.save_matching,
        &arguments.save_singularities,
        &arguments.save_cycles,
        &arguments.render,
    ]
    .map(|path| path.as_deref());
    let outputs: Vec<&Path> = outputs.into_iter().chain([general.report.as_deref()]).flatten().collect();
    if outputs.is_empty() {
        return Err(Failure::Usage(
            "no output is given; add -o OUT.rawfield, --render OUT.png, --sample P.json --samples V.csv or --report \
             R.json"
                .into(),
        ));
    }
    let read = [&arguments.singularities, &arguments.cycles, &arguments.sample, &arguments.field];
    let read = read.into_iter().flatten().map(PathBuf::as_path).chain(files(&arguments.align));
    let inputs: Vec<&Path> = std::iter::once(arguments.mesh.mesh.as_path()).chain(read).collect();
    check_outputs(&outputs, &inputs)?;
    if let (Some(flag), None) = (arguments.picture.given(), &arguments.render) {
        return Err(Failure::Usage(format!("{flag} has no effect without a picture; add --render OUT.png")));
    }
    let has_lines = arguments.streamlines.is_some() || arguments.render.is_some() && !arguments.glyphs;
    if arguments.separation.is_some() && !has_lines {
        return Err(Failure::Usage(
            "--separation has no effect without streamlines; add --streamlines L.obj, or --render OUT.png without \
             --glyphs"
                .into(),
        ));
    }
    if let Some(flag) = arguments.picture.about_values() {
        return Err(Failure::Usage(format!("{flag} has no effect on a picture of directions; leave it out")));
    }
    arguments.render.as_deref().map_or(Ok(()), check_picture_path)?;
    let format = arguments.output.as_deref().map(field_format).transpose()?;
    if format == Some(FieldFormat::Rosy) && arguments.degree != 4 && arguments.field.is_none() {
        return Err(Failure::Usage(".rosy files are for N = 4 only; write .rawfield".into()));
    }
    if let Some(path) = &arguments.split {
        split_format(path)?;
    }
    Ok(format)
}

/// Reads a stored field.
fn restore(
    path: &Path,
    input: &MeshInput,
    session: &mut Session,
) -> Result<(PolarField, Prescription), Failure> {
    let data = read_stored_field(path)?;
    let field = session.solver("restore", || restored_field(path, &input.mesh, &data))?;
    let FieldReport { closure, measured, largest_power, .. } = &field.report;
    session.report.result.extend(
        [
            ("degree", json!(field.degree())),
            ("closure", json!(closure)),
            ("measured", json!(measured)),
            ("largest_power", json!(largest_power)),
        ]
        .map(|(key, value)| (key.to_string(), value)),
    );
    let mut prescription = Prescription::default();
    prescription.singularities = data.singularities;
    Ok((field, prescription))
}

/// Writes the field as vectors per face, and what belongs to them.
fn output_per_face(
    arguments: &FieldArguments,
    format: Option<FieldFormat>,
    field: &PolarField,
    session: &mut Session,
) -> Result<(), Failure> {
    let output = arguments.output.as_deref().zip(format);
    if let Some((path, format)) = output
        && format.is_stored()
    {
        output_stored(path, format, field, session)?;
    }
    let output = output.filter(|(_, format)| !format.is_stored());
    if output.is_none() && arguments.split.is_none() && arguments.save_matching.is_none() {
        return Ok(());
    }
    let sampled = match arguments.split.is_some() {
        true => session.solver("split", || field.split())?,
        false => session.solver("vectors per face", || field.per_face())?,
    };
    if let Some(first) = sampled.steep_edges.first() {
        let sentence = format!(
            "{} by half a turn of the N-th power or more from face to face (first: {first}), so programs that match \
             vectors by the smallest rotation see other indices at their ends; give them the matching \
             (--save-matching), or refine the mesh there",
            counted(sampled.steep_edges.len(), "edge turns", "edges turn"),
        );
        session.warn(Warned::new("steep_edges", sentence).with("count", sampled.steep_edges.len()));
    }
    if sampled.left_out > 0 {
        let sentence = format!(
            "{} inside faces or edges, where vectors per face cannot show them; add --split MESH.obj to make them \
             vertices",
            counted(sampled.left_out, "singular point is", "singular points are"),
        );
        session.warn(Warned::new("not_at_vertices", sentence).with("count", sampled.left_out));
    }
    if let Some(path) = &arguments.split {
        output_split(path, &sampled, session)?;
        let list = arguments.save_singularities.as_deref().filter(|path| is_sings(path));
        if let Some(path) = list {
            output_vertex_list(path, &sampled, session)?;
        }
    }
    if let Some((path, format)) = output {
        output_field(path, format, &sampled, session)?;
    }
    match &arguments.save_matching {
        Some(path) => output_matching(path, &sampled, session),
        None => Ok(()),
    }
}

fn solve(
    arguments: &FieldArguments,
    input: &MeshInput,
    mut prescription: Prescription,
    guides: Vec<Guide>,
    session: &mut Session,
) -> Result<(PolarField, Prescription), Failure> {
    let solver_options =
        SolverOptions::default().with_threads(session.threads()).with_memory_limit(arguments.memory_limit);
    session.report.options.extend(
        [
            ("degree", json!(arguments.degree)),
            ("auto", json!(arguments.auto.map(Automatic::name))),
            ("guides", json!(arguments.align.len())),
            ("align_weight", json!(arguments.align_weight)),
            ("trivial", json!(arguments.trivial)),
            ("threads", json!(solver_options.threads)),
            ("memory_limit", json!(arguments.memory_limit)),
        ]
        .map(|(key, value)| (key.to_string(), value)),
    );
    let solver = session.solver("prepare", || Solver::new(&input.mesh, &solver_options))?;
    if let Some(how) = arguments.auto {
        let options = AutomaticOptions::default()
            .with_degree(arguments.degree)
            .with_guides(guides.clone())
            .with_curvature(how == Automatic::Curvature);
        prescription = session.solver("automatic", || solver.automatic(&options))?;
    }
    let options = FieldOptions::default()
        .with_degree(arguments.degree)
        .with_generators(prescription.generators.clone())
        .with_guides(guides)
        .with_guide_weight(arguments.align_weight);
    let field = session.solver("solve", || match arguments.trivial {
        true => solver.trivial_connection(&prescription.singularities, &options),
        false => solver.solve(&prescription.singularities, &options),
    })?;
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
    warn_of_guides(report, arguments.align_weight.is_none(), session);
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
            (
                "printed_energy",
                json!({"jumps times 50": report.printed_energy[0], "jumps times 1": report.printed_energy[1]}),
            ),
            ("measured", json!(report.measured)),
            ("aliased", json!(aliased)),
            ("unplaced", json!(report.unplaced)),
            ("largest_power", json!(report.largest_power)),
            ("scale_rounds", json!(report.scale_rounds)),
            ("scales_at_bound", json!(report.scales_at_bound)),
            ("scales_gave_up", json!(report.scales_gave_up)),
            ("generators", json!(solver.generator_count())),
            ("cycles", json!(prescription.generators)),
            ("followed", json!(report.followed.iter().map(followed).collect::<Vec<_>>())),
        ]
        .map(|(key, value)| (key.to_string(), value)),
    );
    session.note(&format!(
        "{} with {}; largest power {}",
        counted(arguments.degree as usize, "direction", "directions"),
        counted(prescription.singularities.len(), "prescribed index", "prescribed indices"),
        report.largest_power
    ));
    session.detail(&format!(
        "residuals {:.1e} (rotation) and {:.1e} (closure of phases); energy {:.6e}",
        report.residual, report.closure, report.energy
    ));
    Ok((field, prescription))
}

/// Angles beyond this many radians between a guide and the field are warned of.
const ASIDE: f64 = 0.02;

fn warn_of_guides(report: &FieldReport, is_exact: bool, session: &mut Session) {
    let aside = |followed: &&Followed| followed.largest_error > ASIDE;
    let worst = |a: &&Followed, b: &&Followed| a.largest_error.total_cmp(&b.largest_error);
    if let Some(worst) = report.followed.iter().filter(aside).filter(|_| is_exact).max_by(worst) {
        let sentence = format!(
            "the field is up to {:.1} degrees away from what it should follow ({}, at {}), where guides turn inside \
             a face, or meet in one; refine the mesh there",
            worst.largest_error.to_degrees(),
            worst.guide,
            worst.worst_face
        );
        let count = report.followed.iter().filter(aside).count();
        session.warn(Warned::new("guides_not_followed", sentence).with("count", count));
    }
}

fn followed(followed: &Followed) -> Value {
    json!({
        "guide": followed.guide,
        "largest_error": followed.largest_error,
        "mean_error": followed.mean_error,
        "worst_face": followed.worst_face.0,
    })
}
