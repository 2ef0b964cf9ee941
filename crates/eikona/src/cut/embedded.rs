//! A mesh cut along curves, with maps back to the input mesh.

use super::{EmbedError, Line, embed_lines};
use crate::geometry::{face_in, unit_of};
use eikona_mesh::{
    Curve, CurveKind, Edge, EdgeField, Face, FaceField, MeshError, Provenance, SurfaceCurves, SurfacePoint,
    TriangleMesh, UnionFind, Vertex, VertexField,
};
use eikona_numeric::check_stopped;
use std::collections::{BTreeMap, BTreeSet};

/// Pieces of curves with fewer edges than this are short: see [`Embedded::split_short`].
pub const SHORT_PIECE_EDGES: usize = 8;

/// A mesh cut along curves.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Embedded {
    /// The cut mesh. Its first vertices are those of the input in their order, then points on
    /// edges, then points inside faces. Its faces follow the order of their parents.
    pub mesh: TriangleMesh,
    /// The place of each vertex on the input, and the input face that contains each face.
    pub provenance: Provenance,
    /// The input curves.
    pub curves: Vec<EmbeddedCurve>,
    /// The vertex of each isolated point of the input.
    pub points: Vec<Vertex>,
    pub(super) input: TriangleMesh,
}

/// A curve as a path along edges of the cut mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct EmbeddedCurve {
    /// Signed or unsigned.
    pub kind: CurveKind,
    /// The surface normal given with the curve.
    pub up: Option<[f64; 3]>,
    /// Its vertices in order; consecutive vertices are always joined by an edge. The curve is
    /// closed if the last is the first. A curve of length zero has one vertex.
    pub vertices: Vec<Vertex>,
    /// For each step between vertices, the input segment that it is a piece of, by the 0-based
    /// index of the segment's first node.
    pub segments: Vec<usize>,
}

/// One pass of a curve along an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Walk {
    /// 0-based index of the curve.
    pub curve: usize,
    /// 0-based index of its step.
    pub step: usize,
    /// Whether it runs in the direction of the edge.
    pub forward: bool,
}

/// An edge that curves run along.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChainEdge {
    /// The edge.
    pub edge: Edge,
    /// Number of walks in the direction of the edge minus the number against it. Zero where curves
    /// cancel.
    pub multiplicity: i64,
    /// All walks along the edge, by curve and step.
    pub walks: Vec<Walk>,
}

/// Curves as a 1-chain.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveChain {
    /// The multiplicity of every edge of the cut mesh.
    pub multiplicities: EdgeField<i64>,
    /// The edges with walks, in increasing order.
    pub edges: Vec<ChainEdge>,
}

impl EmbeddedCurve {
    /// Whether the last vertex is the first, after at least one step.
    pub fn is_closed(&self) -> bool {
        self.vertices.len() > 1 && self.vertices.first() == self.vertices.last()
    }
}

impl Embedded {
    /// Returns the mesh that was cut.
    pub fn input(&self) -> &TriangleMesh {
        &self.input
    }

    /// Returns the curves as curves on the cut mesh, without those of length zero.
    pub fn curves_on_mesh(&self) -> SurfaceCurves {
        let walked = self.curves.iter().filter(|c| c.vertices.len() > 1);
        let curve = |c: &EmbeddedCurve| Curve {
            kind: c.kind,
            nodes: c.vertices.iter().map(|&v| v.into()).collect(),
            up: c.up,
        };
        SurfaceCurves {
            curves: walked.map(curve).collect(),
            points: self.points.iter().map(|&v| v.into()).collect(),
        }
    }

    /// Returns the chain of all curves. Unsigned curves count in the order of their nodes, as if
    /// signed; see [`Embedded::chain_of`] to leave them out.
    pub fn chain(&self) -> CurveChain {
        self.chain_of(|_| true)
    }

