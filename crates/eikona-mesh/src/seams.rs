//! Seams, cracks and T-junctions: places where boundaries of a surface touch without being joined.

use crate::error::Fault;
use crate::id::{Edge, Halfedge, Vertex};
use crate::mesh::TriangleMesh;
use crate::near::NearVertices;

/// The gap, relative to the diagonal of the bounding box, up to which boundaries are assumed to be
/// meant to join.
///
/// Coordinates that should be equal differ by up to 1e-7 of the mesh's size in single precision,
/// and by up to 1e-6 in text with six digits. Intended gaps are far wider. Single precision far
/// from the origin leaves wider gaps; pass a tolerance for these.
pub const SEAM_TOLERANCE: f64 = 1e-6;

/// Gaps are closed only if they are at most this share of the edges at the vertex. So no edge
/// collapses if both its endpoints move.
const SHARE_OF_EDGE: f64 = 0.25;

/// The mean number of vertices inside an edge beyond which a search stops: edges of a fan that is
/// folded within the tolerance can contain one another's endpoints, which are quadratic in number.
/// At an ordinary seam it is below 1.
const MOST_PER_EDGE: usize = 16;

/// Boundary vertices and edges that coincide, or nearly so, but are not joined. Connectivity ends
/// there: distances go around them, and regions stop.
///
/// ```
/// use eikona_mesh::{Seams, TriangleMesh, Vertex};
/// // Two triangles on one edge of a third: vertex 3 lies inside the edge from 1 to 2.
/// let positions = vec![[0., 0., 0.], [1., 0., 0.], [1., 2., 0.], [1., 1., 0.], [2., 1., 0.]];
/// let mesh = TriangleMesh::new(positions, vec![[0, 1, 2], [1, 4, 3], [3, 4, 2]])?;
/// let seams = Seams::of(&mesh);
/// assert_eq!(seams.hanging[0].vertex, Vertex(3));
/// assert_eq!((seams.hanging.len(), seams.joints.len(), seams.largest_gap()), (1, 0, 0.0));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Seams {
    /// Vertices next to another one: at the same position (a seam) or across a gap (a crack). In
    /// increasing order.
    pub joints: Vec<Joint>,
    /// Vertices inside an edge of other faces, along which the boundary runs there (T-junctions),
    /// each with the nearest such edge. In increasing order.
    pub hanging: Vec<HangingVertex>,
    /// Whether the search stopped early, because vertices lie inside so many edges that the
    /// tolerance can not be right for this mesh. What was found until then is listed.
    pub truncated: bool,
}

/// A boundary vertex next to an earlier one that it is not joined to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// The vertex.
    pub vertex: Vertex,
    /// The earlier vertex, which is itself not joined to another one.
    pub to: Vertex,
    /// Their distance, in the mesh's unit.
    pub gap: f64,
}

/// A boundary vertex inside an edge of faces that do not use it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HangingVertex {
    /// The vertex.
    pub vertex: Vertex,
    /// The edge.
    pub edge: Edge,
    /// Its distance from the edge, in the mesh's unit.
    pub gap: f64,
}

impl Seams {
    /// Finds gaps of at most [`SEAM_TOLERANCE`] times the diagonal of the bounding box.
    ///
    /// A vertex is joined only across gaps of at most a quarter of its shortest edge, so that fine
    /// parts of a large mesh do not count as cracks. A vertex with an edge of length zero is
    /// skipped.
    ///
    /// # Cost
    /// O(E log B) for B boundary vertices, and next to nothing on a closed mesh. At most about 0.5
    /// s per million faces.
    pub fn of(mesh: &TriangleMesh) -> Seams {
        Seams::within(mesh, seam_tolerance(mesh))
    }

    /// Finds gaps of at most `tolerance`, in the mesh's unit.
    pub fn within(mesh: &TriangleMesh, tolerance: f64) -> Seams {
        let (joints, contacts) = Contacts::of(mesh, tolerance);
        let mut nearest: Vec<Option<HangingVertex>> = vec![None; mesh.vertex_count()];
        let complete = contacts.each_hanging(mesh, |hanging, _| {
            let best = &mut nearest[hanging.vertex.index()];
            if best.is_none_or(|b| hanging.gap < b.gap) {
                *best = Some(hanging);
            }
        });
        Seams { joints, hanging: nearest.into_iter().flatten().collect(), truncated: !complete }
    }

    /// Returns whether nothing was found.
    pub fn is_empty(&self) -> bool {
        self.joints.is_empty() && self.hanging.is_empty()
    }

