//! The triangle mesh: positions, faces, and connectivity that represents nonmanifold edges
//! explicitly.

use crate::error::{Fault, MeshError};
use crate::id::{Corner, Edge, Face, Halfedge, Vertex};
use crate::polygon::PolygonMesh;
use std::sync::Arc;

/// A triangle mesh of any kind: open or closed, with one or many components, manifold or not,
/// consistently oriented or not.
///
/// Vertices and faces keep the order and count of the input. Guaranteed: every index is in range,
/// the three corners of a face are three different vertices, every coordinate is finite. Nothing
/// else is; see [`Topology`](crate::Topology), [`Quality`](crate::Quality) and
/// [`validate`](crate::validate).
///
/// Halfedge `3 f + k` is side `k` of face `f`; edge `i` is the `i`-th one met when the faces are
/// visited in order.
///
/// ```
/// use eikona_mesh::{TriangleMesh, Neighbour, Face};
/// let mesh = TriangleMesh::new(
///     vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]],
///     vec![[0, 1, 2], [0, 2, 3]],
/// )?;
/// assert_eq!((mesh.vertex_count(), mesh.edge_count(), mesh.face_count()), (4, 5, 2));
/// assert_eq!(mesh.neighbour(Face(0).halfedge(2)), Neighbour::Twin(Face(1).halfedge(0)));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
///
/// Clones share their data: copying a mesh costs nothing.
#[derive(Clone, Debug)]
pub struct TriangleMesh {
    positions: Arc<Vec<[f64; 3]>>,
    connectivity: Arc<Connectivity>,
}

#[derive(Debug)]
struct Connectivity {
    faces: Vec<[u32; 3]>,
    /// Edge of each halfedge.
    halfedge_edge: Vec<u32>,
    /// The two endpoints of each edge, in the direction in which it was first met.
    edge_vertices: Vec<[u32; 2]>,
    /// The halfedges of edge `e` are `edge_halfedges[edge_start[e]..edge_start[e + 1]]`, in
    /// increasing order.
    edge_start: Vec<u32>,
    edge_halfedges: Vec<Halfedge>,
    /// The corners at vertex `v` are `vertex_corners[vertex_start[v]..vertex_start[v + 1]]`, in
    /// increasing order.
    vertex_start: Vec<u32>,
    vertex_corners: Vec<Corner>,
}

/// The other side of a halfedge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Neighbour<'a> {
    /// No face: the edge is on the boundary.
    Boundary,
    /// Exactly one other face. (Its halfedge runs the opposite way only if the two faces are
    /// consistently oriented.)
    Twin(Halfedge),
    /// Two or more other faces: all halfedges of the edge, including this one.
    Nonmanifold(&'a [Halfedge]),
}

impl TriangleMesh {
    /// Builds the mesh and its connectivity.
    ///
    /// # Errors
    /// [`MeshError::Invalid`] with *every* vertex that is not finite and every face that repeats a
    /// vertex or refers to one that does not exist; [`MeshError::TooLarge`] past 2^32 / 3 faces.
    ///
    /// # Cost
    /// O(V + F log d) for vertex degrees d; about 0.1 s per million faces.
    pub fn new(positions: Vec<[f64; 3]>, faces: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        if faces.len() > (u32::MAX / 3) as usize || positions.len() >= u32::MAX as usize {
            return Err(MeshError::TooLarge { vertices: positions.len(), faces: faces.len() });
        }
        let faults = structural_faults(&positions, &faces);
        if !faults.is_empty() {
            return Err(MeshError::Invalid(faults));
        }
        let (vertex_start, vertex_corners) = corners_by_vertex(positions.len(), &faces);
        let (halfedge_edge, edge_vertices) = number_edges(positions.len(), &faces);
        let (edge_start, edge_halfedges) = halfedges_by_edge(edge_vertices.len(), &halfedge_edge);
        let connectivity = Connectivity {
            faces,
            halfedge_edge,
            edge_vertices,
            edge_start,
            edge_halfedges,
            vertex_start,
            vertex_corners,
        };
        Ok(TriangleMesh { positions: Arc::new(positions), connectivity: Arc::new(connectivity) })
    }

