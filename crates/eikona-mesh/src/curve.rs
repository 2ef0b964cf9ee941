//! Curves and isolated points on a surface: the one form in which every method takes them and gives
//! them back.

use crate::error::CurveError;
use crate::id::{Edge, Face};
use crate::mesh::TriangleMesh;
use crate::point::{Located, SurfacePoint};
use serde::{Deserialize, Serialize};

/// Whether the sides of a curve are told apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CurveKind {
    /// Oriented: left and right of its direction differ.
    #[default]
    Signed,
    /// Not oriented: distance grows away from it on both sides.
    Unsigned,
}

/// A polyline on a surface. It is closed if its last node is its first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Curve {
    /// Oriented or not.
    #[serde(default)]
    pub kind: CurveKind,
    /// The corners of the polyline. Methods want consecutive nodes in one (closed) face; tracing
    /// makes them so.
    pub nodes: Vec<SurfacePoint>,
    /// A surface normal at the first segment, from whose side "left" is seen. Without it, the
    /// winding of the faces tells. On a surface without a consistent orientation the choice is
    /// carried along the curve from its first segment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<[f64; 3]>,
}

impl Curve {
    /// An oriented curve through these points.
    pub fn signed(nodes: impl IntoIterator<Item = impl Into<SurfacePoint>>) -> Curve {
        Curve { kind: CurveKind::Signed, nodes: nodes.into_iter().map(Into::into).collect(), up: None }
    }
    /// A curve without sides through these points.
    pub fn unsigned(nodes: impl IntoIterator<Item = impl Into<SurfacePoint>>) -> Curve {
        Curve { kind: CurveKind::Unsigned, ..Curve::signed(nodes) }
    }
    /// The same curve in the opposite direction.
    pub fn reversed(mut self) -> Curve {
        self.nodes.reverse();
        self
    }
    /// Whether the last node is the first.
    pub fn is_closed(&self) -> bool {
        self.nodes.len() > 2 && self.nodes.first() == self.nodes.last()
    }
}

/// Curves and isolated points on one surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceCurves {
    /// The curves, signed and unsigned.
    pub curves: Vec<Curve>,
    /// Isolated points (always unsigned).
    pub points: Vec<SurfacePoint>,
}

/// The element that a segment lies in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SegmentHost {
    /// Along an edge, from parameter `t[0]` to `t[1]` in the edge's own direction.
    Edge(Edge, [f64; 2]),
    /// Through a face, between these weights of its corners.
    Face(Face, [[f64; 3]; 2]),
}

/// A piece of a curve inside one edge or one face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// 0-based index of its curve.
    pub curve: usize,
    /// 0-based index of its first node in the curve.
    pub node: usize,
    /// Its two ends.
    pub ends: [Located; 2],
    /// Where it lies.
    pub host: SegmentHost,
}

impl SurfaceCurves {
    /// One curve, no points.
    pub fn from_curve(curve: Curve) -> Self {
        SurfaceCurves { curves: vec![curve], points: Vec::new() }
    }
    /// One isolated point.
    pub fn from_point(point: impl Into<SurfacePoint>) -> Self {
        SurfaceCurves { curves: Vec::new(), points: vec![point.into()] }
    }
    /// Whether there is neither a curve nor a point.
    pub fn is_empty(&self) -> bool {
        self.curves.is_empty() && self.points.is_empty()
    }
    /// Number of segments of all curves.
    pub fn segment_count(&self) -> usize {
        self.curves.iter().map(|c| c.nodes.len().saturating_sub(1)).sum()
    }

    /// All curves cut into their segments, each with the edge or face that it lies in; zero-length
    /// segments are left out.
    ///
    /// # Errors
    /// The first fault with curve and node: fewer than two nodes, an element that does not exist,
    /// weights out of range, or [`CurveError::SegmentAcrossFaces`] where a segment leaves its face.
    pub fn segments(&self, mesh: &TriangleMesh) -> Result<Vec<Segment>, CurveError> {
        let mut segments = Vec::with_capacity(self.segment_count());
        for (c, curve) in self.curves.iter().enumerate() {
            if curve.nodes.len() < 2 {
                return Err(CurveError::TooFewNodes { curve: c, nodes: curve.nodes.len() });
            }
            let before = segments.len();
            let mut previous: Option<Located> = None;
            for (n, node) in curve.nodes.iter().enumerate() {
                let here = node.locate(mesh).map_err(|e| e.at(c, n))?;
                if let Some(from) = previous
                    && from != here
                {
                    let host = segment_host(mesh, from, here)
                        .ok_or_else(|| CurveError::SegmentAcrossFaces.at(c, n - 1))?;
                    segments.push(Segment { curve: c, node: n - 1, ends: [from, here], host });
                }
                previous = Some(here);
            }
            if segments.len() == before {
                return Err(CurveError::ZeroLength { curve: c });
            }
        }
        Ok(segments)
    }

    /// The isolated points, looked up.
    ///
    /// # Errors
    /// The first fault with the index of the point.
    pub fn located_points(&self, mesh: &TriangleMesh) -> Result<Vec<Located>, CurveError> {
        self.points.iter().enumerate().map(|(i, p)| p.locate(mesh).map_err(|e| e.at_point(i))).collect()
    }
}

/// The edge, or else the first face, that holds both points.
pub fn segment_host(mesh: &TriangleMesh, from: Located, to: Located) -> Option<SegmentHost> {
    if let Some(edge) = common_edge(mesh, from, to) {
        let t = |p: Located| match p {
            Located::Edge(_, t) => t,
            Located::Vertex(v) if v == mesh.edge_vertices(edge)[0] => 0.0,
            _ => 1.0,
        };
        return Some(SegmentHost::Edge(edge, [t(from), t(to)]));
    }
    let candidates = from.faces(mesh);
    candidates.into_iter().find_map(|f| {
        Some(SegmentHost::Face(f, [from.weights_in_face(mesh, f)?, to.weights_in_face(mesh, f)?]))
    })
}

fn common_edge(mesh: &TriangleMesh, from: Located, to: Located) -> Option<Edge> {
    match (from, to) {
        (Located::Vertex(a), Located::Vertex(b)) => mesh.find_edge(a, b),
        (Located::Vertex(v), Located::Edge(e, _)) | (Located::Edge(e, _), Located::Vertex(v)) => {
            mesh.edge_vertices(e).contains(&v).then_some(e)
        }
        (Located::Edge(a, _), Located::Edge(b, _)) => (a == b).then_some(a),
        _ => None,
    }
}
