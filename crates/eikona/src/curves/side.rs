//! The left side of curves, also on surfaces without a consistent orientation.

use crate::Warning;
use crate::geometry::vector::{cross, dot, sub, unit};
use eikona_mesh::{
    CurveKind, Edge, Face, Halfedge, Located, Orientation, Segment, SegmentHost, SurfaceCurves, TriangleMesh,
    Vertex, VertexFan,
};
use std::collections::HashMap;

/// For each segment, a face that it touches and a sign: +1 if left is left by the orientation of
/// that face, else -1.
pub(crate) struct SideOfSegments {
    sides: Vec<Side>,
}

/// The left side of one segment.
#[derive(Clone, Copy)]
struct Side {
    face: Face,
    upside: f64,
    /// For a segment along an edge of three or more faces, the normal from whose tip left is seen.
    up: Option<[f64; 3]>,
}

impl SideOfSegments {
    /// Determines the sides of all segments. On a `consistent` mesh they follow the faces.
    /// Otherwise the side is transported from the first segment of each curve to its last, from
    /// face to face around the nodes; along edges of three or more faces, and on from there, by
    /// normals. Where no chain of faces connects two consecutive segments, the sign is kept. Warns
    /// of closed curves that come back reversed.
    pub fn of(
        mesh: &TriangleMesh,
        consistent: bool,
        input: &SurfaceCurves,
        segments: &[Segment],
        warnings: &mut Vec<Warning>,
    ) -> SideOfSegments {
        let mut sides: Vec<Side> = Vec::with_capacity(segments.len());
        let mut fans = Fans::new(mesh, consistent);
        let mut first = 0;
        for (i, segment) in segments.iter().enumerate() {
            let before =
                if i > 0 && segments[i - 1].curve == segment.curve { Some(sides[i - 1]) } else { None };
            if before.is_none() {
                first = i;
            }
            let up = input.curves[segment.curve].up;
            sides.push(fans.side(segment, before, up, warnings));
            let last = segments.get(i + 1).is_none_or(|next| next.curve != segment.curve);
            if last && i > first && segment.ends[1] == segments[first].ends[0] {
                let back = fans.side(&segments[first], Some(sides[i]), None, &mut Vec::new());
                let signed = input.curves[segment.curve].kind == CurveKind::Signed;
                if signed && !back.agrees(&sides[first]) {
                    warnings.push(Warning::OneSidedCurve { curve: segment.curve });
                }
            }
        }
        SideOfSegments { sides }
    }

    /// Returns face and sign of a segment.
    pub fn of_segment(&self, i: usize) -> (Face, f64) {
        (self.sides[i].face, self.sides[i].upside)
    }

    /// Returns +1 if the face of a halfedge lies on the left of a segment along its edge, which has
    /// three or more faces, else -1.
    pub fn of_sheet(&self, mesh: &TriangleMesh, i: usize, segment: &Segment, h: Halfedge) -> f64 {
        let up = self.sides[i].up.expect("the segment runs along an edge of three or more faces");
        Seam::of(mesh, mesh.edge(h), segment).side(h, up)
    }
}

impl Side {
    fn agrees(&self, other: &Side) -> bool {
        match (self.up, other.up) {
            (Some(a), Some(b)) => dot(a, b) > 0.0,
            _ => self.upside == other.upside,
        }
    }

    /// Returns the normal from whose tip left is seen.
    fn normal(&self, mesh: &TriangleMesh) -> [f64; 3] {
        self.up.unwrap_or_else(|| face_normal(mesh, self.face).map(|x| self.upside * x))
    }
}

fn host_face(mesh: &TriangleMesh, segment: &Segment) -> Face {
    match segment.host {
        SegmentHost::Face(face, _) => face,
        SegmentHost::Edge(edge, _) => mesh.edge_halfedges(edge)[0].face(),
    }
}

fn face_normal(mesh: &TriangleMesh, face: Face) -> [f64; 3] {
    let [a, b, c] = mesh.face_positions(face);
    unit(cross(unit(sub(b, a)), unit(sub(c, a))))
}

