//! Continuous collision detection: how far the vertices of a mesh can move along straight lines
//! before the surface touches itself.
//!
//! A mesh first touches itself where a vertex meets a face or an edge meets an edge. Candidates are
//! pairs of faces whose boxes meet on the way; boxes know the range of the motions inside of them,
//! so faces that move alike are no candidates. Each vertex and each edge is tested with one face
//! that has it. A pair is advanced by steps that its distance proves safe (additive conservative
//! advancement), so no root of a polynomial has to be found, and rounding can only shorten a step.
//!
//! **Reference.** Li, Kaufman and Jiang, *Codimensional Incremental Potential Contact*, ACM
//! Transactions on Graphics 40 (4), 2021, section 5.

use crate::geometry::vector::{add, distance, dot, scale, sub};
use crate::spatial::closest::{closest_point_of_triangle, segment_distance, triangle_distance};
use crate::spatial::cluster_tree::ClusterTree;
use eikona_mesh::{Edge, Face, TriangleMesh, Vertex};
use eikona_numeric::{NumericError, check_step, check_stopped, mapped};
use std::ops::ControlFlow;

type Vec3 = [f64; 3];

/// The share of its distance that a pair keeps.
const KEPT: f64 = 0.1;

/// Advances of one pair: those of elements that slide along each other at a tiny distance have no
/// end. As far as they have come is safe.
const MOST_ADVANCES: usize = 1000;

/// The pair that limits a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Contact {
    /// A vertex and a face.
    VertexFace(Vertex, Face),
    /// Two edges.
    EdgeEdge(Edge, Edge),
}

impl Contact {
    /// Returns the vertices of both elements, those of the first one first.
    pub fn vertices(self, mesh: &TriangleMesh) -> [Vertex; 4] {
        match self {
            Contact::VertexFace(v, f) => {
                let [a, b, c] = mesh.face_vertices(f);
                [v, a, b, c]
            }
            Contact::EdgeEdge(d, e) => {
                let ([a, b], [p, q]) = (mesh.edge_vertices(d), mesh.edge_vertices(e));
                [a, b, p, q]
            }
        }
    }
}

/// The share of a motion that keeps a mesh from touching itself.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SafeMotion {
    /// The share, from 0 to 1. After it, each pair of elements still has a tenth of its distance.
    pub share: f64,
    /// The pair that limits the motion; `None` if all of it is safe.
    pub contact: Option<Contact>,
}

/// Returns the share of a motion of the vertices along straight lines that is proven to keep the
/// mesh from touching itself. All pairs of a vertex and a face, or of two edges, are tested that
/// share no vertex, those in one fan included.
///
/// A pair that touches already allows no motion.
///
/// # Panics
/// If there is not one displacement per vertex.
///
/// # Errors
/// [`NumericError::Stopped`].
///
/// # Cost
/// O(F log F) if few boxes meet: about 2 us per face and thread for short motions.
///
/// ```
/// use eikona::mesh::TriangleMesh;
/// use eikona::spatial::safe_motion;
/// // A triangle and another one above it that falls by 4.
/// let base = [[0., 0., 0.], [9., 0., 0.], [0., 9., 0.]];
/// let top = [[1., 1., 2.], [2., 1., 3.], [1., 2., 3.]];
/// let mesh = TriangleMesh::new([base, top].concat(), vec![[0, 1, 2], [3, 4, 5]])?;
/// let fall = [[[0.; 3]; 3], [[0., 0., -4.]; 3]].concat();
/// let safe = safe_motion(&mesh, &fall, 1)?;
/// assert!(safe.share > 0.44 && safe.share < 0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn safe_motion(mesh: &TriangleMesh, motion: &[Vec3], threads: usize) -> Result<SafeMotion, NumericError> {
    assert_eq!(motion.len(), mesh.vertex_count(), "one displacement per vertex");
    safe_motion_in(mesh, mesh.face_count(), motion, threads)
}

