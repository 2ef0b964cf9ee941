//! Shortest paths between two points on a surface, and near-equal alternatives.
//!
//! An A* search runs over the vertices and the midpoints of edges, joined across faces. On nearly
//! equilateral faces its paths are at most 4 % longer than geodesics (paths along edges: 15 %), so
//! it rarely takes the wrong side of an obstacle. Straightening does the rest.

use super::straighten::{path_length, straighten};
use crate::geometry::vector::{Vec3, distance};
use eikona_mesh::{Edge, Face, Located, TriangleMesh, Vertex};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

/// Paths whose lengths differ by at most this share count as equally good.
pub(super) const AMBIGUOUS: f64 = 0.03;

/// Two paths differ if their midpoints are this share of their length apart, along the surface.
const APART: f64 = 0.25;

/// Relative length difference that counts as a tie. On regular meshes many paths differ only by
/// rounding; the path whose nodes have the smaller coordinates wins, so that neither numbering nor
/// scale matters.
const EQUAL: f64 = 1e-12;

/// Shortest-path searches on one mesh.
pub(super) struct PathSearch<'a> {
    mesh: &'a TriangleMesh,
    /// Number of nodes settled by all searches so far.
    pub settled: usize,
}

impl<'a> PathSearch<'a> {
    pub fn new(mesh: &'a TriangleMesh) -> Self {
        PathSearch { mesh, settled: 0 }
    }

    /// Returns the straightened shortest path and its length; `None` if the surface does not
    /// connect the ends.
    ///
    /// # Cost
    /// O(n log n) in the number of faces whose distances from both ends sum to at most the path's
    /// length.
    pub fn shortest(&mut self, from: Located, to: Located) -> Option<(Vec<Located>, f64)> {
        let (reached, last, _) = self.towards(from, to, 1.0)?;
        let mut path = reached.path_to(self.mesh, last);
        path.push(to);
        path.dedup();
        let path = straighten(self.mesh, &path);
        let length = path_length(self.mesh, &path);
        Some((path, length))
    }

    /// Returns an alternative to `path`: at most [`AMBIGUOUS`] longer than the shortest `length`,
    /// with its midpoint far from the midpoint of `path`; of several, the farthest.
    ///
    /// # Cost
    /// Three searches over the faces that such paths can touch.
    pub fn alternative(&mut self, path: &[Located], length: f64) -> Option<Vec<Located>> {
        let (mesh, from, to) = (self.mesh, *path.first()?, *path.last()?);
        let slack = 1.0 + AMBIGUOUS;
        let (there, _, found) = self.towards(from, to, slack)?;
        let (back, ..) = self.towards(to, from, slack)?;
        let middle = middle_of(mesh, path)?;
        let near = self.search(middle, |_| 0.0, |_, d, _| d <= APART * length);
        let mut farthest: Option<(f64, u32)> = None;
        let mut shortest: Option<(f64, u32)> = None;
        for (&node, &(d, _)) in &there.nodes {
            let rest = back.length_to(node);
            let halfway = (d - rest).abs() < 0.1 * found && d + rest <= slack * found;
            if !halfway || near.length_to(node) <= APART * length {
                continue;
            }
            let off = distance(position(mesh, node), middle.position(mesh));
            if farthest.is_none_or(|f| (off, node) > f) {
                farthest = Some((off, node));
            }
            if shortest.is_none_or(|s| (d + rest, node) < s) {
                shortest = Some((d + rest, node));
            }
        }
        let through = |(_, node): (f64, u32)| {
            let mut path = straighten(mesh, &there.path_to(mesh, node));
            let mut rest = back.path_to(mesh, node);
            rest.reverse();
            path.extend(straighten(mesh, &rest).into_iter().skip(1));
            path
        };
        let good = |path: &Vec<Located>| path_length(mesh, path) <= slack * length;
        [farthest, shortest].into_iter().flatten().map(through).find(good)
    }

    /// Reaches all nodes on paths up to `slack` times as long as the shortest one. Also returns the
    /// last node of the shortest path before `to`, and its length.
    fn towards(&mut self, from: Located, to: Located, slack: f64) -> Option<(Reached, u32, f64)> {
        let mesh = self.mesh;
        let goal = to.position(mesh);
        let rest: HashMap<u32, f64> = nodes_around(mesh, to).collect();
        let mut best: Option<(f64, u32)> = None;
        let goes_on = |node: u32, d: f64, bound: f64| {
            let better = |e: f64, (length, last): (f64, u32)| {
                let equal = (e - length).abs() <= EQUAL * length;
                if equal { position(mesh, node) < position(mesh, last) } else { e < length }
            };
            if let Some(rest) = rest.get(&node)
                && best.is_none_or(|b| better(d + rest, b))
            {
                best = Some((d + rest, node));
            }
            best.is_none_or(|b| bound <= slack * b.0)
        };
        let reached = self.search(from, |p| distance(p, goal), goes_on);
        best.map(|(length, last)| (reached, last, length))
    }

