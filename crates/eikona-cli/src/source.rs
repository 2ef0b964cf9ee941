//! The source curves and points: read from files, projected to the mesh and traced across its
//! faces.

use crate::exit::Failure;
use crate::input::{MeshArguments, MeshInput};
use crate::make::CURVE_NAMES;
use crate::session::Session;
use crate::warned::Warned;
use clap::Args;
use eikona::curves::{CurveReport, DEFAULT_TOLERANCE, TraceError, Traced, trace_curve, trace_polyline};
use eikona::spatial::Bvh;
use eikona_mesh::io::without_gzip;
use eikona_mesh::{
    Curve, CurveError, CurveFile, CurveFormat, CurveKind, Located, Quality, SpacePolyline, SurfaceCurves,
    SurfacePoint, TriangleMesh, counted, curve_text, curves_from_lines, read_curves_bytes, segment_host,
};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Input curves and points.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Curves and points")]
pub struct SourceArguments {
    /// Curve file: eikona's JSON, OBJ with `l` lines, or the text formats of signed-heat-demo and
    /// SWN; may be repeated. Without it and --points, the `l` lines of the mesh's own OBJ file are
    /// used
    #[arg(long, value_name = "FILE")]
    pub curve: Vec<PathBuf>,
    /// Isolated points: vertex numbers from 0 ("12,40"), or a curve file, of which only the points
    /// are used; may be repeated
    #[arg(long, value_name = "V,V,..|FILE", allow_hyphen_values = true, value_parser = parse_points)]
    pub points: Vec<Points>,
    /// Treat all curves as unsigned: the distance is positive on both sides
    #[arg(long, conflicts_with = "flip")]
    pub unsigned: bool,
    /// Reverse all curves, which swaps left and right
    #[arg(long)]
    pub flip: bool,
    /// Trace segments that span several faces, and polylines in space, over the mesh (default)
    #[arg(long, overrides_with = "no_trace")]
    pub trace: bool,
    /// Fail for curves that need tracing
    #[arg(long)]
    pub no_trace: bool,
}

/// Isolated points, as given on the command line.
#[derive(Clone, Debug, PartialEq)]
pub enum Points {
    /// Vertex numbers of the mesh file.
    Vertices(Vec<u32>),
    /// A curve file.
    File(PathBuf),
}

fn parse_points(text: &str) -> Result<Points, String> {
    let is_list = text.chars().all(|c| c.is_ascii_digit() || c == ',' || c.is_whitespace());
    let is_number = !text.is_empty() && text.split(',').all(|word| word.trim().parse::<f64>().is_ok());
    if !is_list && (Path::new(text).exists() || !is_number) {
        return Ok(Points::File(text.into()));
    }
    const EXPECTED: &str = "expected vertex numbers from 0, such as 12,40, or a curve file";
    let mut vertices = Vec::new();
    for words in text.split(',') {
        if words.trim().is_empty() {
            return Err(format!("a number is missing before or after a comma; {EXPECTED}"));
        }
        for word in words.split_whitespace() {
            let vertex = word.parse().map_err(|_| format!("{word} is not a vertex number; {EXPECTED}"))?;
            vertices.push(vertex);
        }
    }
    Ok(Points::Vertices(vertices))
}

impl SourceArguments {
    /// The given options that concern the sides of curves.
    pub fn about_sides(&self) -> Vec<&'static str> {
        let flags = [(self.flip, "--flip"), (self.unsigned, "--unsigned")];
        flags.into_iter().filter(|(given, _)| *given).map(|(_, flag)| flag).collect()
    }

    /// Fails for options about curves, including `more`, if only points are given.
    pub fn check_sides(&self, more: &[&str]) -> Result<(), Failure> {
        let flags = self.about_sides();
        match flags.iter().chain(more).next() {
            Some(flag) if self.curve.is_empty() && !self.points.is_empty() => Err(Failure::Usage(format!(
                "{flag} needs curves, but there is only --points; leave it out, or add --curve FILE"
            ))),
            _ => Ok(()),
        }
    }
}

