//! The topology of a mesh: connected components, sheets, boundary loops, Euler characteristic,
//! genus, and nonmanifold elements.

use crate::fan::{far_boundary, umbrellas};
use crate::field::{FaceField, VertexField};
use crate::id::{Edge, Face, Halfedge, Vertex};
use crate::mesh::TriangleMesh;
use crate::orientation::Flood;
use crate::union_find::UnionFind;
use std::convert::Infallible;

/// The topology of a triangle mesh of any kind. It depends on the faces only, not on positions.
///
/// Two notions of connectedness are distinguished: a **sheet** is a set of faces connected through
/// edges, a **component** is a set of faces connected through vertices. Two tetrahedra that touch
/// at a vertex are two sheets in one component. Sheets and components are numbered by their first
/// face.
///
/// ```
/// use eikona_mesh::{Topology, TriangleMesh};
/// let square = TriangleMesh::new(
///     vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]],
///     vec![[0, 1, 2], [0, 2, 3]],
/// )?;
/// let topology = Topology::of(&square);
/// assert_eq!(topology.euler_characteristic, 1);
/// assert_eq!(topology.boundary_loops[0].halfedges.len(), 4);
/// assert_eq!(topology.components[0].genus, Some(0));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Topology {
    /// The sheet of each face.
    pub sheet_of_face: FaceField<u32>,
    /// Number of sheets.
    pub sheet_count: usize,
    /// The component of each face.
    pub component_of_face: FaceField<u32>,
    /// The component of each vertex; `None` for a vertex that no face uses.
    pub component_of_vertex: VertexField<Option<u32>>,
    /// The components.
    pub components: Vec<Component>,
    /// The boundary loops, ordered by their smallest halfedges.
    pub boundary_loops: Vec<BoundaryLoop>,
    /// Number of connected components of the boundary. Loops that touch at a vertex are one
    /// component, so this is at most the number of loops, and equal to it on a manifold.
    pub boundary_component_count: usize,
    /// V - E + F, where V excludes unreferenced vertices.
    pub euler_characteristic: i64,
    /// Edges with more than two faces, in increasing order.
    pub nonmanifold_edges: Vec<Edge>,
    /// Vertices with more than one vertex fan, in increasing order.
    pub nonmanifold_vertices: Vec<NonmanifoldVertex>,
    /// Vertices that no face uses, in increasing order.
    pub unreferenced_vertices: Vec<Vertex>,
}

/// A connected component of a mesh: faces connected through vertices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Component {
    /// Its first face.
    pub first_face: Face,
    /// Number of vertices.
    pub vertex_count: usize,
    /// Number of edges.
    pub edge_count: usize,
    /// Number of faces.
    pub face_count: usize,
    /// Number of boundary loops.
    pub boundary_loop_count: usize,
    /// V - E + F.
    pub euler_characteristic: i64,
    /// Whether no edge has more than two faces and no vertex more than one fan.
    pub manifold: bool,
    /// Whether its faces can be oriented consistently across all edges with two faces.
    pub orientable: bool,
    /// Number of handles, (2 - chi - b) / 2 for b boundary loops; `None` if it is not manifold or
    /// not orientable.
    pub genus: Option<u32>,
    /// Number of crosscaps, 2 - chi - b, of a nonorientable manifold (1 for projective plane and
    /// Moebius band, 2 for the Klein bottle).
    pub nonorientable_genus: Option<u32>,
}

/// A vertex with more than one vertex fan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NonmanifoldVertex {
    /// The vertex.
    pub vertex: Vertex,
    /// The number of vertex fans. Two faces at a vertex are in the same fan if a chain of faces
    /// joins them in which each shares an edge at this vertex with the next; the edge may have any
    /// number of faces.
    pub fans: usize,
}

