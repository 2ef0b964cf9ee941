//! Decomposes closed jumps off the curve into pieces between fixed vertices.

use super::sides::{other_side, swept, transported};
use eikona_mesh::{Edge, Halfedge, TriangleMesh, Vertex};
use std::collections::BTreeMap;

/// Jumps below this count as zero.
const NOTHING: f64 = 1e-7;

/// One step of a piece along an edge.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// The halfedge on whose side the piece runs. It matters along the curve only, which a piece
    /// must not cross.
    pub along: Halfedge,
    /// Whether the step runs in the direction of that halfedge.
    pub forward: bool,
    /// The halfedge of the face where the function is higher.
    pub high: Halfedge,
}

impl Step {
    pub fn ends(&self, mesh: &TriangleMesh) -> [Vertex; 2] {
        let [a, b] = [mesh.origin(self.along), mesh.tip(self.along)];
        if self.forward { [a, b] } else { [b, a] }
    }

    fn reversed(self) -> Step {
        Step { forward: !self.forward, ..self }
    }
}

/// A path along edges with a jump of constant height: from one fixed vertex to another, or a closed
/// loop without fixed vertices.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub steps: Vec<Step>,
    pub height: f64,
    pub is_loop: bool,
    /// The face beside the piece where the function is higher.
    pub high_side: Halfedge,
}

impl Piece {
    fn reverse(&mut self) {
        self.steps.reverse();
        self.steps.iter_mut().for_each(|s| *s = s.reversed());
    }
}

/// Closed jumps and the curve, on one mesh.
pub(super) struct Jumps<'a> {
    pub mesh: &'a TriangleMesh,
    /// The jump at each edge: first face minus second.
    pub jump: &'a [f64],
    /// Whether the edge belongs to the input, which does not move.
    pub is_curve: &'a [bool],
}

/// The edges of the completion and of the curve at each vertex.
struct Star {
    free: BTreeMap<Vertex, Vec<Edge>>,
    curve: BTreeMap<Vertex, Vec<Edge>>,
}

