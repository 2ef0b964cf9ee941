//! Cuts a mesh along curves: faces are split into triangles of the same orientation, so that every
//! curve runs along edges.
//!
//! A method whose unknowns jump across a curve needs the curve along edges. [`embed_curves`]
//! provides this and the maps back: the place of each vertex on the input, the parent of each face,
//! the edges along each curve.
//!
//! Points are distinguished down to 1e-9 of an edge, in barycentric coordinates: nodes and
//! crossings nearer than that to each other, to a vertex or to a side are merged with it, and a
//! segment that passes a vertex within half of it goes through that vertex. Rounding thus leaves no
//! slivers; thin faces arise only in slits between the curves themselves. Beyond that, sides are
//! decided exactly, in integers. Curves are displaced by at most a few times this tolerance.
//!
//! The points on each edge are found first, over all faces at it; then each face is cut
//! independently, and the pieces of neighbouring faces match.

mod embedded;
mod error;
mod face;
mod triangulation;

pub use embedded::{ChainEdge, CurveChain, Embedded, EmbeddedCurve, SHORT_PIECE_EDGES, Walk};
pub(crate) use embedded::{areas_of_pieces, label_of_most, parts_of_short_edges};
pub use error::EmbedError;

use crate::geometry::shape_of_face;
use eikona_mesh::{
    CurveError, CurveKind, Edge, Face, Located, Provenance, SegmentHost, SurfaceCurves, SurfacePoint,
    TriangleMesh, Vertex, segment_host,
};
use eikona_numeric::check_stopped;
use face::{FaceCurves, FaceCut, SAME, Stop, cut_face};
use std::collections::{BTreeMap, BTreeSet};
use triangulation::{ONE, Point};

/// Cuts a mesh along curves, so that every segment becomes a chain of edges.
///
/// Segments may cross, touch, overlap, repeat, pass through vertices, run along edges and have
/// length zero. Each lies in one face or along one edge, as
/// [`trace_curve`](crate::curves::trace_curve) makes them. Isolated points become vertices. Faces
/// without a curve inside and without new vertices on their sides keep their corners; the others
/// are triangulated as well as their points allow (constrained Delaunay in the true shape of the
/// face).
///
/// ```
/// use eikona::cut::embed_curves;
/// use eikona_mesh::{Curve, SurfaceCurves, SurfacePoint, TriangleMesh};
/// let corners = vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
/// let mesh = TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]])?;
/// // Across the lower triangle, from the midpoint of its first side to that of the diagonal.
/// let middle = |vertices| SurfacePoint::Edge { vertices, t: 0.5 };
/// let curve = Curve::signed([[0, 1], [2, 0]].map(middle));
/// let cut = embed_curves(&mesh, &SurfaceCurves::from_curve(curve))?;
/// assert_eq!((cut.mesh.vertex_count(), cut.mesh.face_count()), (6, 5));
/// assert_eq!(cut.curves[0].vertices.len(), 2);
/// assert_eq!(cut.chain().multiplicities.as_slice().iter().sum::<i64>().abs(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`EmbedError::Curve`], with curve and node, for a node that is not on the mesh, a curve with
/// fewer than two nodes, or a segment that leaves its face. [`EmbedError::Tangled`] if curves are
/// too close together to be ordered, and [`EmbedError::Mesh`] if the result is too large.
///
/// # Cost
/// O(F), plus usually O((k + c)^1.5) in a face with k segments and c crossings; O((k + c)^2) where
/// thousands of segments meet in one vertex. 68 000 segments over 320 000 faces take about 1.5 s;
/// 10 000 short segments in one face about 1 s.
pub fn embed_curves(mesh: &TriangleMesh, curves: &SurfaceCurves) -> Result<Embedded, EmbedError> {
    for (curve, c) in curves.curves.iter().enumerate() {
        if c.nodes.len() < 2 {
            return Err(CurveError::TooFewNodes { curve, nodes: c.nodes.len() }.into());
        }
    }
    let lines = curves.curves.iter().map(|c| Line { kind: c.kind, up: c.up, nodes: &c.nodes });
    embed_lines(mesh, &lines.collect::<Vec<_>>(), &curves.points)
}

