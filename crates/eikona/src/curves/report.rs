//! Checks of a set of curves before use: lengths, gaps, crossings, doubled pieces, segments across
//! faces, one-sided closed curves.

use super::meeting::{self, Hosted};
use super::nearest_end::nearest_others;
use super::side::Fans;
use crate::Warning;
use crate::geometry::vector::distance;
use eikona_mesh::{
    Curve, CurveError, CurveKind, Located, SegmentHost, SurfaceCurves, TriangleMesh, segment_host,
};
use serde::Serialize;

/// Largest number of meetings, and of doubled pieces, that a report lists.
pub const MAX_LISTED: usize = 10_000;

/// A segment of a set of curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct SegmentId {
    /// 0-based index of the curve.
    pub curve: usize,
    /// 0-based index of the segment's first node.
    pub node: usize,
}

/// Properties of one curve.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct CurveFacts {
    /// Sum of the straight distances between its nodes, in the mesh's unit.
    pub length: f64,
    /// Whether its last node is its first.
    pub closed: bool,
    /// First nodes of segments that do not lie in a single face; tracing resolves them.
    pub across_faces: Vec<usize>,
    /// First nodes of segments of length zero.
    pub zero_length: Vec<usize>,
    /// Whether it is closed and left becomes right after one turn, so that it has no two sides.
    pub one_sided: bool,
}

/// An end of an open curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenEnd {
    /// 0-based index of the curve.
    pub curve: usize,
    /// Whether it is the last node (`true`) or the first.
    pub last: bool,
    /// Position of the end.
    pub position: [f64; 3],
    /// The nearest other open end, as an index into [`CurveReport::open_ends`], and its distance in
    /// space.
    pub nearest: Option<(usize, f64)>,
}

/// How two segments meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeetingKind {
    /// They cross inside a face.
    Crossing,
    /// Both curves pass through one node: they cross or touch there.
    SharedNode,
    /// A node of one lies on the other.
    Touching,
}

/// A place where curves cross or touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// The two segments, of one curve or of two.
    pub segments: [SegmentId; 2],
    /// How they meet.
    pub kind: MeetingKind,
    /// Position of the meeting.
    pub position: [f64; 3],
}

/// A piece that two segments cover.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// The two segments.
    pub segments: [SegmentId; 2],
    /// Whether they run in the same direction; in opposite directions they cancel as signed
    /// sources.
    pub same_direction: bool,
    /// Length of the common piece.
    pub length: f64,
}

/// Properties and defects of a set of curves.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct CurveReport {
    /// Properties of each curve.
    pub curves: Vec<CurveFacts>,
    /// Ends of the open curves: gaps, if the curves are meant to be closed.
    pub open_ends: Vec<OpenEnd>,
    /// Places where curves cross or touch themselves or each other.
    pub meetings: Vec<Meeting>,
    /// Pieces covered twice.
    pub overlaps: Vec<Overlap>,
    /// Whether there are more meetings or doubled pieces than listed.
    pub truncated: bool,
}

impl CurveReport {
    /// Analyses the curves.
    ///
    /// # Errors
    /// [`CurveError`] for a node that is not on the mesh. Other defects are in the report.
    ///
    /// # Cost
    /// O(n log n) in the number of segments, unless one face holds many of them; the number of
    /// tests within faces is bounded.
    pub fn of(mesh: &TriangleMesh, curves: &SurfaceCurves) -> Result<CurveReport, CurveError> {
        let mut report = CurveReport::default();
        let mut hosted = Vec::new();
        let mut nodes = Vec::new();
        let mut fans = Fans::new(mesh, mesh.is_consistently_oriented());
        for (c, curve) in curves.curves.iter().enumerate() {
            let located = curve.nodes.iter().enumerate();
            let located = located.map(|(n, p)| p.locate(mesh).map_err(|e| e.at(c, n)));
            let located: Vec<Located> = located.collect::<Result<_, _>>()?;
            let first = hosted.len();
            let facts = curve_facts(mesh, c, curve, &located, &mut hosted);
            if !facts.closed && located.len() > 1 {
                for (last, place) in [(false, located.first()), (true, located.last())] {
                    let Some(place) = place else { continue };
                    let position = place.position(mesh);
                    report.open_ends.push(OpenEnd { curve: c, last, position, nearest: None });
                }
            }
            for (n, place) in located.iter().enumerate().take(located.len() - usize::from(facts.closed)) {
                let end = !facts.closed && (n == 0 || n + 1 == located.len());
                let repeats = n > 0 && located[n - 1] == *place;
                if !repeats {
                    let node = if end && n > 0 { n - 1 } else { n };
                    nodes.push(meeting::Visit { segment: SegmentId { curve: c, node }, place: *place, end });
                }
            }
            let one_sided = one_sided(mesh, &mut fans, &facts, &hosted[first..]);
            report.curves.push(CurveFacts { one_sided, ..facts });
        }
        let positions: Vec<[f64; 3]> = report.open_ends.iter().map(|e| e.position).collect();
        for (end, nearest) in report.open_ends.iter_mut().zip(nearest_others(&positions)) {
            end.nearest = nearest;
        }
        meeting::find(mesh, &hosted, &nodes, &mut report);
        Ok(report)
    }

