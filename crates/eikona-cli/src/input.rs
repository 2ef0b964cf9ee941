//! The input mesh: read from a file or standard input, repaired on request, and triangulated.

use crate::exit::Failure;
use crate::report::vertex_map;
use crate::seams::{Stitch, looks_loose, parse_stitch, stitch_mesh};
use crate::session::Session;
use crate::warned::Warned;
use clap::Args;
use eikona_mesh::io::{MeshFile, MeshFormat, MeshOut, read_mesh_as, read_mesh_bytes, without_gzip};
use eikona_mesh::{
    Face, Fault, MeshError, PolygonMesh, PolygonQuality, Provenance, RepairedPolygons, Stitched,
    SurfacePoint, TriangleMesh, Vertex, counted, drop_broken_polygons, drop_degenerate_faces, weld_polygons,
};
use serde_json::{Value, json};
use std::io::Read;
use std::path::{Path, PathBuf};

/// The mesh file and its repairs.
#[derive(Args, Clone, Debug)]
pub struct MeshArguments {
    /// Input mesh: .obj, .ply, .stl, .off, .glb, .gltf or .vtp, optionally with .gz; - for standard
    /// input
    #[arg(value_name = "MESH")]
    pub mesh: PathBuf,
    /// Format of the input if its content does not identify it: obj, ply, stl, off, glb, gltf, vtp
    #[arg(long, value_name = "FORMAT", value_parser = parse_format)]
    pub in_format: Option<MeshFormat>,
    /// Merge vertices at equal positions, or at most TOL apart (in the mesh's unit). STL files
    /// store separate triangles: their vertices at equal positions are merged unless `--weld=off`
    /// is given
    #[arg(long, value_name = "TOL|off", num_args = 0..=1, require_equals = true, default_missing_value = "0", value_parser = parse_weld)]
    pub weld: Option<Weld>,
    /// Drop faces of zero area and faces that repeat a vertex (but not polygons with holes), and
    /// remove corners repeated in a row; vertices are kept
    #[arg(long)]
    pub drop_degenerate: bool,
    /// Join boundaries that touch, or are at most TOL apart (in the mesh's unit): merge vertices,
    /// and split edges and their faces at vertices that lie inside them (T-junctions)
    #[arg(long, value_name = "TOL", num_args = 0..=1, require_equals = true, default_missing_value = "auto", value_parser = parse_stitch)]
    pub stitch: Option<Stitch>,
    /// Whether the error for an invalid mesh lists all faults rather than the first few.
    #[arg(skip)]
    pub all_faults: bool,
}

/// Whether vertices are merged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weld {
    /// Never, not even in an STL file.
    Off,
    /// If they are at most this far apart.
    Within(f64),
}

fn parse_weld(text: &str) -> Result<Weld, String> {
    match text {
        "off" => Ok(Weld::Off),
        _ => match text.parse::<f64>() {
            Ok(tolerance) if tolerance >= 0.0 && tolerance.is_finite() => Ok(Weld::Within(tolerance)),
            _ => Err("expected a length of 0 or more, or \"off\"".into()),
        },
    }
}

/// Parses a mesh format from its file extension.
pub fn parse_format(text: &str) -> Result<MeshFormat, String> {
    MeshFormat::from_path(format!("x.{}", text.trim_start_matches('.')))
        .ok_or_else(|| "expected obj, ply, stl, off, glb, gltf or vtp".into())
}

/// The faces of output files: as close to those of the input as the repairs allow.
enum Surface {
    /// The polygons of the file.
    File,
    /// The repaired polygons.
    Polygons(PolygonMesh),
    /// The triangles, since a repair may have dropped some triangles of a polygon.
    Triangles,
}

/// A mesh as read, and as repaired and triangulated.
pub struct MeshInput {
    /// As named on the command line.
    pub path: PathBuf,
    /// Content of the file.
    pub file: MeshFile,
    /// The repaired triangle mesh that methods work on.
    pub mesh: TriangleMesh,
    /// Convexity and planarity of the repaired polygons. `None` if all faces are triangles.
    pub polygon_quality: Option<PolygonQuality>,
    /// Faces of output files.
    surface: Surface,
    /// Where the vertices and triangles of `mesh` come from in the file.
    pub provenance: Provenance,
    /// The mesh before repairs, whose numbers curve files use. `None` if it equals `mesh`.
    of_file: Option<MeshOfFile>,
    /// Maps the vertices of that mesh to those before stitching.
    renamed: Provenance,
    /// Maps the points before stitching to `mesh`, if boundaries were stitched.
    stitched: Option<Stitched>,
}

