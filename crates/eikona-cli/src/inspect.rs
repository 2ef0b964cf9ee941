//! `eikona inspect`: topology, quality and faults of a mesh and of curves on it, with advice.

use crate::exit::Failure;
use crate::input::{MeshArguments, MeshInput};
use crate::number::rounded;
use crate::seams::remedy;
use crate::session::{General, Session, check_outputs, print_bytes};
use crate::source::{SourceArguments, files_read, read_source_if_any, warn_of_sides};
use clap::Args;
use eikona::curves::{CurveReport, MeetingKind};
use eikona::spatial::self_intersections;
use eikona_mesh::{
    Face, Fault, Orientation, PolygonQuality, Quality, Seams, SurfaceCurves, Topology, TriangleMesh, counted,
    slivers, validate,
};
use serde_json::{Map, Value, json};
use std::fmt::Write as _;

/// Arguments of `eikona inspect`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example (the first line makes the file):
  eikona make torus -o torus.ply --flip-faces 0.1
  eikona inspect torus.ply")]
pub struct InspectArguments {
    #[command(flatten)]
    pub mesh: MeshArguments,
    #[command(flatten)]
    pub source: SourceArguments,
    /// Find all pairs of faces that intersect (exact, about 2 us per face)
    #[arg(long)]
    pub self_intersections: bool,
    /// Print JSON to standard output
    #[arg(long)]
    pub json: bool,
    /// List all faults rather than the first 5 of each kind
    #[arg(long)]
    pub all: bool,
}

/// Number of faults listed per kind without `--all`.
const SHOWN: usize = 5;

/// Runs the command and returns the exit code.
pub fn run(arguments: &InspectArguments, general: &General) -> Result<u8, Failure> {
    let mut session = Session::new("inspect", general);
    let files = files_read(&arguments.mesh, &arguments.source);
    check_outputs(general.report.as_deref().as_slice(), &files)?;
    arguments.source.check_sides(&[])?;
    let mesh_arguments = MeshArguments { all_faults: arguments.all, ..arguments.mesh.clone() };
    let input = MeshInput::read(&mesh_arguments, &mut session)?;
    let mesh = &input.mesh;
    if mesh.vertex_count() == 0 {
        input.require_faces()?;
    }
    let topology = session.phase("topology", || Topology::of(mesh));
    let quality = session.phase("quality", || Quality::of(mesh));
    let orientation = session.phase("orientation", || Orientation::of(mesh));
    let seams = session.phase("seams", || Seams::of(mesh));
    let faults = session.phase("faults", || all_faults(mesh, &seams));
    let kinds = by_kind(&faults, &orientation, &seams);

    let mut text = mesh_text(&input, &topology, &quality);
    if let Some(polygons) = &input.polygon_quality {
        text += &polygons_text(polygons);
    }
    text += &faults_text(&kinds, arguments.all);
    let mut facts = Map::new();
    facts.insert("mesh".into(), session.report.input.get("mesh").cloned().unwrap_or_default());
    facts.insert("topology".into(), topology_json(&topology, &orientation));
    facts.insert("quality".into(), quality_json(&quality));
    if let Some(polygons) = &input.polygon_quality {
        facts.insert("polygons".into(), polygons_json(polygons));
    }
    facts.insert("faults".into(), faults_json(&kinds, arguments.all));
    if arguments.self_intersections {
        let threads = session.threads();
        let found = session.solver("self-intersections", || self_intersections(mesh, threads));
        let found = found.map_err(|fault| Failure::Failed(fault.to_string()))?;
        text += &intersections_text(&found, arguments.all);
        let pairs: Vec<[u32; 2]> = found.iter().map(|pair| pair.map(|f| f.0)).collect();
        facts.insert("self_intersections".into(), json!({"count": pairs.len(), "pairs": pairs}));
    }
    if let Some((curves, report)) = read_source_if_any(&arguments.source, &input, &mut session)? {
        text += &curves_text(&curves, &report, arguments.all);
        facts.insert("curves".into(), curves_json(&curves, &report, arguments.all));
    } else {
        warn_of_sides(&arguments.source.about_sides(), &mut session);
    }
    session.report.result = facts.clone();
    if arguments.json {
        text = serde_json::to_string_pretty(&facts).unwrap_or_default() + "\n";
    }
    print_bytes(text.as_bytes())?;
    session.finish()
}

/// All faults of one kind, with advice.
struct Kind<'a> {
    name: &'static str,
    key: &'static str,
    advice: String,
    faults: Vec<&'a Fault>,
}

