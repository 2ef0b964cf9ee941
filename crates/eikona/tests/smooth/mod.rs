//! Properties of every straightened completion, compared with the same solve with completions along
//! edges.
#![allow(dead_code)] // each test file uses some of them

use eikona::geometry::vector::distance;
use eikona::mesh::{Edge, Face, TriangleMesh, Vertex};
use eikona::winding::{JumpLoop, Winding};
use std::collections::BTreeMap;

/// Returns the length of loops.
pub fn length(mesh: &TriangleMesh, loops: &[JumpLoop]) -> f64 {
    let steps = loops.iter().flat_map(|l| l.vertices.windows(2));
    steps.map(|v| distance(mesh.position(v[0]), mesh.position(v[1]))).sum()
}

/// Returns the jump of the labels at an edge: the face of its first halfedge minus that of its
/// second.
pub fn label_jump(w: &Winding, e: Edge) -> i32 {
    match w.mesh.edge_halfedges(e) {
        &[a, b] => w.labels[a.face()] - w.labels[b.face()],
        _ => 0,
    }
}

/// Returns the labels beside the steps of the curve, in its order: for a step that was cut, those
/// of its first part.
fn beside_curve(w: &Winding) -> BTreeMap<(usize, usize), Vec<[i32; 2]>> {
    let mut labels: BTreeMap<(usize, usize), Vec<[i32; 2]>> = BTreeMap::new();
    for (c, walk) in w.curves.iter().enumerate() {
        for (ends, &segment) in walk.vertices.windows(2).zip(&walk.segments) {
            let e = w.mesh.find_edge(ends[0], ends[1]).unwrap();
            if let &[a, b] = w.mesh.edge_halfedges(e) {
                let mut pair = [w.labels[a.face()], w.labels[b.face()]];
                pair.sort_unstable();
                labels.entry((c, segment)).or_default().push(pair);
            }
        }
    }
    labels
}

/// Compares a straightened result with the one on edges.
pub fn check(input: &TriangleMesh, edges: &Winding, straight: &Winding) {
    let (mesh, report) = (&straight.mesh, straight.report.completion);
    assert!(edges.report.completion.is_none());
    // Nothing to complete: the same digits.
    if report.is_none_or(|r| r.straightened == 0) {
        assert_eq!(mesh.triangles(), edges.mesh.triangles());
        assert_eq!(straight.labels, edges.labels);
        assert_eq!(straight.nonbounding, edges.nonbounding);
        assert_eq!(straight.bounding_loops, edges.bounding_loops);
        return;
    }
    let report = report.unwrap();
    assert!(report.straightened + report.on_edges <= report.pieces);
    assert!(report.length_after < report.length_before);
    // Properties of the solution on edges are unchanged.
    assert_eq!(straight.report.program, edges.report.program);
    assert_eq!(straight.report.largest_nonbounding, edges.report.largest_nonbounding);
    assert_eq!((&straight.endpoints, &straight.shift), (&edges.endpoints, &edges.shift));
    assert_eq!(straight.bounding_part().curves.len(), edges.bounding_part().curves.len());
    // The input stays in place, with its jumps and parts.
    assert_eq!(straight.curves.len(), edges.curves.len());
    for (new, old) in straight.curves.iter().zip(&edges.curves) {
        let mut next = new.vertices.iter();
        assert!(old.vertices.iter().all(|v| next.any(|n| n == v)), "a walk still passes all its vertices");
    }
    let copies = |w: &Winding| -> i64 { w.jump.iter().map(|(_, j)| i64::from(j.abs())).sum() };
    assert!(copies(straight) >= copies(edges));
    // Both maps lead back to the input.
    let parents = straight.provenance.face_parents();
    assert_eq!(parents.len(), mesh.face_count());
    assert!(parents.is_sorted());
    for v in mesh.vertices() {
        let place = straight.provenance.vertex_place(v).unwrap().locate(input).unwrap().position(input);
        let size = input.positions().iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
        assert!((0..3).all(|k| (place[k] - mesh.position(v)[k]).abs() <= 1e-7 * size), "{v}");
    }
    // Loops run exactly where labels and nonbounding jumps change.
    let mut from_loops = vec![0.0; mesh.edge_count()];
    for l in &straight.bounding_loops {
        for ends in l.vertices.windows(2) {
            from_loops[mesh.find_edge(ends[0], ends[1]).unwrap().index()] += l.jump;
        }
    }
    for e in mesh.edges() {
        assert_eq!(from_loops[e.index()], f64::from(label_jump(straight, e).abs()), "{e}");
    }
    // The nonbounding part is closed: its jumps sum to zero around inner vertices.
    for v in mesh.vertices() {
        if let Some(sum) = sum_around(mesh, v, |e| straight.nonbounding[e]) {
            let most = edges.nonbounding.iter().fold(1.0f64, |m, (_, t)| m.max(t.abs()));
            assert!(sum.abs() < 1e-6 * most, "{v}: {sum}");
        }
    }
    // Labels beside the curve are unchanged, unless a completion runs or ran there.
    let (new, old) = (beside_curve(straight), beside_curve(edges));
    for (step, labels) in &old {
        let ([a, b], [c, d]) = (labels[0], new[step][0]);
        assert!([a, b] == [c, d] || b - a != d - c, "segment {step:?}: labels {a} {b}, then {c} {d}");
    }
}

/// Returns the sum of jumps around a vertex inside the surface.
pub fn sum_around(mesh: &TriangleMesh, v: Vertex, jump: impl Fn(Edge) -> f64) -> Option<f64> {
    let first = mesh.vertex_corners(v).first()?.halfedge();
    let (mut side, mut sum) = (first, 0.0);
    for _ in 0..mesh.vertex_corners(v).len() {
        side = if mesh.tip(side) == v { side.next() } else { side.previous() };
        let edge = mesh.edge(side);
        let &[a, b] = mesh.edge_halfedges(edge) else { return None };
        sum += if a == side { jump(edge) } else { -jump(edge) };
        side = if a == side { b } else { a };
        if side == first {
            return Some(sum);
        }
    }
    None
}

/// Returns the area of the faces that `chosen` accepts.
pub fn area_of(mesh: &TriangleMesh, chosen: impl Fn(Face) -> bool) -> f64 {
    mesh.faces().filter(|&f| chosen(f)).map(|f| eikona::geometry::Triangle::of_face(mesh, f).area).sum()
}