/// Returns +1 if the face's orientation agrees with `up`, else -1.
fn seen_from(mesh: &TriangleMesh, face: Face, up: [f64; 3]) -> f64 {
    if dot(up, face_normal(mesh, face)) < 0.0 { -1.0 } else { 1.0 }
}

/// A segment along an edge of three or more faces, and the sheets that meet there.
struct Seam<'a> {
    mesh: &'a TriangleMesh,
    edge: Edge,
    /// The direction of the segment.
    along: [f64; 3],
}

impl Seam<'_> {
    fn of<'a>(mesh: &'a TriangleMesh, edge: Edge, segment: &Segment) -> Seam<'a> {
        let [p, q] = segment.ends.map(|end| end.position(mesh));
        Seam { mesh, edge, along: unit(sub(q, p)) }
    }

    /// Returns the direction into the sheet of a halfedge, perpendicular to the seam.
    fn into(&self, h: Halfedge) -> [f64; 3] {
        let [a, apex] = [self.mesh.origin(h), self.mesh.origin(h.previous())].map(|v| self.mesh.position(v));
        unit(self.across(unit(sub(apex, a))))
    }

    fn across(&self, a: [f64; 3]) -> [f64; 3] {
        let part = dot(a, self.along);
        [0, 1, 2].map(|k| a[k] - part * self.along[k])
    }

    /// Returns +1 for sheets on the left, seen from the tip of `up`, else -1. Sheets that point
    /// neither left nor right count as left if they rise towards `up`.
    fn side(&self, h: Halfedge, up: [f64; 3]) -> f64 {
        let into = self.into(h);
        let left = dot(into, cross(up, self.along));
        let decisive = if left.abs() > SQUARE { left } else { dot(into, up) };
        if decisive < 0.0 { -1.0 } else { 1.0 }
    }

    /// Returns the normal perpendicular to the seam that is nearest to a given one. If there is
    /// none, takes the normal of the two sheets that are most nearly coplanar, by the orientation
    /// of the first; the flag tells whether the second agrees.
    fn up(&self, wanted: [f64; 3]) -> ([f64; 3], bool) {
        let up = unit(self.across(wanted));
        if dot(up, wanted) > SQUARE * dot(wanted, wanted).sqrt() {
            return (up, true);
        }
        let halfedges = self.mesh.edge_halfedges(self.edge);
        let into: Vec<[f64; 3]> = halfedges.iter().map(|&h| self.into(h)).collect();
        let pairs = (0..into.len()).flat_map(|j| (0..j).map(move |i| (i, j)));
        let flattest = pairs.min_by(|a, b| dot(into[a.0], into[a.1]).total_cmp(&dot(into[b.0], into[b.1])));
        let Some((i, j)) = flattest else { return (up, true) };
        let runs_along = |h: Halfedge| {
            let [a, b] = [self.mesh.origin(h), self.mesh.tip(h)].map(|v| self.mesh.position(v));
            dot(sub(b, a), self.along) > 0.0
        };
        let [first, second] = [i, j].map(|i| runs_along(halfedges[i]));
        let to_left =
            [0, 1, 2].map(|k| if first { into[i][k] - into[j][k] } else { into[j][k] - into[i][k] });
        (unit(cross(self.along, to_left)), first != second)
    }

    /// Returns the normal for the same side as seen from the middle of the sheets on it, so that it
    /// follows them where the seam bends.
    fn settled(&self, up: [f64; 3]) -> [f64; 3] {
        let mut left = [0.0; 3];
        for &h in self.mesh.edge_halfedges(self.edge) {
            let (side, into) = (self.side(h, up), self.into(h));
            (0..3).for_each(|k| left[k] += side * into[k]);
        }
        let settled = cross(self.along, left);
        if dot(settled, up) > 0.0 { unit(settled) } else { up }
    }
}

/// Tolerance for sheets perpendicular to the normal, and for normals along the seam.
const SQUARE: f64 = 1e-6;

/// Relative orientation of faces at one place, transported through the faces there.
pub(crate) struct Fans<'a> {
    mesh: &'a TriangleMesh,
    /// Whether all faces are consistently oriented.
    consistent: bool,
    /// The faces around each vertex visited so far, in increasing order: each with its fan, and
    /// whether it is oriented like the first face of the fan.
    around: HashMap<Vertex, Vec<(Face, usize, bool)>>,
}

