//! Boundaries that touch without sharing vertices: warnings and the repair.

use crate::exit::Failure;
use crate::report::vertex_map;
use crate::session::Session;
use crate::warned::Warned;
use eikona_mesh::{Components, MeshError, Seams, Stitched, SurfaceCurves, TriangleMesh, counted, stitch};
use serde_json::{Value, json};

/// Largest distance between boundaries that `--stitch` joins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stitch {
    /// The default tolerance, see [`eikona_mesh::SEAM_TOLERANCE`].
    Touching,
    /// A length in the mesh's unit.
    Within(f64),
}

pub fn parse_stitch(text: &str) -> Result<Stitch, String> {
    match text.parse::<f64>() {
        _ if text == "auto" => Ok(Stitch::Touching),
        Ok(tolerance) if tolerance >= 0.0 && tolerance.is_finite() => Ok(Stitch::Within(tolerance)),
        _ => Err("expected a length of 0 or more, or \"auto\"".into()),
    }
}

/// Stitches the boundaries of a mesh. Returns `None` if there is nothing to stitch.
pub fn stitch_mesh(
    mesh: &TriangleMesh,
    how: Stitch,
    session: &mut Session,
) -> Result<Option<(Stitched, Value)>, Failure> {
    let tolerance = match how {
        Stitch::Touching => None,
        Stitch::Within(length) => Some(length),
    };
    let stitched = session.phase("stitch", || stitch(mesh, tolerance)).map_err(|e| match e {
        MeshError::Parameter { .. } => Failure::Usage(format!("--stitch: {e}")),
        e => Failure::Input(e.to_string()),
    })?;
    if !stitched.is_changed() {
        session.note("--stitch found no boundaries to join");
        return Ok(None);
    }
    let results = if stitched.joined_vertices > 0 {
        format!(
            "; the results refer to the {} remaining vertices, the report contains the map",
            stitched.mesh.vertex_count()
        )
    } else {
        String::new()
    };
    session.note(&format!(
        "stitched: {} merged into others, {} inserted into edges, {} split; widest gap {:.1e}{results}",
        counted(stitched.joined_vertices, "vertex", "vertices"),
        stitched.inserted_vertices,
        counted(stitched.divided_faces, "face", "faces"),
        stitched.largest_gap
    ));
    let facts = json!({
        "repair": "stitch", "tolerance": tolerance, "joined_vertices": stitched.joined_vertices,
        "inserted_vertices": stitched.inserted_vertices, "divided_faces": stitched.divided_faces,
        "largest_gap": stitched.largest_gap,
        "vertex_map": vertex_map(&stitched.provenance, mesh.vertex_count()),
    });
    Ok(Some((stitched, facts)))
}

/// Names the repair that joins these boundaries.
pub fn remedy(seams: &Seams) -> &'static str {
    if seams.hanging.is_empty() && seams.largest_gap() == 0.0 {
        "add --weld to connect the surface there"
    } else {
        "add --stitch to connect the surface there"
    }
}

/// Whether no two faces share a vertex.
pub fn looks_loose(mesh: &TriangleMesh) -> bool {
    mesh.face_count() > 1 && mesh.vertices().all(|v| mesh.vertex_corners(v).len() <= 1)
}

/// Warns of boundaries that touch without sharing vertices, on components with a curve or point,
/// where joining them would change the result.
pub fn warn_of_seams(mesh: &TriangleMesh, source: &SurfaceCurves, session: &mut Session) {
    if looks_loose(mesh) {
        return; // reading the mesh has warned of this
    }
    let mut seams = session.phase("find seams", || Seams::of(mesh));
    if seams.is_empty() {
        return;
    }
    let components = Components::of(mesh);
    let mut has_source = vec![false; components.count];
    let nodes = source.curves.iter().flat_map(|c| &c.nodes).chain(&source.points);
    for point in nodes.filter_map(|p| p.locate(mesh).ok()) {
        for (v, _) in point.weights(mesh) {
            if let Some(c) = components.of_vertex[v] {
                has_source[c as usize] = true;
            }
        }
    }
    let reached = |v| components.of_vertex[v].is_some_and(|c| has_source[c as usize]);
    seams.joints.retain(|j| reached(j.vertex) || reached(j.to));
    seams.hanging.retain(|h| reached(h.vertex) || reached(mesh.edge_vertices(h.edge)[0]));
    if seams.is_empty() {
        return;
    }
    let mut parts = Vec::new();
    if let Some(h) = seams.hanging.first() {
        let [a, b] = mesh.edge_vertices(h.edge);
        let count = seams.hanging.len();
        let lie = counted(count, "boundary vertex lies inside an edge", "boundary vertices lie inside edges");
        parts.push(format!("{lie} of other faces (first: {} between {a} and {b})", h.vertex));
    }
    if let Some(j) = seams.joints.first() {
        let touch = counted(seams.joints.len(), "boundary vertex touches", "boundary vertices touch");
        parts.push(format!("{touch} another one (first: {} and {})", j.vertex, j.to));
    }
    let gap = match seams.largest_gap() {
        0.0 => String::new(),
        gap => format!("; widest gap {gap:.1e}"),
    };
    let at_least = if seams.truncated { "at least " } else { "" };
    let sentence = format!(
        "boundaries touch without sharing vertices, which disconnects the surface: {at_least}{}{gap}; {}",
        parts.join("; "),
        remedy(&seams)
    );
    let warned = Warned::new("open_seams", sentence);
    session.warn(warned.with("hanging", seams.hanging.len()).with("joints", seams.joints.len()));
}
