//! Continuous collision detection: how far the vertices of a mesh can move along straight lines
//! before the surface touches itself.
//!
//! A mesh first touches itself where a vertex meets a face or an edge meets an edge. Candidates are
//! pairs of faces whose swept boxes meet; each vertex and each edge is tested with one face that
//! has it. A pair is advanced by steps that its distance proves safe (additive conservative
//! advancement), so no root of a polynomial has to be found, and rounding can only shorten a step.
//!
//! **Reference.** Li, Kaufman and Jiang, *Codimensional Incremental Potential Contact*, ACM
//! Transactions on Graphics 40 (4), 2021, section 5.

use crate::geometry::vector::{add, distance, dot, scale, sub};
use crate::spatial::closest::{closest_point_of_triangle, segment_distance};
use crate::spatial::cluster_tree::ClusterTree;
use eikona_mesh::{Edge, Face, TriangleMesh, Vertex};
use eikona_numeric::{NumericError, check_step, check_stopped, together};

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
    // Swept boxes of long motions meet many others, so shorter ones are tried first: at first about
    // the length of two edges.
    let short = 2.0 * mean_edge(mesh) / longest_relative(motion);
    // Lengths beyond the range of numbers give 0 or NaN.
    let mut tried = if short >= SHORTEST { short } else { SHORTEST };
    loop {
        tried = if tried < 1.0 { tried } else { 1.0 };
        let scaled: Vec<Vec3> = motion.iter().map(|&m| scale(m, tried)).collect();
        let found = first_contact(mesh, &scaled, threads)?;
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

fn first_contact(mesh: &TriangleMesh, motion: &[Vec3], threads: usize) -> Result<SafeMotion, NumericError> {
    let sweep = Sweep::new(mesh, motion)?;
    let mut first = SafeMotion { share: 1.0, contact: None };
    for found in together(sweep.shares(threads).map(|leaves| || sweep.first_contact(leaves))) {
        let found = found?;
        if found.share < first.share {
            first = found;
        }
    }
    Ok(first)
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
    let sweep = Sweep::new(mesh, &still)?;
    let mut least = f64::INFINITY;
    for found in together(sweep.shares(threads).map(|leaves| || sweep.least_distance(leaves))) {
        least = least.min(found?);
    }
    Ok(least)
}

#[derive(Clone, Copy)]
struct Aabb {
    low: Vec3,
    high: Vec3,
}

impl Aabb {
    const EMPTY: Aabb = Aabb { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };

    fn including(mut self, p: Vec3) -> Aabb {
        for k in 0..3 {
            self.low[k] = self.low[k].min(p[k]);
            self.high[k] = self.high[k].max(p[k]);
        }
        self
    }

    /// Distance of the boxes, zero if they meet.
    fn distance(&self, other: &Aabb) -> f64 {
        let apart =
            [0, 1, 2].map(|k| (other.low[k] - self.high[k]).max(self.low[k] - other.high[k]).max(0.0));
        dot(apart, apart).sqrt()
    }

    fn meets(&self, other: &Aabb) -> bool {
        (0..3).all(|k| self.low[k] <= other.high[k] && other.low[k] <= self.high[k])
    }
}

/// The faces of a mesh in a tree, with the boxes that they sweep.
pub(super) struct Sweep<'a> {
    mesh: &'a TriangleMesh,
    motion: &'a [Vec3],
    tree: ClusterTree,
    leaves: Vec<usize>,
    /// Swept boxes of the clusters.
    boxes: Vec<Aabb>,
    /// Swept boxes of the faces, in the order of the tree.
    faces: Vec<Aabb>,
}