impl<'a> Fans<'a> {
    pub fn new(mesh: &'a TriangleMesh, consistent: bool) -> Self {
        Fans { mesh, consistent, around: HashMap::new() }
    }

    /// Returns +1 if two faces at a place are consistently oriented, -1 if oppositely, `None` if no
    /// chain of faces around it connects them (on an inconsistently oriented mesh).
    ///
    /// # Cost
    /// O(d log d) for the first pair at a vertex of d faces, then O(log d).
    pub fn relative_orientation(&mut self, from: Face, to: Face, at: Located) -> Option<f64> {
        if from == to || self.consistent {
            return Some(1.0);
        }
        let mesh = self.mesh;
        match at {
            Located::Face(..) => None,
            Located::Edge(edge, _) => {
                let halfedge = |f: Face| mesh.edge_halfedges(edge).iter().copied().find(|h| h.face() == f);
                let (a, b) = (halfedge(from)?, halfedge(to)?);
                Some(if mesh.follows_edge(a) == mesh.follows_edge(b) { -1.0 } else { 1.0 })
            }
            Located::Vertex(v) => {
                let faces = self.around.entry(v).or_insert_with(|| fans_around(mesh, v));
                let find = |f: Face| faces.binary_search_by_key(&f, |x| x.0).ok().map(|i| faces[i]);
                let (a, b) = (find(from)?, find(to)?);
                (a.1 == b.1).then(|| if a.2 == b.2 { 1.0 } else { -1.0 })
            }
        }
    }

    /// Returns the side of a segment from that of its predecessor, or of the first segment of a
    /// curve.
    fn side(
        &mut self,
        segment: &Segment,
        before: Option<Side>,
        up: Option<[f64; 3]>,
        warnings: &mut Vec<Warning>,
    ) -> Side {
        let mesh = self.mesh;
        let face = host_face(mesh, segment);
        if let SegmentHost::Edge(edge, _) = segment.host
            && mesh.edge_halfedges(edge).len() > 2
        {
            let seam = Seam::of(mesh, edge, segment);
            let wanted = before.map(|b| b.normal(mesh)).or(up).unwrap_or_default();
            let (found, is_determined) = seam.up(wanted);
            if !is_determined && before.is_none() {
                warnings.push(Warning::UndeterminedSide { curve: segment.curve });
            }
            return Side { face, upside: seen_from(mesh, face, found), up: Some(seam.settled(found)) };
        }
        let upside = match before {
            None => up.map_or(1.0, |up| seen_from(mesh, face, up)),
            Some(before) => match before.up {
                Some(up) => seen_from(mesh, face, up),
                None => {
                    before.upside
                        * self.relative_orientation(before.face, face, segment.ends[0]).unwrap_or(1.0)
                }
            },
        };
        Side { face, upside, up: None }
    }
}

/// Returns the faces around a vertex, sorted: each with the number of its fan, and whether it is
/// oriented like the first face of the fan.
fn fans_around(mesh: &TriangleMesh, v: Vertex) -> Vec<(Face, usize, bool)> {
    let mut faces = Vec::new();
    for (number, fan) in VertexFan::all(mesh, v).into_iter().enumerate() {
        let corners = fan.corners.into_iter().zip(fan.agrees);
        faces.extend(corners.map(|(corner, agrees)| (corner.face(), number, agrees)));
    }
    faces.sort_unstable_by_key(|x| x.0);
    faces
}

/// Returns the mesh with the smaller part of each orientable patch flipped where it is
/// inconsistently oriented.
pub(crate) fn consistently_oriented(mesh: &TriangleMesh, warnings: &mut Vec<Warning>) -> TriangleMesh {
    if mesh.is_consistently_oriented() {
        return mesh.clone();
    }
    let orientation = Orientation::of(mesh);
    let flipped = orientation.flipped_faces().len();
    if !orientation.is_orientable() {
        warnings.push(Warning::NotOrientable);
    }
    if flipped == 0 {
        return mesh.clone();
    }
    warnings.push(Warning::FacesFlipped { count: flipped });
    orientation.oriented(mesh)
}
