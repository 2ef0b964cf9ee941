//! Which parts of the curve bound, and the loops that complete them (section 3.5).

use crate::winding::chain::Step;
use eikona_mesh::{Edge, TriangleMesh, Vertex};
use std::collections::BTreeMap;

/// Jumps of the nonbounding part below this are taken for none.
pub(crate) const THRESHOLD: f64 = 0.1;

/// For every step of the input whether it belongs to the nonbounding part: as many steps of an edge, in the direction of the
/// nonbounding jump, as that jump has copies.
pub(crate) fn nonbounding_steps(steps: &[Step], nonbounding: &[f64]) -> Vec<bool> {
    let mut left: BTreeMap<Edge, f64> = BTreeMap::new();
    steps
        .iter()
        .map(|step| {
            let t = nonbounding[step.edge.index()];
            if t.abs() <= THRESHOLD || (t > 0.0) != (step.jump > 0) || step.jump == 0 {
                return false;
            }
            let copies = left.entry(step.edge).or_insert_with(|| t.abs().round().max(1.0));
            *copies -= 1.0;
            *copies >= 0.0
        })
        .collect()
}

/// Edges with a jump, as polylines of vertices that have the higher value on their left (seen from the first face of each edge): every edge as often as
/// its jump has copies. Closed where the jumps are; a closed polyline begins and ends with the same vertex.
pub(crate) fn polylines(mesh: &TriangleMesh, jump: impl Fn(Edge) -> f64) -> Vec<Vec<Vertex>> {
    // Directed edges by their tails.
    let mut leaving: BTreeMap<Vertex, Vec<Vertex>> = BTreeMap::new();
    let mut surplus: BTreeMap<Vertex, i64> = BTreeMap::new();
    for e in mesh.edges() {
        let value = jump(e);
        let (Some(&first), true) = (mesh.edge_halfedges(e).first(), value.abs() > THRESHOLD) else {
            continue;
        };
        let (mut from, mut to) = (mesh.origin(first), mesh.tip(first));
        if value < 0.0 {
            (from, to) = (to, from);
        }
        for _ in 0..(value.abs().round().max(1.0) as usize) {
            leaving.entry(from).or_default().push(to);
            *surplus.entry(from).or_default() += 1;
            *surplus.entry(to).or_default() -= 1;
        }
    }
    // Open ones first, from where more leave than arrive.
    let starts: Vec<Vertex> =
        surplus.iter().filter(|(_, s)| **s > 0).flat_map(|(&v, &s)| (0..s).map(move |_| v)).collect();
    let mut result = Vec::new();
    for start in starts {
        result.extend(walk(&mut leaving, start));
    }
    let tails: Vec<Vertex> = leaving.keys().copied().collect();
    for start in tails {
        while leaving.get(&start).is_some_and(|to| !to.is_empty()) {
            result.extend(walk(&mut leaving, start));
        }
    }
    result
}

/// Walks until no edge leaves, and cuts off every loop that closes on the way.
fn walk(leaving: &mut BTreeMap<Vertex, Vec<Vertex>>, start: Vertex) -> Vec<Vec<Vertex>> {
    let mut result = Vec::new();
    let mut path = vec![start];
    let mut place: BTreeMap<Vertex, usize> = BTreeMap::from([(start, 0)]);
    while let Some(next) = path.last().and_then(|v| leaving.get_mut(v)).and_then(Vec::pop) {
        match place.get(&next) {
            Some(&first) => {
                let mut cycle = path.split_off(first + 1);
                cycle.iter().for_each(|v| {
                    place.remove(v);
                });
                cycle.insert(0, next);
                cycle.push(next);
                result.push(cycle);
            }
            None => {
                place.insert(next, path.len());
                path.push(next);
            }
        }
    }
    if path.len() > 1 {
        result.push(path);
    }
    result
}