    /// Returns the number of vertices, including unreferenced ones.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }
    /// Returns the number of edges.
    pub fn edge_count(&self) -> usize {
        self.connectivity.edge_vertices.len()
    }
    /// Returns the number of faces.
    pub fn face_count(&self) -> usize {
        self.connectivity.faces.len()
    }
    /// Returns the number of halfedges (and of corners): three per face.
    pub fn halfedge_count(&self) -> usize {
        self.connectivity.halfedge_edge.len()
    }
    /// Iterates over all vertices.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = Vertex> + use<> {
        (0..self.positions.len() as u32).map(Vertex)
    }
    /// Iterates over all edges.
    pub fn edges(&self) -> impl ExactSizeIterator<Item = Edge> + use<> {
        (0..self.connectivity.edge_vertices.len() as u32).map(Edge)
    }
    /// Iterates over all faces.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = Face> + use<> {
        (0..self.connectivity.faces.len() as u32).map(Face)
    }
    /// Returns the positions of the vertices, in order.
    pub fn positions(&self) -> &[[f64; 3]] {
        &self.positions
    }
    /// Returns the vertex indices of the faces, in order.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.connectivity.faces
    }
    /// Returns the position of a vertex.
    #[inline]
    pub fn position(&self, v: Vertex) -> [f64; 3] {
        self.positions[v.index()]
    }
    /// Returns the positions of the three corners of a face.
    #[inline]
    pub fn face_positions(&self, f: Face) -> [[f64; 3]; 3] {
        self.connectivity.faces[f.index()].map(|v| self.positions[v as usize])
    }
    /// Returns the three vertices of a face, in its orientation.
    #[inline]
    pub fn face_vertices(&self, f: Face) -> [Vertex; 3] {
        self.connectivity.faces[f.index()].map(Vertex)
    }
    /// Returns the three edges of a face; edge `k` joins corners `k` and `k + 1`.
    #[inline]
    pub fn face_edges(&self, f: Face) -> [Edge; 3] {
        let h = 3 * f.index();
        [0, 1, 2].map(|k| Edge(self.connectivity.halfedge_edge[h + k]))
    }
    /// Returns the edge of a halfedge.
    #[inline]
    pub fn edge(&self, h: Halfedge) -> Edge {
        Edge(self.connectivity.halfedge_edge[h.index()])
    }
    /// Returns the vertex at which a halfedge starts.
    #[inline]
    pub fn origin(&self, h: Halfedge) -> Vertex {
        Vertex(self.connectivity.faces[h.face().index()][h.side()])
    }
    /// Returns the vertex at which a halfedge ends.
    #[inline]
    pub fn tip(&self, h: Halfedge) -> Vertex {
        self.origin(h.next())
    }
    /// Returns the vertex of a corner.
    #[inline]
    pub fn corner_vertex(&self, c: Corner) -> Vertex {
        self.origin(c.halfedge())
    }
    /// Returns the two endpoints of an edge, in the edge's own direction: that of its first
    /// halfedge.
    #[inline]
    pub fn edge_vertices(&self, e: Edge) -> [Vertex; 2] {
        self.connectivity.edge_vertices[e.index()].map(Vertex)
    }
    /// Returns the halfedges of an edge, in increasing order: one on the boundary, two in the
    /// interior, more at a nonmanifold edge.
    #[inline]
    pub fn edge_halfedges(&self, e: Edge) -> &[Halfedge] {
        let e = e.index();
        &self.connectivity.edge_halfedges
            [self.connectivity.edge_start[e] as usize..self.connectivity.edge_start[e + 1] as usize]
    }
    /// Returns the corners at a vertex, in the order of their faces (not around the vertex).
    #[inline]
    pub fn vertex_corners(&self, v: Vertex) -> &[Corner] {
        let v = v.index();
        &self.connectivity.vertex_corners
            [self.connectivity.vertex_start[v] as usize..self.connectivity.vertex_start[v + 1] as usize]
    }
    /// Returns whether the halfedge runs in the direction of its edge.
    #[inline]
    pub fn follows_edge(&self, h: Halfedge) -> bool {
        self.connectivity.edge_vertices[self.edge(h).index()][0] == self.origin(h).0
    }
    /// Returns what lies across a halfedge.
    #[inline]
    pub fn neighbour(&self, h: Halfedge) -> Neighbour<'_> {
        match self.edge_halfedges(self.edge(h)) {
            [_] => Neighbour::Boundary,
            &[a, b] => Neighbour::Twin(if a == h { b } else { a }),
            all => Neighbour::Nonmanifold(all),
        }
    }
    /// Returns whether the edge has exactly one face.
    #[inline]
    pub fn is_boundary_edge(&self, e: Edge) -> bool {
        self.edge_halfedges(e).len() == 1
    }
    /// Returns whether the vertex is an endpoint of a boundary edge.
    ///
    /// # Cost
    /// O(degree).
    pub fn is_boundary_vertex(&self, v: Vertex) -> bool {
        let mut sides = self.vertex_corners(v).iter().flat_map(|c| [c.halfedge(), c.halfedge().previous()]);
        sides.any(|h| self.is_boundary_edge(self.edge(h)))
    }
    /// Returns the edge between two vertices, if there is one.
    ///
    /// # Cost
    /// O(the smaller of their degrees).
    pub fn find_edge(&self, a: Vertex, b: Vertex) -> Option<Edge> {
        if a.index() >= self.vertex_count() || b.index() >= self.vertex_count() || a == b {
            return None;
        }
        let (a, b) =
            if self.vertex_corners(a).len() <= self.vertex_corners(b).len() { (a, b) } else { (b, a) };
        self.vertex_corners(a).iter().find_map(|&c| {
            let h = c.halfedge();
            if self.tip(h) == b {
                Some(self.edge(h))
            } else if self.origin(h.previous()) == b {
                Some(self.edge(h.previous()))
            } else {
                None
            }
        })
    }
    /// Returns the first face with these three vertices, in any order.
    pub fn find_face(&self, vertices: [Vertex; 3]) -> Option<Face> {
        if vertices.iter().any(|v| v.index() >= self.vertex_count()) {
            return None;
        }
        let rarest = vertices.into_iter().min_by_key(|&v| self.vertex_corners(v).len())?;
        self.vertex_corners(rarest).iter().map(|c| c.face()).find(|&f| {
            let corners = self.face_vertices(f);
            vertices.iter().all(|v| corners.contains(v))
        })
    }
    /// Flips the faces for which `flip` returns true. Vertices, edges and faces keep their ids;
    /// edges may change direction.
    pub fn with_flipped_faces(&self, mut flip: impl FnMut(Face) -> bool) -> TriangleMesh {
        let faces = self
            .faces()
            .map(|f| {
                let [a, b, c] = self.connectivity.faces[f.index()];
                if flip(f) { [a, c, b] } else { [a, b, c] }
            })
            .collect();
        TriangleMesh::new(self.positions.to_vec(), faces)
            .expect("flipping faces of a valid mesh keeps it valid")
    }
    /// Replaces the positions and keeps the connectivity.
    ///
    /// # Errors
    /// [`MeshError::Invalid`] if a coordinate is not finite, [`MeshError::WrongLength`] if the
    /// count differs.
    pub fn with_positions(&self, positions: Vec<[f64; 3]>) -> Result<TriangleMesh, MeshError> {
        if positions.len() != self.vertex_count() {
            return Err(MeshError::WrongLength {
                what: "positions",
                found: positions.len(),
                expected: self.vertex_count(),
            });
        }
        let faults = structural_faults(&positions, &[]);
        if !faults.is_empty() {
            return Err(MeshError::Invalid(faults));
        }
        Ok(TriangleMesh { positions: Arc::new(positions), connectivity: self.connectivity.clone() })
    }
    /// Converts the mesh to a polygon mesh.
    pub fn to_polygon_mesh(&self) -> PolygonMesh {
        PolygonMesh::from_triangles(self.positions.to_vec(), &self.connectivity.faces)
    }
}