    /// Returns the total length of all curves.
    pub fn length(&self) -> f64 {
        self.curves.iter().map(|c| c.length).sum()
    }

    /// Returns the warnings about these curves.
    pub fn warnings(&self, curves: &SurfaceCurves) -> Vec<Warning> {
        let mut warnings = Vec::new();
        for (curve, facts) in self.curves.iter().enumerate() {
            if let Some(&first_node) = facts.across_faces.first() {
                let count = facts.across_faces.len();
                warnings.push(Warning::SegmentsAcrossFaces { curve, count, first_node });
            }
            let signed = curves.curves.get(curve).is_some_and(|c| c.kind == CurveKind::Signed);
            if facts.one_sided && signed {
                warnings.push(Warning::OneSidedCurve { curve });
            }
        }
        let mut add = |count: usize, warning: fn(usize) -> Warning| {
            if count > 0 {
                warnings.push(warning(count));
            }
        };
        let same_direction = self.overlaps.iter().filter(|d| d.same_direction).count();
        add(self.overlaps.len() - same_direction, |count| Warning::OppositeOverlaps { count });
        add(same_direction, |count| Warning::Overlaps { count });
        let crossings = self.meetings.iter().filter(|m| m.kind == MeetingKind::Crossing).count();
        add(crossings, |count| Warning::Crossings { count });
        warnings
    }
}

fn curve_facts(
    mesh: &TriangleMesh,
    c: usize,
    curve: &Curve,
    located: &[Located],
    hosted: &mut Vec<Hosted>,
) -> CurveFacts {
    let closed = curve.is_closed() || (located.len() > 2 && located.first() == located.last());
    let mut facts = CurveFacts { closed, ..Default::default() };
    for (n, pair) in located.windows(2).enumerate() {
        let ends = [pair[0], pair[1]];
        facts.length += distance(ends[0].position(mesh), ends[1].position(mesh));
        if ends[0] == ends[1] {
            facts.zero_length.push(n);
            continue;
        }
        match segment_host(mesh, ends[0], ends[1]) {
            Some(host) => hosted.push(Hosted { id: SegmentId { curve: c, node: n }, ends, host }),
            None => facts.across_faces.push(n),
        }
    }
    facts
}

/// Whether the left side of a closed curve becomes its right side after one turn.
fn one_sided(mesh: &TriangleMesh, fans: &mut Fans, facts: &CurveFacts, segments: &[Hosted]) -> bool {
    if !facts.closed || !facts.across_faces.is_empty() || segments.is_empty() {
        return false;
    }
    let face = |s: &Hosted| match s.host {
        SegmentHost::Face(f, _) => Some(f),
        SegmentHost::Edge(e, _) => mesh.edge_halfedges(e).first().map(|h| h.face()),
    };
    let mut side = 1.0;
    for (i, segment) in segments.iter().enumerate() {
        let next = &segments[(i + 1) % segments.len()];
        let (Some(f), Some(g)) = (face(segment), face(next)) else { return false };
        match fans.relative_orientation(f, g, segment.ends[1]) {
            Some(turn) => side *= turn,
            None => return false, // sides are undefined at nonmanifold places
        }
    }
    side < 0.0
}
