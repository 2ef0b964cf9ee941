//! Stitches boundaries of a surface where they meet: at nearby vertices, and at vertices inside
//! edges.

use crate::error::MeshError;
use crate::id::{Edge, Face, Vertex};
use crate::mesh::TriangleMesh;
use crate::point::SurfacePoint;
use crate::provenance::Provenance;
use crate::repair::keep_vertices;
use crate::seams::{Contacts, seam_tolerance};

/// A mesh whose seams, cracks and T-junctions are closed.
#[derive(Clone, Debug)]
pub struct Stitched {
    /// The new mesh. Vertices that are kept stay in order and in place; the parts of a face take
    /// its place in the order.
    pub mesh: TriangleMesh,
    /// Where its vertices and faces come from. Joined vertices have the same new one.
    pub provenance: Provenance,
    /// Number of vertices that were joined to another one.
    pub joined_vertices: usize,
    /// Number of vertices that were inserted into the edges that contained them.
    pub inserted_vertices: usize,
    /// Number of faces that were subdivided.
    pub divided_faces: usize,
    /// The widest gap that was closed, in the mesh's unit.
    pub largest_gap: f64,
    old: TriangleMesh,
    inside: InsideEdges,
}

/// Joins nearby boundary vertices, and subdivides the edges (and their faces) that contain boundary
/// vertices. This closes what [`Seams`](crate::Seams) finds within the tolerance; by default, what
/// [`Seams::of`](crate::Seams::of) finds.
///
/// No vertex is added. A joined vertex moves by at most the tolerance; one inside an edge stays in
/// place, and the edge bends by at most the tolerance. The result may be nonmanifold where more
/// than two parts meet. Faces keep their orientation: where parts are inconsistently oriented, call
/// [`orient`](crate::orient) next.
///
/// # Errors
/// [`MeshError::Parameter`] if the tolerance is negative, not finite, or so large that edges
/// contain most of the mesh's vertices; [`MeshError::TooLarge`] if there would be more faces than
/// 32-bit indices can address.
///
/// # Cost
/// O(E log B) for B boundary vertices, plus the number of new faces.
///
/// ```
/// use eikona_mesh::{Face, Seams, TriangleMesh, stitch};
/// // Two triangles on one edge of a third: vertex 3 lies inside the edge from 1 to 2.
/// let positions = vec![[0., 0., 0.], [1., 0., 0.], [1., 2., 0.], [1., 1., 0.], [2., 1., 0.]];
/// let mesh = TriangleMesh::new(positions, vec![[0, 1, 2], [1, 4, 3], [3, 4, 2]])?;
/// let stitched = stitch(&mesh, None)?;
/// assert_eq!(stitched.mesh.triangles(), [[1, 3, 0], [3, 2, 0], [1, 4, 3], [3, 4, 2]]);
/// assert!(stitched.provenance.face_parents().eq([0, 0, 1, 2].map(Face)));
/// assert!(Seams::of(&stitched.mesh).is_empty());
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn stitch(mesh: &TriangleMesh, tolerance: Option<f64>) -> Result<Stitched, MeshError> {
    let tolerance = tolerance.unwrap_or_else(|| seam_tolerance(mesh));
    let refused =
        |bound| Err(MeshError::Parameter { name: "tolerance", value: tolerance.to_string(), bound });
    if !(tolerance >= 0.0 && tolerance.is_finite()) {
        return refused("it must be a finite length of 0 or more");
    }
    let (joints, contacts) = Contacts::of(mesh, tolerance);
    let (positions, vertices) = keep_vertices(mesh.positions(), &contacts.target);
    let mut largest_gap = joints.iter().map(|j| j.gap).fold(0.0, f64::max);
    let mut inside = InsideEdges { vertices: Vec::new() };
    let complete = contacts.each_hanging(mesh, |hanging, place| {
        largest_gap = largest_gap.max(hanging.gap);
        let [first, _] = contacts.ends(mesh, hanging.edge);
        let forward = contacts.target[mesh.edge_vertices(hanging.edge)[0].index()] == first;
        let place = if forward { place } else { 1.0 - place };
        inside.vertices.push((hanging.edge, place, vertices[hanging.vertex.index()]));
    });
    if !complete {
        return refused(
            "give a smaller tolerance; within this one, edges overlap and contain each other's vertices",
        );
    }
    inside.vertices.sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));

    let mut faces = Vec::with_capacity(mesh.face_count());
    let mut parent = Vec::with_capacity(mesh.face_count());
    let mut divided_faces = 0;
    for face in mesh.faces() {
        let corners = mesh.face_vertices(face).map(|v| vertices[v.index()].0);
        let sides = inside.sides(mesh, face).map(|side| side.into_iter().map(|(_, v)| v.0).collect());
        let before = faces.len();
        divide(corners, &sides, &mut faces);
        divided_faces += usize::from(faces.len() > before + 1);
        parent.resize(faces.len(), face);
    }
    let mut inserted: Vec<Vertex> = inside.vertices.iter().map(|x| x.2).collect();
    inserted.sort_unstable();
    inserted.dedup();
    let provenance = Provenance::identity(mesh.vertex_count(), mesh.face_count())
        .with_new_vertices(vertices.into_iter().map(Some).collect())
        .with_face_parents(parent);
    Ok(Stitched {
        mesh: TriangleMesh::new(positions, faces)?,
        provenance,
        joined_vertices: joints.len(),
        inserted_vertices: inserted.len(),
        divided_faces,
        largest_gap,
        old: mesh.clone(),
        inside,
    })
}