/// A curve of at least one node.
struct Line<'a> {
    kind: CurveKind,
    up: Option<[f64; 3]>,
    nodes: &'a [SurfacePoint],
}

fn embed_lines(mesh: &TriangleMesh, lines: &[Line], points: &[SurfacePoint]) -> Result<Embedded, EmbedError> {
    let mut plan = Plan::of(mesh, lines, points)?;
    check_stopped()?;
    let cuts = plan.cut_faces()?;
    assemble(&plan, cuts, lines)
}

/// Largest number of rounds of recutting faces after crossings beside a side moved onto it.
const ROUNDS: usize = 64;

/// The faces and edges to be cut.
struct Plan<'a> {
    mesh: &'a TriangleMesh,
    /// The nodes of all curves, one curve after the other, and then the isolated points.
    nodes: Vec<Located>,
    /// The nodes of all curves, curve by curve, then the isolated points.
    starts: Vec<usize>,
    /// The host of the segment that follows each node; `None` for segments of length zero and after
    /// the last node of a curve.
    hosts: Vec<Option<SegmentHost>>,
    /// Points inside edges, more than [`SAME`] apart, in increasing order.
    on_edge: BTreeMap<Edge, Vec<EdgePoint>>,
    /// Faces with curves inside.
    tasks: BTreeMap<Face, Task>,
}

/// A point on an edge.
#[derive(Clone, Copy)]
struct EdgePoint {
    /// Position along the edge, in units of `1 / ONE`.
    place: i64,
    /// The same as given.
    t: f64,
}

/// The curves inside a face.
#[derive(Default)]
struct Task {
    /// Nodes inside it, in increasing order.
    nodes: Vec<usize>,
    /// First nodes of the segments through it.
    segments: Vec<usize>,
}

/// A face to be cut and the points on its sides.
struct Cut {
    sides: [Vec<(Edge, usize)>; 3],
    done: FaceCut,
}

impl<'a> Plan<'a> {
    fn of(mesh: &'a TriangleMesh, lines: &[Line], points: &[SurfacePoint]) -> Result<Self, CurveError> {
        let mut plan = Plan {
            mesh,
            nodes: Vec::new(),
            starts: Vec::new(),
            hosts: Vec::new(),
            on_edge: BTreeMap::new(),
            tasks: BTreeMap::new(),
        };
        for (c, line) in lines.iter().enumerate() {
            plan.starts.push(plan.nodes.len());
            for (n, node) in line.nodes.iter().enumerate() {
                let here = node.locate(mesh).map_err(|e| e.at(c, n))?;
                if n > 0 {
                    let from = plan.nodes[plan.nodes.len() - 1];
                    plan.hosts.push(if from == here {
                        None
                    } else {
                        let host = segment_host(mesh, from, here);
                        Some(host.ok_or_else(|| CurveError::SegmentAcrossFaces.at(c, n - 1))?)
                    });
                }
                plan.nodes.push(here);
            }
            plan.hosts.push(None);
        }
        plan.starts.push(plan.nodes.len());
        for (i, point) in points.iter().enumerate() {
            plan.nodes.push(point.locate(mesh).map_err(|e| e.at_point(i))?);
            plan.hosts.push(None);
        }
        plan.spread();
        Ok(plan)
    }

    /// Assigns nodes and segments to their host edges and faces.
    fn spread(&mut self) {
        for (n, node) in self.nodes.iter().enumerate() {
            match *node {
                Located::Vertex(_) => {}
                Located::Edge(e, t) => {
                    let place = (t * ONE as f64).round() as i64;
                    self.on_edge.entry(e).or_default().push(EdgePoint { place, t });
                }
                Located::Face(f, _) => self.tasks.entry(f).or_default().nodes.push(n),
            }
            if let Some(SegmentHost::Face(f, _)) = self.hosts[n] {
                self.tasks.entry(f).or_default().segments.push(n);
            }
        }
        for points in self.on_edge.values_mut() {
            points.sort_by(|a, b| a.place.cmp(&b.place).then(a.t.total_cmp(&b.t)));
            let mut last = None;
            points.retain(|p| {
                let kept = last.is_none_or(|l| p.place - l > same());
                if kept {
                    last = Some(p.place);
                }
                kept
            });
        }
    }