/// Like [`safe_motion`], past an obstacle that stays where it is. Faces and vertices of the
/// obstacle are numbered after those of the mesh.
///
/// # Panics
/// If there is not one displacement per vertex of the mesh.
///
/// # Errors
/// [`NumericError::Stopped`].
///
/// # Cost
/// As for [`safe_motion`], with the faces of both.
///
/// ```
/// use eikona::mesh::{Face, TriangleMesh, Vertex};
/// use eikona::spatial::{Contact, safe_motion_past};
/// let floor = TriangleMesh::new(vec![[0., 0., 0.], [9., 0., 0.], [0., 9., 0.]], vec![[0, 1, 2]])?;
/// let top = TriangleMesh::new(vec![[1., 1., 2.], [2., 1., 3.], [1., 2., 3.]], vec![[0, 1, 2]])?;
/// let safe = safe_motion_past(&top, &[[0., 0., -4.]; 3], &floor, 1)?;
/// assert!(safe.share > 0.44 && safe.share < 0.5);
/// assert_eq!(safe.contact, Some(Contact::VertexFace(Vertex(0), Face(1))));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn safe_motion_past(
    mesh: &TriangleMesh,
    motion: &[Vec3],
    obstacle: &TriangleMesh,
    threads: usize,
) -> Result<SafeMotion, NumericError> {
    assert_eq!(motion.len(), mesh.vertex_count(), "one displacement per vertex");
    let still = vec![[0.0; 3]; obstacle.vertex_count()];
    safe_motion_in(&joined(mesh, obstacle), mesh.face_count(), &[motion, &still].concat(), threads)
}

/// Both meshes as one.
pub(crate) fn joined(first: &TriangleMesh, second: &TriangleMesh) -> TriangleMesh {
    let shift = first.vertex_count() as u32;
    let faces = second.triangles().iter().map(|corners| corners.map(|v| v + shift));
    TriangleMesh::new(
        [first.positions(), second.positions()].concat(),
        first.triangles().iter().copied().chain(faces).collect(),
    )
    .expect("both meshes are valid")
}

/// The same, where only the first faces move.
fn safe_motion_in(
    mesh: &TriangleMesh,
    moving: usize,
    motion: &[Vec3],
    threads: usize,
) -> Result<SafeMotion, NumericError> {
    // Boxes of long motions meet many others, so shorter ones are tried first: at first about
    // the length of two edges.
    let short = 2.0 * mean_edge(mesh) / longest_relative(motion);
    // Lengths beyond the range of numbers give 0 or NaN.
    let mut tried = if short >= SHORTEST { short } else { SHORTEST };
    loop {
        tried = if tried < 1.0 { tried } else { 1.0 };
        let scaled: Vec<Vec3> = motion.iter().map(|&m| scale(m, tried)).collect();
        let found = first_contact(mesh, moving, &scaled, threads)?;
        if found.contact.is_some() {
            return Ok(SafeMotion { share: tried * found.share, ..found });
        }
        if tried == 1.0 {
            return Ok(found);
        }
        tried *= GROWTH;
    }
}

/// The shortest share of a motion that is tried first.
const SHORTEST: f64 = 1e-6;
/// By how much the motion that is tried grows.
const GROWTH: f64 = 4.0;

fn mean_edge(mesh: &TriangleMesh) -> f64 {
    let length = |e: Edge| {
        let [a, b] = mesh.edge_vertices(e).map(|v| mesh.position(v));
        distance(a, b)
    };
    mesh.edges().map(length).sum::<f64>() / mesh.edge_count().max(1) as f64
}

/// The longest displacement relative to the mean one.
fn longest_relative(motion: &[Vec3]) -> f64 {
    let sum = motion.iter().fold([0.0; 3], |sum, &m| add(sum, m));
    let mean = scale(sum, 1.0 / motion.len().max(1) as f64);
    motion.iter().map(|&m| distance(m, mean)).fold(0.0, f64::max)
}

fn first_contact(
    mesh: &TriangleMesh,
    moving: usize,
    motion: &[Vec3],
    threads: usize,
) -> Result<SafeMotion, NumericError> {
    let sweep = Sweep::new(mesh, moving, motion, threads)?;
    let mut first = SafeMotion { share: 1.0, contact: None };
    for found in sweep.tree.over_leaves(threads, |leaves| sweep.first_contact(leaves))? {
        if found.share < first.share {
            first = found;
        }
    }
    Ok(first)
}

