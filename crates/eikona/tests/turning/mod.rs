//! How often a field turns, measured from its values: around single elements, and on closed
//! polylines across faces. Shares nothing with the library but evaluation.

use crate::frames::{angle_in_face, cross, dot, sub, wrapped};
use eikona::mesh::{Edge, Face, Halfedge, Neighbour, TriangleMesh, Vertex};
use eikona::polar_field::PolarField;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

fn corner_angle(mesh: &TriangleMesh, h: Halfedge) -> f64 {
    let [here, a, b] = [h, h.next(), h.previous()].map(|h| mesh.position(mesh.origin(h)));
    let (a, b) = (sub(a, here), sub(b, here));
    dot(cross(a, b), cross(a, b)).sqrt().atan2(dot(a, b))
}

fn twin(mesh: &TriangleMesh, h: Halfedge) -> Option<Halfedge> {
    match mesh.neighbour(h) {
        Neighbour::Twin(twin) => Some(twin),
        _ => None,
    }
}

/// Barycentric coordinates in a face of the point at `t` from one vertex to another.
fn between(mesh: &TriangleMesh, f: Face, [from, to]: [Vertex; 2], t: f64) -> [f64; 3] {
    let weight = |v: Vertex| {
        if v == from {
            1.0 - t
        } else if v == to {
            t
        } else {
            0.0
        }
    };
    mesh.face_vertices(f).map(weight)
}

/// How far the N-th power turns in a face on a straight way, in radians. The way is halved until no
/// turn can be missed: the power is that of a linear field, whose change follows from its lengths
/// at the ends and in the middle (parallelogram law).
fn turn_inside(field: &PolarField, f: Face, from: [f64; 3], to: [f64; 3]) -> f64 {
    let m = f64::from(field.power_of_face(f));
    let values = [from, to].map(|p| field.power_at(f, p));
    let middle = [0, 1, 2].map(|k| 0.5 * (from[k] + to[k]));
    let lengths = [values[0], field.power_at(f, middle), values[1]].map(|z| z.norm().powf(1.0 / m));
    let change = 2.0 * (lengths[0].powi(2) + lengths[2].powi(2)) - 4.0 * lengths[1].powi(2);
    let turn = m * change.max(0.0).sqrt() / lengths.into_iter().fold(f64::INFINITY, f64::min);
    let closest = [0, 1, 2].map(|k| (from[k] - to[k]).abs()).into_iter().fold(0.0, f64::max) < 1e-12;
    if turn < 1.0 || closest {
        return wrapped(values[1].arg() - values[0].arg());
    }
    turn_inside(field, f, from, middle) + turn_inside(field, f, middle, to)
}

/// How far the N-th power turns at a point of a halfedge, from the face of its twin to its own,
/// beyond parallel transport; within half a turn.
fn turn_across(field: &PolarField, h: Halfedge, twin: Halfedge, t: f64) -> f64 {
    let mesh = field.mesh();
    let ends = [mesh.origin(h), mesh.tip(h)];
    let side = sub(mesh.position(ends[1]), mesh.position(ends[0]));
    let angle = |f: Face| {
        let frame = angle_in_face(mesh, f, side);
        field.power_at(f, between(mesh, f, ends, t)).arg() - f64::from(field.degree()) * frame
    };
    wrapped(angle(h.face()) - angle(twin.face()))
}

/// An element around which a field may turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Element {
    Face(Face),
    Edge(Edge),
    Vertex(Vertex),
}

impl std::fmt::Display for Element {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Element::Face(x) => x.fmt(f),
            Element::Edge(x) => x.fmt(f),
            Element::Vertex(x) => x.fmt(f),
        }
    }
}