/// The mesh with the numbering of its file.
struct MeshOfFile {
    /// Its vertices and valid faces.
    whole: TriangleMesh,
    /// If faces are broken: the mesh with a placeholder triangle for each broken face, on three
    /// extra vertices at the end, and the ids of the broken faces. Files that number faces count
    /// the broken ones too.
    placeholders: Option<(TriangleMesh, Vec<Face>)>,
}

impl MeshOfFile {
    fn new(polygons: &PolygonMesh) -> Result<MeshOfFile, MeshError> {
        let RepairedPolygons { mesh: kept, provenance } = drop_broken_polygons(polygons);
        let broken = provenance.dropped_faces();
        let (whole, _) = kept.triangulate()?;
        if broken.is_empty() {
            return Ok(MeshOfFile { whole, placeholders: None });
        }
        let mut all = PolygonMesh::new(polygons.positions.clone());
        for face in (0..polygons.face_count() as u32).map(Face) {
            if let Some(f) = provenance.face_parts(face).next() {
                all.push_face(kept.face(f.index()).iter().copied());
            } else {
                let first = all.vertex_count() as u32;
                all.positions.extend([[0.0; 3]; 3]);
                all.push_face(first..first + 3);
            }
        }
        let (all, _) = all.triangulate()?;
        Ok(MeshOfFile { whole, placeholders: Some((all, broken)) })
    }
}