impl Kind<'_> {
    /// The widest gap, if these are faults with gaps.
    fn largest_gap(&self) -> Option<f64> {
        let gap = |fault: &&Fault| match fault {
            Fault::HangingVertex { gap, .. } | Fault::Crack { gap, .. } => Some(*gap),
            _ => None,
        };
        self.faults.iter().filter_map(gap).reduce(f64::max)
    }
}

/// All faults of a mesh, including unjoined boundaries and slivers. Slivers of zero area are listed
/// only as faces of zero area.
fn all_faults(mesh: &TriangleMesh, seams: &Seams) -> Vec<Fault> {
    let mut faults = validate(mesh);
    faults.extend(seams.faults(mesh));
    let is_zero = |fault: &Fault| if let Fault::ZeroArea { face, .. } = fault { Some(*face) } else { None };
    let zero: Vec<_> = faults.iter().filter_map(is_zero).collect();
    let thin = slivers(mesh).into_iter().filter(|s| zero.binary_search(&s.face).is_err());
    faults.extend(thin.map(|s| Fault::Sliver { face: s.face, height: s.height }));
    faults
}

fn by_kind<'a>(faults: &'a [Fault], orientation: &Orientation, seams: &Seams) -> Vec<Kind<'a>> {
    let mut kinds: Vec<Kind> = Vec::new();
    for fault in faults {
        let (name, key) = kind_of(fault);
        match kinds.iter_mut().find(|k| k.key == key) {
            Some(kind) => kind.faults.push(fault),
            None => {
                kinds.push(Kind { name, key, advice: advice(fault, orientation, seams), faults: vec![fault] })
            }
        }
    }
    kinds
}

fn kind_of(fault: &Fault) -> (&'static str, &'static str) {
    match fault {
        Fault::NonFinitePosition { .. } => ("vertices with non-finite positions", "non_finite_positions"),
        Fault::IndexOutOfRange { .. } => ("faces with a vertex index out of range", "indices_out_of_range"),
        Fault::RepeatedVertex { .. } => ("faces that repeat a vertex", "repeated_vertices"),
        Fault::TooFewCorners { .. } => ("faces with fewer than 3 corners", "too_few_corners"),
        Fault::ZeroArea { .. } => ("faces of zero area", "zero_area_faces"),
        Fault::UnreferencedVertex { .. } => ("unreferenced vertices", "unreferenced_vertices"),
        Fault::NonmanifoldEdge { .. } => ("edges with more than two faces", "nonmanifold_edges"),
        Fault::NonmanifoldVertex { .. } => ("vertices with several vertex fans", "nonmanifold_vertices"),
        Fault::InconsistentOrientation { .. } => {
            ("edges between inconsistently oriented faces", "inconsistent_edges")
        }
        Fault::DuplicateFace { .. } => ("duplicate faces", "duplicate_faces"),
        Fault::CoincidentVertices { .. } => {
            ("vertices at the position of another one", "coincident_vertices")
        }
        Fault::HangingVertex { .. } => {
            ("vertices inside edges of other faces (T-junctions)", "hanging_vertices")
        }
        Fault::Crack { .. } => ("boundary vertices at a small gap from another one (cracks)", "cracks"),
        Fault::Sliver { .. } => ("faces of almost zero height (slivers)", "slivers"),
        _ => ("other faults", "other"),
    }
}

fn advice(fault: &Fault, orientation: &Orientation, seams: &Seams) -> String {
    match fault {
        Fault::ZeroArea { .. } => {
            "sdf handles them; --drop-degenerate removes them (add --weld if the mesh has slits)".into()
        }
        Fault::UnreferencedVertex { .. } => "harmless; values at them are NaN".into(),
        Fault::NonmanifoldEdge { .. } => {
            "sdf handles them; a curve along such an edge has a left side in each of its faces".into()
        }
        Fault::NonmanifoldVertex { .. } => "sdf handles them; distance continues through them as from a \
         point source"
            .into(),
        Fault::InconsistentOrientation { .. } if orientation.is_orientable() => format!(
            "sdf flips {} internally; repair the file if other programs need it",
            counted(orientation.flipped_faces().len(), "face", "faces")
        ),
        Fault::InconsistentOrientation { .. } => {
            "the surface is not orientable: give signed curves an `up` direction in JSON, or use --unsigned"
                .into()
        }
        Fault::DuplicateFace { .. } => {
            "remove the copies, unless the surface is meant to have two sheets".into()
        }
        Fault::CoincidentVertices { .. } => "add --weld to connect the surface there".into(),
        Fault::HangingVertex { .. } | Fault::Crack { .. } => {
            let more = if seams.truncated { "there are more; " } else { "" };
            format!("{more}the surface is disconnected there; {}", remedy(seams))
        }
        Fault::Sliver { .. } => {
            "harmless if there are few; distance loses accuracy in regions full of them, which should be \
             remeshed"
                .into()
        }
        _ => "correct the file".into(),
    }
}

