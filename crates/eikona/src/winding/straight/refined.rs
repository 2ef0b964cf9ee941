//! The mesh cut along straightened pieces: transfers edge and corner data, and integrates jumps.

use super::pieces::Piece;
use super::sides::{redirected, transported};
use crate::cut::Embedded;
use crate::geometry::face_in;
use eikona_mesh::{Edge, Face, Halfedge, TriangleMesh, Vertex};
use eikona_numeric::{NumericError, check_step};
use std::collections::{BTreeMap, VecDeque};

/// A mesh before and after the cut.
pub(super) struct Refined<'a> {
    pub before: &'a TriangleMesh,
    pub cut: &'a Embedded,
}

/// An edge of a straightened piece: its halfedge on the higher side, and its height.
pub(super) type Wall = (Halfedge, f64);

impl Refined<'_> {
    pub fn mesh(&self) -> &TriangleMesh {
        &self.cut.mesh
    }

    /// Returns the barycentric coordinates of a vertex in the face that `face` was cut from.
    fn weights(&self, face: Face, v: Vertex) -> [f64; 3] {
        self.cut.provenance.weights_in(v, self.before.face_vertices(self.cut.provenance.face_parent(face)))
    }

    /// Returns the halfedge before the cut that contains a halfedge.
    pub fn parent(&self, h: Halfedge) -> Option<Halfedge> {
        let face = h.face();
        let [a, b] = [self.mesh().origin(h), self.mesh().tip(h)].map(|v| self.weights(face, v));
        // Side k lies opposite corner k + 2.
        let side = (0..3).find(|k| a[(k + 2) % 3] == 0.0 && b[(k + 2) % 3] == 0.0)?;
        Some(self.cut.provenance.face_parent(face).halfedge(side))
    }

    /// Returns the edge before the cut that contains an edge, and whether the first faces of both
    /// are on the same side.
    fn edge_parent(&self, e: Edge) -> Option<(Edge, bool)> {
        let parent = self.parent(self.mesh().edge_halfedges(e)[0])?;
        let edge = self.before.edge(parent);
        Some((edge, self.before.edge_halfedges(edge)[0] == parent))
    }

    /// Transfers jumps at edges: first face minus second. Edges inside faces have none.
    pub fn jumps<T: Copy + Default + std::ops::Neg<Output = T>>(
        &self,
        jump: &[T],
    ) -> Result<Vec<T>, NumericError> {
        let of = |e: Edge| {
            check_step(e.index())?;
            Ok(match self.edge_parent(e) {
                Some((parent, true)) => jump[parent.index()],
                Some((parent, false)) => -jump[parent.index()],
                None => T::default(),
            })
        };
        self.mesh().edges().map(of).collect()
    }

    /// Transfers values at corners; corners without a value (NaN) have no weight, as in eq. 4.
    pub fn values(&self, values: &[f64]) -> Result<Vec<f64>, NumericError> {
        let mesh = self.mesh();
        let mut result = Vec::with_capacity(3 * mesh.face_count());
        for f in mesh.faces() {
            check_step(f.index())?;
            let parent = self.cut.provenance.face_parent(f).index();
            for v in mesh.face_vertices(f) {
                let (mut sum, mut total) = (0.0, 0.0);
                for (value, weight) in values[3 * parent..].iter().zip(self.weights(f, v)) {
                    if !value.is_nan() && weight != 0.0 {
                        sum += weight * value;
                        total += weight;
                    }
                }
                result.push(if total == 0.0 { f64::NAN } else { sum / total });
            }
        }
        Ok(result)
    }

    /// Returns the edges of a straightened piece with their higher sides, transported from that of
    /// the original piece. `None` if the sides cannot be determined.
    pub fn walls(&self, piece: &Piece, walk: &[Vertex]) -> Option<Vec<Wall>> {
        let mesh = self.mesh();
        let mut walls: Vec<Wall> = Vec::with_capacity(walk.len());
        for ends in walk.windows(2) {
            let edge = mesh.find_edge(ends[0], ends[1])?;
            let high = match walls.last() {
                Some(&(high, _)) => transported(mesh, ends[0], high, edge)?,
                None if piece.is_loop && !walk.first().is_some_and(|v| self.starts_at(piece, *v)) => {
                    // Faces are consistently oriented here, and left stays left.
                    let step = piece.steps.first()?;
                    let on_left = step.forward == (step.along == step.high);
                    let runs_along = |h: &&Halfedge| (mesh.origin(**h) == ends[0]) == on_left;
                    *mesh.edge_halfedges(edge).iter().find(runs_along)?
                }
                None => redirected(mesh, ends[0], self.first_high(piece, ends[0])?, edge)?,
            };
            walls.push((high, piece.height));
        }
        Some(walls)
    }

    fn starts_at(&self, piece: &Piece, v: Vertex) -> bool {
        piece.steps.first().is_some_and(|s| s.ends(self.before)[0] == v)
    }

    /// Returns the halfedge at the piece's first vertex that lies on the higher side of its first
    /// step.
    fn first_high(&self, piece: &Piece, v: Vertex) -> Option<Halfedge> {
        let high = piece.steps.first()?.high;
        let corners = self.mesh().vertex_corners(v).iter();
        let mut sides = corners.flat_map(|c| [c.halfedge(), c.halfedge().previous()]);
        sides.find(|h| {
            self.cut.provenance.face_parent(h.face()) == high.face() && self.parent(*h) == Some(high)
        })
    }

    /// Adds walls to jumps at edges.
    pub fn add(&self, walls: &[Wall], jump: &mut [f64]) {
        for &(high, height) in walls {
            let edge = self.mesh().edge(high);
            let is_first = self.mesh().edge_halfedges(edge)[0] == high;
            jump[edge.index()] += if is_first { height } else { -height };
        }
    }

    /// Integrates jumps to a function that is constant on faces. Its constant on each connected
    /// component keeps the value `before` on the largest area. `None` if the jumps are not
    /// integrable.
    pub fn function(
        &self,
        jump: &[f64],
        before: impl Fn(Face) -> f64,
        unit: f64,
    ) -> Result<Option<Vec<f64>>, NumericError> {
        let mesh = self.mesh();
        let mut value = vec![f64::NAN; mesh.face_count()];
        for first in mesh.faces() {
            if !value[first.index()].is_nan() {
                continue;
            }
            value[first.index()] = 0.0;
            let mut component = Vec::new();
            let mut waiting = VecDeque::from([first]);
            while let Some(f) = waiting.pop_front() {
                check_step(component.len())?;
                component.push(f);
                for e in mesh.face_edges(f) {
                    let &[a, b] = mesh.edge_halfedges(e) else { continue };
                    let (other, jump) = if a.face() == f {
                        (b.face(), -jump[e.index()])
                    } else {
                        (a.face(), jump[e.index()])
                    };
                    let expected = value[f.index()] + jump;
                    let there = &mut value[other.index()];
                    if there.is_nan() {
                        *there = expected;
                        waiting.push_back(other);
                    } else if (*there - expected).abs() > 1e-6 {
                        return Ok(None);
                    }
                }
            }
            let mut votes: BTreeMap<i64, (f64, f64)> = BTreeMap::new();
            for (step, &f) in component.iter().enumerate() {
                check_step(step)?;
                let constant = before(f) - value[f.index()];
                let area = face_in(mesh, f, unit).area;
                votes.entry((1e6 * constant).round() as i64).or_insert((0.0, constant)).0 += area;
            }
            let most = votes.values().max_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |most| most.1);
            component.iter().for_each(|f| value[f.index()] += most);
        }
        Ok(Some(value))
    }
}