/// The input files of these arguments.
pub fn files_read<'a>(mesh: &'a MeshArguments, source: &'a SourceArguments) -> Vec<&'a Path> {
    let points = source.points.iter().filter_map(|points| match points {
        Points::File(path) => Some(path),
        Points::Vertices(_) => None,
    });
    [&mesh.mesh].into_iter().chain(&source.curve).chain(points).map(PathBuf::as_path).collect()
}

/// Warns that these options have no effect without a signed curve.
pub fn warn_of_sides(flags: &[&str], session: &mut Session) {
    for flag in flags {
        let sentence = format!("{flag} has no effect: there is no signed curve");
        session.warn(Warned::new("idle_option", sentence));
    }
}

/// Polylines farther from the mesh than this share of its longest side are reported.
const FAR: f64 = 0.01;

/// Reads the source and traces it, so that each segment lies in one face.
pub fn read_source(
    arguments: &SourceArguments,
    input: &MeshInput,
    session: &mut Session,
) -> Result<(SurfaceCurves, CurveReport), Failure> {
    let mut curves = SurfaceCurves::default();
    let mut facts: Vec<Value> = Vec::new();
    for path in &arguments.curve {
        let file = read_curve_file(path, input, session)?;
        if file.curves.is_empty() && file.polylines.is_empty() {
            return Err(Failure::curve(path, "this file contains no curve; check that it is the right file"));
        }
        let added = bring_to_mesh(file, path, arguments, input, session, &mut facts)?;
        curves.curves.extend(added.curves);
        curves.points.extend(added.points);
    }
    for points in &arguments.points {
        curves.points.extend(read_points(points, arguments, input, session)?);
    }
    if arguments.curve.is_empty() && arguments.points.is_empty() && !input.file.lines.is_empty() {
        let path = input.path.clone();
        let file = own_lines(input, session)?;
        let added = bring_to_mesh(file, &path, arguments, input, session, &mut facts)?;
        curves.curves.extend(added.curves);
        curves.points.extend(added.points);
    }
    if curves.is_empty() {
        return Err(eikona::signed_heat::SignedHeatError::Curve(CurveError::Empty).into());
    }
    if !curves.curves.iter().any(|c| c.kind == CurveKind::Signed) {
        warn_of_sides(&arguments.about_sides(), session);
    }
    if arguments.unsigned {
        curves.curves.iter_mut().for_each(|c| c.kind = CurveKind::Unsigned);
    }
    if arguments.flip {
        curves.curves = curves.curves.into_iter().map(Curve::reversed).collect();
    }
    let report = session
        .phase("check curve", || CurveReport::of(&input.mesh, &curves))
        .map_err(|e| Failure::Input(e.to_string()))?;
    for warning in &report.warnings(&curves) {
        session.warn(warning);
    }
    session.report.input.insert("curves".into(), Value::Array(facts));
    session.report.input.insert(
        "source".into(),
        json!({
            "curves": curves.curves.len(), "segments": curves.segment_count(), "points": curves.points.len(),
            "length": report.length(), "open_ends": report.open_ends.len(),
        }),
    );
    Ok((curves, report))
}

