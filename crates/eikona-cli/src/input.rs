//! The mesh that a verb works on: read from a file or the standard input, repaired where that was
//! asked for, triangulated.

use crate::exit::Failure;
use crate::seams::{Stitch, looks_loose, parse_stitch, stitch_mesh};
use crate::session::Session;
use clap::Args;
use eikona_mesh::io::{MeshFile, MeshFormat, MeshOut, read_mesh_as, read_mesh_bytes, without_gzip};
use eikona_mesh::{
    Face, Fault, IndexMaps, MeshError, PolygonMesh, PolygonQuality, RepairedPolygons, Stitched, SurfacePoint,
    TriangleMesh, Vertex, drop_broken_polygons, drop_degenerate_faces, weld_polygons,
};
use serde_json::{Value, json};
use std::io::Read;
use std::path::{Path, PathBuf};

/// The mesh file and what is to be repaired in it.
#[derive(Args, Clone, Debug)]
pub struct MeshArguments {
    /// The mesh: .obj, .ply, .stl, .off, .glb, .gltf or .vtp, also with .gz; - for the standard
    /// input
    #[arg(value_name = "MESH")]
    pub mesh: PathBuf,
    /// Format of the standard input, when its content does not tell it: obj, ply, stl, off, glb,
    /// gltf, vtp
    #[arg(long, value_name = "FORMAT", value_parser = parse_format)]
    pub in_format: Option<MeshFormat>,
    /// Join vertices at the same place, or at most TOL apart (in the unit of the mesh). STL files,
    /// which hold loose triangles, are joined at equal places unless `--weld=off` is given
    #[arg(long, value_name = "TOL|off", num_args = 0..=1, require_equals = true, default_missing_value = "0", value_parser = parse_weld)]
    pub weld: Option<Weld>,
    /// Drop faces without area and faces that name a vertex twice (but not polygons with holes),
    /// and corners of polygons named twice in a row; the vertices stay
    #[arg(long)]
    pub drop_degenerate: bool,
    /// Join boundaries that touch, or are at most TOL apart (in the unit of the mesh): vertices at
    /// vertices, and vertices inside edges (T-junctions), which are divided there with their faces
    #[arg(long, value_name = "TOL", num_args = 0..=1, require_equals = true, default_missing_value = "auto", value_parser = parse_stitch)]
    pub stitch: Option<Stitch>,
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
    /// How far the polygons, after repairs, are from convex and planar ones. `None` if all faces
    /// are triangles.
    pub polygon_quality: Option<PolygonQuality>,
    /// What goes into output files.
    surface: Surface,
    /// The face of the file that each triangle is a part of, in their order. `None` if triangles
    /// have the numbers of faces.
    parts_of: Option<Vec<Face>>,
    /// The mesh that curve files number: that of the file before it was repaired. `None` when it is
    /// `mesh`.
    of_file: Option<MeshOfFile>,
    /// From the vertices of that mesh to those of `mesh`, where they were joined.
    joined: Option<IndexMaps>,
    /// From there to `mesh`, where boundaries were joined after that.
    stitched: Option<Stitched>,
}

/// A mesh as its file numbers it.
struct MeshOfFile {
    /// Its vertices and whole faces.
    whole: TriangleMesh,
    /// Where faces are broken: with a triangle in the place of each, on three vertices of its own
    /// behind all others; and which faces they are. Files that number the faces count the broken
    /// ones too.
    stand_ins: Option<(TriangleMesh, Vec<Face>)>,
}