/// Returns the faults that prevent the connectivity from being built.
pub(crate) fn structural_faults(positions: &[[f64; 3]], faces: &[[u32; 3]]) -> Vec<Fault> {
    let mut faults = Vec::new();
    for (i, p) in positions.iter().enumerate() {
        if !p.iter().all(|x| x.is_finite()) {
            faults.push(Fault::NonFinitePosition { vertex: Vertex(i as u32), position: *p });
        }
    }
    for (i, face) in faces.iter().enumerate() {
        let id = Face(i as u32);
        if let Some(&index) = face.iter().find(|&&v| v as usize >= positions.len()) {
            faults.push(Fault::IndexOutOfRange { face: id, index: index as i64, vertices: positions.len() });
        } else if face[0] == face[1] || face[1] == face[2] || face[2] == face[0] {
            let repeated = if face[0] == face[1] { face[0] } else { face[2] };
            faults.push(Fault::RepeatedVertex { face: id, vertex: Vertex(repeated) });
        }
    }
    faults
}

/// Inverts a list of owners: returns the starts and the items of each owner, items in increasing
/// order.
pub(crate) fn group_by_owner(
    owners: usize,
    owner_of: impl Iterator<Item = u32> + Clone,
) -> (Vec<u32>, Vec<u32>) {
    let mut start = vec![0u32; owners + 1];
    for o in owner_of.clone() {
        start[o as usize + 1] += 1;
    }
    for i in 0..owners {
        start[i + 1] += start[i];
    }
    let mut next = start.clone();
    let mut items = vec![0u32; start[owners] as usize];
    for (item, o) in owner_of.enumerate() {
        items[next[o as usize] as usize] = item as u32;
        next[o as usize] += 1;
    }
    (start, items)
}