/// The curves from the `l` lines of the mesh file. Those off the surface are left out; fails if
/// none remain.
fn own_lines(input: &MeshInput, session: &mut Session) -> Result<CurveFile, Failure> {
    let path = &input.path;
    let mut file = curves_from_lines(&input.lines(), &input.mesh).map_err(|e| Failure::curve(path, e))?;
    session.note(&format!("using the {} line elements of the mesh file as curves", input.file.lines.len()));
    for warning in &file.warnings {
        session.warn(Warned::from(warning).about(path.display()));
    }
    if file.polylines.is_empty() {
        if file.curves.is_empty() {
            return Err(Failure::curve(
                path,
                "the `l` lines of this file contain no curve on its surface; give a curve with --curve FILE \
                 or points with --points",
            ));
        }
        return Ok(file);
    }
    let bvh = session.phase("build search tree", || Bvh::new(&input.mesh));
    let off_surface = |line: &SpacePolyline| {
        let off = |p: &[f64; 3]| bvh.closest_point(*p).map_or(f64::INFINITY, |closest| closest.distance);
        line.points.iter().map(off).fold(0.0, f64::max)
    };
    let offs: Vec<f64> = file.polylines.iter().map(off_surface).collect();
    let is_far = |off: f64| off > FAR * longest_side(input);
    let far: Vec<f64> = offs.iter().copied().filter(|&off| is_far(off)).collect();
    let Some(&first) = far.first() else { return Ok(file) };
    if far.len() == file.polylines.len() && file.curves.is_empty() {
        return Err(Failure::curve(
            path,
            format!(
                "the `l` lines of this file lie off its surface, the first by {first:.3e}; give a curve \
                 with --curve FILE or points with --points"
            ),
        ));
    }
    let sentence =
        format!("left out {} polylines that lie off the surface, the first by {first:.3e}", far.len());
    let warned = Warned::new("lines_off_surface", sentence).about(path.display());
    session.warn(warned.with("count", far.len()).with("distance", first));
    let mut offs = offs.into_iter();
    file.polylines.retain(|_| !offs.next().is_some_and(is_far));
    Ok(file)
}

/// Like [`read_source`], for commands that need no source: invalid `l` lines of the mesh file only
/// give a warning.
pub fn read_source_if_any(
    arguments: &SourceArguments,
    input: &MeshInput,
    session: &mut Session,
) -> Result<Option<(SurfaceCurves, CurveReport)>, Failure> {
    if !arguments.curve.is_empty() || !arguments.points.is_empty() {
        return read_source(arguments, input, session).map(Some);
    }
    if input.file.lines.is_empty() {
        return Ok(None);
    }
    match read_source(arguments, input, session) {
        Ok(found) => Ok(Some(found)),
        Err(Failure::Input(fault)) => {
            let sentence = format!("{fault}; ignored the `l` lines of this file");
            session.warn(Warned::new("invalid_lines", sentence));
            Ok(None)
        }
        Err(failure) => Err(failure),
    }
}

/// Reads a curve file, without tracing.
pub fn read_curve_file(path: &Path, input: &MeshInput, session: &mut Session) -> Result<CurveFile, Failure> {
    let bytes = std::fs::read(path).map_err(|e| match path.to_str().filter(|name| CURVE_NAMES.contains(name)) {
        Some(name) => Failure::Input(format!(
            "{name}: no such file; {name} names a curve that `make` writes to a file: eikona make SHAPE -o \
             MESH --curve {name} --curve-out {name}.json"
        )),
        None => Failure::reading(path, eikona_mesh::FileError::io(path, e)),
    })?;
    let bytes = without_gzip(bytes, &path.display().to_string()).map_err(|e| Failure::reading(path, e))?;
    let bytes = curve_text(&bytes).into_bytes();
    let format = CurveFormat::detect(path, &bytes);
    let numbered = matches!(format, CurveFormat::SignedHeatDemo | CurveFormat::SurfaceWinding);
    if numbered {
        refuse_numbers(path, &bytes, input)?;
    }
    let mesh = if numbered { input.mesh_for_numbers() } else { input.mesh_for_curves() };
    let read = session.phase("read curve", || read_curves_bytes(&bytes, format, mesh));
    let mut file = read.map_err(|e| Failure::reading(path, e))?;
    let nodes = file.curves.curves.iter().flat_map(|c| &c.nodes).chain(&file.curves.points);
    nodes.copied().try_for_each(|p| input.check_of_file(p)).map_err(|e| Failure::curve(path, e))?;
    for warning in &file.warnings {
        session.warn(Warned::from(warning).about(path.display()));
    }
    for curve in &mut file.curves.curves {
        curve.nodes.iter_mut().for_each(|p| *p = input.renumber(*p));
    }
    file.curves.points.iter_mut().for_each(|p| *p = input.renumber(*p));
    Ok(file)
}