impl Stitched {
    /// Returns whether the mesh was changed at all.
    pub fn is_changed(&self) -> bool {
        self.joined_vertices > 0 || self.divided_faces > 0
    }

    /// Maps a point of the old mesh to the new one. A point that is not on the old mesh keeps its
    /// weights, with new vertices.
    ///
    /// # Cost
    /// O(log E) for a vertex or edge; linear in the number of parts for a point in a face.
    pub fn point(&self, point: SurfacePoint) -> SurfacePoint {
        let divided = match point {
            SurfacePoint::Vertex { .. } => None,
            SurfacePoint::Edge { vertices, t } => {
                let [a, b] = vertices.map(Vertex);
                self.old.find_edge(a, b).map(|edge| self.point_on_edge(edge, a, t))
            }
            SurfacePoint::Face { vertices, bary } => {
                let face = self.old.find_face(vertices.map(Vertex));
                face.and_then(|f| self.point_in_face(f, vertices, bary))
            }
        };
        divided.unwrap_or_else(|| self.provenance.rename(point))
    }

    /// Returns the new vertex of an old one: none is dropped.
    fn new_vertex(&self, old: Vertex) -> Vertex {
        self.provenance.new_vertex(old).unwrap_or(old)
    }

    fn point_on_edge(&self, edge: Edge, first: Vertex, t: f64) -> SurfacePoint {
        let [a, b] = self.old.edge_vertices(edge);
        let t = if a == first { t } else { 1.0 - t };
        let inside = self.inside.of(edge);
        let after = inside.partition_point(|x| x.1 <= t);
        let (from, low) = match after.checked_sub(1) {
            Some(i) => (inside[i].2, inside[i].1),
            None => (self.new_vertex(a), 0.0),
        };
        let (to, high) = inside.get(after).map_or((self.new_vertex(b), 1.0), |x| (x.2, x.1));
        if from == to || t == low {
            return SurfacePoint::Vertex { vertex: from.0 };
        }
        if t == high {
            return SurfacePoint::Vertex { vertex: to.0 };
        }
        SurfacePoint::Edge { vertices: [from.0, to.0], t: (t - low) / (high - low) }
    }

    /// Returns `None` if the face is not subdivided.
    fn point_in_face(&self, face: Face, named: [u32; 3], bary: [f64; 3]) -> Option<SurfacePoint> {
        let parts = self.provenance.face_parts(face);
        if parts.len() < 2 {
            return None;
        }
        let corners = self.old.face_vertices(face);
        let weight = |v: Vertex| named.iter().position(|n| *n == v.0).map_or(0.0, |k| bary[k]);
        let target = corners.map(weight);
        // The weights in the old face of each vertex of its parts.
        let mut places: Vec<(Vertex, [f64; 3])> = Vec::new();
        for (k, side) in self.inside.sides(&self.old, face).into_iter().enumerate() {
            let mut at = [0.0; 3];
            at[k] = 1.0;
            places.push((self.new_vertex(corners[k]), at));
            for (place, v) in side {
                let mut at = [0.0; 3];
                (at[k], at[(k + 1) % 3]) = (1.0 - place, place);
                places.push((v, at));
            }
        }
        places.sort_by_key(|p| p.0);
        let place = |v: Vertex| places.binary_search_by_key(&v, |p| p.0).ok().map(|i| places[i].1);
        let mut best: Option<(f64, SurfacePoint)> = None;
        for part in parts {
            let vertices = self.mesh.face_vertices(part);
            let [Some(a), Some(b), Some(c)] = vertices.map(place) else { continue };
            let whole = signed_area(a, b, c);
            let weights = [
                signed_area(target, b, c) / whole,
                signed_area(a, target, c) / whole,
                signed_area(a, b, target) / whole,
            ];
            let least = weights.iter().fold(f64::INFINITY, |m, w| m.min(*w));
            if best.is_none_or(|b| least > b.0) {
                let positive = weights.map(|w| w.max(0.0));
                let sum: f64 = positive.iter().sum();
                let bary = positive.map(|w| w / sum);
                best = Some((least, SurfacePoint::Face { vertices: vertices.map(|v| v.0), bary }));
            }
        }
        best.map(|b| b.1)
    }
}

