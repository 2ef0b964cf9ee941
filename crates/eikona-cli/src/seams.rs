//! Boundaries that lie on one another without being joined: what is said of them, and the repair.

use crate::exit::Failure;
use crate::session::Session;
use eikona_mesh::{Components, MeshError, Seams, Stitched, SurfaceCurves, TriangleMesh, stitch};
use serde_json::{Value, json};

/// How far apart boundaries may be that are joined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stitch {
    /// As far as they are taken for one, see [`eikona_mesh::SEAM_TOLERANCE`].
    Touching,
    /// A length in the unit of the mesh.
    Within(f64),
}

pub fn parse_stitch(text: &str) -> Result<Stitch, String> {
    match text.parse::<f64>() {
        _ if text == "auto" => Ok(Stitch::Touching),
        Ok(tolerance) if tolerance >= 0.0 && tolerance.is_finite() => Ok(Stitch::Within(tolerance)),
        _ => Err("a length of 0 or more, or \"auto\", is expected".into()),
    }
}

/// Joins the boundaries of a mesh. `None` if there is nothing to join.
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
            "; {} vertices remain, results are given for these, the report has the map",
            stitched.mesh.vertex_count()
        )
    } else {
        String::new()
    };
    session.note(&format!(
        "stitched: {} vertices joined to others, {} inserted into edges, {} faces divided; the widest gap was {:.1e}{results}",
        stitched.joined_vertices, stitched.inserted_vertices, stitched.divided_faces, stitched.largest_gap
    ));
    let vertex_map: Vec<u32> = stitched.vertices.as_slice().iter().map(|v| v.0).collect();
    let facts = json!({
        "repair": "stitch", "tolerance": tolerance, "joined_vertices": stitched.joined_vertices,
        "inserted_vertices": stitched.inserted_vertices, "divided_faces": stitched.divided_faces,
        "largest_gap": stitched.largest_gap,
        "vertex_map": if stitched.joined_vertices == 0 { Value::Null } else { json!(vertex_map) },
    });
    Ok(Some((stitched, facts)))
}

/// The repair that joins these boundaries.
pub fn remedy(seams: &Seams) -> &'static str {
    if seams.hanging.is_empty() && seams.largest_gap() == 0.0 {
        "add --weld to connect the surface there"
    } else {
        "add --stitch to connect the surface there"
    }
}

/// Whether every face has three vertices of its own.
pub fn looks_loose(mesh: &TriangleMesh) -> bool {
    mesh.face_count() > 1 && mesh.vertices().all(|v| mesh.vertex_corners(v).len() <= 1)
}

/// Warns of boundaries that touch without being joined, on parts of the surface that the curves and
/// points lie on: results would differ if they were joined.
pub fn warn_of_seams(mesh: &TriangleMesh, source: &SurfaceCurves, session: &mut Session) {
    if looks_loose(mesh) {
        return; // which is said when the mesh is read
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
        let (count, vertices) = counted(seams.hanging.len(), "lies inside an edge", "lie inside edges");
        parts.push(format!("{count} {vertices} of other faces (first: {} between {a} and {b})", h.vertex));
    }
    if let Some(j) = seams.joints.first() {
        let (count, vertices) = counted(seams.joints.len(), "touches", "touch");
        parts.push(format!("{count} {vertices} another one (first: {} and {})", j.vertex, j.to));
    }
    let gap = match seams.largest_gap() {
        0.0 => String::new(),
        gap => format!("; the widest gap is {gap:.1e}"),
    };
    let at_least = if seams.truncated { "at least " } else { "" };
    session.warn(format!(
        "boundaries touch without being joined, and nothing crosses them: {at_least}{}{gap}; {}",
        parts.join("; "),
        remedy(&seams)
    ));
}

fn counted(count: usize, one: &'static str, many: &'static str) -> (String, &'static str) {
    if count == 1 { ("1 boundary vertex".into(), one) } else { (format!("{count} boundary vertices"), many) }
}
