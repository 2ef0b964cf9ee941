//! Detects where segments of curves meet: within each face, along each edge and at each node.

use super::report::{CurveReport, MAX_LISTED, Meeting, MeetingKind, Overlap, SegmentId};
use crate::geometry::vector::{distance, lerp};
use eikona_mesh::{Located, SegmentHost, TriangleMesh};
use std::collections::BTreeMap;

/// Largest number of segment pairs tested; intended curves stay far below it.
const PAIRS_TESTED: usize = 20_000_000;

/// A segment inside one edge or face.
pub(super) struct Hosted {
    pub id: SegmentId,
    pub ends: [Located; 2],
    pub host: SegmentHost,
}

/// A curve passing through (or ending in) a node.
pub(super) struct Visit {
    pub segment: SegmentId,
    pub place: Located,
    pub end: bool,
}

/// A place as a key: element and bits of the weights.
type Key = (u8, u32, [u64; 3]);

/// Adds meetings and doubled pieces to the report.
pub(super) fn find(mesh: &TriangleMesh, segments: &[Hosted], visits: &[Visit], report: &mut CurveReport) {
    at_nodes(mesh, visits, report);
    let mut in_face: BTreeMap<u32, Vec<&Hosted>> = BTreeMap::new();
    let mut on_edge: BTreeMap<u32, Vec<&Hosted>> = BTreeMap::new();
    for s in segments {
        match s.host {
            SegmentHost::Face(f, _) => in_face.entry(f.0).or_default().push(s),
            SegmentHost::Edge(e, _) => on_edge.entry(e.0).or_default().push(s),
        }
    }
    let mut nodes_on_edge: BTreeMap<u32, Vec<(f64, &Visit)>> = BTreeMap::new();
    for visit in visits {
        if let Located::Edge(e, t) = visit.place {
            nodes_on_edge.entry(e.0).or_default().push((t, visit));
        }
    }
    let mut budget = PAIRS_TESTED;
    for group in in_face.values_mut() {
        within_face(mesh, group, report, &mut budget);
    }
    for (edge, group) in &on_edge {
        let nodes = nodes_on_edge.get(edge).map_or(&[][..], |n| n);
        along_edge(mesh, group, nodes, report, &mut budget);
    }
    report.meetings.sort_by_key(|m| m.segments);
    report.overlaps.sort_by_key(|d| d.segments);
}

fn list_meeting(
    report: &mut CurveReport,
    mut segments: [SegmentId; 2],
    kind: MeetingKind,
    position: [f64; 3],
) {
    segments.sort();
    if report.meetings.len() < MAX_LISTED {
        report.meetings.push(Meeting { segments, kind, position });
    } else {
        report.truncated = true;
    }
}

fn list_overlap(report: &mut CurveReport, mut segments: [SegmentId; 2], same_direction: bool, length: f64) {
    segments.sort();
    if report.overlaps.len() < MAX_LISTED {
        report.overlaps.push(Overlap { segments, same_direction, length });
    } else {
        report.truncated = true;
    }
}

/// Reports nodes that are passed more than once. Where two curves both end, one continues the
/// other.
fn at_nodes(mesh: &TriangleMesh, visits: &[Visit], report: &mut CurveReport) {
    let mut first: BTreeMap<Key, &Visit> = BTreeMap::new();
    for visit in visits {
        let other = first.entry(visit.place.key()).or_insert(visit);
        if std::ptr::eq(*other, visit) || (other.end && visit.end) {
            continue;
        }
        let kind = if other.end || visit.end { MeetingKind::Touching } else { MeetingKind::SharedNode };
        list_meeting(report, [other.segment, visit.segment], kind, visit.place.position(mesh));
        if other.end {
            *other = visit; // compare later visits with one that passes through
        }
    }
}

/// Returns the coordinates of both ends in the triangle's plane: weights of corners 1 and 2.
fn flat(s: &Hosted) -> [[f64; 2]; 2] {
    match s.host {
        SegmentHost::Face(_, w) => w.map(|w| [w[1], w[2]]),
        SegmentHost::Edge(..) => [[0.0; 2]; 2],
    }
}

