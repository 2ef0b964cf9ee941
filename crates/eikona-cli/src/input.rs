//! The mesh that a verb works on: read from a file or the standard input, repaired where that was asked for, triangulated.

use crate::exit::Failure;
use crate::session::Session;
use clap::Args;
use eikona_mesh::io::{MeshFile, MeshFormat, MeshOut, read_mesh, read_mesh_bytes, without_gzip};
use eikona_mesh::{
    Fault, IndexMaps, MeshError, PolygonMesh, SurfacePoint, TriangleMesh, Vertex, drop_broken_polygons,
    drop_degenerate_faces, weld_polygons,
};
use serde_json::{Value, json};
use std::io::Read;
use std::path::{Path, PathBuf};

/// The mesh file and what is to be repaired in it.
#[derive(Args, Clone, Debug)]
pub struct MeshArguments {
    /// The mesh: .obj, .ply, .stl, .off, .glb, .gltf or .vtp, also with .gz; - for the standard input
    #[arg(value_name = "MESH")]
    pub mesh: PathBuf,
    /// Format of the standard input, when its content does not tell it: obj, ply, stl, off, glb, gltf, vtp
    #[arg(long, value_name = "FORMAT", value_parser = parse_format)]
    pub in_format: Option<MeshFormat>,
    /// Join vertices at the same place, or at most TOL apart (in the unit of the mesh). STL files, which hold loose triangles,
    /// are joined at equal places unless `--weld=off` is given
    #[arg(long, value_name = "TOL|off", num_args = 0..=1, require_equals = true, default_missing_value = "0", value_parser = parse_weld)]
    pub weld: Option<Weld>,
    /// Drop faces without area and faces that name a vertex twice; the vertices stay
    #[arg(long)]
    pub drop_degenerate: bool,
    /// Whether a mesh that is not valid is refused with all its faults rather than the first few.
    #[arg(skip)]
    pub all_faults: bool,
}

/// Whether vertices are joined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weld {
    /// Not even those of an STL file.
    Off,
    /// Those at most this far apart.
    Within(f64),
}

fn parse_weld(text: &str) -> Result<Weld, String> {
    match text {
        "off" => Ok(Weld::Off),
        _ => match text.parse::<f64>() {
            Ok(tolerance) if tolerance >= 0.0 && tolerance.is_finite() => Ok(Weld::Within(tolerance)),
            _ => Err("a length of 0 or more, or \"off\", is expected".into()),
        },
    }
}

/// A mesh format by its extension.
pub fn parse_format(text: &str) -> Result<MeshFormat, String> {
    MeshFormat::from_path(format!("x.{}", text.trim_start_matches('.')))
        .ok_or_else(|| "one of obj, ply, stl, off, glb, gltf, vtp is expected".into())
}

/// The faces of output files: as near to those of the input as the repairs allow.
enum Surface {
    /// The polygons of the file.
    File,
    /// Those after the repairs.
    Polygons(PolygonMesh),
    /// The triangles: some of a polygon may have been dropped.
    Triangles,
}

/// A mesh as it was read and as it is worked on.
pub struct MeshInput {
    /// As named on the command line.
    pub path: PathBuf,
    /// All that the file holds.
    pub file: MeshFile,
    /// The triangles that are worked on.
    pub mesh: TriangleMesh,
    /// What goes into output files.
    surface: Surface,
    /// The mesh that curve files number: that of the file before vertices were joined. `None` when it is `mesh`.
    numbered_by_curves: Option<TriangleMesh>,
    /// From the vertices of that mesh to those of `mesh`.
    joined: Option<IndexMaps>,
}