/// The elements around which a field turns, each with its index times N: along the sides of faces,
/// and from face to face at their corners.
pub fn turning_elements(field: &PolarField) -> BTreeMap<Element, i64> {
    let mesh = field.mesh();
    let mut turned: BTreeMap<Element, f64> = BTreeMap::new();
    let mut add = |element, angle: f64| *turned.entry(element).or_default() += angle;
    for h in (0..mesh.halfedge_count() as u32).map(Halfedge) {
        let (f, e, v) = (h.face(), Element::Edge(mesh.edge(h)), Element::Vertex(mesh.origin(h)));
        let ends = [mesh.origin(h), mesh.tip(h)];
        let [from, to] = [0.0, 1.0].map(|t| between(mesh, f, ends, t));
        let along = turn_inside(field, f, from, to);
        add(Element::Face(f), along);
        add(v, -f64::from(field.degree()) * corner_angle(mesh, h));
        if let Some(twin) = twin(mesh, h) {
            let across = turn_across(field, h, twin, 0.0);
            add(e, -along - across);
            add(v, across);
        }
    }
    let whole = |(element, angle): (Element, f64)| {
        let angle = match element {
            Element::Vertex(_) => angle + TAU * f64::from(field.degree()),
            _ => angle,
        };
        let turns = (angle / TAU).round();
        assert!((angle / TAU - turns).abs() < 1e-6, "{element}: {angle}");
        (element, turns as i64)
    };
    let on_boundary = |element: &Element| match *element {
        Element::Face(_) => false,
        Element::Edge(e) => mesh.is_boundary_edge(e),
        Element::Vertex(v) => mesh.is_boundary_vertex(v),
    };
    turned.into_iter().filter(|(c, _)| !on_boundary(c)).map(whole).filter(|(_, turns)| *turns != 0).collect()
}

/// A closed polyline that crosses every edge between some vertices and all others once, the former
/// on its left.
pub struct Loop {
    /// The halfedges that it crosses, from the inner to the outer vertex, in order; it enters the
    /// face of each.
    spokes: Vec<Halfedge>,
    inner: Vec<bool>,
}

impl Loop {
    /// Returns the loop around these vertices; `None` if it has several parts or meets the
    /// boundary.
    pub fn around(mesh: &TriangleMesh, vertices: &[Vertex]) -> Option<Loop> {
        let mut inner = vec![false; mesh.vertex_count()];
        vertices.iter().for_each(|v| inner[v.index()] = true);
        let is_spoke = |h: &Halfedge| inner[mesh.origin(*h).index()] && !inner[mesh.tip(*h).index()];
        let all = (0..mesh.edge_count() as u32).map(Edge);
        let count = all.filter(|&e| {
            let [a, b] = mesh.edge_vertices(e);
            inner[a.index()] != inner[b.index()]
        });
        let count = count.count();
        let first = vertices.iter().flat_map(|&v| mesh.vertex_corners(v));
        let first = first.map(|c| c.halfedge()).find(is_spoke)?;
        let mut spokes = vec![first];
        loop {
            let h = spokes[spokes.len() - 1];
            let third = mesh.origin(h.previous());
            let exit = if inner[third.index()] { h.next() } else { h.previous() };
            let next = twin(mesh, exit)?;
            if next == first {
                break;
            }
            spokes.push(next);
        }
        twin(mesh, first)?;
        (spokes.len() == count).then_some(Loop { spokes, inner })
    }

    /// Returns the index times N of what is inside, from the turning on the loop through the points
    /// at `t` on its edges; not rounded.
    pub fn turns(&self, field: &PolarField, t: f64) -> f64 {
        let mesh = field.mesh();
        let mut turned = 0.0;
        for (i, &h) in self.spokes.iter().enumerate() {
            let next = self.spokes[(i + 1) % self.spokes.len()];
            let exit = twin(mesh, next).expect("loops stay inside");
            turned += turn_across(field, h, twin(mesh, h).expect("loops stay inside"), t);
            // The exit runs from the outer to the inner vertex.
            let from = between(mesh, h.face(), [mesh.origin(h), mesh.tip(h)], t);
            let to = between(mesh, h.face(), [mesh.tip(exit), mesh.origin(exit)], t);
            turned += turn_inside(field, h.face(), from, to);
        }
        (turned + f64::from(field.degree()) * self.curvature(mesh)) / TAU
    }

    /// The curvature inside: 2 pi less the angles at each vertex, pi less the angles on the
    /// boundary.
    fn curvature(&self, mesh: &TriangleMesh) -> f64 {
        let mut sum = 0.0;
        for v in mesh.vertices().filter(|v| self.inner[v.index()]) {
            let angles: f64 = mesh.vertex_corners(v).iter().map(|c| corner_angle(mesh, c.halfedge())).sum();
            sum += if mesh.is_boundary_vertex(v) { PI } else { TAU } - angles;
        }
        sum
    }
}

/// Returns the vertices with all their neighbors.
pub fn grown(mesh: &TriangleMesh, vertices: &[Vertex]) -> Vec<Vertex> {
    let faces = vertices.iter().flat_map(|&v| mesh.vertex_corners(v)).map(|c| c.face());
    let mut grown: Vec<Vertex> = faces.flat_map(|f| mesh.face_vertices(f)).collect();
    grown.sort_unstable();
    grown.dedup();
    grown
}