impl<'a> Sweep<'a> {
    pub fn new(mesh: &'a TriangleMesh, motion: &'a [Vec3]) -> Result<Sweep<'a>, NumericError> {
        let middle = |f: Face| {
            let corners = mesh.face_vertices(f).map(|v| at(mesh, motion, v, 0.5));
            scale(add(add(corners[0], corners[1]), corners[2]), 1.0 / 3.0)
        };
        let centroids: Vec<Vec3> = mesh.faces().map(middle).collect();
        check_stopped()?;
        let tree = ClusterTree::new(&centroids);
        check_stopped()?;
        let swept = |f: &u32| {
            let corners = mesh.face_vertices(Face(*f));
            corners.iter().fold(Aabb::EMPTY, |whole, &v| {
                whole.including(mesh.position(v)).including(at(mesh, motion, v, 1.0))
            })
        };
        let faces: Vec<Aabb> = tree.order().iter().map(swept).collect();
        let mut boxes = vec![Aabb::EMPTY; tree.nodes().len()];
        for node in (0..boxes.len()).rev() {
            let join = |whole: Aabb, part: &Aabb| whole.including(part.low).including(part.high);
            boxes[node] = match tree.children(node) {
                Some([a, b]) => [boxes[a], boxes[b]].iter().fold(Aabb::EMPTY, join),
                None => faces[tree.nodes()[node].places()].iter().fold(Aabb::EMPTY, join),
            };
        }
        check_stopped()?;
        let leaves = (0..boxes.len()).filter(|&node| tree.nodes()[node].is_leaf()).collect();
        Ok(Sweep { mesh, motion, tree, leaves, boxes, faces })
    }

    /// The face at a place.
    pub fn face(&self, place: usize) -> Face {
        Face(self.tree.order()[place])
    }

    /// The leaves, divided among threads.
    pub fn shares(&self, threads: usize) -> impl Iterator<Item = &[usize]> {
        self.leaves.chunks(self.leaves.len().div_ceil(threads.max(1)).max(1))
    }

    /// The first contact of the faces of some leaves with faces at later places.
    fn first_contact(&self, leaves: &[usize]) -> Result<SafeMotion, NumericError> {
        let mut first = SafeMotion { share: 1.0, contact: None };
        self.for_pairs(leaves, |a, b| self.test_faces(a, b, &mut first))?;
        Ok(first)
    }

    /// Calls a function with the places of each pair of faces whose boxes meet, the first in some
    /// leaves, the second at a later place.
    pub fn for_pairs(
        &self,
        leaves: &[usize],
        mut visit: impl FnMut(usize, usize),
    ) -> Result<(), NumericError> {
        let mut stack = Vec::new();
        for (step, &leaf) in leaves.iter().enumerate() {
            check_step(16 * step)?;
            let own = self.tree.nodes()[leaf].places();
            stack.push(0);
            while let Some(node) = stack.pop() {
                let cluster = self.tree.nodes()[node];
                if cluster.places().end <= own.start || !self.boxes[node].meets(&self.boxes[leaf]) {
                    continue;
                }
                if let Some(children) = self.tree.children(node) {
                    stack.extend(children);
                    continue;
                }
                for a in own.clone() {
                    for b in cluster.places().filter(|&b| b > a && self.faces[a].meets(&self.faces[b])) {
                        visit(a, b);
                    }
                }
            }
        }
        Ok(())
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
        let mut least = f64::INFINITY;
        for (points, triangle) in [(s, t), (t, s)] {
            for p in points {
                least = least.min(closest_point_of_triangle(p, triangle).2.sqrt());
            }
        }
        let sides = |[a, b, c]: [Vec3; 3]| [[a, b], [b, c], [c, a]];
        for side in sides(s) {
            for other in sides(t) {
                least = least.min(segment_distance(side, other));
            }
        }
        least
    }

    /// Tests the vertices and edges that are assigned to two faces with each other.
    fn test_faces(&self, a: usize, b: usize, first: &mut SafeMotion) {
        let mesh = self.mesh;
        let [f, g] = [a, b].map(|place| self.face(place));
        for (f, g, other) in [(f, g, b), (g, f, a)] {
            for v in self.own_vertices(f).filter(|v| !mesh.face_vertices(g).contains(v)) {
                if self.swept([v]).meets(&self.faces[other]) {
                    let corners = mesh.face_vertices(g);
                    let share = self.advance([v, corners[0], corners[1], corners[2]], 1, first.share);
                    self.note(share, Contact::VertexFace(v, g), first);
                }
            }
        }
        for d in self.own_edges(f) {
            let ends = mesh.edge_vertices(d);
            let swept = self.swept(ends);
            if !swept.meets(&self.faces[b]) {
                continue;
            }
            for e in self.own_edges(g) {
                let others = mesh.edge_vertices(e);
                if ends.iter().any(|v| others.contains(v)) || !swept.meets(&self.swept(others)) {
                    continue;
                }
                let share = self.advance([ends[0], ends[1], others[0], others[1]], 2, first.share);
                self.note(share, Contact::EdgeEdge(d, e), first);
            }
        }
    }

    fn note(&self, share: f64, contact: Contact, first: &mut SafeMotion) {
        if share < first.share {
            *first = SafeMotion { share, contact: Some(contact) };
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

    fn swept<const N: usize>(&self, vertices: [Vertex; N]) -> Aabb {
        vertices.iter().fold(Aabb::EMPTY, |whole, &v| {
            whole.including(self.mesh.position(v)).including(at(self.mesh, self.motion, v, 1.0))
        })
    }

    /// Returns a share of the motion, at most `most`, that is safe for two elements: the first
    /// `count` vertices, and the others.
    fn advance(&self, vertices: [Vertex; 4], count: usize, most: f64) -> f64 {
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