    /// Settles nodes by increasing distance from the start plus `rest`, a lower bound on the
    /// remaining distance, while `goes_on` accepts the node, its distance and that sum.
    fn search(
        &mut self,
        from: Located,
        rest: impl Fn(Vec3) -> f64,
        mut goes_on: impl FnMut(u32, f64, f64) -> bool,
    ) -> Reached {
        let mesh = self.mesh;
        // Lengths are nonnegative, so their bits sort like the numbers. Ties go to the lower node.
        let key = |d: f64, node: u32, p: Vec3| Reverse(((d + rest(p)).to_bits(), node));
        let mut reached = Reached { from, nodes: HashMap::new() };
        let mut queue = BinaryHeap::new();
        for (node, d) in nodes_around(mesh, from) {
            if d < reached.length_to(node) {
                reached.nodes.insert(node, (d, NONE));
                queue.push(key(d, node, position(mesh, node)));
            }
        }
        let mut neighbours = Vec::new();
        while let Some(Reverse((bits, node))) = queue.pop() {
            let (p, d) = (position(mesh, node), reached.length_to(node));
            if Reverse((bits, node)) != key(d, node, p) {
                continue; // already reached by a shorter path
            }
            self.settled += 1;
            if !goes_on(node, d, f64::from_bits(bits)) {
                break;
            }
            neighbours.clear();
            push_neighbours(mesh, node, &mut neighbours);
            for &next in &neighbours {
                let q = position(mesh, next);
                let e = d + distance(p, q);
                let (known, before) = reached.nodes.get(&next).copied().unwrap_or((f64::INFINITY, NONE));
                if e < known * (1.0 - EQUAL) {
                    reached.nodes.insert(next, (e, node));
                    queue.push(key(e, next, q));
                } else if e <= known * (1.0 + EQUAL)
                    && d < known
                    && before != NONE
                    && p < position(mesh, before)
                {
                    reached.nodes.insert(next, (known, node));
                }
            }
        }
        reached
    }
}

/// The nodes that one search has reached, each with its distance and its predecessor ([`NONE`] at
/// the start).
struct Reached {
    from: Located,
    nodes: HashMap<u32, (f64, u32)>,
}

const NONE: u32 = u32::MAX;

impl Reached {
    fn length_to(&self, node: u32) -> f64 {
        self.nodes.get(&node).map_or(f64::INFINITY, |r| r.0)
    }

    fn path_to(&self, mesh: &TriangleMesh, node: u32) -> Vec<Located> {
        let mut path = Vec::new();
        let mut node = node;
        while node != NONE {
            path.push(place(mesh, node));
            node = self.nodes.get(&node).map_or(NONE, |r| r.1);
        }
        path.push(self.from);
        path.reverse();
        path.dedup();
        path
    }
}

/// Returns the node of a path nearest to half its length.
fn middle_of(mesh: &TriangleMesh, path: &[Located]) -> Option<Located> {
    let half = 0.5 * path_length(mesh, path);
    let mut gone = 0.0;
    let mut nearest = (half, *path.first()?);
    for pair in path.windows(2) {
        gone += path_length(mesh, pair);
        let off = (gone - half).abs();
        if off < nearest.0 {
            nearest = (off, pair[1]);
        }
    }
    Some(nearest.1)
}

/// Nodes are numbered vertices first, then edge midpoints.
fn place(mesh: &TriangleMesh, node: u32) -> Located {
    match node.checked_sub(mesh.vertex_count() as u32) {
        None => Located::Vertex(Vertex(node)),
        Some(edge) => Located::Edge(Edge(edge), 0.5),
    }
}

fn midpoint(mesh: &TriangleMesh, edge: Edge) -> u32 {
    mesh.vertex_count() as u32 + edge.0
}

fn position(mesh: &TriangleMesh, node: u32) -> Vec3 {
    place(mesh, node).position(mesh)
}

/// Returns the nodes of the faces around a place, with their distances from it.
fn nodes_around(mesh: &TriangleMesh, place: Located) -> impl Iterator<Item = (u32, f64)> {
    let nodes = |f: Face| {
        let (vertices, edges) = (mesh.face_vertices(f), mesh.face_edges(f));
        vertices.map(|v| v.0).into_iter().chain(edges.map(|e| midpoint(mesh, e)))
    };
    let p = place.position(mesh);
    place.faces(mesh).into_iter().flat_map(nodes).map(move |n| (n, distance(p, position(mesh, n))))
}

/// Appends the nodes of adjacent faces to which a shortest path may lead directly.
fn push_neighbours(mesh: &TriangleMesh, node: u32, neighbours: &mut Vec<u32>) {
    match place(mesh, node) {
        Located::Edge(e, _) => {
            for h in mesh.edge_halfedges(e) {
                let (next, previous) = (h.next(), h.previous());
                let sides = [next, previous].map(|h| midpoint(mesh, mesh.edge(h)));
                neighbours.extend([mesh.origin(previous).0, sides[0], sides[1]]);
            }
        }
        // Passing the midpoint of an incident edge is never shorter than going directly.
        _ => {
            for c in mesh.vertex_corners(Vertex(node)) {
                let h = c.halfedge();
                let opposite = midpoint(mesh, mesh.edge(h.next()));
                neighbours.extend([mesh.tip(h).0, mesh.origin(h.previous()).0, opposite]);
            }
        }
    }
}