/// Fails for edge and face numbers in a text file that are ambiguous for this mesh.
fn refuse_numbers(path: &Path, bytes: &[u8], input: &MeshInput) -> Result<(), Failure> {
    let (words, why): (&[&str], _) = if !input.file.mesh.is_triangular() {
        (
            &["e", "f"],
            "names an edge or face of a polygon mesh by number, but polygons are triangulated first",
        )
    } else if input.has_placeholders() {
        (
            &["e"],
            "names an edge by number, but edge numbers are ambiguous: the mesh has faces that repeat a \
             vertex or have too few corners",
        )
    } else {
        return Ok(());
    };
    let text = String::from_utf8_lossy(bytes);
    let numbered = |line: &str| line.split_whitespace().next().is_some_and(|word| words.contains(&word));
    match text.lines().position(numbered) {
        Some(line) => Err(Failure::curve(
            path,
            format!(
                "line {} {why}; name vertices instead (v i, or JSON with the edge's vertices), or give a \
                 polyline in space",
                line + 1
            ),
        )),
        None => Ok(()),
    }
}

fn read_points(
    points: &Points,
    arguments: &SourceArguments,
    input: &MeshInput,
    session: &mut Session,
) -> Result<Vec<SurfacePoint>, Failure> {
    let numbers = match points {
        Points::Vertices(numbers) => numbers,
        Points::File(path) if !path.exists() => {
            return Err(Failure::Input(format!(
                "--points {}: no such file, and not a list of vertex numbers such as 12,40",
                path.display()
            )));
        }
        Points::File(path) => {
            let file = read_curve_file(path, input, session)?;
            if file.curves.points.is_empty() {
                return Err(Failure::curve(
                    path,
                    "this file contains no isolated points; pass its curves with --curve",
                ));
            }
            file.curves.located_points(&input.mesh).map_err(|e| Failure::curve(path, e))?;
            let left_out = file.curves.curves.len() + file.polylines.len();
            if left_out > 0 && !arguments.curve.contains(path) {
                let path = path.display();
                let counted = counted(left_out, "curve", "curves");
                let sentence =
                    format!("{path} has {counted}, which --points ignores; --curve {path} uses both");
                session.warn(Warned::new("ignored_curves", sentence).with("count", left_out));
            }
            return Ok(file.curves.points);
        }
    };
    let vertices = input.mesh_for_curves().vertex_count();
    let point = |&vertex: &u32| {
        if vertex as usize >= vertices {
            return Err(Failure::Input(format!(
                "--points: vertex {vertex} does not exist: the mesh has {vertices} vertices, numbered from 0 to {}",
                vertices.saturating_sub(1)
            )));
        }
        Ok(input.renumber(SurfacePoint::Vertex { vertex }))
    };
    numbers.iter().map(point).collect()
}