/// A chain of edges with one face along the boundary of the surface.
///
/// At a vertex the walk continues at the other end of the *same fan*, so loops that touch at a
/// vertex stay apart. A fan that ends at an edge with three or more faces has no other end; such
/// ends at one vertex are joined in pairs by increasing halfedge, and a remaining one ends an open
/// chain. There the number of loops depends on the order of the faces; on a manifold it does not,
/// and every loop is closed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BoundaryLoop {
    /// The halfedges, one per boundary edge. The walk follows the direction of the smallest one; so
    /// where faces are consistently oriented all halfedges are traversed in their own direction,
    /// and the surface lies on the left.
    pub halfedges: Vec<Halfedge>,
    /// The vertex at which each halfedge begins, in the direction of the walk. An open chain has
    /// one more vertex, its end.
    pub vertices: Vec<Vertex>,
    /// Its component.
    pub component: u32,
}

impl BoundaryLoop {
    /// Returns whether the walk ends where it began. Always true on a manifold.
    pub fn is_closed(&self) -> bool {
        self.vertices.len() == self.halfedges.len()
    }
}

impl Topology {
    /// Computes the topology.
    ///
    /// # Cost
    /// Nearly linear; about 0.3 s per million faces.
    pub fn of(mesh: &TriangleMesh) -> Topology {
        match Topology::in_steps(mesh, || Ok::<(), Infallible>(())) {
            Ok(topology) => topology,
        }
    }

    /// Computes the topology in steps of at most some 50 ms per million faces, and calls `between`
    /// them, which may stop it.
    ///
    /// # Errors
    /// That of `between`.
    pub fn in_steps<E>(
        mesh: &TriangleMesh,
        mut between: impl FnMut() -> Result<(), E>,
    ) -> Result<Topology, E> {
        let mut sheets = joined_through_edges(mesh);
        between()?;
        let (sheet_of_face, sheet_count) = sheets.number(0..mesh.face_count() as u32);
        let sheet_of_face = sheet_of_face.into();
        between()?;
        let (component_of_face, component_of_vertex, component_count) = connect_through_vertices(mesh);
        between()?;
        let boundary = Boundary::of(mesh);
        between()?;
        let boundary_loops = boundary.loops(mesh, &component_of_face);
        between()?;
        let nonmanifold_edges: Vec<Edge> =
            mesh.edges().filter(|&e| mesh.edge_halfedges(e).len() > 2).collect();
        between()?;
        let nonmanifold_vertices = nonmanifold_vertices(mesh);
        between()?;
        let unreferenced_vertices: Vec<Vertex> =
            component_of_vertex.iter().filter(|(_, c)| c.is_none()).map(|(v, _)| v).collect();
        let mut topology = Topology {
            sheet_of_face,
            sheet_count,
            component_of_face,
            component_of_vertex,
            components: Vec::new(),
            boundary_loops,
            boundary_component_count: boundary.component_count(mesh),
            euler_characteristic: (mesh.vertex_count() - unreferenced_vertices.len()) as i64
                - mesh.edge_count() as i64
                + mesh.face_count() as i64,
            nonmanifold_edges,
            nonmanifold_vertices,
            unreferenced_vertices,
        };
        between()?;
        topology.components = topology.describe_components(mesh, component_count, between)?;
        Ok(topology)
    }

    /// Returns whether every edge has at most two faces and every vertex at most one fan.
    pub fn is_manifold(&self) -> bool {
        self.nonmanifold_edges.is_empty() && self.nonmanifold_vertices.is_empty()
    }
    /// Returns whether no edge has exactly one face.
    pub fn is_closed(&self) -> bool {
        self.boundary_loops.is_empty()
    }
    /// Returns whether every component is orientable.
    pub fn is_orientable(&self) -> bool {
        self.components.iter().all(|c| c.orientable)
    }