    /// Returns the index of the point that represents a place, among the points of its edge.
    fn on_edge(&self, e: Edge, t: f64) -> usize {
        let place = (t * ONE as f64).round() as i64;
        let points = self.on_edge.get(&e).map_or(&[][..], |p| p);
        points.partition_point(|p| p.place <= place).saturating_sub(1)
    }

    /// Cuts all faces with points or curves.
    fn cut_faces(&mut self) -> Result<BTreeMap<Face, Cut>, EmbedError> {
        let mesh = self.mesh;
        let mut cuts = BTreeMap::new();
        let mut waiting: BTreeSet<Face> = self.tasks.keys().copied().collect();
        waiting.extend(self.on_edge.keys().flat_map(|&e| mesh.edge_halfedges(e)).map(|h| h.face()));
        for _ in 0..ROUNDS {
            let mut next = BTreeSet::new();
            for &face in &waiting {
                check_stopped()?;
                let (sides, curves) = self.curves_in(face);
                match cut_face(&curves) {
                    Ok(done) => {
                        cuts.insert(face, Cut { sides, done });
                    }
                    Err(Stop::OnSides(asked)) => {
                        next.insert(face);
                        for (side, place) in asked {
                            let edge = self.add_on_side(face, side, place);
                            next.extend(mesh.edge_halfedges(edge).iter().map(|h| h.face()));
                        }
                    }
                    Err(Stop::Tangled) => return Err(EmbedError::Tangled { face }),
                }
            }
            if next.is_empty() {
                return Ok(cuts);
            }
            waiting = next;
        }
        Err(EmbedError::Tangled { face: waiting.first().copied().unwrap_or(Face(0)) })
    }

    fn add_on_side(&mut self, face: Face, side: usize, place: i64) -> Edge {
        let h = face.halfedge(side);
        let edge = self.mesh.edge(h);
        let place = if self.mesh.follows_edge(h) { place } else { ONE - place };
        let points = self.on_edge.entry(edge).or_default();
        // Another face at this edge may have requested the same point in this round.
        let at = points.partition_point(|p| p.place < place);
        let near = |p: Option<&EdgePoint>| p.is_some_and(|p| (p.place - place).abs() <= same());
        if !near(points.get(at)) && !near(at.checked_sub(1).and_then(|i| points.get(i))) {
            points.insert(at, EdgePoint { place, t: place as f64 / ONE as f64 });
        }
        edge
    }

    /// Collects the points on the sides and the curves in a face.
    fn curves_in(&self, face: Face) -> ([Vec<(Edge, usize)>; 3], FaceCurves) {
        let mesh = self.mesh;
        let triangle = shape_of_face(mesh, face);
        let longest = triangle.lengths.iter().fold(0.0f64, |m, &l| m.max(l));
        let [_, b, c] = triangle.corners();
        let axes = [b, c].map(|z| [z.re / longest, z.im / longest]);
        let mut sides: [Vec<(Edge, usize)>; 3] = Default::default();
        let mut places: [Vec<i64>; 3] = Default::default();
        for k in 0..3 {
            let edge = mesh.face_edges(face)[k];
            let Some(points) = self.on_edge.get(&edge) else { continue };
            sides[k].extend((0..points.len()).map(|i| (edge, i)));
            places[k].extend(points.iter().map(|p| p.place));
            if !mesh.follows_edge(face.halfedge(k)) {
                sides[k].reverse();
                places[k].reverse();
                places[k].iter_mut().for_each(|s| *s = ONE - *s);
            }
        }
        let mut curves = FaceCurves {
            axes,
            doubled: places.iter().any(|p| !p.is_empty()) && is_doubled(mesh, face),
            sides: places,
            inside: Vec::new(),
            segments: Vec::new(),
        };
        if let Some(task) = self.tasks.get(&face) {
            for &n in &task.nodes {
                if let Located::Face(_, w) = self.nodes[n] {
                    curves.inside.push(on_grid(w));
                }
            }
            curves.segments.extend(
                task.segments
                    .iter()
                    .map(|&n| [n, n + 1].map(|n| self.point_in(face, &sides, &task.nodes, n))),
            );
        }
        (sides, curves)
    }