fn mesh_text(input: &MeshInput, topology: &Topology, quality: &Quality) -> String {
    let mesh = &input.mesh;
    let mut text = String::new();
    let mut triangles = counted(mesh.face_count(), "triangle", "triangles");
    if !input.file.mesh.is_triangular() {
        triangles += &format!(" from {}", counted(input.file.mesh.face_count(), "polygon", "polygons"));
    }
    let _ = writeln!(
        text,
        "{}: {}, {}, {triangles}",
        input.path.display(),
        counted(mesh.vertex_count(), "vertex", "vertices"),
        counted(mesh.edge_count(), "edge", "edges")
    );
    if mesh.face_count() == 0 {
        let _ = writeln!(text, "  surface      none: the mesh has vertices but no faces, which sdf needs");
    } else {
        let _ = writeln!(text, "  surface      {}", surface_words(topology));
    }
    if topology.components.len() > 1 {
        for (i, c) in topology.components.iter().enumerate().take(SHOWN) {
            let genus = c.genus.map_or(String::new(), |g| format!(", genus {g}"));
            let _ = writeln!(
                text,
                "    component {i}: {} from face {}, {}{genus}",
                counted(c.face_count, "face", "faces"),
                c.first_face.0,
                counted(c.boundary_loop_count, "boundary loop", "boundary loops")
            );
        }
        if topology.components.len() > SHOWN {
            let _ = writeln!(text, "    and {} more", topology.components.len() - SHOWN);
        }
    }
    if let Some([low, high]) = quality.bounding_box {
        let size = [0, 1, 2].map(|k| high[k] - low[k]);
        let _ = writeln!(text, "  box          {}, from ({})", together(size, " x "), together(low, ", "));
    }
    let _ = writeln!(text, "  area         {}", rounded(quality.area, 6, quality.area));
    if let Some(l) = quality.edge_length {
        let _ = writeln!(text, "  edges        {:.3e} to {:.3e}, mean {:.3e}", l.min, l.max, l.mean);
    }
    if let (Some(min), Some(percentile), Some(max)) =
        (quality.min_angle_deg, quality.min_angle_percentile_1_deg, quality.max_angle_deg)
    {
        let _ = writeln!(
            text,
            "  angles       {}° to {max:.3}°; smallest angle at least {}° in 99 % of the faces",
            rounded(min, 3, min),
            rounded(percentile, 3, percentile)
        );
    }
    if let Some(a) = quality.aspect_ratio {
        let _ = writeln!(text, "  aspect       mean {:.2}, worst {:.3e} (1 is equilateral)", a.mean, a.max);
    }
    let _ = writeln!(text, "  non-Delaunay {} of {} edges", quality.non_delaunay_edges, mesh.edge_count());
    let names: Vec<&str> = input.file.vertex_scalars.iter().map(|s| s.0.as_str()).collect();
    if !names.is_empty() {
        let _ = writeln!(text, "  fields       {}", names.join(", "));
    }
    text
}

/// Reported kinds of polygons: words, JSON key, and the polygons.
fn polygon_kinds(polygons: &PolygonQuality) -> [(&'static str, &'static str, &[Face]); 4] {
    [
        ("not convex", "nonconvex", &polygons.nonconvex),
        ("not planar", "nonplanar", &polygons.nonplanar),
        ("self-crossing", "self_crossing", &polygons.self_crossing),
        ("collinear", "collinear", &polygons.collinear),
    ]
}

fn polygons_text(polygons: &PolygonQuality) -> String {
    let mut parts = Vec::new();
    for (words, key, faces) in polygon_kinds(polygons) {
        let Some(first) = faces.first() else { continue };
        let off = if key == "nonplanar" {
            format!(", by up to {:.1e} of the polygon's size", polygons.largest_deviation)
        } else {
            String::new()
        };
        parts.push(format!("{} {words} (first: {first}{off})", faces.len()));
    }
    let parts = if parts.is_empty() { "all convex and planar".into() } else { parts.join(", ") };
    format!("  polygons     {parts}\n")
}

