//! Shortest paths along edges.

use super::TraceError;
use crate::geometry::vector::distance;
use eikona_mesh::{TriangleMesh, Vertex};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

/// Computes the shortest path along edges through all given vertices in order, both ends included.
/// Repeated consecutive vertices count once.
///
/// # Errors
/// [`TraceError::VertexOutOfRange`]; [`TraceError::NotConnected`], with indices into `through`, for
/// two vertices that no path along edges connects.
///
/// # Cost
/// One Dijkstra search per pair, over the vertices that are nearer than the goal.
pub fn shortest_vertex_path(mesh: &TriangleMesh, through: &[Vertex]) -> Result<Vec<Vertex>, TraceError> {
    if let Some(&vertex) = through.iter().find(|v| v.index() >= mesh.vertex_count()) {
        return Err(TraceError::VertexOutOfRange { vertex, vertices: mesh.vertex_count() });
    }
    let mut path: Vec<Vertex> = through.first().copied().into_iter().collect();
    for (i, pair) in through.windows(2).enumerate() {
        let leg =
            path_between(mesh, pair[0], pair[1]).ok_or(TraceError::NotConnected { from: i, to: i + 1 })?;
        path.extend(leg.into_iter().skip(1));
    }
    Ok(path)
}

fn path_between(mesh: &TriangleMesh, start: Vertex, goal: Vertex) -> Option<Vec<Vertex>> {
    // Lengths are nonnegative, so their bits sort like the numbers. Ties go to the lower vertex.
    let key = |d: f64, v: Vertex| Reverse((d.to_bits(), v));
    let mut reached: BTreeMap<Vertex, (f64, Option<Vertex>)> = BTreeMap::from([(start, (0.0, None))]);
    let mut queue = BinaryHeap::from([key(0.0, start)]);
    while let Some(Reverse((bits, v))) = queue.pop() {
        if v == goal {
            break;
        }
        let d = f64::from_bits(bits);
        if reached.get(&v).is_some_and(|r| r.0 < d) {
            continue;
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
    reached.get(&goal)?;
    let mut path = vec![goal];
    while let Some((_, Some(previous))) = reached.get(path.last()?).copied() {
        path.push(previous);
    }
    path.reverse();
    Some(path)
}
