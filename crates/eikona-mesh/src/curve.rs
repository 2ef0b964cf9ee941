//! Curves and isolated points on a surface, in the one representation that all methods take and
//! return.

use crate::error::CurveError;
use crate::id::{Edge, Face};
use crate::mesh::TriangleMesh;
use crate::point::{Located, SurfacePoint};
use serde::{Deserialize, Serialize};

/// Whether the two sides of a curve are distinguished.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CurveKind {
    /// Oriented: left and right of its direction differ.
    #[default]
    Signed,
    /// Not oriented: distance grows away from it on both sides.
    Unsigned,
}

/// A polyline on a surface. It is closed if its last node equals its first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Curve {
    /// Whether the curve is oriented.
    #[serde(default)]
    pub kind: CurveKind,
    /// The vertices of the polyline. Methods require consecutive nodes to share a (closed) face;
    /// tracing ensures this.
    pub nodes: Vec<SurfacePoint>,
    /// A surface normal at the first segment; "left" is as seen from its side. Without it, left is
    /// taken from the orientation of the faces. On a surface without a consistent orientation the
    /// side is transported along the curve from its first segment.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<[f64; 3]>,
}

impl Curve {
    /// Creates an oriented curve through these points.
    pub fn signed(nodes: impl IntoIterator<Item = impl Into<SurfacePoint>>) -> Curve {
        Curve { kind: CurveKind::Signed, nodes: nodes.into_iter().map(Into::into).collect(), up: None }
    }
    /// Creates an unoriented curve through these points.
    pub fn unsigned(nodes: impl IntoIterator<Item = impl Into<SurfacePoint>>) -> Curve {
        Curve { kind: CurveKind::Unsigned, ..Curve::signed(nodes) }
    }
    /// Reverses the direction of the curve.
    pub fn reversed(mut self) -> Curve {
        self.nodes.reverse();
        self
    }
    /// Returns whether the last node equals the first.
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

/// The element that contains a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SegmentHost {
    /// On an edge, from parameter `t[0]` to `t[1]` in the edge's own direction.
    Edge(Edge, [f64; 2]),
    /// In a face, between these barycentric weights.
    Face(Face, [[f64; 3]; 2]),
}

/// A straight piece of a curve, inside one edge or one face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// 0-based index of the curve.
    pub curve: usize,
    /// 0-based index of the segment's first node in the curve.
    pub node: usize,
    /// The two ends.
    pub ends: [Located; 2],
    /// The element that contains the segment.
    pub host: SegmentHost,
}

impl SurfaceCurves {
    /// Creates a set of one curve and no points.
    pub fn from_curve(curve: Curve) -> Self {
        SurfaceCurves { curves: vec![curve], points: Vec::new() }
    }
    /// Creates a set of one isolated point.
    pub fn from_point(point: impl Into<SurfacePoint>) -> Self {
        SurfaceCurves { curves: Vec::new(), points: vec![point.into()] }
    }
    /// Returns whether there is neither a curve nor a point.
    pub fn is_empty(&self) -> bool {
        self.curves.is_empty() && self.points.is_empty()
    }
    /// Returns the number of segments of all curves.
    pub fn segment_count(&self) -> usize {
        self.curves.iter().map(|c| c.nodes.len().saturating_sub(1)).sum()
    }

    /// Splits all curves into segments, each with the edge or face that contains it. Omits
    /// zero-length segments.
    ///
    /// # Errors
    /// The first fault, with curve and node: fewer than two nodes, an element that does not exist,
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

    /// Locates the isolated points.
    ///
    /// # Errors
    /// The first fault, with the index of the point.
    pub fn located_points(&self, mesh: &TriangleMesh) -> Result<Vec<Located>, CurveError> {
        self.points.iter().enumerate().map(|(i, p)| p.locate(mesh).map_err(|e| e.at_point(i))).collect()
    }
}

/// Returns the edge, or else the first face, that contains both points.
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