impl MeshInput {
    /// Reads, repairs and triangulates the mesh, and reports the repairs.
    pub fn read(arguments: &MeshArguments, session: &mut Session) -> Result<MeshInput, Failure> {
        let path = arguments.mesh.clone();
        let (file, format) = session.phase("read mesh", || read_file(arguments))?;
        for warning in &file.warnings {
            session.warn(Warned::from(warning).about(path.display()));
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
        let mut repaired = Provenance::identity(file.mesh.vertex_count(), file.mesh.face_count());
        if arguments.drop_degenerate {
            let dropped = drop_broken_polygons(&file.mesh);
            let faces = dropped.provenance.dropped_faces();
            let corners = |polygons: &PolygonMesh| polygons.faces().map(<[u32]>::len).sum::<usize>();
            let lost: usize = faces.iter().map(|f| file.mesh.face(f.index()).len()).sum();
            let doubled = corners(&file.mesh) - lost - corners(&dropped.mesh);
            if doubled > 0 {
                let corners = counted(doubled, "corner that repeats", "corners that repeat");
                session.note(&format!("removed {corners} the vertex of the corner before"));
                repairs.push(json!({"repair": "remove doubled corners", "corners": doubled}));
            }
            if !faces.is_empty() {
                let count = counted(faces.len(), "face that repeats", "faces that repeat");
                session.note(&format!("dropped {count} a vertex or with fewer than 3 corners"));
                repairs.push(
                    json!({"repair": "drop broken faces", "dropped_faces": ids(faces.iter().map(|f| f.0))}),
                );
            }
            repaired = dropped.provenance;
            if doubled > 0 || !faces.is_empty() {
                polygons = Some(dropped.mesh);
            }
        }
        let triangulate = |polygons: &PolygonMesh| polygons.triangulate().map_err(|e| invalid(&path, e, all));
        if let Some(tolerance) = weld {
            let before = polygons.as_ref().unwrap_or(&file.mesh);
            let welded = session.phase("weld", || weld_polygons(before, tolerance)).map_err(|e| match e {
                MeshError::Parameter { .. } => Failure::Usage(format!("--weld: {e}")),
                e => invalid(&path, e, all),
            })?;
            let (from, to) = (before.vertex_count(), welded.mesh.vertex_count());
            let dropped = welded.provenance.dropped_faces();
            let lost = dropped.len();
            if from != to || lost > 0 {
                session.note(&weld_note(is_stl && arguments.weld.is_none(), from, to, lost));
            }
            repairs.push(json!({
                "repair": "weld", "tolerance": tolerance, "vertices_before": from, "vertices_after": to,
                "dropped_faces": ids(dropped.iter().map(|f| f.0)),
                "vertex_map": vertex_map(&welded.provenance, from),
            }));
            repaired = repaired.then(&welded.provenance);
            polygons = Some(welded.mesh);
        }
        let surface = polygons.as_ref().unwrap_or(&file.mesh);
        let (mut mesh, triangulated) = session.phase("triangulate", || triangulate(surface))?;
        let mut provenance = repaired.then(&triangulated);
        // Whether triangles were dropped or stitched.
        let mut changed = false;
        let mut polygon_quality = None;
        if !surface.is_triangular() {
            session.note(&format!(
                "triangulated {} into {}: fans from the first corner where these do not fold over, ear clipping \
                 elsewhere",
                counted(surface.face_count(), "polygon", "polygons"),
                counted(mesh.face_count(), "triangle", "triangles")
            ));
            let quality = session.phase("polygons", || PolygonQuality::of(surface));
            if let Some(first) = quality.self_crossing.first() {
                let count = quality.self_crossing.len();
                let sentence = format!(
                    "{} (first: {first}), whose triangles overlap; correct the file",
                    counted(count, "self-crossing polygon", "self-crossing polygons")
                );
                let warned = Warned::new("self_crossing_polygons", sentence).about(path.display());
                session.warn(warned.with("count", count).with("first", *first));
            }
            polygon_quality = Some(quality);
        }
        if arguments.drop_degenerate {
            let dropped = drop_degenerate_faces(&mesh);
            let faces = dropped.provenance.dropped_faces();
            if !faces.is_empty() {
                session.note(&format!("dropped {} triangles of zero area", faces.len()));
                repairs.push(json!({"repair": "drop degenerate faces", "dropped_faces": ids(faces.iter().map(|f| f.0))}));
                provenance = provenance.then(&dropped.provenance);
                mesh = dropped.mesh;
                changed = true;
            }
        }
        let mut stitched = None;
        if let Some(how) = arguments.stitch
            && let Some((found, facts)) = stitch_mesh(&mesh, how, session)?
        {
            repairs.push(facts);
            provenance = provenance.then(&found.provenance);
            mesh = found.mesh.clone();
            stitched = Some(found);
            changed = true;
        }
        if weld.is_none() && arguments.stitch.is_none() && looks_loose(&mesh) {
            let sentence = "no two faces share a vertex, so the surface is disconnected; add --weld to merge \
                            vertices at equal positions";
            session.warn(Warned::new("disconnected_faces", sentence).about(path.display()));
        }
        session.report.input.insert("mesh".into(), facts(&path, format, &file, &mesh));
        session.report.input.insert("repairs".into(), Value::Array(repairs));
        // Curves can name the faces of an STL file, but not its vertices: the format has no shared
        // ones.
        let same_vertices = is_stl || repaired.keeps_vertices();
        let of_file = match &polygons {
            _ if same_vertices && repaired.keeps_faces() && !changed => None,
            Some(welded) if is_stl => Some(MeshOfFile::new(&with_vertices(&file.mesh, welded, &repaired))),
            _ => Some(MeshOfFile::new(&file.mesh)),
        };
        let of_file = of_file.transpose().map_err(|e| invalid(&path, e, all))?;
        let renamed = match &polygons {
            Some(welded) if is_stl => Provenance::identity(welded.vertex_count(), 0),
            _ => repaired,
        };
        let surface =
            if changed { Surface::Triangles } else { polygons.map_or(Surface::File, Surface::Polygons) };
        Ok(MeshInput { path, file, mesh, polygon_quality, surface, provenance, of_file, renamed, stitched })
    }

    /// Fails if the mesh has no faces.
    pub fn require_faces(&self) -> Result<(), Failure> {
        if self.mesh.face_count() > 0 {
            return Ok(());
        }
        let hint = if is_named_like_curves(&self.path) { format!("\n{IF_CURVES}") } else { String::new() };
        let problem = match self.file.mesh.face_count() {
            0 => "this file has no faces; give a surface mesh".into(),
            n => {
                format!("the repairs dropped all {n} faces of this file; check it with `eikona inspect`")
            }
        };
        Err(Failure::Input(format!("{}: {problem}{hint}", shown_name(&self.path))))
    }

    /// The mesh to write: the original polygons if the format can store them.
    pub fn to_write(&self, format: MeshFormat) -> MeshOut<'_> {
        let triangles_only = matches!(format, MeshFormat::Stl | MeshFormat::Glb | MeshFormat::Gltf);
        match &self.surface {
            Surface::File if !triangles_only => MeshOut::from(&self.file.mesh),
            Surface::Polygons(polygons) if !triangles_only => MeshOut::from(polygons),
            _ => MeshOut::from(&self.mesh),
        }
    }

