//! Repairs of a mesh. Each is an explicit function that returns the new mesh and its
//! [`Provenance`].

use crate::duplicates::{first_at_position, first_with_same_vertices};
use crate::error::{Fault, MeshError};
use crate::fan::umbrellas;
use crate::id::{Face, Vertex};
use crate::mesh::{TriangleMesh, structural_faults};
use crate::orientation::Orientation;
use crate::point::SurfacePoint;
use crate::polygon::{PolygonMesh, cut_polygon};
use crate::provenance::Provenance;
use crate::quality::TriangleShape;
use std::collections::HashMap;

/// A repaired mesh.
#[derive(Clone, Debug)]
pub struct Repaired {
    /// The new mesh. Vertices and faces that are kept stay in order.
    pub mesh: TriangleMesh,
    /// Where its vertices and faces come from.
    pub provenance: Provenance,
}

/// A repaired polygon mesh.
#[derive(Clone, Debug)]
pub struct RepairedPolygons {
    /// The new mesh. Vertices and faces that are kept stay in order.
    pub mesh: PolygonMesh,
    /// Where its vertices and faces come from.
    pub provenance: Provenance,
}

/// Merges coincident or nearby vertices, and drops the faces that lose a corner by it.
///
/// With tolerance 0, vertices with equal coordinates are merged. With a larger one, each vertex in
/// order is merged into the nearest vertex kept before it that is at most `tolerance` (in the
/// mesh's unit) away, or else is kept. So no vertex moves by more than the tolerance, and kept
/// vertices do not move; but two nearby vertices may stay apart if they are merged into different
/// ones.
///
/// # Errors
/// [`MeshError::Parameter`] if the tolerance is negative, not finite, or too small relative to the
/// coordinates to exceed rounding (below 1e-13 of the largest coordinate); use 0 instead.
///
/// # Cost
/// O(V + F); for a million separate triangles about 0.5 s at tolerance 0 and 1 s at a larger one.
pub fn weld(mesh: &TriangleMesh, tolerance: f64) -> Result<Repaired, MeshError> {
    let target = weld_targets(mesh.positions(), tolerance)?;
    let (positions, vertex_map) = keep_vertices(mesh.positions(), &target);
    let merged: Vec<[u32; 3]> =
        mesh.triangles().iter().map(|face| face.map(|v| vertex_map[v as usize].0)).collect();
    let keep = |[a, b, c]: [u32; 3]| a != b && b != c && c != a;
    let provenance = Provenance::identity(mesh.vertex_count(), mesh.face_count())
        .with_new_vertices(vertex_map.into_iter().map(Some).collect())
        .with_face_parents(mesh.faces().filter(|f| keep(merged[f.index()])).collect());
    let faces = merged.into_iter().filter(|&f| keep(f)).collect();
    Ok(Repaired { mesh: TriangleMesh::new(positions, faces)?, provenance })
}

/// Merges vertices like [`weld`], for polygons. A corner that follows one at the same vertex is
/// omitted; a polygon with fewer than three corners left is dropped.
///
/// A polygon that revisits a vertex after others is kept with all its corners: it may enclose a
/// hole.
///
/// # Errors
/// As for [`weld`]; also [`MeshError::Invalid`] with all vertices that are not finite and all faces
/// that refer to a vertex that does not exist.
pub fn weld_polygons(mesh: &PolygonMesh, tolerance: f64) -> Result<RepairedPolygons, MeshError> {
    let faults = faults_of_polygons(mesh);
    if !faults.is_empty() {
        return Err(MeshError::Invalid(faults));
    }
    let target = weld_targets(&mesh.positions, tolerance)?;
    let (positions, vertex_map) = keep_vertices(&mesh.positions, &target);
    let mut welded = PolygonMesh::new(positions);
    let mut kept = Vec::with_capacity(mesh.face_count());
    for (f, face) in mesh.faces().enumerate() {
        let corners = without_doubled(face.iter().map(|&v| vertex_map[v as usize].0).collect());
        if corners.len() >= 3 {
            kept.push(Face(f as u32));
            welded.push_face(corners);
        }
    }
    let provenance = Provenance::identity(mesh.vertex_count(), mesh.face_count())
        .with_new_vertices(vertex_map.into_iter().map(Some).collect())
        .with_face_parents(kept);
    Ok(RepairedPolygons { mesh: welded, provenance })
}