fn corners_by_vertex(vertices: usize, faces: &[[u32; 3]]) -> (Vec<u32>, Vec<Corner>) {
    let (start, corners) = group_by_owner(vertices, faces.iter().flatten().copied());
    (start, corners.into_iter().map(Corner).collect())
}

fn halfedges_by_edge(edges: usize, halfedge_edge: &[u32]) -> (Vec<u32>, Vec<Halfedge>) {
    let (start, halfedges) = group_by_owner(edges, halfedge_edge.iter().copied());
    (start, halfedges.into_iter().map(Halfedge).collect())
}

/// Numbers the edges in the order in which they are first met: corners 01, 12, 20 of each face in
/// turn.
fn number_edges(vertices: usize, faces: &[[u32; 3]]) -> (Vec<u32>, Vec<[u32; 2]>) {
    let ends = |h: usize| {
        let face = faces[h / 3];
        [face[h % 3], face[(h + 1) % 3]]
    };
    let halfedges = 3 * faces.len();
    // Halfedges are grouped by their smaller endpoint; within a group the larger one identifies the
    // edge.
    let (start, by_smaller) = group_by_owner(vertices, (0..halfedges).map(|h| ends(h)[0].min(ends(h)[1])));
    const UNNUMBERED: u32 = u32::MAX;
    let mut first_of = vec![UNNUMBERED; halfedges]; // first halfedge on the same edge
    let mut group: Vec<(u32, u32)> = Vec::new();
    for v in 0..vertices {
        group.clear();
        group.extend(by_smaller[start[v] as usize..start[v + 1] as usize].iter().map(|&h| {
            let [a, b] = ends(h as usize);
            (a.max(b), h)
        }));
        group.sort_unstable();
        let mut i = 0;
        while i < group.len() {
            let first = group[i].1;
            let larger = group[i].0;
            while i < group.len() && group[i].0 == larger {
                first_of[group[i].1 as usize] = first;
                i += 1;
            }
        }
    }
    let mut halfedge_edge = first_of;
    let mut edge_vertices = Vec::with_capacity(halfedges / 2 + 1);
    for h in 0..halfedges {
        let first = halfedge_edge[h] as usize;
        if first == h {
            halfedge_edge[h] = edge_vertices.len() as u32;
            edge_vertices.push(ends(h));
        } else {
            halfedge_edge[h] = halfedge_edge[first]; // smaller halfedges are numbered already
        }
    }
    (halfedge_edge, edge_vertices)
}