fn within_face(mesh: &TriangleMesh, group: &mut [&Hosted], report: &mut CurveReport, budget: &mut usize) {
    if group.len() < 2 {
        return;
    }
    // Sorted by their left ends, only segments that overlap in x need testing.
    let left = |s: &Hosted| flat(s)[0][0].min(flat(s)[1][0]);
    let right = |s: &Hosted| flat(s)[0][0].max(flat(s)[1][0]);
    group.sort_by(|a, b| left(a).total_cmp(&left(b)).then(a.id.cmp(&b.id)));
    for (i, a) in group.iter().enumerate() {
        for b in group[i + 1..].iter().take_while(|b| left(b) <= right(a)) {
            let Some(rest) = budget.checked_sub(1) else {
                report.truncated = true;
                return;
            };
            *budget = rest;
            in_pair(mesh, a, b, report);
        }
    }
}

fn in_pair(mesh: &TriangleMesh, a: &Hosted, b: &Hosted, report: &mut CurveReport) {
    let shared = a.ends.map(|p| b.ends.contains(&p));
    if shared[0] && shared[1] {
        let length = distance(a.ends[0].position(mesh), a.ends[1].position(mesh));
        list_overlap(report, [a.id, b.id], a.ends[0] == b.ends[0], length);
        return;
    }
    if shared[0] || shared[1] {
        return; // neighbours on a curve, or a node passed twice
    }
    let ([p, q], [r, s]) = (flat(a), flat(b));
    let area =
        |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let (to_r, to_s, to_p, to_q) = (area(p, q, r), area(p, q, s), area(r, s, p), area(r, s, q));
    if to_r * to_s > 0.0 || to_p * to_q > 0.0 || to_p == to_q {
        return;
    }
    let t = to_p / (to_p - to_q);
    let position = lerp(a.ends[0].position(mesh), a.ends[1].position(mesh), t);
    let crossing = to_r != 0.0 && to_s != 0.0 && to_p != 0.0 && to_q != 0.0;
    let kind = if crossing { MeetingKind::Crossing } else { MeetingKind::Touching };
    list_meeting(report, [a.id, b.id], kind, position);
}

/// Compares segments along one edge: common pieces, and nodes of other curves on them.
fn along_edge(
    mesh: &TriangleMesh,
    group: &[&Hosted],
    nodes: &[(f64, &Visit)],
    report: &mut CurveReport,
    budget: &mut usize,
) {
    let span = |s: &Hosted| match s.host {
        SegmentHost::Edge(_, [a, b]) => (a.min(b), a.max(b), a < b),
        SegmentHost::Face(..) => (0.0, 0.0, true),
    };
    let mut spans: Vec<_> = group.iter().map(|s| (span(s), *s)).collect();
    spans.sort_by(|a, b| a.0.0.total_cmp(&b.0.0).then(a.1.id.cmp(&b.1.id)));
    let mut nodes = nodes.to_vec();
    nodes.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (i, &((low, high, along), s)) in spans.iter().enumerate() {
        let length = distance(s.ends[0].position(mesh), s.ends[1].position(mesh));
        for &((low_b, high_b, along_b), b) in spans[i + 1..].iter().take_while(|b| b.0.0 < high) {
            let Some(rest) = budget.checked_sub(1) else {
                report.truncated = true;
                return;
            };
            *budget = rest;
            let common = (high.min(high_b) - low.max(low_b)) / (high - low) * length;
            list_overlap(report, [s.id, b.id], along == along_b, common);
        }
        let begin = nodes.partition_point(|n| n.0 <= low);
        for (_, visit) in nodes[begin..].iter().take_while(|n| n.0 < high) {
            let Some(rest) = budget.checked_sub(1) else {
                report.truncated = true;
                return;
            };
            *budget = rest;
            list_meeting(report, [s.id, visit.segment], MeetingKind::Touching, visit.place.position(mesh));
        }
    }
}
