//! Step I, right-hand side: what curves and points put on the edges (SHM section 5.6 and appendix A).

use crate::geometry::Triangle;
use crate::operators::{EdgeFrames, EdgeVector};
use crate::signed_heat::options::SignConvention;
use crate::signed_heat::side::SideOfSegments;
use eikona_mesh::{
    CurveError, CurveKind, Face, Halfedge, Located, Neighbour, Segment, SegmentHost, SurfaceCurves,
    TriangleMesh, Vertex,
};
use eikona_numeric::Complex;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// A source looked up on the mesh.
pub(crate) struct Source {
    pub segments: Vec<Segment>,
    pub points: Vec<Located>,
    /// For each segment: its kind.
    pub kinds: Vec<CurveKind>,
    /// The ends of open unsigned curves: the point, its last segment, and at which end of it.
    caps: Vec<(Segment, usize)>,
    pub warnings: Vec<String>,
    sides: SideOfSegments,
}

impl Source {
    /// Looks up every node.
    pub fn new(mesh: &TriangleMesh, input: &SurfaceCurves) -> Result<Source, CurveError> {
        if input.is_empty() {
            return Err(CurveError::Empty);
        }
        let segments = input.segments(mesh)?;
        let points = input.located_points(mesh)?;
        let kinds: Vec<CurveKind> = segments.iter().map(|s| input.curves[s.curve].kind).collect();
        let mut warnings = Vec::new();
        let sides = SideOfSegments::of(mesh, input, &segments, &mut warnings);
        let caps = open_unsigned_ends(input, &segments);
        Ok(Source { segments, points, kinds, caps, warnings, sides })
    }

    /// The values `X_0`. Points weigh as much as a curve of length `point_weight`, so that both kinds mix at any scale.
    pub fn values(
        &self,
        mesh: &TriangleMesh,
        frames: &EdgeFrames,
        triangles: &[Triangle],
        sign: SignConvention,
        point_weight: f64,
    ) -> EdgeVector {
        let mut deposit = Deposit { mesh, frames, triangles, values: frames.zeros(mesh) };
        for (i, (segment, kind)) in self.segments.iter().zip(&self.kinds).enumerate() {
            match kind {
                CurveKind::Signed => deposit.signed_segment(segment, self.sides.of_segment(i), sign),
                CurveKind::Unsigned => deposit.unsigned_segment(segment),
            }
        }
        for (segment, end) in &self.caps {
            deposit.cap(segment, *end);
        }
        for point in &self.points {
            deposit.point(*point, point_weight);
        }
        deposit.values
    }
}

/// First and last segments of the unsigned curves that do not close, where no other unsigned curve goes on.
fn open_unsigned_ends(input: &SurfaceCurves, segments: &[Segment]) -> Vec<(Segment, usize)> {
    let mut ends = Vec::new();
    for (i, segment) in segments.iter().enumerate() {
        let curve = segment.curve;
        if input.curves[curve].kind != CurveKind::Unsigned || input.curves[curve].is_closed() {
            continue;
        }
        if i == 0 || segments[i - 1].curve != curve {
            ends.push((*segment, 0));
        }
        if segments.get(i + 1).is_none_or(|next| next.curve != curve) {
            ends.push((*segment, 1));
        }
    }
    // Two curves that meet end to end have no cap there.
    let mut count: HashMap<PointKey, usize> = HashMap::new();
    for (segment, end) in &ends {
        *count.entry(key(segment.ends[*end])).or_default() += 1;
    }
    ends.retain(|(segment, end)| count[&key(segment.ends[*end])] == 1);
    ends
}

type PointKey = (u8, u32, [u64; 3]);

/// Equal for equal points.
pub(crate) fn key(point: Located) -> PointKey {
    match point {
        Located::Vertex(v) => (0, v.0, [0; 3]),
        Located::Edge(e, t) => (1, e.0, [t.to_bits(), 0, 0]),
        Located::Face(f, w) => (2, f.0, w.map(f64::to_bits)),
    }
}

struct Deposit<'a> {
    mesh: &'a TriangleMesh,
    frames: &'a EdgeFrames,
    triangles: &'a [Triangle],
    values: EdgeVector,
}

const I: Complex = Complex { re: 0.0, im: 1.0 };

/// Where a direction of the star of a point goes: a wedge of directions inside one face, counter-clockwise from `start`
/// (an angle in the layout of the face).
struct Wedge {
    face: Face,
    start: f64,
    angle: f64,
    /// The side that the wedge looks at; `None`: all three, as for the corner of a face.
    side: Option<usize>,
}