/// Returns all pairs of elements that would come closer than a tenth of their distance if all
/// vertices moved along straight lines, or that touch already. Without them, the whole motion is
/// safe. Only the first faces move.
pub(crate) fn contacts(
    mesh: &TriangleMesh,
    moving: usize,
    motion: &[Vec3],
    threads: usize,
) -> Result<Vec<Contact>, NumericError> {
    let sweep = Sweep::new(mesh, moving, motion, threads)?;
    Ok(sweep.tree.over_leaves(threads, |leaves| sweep.contacts(leaves))?.concat())
}

/// Returns the smallest distance of two faces that share no vertex; infinite if all do.
///
/// # Errors
/// [`NumericError::Stopped`].
///
/// # Cost
/// O(F log F).
///
/// ```
/// use eikona::mesh::TriangleMesh;
/// use eikona::spatial::self_distance;
/// let base = [[0., 0., 0.], [9., 0., 0.], [0., 9., 0.]];
/// let top = [[1., 1., 2.], [2., 1., 3.], [1., 2., 3.]];
/// let mesh = TriangleMesh::new([base, top].concat(), vec![[0, 1, 2], [3, 4, 5]])?;
/// assert_eq!(self_distance(&mesh, 1)?, 2.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn self_distance(mesh: &TriangleMesh, threads: usize) -> Result<f64, NumericError> {
    let still = vec![[0.0; 3]; mesh.vertex_count()];
    let sweep = Sweep::new(mesh, mesh.face_count(), &still, threads)?;
    let found = sweep.tree.over_leaves(threads, |leaves| sweep.least_distance(leaves))?;
    Ok(found.into_iter().fold(f64::INFINITY, f64::min))
}

/// A box around points at the start, and the range of their motions. Two boxes that move alike do
/// not meet, however far they go.
#[derive(Clone, Copy, Default)]
struct MovingBox {
    low: Vec3,
    high: Vec3,
    least: Vec3,
    largest: Vec3,
}

/// Boxes meet if they are no farther apart than rounding.
const ROUNDING: f64 = 1e-14;

impl MovingBox {
    const EMPTY: MovingBox = MovingBox {
        low: [f64::INFINITY; 3],
        high: [f64::NEG_INFINITY; 3],
        least: [f64::INFINITY; 3],
        largest: [f64::NEG_INFINITY; 3],
    };

    fn including(mut self, p: Vec3, motion: Vec3) -> MovingBox {
        for k in 0..3 {
            self.low[k] = self.low[k].min(p[k]);
            self.high[k] = self.high[k].max(p[k]);
            self.least[k] = self.least[k].min(motion[k]);
            self.largest[k] = self.largest[k].max(motion[k]);
        }
        self
    }

    fn joined(self, other: &MovingBox) -> MovingBox {
        self.including(other.low, other.least).including(other.high, other.largest)
    }

    /// Distance of the boxes at the start, zero if they meet.
    fn distance(&self, other: &MovingBox) -> f64 {
        let apart =
            [0, 1, 2].map(|k| (other.low[k] - self.high[k]).max(self.low[k] - other.high[k]).max(0.0));
        dot(apart, apart).sqrt()
    }

    /// Whether points of both may meet on the way: along no axis is the gap wider than what the
    /// points of one move relative to those of the other.
    fn meets(&self, other: &MovingBox) -> bool {
        let comes = |first: &MovingBox, second: &MovingBox, k: usize| {
            let gap = second.low[k] - first.high[k];
            let closer = (first.largest[k] - second.least[k]).max(0.0);
            gap <= closer + ROUNDING * (second.low[k].abs() + first.high[k].abs() + closer)
        };
        (0..3).all(|k| comes(self, other, k) && comes(other, self, k))
    }
}

/// The faces of a mesh in a tree, with boxes that move with them.
pub(super) struct Sweep<'a> {
    mesh: &'a TriangleMesh,
    /// The first faces move; pairs of others do not count.
    moving: usize,
    motion: &'a [Vec3],
    pub tree: ClusterTree,
    /// Boxes of the clusters.
    boxes: Vec<MovingBox>,
    /// Boxes of the faces, in the order of the tree.
    faces: Vec<MovingBox>,
}