/// Returns twice the area of a triangle given by barycentric weights, relative to that of the whole
/// face.
fn signed_area(a: [f64; 3], b: [f64; 3], c: [f64; 3]) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1])
        + a[1] * (b[2] * c[0] - b[0] * c[2])
        + a[2] * (b[0] * c[1] - b[1] * c[0])
}

/// The vertices inside old edges, with their parameter from 0 at the first endpoint of the edge to
/// 1; sorted.
#[derive(Clone, Debug)]
struct InsideEdges {
    vertices: Vec<(Edge, f64, Vertex)>,
}

impl InsideEdges {
    fn of(&self, edge: Edge) -> &[(Edge, f64, Vertex)] {
        let start = self.vertices.partition_point(|x| x.0 < edge);
        let count = self.vertices[start..].partition_point(|x| x.0 == edge);
        &self.vertices[start..start + count]
    }

    /// Returns the vertices inside the sides of a face, in its direction. In a face so thin that a
    /// vertex lies inside two sides, the vertex is assigned to the first one.
    fn sides(&self, mesh: &TriangleMesh, face: Face) -> [Vec<(f64, Vertex)>; 3] {
        let mut sides = [0, 1, 2].map(|k| {
            let halfedge = face.halfedge(k);
            let mut side: Vec<_> = self.of(mesh.edge(halfedge)).iter().map(|&(_, t, v)| (t, v)).collect();
            if !mesh.follows_edge(halfedge) {
                side.reverse();
                side.iter_mut().for_each(|x| x.0 = 1.0 - x.0);
            }
            side
        });
        if sides.iter().filter(|side| !side.is_empty()).count() > 1 {
            let mut taken: Vec<(Vertex, usize)> =
                (0..3).flat_map(|k| sides[k].iter().map(move |x| (x.1, k))).collect();
            taken.sort_unstable();
            taken.dedup_by_key(|x| x.0);
            for (k, side) in sides.iter_mut().enumerate() {
                side.retain(|x| taken.binary_search(&(x.1, k)).is_ok());
            }
        }
        sides
    }
}

/// Subdivides a triangle with vertices on its sides into triangles of positive area. A triangle
/// that has lost a corner gives none.
fn divide(corners: [u32; 3], sides: &[Vec<u32>; 3], faces: &mut Vec<[u32; 3]>) {
    let [a, b, c] = corners;
    if a == b || b == c || c == a {
        return;
    }
    // A fan from the corner opposite the most subdivided side; its first and last triangle get the
    // other two sides.
    let base = (1..3).fold(0, |best, k| if sides[k].len() > sides[best].len() { k } else { best });
    let [next, last] = [(base + 1) % 3, (base + 2) % 3];
    let apex = corners[last];
    let mut row = Vec::with_capacity(sides[base].len() + 2);
    row.push(corners[base]);
    row.extend(&sides[base]);
    row.push(corners[next]);
    for (i, pair) in row.windows(2).enumerate() {
        let from_first = i == 0 && !sides[last].is_empty();
        let to_last = i + 2 == row.len() && !sides[next].is_empty();
        match (from_first, to_last) {
            (false, false) => faces.push([pair[0], pair[1], apex]),
            // Then the base is subdivided, being the most subdivided side, and no triangle has both
            // other sides.
            (true, _) => fan(pair[1], apex, &sides[last], pair[0], faces),
            (false, true) => fan(pair[0], pair[1], &sides[next], apex, faces),
        }
    }
}

/// Adds the triangles from `apex` to the parts of the side from `first` to `last`.
fn fan(apex: u32, first: u32, inside: &[u32], last: u32, faces: &mut Vec<[u32; 3]>) {
    let mut from = first;
    for &to in inside.iter().chain([&last]) {
        faces.push([apex, from, to]);
        from = to;
    }
}