    /// Returns the chain of the curves that `chosen` accepts.
    ///
    /// # Cost
    /// O(E) plus O(n log n) for n steps, times the smaller degree of an edge's ends.
    pub fn chain_of(&self, chosen: impl Fn(&EmbeddedCurve) -> bool) -> CurveChain {
        let mut walks: BTreeMap<Edge, Vec<Walk>> = BTreeMap::new();
        for (c, curve) in self.curves.iter().enumerate().filter(|(_, curve)| chosen(curve)) {
            for (step, ends) in curve.vertices.windows(2).enumerate() {
                if let Some((edge, forward)) = self.edge_between(ends[0], ends[1]) {
                    walks.entry(edge).or_default().push(Walk { curve: c, step, forward });
                }
            }
        }
        let mut multiplicities = EdgeField::constant(self.mesh.edge_count(), 0);
        let edges = walks.into_iter().map(|(edge, walks)| {
            let multiplicity = walks.iter().map(|w| if w.forward { 1 } else { -1 }).sum();
            multiplicities[edge] = multiplicity;
            ChainEdge { edge, multiplicity, walks }
        });
        let edges = edges.collect();
        CurveChain { multiplicities, edges }
    }

    /// Returns the edge between two vertices and whether it runs from the first to the second.
    fn edge_between(&self, a: Vertex, b: Vertex) -> Option<(Edge, bool)> {
        // A search costs the degree of the vertex where it starts.
        let degree = |v: Vertex| self.mesh.vertex_corners(v).len();
        let edge =
            if degree(a) <= degree(b) { self.mesh.find_edge(a, b) } else { self.mesh.find_edge(b, a) }?;
        Some((edge, self.mesh.edge_vertices(edge)[0] == a))
    }

    /// Restricts a field on the cut mesh to the vertices of the input.
    ///
    /// # Errors
    /// [`MeshError::WrongLength`].
    pub fn field_to_input_vertices<T: Clone>(
        &self,
        field: &VertexField<T>,
    ) -> Result<VertexField<T>, MeshError> {
        let values = self.provenance.push_vertices(field)?.into_vec();
        Ok(values.into_iter().flatten().collect::<Vec<T>>().into())
    }

    /// Averages over the pieces of each input face, weighted by area. Faces that were not cut keep
    /// their value exactly.
    ///
    /// # Errors
    /// [`MeshError::WrongLength`].
    pub fn field_to_input_faces(&self, field: &FaceField<f64>) -> Result<FaceField<f64>, MeshError> {
        self.gather(field, |pieces| {
            let total: f64 = pieces.iter().map(|p| p.0).sum();
            pieces.iter().map(|(area, value)| area / total * **value).sum::<f64>()
        })
    }

    /// Returns for each input face the label that covers the largest area, on ties the smallest.
    ///
    /// # Errors
    /// [`MeshError::WrongLength`].
    pub fn labels_to_input_faces<T: Clone + Ord>(
        &self,
        labels: &FaceField<T>,
    ) -> Result<FaceField<T>, MeshError> {
        self.gather(labels, |pieces| label_of_most(pieces.iter().copied()).unwrap_or(pieces[0].1).clone())
    }

    /// Computes one value per input face from those of its pieces and their areas (all 1 where all
    /// are 0).
    fn gather<T: Clone>(
        &self,
        field: &FaceField<T>,
        join: impl Fn(&[(f64, &T)]) -> T,
    ) -> Result<FaceField<T>, MeshError> {
        let unit = unit_of(&self.mesh);
        self.provenance.push_faces(field, |first, values| match values {
            [value] => value.clone(),
            values => {
                let pieces: Vec<Face> = (first.0..).map(Face).take(values.len()).collect();
                let areas = areas_of_pieces(&self.mesh, unit, &pieces);
                join(&areas.into_iter().zip(values).collect::<Vec<_>>())
            }
        })
    }

