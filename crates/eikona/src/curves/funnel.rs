//! The funnel algorithm: the shortest path through a strip of faces unfolded into the plane.

use super::straighten::{Leg, path_length};
use crate::geometry::vector::{cross, dot, norm, sub};
use eikona_mesh::{Edge, Face, Located, SNAP_TOLERANCE, TriangleMesh, Vertex};

type Point = [f64; 2];

/// The edge between two faces of the unfolded strip.
struct Gate {
    left: (Vertex, Point),
    right: (Vertex, Point),
}

/// A bend of the path, or one of its ends.
#[derive(Clone, Copy)]
struct Bend {
    /// Number of gates before it, its own included.
    passed: usize,
    place: Located,
    point: Point,
}

/// Returns twice the signed area: positive if `c` lies to the left of the line from `a` to `b`.
fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Returns the corners and legs of the shortest path from `from`, in the first face, to `to`, in
/// the last. `None` if consecutive faces do not form a strip.
pub(super) fn shortest_in_strip(
    mesh: &TriangleMesh,
    from: Located,
    to: Located,
    faces: &[Face],
    gates: &[Edge],
) -> Option<(Vec<Located>, Vec<Leg>)> {
    let (unfolded, start, end) = unfold(mesh, from, to, faces, gates)?;
    let first = Bend { passed: 0, place: from, point: start };
    let last = Bend { passed: gates.len(), place: to, point: end };
    let mut bends = vec![first];
    bends.extend(pull(&unfolded, start, end));
    bends.push(last);
    bends = bend_at_passed_vertices(gates, &unfolded, &bends);
    // A closed path starts and ends in one place, but at two points of the unfolded strip.
    let size = [start, end].into_iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    let is_same = |a: &Bend, b: &Bend| {
        a.place == b.place && (0..2).all(|k| (a.point[k] - b.point[k]).abs() <= 1e-9 * size)
    };
    bends.dedup_by(|b, a| is_same(a, b) && !matches!(a.place, Located::Face(..)));
    if !is_same(bends.last()?, &last) {
        bends.push(last);
    }
    let mut legs = Vec::with_capacity(bends.len() - 1);
    for pair in bends.windows(2) {
        legs.push(leg(mesh, pair[0], pair[1], faces, gates, &unfolded)?);
    }
    let corners = bends.get(1..bends.len() - 1)?.iter().map(|b| b.place).collect();
    Some((corners, legs))
}

fn unfold(
    mesh: &TriangleMesh,
    from: Located,
    to: Located,
    faces: &[Face],
    gates: &[Edge],
) -> Option<(Vec<Gate>, Point, Point)> {
    let face = *faces.first()?;
    let ids = mesh.face_vertices(face);
    let length = norm(sub(mesh.position(ids[1]), mesh.position(ids[0])));
    let mut corners = [(ids[0], [0.0, 0.0]), (ids[1], [length, 0.0]), (ids[2], [0.0, 0.0])];
    corners[2].1 = third_point(mesh, corners[0], corners[1], ids[2]);
    let start = place(mesh, from, face, &corners)?;
    let mut unfolded = Vec::with_capacity(gates.len());
    for (&gate, &next) in gates.iter().zip(faces.get(1..)?) {
        let ends = mesh.edge_vertices(gate);
        // The corners are in counterclockwise order, so leaving the face puts the side's second
        // corner on the left.
        let k = (0..3).find(|&k| ends.contains(&corners[k].0) && ends.contains(&corners[(k + 1) % 3].0))?;
        let (right, left) = (corners[k], corners[(k + 1) % 3]);
        unfolded.push(Gate { left, right });
        let vertices = mesh.face_vertices(next);
        let far = vertices.into_iter().find(|v| !ends.contains(v))?;
        if !ends.iter().all(|v| vertices.contains(v)) {
            return None;
        }
        corners = [left, right, (far, third_point(mesh, left, right, far))];
    }
    let end = place(mesh, to, *faces.last()?, &corners)?;
    Some((unfolded, start, end))
}

/// Returns the position of a face's third corner, left of the line from `a` to `b`.
fn third_point(mesh: &TriangleMesh, a: (Vertex, Point), b: (Vertex, Point), c: Vertex) -> Point {
    let (side, other) =
        (sub(mesh.position(b.0), mesh.position(a.0)), sub(mesh.position(c), mesh.position(a.0)));
    let length = norm(side);
    if length == 0.0 {
        return [a.1[0], a.1[1] + norm(other)];
    }
    let (along, off) = (dot(side, other) / length, norm(cross(side, other)) / length);
    let unit = [(b.1[0] - a.1[0]) / length, (b.1[1] - a.1[1]) / length];
    [a.1[0] + along * unit[0] - off * unit[1], a.1[1] + along * unit[1] + off * unit[0]]
}

fn place(mesh: &TriangleMesh, at: Located, face: Face, corners: &[(Vertex, Point); 3]) -> Option<Point> {
    let weights = at.weights_in_face(mesh, face)?;
    let mut point = [0.0; 2];
    for (v, w) in mesh.face_vertices(face).into_iter().zip(weights) {
        let p = corners.iter().find(|c| c.0 == v)?.1;
        point = [point[0] + w * p[0], point[1] + w * p[1]];
    }
    Some(point)
}

