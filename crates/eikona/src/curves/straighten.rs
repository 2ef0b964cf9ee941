//! Shortens a path across faces until it is locally shortest.
//!
//! The path is stored as corners and legs; a leg is a strip of faces that the path crosses in a
//! straight line from corner to corner. At a vertex, the faces on either side of the path join its
//! two legs to one strip. If they span less than pi there, the shortest path through the joined
//! strip ([`super::funnel`]) is shorter than the two legs and replaces them. This is repeated,
//! every second corner at a time so that strips grow by doubling, until no corner can be improved.

use super::TraceError;
use super::funnel::shortest_in_strip;
use crate::geometry::vector::{angle, distance, sub};
use eikona_mesh::{Curve, Edge, Face, Located, Neighbour, SegmentHost, TriangleMesh, Vertex, segment_host};
use std::f64::consts::PI;

/// Largest number of passes over the path. Every pass shortens it. A shortest edge path needs 5 to
/// 20; a long detour pulled over the surface passes about one vertex per pass.
const PASSES: usize = 10_000;

/// Sides that span less than pi by more than this can be shortened; below it is rounding.
const ANGLE_SLACK: f64 = 1e-9;

/// A part of the path that runs straight through a strip of faces.
#[derive(Clone, Debug)]
pub(super) struct Leg {
    /// The faces in order, and the edges between them.
    pub faces: Vec<Face>,
    pub gates: Vec<Edge>,
    /// Where the path crosses the gates.
    pub nodes: Vec<Located>,
    pub length: f64,
}

/// Straightens a curve to a locally shortest one with the same ends (a closed curve stays fixed at
/// its first node).
///
/// Each segment must lie in one face, as after tracing or for a path along edges. The same holds
/// for the result. It is never longer than the input; where it bends at a vertex, no side spans
/// less than pi, so that small moves do not shorten it. It passes boundary vertices and nonmanifold
/// edges only where the input does.
///
/// ```
/// use eikona::contour::polylines;
/// use eikona::curves::{shortest_vertex_path, straighten_curve};
/// use eikona_mesh::{Curve, TriangleMesh, Vertex};
/// let corners = vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
/// let mesh = TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]])?;
/// // Around a corner of the square.
/// let path = Curve::signed(shortest_vertex_path(&mesh, &[Vertex(1), Vertex(3)])?);
/// let straight = straighten_curve(&mesh, &path)?;
/// assert_eq!(polylines(&mesh, [&straight])?, [[[1., 0., 0.], [0.5, 0.5, 0.], [0., 1., 0.]]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`TraceError::Curve`] for a node that is not on the mesh or a segment that does not lie in a
/// single face (trace the curve first), and [`TraceError::TooFewPoints`].
///
/// # Cost
/// About O(n log n) in the number of faces along a path that is nearly shortest; a detour costs one
/// pass over the path per vertex that it is pulled past, at most 10,000 passes.
pub fn straighten_curve(mesh: &TriangleMesh, curve: &Curve) -> Result<Curve, TraceError> {
    if curve.nodes.len() < 2 {
        return Err(TraceError::TooFewPoints { points: curve.nodes.len() });
    }
    let located = curve.nodes.iter().enumerate();
    let path: Vec<Located> =
        located.map(|(n, p)| p.locate(mesh).map_err(|e| e.at(0, n))).collect::<Result<_, _>>()?;
    for (n, pair) in path.windows(2).enumerate() {
        if pair[0] != pair[1] && segment_host(mesh, pair[0], pair[1]).is_none() {
            return Err(eikona_mesh::CurveError::SegmentAcrossFaces.at(0, n).into());
        }
    }
    let mut nodes: Vec<_> = straighten(mesh, &path).iter().map(|p| p.to_surface_point(mesh)).collect();
    // A contractible closed curve shrinks to its first node.
    if let [node] = *nodes.as_slice() {
        nodes.push(node);
    }
    Ok(Curve { nodes, ..curve.clone() })
}

/// [`straighten_curve`] for located places. Returns a path unchanged if a segment does not lie in a
/// single face.
pub(super) fn straighten(mesh: &TriangleMesh, path: &[Located]) -> Vec<Located> {
    straighten_around(mesh, path, &|_| false)
}