    /// Returns the number of a node among the points of a face: corners, sides, inside.
    fn point_in(&self, face: Face, sides: &[Vec<(Edge, usize)>; 3], inside: &[usize], n: usize) -> u32 {
        let rim = 3 + sides.iter().map(Vec::len).sum::<usize>();
        let found = match self.nodes[n] {
            Located::Vertex(v) => self.mesh.face_vertices(face).iter().position(|&c| c == v),
            Located::Edge(e, t) => {
                let i = self.on_edge(e, t);
                // Sides hold the points of an edge in order or reversed.
                let mut before = 3;
                sides.iter().find_map(|side| {
                    let places = [Some(i), side.len().checked_sub(i + 1)].into_iter().flatten();
                    let found = places.map(|at| (before + at, side.get(at))).find(|f| f.1 == Some(&(e, i)));
                    before += side.len();
                    found.map(|f| f.0)
                })
            }
            Located::Face(..) => inside.binary_search(&n).ok().map(|i| rim + i),
        };
        found.map_or(u32::MAX, |i| i as u32)
    }
}

/// [`SAME`] in grid units.
fn same() -> i64 {
    (SAME * ONE as f64) as i64
}

fn on_grid(weights: [f64; 3]) -> Point {
    [weights[1], weights[2]].map(|w| (w * ONE as f64).round() as i64)
}

/// Whether another face has the same three corners.
fn is_doubled(mesh: &TriangleMesh, face: Face) -> bool {
    let corners = mesh.face_vertices(face);
    let fewest = corners.iter().min_by_key(|v| mesh.vertex_corners(**v).len());
    fewest.is_some_and(|&v| {
        mesh.vertex_corners(v)
            .iter()
            .any(|c| c.face() != face && mesh.face_vertices(c.face()).iter().all(|u| corners.contains(u)))
    })
}