impl<'a> Sweep<'a> {
    pub fn new(
        mesh: &'a TriangleMesh,
        moving: usize,
        motion: &'a [Vec3],
        threads: usize,
    ) -> Result<Sweep<'a>, NumericError> {
        let middle = |f: Face| {
            let corners = mesh.face_vertices(f).map(|v| at(mesh, motion, v, 0.5));
            scale(add(add(corners[0], corners[1]), corners[2]), 1.0 / 3.0)
        };
        let centroids: Vec<Vec3> = mapped(threads, mesh.face_count(), |f| middle(Face(f as u32)))?;
        let tree = ClusterTree::on_threads(&centroids, threads);
        let of_face = |place: usize| {
            let corners = mesh.face_vertices(Face(tree.order()[place]));
            corners
                .iter()
                .fold(MovingBox::EMPTY, |whole, &v| whole.including(mesh.position(v), motion[v.index()]))
        };
        let faces: Vec<MovingBox> = mapped(threads, mesh.face_count(), of_face)?;
        let mut boxes = vec![MovingBox::EMPTY; tree.nodes().len()];
        tree.ascend(&mut boxes, 1, threads, |node, own, children| {
            own[0] = match children {
                Some([a, b]) => a[0].joined(&b[0]),
                None => faces[tree.nodes()[node].places()].iter().fold(MovingBox::EMPTY, |w, f| w.joined(f)),
            };
        });
        check_stopped()?;
        Ok(Sweep { mesh, moving, motion, tree, boxes, faces })
    }

    fn moves(&self, place: usize) -> bool {
        self.face(place).index() < self.moving
    }

    /// The face at a place.
    pub fn face(&self, place: usize) -> Face {
        Face(self.tree.order()[place])
    }

    /// The first contact of the faces of some leaves with faces at later places.
    fn first_contact(&self, leaves: &[usize]) -> Result<SafeMotion, NumericError> {
        let mut first = SafeMotion { share: 1.0, contact: None };
        self.for_pairs(leaves, |a, b| {
            self.for_elements(a, b, |contact| {
                let share = self.advance(contact, first.share);
                if share < first.share {
                    first = SafeMotion { share, contact: Some(contact) };
                }
            });
        })?;
        Ok(first)
    }

    /// All contacts of the faces of some leaves with faces at later places.
    fn contacts(&self, leaves: &[usize]) -> Result<Vec<Contact>, NumericError> {
        let mut found = Vec::new();
        self.for_pairs(leaves, |a, b| {
            self.for_elements(a, b, |contact| {
                if self.advance(contact, 1.0) < 1.0 {
                    found.push(contact);
                }
            });
        })?;
        Ok(found)
    }

    /// Calls a function with the places of each pair of faces whose boxes meet, the first in some
    /// leaves, the second at a later place.
    pub fn for_pairs(
        &self,
        leaves: &[usize],
        mut visit: impl FnMut(usize, usize),
    ) -> Result<(), NumericError> {
        let meet = |leaf: usize, node: usize| self.boxes[node].meets(&self.boxes[leaf]);
        self.tree.for_pairs(leaves, meet, |a, b| {
            if self.faces[a].meets(&self.faces[b]) && (self.moves(a) || self.moves(b)) {
                visit(a, b);
            }
            ControlFlow::Continue(())
        })
    }

    /// The least distance of the faces of some leaves from faces that share no vertex with them.
    fn least_distance(&self, leaves: &[usize]) -> Result<f64, NumericError> {
        let mut least = f64::INFINITY;
        let mut stack = Vec::new();
        for (step, &leaf) in leaves.iter().enumerate() {
            check_step(16 * step)?;
            stack.push((0, 0.0));
            while let Some((node, box_distance)) = stack.pop() {
                if box_distance >= least {
                    continue;
                }
                if let Some(children) = self.tree.children(node) {
                    let [near, far] =
                        children.map(|child| (child, self.boxes[child].distance(&self.boxes[leaf])));
                    // The nearer one is visited first.
                    stack.extend(if near.1 <= far.1 { [far, near] } else { [near, far] });
                    continue;
                }
                for a in self.tree.nodes()[leaf].places() {
                    for b in self.tree.nodes()[node].places() {
                        if self.faces[a].distance(&self.faces[b]) < least {
                            least = least.min(self.face_distance(a, b));
                        }
                    }
                }
            }
        }
        Ok(least)
    }

    /// The distance of two faces that do not cross; infinite if they share a vertex.
    fn face_distance(&self, a: usize, b: usize) -> f64 {
        let [s, t] = [a, b].map(|place| self.mesh.face_vertices(self.face(place)));
        if s.iter().any(|v| t.contains(v)) {
            return f64::INFINITY;
        }
        let [s, t] = [s, t].map(|corners| corners.map(|v| self.mesh.position(v)));
        triangle_distance(s, t)
    }

    /// Visits the pairs of a vertex and a face, or of two edges, that are assigned to two faces and
    /// whose boxes meet.
    fn for_elements(&self, a: usize, b: usize, mut visit: impl FnMut(Contact)) {
        let mesh = self.mesh;
        let [f, g] = [a, b].map(|place| self.face(place));
        for (f, g, other) in [(f, g, b), (g, f, a)] {
            for v in self.own_vertices(f).filter(|v| !mesh.face_vertices(g).contains(v)) {
                if self.box_of([v]).meets(&self.faces[other]) {
                    visit(Contact::VertexFace(v, g));
                }
            }
        }
        for d in self.own_edges(f) {
            let ends = mesh.edge_vertices(d);
            let own = self.box_of(ends);
            if !own.meets(&self.faces[b]) {
                continue;
            }
            for e in self.own_edges(g) {
                let others = mesh.edge_vertices(e);
                if !ends.iter().any(|v| others.contains(v)) && own.meets(&self.box_of(others)) {
                    visit(Contact::EdgeEdge(d, e));
                }
            }
        }
    }

    /// Each vertex belongs to its first face.
    fn own_vertices(&self, f: Face) -> impl Iterator<Item = Vertex> {
        let own = move |v: &Vertex| self.mesh.vertex_corners(*v).first().is_some_and(|c| c.face() == f);
        self.mesh.face_vertices(f).into_iter().filter(own)
    }

    /// Each edge belongs to its first face.
    fn own_edges(&self, f: Face) -> impl Iterator<Item = Edge> {
        let own = move |e: &Edge| self.mesh.edge_halfedges(*e)[0].face() == f;
        self.mesh.face_edges(f).into_iter().filter(own)
    }

    fn box_of<const N: usize>(&self, vertices: [Vertex; N]) -> MovingBox {
        vertices.iter().fold(MovingBox::EMPTY, |whole, &v| {
            whole.including(self.mesh.position(v), self.motion[v.index()])
        })
    }

    /// Returns a share of the motion, at most `most`, that is safe for two elements.
    fn advance(&self, contact: Contact, most: f64) -> f64 {
        let vertices = contact.vertices(self.mesh);
        let count = match contact {
            Contact::VertexFace(..) => 1,
            Contact::EdgeEdge(..) => 2,
        };
        let start = vertices.map(|v| self.mesh.position(v));
        let moves = vertices.map(|v| self.motion[v.index()]);
        // Only relative motion counts.
        let mean = scale(moves.iter().fold([0.0; 3], |sum, &m| add(sum, m)), 0.25);
        let moves = moves.map(|m| sub(m, mean));
        let fastest = |moves: &[Vec3]| moves.iter().map(|m| dot(*m, *m)).fold(0.0, f64::max).sqrt();
        let speed = fastest(&moves[..count]) + fastest(&moves[count..]);
        if speed == 0.0 {
            return most;
        }
        let distance_at = |t: f64| {
            let p: [Vec3; 4] = std::array::from_fn(|i| add(start[i], scale(moves[i], t)));
            if count == 1 {
                closest_point_of_triangle(p[0], [p[1], p[2], p[3]]).2.sqrt()
            } else {
                segment_distance([p[0], p[1]], [p[2], p[3]])
            }
        };
        let mut at = distance_at(0.0);
        // Beyond the range of numbers, nothing is proven.
        if !(at.is_finite() && speed.is_finite()) {
            return 0.0;
        }
        let kept = KEPT * at;
        let mut share = (1.0 - KEPT) * at / speed;
        for _ in 0..MOST_ADVANCES {
            if share >= most {
                return most;
            }
            at = distance_at(share);
            if at.is_nan() || at <= 1.5 * kept {
                break;
            }
            share += 0.9 * (at - kept) / speed;
        }
        share.min(most)
    }
}

/// The position of a vertex after a share of its motion.
fn at(mesh: &TriangleMesh, motion: &[Vec3], v: Vertex, share: f64) -> Vec3 {
    add(mesh.position(v), scale(motion[v.index()], share))
}