/// Returns the bends of the shortest path through the gates. The funnel from the last bend (`apex`)
/// to the sides seen so far is narrowed gate by gate; where one side crosses the other, the path
/// bends.
fn pull(gates: &[Gate], start: Point, end: Point) -> Vec<Bend> {
    let mut bends = Vec::new();
    let mut apex = start;
    let (mut left, mut right) = ((start, 0), (start, 0));
    let mut i = 0;
    while i <= gates.len() {
        let (to_left, to_right) = match gates.get(i) {
            Some(gate) => (gate.left.1, gate.right.1),
            None => (end, end),
        };
        i += 1;
        let mut bend = None;
        if turn(apex, right.0, to_right) >= 0.0 {
            if apex == right.0 || turn(apex, left.0, to_right) < 0.0 {
                right = (to_right, i);
            } else {
                bend = Some((left, true));
            }
        }
        if bend.is_none() && turn(apex, left.0, to_left) <= 0.0 {
            if apex == left.0 || turn(apex, right.0, to_left) > 0.0 {
                left = (to_left, i);
            } else {
                bend = Some((right, false));
            }
        }
        // A side with number 0 is the start, past the last gate the end: there is no vertex to bend
        // at. Beside coordinates beyond the range of numbers, a side may stay at the apex; a bend
        // there would be repeated for ever.
        if let Some(((point, passed), on_left)) = bend
            && passed > bends.last().map_or(0, |bend: &Bend| bend.passed)
            && let Some(gate) = passed.checked_sub(1).and_then(|g| gates.get(g))
        {
            let vertex = if on_left { gate.left.0 } else { gate.right.0 };
            bends.push(Bend { passed, place: Located::Vertex(vertex), point });
            apex = point;
            (left, right) = ((point, passed), (point, passed));
            i = passed;
        }
    }
    bends
}

/// Returns where the path passes a gate between two bends, from 0 at the left to 1 at the right.
/// `None` for gates at whose end, or along which, it bends.
fn passage(a: Bend, b: Bend, edge: Edge, gate: &Gate) -> Option<f64> {
    for place in [a.place, b.place] {
        match place {
            Located::Vertex(v) if v == gate.left.0 || v == gate.right.0 => return None,
            Located::Edge(e, _) if e == edge => return None,
            _ => {}
        }
    }
    let (l, r) = (turn(a.point, b.point, gate.left.1), turn(a.point, b.point, gate.right.1));
    let t = l / (l - r);
    Some(if t.is_nan() { 0.5 } else { t.clamp(0.0, 1.0) })
}

/// Makes a vertex that a straight leg passes exactly through a bend: on a curved surface its other
/// side may be shorter.
fn bend_at_passed_vertices(edges: &[Edge], gates: &[Gate], bends: &[Bend]) -> Vec<Bend> {
    let mut all = Vec::with_capacity(bends.len());
    for pair in bends.windows(2) {
        all.push(pair[0]);
        for g in pair[0].passed..pair[1].passed {
            let Some(t) = passage(pair[0], pair[1], edges[g], &gates[g]) else { continue };
            let (vertex, point) = match t {
                t if t <= SNAP_TOLERANCE => gates[g].left,
                t if t >= 1.0 - SNAP_TOLERANCE => gates[g].right,
                _ => continue,
            };
            all.push(Bend { passed: g + 1, place: Located::Vertex(vertex), point });
        }
    }
    all.extend(bends.last());
    all
}

fn leg(mesh: &TriangleMesh, a: Bend, b: Bend, faces: &[Face], edges: &[Edge], gates: &[Gate]) -> Option<Leg> {
    // Faces before the first gate that the leg crosses, and after the last, hold only its ends.
    let touches = |g: usize| passage(a, b, edges[g], &gates[g]).is_none();
    let (mut low, mut high) = (a.passed, b.passed);
    let holds = |place: Located, face: Face| place.weights_in_face(mesh, face).is_some();
    while low < high && touches(low) && holds(a.place, *faces.get(low + 1)?) {
        low += 1;
    }
    while high > low && touches(high - 1) && holds(b.place, *faces.get(high - 1)?) {
        high -= 1;
    }
    let mut nodes = Vec::with_capacity(high - low);
    for g in low..high {
        let t = passage(a, b, edges[g], &gates[g])?;
        let forward = mesh.edge_vertices(edges[g])[0] == gates[g].left.0;
        nodes.push(Located::Edge(edges[g], if forward { t } else { 1.0 - t }));
    }
    let mut path = vec![a.place];
    path.extend(&nodes);
    path.push(b.place);
    let length = path_length(mesh, &path);
    let (faces, gates) = (faces.get(low..=high)?.to_vec(), edges.get(low..high)?.to_vec());
    length.is_finite().then_some(Leg { faces, gates, nodes, length })
}