impl MeshInput {
    /// Reads the mesh, repairs what is asked for, says what was done.
    pub fn read(arguments: &MeshArguments, session: &mut Session) -> Result<MeshInput, Failure> {
        let path = arguments.mesh.clone();
        let (file, format) = session.phase("read mesh", || read_file(arguments))?;
        for warning in &file.warnings {
            session.warn(format!("{}: {warning}", path.display()));
        }
        let is_stl = format == Some(MeshFormat::Stl);
        let weld = match arguments.weld {
            Some(Weld::Off) => None,
            Some(Weld::Within(tolerance)) => Some(tolerance),
            None => is_stl.then_some(0.0),
        };
        let all = arguments.all_faults;
        let mut repairs: Vec<Value> = Vec::new();

        let mut polygons = None;
        if arguments.drop_degenerate {
            let dropped = drop_broken_polygons(&file.mesh);
            let faces = dropped.maps.dropped_faces();
            if !faces.is_empty() {
                session.note(&format!(
                    "dropped {} faces that name a vertex twice or have fewer than 3 corners",
                    faces.len()
                ));
                repairs.push(
                    json!({"repair": "drop broken faces", "dropped_faces": ids(faces.iter().map(|f| f.0))}),
                );
                polygons = Some(dropped.mesh);
            }
        }
        let triangulate = |polygons: &PolygonMesh| polygons.triangulate().map_err(|e| invalid(&path, e, all));
        let mut numbered_by_curves = None;
        let mut joined = None;
        if let Some(tolerance) = weld {
            let before = polygons.as_ref().unwrap_or(&file.mesh);
            let welded = session.phase("weld", || weld_polygons(before, tolerance)).map_err(|e| match e {
                MeshError::Parameter { .. } => Failure::Usage(format!("--weld: {e}")),
                e => invalid(&path, e, all),
            })?;
            let (from, to) = (before.vertex_count(), welded.mesh.vertex_count());
            let lost = welded.maps.dropped_faces().len();
            if from != to || lost > 0 {
                session.note(&weld_note(is_stl && arguments.weld.is_none(), from, to, lost));
            }
            let vertex_map: Vec<Option<u32>> =
                welded.maps.vertices.as_slice().iter().map(|v| v.map(|v| v.0)).collect();
            repairs.push(json!({
                "repair": "weld", "tolerance": tolerance, "vertices_before": from, "vertices_after": to,
                "dropped_faces": ids(welded.maps.dropped_faces().iter().map(|f| f.0)),
                "vertex_map": if from == to { Value::Null } else { json!(vertex_map) },
            }));
            // No curve can name the vertices of an STL file, which has none of its own.
            if !is_stl && from != to {
                // Where triangles can not be made of it, curves must name the joined vertices.
                let whole = drop_broken_polygons(before);
                numbered_by_curves = whole.mesh.triangulate().ok().map(|(mesh, _)| mesh);
                joined = Some(welded.maps);
            }
            polygons = Some(welded.mesh);
        }
        let surface = polygons.as_ref().unwrap_or(&file.mesh);
        let (mut mesh, _) = session.phase("triangulate", || triangulate(surface))?;
        if !surface.is_triangular() {
            session.note(&format!(
                "{} polygons were cut into {} triangles, each from its first corner",
                surface.face_count(),
                mesh.face_count()
            ));
        }
        let mut kept_polygons = true;
        if arguments.drop_degenerate {
            let dropped = drop_degenerate_faces(&mesh);
            let faces = dropped.maps.dropped_faces();
            if !faces.is_empty() {
                session.note(&format!("dropped {} triangles without area", faces.len()));
                repairs.push(json!({"repair": "drop degenerate faces", "dropped_faces": ids(faces.iter().map(|f| f.0))}));
                mesh = dropped.mesh;
                kept_polygons = false;
            }
        }
        if weld.is_none() && looks_loose(&mesh) {
            session.warn(format!(
                "{}: no two faces share a vertex, so nothing connects them; add --weld to join vertices at the same place",
                path.display()
            ));
        }
        session.report.input.insert("mesh".into(), facts(&path, format, &file, &mesh));
        session.report.input.insert("repairs".into(), Value::Array(repairs));
        let surface = if kept_polygons {
            polygons.map_or(Surface::File, Surface::Polygons)
        } else {
            Surface::Triangles
        };
        Ok(MeshInput { path, file, mesh, surface, numbered_by_curves, joined })
    }

    /// Refuses a mesh on which there is nothing to measure.
    pub fn require_faces(&self) -> Result<(), Failure> {
        if self.mesh.face_count() > 0 {
            return Ok(());
        }
        let hint = if is_named_like_curves(&self.path) { format!("\n{IF_CURVES}") } else { String::new() };
        Err(Failure::Input(format!(
            "{}: there are no faces in this file; give a mesh of a surface{hint}",
            shown_name(&self.path)
        )))
    }

    /// The mesh to write: polygons as they were where the format can hold them.
    pub fn to_write(&self, format: MeshFormat) -> MeshOut<'_> {
        let triangles_only = matches!(format, MeshFormat::Stl | MeshFormat::Glb | MeshFormat::Gltf);
        match &self.surface {
            Surface::File if !triangles_only => MeshOut::from(&self.file.mesh),
            Surface::Polygons(polygons) if !triangles_only => MeshOut::from(polygons),
            _ => MeshOut::from(&self.mesh),
        }
    }

    /// Whether the faces of output files that can hold polygons are those of the input file, one by one.
    pub fn writes_faces_of_file(&self) -> bool {
        matches!(self.surface, Surface::File)
    }

    /// Values given at the vertices of the file, at the vertices of the mesh. Where vertices were joined the first one counts.
    pub fn vertex_values(&self, values: &[f64]) -> Vec<f64> {
        let Some(maps) = &self.joined else { return values.to_vec() };
        let mut result = vec![f64::NAN; self.mesh.vertex_count()];
        for (new, &value) in maps.vertices.as_slice().iter().zip(values).rev() {
            if let Some(place) = new.and_then(|v| result.get_mut(v.index())) {
                *place = value;
            }
        }
        result
    }

    /// The mesh whose vertices, edges and faces a curve file names.
    pub fn mesh_for_curves(&self) -> &TriangleMesh {
        self.numbered_by_curves.as_ref().unwrap_or(&self.mesh)
    }

    /// A point named by vertices of [`MeshInput::mesh_for_curves`], named by vertices of the mesh.
    pub fn renumber(&self, point: SurfacePoint) -> SurfacePoint {
        let Some(maps) = &self.joined else { return point };
        if self.numbered_by_curves.is_none() {
            return point;
        }
        let new = |v: u32| maps.vertices.get(Vertex(v)).copied().flatten().map_or(v, |v| v.0);
        match point {
            SurfacePoint::Vertex { vertex } => SurfacePoint::Vertex { vertex: new(vertex) },
            SurfacePoint::Edge { vertices: [a, b], t } => match [new(a), new(b)] {
                [a, b] if a == b => SurfacePoint::Vertex { vertex: a },
                vertices => SurfacePoint::Edge { vertices, t },
            },
            SurfacePoint::Face { vertices, bary } => SurfacePoint::Face { vertices: vertices.map(new), bary },
        }
    }
}

