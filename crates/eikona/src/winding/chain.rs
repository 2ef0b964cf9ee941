//! The curve as a dual 1-chain: the jump of the function between the two faces of each edge.

use crate::Warning;
use crate::curves::side::SideOfSegments;
use crate::cut::EmbeddedCurve;
use crate::winding::error::WindingError;
use crate::winding::walks::{curves_of, segments_of};
use eikona_mesh::{Edge, Segment, SegmentHost, TriangleMesh, Vertex};

/// A dual 1-chain: per edge of two faces, the value in the face of its first halfedge minus the
/// value in the face of its second. All steps of the method work on such chains, so that left and
/// right, and with them the orientation of the surface, matter only where a curve is read.
#[derive(Clone, Debug)]
pub(crate) struct Chain {
    /// The jump at each edge; 0 at edges that have one face, or more than two.
    pub jump: Vec<i32>,
    /// Edges that the input traverses equally often in both directions, so that the steps cancel.
    pub cancelled: usize,
    /// Steps of the input along boundary edges, where no jump is possible.
    pub on_boundary: usize,
    /// Steps of the input along edges of three or more faces, where left and right are not defined.
    pub on_nonmanifold: usize,
}

/// One step of an input curve along an edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub curve: usize,
    /// 0-based index among the steps of its curve.
    pub step: usize,
    pub edge: Edge,
    pub ends: [Vertex; 2],
    /// Its contribution to the jump of the edge: left is one higher than right.
    pub jump: i32,
}

impl Chain {
    /// Builds the chain of walks, and lists their steps.
    ///
    /// # Errors
    /// [`WindingError::Multiplicity`].
    pub fn of(
        mesh: &TriangleMesh,
        consistent: bool,
        walks: &[EmbeddedCurve],
        warnings: &mut Vec<Warning>,
    ) -> Result<(Chain, Vec<Step>), WindingError> {
        let segments = segments_of(mesh, walks);
        let sides = SideOfSegments::of(mesh, consistent, &curves_of(walks), &segments, warnings);
        let mut chain =
            Chain { jump: vec![0; mesh.edge_count()], cancelled: 0, on_boundary: 0, on_nonmanifold: 0 };
        let mut steps: Vec<Step> = Vec::with_capacity(segments.len());
        for (i, segment) in segments.iter().enumerate() {
            let Some((edge, forward)) = along_edge(segment) else { continue };
            let [a, b] = mesh.edge_vertices(edge);
            let ends = if forward { [a, b] } else { [b, a] };
            let curve = segment.curve;
            let number = steps.last().filter(|s| s.curve == curve).map_or(0, |s| s.step + 1);
            let step = |jump| Step { curve, step: number, edge, ends, jump };
            let &[first, _] = mesh.edge_halfedges(edge) else {
                let is_boundary = mesh.is_boundary_edge(edge);
                *(if is_boundary { &mut chain.on_boundary } else { &mut chain.on_nonmanifold }) += 1;
                steps.push(step(0));
                continue;
            };
            // The side refers to the face of the first halfedge. That face lies on the left of the
            // segment if the halfedge and the segment run the same way.
            let (face, side) = sides.of_segment(i);
            debug_assert_eq!(face, first.face());
            let along = if mesh.follows_edge(first) == forward { 1 } else { -1 };
            let jump = if side < 0.0 { -along } else { along };
            chain.jump[edge.index()] += jump;
            steps.push(step(jump));
        }
        if let Some(edge) = mesh.edges().find(|e| chain.jump[e.index()].abs() > MAX_COPIES) {
            let vertices = mesh.edge_vertices(edge);
            return Err(WindingError::Multiplicity { edge, vertices, most: MAX_COPIES });
        }
        let mut touched: Vec<Edge> = steps.iter().filter(|s| s.jump != 0).map(|s| s.edge).collect();
        touched.sort_unstable();
        touched.dedup();
        chain.cancelled = touched.iter().filter(|e| chain.jump[e.index()] == 0).count();
        Ok((chain, steps))
    }
}

/// Returns the edge that a segment covers, and whether it runs in the edge's direction.
pub(crate) fn along_edge(segment: &Segment) -> Option<(Edge, bool)> {
    match segment.host {
        SegmentHost::Edge(edge, [0.0, 1.0]) => Some((edge, true)),
        SegmentHost::Edge(edge, [1.0, 0.0]) => Some((edge, false)),
        _ => None,
    }
}

/// Largest accepted multiplicity of an edge: labels are small integers, and more is a mistake in
/// the input.
const MAX_COPIES: i32 = 1_000_000;
