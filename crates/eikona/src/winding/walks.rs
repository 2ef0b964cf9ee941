//! Curves as walks along edges, the form in which all steps use them.

use crate::cut::EmbeddedCurve;
use eikona_mesh::{Curve, Located, Segment, SurfaceCurves, TriangleMesh, segment_host};

/// Returns the segments of walks along edges.
pub(super) fn segments_of(mesh: &TriangleMesh, walks: &[EmbeddedCurve]) -> Vec<Segment> {
    let mut segments = Vec::new();
    for (curve, walk) in walks.iter().enumerate() {
        for (node, ends) in walk.vertices.windows(2).enumerate() {
            let ends = [Located::Vertex(ends[0]), Located::Vertex(ends[1])];
            if let Some(host) = segment_host(mesh, ends[0], ends[1]) {
                segments.push(Segment { curve, node, ends, host });
            }
        }
    }
    segments
}

/// Returns walks as curves through their vertices.
pub(super) fn curves_of(walks: &[EmbeddedCurve]) -> SurfaceCurves {
    let curve = |walk: &EmbeddedCurve| {
        let nodes = walk.vertices.iter().map(|&v| v.into()).collect();
        Curve { kind: walk.kind, up: walk.up, nodes }
    };
    SurfaceCurves { curves: walks.iter().map(curve).collect(), points: Vec::new() }
}

/// Converts curves along edges to walks.
pub(super) fn walks_of(curves: &SurfaceCurves, segments: &[Segment]) -> Vec<EmbeddedCurve> {
    let mut walks: Vec<EmbeddedCurve> = curves
        .curves
        .iter()
        .map(|c| EmbeddedCurve { kind: c.kind, up: c.up, vertices: Vec::new(), segments: Vec::new() })
        .collect();
    for segment in segments {
        let [Located::Vertex(from), Located::Vertex(to)] = segment.ends else { continue };
        let walk = &mut walks[segment.curve];
        if walk.vertices.is_empty() {
            walk.vertices.push(from);
        }
        walk.vertices.push(to);
        walk.segments.push(segment.node);
    }
    walks
}