fn polygons_json(polygons: &PolygonQuality) -> Value {
    let entry = |faces: &[Face]| json!({"count": faces.len(), "first": faces.first().map(|f| f.0)});
    let mut all: Map<String, Value> =
        polygon_kinds(polygons).iter().map(|(_, key, faces)| (key.to_string(), entry(faces))).collect();
    all.insert("largest_deviation".into(), json!(polygons.largest_deviation));
    Value::Object(all)
}

/// Formats three numbers to the same precision.
fn together(numbers: [f64; 3], between: &str) -> String {
    let largest = numbers.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    numbers.map(|x| rounded(x, 6, largest)).join(between)
}

fn surface_words(topology: &Topology) -> String {
    let components = match topology.components.len() {
        1 => "1 component".to_string(),
        n => format!("{n} components"),
    };
    let loops = match topology.boundary_loops.len() {
        0 => "closed".to_string(),
        1 => "1 boundary loop".to_string(),
        n => format!("{n} boundary loops"),
    };
    let mut words =
        vec![components, loops, format!("Euler characteristic {}", topology.euler_characteristic)];
    if let [only] = topology.components.as_slice() {
        words.extend(only.genus.map(|g| format!("genus {g}")));
        words.extend(
            only.nonorientable_genus.map(|k| format!("{k} crosscap{}", if k == 1 { "" } else { "s" })),
        );
    }
    words.push(if topology.is_orientable() { "orientable" } else { "not orientable" }.into());
    words.push(if topology.is_manifold() { "manifold" } else { "not manifold" }.into());
    words.join(", ")
}

fn faults_text(kinds: &[Kind], all: bool) -> String {
    if kinds.is_empty() {
        return "  faults       none\n".into();
    }
    let mut text = String::from("  faults\n");
    for kind in kinds {
        let gap = match kind.largest_gap() {
            Some(gap) if gap > 0.0 => format!(", widest gap {gap:.1e}"),
            _ => String::new(),
        };
        let _ = writeln!(text, "    {} {}{gap}: {}", kind.faults.len(), kind.name, kind.advice);
        let shown = if all { kind.faults.len() } else { SHOWN };
        for fault in kind.faults.iter().take(shown) {
            let _ = writeln!(text, "      {fault}");
        }
        if kind.faults.len() > shown {
            let _ = writeln!(text, "      and {} more (--all lists them)", kind.faults.len() - shown);
        }
    }
    text
}

fn intersections_text(pairs: &[[Face; 2]], all: bool) -> String {
    if pairs.is_empty() {
        return "  crossings    no two faces intersect\n".into();
    }
    let mut text =
        format!("  crossings    {} intersect\n", counted(pairs.len(), "pair of faces", "pairs of faces"));
    let shown = if all { pairs.len() } else { SHOWN };
    for [f, g] in pairs.iter().take(shown) {
        let _ = writeln!(text, "      {f} and {g}");
    }
    if pairs.len() > shown {
        let _ = writeln!(text, "      and {} more (--all lists them)", pairs.len() - shown);
    }
    text
}

fn topology_json(topology: &Topology, orientation: &Orientation) -> Value {
    let components: Vec<Value> = topology
        .components
        .iter()
        .map(|c| {
            json!({
                "first_face": c.first_face.0, "vertices": c.vertex_count, "edges": c.edge_count, "faces": c.face_count,
                "boundary_loops": c.boundary_loop_count, "euler_characteristic": c.euler_characteristic,
                "manifold": c.manifold, "orientable": c.orientable, "genus": c.genus,
                "nonorientable_genus": c.nonorientable_genus,
            })
        })
        .collect();
    json!({
        "components": components,
        "boundary_loops": topology.boundary_loops.iter().map(|l| l.halfedges.len()).collect::<Vec<_>>(),
        "euler_characteristic": topology.euler_characteristic,
        "manifold": topology.is_manifold(), "orientable": topology.is_orientable(), "closed": topology.is_closed(),
        "consistently_oriented": orientation.is_consistent(), "faces_to_flip": orientation.flipped_faces().len(),
    })
}

fn quality_json(quality: &Quality) -> Value {
    let range =
        |r: Option<eikona_mesh::Range>| r.map(|r| json!({"min": r.min, "mean": r.mean, "max": r.max}));
    json!({
        "edge_length": range(quality.edge_length), "area": quality.area, "bounding_box": quality.bounding_box,
        "min_angle_deg": quality.min_angle_deg, "min_angle_percentile_1_deg": quality.min_angle_percentile_1_deg,
        "max_angle_deg": quality.max_angle_deg, "aspect_ratio": range(quality.aspect_ratio),
        "aspect_ratio_percentile_99": quality.aspect_ratio_percentile_99,
        "non_delaunay_edges": quality.non_delaunay_edges, "zero_area_faces": quality.zero_area_faces,
    })
}