fn weld_note(because_stl: bool, from: usize, to: usize, lost: usize) -> String {
    let mut text = if because_stl {
        format!(
            "STL holds loose triangles: their {from} corners were joined to {to} vertices where they lie at the same place, and \
             results are given for these (--weld=TOL joins near ones too, --weld=off joins none)"
        )
    } else {
        format!("joined {from} vertices to {to}; results are given for these, the report has the map")
    };
    if lost > 0 {
        text += &format!("; {lost} faces that lost a corner by it were dropped");
    }
    text
}

fn read_file(arguments: &MeshArguments) -> Result<(MeshFile, Option<MeshFormat>), Failure> {
    let path = &arguments.mesh;
    if path == Path::new("-") {
        let mut bytes = Vec::new();
        std::io::stdin()
            .read_to_end(&mut bytes)
            .map_err(|e| Failure::Input(format!("the standard input can not be read: {e}")))?;
        let bytes = without_gzip(bytes, &shown_name(path)).map_err(|e| Failure::Input(e.to_string()))?;
        if bytes.is_empty() {
            return Err(Failure::Input("the standard input is empty; pipe a mesh into it".into()));
        }
        let format = arguments.in_format.or_else(|| MeshFormat::sniff(&bytes)).ok_or_else(|| {
            Failure::Input(
                "the format of the standard input can not be told; name it with --in-format".into(),
            )
        })?;
        let file = read_mesh_bytes(&bytes, format).map_err(|e| Failure::reading(path, e))?;
        return Ok((file, Some(format)));
    }
    if let Some(format) = arguments.in_format {
        let bytes =
            std::fs::read(path).map_err(|e| Failure::reading(path, eikona_mesh::FileError::io(path, e)))?;
        let bytes = without_gzip(bytes, &shown_name(path)).map_err(|e| Failure::Input(e.to_string()))?;
        let file = read_mesh_bytes(&bytes, format).map_err(|e| Failure::reading(path, e))?;
        return Ok((file, Some(format)));
    }
    let file = read_mesh(path).map_err(|e| match Failure::reading(path, e) {
        Failure::Input(text) if path.exists() && is_named_like_curves(path) => {
            Failure::Input(format!("{text}\n{IF_CURVES}"))
        }
        failure => failure,
    })?;
    Ok((file, MeshFormat::from_path(path).or_else(|| sniff_file(path))))
}

const IF_CURVES: &str = "If this is a curve file, give it with --curve beside a mesh";

/// Curve files may be .obj too, but then they are meshes without faces.
fn is_named_like_curves(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json") || e.eq_ignore_ascii_case("txt"))
}

fn shown_name(path: &Path) -> String {
    if path == Path::new("-") { "the standard input".into() } else { path.display().to_string() }
}

fn sniff_file(path: &Path) -> Option<MeshFormat> {
    let mut bytes = Vec::new();
    std::fs::File::open(path).ok()?.take(1 << 16).read_to_end(&mut bytes).ok()?;
    MeshFormat::sniff(&bytes)
}

fn invalid(path: &Path, fault: MeshError, all: bool) -> Failure {
    let mut text = format!("{}: {fault}", path.display());
    if let MeshError::Invalid(faults) = &fault {
        if all {
            text = format!("{}: the mesh is not valid:", path.display());
            faults.iter().for_each(|f| text += &format!("\n  {f}"));
        }
        if faults.iter().all(|f| matches!(f, Fault::RepeatedVertex { .. } | Fault::TooFewCorners { .. })) {
            text += "\n--drop-degenerate drops such faces";
        }
    }
    Failure::Input(text)
}

/// Whether every face has three vertices of its own.
fn looks_loose(mesh: &TriangleMesh) -> bool {
    mesh.face_count() > 1 && mesh.vertices().all(|v| mesh.vertex_corners(v).len() <= 1)
}

fn facts(path: &Path, format: Option<MeshFormat>, file: &MeshFile, mesh: &TriangleMesh) -> Value {
    json!({
        "path": path.display().to_string(),
        "format": format.map(|f| format!("{f:?}").to_lowercase()),
        "vertices_in_file": file.mesh.vertex_count(),
        "faces_in_file": file.mesh.face_count(),
        "vertices": mesh.vertex_count(),
        "edges": mesh.edge_count(),
        "triangles": mesh.face_count(),
    })
}

fn ids(ids: impl Iterator<Item = u32>) -> Vec<u32> {
    ids.collect()
}