/// Returns the shortest path in the homotopy class relative to some fixed vertices: a path that
/// meets one of them stays on it.
pub(crate) fn straighten_around(
    mesh: &TriangleMesh,
    path: &[Located],
    is_fixed: &dyn Fn(Vertex) -> bool,
) -> Vec<Located> {
    let Some((mut corners, mut legs)) = legs_of(mesh, path) else { return path.to_vec() };
    // Zero-area faces let corners wander between coinciding vertices; each pass must shorten the
    // whole path.
    let state = |corners: &[Located], legs: &[Leg]| {
        let loose = corners.iter().filter(|c| !matches!(c, Located::Vertex(_))).count();
        (legs.iter().map(|l| l.length).sum::<f64>(), loose)
    };
    let (mut length, mut loose) = state(&corners, &legs);
    for _ in 0..PASSES {
        if !pass(mesh, &mut corners, &mut legs, is_fixed) {
            break;
        }
        let (new_length, new_loose) = state(&corners, &legs);
        if new_length >= length * (1.0 - 1e-13) && new_loose >= loose {
            break;
        }
        (length, loose) = (new_length, new_loose);
    }
    let mut result: Vec<Located> = corners[..1].to_vec();
    for (leg, corner) in legs.iter().zip(&corners[1..]) {
        for &node in leg.nodes.iter().chain([corner]) {
            if result.last() != Some(&node) {
                result.push(node);
            }
        }
    }
    // Rounding can lengthen a path that was already straight.
    let whole = result.windows(2).all(|p| segment_host(mesh, p[0], p[1]).is_some());
    if whole && path_length(mesh, &result) <= path_length(mesh, path) { result } else { path.to_vec() }
}

/// Largest number of base moves of a closed path. Smooth surfaces take about 10.
const LOOP_ROUNDS: usize = 100;

/// Straightens a closed path (its last place is its first) everywhere: the base, which is fixed
/// while the rest is straightened, moves on to the opposite side until nothing is gained. A
/// contractible path ends as one place.
pub(crate) fn straighten_loop(
    mesh: &TriangleMesh,
    path: &[Located],
    is_fixed: &dyn Fn(Vertex) -> bool,
) -> Vec<Located> {
    let mut path = straighten_around(mesh, path, is_fixed);
    let mut length = path_length(mesh, &path);
    let mut idle = 0;
    for _ in 0..LOOP_ROUNDS {
        if path.len() < 3 || idle == 2 {
            break;
        }
        path.pop();
        let half = path.len() / 2;
        path.rotate_left(half);
        path.push(path[0]);
        path = straighten_around(mesh, &path, is_fixed);
        let new_length = path_length(mesh, &path);
        idle = if new_length < length * (1.0 - 1e-12) { 0 } else { idle + 1 };
        length = new_length;
    }
    path
}

pub(crate) fn path_length(mesh: &TriangleMesh, path: &[Located]) -> f64 {
    path.windows(2).map(|p| distance(p[0].position(mesh), p[1].position(mesh))).sum()
}

/// Returns one leg per segment; `None` without segments, or if one does not lie in a single face.
fn legs_of(mesh: &TriangleMesh, path: &[Located]) -> Option<(Vec<Located>, Vec<Leg>)> {
    let mut corners = vec![*path.first()?];
    let mut legs = Vec::new();
    for pair in path.windows(2).filter(|p| p[0] != p[1]) {
        let face = match segment_host(mesh, pair[0], pair[1])? {
            SegmentHost::Face(f, _) => f,
            SegmentHost::Edge(e, _) => mesh.edge_halfedges(e).first()?.face(),
        };
        let length = path_length(mesh, pair);
        legs.push(Leg { faces: vec![face], gates: Vec::new(), nodes: Vec::new(), length });
        corners.push(pair[1]);
    }
    (!legs.is_empty()).then_some((corners, legs))
}

/// Tries to improve each corner whose legs have not changed in this pass; returns whether any
/// improved.
fn pass(
    mesh: &TriangleMesh,
    corners: &mut Vec<Located>,
    legs: &mut Vec<Leg>,
    is_fixed: &dyn Fn(Vertex) -> bool,
) -> bool {
    let mut improved = false;
    let (mut new_corners, mut new_legs) = (vec![corners[0]], Vec::with_capacity(legs.len()));
    let mut i = 0;
    while i < legs.len() {
        let next = legs.get(i + 1).filter(|_| !matches!(corners[i + 1], Located::Vertex(v) if is_fixed(v)));
        let joined = next.and_then(|next| join(mesh, &corners[i..i + 3], &legs[i], next));
        match joined {
            Some((_, pieces)) if pieces.is_empty() => {
                improved = true;
                i += 2;
            }
            Some((between, pieces)) => {
                improved = true;
                new_corners.extend(between);
                new_legs.extend(pieces);
                new_corners.push(corners[i + 2]);
                i += 2;
            }
            None => {
                new_legs.push(legs[i].clone());
                new_corners.push(corners[i + 1]);
                i += 1;
            }
        }
    }
    (*corners, *legs) = (new_corners, new_legs);
    improved
}