    /// Computes the counts of each component.
    fn describe_components<E>(
        &self,
        mesh: &TriangleMesh,
        count: usize,
        mut between: impl FnMut() -> Result<(), E>,
    ) -> Result<Vec<Component>, E> {
        let blank = Component {
            first_face: Face(u32::MAX),
            vertex_count: 0,
            edge_count: 0,
            face_count: 0,
            boundary_loop_count: 0,
            euler_characteristic: 0,
            manifold: true,
            orientable: true,
            genus: None,
            nonorientable_genus: None,
        };
        let mut components = vec![blank; count];
        let of_edge = |e: Edge| self.component_of_face[mesh.edge_halfedges(e)[0].face()] as usize;
        for (f, &c) in self.component_of_face.iter() {
            let component = &mut components[c as usize];
            component.first_face = component.first_face.min(f);
            component.face_count += 1;
        }
        for c in self.component_of_vertex.as_slice().iter().flatten() {
            components[*c as usize].vertex_count += 1;
        }
        between()?;
        for e in mesh.edges() {
            components[of_edge(e)].edge_count += 1;
        }
        between()?;
        for chain in &self.boundary_loops {
            components[chain.component as usize].boundary_loop_count += 1;
        }
        for &e in &self.nonmanifold_edges {
            components[of_edge(e)].manifold = false;
        }
        for at in &self.nonmanifold_vertices {
            if let Some(c) = self.component_of_vertex[at.vertex] {
                components[c as usize].manifold = false;
            }
        }
        let flood = Flood::in_steps(mesh, &mut between)?;
        between()?;
        for patch in flood.patches.iter().filter(|p| !p.is_orientable()) {
            components[self.component_of_face[patch.first_face] as usize].orientable = false;
        }
        for c in &mut components {
            c.euler_characteristic = c.vertex_count as i64 - c.edge_count as i64 + c.face_count as i64;
            let crosscaps = 2 - c.euler_characteristic - c.boundary_loop_count as i64;
            if c.manifold && c.orientable {
                c.genus = u32::try_from(crosscaps / 2).ok();
            } else if c.manifold {
                c.nonorientable_genus = u32::try_from(crosscaps).ok();
            }
        }
        Ok(components)
    }
}

/// Returns the sheet of each face, numbered by first face, and the number of sheets.
fn joined_through_edges(mesh: &TriangleMesh) -> UnionFind {
    let mut sets = UnionFind::new(mesh.face_count());
    for e in mesh.edges() {
        for pair in mesh.edge_halfedges(e).windows(2) {
            sets.join(pair[0].face().0, pair[1].face().0);
        }
    }
    sets
}

/// The connected components of a mesh (faces connected through vertices), numbered by their first
/// face. [`Topology`] includes them.
#[derive(Clone, Debug)]
pub struct Components {
    /// Component of each face.
    pub of_face: FaceField<u32>,
    /// Component of each vertex; `None` for a vertex that no face uses.
    pub of_vertex: VertexField<Option<u32>>,
    /// Number of components.
    pub count: usize,
}

impl Components {
    /// Computes the components.
    ///
    /// # Cost
    /// Nearly linear.
    pub fn of(mesh: &TriangleMesh) -> Components {
        let (of_face, of_vertex, count) = connect_through_vertices(mesh);
        Components { of_face, of_vertex, count }
    }
}

fn connect_through_vertices(mesh: &TriangleMesh) -> (FaceField<u32>, VertexField<Option<u32>>, usize) {
    let mut sets = UnionFind::new(mesh.vertex_count());
    for &[a, b, c] in mesh.triangles() {
        sets.join(a, b);
        sets.join(a, c);
    }
    let (of_face, count) = sets.number(mesh.triangles().iter().map(|face| face[0]));
    let of_vertex: Vec<Option<u32>> = mesh
        .vertices()
        .map(|v| mesh.vertex_corners(v).first().map(|corner| of_face[corner.face().index()]))
        .collect();
    (of_face.into(), of_vertex.into(), count)
}

fn nonmanifold_vertices(mesh: &TriangleMesh) -> Vec<NonmanifoldVertex> {
    let mut fans = umbrellas(mesh);
    mesh.vertices()
        .filter_map(|vertex| {
            // Each fan has exactly one representative corner.
            let fans = mesh.vertex_corners(vertex).iter().filter(|c| fans.find(c.0) == c.0).count();
            (fans > 1).then_some(NonmanifoldVertex { vertex, fans })
        })
        .collect()
}

