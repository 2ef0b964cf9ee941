//! Vertex fans: the faces around a vertex, in the order in which they share edges.

use crate::id::{Corner, Edge, Halfedge, Vertex};
use crate::mesh::{Neighbour, TriangleMesh};
use crate::union_find::UnionFind;

/// A maximal chain of faces around a vertex, each sharing an edge at the vertex with the next.
///
/// Only edges with exactly two faces are crossed. A fan ends at the boundary and at nonmanifold
/// edges; a closed fan is a cycle. Faces need not be consistently oriented.
///
/// ```
/// use eikona_mesh::{Vertex, VertexFan, shapes};
/// let disk = shapes::disk(1, 6, 1.0)?;
/// let [centre] = &VertexFan::all(&disk, Vertex(0))[..] else { panic!("one fan") };
/// assert!(centre.is_closed());
/// assert_eq!((centre.corners.len(), centre.crossings.len()), (6, 6));
/// let [rim] = &VertexFan::all(&disk, Vertex(1))[..] else { panic!("one fan") };
/// assert_eq!((rim.corners.len(), rim.crossings.len()), (2, 1));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VertexFan {
    /// The corners at the vertex, in order. The chain starts at a boundary edge if the fan has one.
    pub corners: Vec<Corner>,
    /// For each corner: whether its face has the orientation of the first corner's face.
    pub agrees: Vec<bool>,
    /// The edges between consecutive corners; in a closed fan, the last one leads back to the first
    /// corner.
    pub crossings: Vec<Crossing>,
    /// Whether an end of the fan is a nonmanifold edge.
    pub ends_at_nonmanifold_edge: bool,
}

/// An edge crossed on the way around a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing {
    /// The edge.
    pub edge: Edge,
    /// Whether the way leads from the face of the edge's first halfedge to that of its second.
    pub forward: bool,
}

impl Crossing {
    /// Returns the change, across the edge, of a function with these jumps per edge (the value in
    /// the face of the first halfedge minus that in the face of the second).
    #[inline]
    pub fn change<T: Copy + std::ops::Neg<Output = T>>(self, jump: &[T]) -> T {
        let jump = jump[self.edge.index()];
        if self.forward { -jump } else { jump }
    }
}

impl VertexFan {
    /// Returns the fans of a vertex, in the order of their lowest corners. None for a vertex
    /// without faces.
    ///
    /// # Cost
    /// O(d log d) for degree d.
    pub fn all(mesh: &TriangleMesh, v: Vertex) -> Vec<VertexFan> {
        let mut left: Vec<Corner> = mesh.vertex_corners(v).to_vec();
        left.sort_unstable();
        let mut fans: Vec<VertexFan> = Vec::new();
        let mut seen = vec![false; left.len()];
        for i in 0..left.len() {
            if seen[i] {
                continue;
            }
            let fan = VertexFan::through(mesh, left[i]);
            for corner in &fan.corners {
                if let Ok(place) = left.binary_search(corner) {
                    seen[place] = true;
                }
            }
            fans.push(fan);
        }
        fans
    }

    /// Returns the fan of a corner. It starts at that corner if it is closed, else at a boundary
    /// edge (of two, the one whose corner comes first), else at a nonmanifold edge.
    ///
    /// # Cost
    /// O(d) for a fan of d faces.
    pub fn through(mesh: &TriangleMesh, corner: Corner) -> VertexFan {
        let ahead = Turn::from(mesh, corner, corner.halfedge().previous());
        if ahead.stop == Stop::Round {
            return ahead.fan(false);
        }
        let behind = Turn::from(mesh, corner, corner.halfedge());
        // The rank of an end: boundary before nonmanifold, then the lower corner.
        let rank = |turn: &Turn| (turn.stop, turn.corners.last().copied());
        let nonmanifold = [&ahead, &behind].iter().any(|turn| turn.stop == Stop::Nonmanifold);
        let (start, exit) = if rank(&behind) <= rank(&ahead) { behind.end() } else { ahead.end() };
        Turn::from(mesh, start, exit).fan(nonmanifold)
    }