impl MeshOfFile {
    fn new(polygons: &PolygonMesh) -> Result<MeshOfFile, MeshError> {
        let RepairedPolygons { mesh: kept, maps } = drop_broken_polygons(polygons);
        let broken = maps.dropped_faces();
        let (whole, _) = kept.triangulate()?;
        if broken.is_empty() {
            return Ok(MeshOfFile { whole, stand_ins: None });
        }
        let mut all = PolygonMesh::new(polygons.positions.clone());
        for new in maps.faces.as_slice() {
            if let Some(f) = new {
                all.push_face(kept.face(f.index()).iter().copied());
            } else {
                let first = all.vertex_count() as u32;
                all.positions.extend([[0.0; 3]; 3]);
                all.push_face(first..first + 3);
            }
        }
        let (all, _) = all.triangulate()?;
        Ok(MeshOfFile { whole, stand_ins: Some((all, broken)) })
    }
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
        let mut parts_of: Vec<Face> = (0..file.mesh.face_count() as u32).map(Face).collect();
        // Whether numbers of the file are no longer those of the mesh.
        let mut renumbered = false;
        if arguments.drop_degenerate {
            let dropped = drop_broken_polygons(&file.mesh);
            let faces = dropped.maps.dropped_faces();
            let corners = |polygons: &PolygonMesh| polygons.faces().map(<[u32]>::len).sum::<usize>();
            let lost: usize = faces.iter().map(|f| file.mesh.face(f.index()).len()).sum();
            let doubled = corners(&file.mesh) - lost - corners(&dropped.mesh);
            if doubled > 0 {
                session.note(&format!("removed {doubled} corners at the same vertex as the corner before"));
                repairs.push(json!({"repair": "remove doubled corners", "corners": doubled}));
            }
            if !faces.is_empty() {
                session.note(&format!(
                    "dropped {} faces that name a vertex twice or have fewer than 3 corners",
                    faces.len()
                ));
                repairs.push(
                    json!({"repair": "drop broken faces", "dropped_faces": ids(faces.iter().map(|f| f.0))}),
                );
                keep(&mut parts_of, &dropped.maps);
                renumbered = true;
            }
            if doubled > 0 || !faces.is_empty() {
                polygons = Some(dropped.mesh);
            }
        }
        let triangulate = |polygons: &PolygonMesh| polygons.triangulate().map_err(|e| invalid(&path, e, all));
        let mut joined = None;
        let mut joined_stl = None;
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
            keep(&mut parts_of, &welded.maps);
            if !is_stl {
                renumbered |= from != to || lost > 0;
                joined = Some(welded.maps);
            } else if lost > 0 || arguments.drop_degenerate || arguments.stitch.is_some() {
                // No curve can name the vertices of an STL file, which has none of its own; but its
                // faces.
                joined_stl = Some(with_vertices(&file.mesh, &welded));
                renumbered |= lost > 0;
            }
            polygons = Some(welded.mesh);
        }
        let surface = polygons.as_ref().unwrap_or(&file.mesh);
        let (mut mesh, polygon_of) = session.phase("triangulate", || triangulate(surface))?;
        parts_of = polygon_of.iter().map(|f| parts_of[f.index()]).collect();
        let mut polygon_quality = None;
        if !surface.is_triangular() {
            session.note(&format!(
                "{} polygons were cut into {} triangles: fans from the first corner where these do not fold over, ears elsewhere",
                surface.face_count(),
                mesh.face_count()
            ));
            let quality = session.phase("polygons", || PolygonQuality::of(surface));
            if let Some(first) = quality.self_crossing.first() {
                session.warn(format!(
                    "{}: polygons that cross themselves: {} (first: {first}); their triangles overlap; correct them",
                    path.display(),
                    quality.self_crossing.len()
                ));
            }
            polygon_quality = Some(quality);
        }
        let mut kept_polygons = true;
        if arguments.drop_degenerate {
            let dropped = drop_degenerate_faces(&mesh);
            let faces = dropped.maps.dropped_faces();
            if !faces.is_empty() {
                session.note(&format!("dropped {} triangles without area", faces.len()));
                repairs.push(json!({"repair": "drop degenerate faces", "dropped_faces": ids(faces.iter().map(|f| f.0))}));
                keep(&mut parts_of, &dropped.maps);
                mesh = dropped.mesh;
                kept_polygons = false;
                renumbered = true;
            }
        }
        let mut stitched = None;
        if let Some(how) = arguments.stitch
            && let Some((found, facts)) = stitch_mesh(&mesh, how, session)?
        {
            repairs.push(facts);
            parts_of = found.parent.as_slice().iter().map(|f| parts_of[f.index()]).collect();
            mesh = found.mesh.clone();
            stitched = Some(found);
            kept_polygons = false;
            renumbered = true;
        }
        if weld.is_none() && arguments.stitch.is_none() && looks_loose(&mesh) {
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
        let of_file = renumbered.then(|| MeshOfFile::new(joined_stl.as_ref().unwrap_or(&file.mesh)));
        let of_file = of_file.transpose().map_err(|e| invalid(&path, e, all))?;
        let same = parts_of.len() == file.mesh.face_count()
            && parts_of.iter().enumerate().all(|(triangle, f)| f.index() == triangle);
        let parts_of = (!same).then_some(parts_of);
        Ok(MeshInput { path, file, mesh, polygon_quality, surface, parts_of, of_file, joined, stitched })
    }

    /// Refuses a mesh on which there is nothing to measure.
    pub fn require_faces(&self) -> Result<(), Failure> {
        if self.mesh.face_count() > 0 {
            return Ok(());
        }
        let hint = if is_named_like_curves(&self.path) { format!("\n{IF_CURVES}") } else { String::new() };
        let problem = match self.file.mesh.face_count() {
            0 => "there are no faces in this file; give a mesh of a surface".into(),
            n => {
                format!("the repairs dropped all {n} faces of this file; look at them with `eikona inspect`")
            }
        };
        Err(Failure::Input(format!("{}: {problem}{hint}", shown_name(&self.path))))
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

    /// Whether the faces of output files that can hold polygons are those of the input file, one by
    /// one.
    pub fn writes_faces_of_file(&self) -> bool {
        matches!(self.surface, Surface::File)
    }

    /// Whether the triangles are the faces of the file, with the same numbers.
    pub fn has_faces_of_file(&self) -> bool {
        self.parts_of.is_none()
    }

    /// The face of the file that a triangle is, or is a part of.
    pub fn face_of_file(&self, triangle: Face) -> Face {
        self.parts_of.as_ref().map_or(triangle, |parts_of| parts_of[triangle.index()])
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
        let Some(parts_of) = &self.parts_of else { return Ok(face) };
        let first = parts_of.partition_point(|f| f.0 < face.0);
        if parts_of.get(first) == Some(&face) {
            return Ok(Face(first as u32));
        }
        Err(format!("{face} was dropped as it has no area or too few corners; name another one"))
    }

    /// Values given at the vertices of the file, at the vertices of the mesh. Where vertices were
    /// joined the first one counts.
    pub fn vertex_values(&self, values: &[f64]) -> Vec<f64> {
        if self.joined.is_none() && self.stitched.is_none() {
            return values.to_vec();
        }
        let mut result = vec![f64::NAN; self.mesh.vertex_count()];
        for (v, &value) in values.iter().enumerate().rev() {
            if let Some(place) = result.get_mut(self.new_vertex(v as u32) as usize) {
                *place = value;
            }
        }
        result
    }

    /// The mesh whose vertices a curve file names.
    pub fn mesh_for_curves(&self) -> &TriangleMesh {
        self.of_file.as_ref().map_or(&self.mesh, |of_file| &of_file.whole)
    }

    /// The mesh whose vertices, edges and faces a curve file names by number. What it holds more
    /// than the file is refused by [`MeshInput::check_of_file`]; see [`MeshInput::has_stand_ins`]
    /// too.
    pub fn mesh_for_numbers(&self) -> &TriangleMesh {
        self.stand_ins().map_or(self.mesh_for_curves(), |(mesh, _)| mesh)
    }

    /// Whether faces of the file are broken, which leaves open what numbers its edges have.
    pub fn has_stand_ins(&self) -> bool {
        self.stand_ins().is_some()
    }

    fn stand_ins(&self) -> Option<&(TriangleMesh, Vec<Face>)> {
        self.of_file.as_ref()?.stand_ins.as_ref()
    }

    /// Refuses a point of [`MeshInput::mesh_for_numbers`] that is not on the mesh of the file.
    pub fn check_of_file(&self, point: SurfacePoint) -> Result<(), String> {
        let Some((_, broken)) = self.stand_ins() else { return Ok(()) };
        let vertices = self.mesh_for_curves().vertex_count();
        match point {
            SurfacePoint::Vertex { vertex } if vertex as usize >= vertices => Err(format!(
                "vertex {vertex} does not exist: the mesh has {vertices}, numbered from 0; correct the index"
            )),
            SurfacePoint::Face { vertices: [a, ..], .. } if a as usize >= vertices => {
                let face = broken.get((a as usize - vertices) / 3).map_or(0, |f| f.0);
                Err(format!(
                    "a node lies on face {face}, which names a vertex twice and was dropped; name another face, or a vertex"
                ))
            }
            _ => Ok(()),
        }
    }

    /// The `l` lines of the file, by vertices of the mesh.
    pub fn lines(&self) -> Vec<Vec<u32>> {
        self.file.lines.iter().map(|line| line.iter().map(|&v| self.new_vertex(v)).collect()).collect()
    }

    /// The vertex of the mesh that a vertex of the file was joined to.
    fn new_vertex(&self, vertex: u32) -> u32 {
        let new = self.joined.as_ref().and_then(|maps| *maps.vertices.get(Vertex(vertex))?);
        let welded = new.map_or(vertex, |v| v.0);
        let stitched = self.stitched.as_ref().and_then(|s| s.vertices.get(Vertex(welded)));
        stitched.map_or(welded, |v| v.0)
    }

    /// A point named by vertices of the file, named by vertices of the mesh. Where its face or edge
    /// was dropped, there is no such point any more.
    pub fn renumber(&self, point: SurfacePoint) -> SurfacePoint {
        let welded = match &self.joined {
            Some(maps) => renumbered(point, maps),
            None => point,
        };
        self.stitched.as_ref().map_or(welded, |stitched| stitched.point(welded))
    }
}