/// Removes what can not be triangulated: corners that follow one at the same vertex, then polygons
/// with fewer than three corners, or with a repeated vertex and no enclosed area. The vertices
/// stay.
///
/// Polygons around holes, which visit both ends of a bridge to the hole twice, are kept.
///
/// ```
/// use eikona_mesh::{Face, PolygonMesh, drop_broken_polygons};
/// let mut mesh = PolygonMesh::new(vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]]);
/// mesh.push_face([0, 1, 1]);
/// mesh.push_face([0, 1, 1, 2]);
/// let dropped = drop_broken_polygons(&mesh);
/// assert_eq!(dropped.provenance.dropped_faces(), [Face(0)]);
/// assert_eq!(dropped.mesh.face(0), [0, 1, 2]);
/// ```
pub fn drop_broken_polygons(mesh: &PolygonMesh) -> RepairedPolygons {
    let in_range = |corners: &[u32]| corners.iter().all(|v| (*v as usize) < mesh.vertex_count());
    let mut triangles = Vec::new();
    let mut whole = |corners: &[u32]| {
        triangles.clear();
        // Indices out of range are a separate fault, which triangulation reports.
        let cut = |triangles| !in_range(corners) || cut_polygon(corners, &mesh.positions, triangles).is_ok();
        corners.len() >= 3 && cut(&mut triangles)
    };
    let mut rest = PolygonMesh::new(mesh.positions.clone());
    let mut kept = Vec::with_capacity(mesh.face_count());
    for (f, face) in mesh.faces().enumerate() {
        let corners = without_doubled(face.to_vec());
        if whole(&corners) {
            kept.push(Face(f as u32));
            rest.push_face(corners);
        }
    }
    let provenance = Provenance::identity(mesh.vertex_count(), mesh.face_count()).with_face_parents(kept);
    RepairedPolygons { mesh: rest, provenance }
}

/// Removes the corners that follow one at the same vertex.
fn without_doubled(mut corners: Vec<u32>) -> Vec<u32> {
    corners.dedup();
    while corners.len() > 1 && corners.first() == corners.last() {
        corners.pop();
    }
    corners
}

/// Drops the faces whose area is below [`ZERO_AREA`](crate::ZERO_AREA) times the square of their
/// longest edge.
///
/// The vertices stay. Where such a face was a sliver between two others, it leaves a slit with a
/// boundary of its own; weld first if its vertices coincide.
pub fn drop_degenerate_faces(mesh: &TriangleMesh) -> Repaired {
    keep_faces(mesh, |f| !TriangleShape::of(mesh.face_positions(f)).is_zero_area())
}

/// Drops every face that has the same three vertices as an earlier one, in either orientation. The
/// vertices stay.
///
/// # Cost
/// O(F log F).
pub fn drop_duplicate_faces(mesh: &TriangleMesh) -> Repaired {
    let first = first_with_same_vertices(mesh);
    keep_faces(mesh, |f| first[f.index()] == f)
}

/// Drops the unreferenced vertices. The faces stay.
pub fn drop_unreferenced_vertices(mesh: &TriangleMesh) -> Repaired {
    let mut positions = Vec::with_capacity(mesh.vertex_count());
    let new = mesh.vertices().map(|v| {
        let is_used = !mesh.vertex_corners(v).is_empty();
        is_used.then(|| {
            positions.push(mesh.position(v));
            Vertex(positions.len() as u32 - 1)
        })
    });
    let new: Vec<Option<Vertex>> = new.collect();
    let renumber = |v: u32| new[v as usize].map_or(v, |w| w.0);
    let faces = mesh.triangles().iter().map(|face| face.map(renumber)).collect();
    let provenance = Provenance::identity(mesh.vertex_count(), mesh.face_count()).with_new_vertices(new);
    Repaired { mesh: rebuilt(positions, faces), provenance }
}

