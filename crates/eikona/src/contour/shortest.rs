//! The shortest way between two places on a surface, and whether there is another one that is nearly as short.
//!
//! The search (A*) runs over vertices and midpoints of edges, joined across faces. Its ways are at most 4 % longer than the shortest
//! ones where faces are nearly equilateral (those along edges alone 15 %), so that it rarely takes the wrong side of an
//! obstacle; straightening does the rest.

use super::straighten::{path_length, straighten};
use crate::geometry::vector::{Vec3, distance, lerp};
use eikona_mesh::{Edge, Face, Located, TriangleMesh, Vertex};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

/// Ways whose lengths differ by no more than this share are equally good to a reader of the curve.
pub(super) const AMBIGUOUS: f64 = 0.03;

/// Two ways differ if their middles lie this share of their length apart.
const APART: f64 = 0.25;

/// Searches over one mesh.
pub(super) struct WaySearch<'a> {
    mesh: &'a TriangleMesh,
    there: Reached,
    back: Reached,
    /// Nodes that all searches so far have settled.
    pub settled: usize,
}

impl<'a> WaySearch<'a> {
    pub fn new(mesh: &'a TriangleMesh) -> Self {
        WaySearch { mesh, there: Reached::default(), back: Reached::default(), settled: 0 }
    }

    /// The shortest way found, from `from` to `to`, and its length. `None` if no way over the surface joins them.
    ///
    /// # Cost
    /// O(n log n) in the number of faces no farther from one end than a way over them is long.
    pub fn shortest(&mut self, from: Located, to: Located) -> Option<(Vec<Located>, f64)> {
        let (last, _) = self.there.search(self.mesh, from, to, 1.0, &mut self.settled)?;
        let mut path = self.there.path_to(self.mesh, last, from);
        path.push(to);
        path.dedup();
        let path = straighten(self.mesh, &path);
        let length = path_length(self.mesh, &path);
        Some((path, length))
    }

    /// A way of nearly the same length as `way` whose middle lies far from the middle of that: the farthest one there is.
    ///
    /// # Cost
    /// Two searches over all faces that such ways may touch.
    pub fn other_way(&mut self, way: &[Located], length: f64) -> Option<Vec<Located>> {
        let (mesh, from, to) = (self.mesh, *way.first()?, *way.last()?);
        let slack = 1.0 + AMBIGUOUS;
        let (_, found) = self.there.search(mesh, from, to, slack, &mut self.settled)?;
        self.back.search(mesh, to, from, slack, &mut self.settled)?;
        let middle = middle_of(mesh, way, length);
        let through = |node: u32| {
            let (there, back) = (self.there.length_to(node), self.back.length_to(node));
            let halfway = (there - back).abs() < 0.1 * found && there + back <= slack * found;
            let apart = distance(position(mesh, node), middle);
            (halfway && apart >= APART * length).then_some((node, apart, there + back))
        };
        let nodes = || self.there.0.keys().copied().filter_map(through);
        let farthest = nodes().max_by(|p, q| p.1.total_cmp(&q.1).then(q.0.cmp(&p.0)));
        let shortest = nodes().min_by(|p, q| p.2.total_cmp(&q.2).then(p.0.cmp(&q.0)));
        [farthest, shortest]
            .into_iter()
            .flatten()
            .map(|(node, ..)| self.way_through(node, from, to))
            .find(|other| path_length(mesh, other) <= slack * length)
    }

    /// The straightened ways of the last two searches to and from a node, joined.
    fn way_through(&self, node: u32, from: Located, to: Located) -> Vec<Located> {
        let [mut way, mut rest] = [(&self.there, from), (&self.back, to)]
            .map(|(reached, end)| reached.path_to(self.mesh, node, end));
        way.dedup();
        rest.reverse();
        rest.dedup();
        let mut way = straighten(self.mesh, &way);
        way.extend(straighten(self.mesh, &rest).into_iter().skip(1));
        way
    }
}

/// Where half of a path's length lies behind.
fn middle_of(mesh: &TriangleMesh, path: &[Located], length: f64) -> Vec3 {
    let mut left = 0.5 * length;
    for pair in path.windows(2) {
        let [p, q] = [pair[0].position(mesh), pair[1].position(mesh)];
        let step = distance(p, q);
        if step >= left && step > 0.0 {
            return lerp(p, q, left / step);
        }
        left -= step;
    }
    path[path.len() - 1].position(mesh)
}