/// A point named by the vertices that its own were joined to.
fn renumbered(point: SurfacePoint, maps: &IndexMaps) -> SurfacePoint {
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

/// Leaves out what stands for faces that a repair has dropped.
fn keep<T>(of_faces: &mut Vec<T>, maps: &IndexMaps) {
    let mut new = maps.faces.as_slice().iter();
    of_faces.retain(|_| new.next().is_some_and(Option::is_some));
}

/// The polygons, broken ones too, by the vertices that theirs were joined to.
fn with_vertices(polygons: &PolygonMesh, welded: &RepairedPolygons) -> PolygonMesh {
    let new = |v: &u32| welded.maps.vertices.get(Vertex(*v)).copied().flatten().map_or(*v, |v| v.0);
    let mut joined = PolygonMesh::new(welded.mesh.positions.clone());
    polygons.faces().for_each(|corners| joined.push_face(corners.iter().map(new)));
    joined
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
    let (file, format) =
        read_mesh_as(path, arguments.in_format).map_err(|e| match Failure::reading(path, e) {
            Failure::Input(text) if path.exists() && is_named_like_curves(path) => {
                Failure::Input(format!("{text}\n{IF_CURVES}"))
            }
            failure => failure,
        })?;
    Ok((file, Some(format)))
}

const IF_CURVES: &str = "If this is a curve file, give it with --curve beside a mesh";

/// Curve files may be .obj too, but then they are meshes without faces.
fn is_named_like_curves(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json") || e.eq_ignore_ascii_case("txt"))
}

fn shown_name(path: &Path) -> String {
    if path == Path::new("-") { "the standard input".into() } else { path.display().to_string() }
}

fn invalid(path: &Path, fault: MeshError, all: bool) -> Failure {
    let mut text = format!("{}: {fault}", path.display());
    if let MeshError::Invalid(faults) = &fault {
        if all {
            text = format!("{}: the mesh is not valid:", path.display());
            faults.iter().for_each(|f| text += &format!("\n  {f}"));
        }
        if faults.iter().all(|f| matches!(f, Fault::RepeatedVertex { .. } | Fault::TooFewCorners { .. })) {
            text +=
                "\n--drop-degenerate removes corners that are named twice in a row and drops the other faces";
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