/// Flips faces until all are consistently oriented, as determined by [`Orientation`]. Vertices and
/// faces keep their ids.
///
/// Nonorientable patches stay as they are; edges with three or more faces may still have faces that
/// run the same way.
pub fn orient(mesh: &TriangleMesh) -> Repaired {
    let orientation = Orientation::of(mesh);
    let provenance = Provenance::identity(mesh.vertex_count(), mesh.face_count())
        .with_flipped_faces(orientation.flipped_faces());
    Repaired { mesh: orientation.oriented(mesh), provenance }
}

/// Duplicates vertices so that each has at most one vertex fan. The first fan (that of the lowest
/// face) keeps the vertex; every other fan gets a copy.
///
/// Old vertices and all faces keep their ids; the copies follow the old vertices. Edges with three
/// or more faces stay.
///
/// # Errors
/// [`MeshError::TooLarge`] if there would be more vertices than 32-bit indices can name.
pub fn split_nonmanifold_vertices(mesh: &TriangleMesh) -> Result<Repaired, MeshError> {
    let mut fans = umbrellas(mesh);
    let mut faces = mesh.triangles().to_vec();
    let mut source: Vec<Vertex> = mesh.vertices().collect();
    let mut vertex_of_fan: Vec<(u32, u32)> = Vec::new();
    for v in mesh.vertices() {
        vertex_of_fan.clear();
        for &c in mesh.vertex_corners(v) {
            // The representative of a fan is its smallest corner, and corners are visited in
            // increasing order, so fans are too.
            let fan = fans.find(c.0);
            let vertex = match vertex_of_fan.binary_search_by_key(&fan, |x| x.0) {
                Ok(i) => vertex_of_fan[i].1,
                Err(_) => {
                    let vertex = if vertex_of_fan.is_empty() {
                        v.0
                    } else {
                        source.push(v);
                        source.len() as u32 - 1
                    };
                    vertex_of_fan.push((fan, vertex));
                    vertex
                }
            };
            faces[c.face().index()][c.halfedge().side()] = vertex;
        }
    }
    let positions = source.iter().map(|&v| mesh.position(v)).collect();
    let places: Vec<SurfacePoint> = source.into_iter().map(SurfacePoint::from).collect();
    let provenance = Provenance::identity(mesh.vertex_count(), mesh.face_count()).with_vertex_places(&places);
    Ok(Repaired { mesh: TriangleMesh::new(positions, faces)?, provenance })
}

/// Returns the vertices that are not finite and the faces that refer to a vertex that does not
/// exist.
fn faults_of_polygons(mesh: &PolygonMesh) -> Vec<Fault> {
    let vertices = mesh.vertex_count();
    let mut faults = structural_faults(&mesh.positions, &[]);
    for (f, corners) in mesh.faces().enumerate() {
        let face = Face(f as u32);
        let outside = corners.iter().filter(|v| **v as usize >= vertices);
        faults.extend(outside.map(|&v| Fault::IndexOutOfRange { face, index: v as i64, vertices }));
    }
    faults
}

fn keep_faces(mesh: &TriangleMesh, keep: impl Fn(Face) -> bool) -> Repaired {
    let kept: Vec<Face> = mesh.faces().filter(|f| keep(*f)).collect();
    let faces = kept.iter().map(|f| mesh.triangles()[f.index()]).collect();
    let provenance = Provenance::identity(mesh.vertex_count(), mesh.face_count()).with_face_parents(kept);
    Repaired { mesh: rebuilt(mesh.positions().to_vec(), faces), provenance }
}

