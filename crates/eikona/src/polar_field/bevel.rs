//! The beveled mesh (PLPF section 4.1): every corner of the mesh is a vertex of it, every side of a
//! face a split edge, and every halfedge with a twin a jump edge between the two corners at its
//! origin. Faces, edges and vertices of the mesh are its faces, and so is a hole per boundary loop.
//!
//! Nothing is stored per edge of the beveled mesh: split and jump edges are both numbered by
//! halfedges, and corners by the halfedges that start at them.

use crate::geometry::Triangle;
use crate::geometry::vector::{cross, norm, scale, sub};
use eikona_mesh::{
    Edge, EdgeField, Face, FaceField, Halfedge, HalfedgeField, Neighbour, Topology, TriangleMesh, Vertex,
    VertexField,
};
use eikona_numeric::{Complex, NumericError, check_step};
use std::f64::consts::{PI, TAU};
use std::ops::{Index, IndexMut};

/// An element of the mesh around which the field may turn: a face of the beveled mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Cycle {
    Face(Face),
    /// An edge of two faces.
    Edge(Edge),
    /// A vertex inside the surface.
    Vertex(Vertex),
    /// A boundary loop, by its index.
    Boundary(u32),
}

/// One value per cycle. Edges and vertices of the boundary have a place, too, which stays unused.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PerCycle<T> {
    pub face: FaceField<T>,
    pub edge: EdgeField<T>,
    pub vertex: VertexField<T>,
    pub boundary: Vec<T>,
}

impl<T> Index<Cycle> for PerCycle<T> {
    type Output = T;
    fn index(&self, cycle: Cycle) -> &T {
        match cycle {
            Cycle::Face(f) => &self.face[f],
            Cycle::Edge(e) => &self.edge[e],
            Cycle::Vertex(v) => &self.vertex[v],
            Cycle::Boundary(b) => &self.boundary[b as usize],
        }
    }
}

impl<T> IndexMut<Cycle> for PerCycle<T> {
    fn index_mut(&mut self, cycle: Cycle) -> &mut T {
        match cycle {
            Cycle::Face(f) => &mut self.face[f],
            Cycle::Edge(e) => &mut self.edge[e],
            Cycle::Vertex(v) => &mut self.vertex[v],
            Cycle::Boundary(b) => &mut self.boundary[b as usize],
        }
    }
}

/// A 1-form on the beveled mesh: how far the field turns along each of its edges, in radians.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rotation {
    /// Along each side of a face, from its first corner to its second.
    pub split: HalfedgeField<f64>,
    /// At the origin of each halfedge with a twin, from the face of the twin to its own, beyond
    /// parallel transport. Unused at the boundary.
    pub jump: HalfedgeField<f64>,
}

impl Rotation {
    /// Adds a multiple of another 1-form.
    pub fn add(&mut self, factor: f64, other: &Rotation) {
        let sums = |a: &mut HalfedgeField<f64>, b: &HalfedgeField<f64>| {
            a.as_mut_slice().iter_mut().zip(b.as_slice()).for_each(|(a, b)| *a += factor * b);
        };
        sums(&mut self.split, &other.split);
        sums(&mut self.jump, &other.jump);
    }
}

/// The beveled mesh of a consistently oriented manifold.
#[derive(Debug)]
pub(crate) struct BeveledMesh {
    pub mesh: TriangleMesh,
    pub topology: Topology,
    pub triangles: Vec<Triangle>,
    /// The halfedge of the other face at the same edge; `None` at the boundary.
    pub twin: HalfedgeField<Option<Halfedge>>,
    /// The boundary loop of each vertex on the boundary.
    loop_of_vertex: VertexField<Option<u32>>,
}

impl BeveledMesh {
    /// Builds the beveled mesh. The mesh must be manifold and consistently oriented.
    pub fn new(mesh: &TriangleMesh, topology: Topology, triangles: Vec<Triangle>) -> BeveledMesh {
        let mut twin = HalfedgeField::constant(mesh.halfedge_count(), None);
        for h in (0..mesh.halfedge_count() as u32).map(Halfedge) {
            if let Neighbour::Twin(other) = mesh.neighbour(h) {
                twin[h] = Some(other);
            }
        }
        let mut loop_of_vertex = VertexField::constant(mesh.vertex_count(), None);
        for (b, boundary) in topology.boundary_loops.iter().enumerate() {
            boundary.vertices.iter().for_each(|&v| loop_of_vertex[v] = Some(b as u32));
        }
        BeveledMesh { mesh: mesh.clone(), topology, triangles, twin, loop_of_vertex }
    }

