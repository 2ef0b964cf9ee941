//! What there is to know about a set of curves before it is used as a source: lengths, gaps,
//! crossings, doubled pieces, segments across faces, closed curves without two sides.

use super::meeting::{self, Hosted};
use super::nearest_end::nearest_others;
use super::side::Fans;
use crate::geometry::vector::distance;
use eikona_mesh::{
    Curve, CurveError, CurveKind, Located, SegmentHost, SurfaceCurves, TriangleMesh, segment_host,
};

/// How many crossings and doubled pieces are listed, at most.
pub const LISTED: usize = 10_000;

/// A segment of a set of curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SegmentId {
    /// 0-based index of the curve.
    pub curve: usize,
    /// 0-based index of the segment's first node.
    pub node: usize,
}

/// One curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurveFacts {
    /// Sum of the straight distances between its nodes, in the mesh's unit.
    pub length: f64,
    /// Whether its last node is its first.
    pub closed: bool,
    /// First nodes of segments that lie in no single face; tracing resolves them.
    pub across_faces: Vec<usize>,
    /// First nodes of segments of length zero.
    pub zero_length: Vec<usize>,
    /// Whether it is closed and its left side becomes its right on the way round: it then has no
    /// sides to tell apart.
    pub one_sided: bool,
}

/// An end of an open curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenEnd {
    /// 0-based index of the curve.
    pub curve: usize,
    /// Whether it is the last node (`true`) or the first.
    pub last: bool,
    /// Where it lies.
    pub position: [f64; 3],
    /// The nearest other open end as an index into [`CurveReport::open_ends`], and the distance in
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

/// A place that curves pass more than once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting {
    /// The two segments, of one curve or of two.
    pub segments: [SegmentId; 2],
    /// How they meet.
    pub kind: MeetingKind,
    /// Where.
    pub position: [f64; 3],
}

/// A piece that is covered twice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Doubled {
    /// The two segments.
    pub segments: [SegmentId; 2],
    /// Whether they run the same way; against each other they cancel as signed sources.
    pub same_direction: bool,
    /// The length of the common piece.
    pub length: f64,
}

/// What there is to know about a set of curves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurveReport {
    /// Each curve.
    pub curves: Vec<CurveFacts>,
    /// The ends of the open curves: gaps, if the curves were meant to be closed.
    pub open_ends: Vec<OpenEnd>,
    /// Crossings of curves with themselves and with others.
    pub meetings: Vec<Meeting>,
    /// Pieces covered twice.
    pub doubled: Vec<Doubled>,
    /// Whether there are more meetings or doubled pieces than are listed.
    pub truncated: bool,
}

impl CurveReport {
    /// Looks the curves over.
    ///
    /// # Errors
    /// [`CurveError`] for a node that is not on the mesh. All else that is wrong is in the report.
    ///
    /// # Cost
    /// O(n log n) in the number of segments, as long as no face holds many of them; the tests
    /// within the faces are bounded.
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

    /// The total length of all curves.
    pub fn length(&self) -> f64 {
        self.curves.iter().map(|c| c.length).sum()
    }

    /// What a user should look at, a sentence each.
    pub fn warnings(&self, curves: &SurfaceCurves) -> Vec<String> {
        let mut warnings = Vec::new();
        for (c, facts) in self.curves.iter().enumerate() {
            if let Some(n) = facts.across_faces.first() {
                let count = facts.across_faces.len();
                warnings.push(format!(
                    "curve {c}: {count} segment(s), the first at node {n}, lie in no single face; have the curve traced"
                ));
            }
            let signed = curves.curves.get(c).is_some_and(|x| x.kind == CurveKind::Signed);
            if facts.one_sided && signed {
                warnings.push(format!(
                    "curve {c} is closed but one-sided: its left becomes its right on the way round; make it unsigned"
                ));
            }
        }
        let cancelling = self.doubled.iter().filter(|d| !d.same_direction).count();
        if cancelling > 0 {
            warnings.push(format!(
                "{cancelling} pair(s) of pieces run against each other along the same line and cancel"
            ));
        }
        if self.doubled.len() > cancelling {
            let count = self.doubled.len() - cancelling;
            warnings.push(format!(
                "{count} pair(s) of pieces run the same way along the same line; each of them counts"
            ));
        }
        let crossings = self.meetings.iter().filter(|m| m.kind == MeetingKind::Crossing).count();
        if crossings > 0 {
            warnings.push(format!("curves cross inside faces at {crossings} place(s)"));
        }
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

/// Carries the side once around a closed curve.
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
        match fans.relative_winding(f, g, segment.ends[1]) {
            Some(turn) => side *= turn,
            None => return false, // at a nonmanifold place sides are not told
        }
    }
    side < 0.0
}