/// Traces segments that cross faces, and polylines in space.
fn bring_to_mesh(
    file: CurveFile,
    path: &Path,
    arguments: &SourceArguments,
    input: &MeshInput,
    session: &mut Session,
    facts: &mut Vec<Value>,
) -> Result<SurfaceCurves, Failure> {
    let name = path.display();
    let mesh = &input.mesh;
    let across = session.phase("locate curve", || first_across(mesh, &file.curves));
    let across = across.map_err(|e| Failure::curve(path, e))?;
    let mut result = SurfaceCurves { curves: Vec::new(), points: file.curves.points };
    let mut traced_curves = 0;
    for (c, (curve, across)) in file.curves.curves.into_iter().zip(across).enumerate() {
        let Some(node) = across else {
            result.curves.push(curve);
            continue;
        };
        if arguments.no_trace {
            return Err(Failure::curve(path, CurveError::SegmentAcrossFaces.at(c, node)));
        }
        let traced = session.phase("trace curve", || trace_curve(mesh, &curve));
        let traced = traced.map_err(|e| Failure::curve(path, format!("curve {c}: {}", of_one_curve(e))))?;
        report_trace(&traced, &format!("{name}: curve {c}"), session);
        traced_curves += 1;
        result.curves.push(traced.curve);
    }
    let mut largest: f64 = 0.0;
    let lines = file.polylines;
    if let (Some(_), true) = (lines.first(), arguments.no_trace) {
        return Err(Failure::curve(
            path,
            "polyline 0 lies in space and must be projected and traced; leave out --no-trace",
        ));
    }
    if !lines.is_empty() {
        let bvh = session.phase("build search tree", || Bvh::new(mesh));
        for (c, line) in lines.iter().enumerate() {
            let traced = session.phase("trace curve", || trace_line(line, input, &bvh));
            let traced =
                traced.map_err(|e| Failure::curve(path, format!("polyline {c}: {}", of_one_curve(e))))?;
            report_trace(&traced, &format!("{name}: polyline {c}"), session);
            largest = largest.max(traced.largest_projection_distance);
            result.curves.push(traced.curve);
        }
        warn_if_far(path, largest, input, session);
    }
    if traced_curves + lines.len() > 0 {
        session.detail(&format!(
            "{name}: traced {}; points in space are at most {largest:.3e} from the mesh",
            counted(traced_curves + lines.len(), "curve", "curves")
        ));
    }
    facts.push(json!({
        "path": name.to_string(), "curves": result.curves.len(), "points": result.points.len(),
        "traced": traced_curves + lines.len(), "largest_projection_distance": largest,
    }));
    Ok(result)
}

/// For each curve, the first node whose segment does not lie in one face.
fn first_across(mesh: &TriangleMesh, curves: &SurfaceCurves) -> Result<Vec<Option<usize>>, CurveError> {
    curves.located_points(mesh)?;
    let first = |(c, curve): (usize, &Curve)| {
        let nodes = curve.nodes.iter().enumerate();
        let nodes: Vec<Located> =
            nodes.map(|(n, p)| p.locate(mesh).map_err(|e| e.at(c, n))).collect::<Result<_, _>>()?;
        let across = |p: &[Located]| p[0] != p[1] && segment_host(mesh, p[0], p[1]).is_none();
        Ok(nodes.windows(2).position(across))
    };
    curves.curves.iter().enumerate().map(first).collect()
}

fn trace_line(line: &SpacePolyline, input: &MeshInput, bvh: &Bvh) -> Result<Traced, TraceError> {
    trace_polyline(&input.mesh, bvh, &line.points, line.closed, line.kind, DEFAULT_TOLERANCE)
}

/// The fault without its curve number, which counts only the traced curve; the caller adds the
/// right one.
fn of_one_curve(fault: TraceError) -> String {
    match fault {
        TraceError::Curve(CurveError::AtNode { node, fault, .. }) => format!("node {node}: {fault}"),
        fault => fault.to_string(),
    }
}

fn report_trace(traced: &Traced, what: &str, session: &mut Session) {
    for warning in &traced.warnings() {
        session.warn(Warned::from(warning).about(what));
    }
}

/// The longest side of the bounding box.
fn longest_side(input: &MeshInput) -> f64 {
    let Some([low, high]) = Quality::of(&input.mesh).bounding_box else { return 0.0 };
    (0..3).fold(0.0f64, |s, k| s.max(high[k] - low[k]))
}

fn warn_if_far(path: &Path, largest: f64, input: &MeshInput, session: &mut Session) {
    let size = longest_side(input);
    if largest > FAR * size {
        let sentence = format!(
            "a point of the curve lies {largest:.3e} from the mesh, whose bounding box has a longest side of \
             {size:.3e}; check that curve and mesh belong together and have the same unit"
        );
        session
            .warn(Warned::new("curve_off_surface", sentence).about(path.display()).with("distance", largest));
    }
}