    /// Bisects the edges of every open piece of the curves with fewer than [`SHORT_PIECE_EDGES`]
    /// edges until it has at least as many.
    ///
    /// Methods whose functions are multivalued at the ends of an open curve exclude those vertices
    /// from their operators, and with them every edge between two of them. A curve of a single edge
    /// would thus have no effect; with vertices inside it, it has one. A piece is a connected
    /// component of the curves; its edges count once, however often they are traversed. A piece is
    /// open if at some vertex off the mesh boundary the numbers of arriving and leaving steps
    /// differ. Edges are cut into 2, 4 or 8 equal parts, and the adjacent faces with them.
    ///
    /// Deviation: the public program bisects short closed pieces, too, which costs only time.
    ///
    /// # Errors
    /// [`EmbedError::Mesh`] if the result is too large.
    ///
    /// # Cost
    /// That of [`embed_curves`](super::embed_curves); no cost if no piece is short.
    pub fn split_short(&self) -> Result<Embedded, EmbedError> {
        let parts = parts_of_short_edges(&self.mesh, &self.curves);
        if parts.is_empty() {
            return Ok(self.clone());
        }
        // The same curves with the new vertices as nodes, and the step that starts at each node.
        let mut nodes: Vec<Vec<SurfacePoint>> = Vec::with_capacity(self.curves.len());
        let mut steps: Vec<Vec<usize>> = Vec::with_capacity(self.curves.len());
        for curve in &self.curves {
            let mut line: Vec<SurfacePoint> = curve.vertices[..1].iter().map(|&v| v.into()).collect();
            let mut step_of_node = Vec::new();
            for (step, ends) in curve.vertices.windows(2).enumerate() {
                let count = parts.get(&sorted(ends[0], ends[1])).copied().unwrap_or(1);
                let vertices = [ends[0].0, ends[1].0];
                let inner = (1..count).map(|i| SurfacePoint::Edge { vertices, t: i as f64 / count as f64 });
                line.extend(inner);
                line.push(ends[1].into());
                step_of_node.resize(line.len() - 1, step);
            }
            nodes.push(line);
            steps.push(step_of_node);
        }
        let lines = self.curves.iter().zip(&nodes).map(|(c, nodes)| Line { kind: c.kind, up: c.up, nodes });
        let points: Vec<SurfacePoint> = self.points.iter().map(|&v| v.into()).collect();
        check_stopped()?;
        let mut finer = embed_lines(&self.mesh, &lines.collect::<Vec<_>>(), &points)?;
        for (curve, (coarse, steps)) in finer.curves.iter_mut().zip(self.curves.iter().zip(&steps)) {
            curve.segments.iter_mut().for_each(|s| *s = coarse.segments[steps[*s]]);
        }
        finer.provenance = self.provenance.then(&finer.provenance);
        finer.input = self.input.clone();
        Ok(finer)
    }
}

/// Returns the number of parts for each edge of a short open piece of the curves.
pub(crate) fn parts_of_short_edges(
    mesh: &TriangleMesh,
    curves: &[EmbeddedCurve],
) -> BTreeMap<[Vertex; 2], usize> {
    let mut edges: BTreeSet<[Vertex; 2]> = BTreeSet::new();
    let mut leaving_less_arriving: BTreeMap<Vertex, i64> = BTreeMap::new();
    let mut pieces = UnionFind::new(mesh.vertex_count());
    for ends in curves.iter().flat_map(|c| c.vertices.windows(2)) {
        pieces.join(ends[0].0, ends[1].0);
        edges.insert(sorted(ends[0], ends[1]));
        *leaving_less_arriving.entry(ends[0]).or_default() += 1;
        *leaving_less_arriving.entry(ends[1]).or_default() -= 1;
    }
    let mut open: BTreeSet<u32> = BTreeSet::new();
    for (v, _) in leaving_less_arriving.into_iter().filter(|&(v, n)| n != 0 && !mesh.is_boundary_vertex(v)) {
        open.insert(pieces.find(v.0));
    }
    let mut edges_of: BTreeMap<u32, usize> = BTreeMap::new();
    for edge in &edges {
        *edges_of.entry(pieces.find(edge[0].0)).or_default() += 1;
    }
    let mut parts = BTreeMap::new();
    for edge in edges {
        let piece = pieces.find(edge[0].0);
        let count = SHORT_PIECE_EDGES.div_ceil(edges_of[&piece]).next_power_of_two();
        if count > 1 && open.contains(&piece) {
            parts.insert(edge, count);
        }
    }
    parts
}

/// Returns the areas of pieces of a face; all 1 where all are 0.
pub(crate) fn areas_of_pieces(mesh: &TriangleMesh, unit: f64, pieces: &[Face]) -> Vec<f64> {
    let areas: Vec<f64> = pieces.iter().map(|f| face_in(mesh, *f, unit).area).collect();
    if areas.iter().any(|area| *area > 0.0) { areas } else { vec![1.0; areas.len()] }
}

/// Returns the label that covers the largest area, on ties the smallest.
pub(crate) fn label_of_most<T: Copy + Ord>(pieces: impl Iterator<Item = (f64, T)>) -> Option<T> {
    let mut covered: BTreeMap<T, f64> = BTreeMap::new();
    for (area, label) in pieces {
        *covered.entry(label).or_default() += area;
    }
    let most = covered.into_iter().max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
    most.map(|(label, _)| label)
}

fn sorted(a: Vertex, b: Vertex) -> [Vertex; 2] {
    [a.min(b), a.max(b)]
}
