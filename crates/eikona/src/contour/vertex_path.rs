//! Shortest paths along edges.

use super::ContourError;
use crate::geometry::vector::distance;
use eikona_mesh::{TriangleMesh, Vertex};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// The shortest path along edges through all these vertices in order, both ends included. A vertex that is given twice in a
/// row counts once.
///
/// # Errors
/// [`ContourError::VertexOutOfRange`]; [`ContourError::NotConnected`] with the places in `through` of two vertices that no
/// edges join.
///
/// # Cost
/// One search (Dijkstra) a pair, each over the vertices that are nearer than the goal.
pub fn shortest_vertex_path(mesh: &TriangleMesh, through: &[Vertex]) -> Result<Vec<Vertex>, ContourError> {
    if let Some(&vertex) = through.iter().find(|v| v.index() >= mesh.vertex_count()) {
        return Err(ContourError::VertexOutOfRange { vertex, vertices: mesh.vertex_count() });
    }
    let mut path: Vec<Vertex> = through.first().copied().into_iter().collect();
    for (i, pair) in through.windows(2).enumerate() {
        let leg = path_between(mesh, &[(pair[0], 0.0)], &[(pair[1], 0.0)])
            .ok_or(ContourError::NotConnected { from: i, to: i + 1 })?;
        path.extend(leg.into_iter().skip(1));
    }
    Ok(path)
}

/// The shortest path along edges from one of these starts to one of these goals, each with the length already gone there.
pub(super) fn path_between(
    mesh: &TriangleMesh,
    starts: &[(Vertex, f64)],
    goals: &[(Vertex, f64)],
) -> Option<Vec<Vertex>> {
    // Lengths are not negative, so their bits order as they do. Ties go to the lower vertex.
    let key = |d: f64, v: Vertex| Reverse((d.to_bits(), v));
    let mut reached: BTreeMap<Vertex, (f64, Option<Vertex>)> = BTreeMap::new();
    let mut queue = BinaryHeap::new();
    for &(v, d) in starts {
        if reached.get(&v).is_none_or(|r| d < r.0) {
            reached.insert(v, (d, None));
            queue.push(key(d, v));
        }
    }
    let mut best: Option<(f64, Vertex)> = None;
    while let Some(Reverse((bits, v))) = queue.pop() {
        let d = f64::from_bits(bits);
        if best.is_some_and(|b| d >= b.0) {
            break;
        }
        if reached.get(&v).is_some_and(|r| r.0 < d) {
            continue;
        }
        for &(goal, rest) in goals {
            if goal == v && best.is_none_or(|b| d + rest < b.0) {
                best = Some((d + rest, v));
            }
        }
        for &corner in mesh.vertex_corners(v) {
            let h = corner.halfedge();
            for w in [mesh.tip(h), mesh.origin(h.previous())] {
                let e = d + distance(mesh.position(v), mesh.position(w));
                if reached.get(&w).is_none_or(|r| e < r.0) {
                    reached.insert(w, (e, Some(v)));
                    queue.push(key(e, w));
                }
            }
        }
    }
    let (_, mut v) = best?;
    let mut path = vec![v];
    while let Some((_, Some(previous))) = reached.get(&v).copied() {
        path.push(previous);
        v = previous;
    }
    path.reverse();
    Some(path)
}