    /// Whether the fan is a cycle.
    pub fn is_closed(&self) -> bool {
        self.crossings.len() == self.corners.len()
    }
}

/// How a turn around a vertex ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Stop {
    /// At the corner where it began.
    Round,
    Boundary,
    Nonmanifold,
}

/// A walk around a vertex in one direction.
struct Turn {
    corners: Vec<Corner>,
    agrees: Vec<bool>,
    crossings: Vec<Crossing>,
    stop: Stop,
    /// The last side, where it stopped.
    last: Halfedge,
}

impl Turn {
    /// Starts at a corner and leaves its face by a side at the corner.
    fn from(mesh: &TriangleMesh, start: Corner, mut exit: Halfedge) -> Turn {
        let (mut corner, mut agrees) = (start, true);
        let mut turn = Turn {
            corners: Vec::new(),
            agrees: Vec::new(),
            crossings: Vec::new(),
            stop: Stop::Boundary,
            last: exit,
        };
        loop {
            turn.corners.push(corner);
            turn.agrees.push(agrees);
            turn.last = exit;
            let Some((crossing, next, next_exit)) = step_around(mesh, corner, exit) else {
                let ends = mesh.is_boundary_edge(mesh.edge(exit));
                turn.stop = if ends { Stop::Boundary } else { Stop::Nonmanifold };
                return turn;
            };
            turn.crossings.push(crossing);
            // A consistently oriented neighbour is left on the same kind of side.
            agrees ^= leaves_by_origin(corner, exit) != leaves_by_origin(next, next_exit);
            (corner, exit) = (next, next_exit);
            if corner == start {
                turn.stop = Stop::Round;
                return turn;
            }
        }
    }

    /// The last corner, and the side that leads back.
    fn end(&self) -> (Corner, Halfedge) {
        let corner = self.corners[self.corners.len() - 1];
        (corner, other_side(corner, self.last))
    }

    fn fan(self, ends_at_nonmanifold_edge: bool) -> VertexFan {
        let Turn { corners, agrees, crossings, .. } = self;
        VertexFan { corners, agrees, crossings, ends_at_nonmanifold_edge }
    }
}

/// Crosses one of the two sides at a corner. Returns the edge, the corner of the neighbour at the
/// same vertex, and the neighbour's other side at it; `None` unless the edge has two faces.
fn step_around(mesh: &TriangleMesh, corner: Corner, exit: Halfedge) -> Option<(Crossing, Corner, Halfedge)> {
    let Neighbour::Twin(twin) = mesh.neighbour(exit) else { return None };
    let edge = mesh.edge(exit);
    let crossing = Crossing { edge, forward: mesh.edge_halfedges(edge)[0] == exit };
    let next =
        if mesh.origin(twin) == mesh.corner_vertex(corner) { twin.corner() } else { twin.next().corner() };
    Some((crossing, next, other_side(next, twin)))
}

/// Of the two sides at a corner, the one that is not given.
fn other_side(corner: Corner, side: Halfedge) -> Halfedge {
    if leaves_by_origin(corner, side) { side.previous() } else { side.next() }
}

/// Whether the vertex of the corner is the origin of the side, not its tip.
fn leaves_by_origin(corner: Corner, side: Halfedge) -> bool {
    side.corner() == corner
}

/// Returns the boundary halfedge at the other end of the fan of a boundary halfedge, around one of
/// its ends. `None` if the fan ends at a nonmanifold edge.
pub(crate) fn far_boundary(mesh: &TriangleMesh, h: Halfedge, v: Vertex) -> Option<Halfedge> {
    let mut corner = if mesh.origin(h) == v { h.corner() } else { h.next().corner() };
    let mut exit = other_side(corner, h);
    while let Some((_, next, next_exit)) = step_around(mesh, corner, exit) {
        (corner, exit) = (next, next_exit);
    }
    mesh.is_boundary_edge(mesh.edge(exit)).then_some(exit)
}