/// The edges with one face, and which end of them follows which. End `2 i` is the origin of
/// halfedge `i` of the list, end `2 i + 1` its tip.
struct Boundary {
    halfedges: Vec<Halfedge>,
    /// The end at which the walk continues when it arrives at this one.
    partner: Vec<Option<u32>>,
}

impl Boundary {
    fn of(mesh: &TriangleMesh) -> Boundary {
        // Edges are numbered by their first halfedge, so this is in increasing order.
        let halfedges: Vec<Halfedge> = mesh
            .edges()
            .filter_map(|e| if let [h] = mesh.edge_halfedges(e) { Some(*h) } else { None })
            .collect();
        let place_of = |h: Halfedge| halfedges.binary_search(&h).ok().map(|i| i as u32);
        let mut partner: Vec<Option<u32>> = Vec::with_capacity(2 * halfedges.len());
        let mut unmatched: Vec<(Vertex, u32)> = Vec::new();
        for &h in &halfedges {
            for v in [mesh.origin(h), mesh.tip(h)] {
                let other = far_boundary(mesh, h, v);
                let end = other.and_then(|g| Some(2 * place_of(g)? + u32::from(mesh.origin(g) != v)));
                if end.is_none() {
                    unmatched.push((v, partner.len() as u32));
                }
                partner.push(end);
            }
        }
        unmatched.sort_unstable();
        for at_vertex in unmatched.chunk_by(|a, b| a.0 == b.0) {
            for pair in at_vertex.chunks_exact(2) {
                partner[pair[0].1 as usize] = Some(pair[1].1);
                partner[pair[1].1 as usize] = Some(pair[0].1);
            }
        }
        Boundary { halfedges, partner }
    }

    fn loops(&self, mesh: &TriangleMesh, component_of_face: &FaceField<u32>) -> Vec<BoundaryLoop> {
        let mut seen = vec![false; self.halfedges.len()];
        let mut loops = Vec::new();
        for first in 0..self.halfedges.len() {
            if seen[first] {
                continue;
            }
            let first_end = 2 * first as u32;
            let (mut ends, closed) = self.walk(first_end, &mut seen);
            if !closed {
                // The chain is open: prepend what lies before the first halfedge, reversed.
                let (before, _) = match self.partner[first_end as usize] {
                    Some(end) => self.walk(end, &mut seen),
                    None => (Vec::new(), false),
                };
                ends.splice(0..0, before.into_iter().rev().map(|end| end ^ 1));
            }
            let at = |end: u32| {
                let h = self.halfedges[end as usize / 2];
                if end & 1 == 0 { mesh.origin(h) } else { mesh.tip(h) }
            };
            let mut vertices: Vec<Vertex> = ends.iter().map(|&end| at(end)).collect();
            if let (false, Some(last)) = (closed, ends.last()) {
                vertices.push(at(last ^ 1));
            }
            loops.push(BoundaryLoop {
                halfedges: ends.iter().map(|&end| self.halfedges[end as usize / 2]).collect(),
                vertices,
                component: component_of_face[self.halfedges[first].face()],
            });
        }
        loops
    }

    /// Returns the ends at which the halfedges are entered from `start` on, and whether the walk
    /// came back to `start`.
    fn walk(&self, start: u32, seen: &mut [bool]) -> (Vec<u32>, bool) {
        let mut ends = Vec::new();
        let mut end = start;
        loop {
            seen[end as usize / 2] = true;
            ends.push(end);
            match self.partner[end as usize ^ 1] {
                None => return (ends, false),
                Some(next) if next == start => return (ends, true),
                Some(next) => end = next,
            }
        }
    }

    /// Returns the number of components when edges are connected through vertices.
    fn component_count(&self, mesh: &TriangleMesh) -> usize {
        let mut sets = UnionFind::new(mesh.vertex_count());
        for &h in &self.halfedges {
            sets.join(mesh.origin(h).0, mesh.tip(h).0);
        }
        sets.number(self.halfedges.iter().map(|&h| mesh.origin(h).0)).1
    }
}