fn faults_json(kinds: &[Kind], all: bool) -> Value {
    let entry = |kind: &Kind| {
        let shown = if all { kind.faults.len() } else { SHOWN };
        let list: Vec<String> = kind.faults.iter().take(shown).map(|f| f.to_string()).collect();
        let mut entry = json!({"count": kind.faults.len(), "advice": kind.advice, "first": list});
        if let Some(gap) = kind.largest_gap() {
            entry["largest_gap"] = json!(gap);
        }
        entry
    };
    Value::Object(kinds.iter().map(|k| (k.key.to_string(), entry(k))).collect())
}

fn curves_text(curves: &SurfaceCurves, report: &CurveReport, all: bool) -> String {
    let mut text = String::new();
    let length = |x: f64| rounded(x, 6, x);
    let _ = writeln!(
        text,
        "curves: {} with {}, length {}; {}",
        curves.curves.len(),
        counted(curves.segment_count(), "segment", "segments"),
        length(report.length()),
        counted(curves.points.len(), "isolated point", "isolated points")
    );
    let shown = if all { usize::MAX } else { SHOWN };
    for (i, (curve, facts)) in curves.curves.iter().zip(&report.curves).enumerate().take(shown) {
        let kind = if curve.kind == eikona_mesh::CurveKind::Signed { "signed" } else { "unsigned" };
        let closed = if facts.closed { "closed" } else { "open" };
        let _ = writeln!(
            text,
            "  curve {i}: {kind}, {closed}, {}, length {}",
            counted(curve.nodes.len(), "node", "nodes"),
            length(facts.length)
        );
    }
    if curves.curves.len() > shown {
        let _ = writeln!(text, "  and {} more (--all lists them)", curves.curves.len() - shown);
    }
    let gaps: Vec<f64> = report.open_ends.iter().filter_map(|e| Some(e.nearest?.1)).collect();
    if !report.open_ends.is_empty() {
        let largest = gaps.iter().fold(0.0f64, |a, b| a.max(*b));
        let _ = writeln!(
            text,
            "  {}; the nearest other end is at most {} away",
            counted(report.open_ends.len(), "open end", "open ends"),
            length(largest)
        );
    }
    for (kind, one, several) in [
        (MeetingKind::Crossing, "crossing inside a face", "crossings inside faces"),
        (MeetingKind::SharedNode, "node visited more than once", "nodes visited more than once"),
        (MeetingKind::Touching, "node that touches another segment", "nodes that touch another segment"),
    ] {
        let found: Vec<_> = report.meetings.iter().filter(|m| m.kind == kind).collect();
        if let Some(first) = found.first() {
            let place = together(first.position, ", ");
            let _ = writeln!(text, "  {} (first: {place})", counted(found.len(), one, several));
        }
    }
    if !report.overlaps.is_empty() {
        let sum = length(report.overlaps.iter().map(|d| d.length).sum());
        let pieces = counted(report.overlaps.len(), "piece", "pieces");
        let _ = writeln!(text, "  {pieces} covered twice, total length {sum}");
    }
    text
}

fn curves_json(curves: &SurfaceCurves, report: &CurveReport, all: bool) -> Value {
    let listed = if all { usize::MAX } else { SHOWN };
    let each: Vec<Value> = curves
        .curves
        .iter()
        .zip(&report.curves)
        .map(|(curve, facts)| {
            json!({
                "kind": curve.kind, "nodes": curve.nodes.len(), "length": facts.length, "closed": facts.closed,
                "one_sided": facts.one_sided, "zero_length_segments": facts.zero_length.len(),
            })
        })
        .collect();
    let ends: Vec<Value> = report
        .open_ends
        .iter()
        .map(|e| {
            let nearest = e.nearest.map(|n| json!({"end": n.0, "distance": n.1}));
            json!({"curve": e.curve, "last": e.last, "position": e.position, "nearest": nearest})
        })
        .collect();
    let meetings: Vec<Value> = report
        .meetings
        .iter()
        .take(listed)
        .map(|m| {
            let segments = m.segments.map(|s| json!({"curve": s.curve, "node": s.node}));
            json!({"kind": format!("{:?}", m.kind), "position": m.position, "segments": segments})
        })
        .collect();
    json!({
        "curves": each, "points": curves.points.len(), "segments": curves.segment_count(), "length": report.length(),
        "open_ends": ends, "meeting_count": report.meetings.len(), "meetings": meetings,
        "overlaps": report.overlaps.len(), "truncated": report.truncated,
    })
}