/// Sets of corners that are joined across edges at their vertex, nonmanifold edges included: one
/// set per umbrella of a vertex. Faces of fans that meet at a nonmanifold edge are in one set.
pub(crate) fn umbrellas(mesh: &TriangleMesh) -> UnionFind {
    let corner_at = |h: Halfedge, v: Vertex| {
        if mesh.origin(h) == v { h.corner() } else { h.next().corner() }
    };
    let mut sets = UnionFind::new(mesh.halfedge_count());
    for e in mesh.edges() {
        for v in mesh.edge_vertices(e) {
            for pair in mesh.edge_halfedges(e).windows(2) {
                sets.join(corner_at(pair[0], v).0, corner_at(pair[1], v).0);
            }
        }
    }
    sets
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{damage, shapes};

    /// Three triangles on one edge, and one that touches them at its end only.
    fn fin() -> TriangleMesh {
        let positions = vec![
            [0., 0., 0.],
            [1., 0., 0.],
            [0., 1., 0.],
            [0., -1., 0.],
            [0., 0., 1.],
            [-1., 0., 0.],
            [-1., 1., 0.],
        ];
        TriangleMesh::new(positions, vec![[0, 1, 2], [1, 0, 3], [0, 1, 4], [0, 5, 6]]).unwrap()
    }

    #[test]
    fn fans_end_at_nonmanifold_edges() {
        let fans = VertexFan::all(&fin(), Vertex(0));
        assert_eq!(fans.len(), 4);
        assert_eq!(fans.iter().filter(|fan| fan.ends_at_nonmanifold_edge).count(), 3);
        assert!(fans.iter().all(|fan| fan.corners.len() == 1 && fan.crossings.is_empty()));
        let mut umbrellas = umbrellas(&fin());
        let corners = fin().vertex_corners(Vertex(0)).to_vec();
        let one =
            |i: usize, j: usize, sets: &mut UnionFind| sets.find(corners[i].0) == sets.find(corners[j].0);
        assert!(one(0, 2, &mut umbrellas) && !one(0, 3, &mut umbrellas));
    }

    #[test]
    fn every_corner_is_in_one_fan_and_neighbours_share_the_crossed_edge() {
        let torus = shapes::torus(1.0, 0.4, 12, 8).unwrap();
        let torn = damage::remove_faces(&torus, 0.3, 4).unwrap().mesh;
        let mixed = damage::flip_faces(&torn, 0.4, 5).unwrap().mesh;
        for v in mixed.vertices() {
            let fans = VertexFan::all(&mixed, v);
            let mut corners: Vec<Corner> = fans.iter().flat_map(|fan| fan.corners.clone()).collect();
            corners.sort_unstable();
            assert_eq!(corners, mixed.vertex_corners(v));
            for fan in &fans {
                let pairs = fan.corners.iter().zip(fan.corners.iter().cycle().skip(1));
                for ((a, b), crossing) in pairs.zip(&fan.crossings) {
                    let faces: Vec<_> =
                        mixed.edge_halfedges(crossing.edge).iter().map(|h| h.face()).collect();
                    let [from, to] = if crossing.forward { [0, 1] } else { [1, 0] };
                    assert_eq!([faces[from], faces[to]], [a.face(), b.face()]);
                }
                let open = mixed.is_boundary_vertex(v);
                assert!(open || fan.is_closed());
            }
        }
        // Which faces agree is what flipping did.
        let flipped: Vec<bool> =
            torn.triangles().iter().zip(mixed.triangles()).map(|(a, b)| a != b).collect();
        for v in mixed.vertices() {
            for fan in VertexFan::all(&mixed, v) {
                let turned = |i: usize| flipped[fan.corners[i].face().index()];
                assert!((0..fan.corners.len()).all(|i| fan.agrees[i] == (turned(i) == turned(0))));
            }
        }
    }
}