impl Jumps<'_> {
    fn is_free(&self, e: Edge) -> bool {
        let two_faces = self.mesh.edge_halfedges(e).len() == 2;
        two_faces && !self.is_curve[e.index()] && self.jump[e.index()].abs() > NOTHING
    }

    fn star(&self) -> Star {
        let mut star = Star { free: BTreeMap::new(), curve: BTreeMap::new() };
        for e in self.mesh.edges() {
            let edges = match (self.is_free(e), self.is_curve[e.index()]) {
                (true, _) => &mut star.free,
                (_, true) => &mut star.curve,
                _ => continue,
            };
            for v in self.mesh.edge_vertices(e) {
                edges.entry(v).or_default().push(e);
            }
        }
        star
    }

    fn high(&self, e: Edge) -> Halfedge {
        self.mesh.edge_halfedges(e)[usize::from(self.jump[e.index()] < 0.0)]
    }

    /// Returns the step that continues another, unless the vertex between them is fixed: on the
    /// curve, at junctions of pieces, and where the sides of the two do not match.
    fn next(&self, star: &Star, step: &Step) -> Option<Step> {
        let mesh = self.mesh;
        let v = step.ends(mesh)[1];
        if star.curve.contains_key(&v) {
            return None;
        }
        let &[a, b] = star.free[&v].as_slice() else { return None };
        let here = mesh.edge(step.high);
        let e = if a == here { b } else { a };
        let high = self.high(e);
        let heights = [here, e].map(|e| self.jump[e.index()].abs());
        let same_height = (heights[0] - heights[1]).abs() <= 1e-6 * heights[0];
        (same_height && transported(mesh, v, step.high, e) == Some(high)).then(|| Step {
            along: high,
            forward: mesh.origin(high) == v,
            high,
        })
    }

    /// Returns the pieces, and the vertices off the curve at which some of them end.
    pub fn pieces(&self) -> (Vec<Piece>, Vec<Vertex>) {
        let mesh = self.mesh;
        let star = self.star();
        let mut seen = vec![false; mesh.edge_count()];
        let mut pieces = Vec::new();
        let mut junctions = Vec::new();
        for e in mesh.edges().filter(|&e| self.is_free(e)) {
            if seen[e.index()] {
                continue;
            }
            let high = self.high(e);
            let mut steps = vec![Step { along: high, forward: true, high }];
            let mut is_loop = false;
            for _ in 0..2 {
                while let Some(next) = self.next(&star, &steps[steps.len() - 1]) {
                    is_loop = mesh.edge(next.high) == e;
                    if is_loop {
                        break;
                    }
                    steps.push(next);
                }
                if is_loop {
                    break;
                }
                junctions.push(steps[steps.len() - 1].ends(mesh)[1]);
                steps.reverse();
                steps.iter_mut().for_each(|s| *s = s.reversed());
            }
            steps.iter().for_each(|s| seen[mesh.edge(s.high).index()] = true);
            let height = self.jump[e.index()].abs();
            pieces.push(Piece { steps, height, is_loop, high_side: high });
        }
        junctions.retain(|v| !star.curve.contains_key(v));
        junctions.sort_unstable();
        junctions.dedup();
        (pieces, junctions)
    }

    /// Extends pieces to open ends of the curve that they miss. Labels are rounded face by face, so
    /// the last edges of a stretch of the curve can have one label on both sides: there the piece
    /// leaves the curve before its end. It is led along the curve to the end, on the side from
    /// which it came. `expected` is the jump that the edges of such a tail must have.
    pub fn extend_to_ends<'a>(
        &self,
        pieces: impl Iterator<Item = &'a mut Piece>,
        expected: impl Fn(Edge) -> Option<f64>,
    ) {
        let star = self.star();
        for piece in pieces.filter(|p| !p.is_loop) {
            for _ in 0..2 {
                if let Some(tail) = self.tail(&star, piece, &expected) {
                    piece.steps.extend(tail);
                }
                piece.reverse();
            }
        }
    }

    fn tail(&self, star: &Star, piece: &Piece, expected: &impl Fn(Edge) -> Option<f64>) -> Option<Vec<Step>> {
        let mesh = self.mesh;
        let last = piece.steps.last()?;
        let mut v = last.ends(mesh)[1];
        let is_bare = |e: Edge| self.jump[e.index()].abs() <= NOTHING && expected(e).is_some();
        let &[a, b] = star.curve.get(&v)?.as_slice() else { return None };
        let (mut edge, rest) = match (is_bare(a), is_bare(b)) {
            (true, false) => (a, b),
            (false, true) => (b, a),
            _ => return None,
        };
        if star.free.get(&v).map_or(0, Vec::len) != 1 {
            return None;
        }
        // The piece turns into the tail on the side away from the rest of the curve.
        let low = other_side(mesh, last.high)?;
        let not_rest = |e: Edge| e != rest;
        let (mut along, on_high) = match swept(mesh, v, last.high, edge, not_rest) {
            Some(side) => (side, true),
            None => (swept(mesh, v, low, edge, not_rest)?, false),
        };
        let mut tail = Vec::new();
        loop {
            let high = if on_high { along } else { other_side(mesh, along)? };
            // Without the piece, the tail has the jump of the curve again.
            let first = mesh.edge_halfedges(edge)[0] == high;
            let left = if first { -piece.height } else { piece.height };
            if (left - expected(edge)?).abs() > NOTHING {
                return None;
            }
            let step = Step { along, forward: mesh.origin(along) == v, high };
            tail.push(step);
            v = step.ends(mesh)[1];
            if star.free.contains_key(&v) || tail.len() > mesh.edge_count() {
                return None;
            }
            match *star.curve.get(&v)?.as_slice() {
                [_] => return Some(tail),
                [a, b] => {
                    edge = if a == edge { b } else { a };
                    if !is_bare(edge) {
                        return None;
                    }
                    along = swept(mesh, v, along, edge, |_| true)?;
                }
                _ => return None,
            }
        }
    }
}