    pub fn halfedges(&self) -> impl Iterator<Item = Halfedge> + use<> {
        (0..self.mesh.halfedge_count() as u32).map(Halfedge)
    }

    /// Iterates over the halfedges with a twin, with their twins.
    pub fn interior(&self) -> impl Iterator<Item = (Halfedge, Halfedge)> + '_ {
        self.twin.iter().filter_map(|(h, twin)| Some((h, (*twin)?)))
    }

    /// Iterates over the edges of two faces, with both halfedges.
    pub fn edges(&self) -> impl Iterator<Item = (Halfedge, Halfedge)> + '_ {
        self.interior().filter(|(h, twin)| h < twin)
    }

    /// Returns all cycles: faces, interior edges, interior vertices, boundary loops.
    pub fn cycles(&self) -> impl Iterator<Item = Cycle> + '_ {
        let mesh = &self.mesh;
        let edges = mesh.edges().filter(|&e| !mesh.is_boundary_edge(e));
        let is_inner = |v: &Vertex| self.loop_of_vertex[*v].is_none() && !mesh.vertex_corners(*v).is_empty();
        mesh.faces()
            .map(Cycle::Face)
            .chain(edges.map(Cycle::Edge))
            .chain(mesh.vertices().filter(is_inner).map(Cycle::Vertex))
            .chain((0..self.topology.boundary_loops.len() as u32).map(Cycle::Boundary))
    }

    /// Returns the cycle around an edge: its own, or that of its boundary loop.
    pub fn of_edge(&self, h: Halfedge) -> Cycle {
        match self.twin[h] {
            Some(_) => Cycle::Edge(self.mesh.edge(h)),
            None => self.of_vertex(self.mesh.origin(h)),
        }
    }

    /// Returns the cycle around a vertex: its own, or that of its boundary loop.
    pub fn of_vertex(&self, v: Vertex) -> Cycle {
        self.loop_of_vertex[v].map_or(Cycle::Vertex(v), Cycle::Boundary)
    }

    /// The boundary loop of a vertex; `None` inside the surface.
    pub fn loop_of_vertex(&self, v: Vertex) -> Option<u32> {
        self.loop_of_vertex[v]
    }

    /// Returns the component of a cycle.
    pub fn component_of(&self, cycle: Cycle) -> usize {
        let face = match cycle {
            Cycle::Face(f) => f,
            Cycle::Edge(e) => self.mesh.edge_halfedges(e)[0].face(),
            Cycle::Vertex(v) => self.mesh.vertex_corners(v)[0].face(),
            Cycle::Boundary(b) => self.topology.boundary_loops[b as usize].halfedges[0].face(),
        };
        self.topology.component_of_face[face] as usize
    }

    /// Returns one value per cycle, all equal.
    pub fn constant<T: Clone>(&self, value: T) -> PerCycle<T> {
        PerCycle {
            face: FaceField::constant(self.mesh.face_count(), value.clone()),
            edge: EdgeField::constant(self.mesh.edge_count(), value.clone()),
            vertex: VertexField::constant(self.mesh.vertex_count(), value.clone()),
            boundary: vec![value; self.topology.boundary_loops.len()],
        }
    }

    pub fn zero(&self) -> Rotation {
        let zeros = || HalfedgeField::constant(self.mesh.halfedge_count(), 0.0);
        Rotation { split: zeros(), jump: zeros() }
    }

    /// Returns the two corners of the jump edge at the origin of `h`: in the face of its twin, then
    /// in its own.
    #[inline]
    pub fn jump_corners(h: Halfedge, twin: Halfedge) -> [Halfedge; 2] {
        [twin.next(), h]
    }

    /// Returns `d0 x`: the differences of a function on corners along the beveled edges.
    pub fn differences(&self, x: &[f64]) -> Rotation {
        let mut result = self.zero();
        for h in self.halfedges() {
            result.split[h] = x[h.next().index()] - x[h.index()];
        }
        for (h, twin) in self.interior() {
            let [from, to] = BeveledMesh::jump_corners(h, twin);
            result.jump[h] = x[to.index()] - x[from.index()];
        }
        result
    }

    /// Returns `d1 theta`: the sum of a 1-form around each cycle, counter-clockwise; around a
    /// boundary loop with the surface on the right.
    pub fn sums(&self, theta: &Rotation) -> PerCycle<f64> {
        let mut sums = self.constant(0.0);
        for h in self.halfedges() {
            sums.face[h.face()] += theta.split[h];
            sums[self.of_edge(h)] -= theta.split[h];
        }
        for (h, _) in self.interior() {
            sums.edge[self.mesh.edge(h)] -= theta.jump[h];
            sums[self.of_vertex(self.mesh.origin(h))] += theta.jump[h];
        }
        sums
    }

    /// Returns the axes of a face in space: along its first side, to the left of it, and normal.
    pub fn frame(&self, face: Face) -> [[f64; 3]; 3] {
        let [a, b, c] = self.mesh.face_positions(face);
        // Squares of lengths overflow long before lengths do.
        let unit = |v: [f64; 3]| {
            let largest = v.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let v = v.map(|x| x / largest);
            scale(v, 1.0 / norm(v))
        };
        let along = unit(sub(b, a));
        let normal = unit(cross(along, unit(sub(c, a))));
        [along, cross(normal, along), normal]
    }

    /// Returns the angle of a corner.
    pub fn angle(&self, corner: Halfedge) -> f64 {
        let Complex { re, im } = self.triangles[corner.face().index()].angles[corner.side()];
        im.atan2(re)
    }

    /// Returns the curvature of each cycle: `2 pi` less the angles at a vertex, the geodesic
    /// curvature of a boundary loop, zero elsewhere. On a component it sums to `2 pi chi`.
    pub fn curvature(&self) -> PerCycle<f64> {
        let mut curvature = self.constant(0.0);
        for v in self.mesh.vertices().filter(|v| !self.mesh.vertex_corners(*v).is_empty()) {
            curvature[self.of_vertex(v)] += if self.loop_of_vertex[v].is_some() { PI } else { TAU };
        }
        for corner in self.halfedges() {
            curvature[self.of_vertex(self.mesh.origin(corner))] -= self.angle(corner);
        }
        // The angles of a face add up to pi up to rounding, always to the same side: over a million
        // faces this reaches 1e-9, which no rotation could make up for. Each vertex takes its part.
        let count = self.topology.components.len();
        let (mut excess, mut vertices) = (vec![0.0; count], vec![0.0; count]);
        let is_inner =
            |v: &Vertex| self.loop_of_vertex[*v].is_none() && !self.mesh.vertex_corners(*v).is_empty();
        for v in self.mesh.vertices().filter(is_inner) {
            let component = self.component_of(Cycle::Vertex(v));
            excess[component] += curvature.vertex[v];
            vertices[component] += 1.0;
        }
        for b in 0..curvature.boundary.len() as u32 {
            excess[self.component_of(Cycle::Boundary(b))] += curvature[Cycle::Boundary(b)];
        }
        for (excess, component) in excess.iter_mut().zip(&self.topology.components) {
            *excess -= TAU * component.euler_characteristic as f64;
        }
        for v in self.mesh.vertices().filter(is_inner) {
            let component = self.component_of(Cycle::Vertex(v));
            curvature.vertex[v] -= excess[component] / vertices[component];
        }
        curvature
    }

    /// Returns the connection: the rotation between the layouts of neighbouring faces at each jump
    /// edge, zero on split edges. Its sum around a cycle is the curvature, up to multiples of `2
    /// pi`.
    pub fn connection(&self) -> Result<Rotation, NumericError> {
        let mut connection = self.zero();
        for (step, (h, twin)) in self.interior().enumerate() {
            check_step(step)?;
            let along = |h: Halfedge| self.triangles[h.face().index()].directions()[h.side()];
            connection.jump[h] = (along(h) * (-along(twin)).conj()).arg();
        }
        Ok(connection)
    }
}

/// Returns the representative in [-pi, pi) of an angle.
pub(crate) fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}