/// Returns the shorter legs (and the corners between them) that replace two legs, if there are any;
/// no legs if the two lead back to their start and are contractible.
fn join(
    mesh: &TriangleMesh,
    corners: &[Located],
    first: &Leg,
    second: &Leg,
) -> Option<(Vec<Located>, Vec<Leg>)> {
    let [from, corner, to] = *corners else { return None };
    let before = first.length + second.length;
    let strips = match corner {
        Located::Vertex(v) => strips_around(mesh, v, (from, first), (to, second)),
        _ => strip_through(mesh, corner, first, second).into_iter().collect(),
    };
    let limit = match corner {
        Located::Vertex(_) => before * (1.0 - 1e-12),
        _ => before * (1.0 + 1e-12), // remove nodes inside edges and faces even without gain
    };
    let strips: Vec<Strip> = strips.into_iter().map(without_turning_back).collect();
    let at_from = |gate: &Edge| match from {
        Located::Vertex(v) => mesh.edge_vertices(*gate).contains(&v),
        Located::Edge(e, _) => *gate == e,
        Located::Face(..) => false,
    };
    if from == to && strips.iter().any(|(_, gates)| gates.iter().all(at_from)) {
        return Some((Vec::new(), Vec::new()));
    }
    strips
        .into_iter()
        .filter_map(|(faces, gates)| shortest_in_strip(mesh, from, to, &faces, &gates))
        .map(|(between, legs)| (legs.iter().map(|l| l.length).sum::<f64>(), between, legs))
        .filter(|(length, ..)| *length <= limit)
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, between, legs)| (between, legs))
}

type Strip = (Vec<Face>, Vec<Edge>);

/// Removes excursions through a gate and straight back, through which no path can be pulled.
fn without_turning_back((faces, gates): Strip) -> Strip {
    let mut strip: Strip = (faces.first().copied().into_iter().collect(), Vec::new());
    for (&gate, &face) in gates.iter().zip(faces.iter().skip(1)) {
        if strip.1.last() == Some(&gate) && strip.0.len() > 1 && strip.0[strip.0.len() - 2] == face {
            strip.0.pop();
            strip.1.pop();
        } else {
            strip.0.push(face);
            strip.1.push(gate);
        }
    }
    strip
}

/// Joins two legs at a node inside an edge or face.
fn strip_through(mesh: &TriangleMesh, corner: Located, first: &Leg, second: &Leg) -> Option<Strip> {
    let (mut faces, mut gates) = (first.faces.clone(), first.gates.clone());
    let (last, next) = (*faces.last()?, *second.faces.first()?);
    if last == next {
        faces.pop();
    } else {
        let Located::Edge(e, _) = corner else { return None };
        let at = |f: Face| mesh.edge_halfedges(e).iter().any(|h| h.face() == f);
        if !at(last) || !at(next) {
            return None;
        }
        gates.push(e);
    }
    faces.extend(&second.faces);
    gates.extend(&second.gates);
    Some((faces, gates))
}