/// Vertices come first in the numbering of nodes, then edges, which stand for their midpoints.
fn place(mesh: &TriangleMesh, node: u32) -> Located {
    match node.checked_sub(mesh.vertex_count() as u32) {
        None => Located::Vertex(Vertex(node)),
        Some(edge) => Located::Edge(Edge(edge), 0.5),
    }
}

fn position(mesh: &TriangleMesh, node: u32) -> Vec3 {
    place(mesh, node).position(mesh)
}

/// What one search has reached: for each node the length of the way to it, and the node before.
#[derive(Default)]
struct Reached(HashMap<u32, (f64, u32)>);

/// The start has no previous node.
const NONE: u32 = u32::MAX;

impl Reached {
    /// Searches until every node is reached that lies on a way up to `slack` times as long as the shortest one found. The last node
    /// of that, and its length.
    fn search(
        &mut self,
        mesh: &TriangleMesh,
        from: Located,
        to: Located,
        slack: f64,
        settled: &mut usize,
    ) -> Option<(u32, f64)> {
        self.0 = HashMap::new(); // clearing a large one would cost every small search after it
        let vertices = mesh.vertex_count() as u32;
        let of_edge = |e: Edge| vertices + e.0;
        let around = |place: Located| {
            let nodes = move |f: Face| {
                let (v, e) = (mesh.face_vertices(f), mesh.face_edges(f));
                v.map(|v| v.0).into_iter().chain(e.map(of_edge))
            };
            let p = place.position(mesh);
            place.faces(mesh).into_iter().flat_map(nodes).map(move |n| (n, distance(p, position(mesh, n))))
        };
        let goal = to.position(mesh);
        // Lengths are not negative, so their bits order as they do. Ties go to the lower node.
        let key = |d: f64, node: u32, p: Vec3| Reverse(((d + distance(p, goal)).to_bits(), node));
        let mut queue = BinaryHeap::new();
        for (node, d) in around(from) {
            if d < self.length_to(node) {
                self.0.insert(node, (d, NONE));
                queue.push(key(d, node, position(mesh, node)));
            }
        }
        let rest: HashMap<u32, f64> = around(to).collect();
        let mut best: Option<(u32, f64)> = None;
        let mut neighbours = Vec::new();
        while let Some(Reverse((bits, node))) = queue.pop() {
            if best.is_some_and(|(_, length)| f64::from_bits(bits) > slack * length) {
                break;
            }
            let (p, d) = (position(mesh, node), self.length_to(node));
            if Reverse((bits, node)) != key(d, node, p) {
                continue; // reached by a shorter way since
            }
            *settled += 1;
            if let Some(rest) = rest.get(&node)
                && best.is_none_or(|b| d + rest < b.1)
            {
                best = Some((node, d + rest));
            }
            neighbours.clear();
            match place(mesh, node) {
                Located::Edge(e, _) => {
                    for h in mesh.edge_halfedges(e) {
                        let (next, previous) = (h.next(), h.previous());
                        neighbours.extend([
                            mesh.origin(previous).0,
                            of_edge(mesh.edge(next)),
                            of_edge(mesh.edge(previous)),
                        ]);
                    }
                }
                // The midpoints of its own edges lie on no shorter way.
                _ => {
                    for c in mesh.vertex_corners(Vertex(node)) {
                        let h = c.halfedge();
                        neighbours.extend([
                            mesh.tip(h).0,
                            mesh.origin(h.previous()).0,
                            of_edge(mesh.edge(h.next())),
                        ]);
                    }
                }
            }
            for &next in &neighbours {
                let q = position(mesh, next);
                let e = d + distance(p, q);
                if e < self.length_to(next) {
                    self.0.insert(next, (e, node));
                    queue.push(key(e, next, q));
                }
            }
        }
        best
    }

    fn length_to(&self, node: u32) -> f64 {
        self.0.get(&node).map_or(f64::INFINITY, |r| r.0)
    }

    /// The way from the start of the search to a node.
    fn path_to(&self, mesh: &TriangleMesh, node: u32, start: Located) -> Vec<Located> {
        let mut path = Vec::new();
        let mut node = node;
        while node != NONE {
            path.push(place(mesh, node));
            node = self.0.get(&node).map_or(NONE, |r| r.1);
        }
        path.push(start);
        path.reverse();
        path
    }
}