    /// Whether output files that can store polygons have exactly the faces of the input file.
    pub fn writes_faces_of_file(&self) -> bool {
        matches!(self.surface, Surface::File)
    }

    /// The first triangle of a face of the file.
    pub fn triangle_of(&self, face: Face) -> Result<Face, String> {
        let faces = self.file.mesh.face_count();
        if face.index() >= faces {
            let face = face.index();
            return Err(format!(
                "face {face} does not exist: the mesh has {faces} faces, numbered from 0 to {}",
                faces.saturating_sub(1)
            ));
        }
        self.provenance.face_parts(face).next().ok_or_else(|| {
            format!(
                "{face} was dropped: it has zero area, repeats a vertex, or has too few corners; name \
                 another face"
            )
        })
    }

    /// Transfers values from the vertices of the file to those of the mesh. Merged vertices take
    /// the value of the first one.
    pub fn vertex_values(&self, values: &[f64]) -> Vec<f64> {
        let pulled = self.provenance.pull_vertices(&values.to_vec().into());
        pulled.expect("readers give one value per vertex").into_vec()
    }

    /// The mesh whose vertices curve files name.
    pub fn mesh_for_curves(&self) -> &TriangleMesh {
        self.of_file.as_ref().map_or(&self.mesh, |of_file| &of_file.whole)
    }

    /// The mesh for curve files that number vertices, edges and faces. It may contain placeholders
    /// for broken faces ([`MeshInput::has_placeholders`]), which [`MeshInput::check_of_file`]
    /// rejects.
    pub fn mesh_for_numbers(&self) -> &TriangleMesh {
        self.placeholders().map_or(self.mesh_for_curves(), |(mesh, _)| mesh)
    }

    /// Whether the file has broken faces, which makes its edge numbers ambiguous.
    pub fn has_placeholders(&self) -> bool {
        self.placeholders().is_some()
    }

    fn placeholders(&self) -> Option<&(TriangleMesh, Vec<Face>)> {
        self.of_file.as_ref()?.placeholders.as_ref()
    }

    /// Fails for a point of [`MeshInput::mesh_for_numbers`] that lies on a placeholder.
    pub fn check_of_file(&self, point: SurfacePoint) -> Result<(), String> {
        let Some((_, broken)) = self.placeholders() else { return Ok(()) };
        let vertices = self.mesh_for_curves().vertex_count();
        match point {
            SurfacePoint::Vertex { vertex } if vertex as usize >= vertices => Err(format!(
                "vertex {vertex} does not exist: the mesh has {vertices} vertices, numbered from 0; correct \
                 the index"
            )),
            SurfacePoint::Face { vertices: [a, ..], .. } if a as usize >= vertices => {
                let face = broken.get((a as usize - vertices) / 3).map_or(0, |f| f.0);
                Err(format!(
                    "a node lies on face {face}, which repeats a vertex or has too few corners and was \
                     dropped; name another face or a vertex"
                ))
            }
            _ => Ok(()),
        }
    }

    /// The `l` lines of the file as vertices of the mesh.
    pub fn lines(&self) -> Vec<Vec<u32>> {
        let new = |v: &u32| self.provenance.new_vertex(Vertex(*v)).map_or(*v, |v| v.0);
        self.file.lines.iter().map(|line| line.iter().map(new).collect()).collect()
    }