    /// Returns the widest gap; 0 if there is none.
    pub fn largest_gap(&self) -> f64 {
        let gaps = self.joints.iter().map(|j| j.gap).chain(self.hanging.iter().map(|h| h.gap));
        gaps.fold(0.0, f64::max)
    }

    /// Returns cracks and T-junctions as faults. Vertices at the same position are omitted:
    /// [`validate`](crate::validate) reports them.
    pub fn faults(&self, mesh: &TriangleMesh) -> Vec<Fault> {
        let cracks = self.joints.iter().filter(|j| j.gap > 0.0);
        let cracks = cracks.map(|j| Fault::Crack { vertex: j.vertex, to: j.to, gap: j.gap });
        let hanging = self.hanging.iter().map(|h| Fault::HangingVertex {
            vertex: h.vertex,
            edge: h.edge,
            vertices: mesh.edge_vertices(h.edge),
            gap: h.gap,
        });
        hanging.chain(cracks).collect()
    }
}

/// Returns [`SEAM_TOLERANCE`] in the unit of a mesh; 0 for a mesh beyond the range of doubles.
pub(crate) fn seam_tolerance(mesh: &TriangleMesh) -> f64 {
    let used = mesh.vertices().filter(|&v| !mesh.vertex_corners(v).is_empty());
    let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for p in used.map(|v| mesh.position(v)) {
        for k in 0..3 {
            bounds[0][k] = bounds[0][k].min(p[k]);
            bounds[1][k] = bounds[1][k].max(p[k]);
        }
    }
    let diagonal = distance(bounds[0], bounds[1]);
    if diagonal.is_finite() { SEAM_TOLERANCE * diagonal } else { 0.0 }
}

/// The boundary vertices that represent those joined to them, in a search structure.
pub(crate) struct Contacts {
    near: NearVertices,
    tolerance: f64,
    /// The maximum distance of each vertex from what it is joined to; infinite for vertices that
    /// are not on the boundary, negative for those with an edge of length zero.
    own: Vec<f64>,
    /// The vertex that each one is joined to; itself if there is none.
    pub(crate) target: Vec<u32>,
    /// Boundary edges after joining, by either endpoint.
    rim: Vec<[u32; 2]>,
}

impl Contacts {
    /// Joins each boundary vertex to the nearest earlier representative, if that is within the
    /// tolerance of both.
    pub(crate) fn of(mesh: &TriangleMesh, tolerance: f64) -> (Vec<Joint>, Contacts) {
        let own = tolerances(mesh, tolerance);
        let at_boundary: Vec<Vertex> = mesh.vertices().filter(|v| own[v.index()] < f64::INFINITY).collect();
        let mut near = NearVertices::new(at_boundary.iter().map(|&v| (mesh.position(v), v, own[v.index()])));
        let mut target: Vec<u32> = (0..mesh.vertex_count() as u32).collect();
        let mut joints = Vec::new();
        for (i, &vertex) in at_boundary.iter().enumerate().filter(|(_, v)| own[v.index()] >= 0.0) {
            let (p, within) = (mesh.position(vertex), own[vertex.index()]);
            let mut best: Option<Joint> = None;
            near.near_segment([p, p], within, |q, to, its| {
                let gap = distance(p, q);
                let before = best.is_none_or(|b| (gap, to) < (b.gap, b.to));
                if gap <= within.min(its) && before {
                    best = Some(Joint { vertex, to, gap });
                }
            });
            match best {
                Some(joint) => {
                    target[vertex.index()] = joint.to.0;
                    joints.push(joint);
                }
                None => near.activate(i),
            }
        }
        let mut rim: Vec<[u32; 2]> = boundary_edges(mesh)
            .flat_map(|e| {
                let [a, b] = mesh.edge_vertices(e).map(|v| target[v.index()]);
                [[a, b], [b, a]]
            })
            .collect();
        rim.sort_unstable();
        (joints, Contacts { near, tolerance, own, target, rim })
    }