/// Rebuilds a mesh from part of a valid one: its own coordinates, its faces renumbered.
fn rebuilt(positions: Vec<[f64; 3]>, faces: Vec<[u32; 3]>) -> TriangleMesh {
    TriangleMesh::new(positions, faces).expect("parts of a valid mesh are valid")
}

/// Returns the positions of the vertices that are their own target, and the new number of each
/// vertex. A target never comes after the vertices merged into it.
pub(crate) fn keep_vertices(positions: &[[f64; 3]], target: &[u32]) -> (Vec<[f64; 3]>, Vec<Vertex>) {
    let mut kept = Vec::new();
    let mut map: Vec<Vertex> = Vec::with_capacity(positions.len());
    for (v, &t) in target.iter().enumerate() {
        if t as usize == v {
            map.push(Vertex(kept.len() as u32));
            kept.push(positions[v]);
        } else {
            map.push(map[t as usize]);
        }
    }
    (kept, map)
}

/// Returns the vertex that each one is merged into: itself, or an earlier one that is its own
/// target.
fn weld_targets(positions: &[[f64; 3]], tolerance: f64) -> Result<Vec<u32>, MeshError> {
    let largest = positions.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
    // Cell coordinates in the grid of `nearest_kept` must be exact to a small part of a cell: below
    // 2^-10 with this bound.
    const TOLERANCES: f64 = 1e13;
    if !tolerance.is_finite() || tolerance < 0.0 || (tolerance > 0.0 && largest / tolerance > TOLERANCES) {
        return Err(MeshError::Parameter {
            name: "tolerance",
            value: tolerance.to_string(),
            bound: "it must be 0 (for equal positions) or at least 1e-13 times the largest coordinate",
        });
    }
    Ok(if tolerance == 0.0 { first_at_position(positions) } else { nearest_kept(positions, tolerance) })
}

/// Returns, for each position, the nearest one kept before it within the tolerance; if there is
/// none, itself, and it is kept.
///
/// Kept positions are more than the tolerance apart, so a grid cell of four times that size
/// contains a bounded number of them.
fn nearest_kept(positions: &[[f64; 3]], tolerance: f64) -> Vec<u32> {
    const END: u32 = u32::MAX;
    const CELL: f64 = 4.0;
    // The tolerance in cells, with a margin for rounding.
    const REACH: f64 = 1.02 / CELL;
    let first = first_at_position(positions);
    // The last vertex kept in each cell; the others are linked by `previous`.
    let mut last_in_cell: HashMap<[i64; 3], u32> = HashMap::new();
    let mut previous = vec![END; positions.len()];
    let mut target: Vec<u32> = Vec::with_capacity(positions.len());
    for (i, p) in positions.iter().enumerate() {
        let equal = first[i] as usize;
        if equal < i && target[equal] == first[i] {
            target.push(first[i]); // nothing is nearer than a kept vertex at the same position
            continue;
        }
        let place = p.map(|x| x / tolerance / CELL);
        let low = place.map(|u| (u - REACH).floor() as i64);
        let high = place.map(|u| (u + REACH).floor() as i64);
        let mut best: Option<(f64, u32)> = None;
        for (x, y, z) in (low[0]..=high[0])
            .flat_map(|x| (low[1]..=high[1]).flat_map(move |y| (low[2]..=high[2]).map(move |z| (x, y, z))))
        {
            let mut at = last_in_cell.get(&[x, y, z]).copied().unwrap_or(END);
            while at != END {
                let q = positions[at as usize];
                let apart_sq: f64 = (0..3).map(|k| ((p[k] - q[k]) / tolerance).powi(2)).sum();
                if apart_sq <= 1.0 && best.is_none_or(|b| (apart_sq, at) < b) {
                    best = Some((apart_sq, at));
                }
                at = previous[at as usize];
            }
        }
        target.push(best.map_or(i as u32, |b| b.1));
        if best.is_none() {
            previous[i] = last_in_cell.insert(place.map(|u| u.floor() as i64), i as u32).unwrap_or(END);
        }
    }
    target
}