impl Deposit<'_> {
    /// Adds a vector, given in the layout of a face, at one of its sides.
    fn add(&mut self, face: Face, side: usize, vector: Complex) {
        let along = self.triangles[face.index()].directions()[side];
        self.frames.add(self.mesh, &mut self.values, face.halfedge(side), along.conj() * vector);
    }

    /// The normal of an oriented segment (eq. 11, without the factor phi_e(m), as the paper advises).
    /// `side` tells in which face, and seen from which side of the surface, left is left.
    fn signed_segment(&mut self, segment: &Segment, (reference, upside): (Face, f64), sign: SignConvention) {
        // The gradient points away from the negative side.
        let to_gradient = match sign {
            SignConvention::LeftNegative => -upside,
            SignConvention::LeftPositive => upside,
        };
        match segment.host {
            SegmentHost::Face(face, [from, to]) => {
                let t = &self.triangles[face.index()];
                let normal = I * (t.point(to) - t.point(from)) * to_gradient;
                for side in 0..3 {
                    self.add(face, side, normal);
                }
            }
            SegmentHost::Edge(edge, [from, to]) => {
                let halfedges = self.mesh.edge_halfedges(edge);
                let nonmanifold = halfedges.len() > 2;
                for &h in halfedges {
                    // Up to two faces share one vector: it is added once, from the reference face. Of more faces, each
                    // gets its own share, by its own winding.
                    if !nonmanifold && h.face() != reference {
                        continue;
                    }
                    let length = self.triangles[h.face().index()].lengths[h.side()];
                    let along = if self.mesh.follows_edge(h) { to - from } else { from - to };
                    let normal = I * (along * length * to_gradient);
                    self.frames.add(self.mesh, &mut self.values, h, normal);
                }
            }
        }
    }

    /// The normals of a segment without sides: outward on both. In the faces that hold it, each side gets the normal of the
    /// side of the curve that it lies on, by the share of its length on the left less that on the right.
    ///
    /// Along an edge this is the rule of appendix A.2 (type A): the two other edges of each adjacent face get the outward
    /// normal, and on the edge itself both sides cancel.
    fn unsigned_segment(&mut self, segment: &Segment) {
        match segment.host {
            SegmentHost::Edge(edge, [from, to]) => {
                for &h in self.mesh.edge_halfedges(edge) {
                    let t = &self.triangles[h.face().index()];
                    let outward = I * t.directions()[h.side()] * ((to - from).abs() * t.lengths[h.side()]);
                    for side in (0..3).filter(|&k| k != h.side()) {
                        self.add(h.face(), side, outward);
                    }
                }
            }
            SegmentHost::Face(face, [from, to]) => {
                let t = self.triangles[face.index()];
                let (start, vector) = (t.point(from), t.point(to) - t.point(from));
                let left = I * vector;
                let height = t.corners().map(|c| dot(left, c - start));
                for side in 0..3 {
                    let (a, b) = (height[side], height[(side + 1) % 3]);
                    // Share of the side on the left of the segment's line less the share on its right.
                    let share = if a.abs() + b.abs() == 0.0 { 0.0 } else { (a + b) / (a.abs() + b.abs()) };
                    self.add(face, side, left * share);
                }
            }
        }
    }

    /// The half-disc of directions beyond the end of an unsigned curve (appendix A.2, type C), weighted by its last segment.
    fn cap(&mut self, segment: &Segment, end: usize) {
        let (face, weights) = match segment.host {
            SegmentHost::Face(face, weights) => (face, weights),
            SegmentHost::Edge(edge, t) => {
                let h = self.mesh.edge_halfedges(edge)[0];
                let weight = |t: f64| {
                    let t = if self.mesh.follows_edge(h) { t } else { 1.0 - t };
                    let mut w = [0.0; 3];
                    w[h.side()] = 1.0 - t;
                    w[(h.side() + 1) % 3] = t;
                    w
                };
                (h.face(), t.map(weight))
            }
        };
        let t = &self.triangles[face.index()];
        let back = t.point(weights[1 - end]) - t.point(weights[end]);
        let length = back.norm();
        let Some((wedges, total)) = self.star(segment.ends[end], Some((face, back.arg()))) else {
            return self.point(segment.ends[end], length);
        };
        // Angles around the point start in the direction back along the curve; the cap lies opposite.
        let (cap_begin, cap_end) = (0.25 * total, 0.75 * total);
        let mut passed = 0.0;
        for wedge in wedges {
            let begin = cap_begin.max(passed) - passed;
            let stop = cap_end.min(passed + wedge.angle) - passed;
            passed += wedge.angle;
            if stop > begin {
                self.wedge(
                    &Wedge { start: wedge.start + begin, angle: stop - begin, ..wedge },
                    length / (0.5 * total),
                );
            }
        }
    }

    /// A point (appendix A.1): unit vectors away from it in all directions.
    fn point(&mut self, point: Located, weight: f64) {
        if let Some((wedges, total)) = self.star(point, None) {
            for wedge in wedges {
                self.wedge(&wedge, weight / total);
            }
        }
    }

    /// The mean of the directions in a wedge (eq. 19).
    fn wedge(&mut self, wedge: &Wedge, weight: f64) {
        // The integral of exp(i a) from a to a + angle.
        let (from, to) = (wedge.start, wedge.start + wedge.angle);
        let vector = Complex { re: to.sin() - from.sin(), im: from.cos() - to.cos() } * weight;
        match wedge.side {
            Some(side) => self.add(wedge.face, side, vector),
            None => (0..3).for_each(|side| self.add(wedge.face, side, vector)),
        }
    }

    /// The directions around a point, counter-clockwise from the given direction where the faces around it form one fan;
    /// together with the total angle. `None` when a first direction is asked for but the faces form no fan.
    fn star(&self, point: Located, first: Option<(Face, f64)>) -> Option<(Vec<Wedge>, f64)> {
        let mut wedges = match point {
            Located::Vertex(v) => self.wedges_at_vertex(v, first.map(|f| f.0))?,
            Located::Edge(edge, t) => {
                let mut wedges = Vec::new();
                for &h in self.mesh.edge_halfedges(edge) {
                    let t = if self.mesh.follows_edge(h) { t } else { 1.0 - t };
                    let mut weights = [0.0; 3];
                    weights[h.side()] = 1.0 - t;
                    weights[(h.side() + 1) % 3] = t;
                    let sides = [(h.side() + 1) % 3, (h.side() + 2) % 3];
                    wedges.extend(self.wedges_inside(h.face(), weights, &sides));
                }
                wedges
            }
            Located::Face(face, weights) => self.wedges_inside(face, weights, &[0, 1, 2]),
        };
        let total: f64 = wedges.iter().map(|w| w.angle).sum();
        if let Some((face, direction)) = first {
            // Rotate the list so that it starts at the direction; the wedge that holds it is cut in two.
            let offset = |w: &Wedge| (direction - w.start).rem_euclid(TAU);
            let holds = |w: &Wedge| {
                let off = offset(w);
                w.face == face && (off <= w.angle + 1e-9 || off > TAU - 1e-9)
            };
            let i = wedges.iter().position(holds)?;
            wedges.rotate_left(i);
            let off = match offset(&wedges[0]) {
                off if off > TAU - 1e-9 => 0.0,
                off => off.min(wedges[0].angle),
            };
            let head = Wedge { angle: off, ..wedges[0] };
            wedges[0].start += off;
            wedges[0].angle -= off;
            wedges.push(head);
        }
        Some((wedges, total))
    }

    /// The directions from a point of a face towards some of its sides.
    fn wedges_inside(&self, face: Face, weights: [f64; 3], sides: &[usize]) -> Vec<Wedge> {
        let t = &self.triangles[face.index()];
        let (p, corners) = (t.point(weights), t.corners());
        sides
            .iter()
            .map(|&side| {
                let (a, b) = (corners[side] - p, corners[(side + 1) % 3] - p);
                Wedge { face, start: a.arg(), angle: (b * a.conj()).arg().clamp(0.0, PI), side: Some(side) }
            })
            .collect()
    }

    /// The corners at a vertex, counter-clockwise if they form one fan (from its clockwise end at a boundary), starting with `first` if
    /// the fan is closed; in file order if no order is asked for.
    fn wedges_at_vertex(&self, v: Vertex, first: Option<Face>) -> Option<Vec<Wedge>> {
        let corners = self.mesh.vertex_corners(v);
        let wedge = |h: Halfedge| {
            let t = &self.triangles[h.face().index()];
            let k = h.side();
            Wedge { face: h.face(), start: t.directions()[k].arg(), angle: t.angles[k].arg(), side: None }
        };
        if first.is_none() {
            return Some(corners.iter().map(|c| wedge(c.halfedge())).collect());
        }
        // Clockwise to the boundary or once round, then counter-clockwise.
        let start = corners.first()?.halfedge();
        let clockwise = |h: Halfedge| match self.mesh.neighbour(h) {
            Neighbour::Twin(twin) if self.mesh.tip(twin) == v => Some(twin.next()),
            _ => None,
        };
        let counter_clockwise = |h: Halfedge| match self.mesh.neighbour(h.previous()) {
            Neighbour::Twin(twin) if self.mesh.origin(twin) == v => Some(twin),
            _ => None,
        };
        let mut begin = start;
        for _ in 0..corners.len() {
            match clockwise(begin) {
                Some(next) if next != start => begin = next,
                _ => break,
            }
        }
        let mut fan = vec![begin];
        while let Some(next) = counter_clockwise(fan[fan.len() - 1]) {
            if next == begin || fan.len() >= corners.len() {
                break;
            }
            fan.push(next);
        }
        (fan.len() == corners.len()).then(|| fan.into_iter().map(wedge).collect())
    }
}

#[inline]
fn dot(a: Complex, b: Complex) -> f64 {
    a.re * b.re + a.im * b.im
}