    /// Returns the number of a vertex of the mesh as files name it: [`renumber`](Self::renumber)
    /// maps it back.
    pub fn vertex_in_file(&self, vertex: u32) -> u32 {
        let before = self.stitched.as_ref().and_then(|s| s.provenance.vertex_parent(Vertex(vertex)));
        let before = before.unwrap_or(Vertex(vertex));
        self.renamed.vertex_parent(before).unwrap_or(before).0
    }

    /// Converts a point from vertices of the file to vertices of the mesh. The result is invalid if
    /// its face or edge was dropped.
    pub fn renumber(&self, point: SurfacePoint) -> SurfacePoint {
        let renamed = self.renamed.rename(point);
        self.stitched.as_ref().map_or(renamed, |stitched| stitched.point(renamed))
    }
}

/// The polygons, including broken ones, on the welded vertices.
fn with_vertices(polygons: &PolygonMesh, welded: &PolygonMesh, provenance: &Provenance) -> PolygonMesh {
    let new = |v: &u32| provenance.new_vertex(Vertex(*v)).map_or(*v, |v| v.0);
    let mut joined = PolygonMesh::new(welded.positions.clone());
    polygons.faces().for_each(|corners| joined.push_face(corners.iter().map(new)));
    joined
}

fn weld_note(because_stl: bool, from: usize, to: usize, lost: usize) -> String {
    let mut text = if because_stl {
        format!(
            "STL stores separate triangles: merged {from} corners at equal positions into {to} vertices, \
             which the results refer to (--weld=TOL also merges near ones, --weld=off merges none)"
        )
    } else {
        let from = counted(from, "vertex", "vertices");
        format!("merged {from} into {to}, which the results refer to; the report contains the map")
    };
    if lost > 0 {
        let faces = counted(lost, "face", "faces");
        text += &format!("; dropped {faces} with fewer than 3 corners left");
    }
    text
}

fn read_file(arguments: &MeshArguments) -> Result<(MeshFile, Option<MeshFormat>), Failure> {
    let path = &arguments.mesh;
    if path == Path::new("-") {
        let mut bytes = Vec::new();
        std::io::stdin()
            .read_to_end(&mut bytes)
            .map_err(|e| Failure::Input(format!("cannot read standard input: {e}")))?;
        let bytes = without_gzip(bytes, &shown_name(path)).map_err(|e| Failure::Input(e.to_string()))?;
        if bytes.is_empty() {
            return Err(Failure::Input("standard input is empty; pipe a mesh into it".into()));
        }
        let format = arguments.in_format.or_else(|| MeshFormat::sniff(&bytes)).ok_or_else(|| {
            Failure::Input("the format of standard input is not recognised; name it with --in-format".into())
        })?;
        let file = read_mesh_bytes(&bytes, format).map_err(|e| Failure::reading(path, e))?;
        return Ok((file, Some(format)));
    }
    let (file, format) =
        read_mesh_as(path, arguments.in_format).map_err(|e| match Failure::reading(path, e) {
            Failure::Input(text) if path.exists() && is_named_like_curves(path) => {
                Failure::Input(format!("{text}\n{IF_CURVES}"))
            }
            failure => failure,
        })?;
    Ok((file, Some(format)))
}

const IF_CURVES: &str = "If this is a curve file, pass it with --curve and give a mesh too";

/// Curve files may also be .obj, but those are read as meshes without faces.
fn is_named_like_curves(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json") || e.eq_ignore_ascii_case("txt"))
}

fn shown_name(path: &Path) -> String {
    if path == Path::new("-") { "standard input".into() } else { path.display().to_string() }
}

fn invalid(path: &Path, fault: MeshError, all: bool) -> Failure {
    let mut text = format!("{}: {fault}", path.display());
    if let MeshError::Invalid(faults) = &fault {
        if all {
            text = format!("{}: the mesh is not valid:", path.display());
            faults.iter().for_each(|f| text += &format!("\n  {f}"));
        }
        if faults.iter().all(|f| matches!(f, Fault::RepeatedVertex { .. } | Fault::TooFewCorners { .. })) {
            text += "\n--drop-degenerate removes corners repeated in a row and drops the other faces";
        }
    }
    Failure::Input(text)
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
