//! `eikona sdf`: signed distance to curves and points on a surface.

use crate::exit::Failure;
use crate::field_file::{FieldFormat, field_format, output_fields};
use crate::input::{MeshArguments, MeshInput};
use crate::isoline_file::{IsolineArguments, check_flat_for_svg, check_isoline_path, output_isolines};
use crate::number::{brief, bytes, named, rounded};
use crate::picture::{PictureArguments, check_picture_path, curves, draw, isolines};
use crate::seams::warn_of_seams;
use crate::session::{General, Session, check_outputs};
use crate::source::{SourceArguments, files_read, read_source, warn_of_sides};
use crate::warned::Warned;
use clap::Args;
use eikona::signed_heat::{
    DiffusionTime, LevelSets, SignConvention, Solution, SolveOptions, Solver, SolverOptions,
};
use eikona_mesh::{CurveKind, SurfaceCurves, counted};
use eikona_render::{ColorMap, Coloring, Levels, ScalarField, Scene, Values};
use serde_json::{Value, json};
use std::path::PathBuf;

/// Arguments of `eikona sdf`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example (the first two lines make the files):
  eikona make clay_animal -o animal.ply --broken-curve loop.json --cut axis=x,at=0.2
  eikona sdf animal.ply --curve loop.json -o distance.ply --render distance.png --up z
  eikona sdf animal.ply --points 12,40 -o distance.csv")]
pub struct SdfArguments {
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

/// Options of the method.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Method")]
pub struct MethodArguments {
    /// Diffusion time, as a coefficient of h², where h is half the mean edge length (the paper uses
    /// 1); auto: chosen from the gaps of the curves; smooth: for smooth closed curves, where the
    /// distance has no ridges
    #[arg(long, value_name = "auto|smooth|COEFF", default_value = "auto", allow_hyphen_values = true, value_parser = named::<DiffusionTime>)]
    pub time: DiffusionTime,
    /// Level-set constraint on the curves: auto (closed curves exactly zero, broken curves as
    /// firmly as their pieces agree), zero, soft (near zero, with weight W), per-component (each
    /// piece at its own level), or free (no constraint)
    #[arg(long, value_name = "auto|zero|soft[=W]|per-component|free", default_value = "auto", value_parser = named::<LevelSets>)]
    pub level_sets: LevelSets,
    /// Keep the diffused vectors normal to the curves, which preserves corners of the curves
    #[arg(long, conflicts_with = "unsigned")]
    pub preserve_normals: bool,
    /// Sign of the distance on the left of a curve, seen along its direction [default:
    /// left-negative]
    #[arg(long, value_name = "left-negative|left-positive", conflicts_with = "unsigned", value_parser = named::<SignConvention>)]
    pub sign: Option<SignConvention>,
    /// Also write how well the curves determine each value: the fields `confidence` (0 to 1) and
    /// `distance_to_data`
    #[arg(long)]
    pub confidence: bool,
    /// Stop before the factorisation if its predicted memory exceeds SIZE, such as 2GiB or 500MB
    #[arg(long, value_name = "SIZE", allow_hyphen_values = true, value_parser = bytes)]
    pub memory_limit: Option<usize>,
}

/// Output files.
#[derive(Args, Clone, Debug)]
#[command(next_help_heading = "Outputs")]
pub struct OutputArguments {
    /// Write the mesh with one distance per vertex (.ply and .vtp also keep the input's fields;
    /// .glb, .gltf; .obj: as texture coordinate u; .off: as colours), or the values alone (.npy,
    /// .csv); - for standard output
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    /// Format of the output on standard output: ply, obj, off, vtp, glb, gltf, npy, csv
    #[arg(long, value_name = "FORMAT")]
    pub out_format: Option<String>,
    #[command(flatten)]
    pub isolines: IsolineArguments,
    /// Draw the distance, its isolines and the curves
    #[arg(long, value_name = "PNG")]
    pub render: Option<PathBuf>,
}

/// Runs the command and returns the exit code.
pub fn run(arguments: &SdfArguments, general: &General) -> Result<u8, Failure> {
    let mut session = Session::new("sdf", general);
    let format = check_arguments(arguments, general)?;
    let input = MeshInput::read(&arguments.mesh, &mut session)?;
    input.require_faces()?;
    check_flat_for_svg(&arguments.outputs.isolines, &input.mesh)?;
    let (source, _) = read_source(&arguments.source, &input, &mut session)?;
    if !source.curves.iter().any(|c| c.kind == CurveKind::Signed) {
        warn_of_sides(&arguments.method.about_sides(), &mut session);
    }
    if source.curves.is_empty() && arguments.method.level_sets == LevelSets::PerComponent {
        let sentence = "--level-sets per-component has no effect: there are only points and no curves";
        session.warn(Warned::new("idle_option", sentence));
    }
    warn_if_short(arguments.method.time, &mut session);
    warn_of_seams(&input.mesh, &source, &mut session);
    let solution = solve(arguments, &input, &source, &mut session)?;
    write_outputs(arguments, format, &input, &source, &solution, &mut session)?;
    session.finish()
}

impl MethodArguments {
    /// The given options that concern the sides of curves.
    fn about_sides(&self) -> Vec<&'static str> {
        let flags = [(self.sign.is_some(), "--sign"), (self.preserve_normals, "--preserve-normals")];
        flags.into_iter().filter(|(given, _)| *given).map(|(_, flag)| flag).collect()
    }
}

