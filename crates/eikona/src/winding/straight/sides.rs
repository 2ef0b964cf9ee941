//! Transports the sides of a path around vertices, independently of the orientation of faces.

use eikona_mesh::{Edge, Halfedge, Neighbour, TriangleMesh, Vertex};

/// Returns the halfedge of the other face at an edge of two faces.
pub(super) fn other_side(mesh: &TriangleMesh, h: Halfedge) -> Option<Halfedge> {
    match mesh.neighbour(h) {
        Neighbour::Twin(other) => Some(other),
        _ => None,
    }
}

/// Turns about a vertex, away from the edge of `from` through its face, up to the edge `to`, and
/// returns the halfedge of the face that reaches it. `None` if the faces end first, or an edge is
/// not `passable`.
pub(super) fn swept(
    mesh: &TriangleMesh,
    v: Vertex,
    from: Halfedge,
    to: Edge,
    passable: impl Fn(Edge) -> bool,
) -> Option<Halfedge> {
    let mut side = from;
    for _ in 0..mesh.vertex_corners(v).len() {
        side = if mesh.tip(side) == v { side.next() } else { side.previous() };
        let edge = mesh.edge(side);
        if edge == to {
            return Some(side);
        }
        if !passable(edge) {
            return None;
        }
        side = other_side(mesh, side)?;
    }
    None
}

/// Transports the side `high` of a path that arrives at a vertex to the edge by which it leaves.
pub(super) fn transported(mesh: &TriangleMesh, v: Vertex, high: Halfedge, to: Edge) -> Option<Halfedge> {
    let through_low =
        || swept(mesh, v, other_side(mesh, high)?, to, |_| true).and_then(|low| other_side(mesh, low));
    swept(mesh, v, high, to, |_| true).or_else(through_low)
}

/// Transports the side `high` of a path that leaves a vertex to another edge by which it leaves
/// instead.
pub(super) fn redirected(mesh: &TriangleMesh, v: Vertex, high: Halfedge, to: Edge) -> Option<Halfedge> {
    if mesh.edge(high) == to {
        return Some(high);
    }
    let through_high = swept(mesh, v, high, to, |_| true).and_then(|low| other_side(mesh, low));
    through_high.or_else(|| swept(mesh, v, other_side(mesh, high)?, to, |_| true))
}
