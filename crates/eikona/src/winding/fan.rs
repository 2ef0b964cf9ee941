//! The faces around a vertex, in order.

use eikona_mesh::{Edge, Face, Neighbour, TriangleMesh, Vertex};

/// What one crosses in a walk around a vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    pub edge: Edge,
    /// From the face of the edge's first halfedge into that of its second.
    pub forward: bool,
}

impl Crossing {
    /// By how much a function with these jumps changes when this is crossed.
    #[inline]
    pub fn change<T: Copy + std::ops::Neg<Output = T>>(self, jump: &[T]) -> T {
        let jump = jump[self.edge.index()];
        if self.forward { -jump } else { jump }
    }
}

/// The corners around a vertex, one after the other, with what is crossed before each.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fan {
    /// Indices of corners (3 f + k).
    pub corners: Vec<usize>,
    /// `crossings[i]` lies between corner `i` and the next; in a closed fan the last one leads back
    /// to the first.
    pub crossings: Vec<Crossing>,
    pub closed: bool,
}

impl Fan {
    /// Walks around a vertex, from one boundary edge to the other if there are such. `false` if its
    /// faces are more than one fan, or meet at an edge of three faces, or if it has no faces.
    pub fn walk(&mut self, mesh: &TriangleMesh, v: Vertex) -> bool {
        self.corners.clear();
        self.crossings.clear();
        self.closed = false;
        let corners = mesh.vertex_corners(v);
        // The halfedges of a corner's face that meet there: (from the corner, to the corner).
        let sides = |corner: usize| {
            let (face, k) = (Face((corner / 3) as u32), corner % 3);
            (face.halfedge(k), face.halfedge((k + 2) % 3))
        };
        let at_rim = corners.iter().map(|c| c.index()).find_map(|c| {
            let (out, back) = sides(c);
            let is_rim = |h| matches!(mesh.neighbour(h), Neighbour::Boundary);
            // Leave by the other side.
            if is_rim(out) { Some((c, back)) } else { is_rim(back).then_some((c, out)) }
        });
        let Some((start, mut exit)) = at_rim.or(corners.first().map(|c| (c.index(), sides(c.index()).1)))
        else {
            return false;
        };
        let mut corner = start;
        loop {
            self.corners.push(corner);
            match mesh.neighbour(exit) {
                Neighbour::Boundary => break,
                Neighbour::Nonmanifold(_) => return false,
                Neighbour::Twin(other) => {
                    let edge = mesh.edge(exit);
                    self.crossings.push(Crossing { edge, forward: mesh.edge_halfedges(edge)[0] == exit });
                    let (face, k) = (other.face(), other.index() % 3);
                    if mesh.origin(other) == v {
                        corner = 3 * face.index() + k;
                        exit = sides(corner).1;
                    } else {
                        corner = 3 * face.index() + (k + 1) % 3;
                        exit = sides(corner).0;
                    }
                    if corner == start {
                        self.closed = true;
                        break;
                    }
                    if self.corners.len() >= corners.len() {
                        return false;
                    }
                }
            }
        }
        self.corners.len() == corners.len()
    }
}