/// Numbers the new vertices and assembles faces and curves.
fn assemble(plan: &Plan, cuts: BTreeMap<Face, Cut>, lines: &[Line]) -> Result<Embedded, EmbedError> {
    let mesh = plan.mesh;
    let mut positions = mesh.positions().to_vec();
    let mut places: Vec<SurfacePoint> = mesh.vertices().map(SurfacePoint::from).collect();
    let mut first_on_edge: BTreeMap<Edge, u32> = BTreeMap::new();
    for (&e, points) in &plan.on_edge {
        first_on_edge.insert(e, positions.len() as u32);
        for p in points {
            let place = Located::Edge(e, p.t);
            positions.push(place.position(mesh));
            places.push(place.to_surface_point(mesh));
        }
    }
    let edge_vertex = |e: Edge, i: usize| Vertex(first_on_edge.get(&e).map_or(0, |first| first + i as u32));

    check_stopped()?;
    // Vertices of each cut face by their numbers in it.
    let mut vertices_of: BTreeMap<Face, Vec<Vertex>> = BTreeMap::new();
    for (&face, cut) in &cuts {
        let mut vertices: Vec<Vertex> = mesh.face_vertices(face).to_vec();
        vertices.extend(cut.sides.iter().flatten().map(|&(e, i)| edge_vertex(e, i)));
        let rim = vertices.len();
        let mut own: Vec<Located> = cut
            .done
            .inside
            .iter()
            .map(|&[x, y]| Located::Face(face, [ONE - x - y, x, y].map(|w| w as f64 / ONE as f64)))
            .collect();
        // Nodes stay exactly where they were given; of several in one vertex the first decides.
        if let Some(task) = plan.tasks.get(&face) {
            for (&n, &v) in task.nodes.iter().zip(&cut.done.vertex_of_point).rev() {
                if let Some(place) = (v as usize).checked_sub(rim).and_then(|i| own.get_mut(i)) {
                    *place = plan.nodes[n];
                }
            }
        }
        for place in own {
            vertices.push(Vertex(positions.len() as u32));
            positions.push(place.position(mesh));
            places.push(place.to_surface_point(mesh));
        }
        vertices_of.insert(face, vertices);
    }

    let mut faces = Vec::with_capacity(mesh.face_count());
    let mut parents = Vec::with_capacity(mesh.face_count());
    for face in mesh.faces() {
        if let (Some(cut), Some(vertices)) = (cuts.get(&face), vertices_of.get(&face)) {
            faces.extend(cut.done.triangles.iter().map(|t| t.map(|v| vertices[v as usize].0)));
        } else {
            faces.push(mesh.triangles()[face.index()]);
        }
        parents.resize(faces.len(), face);
    }
    check_stopped()?;
    let new = TriangleMesh::new(positions, faces)?;
    check_stopped()?;

    // Chains of the segments through faces.
    let mut chain_of: Vec<Vec<Vertex>> = vec![Vec::new(); plan.nodes.len()];
    for (face, task) in &plan.tasks {
        if let (Some(cut), Some(vertices)) = (cuts.get(face), vertices_of.get(face)) {
            for (&n, chain) in task.segments.iter().zip(&cut.done.chains) {
                chain_of[n] = chain.iter().map(|&v| vertices[v as usize]).collect();
            }
        }
    }
    let vertex_of_node = |n: usize| match plan.nodes[n] {
        Located::Vertex(v) => v,
        Located::Edge(e, t) => edge_vertex(e, plan.on_edge(e, t)),
        Located::Face(f, _) => {
            let local = plan.tasks.get(&f).zip(cuts.get(&f)).and_then(|(task, cut)| {
                task.nodes.binary_search(&n).ok().map(|i| cut.done.vertex_of_point[i] as usize)
            });
            local.zip(vertices_of.get(&f)).map_or(Vertex(0), |(i, vertices)| vertices[i])
        }
    };
    // Returns all vertices of an edge from one end to the other; the ends have places 0 and m + 1
    // in it.
    let along_edge = |e: Edge, from: Located, to: Located| -> Vec<Vertex> {
        let count = plan.on_edge.get(&e).map_or(0, Vec::len);
        let [first, last] = mesh.edge_vertices(e);
        let place = |p: Located| match p {
            Located::Edge(_, t) => plan.on_edge(e, t) + 1,
            Located::Vertex(v) if v == first => 0,
            _ => count + 1,
        };
        let vertex = |i: usize| match i {
            0 => first,
            i if i == count + 1 => last,
            i => edge_vertex(e, i - 1),
        };
        let (a, b) = (place(from), place(to));
        if a <= b { (a..=b).map(vertex).collect() } else { (b..=a).rev().map(vertex).collect() }
    };
    let mut curves = Vec::with_capacity(lines.len());
    for (c, line) in lines.iter().enumerate() {
        let nodes = plan.starts[c]..plan.starts[c + 1];
        let mut curve = EmbeddedCurve {
            kind: line.kind,
            up: line.up,
            vertices: nodes.clone().take(1).map(vertex_of_node).collect(),
            segments: Vec::new(),
        };
        for n in nodes.clone() {
            let chain = match plan.hosts[n] {
                None => continue,
                Some(SegmentHost::Edge(e, _)) => along_edge(e, plan.nodes[n], plan.nodes[n + 1]),
                Some(SegmentHost::Face(..)) => std::mem::take(&mut chain_of[n]),
            };
            for &v in chain.iter().skip(1) {
                curve.vertices.push(v);
                curve.segments.push(n - nodes.start);
            }
        }
        curves.push(curve);
    }
    let after = plan.starts[lines.len()];
    Ok(Embedded {
        mesh: new,
        provenance: Provenance::identity(mesh.vertex_count(), mesh.face_count())
            .with_vertex_places(&places)
            .with_face_parents(parents),
        curves,
        points: (after..plan.nodes.len()).map(vertex_of_node).collect(),
        input: mesh.clone(),
    })
}
