//! Which side of a curve is left: faces wound alike, and segments that see which way the face beside them is wound.

use crate::geometry::vector::{cross, dot, sub};
use crate::geometry::winding_is_consistent;
use crate::wording::counted;
use eikona_mesh::{
    CurveKind, Face, Located, Neighbour, Orientation, Segment, SegmentHost, SurfaceCurves, TriangleMesh,
    Vertex,
};
use std::collections::{HashSet, VecDeque};

/// For each segment a face that it touches, and +1 or -1: whether left is left in the winding of that face.
pub(crate) struct SideOfSegments {
    sides: Vec<(Face, f64)>,
}

impl SideOfSegments {
    /// On a mesh of `consistent` winding left is left. Else carries the side from the first segment of each curve to its last:
    /// left stays left where two consecutive segments see no chain of faces between them, and a warning tells of a closed curve
    /// that comes back reversed.
    pub fn of(
        mesh: &TriangleMesh,
        consistent: bool,
        input: &SurfaceCurves,
        segments: &[Segment],
        warnings: &mut Vec<String>,
    ) -> SideOfSegments {
        let mut sides: Vec<(Face, f64)> = Vec::with_capacity(segments.len());
        let mut first_of_curve = 0;
        for (i, segment) in segments.iter().enumerate() {
            let face = host_face(mesh, segment);
            if i == 0 || segments[i - 1].curve != segment.curve {
                first_of_curve = i;
                sides.push((face, first_side(mesh, face, input.curves[segment.curve].up)));
                continue;
            }
            let (before, side) = sides[i - 1];
            let turn = if consistent {
                1.0
            } else {
                relative_winding(mesh, before, face, segment.ends[0]).unwrap_or(1.0)
            };
            sides.push((face, side * turn));
            let last = !consistent && segments.get(i + 1).is_none_or(|next| next.curve != segment.curve);
            if last && segment.ends[1] == segments[first_of_curve].ends[0] {
                let (first_face, first_side) = sides[first_of_curve];
                let back = relative_winding(mesh, face, first_face, segment.ends[1]).unwrap_or(1.0);
                let signed = input.curves[segment.curve].kind == CurveKind::Signed;
                if signed && side * turn * back != first_side {
                    warnings.push(format!(
                        "curve {} is one-sided: going once round it, left becomes right; the sides change at its first node",
                        segment.curve
                    ));
                }
            }
        }
        SideOfSegments { sides }
    }

    /// Face and sign of a segment.
    pub fn of_segment(&self, i: usize) -> (Face, f64) {
        self.sides[i]
    }
}

fn host_face(mesh: &TriangleMesh, segment: &Segment) -> Face {
    match segment.host {
        SegmentHost::Face(face, _) => face,
        SegmentHost::Edge(edge, _) => mesh.edge_halfedges(edge)[0].face(),
    }
}

/// +1 when left is left in the winding of the face: always, unless the wanted normal says otherwise.
fn first_side(mesh: &TriangleMesh, face: Face, up: Option<[f64; 3]>) -> f64 {
    let Some(up) = up else { return 1.0 };
    let [a, b, c] = mesh.face_positions(face);
    if dot(up, cross(sub(b, a), sub(c, a))) < 0.0 { -1.0 } else { 1.0 }
}

/// +1 when two faces at a point have the same winding, -1 when opposite, `None` when no chain of faces around the point joins them.
fn relative_winding(mesh: &TriangleMesh, from: Face, to: Face, at: Located) -> Option<f64> {
    if from == to {
        return Some(1.0);
    }
    match at {
        Located::Face(..) => None,
        Located::Edge(edge, _) => {
            let halfedge = |f: Face| mesh.edge_halfedges(edge).iter().copied().find(|h| h.face() == f);
            let (a, b) = (halfedge(from)?, halfedge(to)?);
            Some(if mesh.follows_edge(a) == mesh.follows_edge(b) { -1.0 } else { 1.0 })
        }
        Located::Vertex(v) => relative_winding_around(mesh, from, to, v),
    }
}

/// # Cost
/// Linear in the number of faces around the vertex.
fn relative_winding_around(mesh: &TriangleMesh, from: Face, to: Face, v: Vertex) -> Option<f64> {
    let mut seen = HashSet::from([from]);
    let mut waiting = VecDeque::from([(from, 1.0)]);
    while let Some((face, side)) = waiting.pop_front() {
        let at_vertex = (0..3).map(|k| face.halfedge(k)).filter(|&h| mesh.origin(h) == v || mesh.tip(h) == v);
        for h in at_vertex {
            let Neighbour::Twin(other) = mesh.neighbour(h) else { continue };
            let turn = if mesh.follows_edge(h) == mesh.follows_edge(other) { -1.0 } else { 1.0 };
            if other.face() == to {
                return Some(side * turn);
            }
            if seen.insert(other.face()) {
                waiting.push_back((other.face(), side * turn));
            }
        }
    }
    None
}

/// The mesh itself if its winding is consistent; else with the smaller part of each orientable patch turned over.
pub(crate) fn consistently_wound(mesh: &TriangleMesh, warnings: &mut Vec<String>) -> TriangleMesh {
    if winding_is_consistent(mesh) {
        return mesh.clone();
    }
    let orientation = Orientation::of(mesh);
    let flipped = orientation.flipped_faces().len();
    if !orientation.is_orientable() {
        warnings.push(
            "the surface has no consistent orientation: left is told by the winding of the first face that a curve touches, \
             or by its `up`, and carried along the curve"
                .into(),
        );
    }
    if flipped == 0 {
        return mesh.clone();
    }
    warnings.push(format!(
        "{} turned over to make the winding consistent",
        counted(flipped, "face was", "faces were")
    ));
    mesh.with_flipped_faces(|f| orientation.sign_of_face[f] < 0)
}