/// Checks the arguments before any work.
fn check_arguments(arguments: &SdfArguments, general: &General) -> Result<Option<FieldFormat>, Failure> {
    let outputs = &arguments.outputs;
    let isolines = outputs.isolines.isolines.as_deref();
    let paths = [outputs.output.as_deref(), isolines, outputs.render.as_deref(), general.report.as_deref()];
    let paths: Vec<_> = paths.into_iter().flatten().collect();
    if paths.is_empty() {
        return Err(Failure::Usage(
            "no output is given; add -o OUT.ply, --render OUT.png, --isolines OUT.obj or --report R.json"
                .into(),
        ));
    }
    check_outputs(&paths, &files_read(&arguments.mesh, &arguments.source))?;
    check_idle(arguments)?;
    let given = outputs.out_format.as_deref();
    let format = outputs.output.as_deref().map(|path| field_format(path, given)).transpose()?;
    check_isoline_path(&outputs.isolines)?;
    outputs.render.as_deref().map_or(Ok(()), check_picture_path)?;
    if let Some(word) = given
        && outputs.output.is_none()
    {
        return Err(Failure::Usage(format!("--out-format {word} has no effect without an output; add -o -")));
    }
    Ok(format)
}

/// Fails for options that would have no effect.
fn check_idle(arguments: &SdfArguments) -> Result<(), Failure> {
    let outputs = &arguments.outputs;
    let wrong = |flag: &str, what: &str| Err(Failure::Usage(format!("{flag} has no effect without {what}")));
    if let (Some(flag), None) = (arguments.picture.given(), &outputs.render) {
        return wrong(flag, "a picture; add --render OUT.png");
    }
    if let (Some(flag), None, None) = (outputs.isolines.given(), &outputs.isolines.isolines, &outputs.render)
    {
        return wrong(flag, "isolines; add --isolines OUT.obj or --render OUT.png");
    }
    if arguments.method.confidence && outputs.output.is_none() {
        return wrong("--confidence", "an output that stores fields; add -o OUT.ply");
    }
    let mut flags = arguments.method.about_sides();
    if arguments.method.level_sets == LevelSets::PerComponent {
        flags.push("--level-sets per-component");
    }
    arguments.source.check_sides(&flags)
}

/// For smaller coefficients of the diffusion time, the diffused vectors decay within one edge.
const SHORT_TIME: f64 = 1e-2;

fn warn_if_short(time: DiffusionTime, session: &mut Session) {
    if let DiffusionTime::Coefficient(c) = time
        && c < SHORT_TIME
    {
        let sentence = format!(
            "--time {c:?} is below {SHORT_TIME}, where the result depends on the mesh edges more than on \
             the distance; leave --time out, or use the paper's value 1"
        );
        session.warn(Warned::new("short_time", sentence).with("time", c));
    }
}