    /// Returns whether a boundary edge at a vertex runs along the edge from `a` to `b` that
    /// contains the vertex. A boundary that crosses the edge there belongs to a part that overlaps
    /// the other one, and must not be joined.
    fn runs_along(&self, mesh: &TriangleMesh, vertex: Vertex, [a, b]: [[f64; 3]; 2], within: f64) -> bool {
        let p = mesh.position(vertex);
        let first = self.rim.partition_point(|ends| ends[0] < vertex.0);
        let own = self.rim[first..].iter().take_while(|ends| ends[0] == vertex.0);
        own.map(|ends| mesh.position(Vertex(ends[1]))).any(|q| {
            // They separate at the end of the shorter one.
            let forward = dot(sub(q, p), sub(b, a)) > 0.0;
            let end = if forward { b } else { a };
            distance_to_segment(q, [p, end]) <= within || distance_to_segment(end, [p, q]) <= within
        })
    }

    /// Returns the endpoints of an edge after joining, the smaller one first, so that edges that
    /// come to coincide are equal.
    pub(crate) fn ends(&self, mesh: &TriangleMesh, edge: Edge) -> [u32; 2] {
        let [a, b] = mesh.edge_vertices(edge).map(|v| self.target[v.index()]);
        [a.min(b), a.max(b)]
    }

    /// Visits the vertices inside each edge after joining, with their parameter from 0 at the first
    /// of [`Contacts::ends`] to 1. Stops and returns `false` after [`MOST_PER_EDGE`] times the
    /// number of edges.
    pub(crate) fn each_hanging(
        &self,
        mesh: &TriangleMesh,
        mut visit: impl FnMut(HangingVertex, f64),
    ) -> bool {
        let mut rest = MOST_PER_EDGE * mesh.edge_count();
        for edge in mesh.edges() {
            let ends = self.ends(mesh, edge);
            let [a, b] = ends.map(|v| mesh.position(Vertex(v)));
            let length = distance(a, b);
            if length == 0.0 || !length.is_finite() {
                continue;
            }
            let along = sub(b, a).map(|x| x / length);
            let within = self.tolerance.min(SHARE_OF_EDGE * length);
            self.near.near_segment([a, b], within, |p, vertex, its| {
                let within = within.min(its);
                let from = sub(p, a);
                let place = dot(from, along);
                let gap = distance(from, along.map(|x| place * x));
                let at_end = [(a, ends[0]), (b, ends[1])]
                    .into_iter()
                    .any(|(end, v)| distance(p, end) <= within.min(self.own[v as usize]));
                let place = place / length;
                if gap > within || at_end || place <= 0.0 || place >= 1.0 {
                    return;
                }
                let is_corner = |h: &Halfedge| {
                    mesh.face_vertices(h.face()).into_iter().any(|v| self.target[v.index()] == vertex.0)
                };
                if !mesh.edge_halfedges(edge).iter().any(is_corner)
                    && self.runs_along(mesh, vertex, [a, b], within)
                {
                    visit(HangingVertex { vertex, edge, gap }, place);
                    rest = rest.saturating_sub(1);
                }
            });
            if rest == 0 {
                return false;
            }
        }
        true
    }
}

/// Iterates over the edges with one face.
fn boundary_edges(mesh: &TriangleMesh) -> impl Iterator<Item = Edge> {
    mesh.edges().filter(|&e| mesh.is_boundary_edge(e))
}

/// Computes [`Contacts::own`].
fn tolerances(mesh: &TriangleMesh, tolerance: f64) -> Vec<f64> {
    let mut own = vec![f64::INFINITY; mesh.vertex_count()];
    for e in boundary_edges(mesh) {
        mesh.edge_vertices(e).into_iter().for_each(|v| own[v.index()] = tolerance);
    }
    for v in mesh.vertices().filter(|v| own[v.index()] < f64::INFINITY).collect::<Vec<_>>() {
        let neighbours = mesh.vertex_corners(v).iter().flat_map(|c| {
            let h = c.halfedge();
            [mesh.tip(h), mesh.origin(h.previous())]
        });
        let lengths = neighbours.map(|w| distance(mesh.position(v), mesh.position(w)));
        let shortest = lengths.fold(f64::INFINITY, f64::min);
        own[v.index()] = if shortest == 0.0 { -1.0 } else { tolerance.min(SHARE_OF_EDGE * shortest) };
    }
    own
}

/// Returns the distance between two points, at any scale. Infinite only if it is beyond the range
/// of doubles.
fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1]).hypot(a[2] - b[2])
}

/// Returns the distance of a point from a segment of positive length.
fn distance_to_segment(p: [f64; 3], [a, b]: [[f64; 3]; 2]) -> f64 {
    let length = distance(a, b);
    let along = sub(b, a).map(|x| x / length);
    let from = sub(p, a);
    let place = dot(from, along).clamp(0.0, length);
    distance(from, along.map(|x| place * x))
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