/// Joins two legs by the faces on one side of a vertex, for each side that spans less than pi.
fn strips_around(
    mesh: &TriangleMesh,
    v: Vertex,
    (from, first): (Located, &Leg),
    (to, second): (Located, &Leg),
) -> Vec<Strip> {
    let (Some(&last), Some(&next)) = (first.faces.last(), second.faces.first()) else { return Vec::new() };
    let p = mesh.position(v);
    let incoming = sub(first.nodes.last().unwrap_or(&from).position(mesh), p);
    let outgoing = sub(second.nodes.first().unwrap_or(&to).position(mesh), p);
    let along = |w: Vertex| sub(mesh.position(w), p);
    let others = |f: Face| -> Vec<Vertex> { mesh.face_vertices(f).into_iter().filter(|&w| w != v).collect() };
    let assemble = |fan: Strip| {
        let mut strip: Strip = (first.faces.clone(), first.gates.clone());
        strip.0.extend(fan.0);
        strip.1.extend(fan.1);
        // The fan ends in the first face of the second leg.
        strip.0.extend(&second.faces[1..]);
        strip.1.extend(&second.gates);
        strip
    };
    let mut strips = Vec::new();
    if last == next && angle(incoming, outgoing) < PI - ANGLE_SLACK {
        strips.push(assemble((Vec::new(), Vec::new())));
    }
    for start in others(last) {
        let (mut fan, mut spoke, mut face) = ((Vec::new(), Vec::new()), start, last);
        let mut span = angle(incoming, along(start));
        while span < PI - ANGLE_SLACK {
            let side = (0..3).map(|k| face.halfedge(k)).find(|&h| {
                let ends = [mesh.origin(h), mesh.tip(h)];
                ends.contains(&v) && ends.contains(&spoke)
            });
            let Some(Neighbour::Twin(twin)) = side.map(|h| mesh.neighbour(h)) else { break };
            fan.1.push(mesh.edge(twin));
            face = twin.face();
            fan.0.push(face);
            if face == next {
                if span + angle(along(spoke), outgoing) < PI - ANGLE_SLACK {
                    strips.push(assemble(fan));
                }
                break;
            }
            if face == last {
                break;
            }
            let Some(far) = others(face).into_iter().find(|&w| w != spoke) else { break };
            span += angle(along(spoke), along(far));
            spoke = far;
        }
    }
    strips
}

#[cfg(test)]
mod tests {
    use super::*;
    use eikona_mesh::shapes;
    use std::f64::consts::TAU;

    #[test]
    fn a_loop_around_the_hole_shrinks_to_the_inner_equator() {
        let (nu, nv) = (60, 30);
        let torus = shapes::torus(1.0, 0.4, nu, nv).unwrap();
        // From row to row, up to four rows off the inner equator.
        let row = |i: usize| nv / 2 + [0, 1, 2, 3, 4, 3, 2, 1][i % 8];
        let vertex = |i: usize| Vertex(((i % nu) * nv + row(i % nu)) as u32);
        let along: Vec<Vertex> = (0..=nu).map(vertex).collect();
        let along = crate::curves::shortest_vertex_path(&torus, &along).unwrap();
        let path: Vec<Located> = along.into_iter().map(Located::Vertex).collect();
        let straight = straighten_loop(&torus, &path, &|_| false);
        let exact = nu as f64 * 2.0 * 0.6 * (0.5 * TAU / nu as f64).sin();
        assert!((path_length(&torus, &straight) / exact - 1.0).abs() < 1e-6);
        // A fixed vertex keeps it longer.
        let fixed = vertex(4);
        let held = path_length(&torus, &straighten_loop(&torus, &path, &|v| v == fixed));
        assert!(held > 1.001 * exact && held < path_length(&torus, &path), "{held}");
    }

    /// Lengths are infinite, and their products no numbers.
    #[test]
    fn paths_beside_a_vertex_beyond_the_range_of_numbers_end() {
        let grid = shapes::grid(6, 4, 1.0, 1.0, shapes::Diagonal::Uniform).unwrap();
        for far in grid.vertices() {
            let mut positions = grid.positions().to_vec();
            positions[far.index()][0] = -1e308;
            let moved = grid.with_positions(positions).unwrap();
            for [a, b] in [[0, 34], [6, 28], [14, 20], [3, 31]] {
                // The vertices are chosen on the grid itself.
                let along = crate::curves::shortest_vertex_path(&grid, &[a, b].map(Vertex)).unwrap();
                let path: Vec<Located> = along.into_iter().map(Located::Vertex).collect();
                let straight = straighten(&moved, &path);
                assert!(straight.first() == path.first() && straight.last() == path.last(), "{far}");
            }
        }
    }

    #[test]
    fn a_contractible_loop_vanishes_unless_it_contains_a_fixed_vertex() {
        let grid = shapes::grid(8, 8, 1.0, 1.0, shapes::Diagonal::Uniform).unwrap();
        let corners = [20, 24, 60, 56, 20].map(Vertex);
        let along = crate::curves::shortest_vertex_path(&grid, &corners).unwrap();
        let path: Vec<Located> = along.into_iter().map(Located::Vertex).collect();
        assert_eq!(straighten_loop(&grid, &path, &|_| false).len(), 1);
        let held = straighten_loop(&grid, &path, &|v| v == Vertex(40));
        assert!(held.contains(&Located::Vertex(Vertex(40))), "{held:?}");
    }
}