fn solve(
    arguments: &SdfArguments,
    input: &MeshInput,
    source: &SurfaceCurves,
    session: &mut Session,
) -> Result<Solution, Failure> {
    let method = &arguments.method;
    let solver_options = SolverOptions::default()
        .with_time(method.time.for_source(&input.mesh, source))
        .with_threads(session.threads())
        .with_memory_limit(method.memory_limit);
    let solve_options = SolveOptions::default()
        .with_level_sets(method.level_sets)
        .with_preserve_source_normals(method.preserve_normals)
        .with_sign(method.sign.unwrap_or_default())
        .with_confidence(method.confidence);
    record_options(&solver_options, &solve_options, arguments, session);
    let solver = session.solver("prepare", || Solver::new(&input.mesh, &solver_options))?;
    let solution = session.solver("solve", || solver.solve(source, &solve_options))?;
    let report = &solution.report;
    session.report.phases_of("prepare", &report.preparation.phases);
    session.report.phases_of("solve", &report.phases);
    for warning in report.all_warnings() {
        session.warn(warning);
    }
    let finite = solution.distance.as_slice().iter().copied().filter(|x| x.is_finite());
    let range = finite.map(|x| [x, x]).reduce(|[a, b], [x, _]| [a.min(x), b.max(x)]);
    let (level_sets, weight) = level_sets_words(report.level_sets.level_sets);
    let undefined = solution.distance.as_slice().iter().filter(|x| x.is_nan()).count();
    session.report.result.extend(
        [
            ("distance_min", json!(range.map(|r| r[0]))),
            ("distance_max", json!(range.map(|r| r[1]))),
            ("undefined_vertices", json!(undefined)),
            ("diffusion_time", json!(report.time.time)),
            ("diffusion_time_coefficient", json!(report.time.coefficient)),
            ("diffusion_time_reason", json!(report.time.reason)),
            ("edge_spacing", json!(report.time.edge_spacing)),
            ("level_sets", json!(level_sets)),
            ("soft_weight", weight),
            ("level_sets_reason", json!(report.level_sets.reason)),
            ("stages", json!(report.stages)),
            ("real_frames", json!(report.preparation.real_frames)),
            ("factor_bytes", json!(report.preparation.factor_bytes)),
            ("needed_bytes", json!(report.preparation.needed_bytes)),
            ("diffusion_residual", json!(report.diffusion_residual)),
            ("integration_residual", json!(report.integration_residual)),
            ("constraint_violation", json!(report.constraint_violation)),
            (
                "normal_constraints",
                json!(report.normal_constraints.as_ref().map(|kept| json!({
                    "iterations": kept.iterations, "residual": kept.residual, "tolerance": kept.tolerance,
                }))),
            ),
            ("levels", json!(report.levels)),
            ("source_segments", json!(report.source_segments)),
            ("source_points", json!(report.source_points)),
        ]
        .map(|(key, value)| (key.to_string(), value)),
    );
    if let Some([low, high]) = range {
        let size = high.abs().max(low.abs());
        session.note(&format!(
            "distance from {} to {} at {}, to {} and {}",
            rounded(low, 6, size),
            rounded(high, 6, size),
            counted(input.mesh.vertex_count() - undefined, "vertex", "vertices"),
            counted(report.source_segments, "segment", "segments"),
            counted(report.source_points, "point", "points")
        ));
    }
    session.detail(&format!(
        "diffusion time {:.3e} = {} h² with h = {:.3e} ({})",
        report.time.time,
        brief((1e4 * report.time.coefficient).round() / 1e4),
        report.time.edge_spacing,
        report.time.reason
    ));
    let weight = match report.level_sets.level_sets {
        LevelSets::Soft(w) => format!("={w:.4}"),
        _ => String::new(),
    };
    session.detail(&format!("level sets {level_sets}{weight} ({})", report.level_sets.reason));
    session.detail(&format!(
        "residuals {:.1e} (diffusion) and {:.1e} (integration); factors of {:.1} MB",
        report.diffusion_residual,
        report.integration_residual,
        report.preparation.factor_bytes as f64 / 1e6
    ));
    Ok(solution)
}

/// The level sets as named on the command line, and the weight of soft ones.
fn level_sets_words(level_sets: LevelSets) -> (String, Value) {
    let weight = if let LevelSets::Soft(w) = level_sets { json!(w) } else { Value::Null };
    (level_sets.to_string().split('=').next().unwrap_or_default().to_string(), weight)
}

fn record_options(
    solver: &SolverOptions,
    solve: &SolveOptions,
    arguments: &SdfArguments,
    session: &mut Session,
) {
    let time = match solver.time {
        DiffusionTime::Coefficient(c) => json!(c),
        other => json!(other.to_string()),
    };
    let (level_sets, weight) = level_sets_words(solve.level_sets);
    let sign = solve.sign.to_string();
    session.report.options.extend(
        [
            ("time", time),
            ("level_sets", json!(level_sets)),
            ("soft_weight", weight),
            ("preserve_normals", json!(solve.preserve_source_normals)),
            ("sign", json!(sign)),
            ("confidence", json!(solve.confidence)),
            ("threads", json!(solver.threads)),
            ("memory_limit", json!(solver.memory_limit)),
            ("unsigned", json!(arguments.source.unsigned)),
            ("flip", json!(arguments.source.flip)),
            ("trace", json!(!arguments.source.no_trace)),
        ]
        .map(|(key, value)| (key.to_string(), value)),
    );
}

fn write_outputs(
    arguments: &SdfArguments,
    format: Option<FieldFormat>,
    input: &MeshInput,
    source: &SurfaceCurves,
    solution: &Solution,
    session: &mut Session,
) -> Result<(), Failure> {
    let outputs = &arguments.outputs;
    let distance = solution.distance.as_slice();
    let mut fields = vec![("distance", distance)];
    if let Some(confidence) = &solution.confidence {
        fields.push(("confidence", confidence.confidence.as_slice()));
        fields.push(("distance_to_data", confidence.distance_to_data.as_slice()));
    }
    if let (Some(path), Some(format)) = (&outputs.output, format) {
        output_fields(path, format, input, &fields, session)?;
    }
    let levels = output_isolines(&outputs.isolines, &input.mesh, &solution.distance, session)?;
    if let Some(path) = &outputs.render {
        let levels = levels.map_or(Levels::About(18), Levels::Values);
        let signed = source.curves.iter().any(|c| c.kind == CurveKind::Signed);
        let field = ScalarField {
            title: Some(if signed { "signed distance" } else { "distance" }),
            // The map is fixed: an unsigned distance may be negative by rounding.
            color_map: (!signed).then(ColorMap::viridis),
            ..ScalarField::new(Values::PerVertex(distance))
        };
        let mut scene = Scene::new(&input.mesh, Coloring::Field(field)).with(isolines(levels));
        scene.drawings.extend(curves(&input.mesh, source)?);
        let png = session.phase("render", || draw(scene, &arguments.picture))?;
        session.output("picture", path, png)?;
    }
    Ok(())
}
