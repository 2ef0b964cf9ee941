//! The curve as jumps: by how much a function changes from one face at an edge to the other.

use crate::contour::side::SideOfSegments;
use crate::winding::error::WindingError;
use eikona_mesh::{
    CurveKind, Edge, Face, Neighbour, Segment, SegmentHost, SurfaceCurves, TriangleMesh, Vertex,
};

/// A dual 1-chain: for every edge of two faces the value in the face of its first halfedge minus the value in the face of its
/// second. All steps of the method work on such chains, so that left and right, and with them the orientation of the
/// surface, matter only where a curve is read.
#[derive(Clone, Debug)]
pub(crate) struct Chain {
    /// The jump at each edge; 0 at edges that have one face, or more than two.
    pub jump: Vec<i32>,
    /// Edges of the input that cancel: walked in both directions equally often.
    pub cancelled: usize,
    /// Steps of the input along boundary edges, where nothing can jump.
    pub on_boundary: usize,
    /// Steps of the input along edges of three or more faces, where left and right are not defined.
    pub on_nonmanifold: usize,
}

/// One step of an input curve along an edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub curve: usize,
    pub edge: Edge,
    /// What it adds to the jump of the edge: left is one higher than right.
    pub jump: i32,
}

impl Chain {
    /// Of curves along whole edges of a mesh.
    ///
    /// # Errors
    /// [`WindingError::Curve`] for curves that are not on the mesh, [`WindingError::NotAlongEdges`] for segments that are no
    /// whole edges, [`WindingError::Unsigned`], [`WindingError::Multiplicity`].
    pub fn of(
        mesh: &TriangleMesh,
        consistent: bool,
        curves: &SurfaceCurves,
        warnings: &mut Vec<String>,
    ) -> Result<(Chain, Vec<Step>), WindingError> {
        if let Some(curve) = curves.curves.iter().position(|c| c.kind == CurveKind::Unsigned) {
            return Err(WindingError::Unsigned { curve });
        }
        let segments = curves.segments(mesh)?;
        let sides = SideOfSegments::of(mesh, consistent, curves, &segments, warnings);
        let mut chain =
            Chain { jump: vec![0; mesh.edge_count()], cancelled: 0, on_boundary: 0, on_nonmanifold: 0 };
        let mut steps = Vec::with_capacity(segments.len());
        for (i, segment) in segments.iter().enumerate() {
            let (edge, forward) = along_edge(segment)
                .ok_or(WindingError::NotAlongEdges { curve: segment.curve, node: segment.node })?;
            let &[first, _] = mesh.edge_halfedges(edge) else {
                let is_boundary = mesh.edge_halfedges(edge).len() == 1;
                *(if is_boundary { &mut chain.on_boundary } else { &mut chain.on_nonmanifold }) += 1;
                steps.push(Step { curve: segment.curve, edge, jump: 0 });
                continue;
            };
            // The side is that of the face of the first halfedge, which has it on its left if both run the same way.
            let (face, side) = sides.of_segment(i);
            debug_assert_eq!(face, first.face());
            let along = if mesh.follows_edge(first) == forward { 1 } else { -1 };
            let jump = if side < 0.0 { -along } else { along };
            let sum = &mut chain.jump[edge.index()];
            *sum += jump;
            if sum.abs() > MOST_COPIES {
                return Err(WindingError::Multiplicity { edge, most: MOST_COPIES });
            }
            steps.push(Step { curve: segment.curve, edge, jump });
        }
        let mut touched: Vec<Edge> = steps.iter().filter(|s| s.jump != 0).map(|s| s.edge).collect();
        touched.sort_unstable();
        touched.dedup();
        chain.cancelled = touched.iter().filter(|e| chain.jump[e.index()] == 0).count();
        Ok((chain, steps))
    }
}

/// The edge that a segment is the whole of, and whether it runs in the direction of the edge.
pub(crate) fn along_edge(segment: &Segment) -> Option<(Edge, bool)> {
    match segment.host {
        SegmentHost::Edge(edge, [0.0, 1.0]) => Some((edge, true)),
        SegmentHost::Edge(edge, [1.0, 0.0]) => Some((edge, false)),
        _ => None,
    }
}

/// A curve that walks an edge more often is refused: labels are small integers, and more is a mistake of the input.
const MOST_COPIES: i32 = 1_000_000;

/// What one crosses in a walk around a vertex.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    pub edge: Edge,
    /// From the face of the edge's first halfedge into that of its second.
    pub forward: bool,
}

impl Crossing {
    /// By how much a function with these jumps changes when this is crossed.
    #[inline]
    pub fn change<T: Copy + std::ops::Neg<Output = T>>(self, jump: &[T]) -> T {
        let jump = jump[self.edge.index()];
        if self.forward { -jump } else { jump }
    }
}

/// The corners around a vertex, one after the other, with what is crossed before each.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fan {
    /// Indices of corners (3 f + k).
    pub corners: Vec<usize>,
    /// `crossings[i]` lies between corner `i` and the next; in a closed fan the last one leads back to the first.
    pub crossings: Vec<Crossing>,
    pub closed: bool,
}

impl Fan {
    /// Walks around a vertex, from one boundary edge to the other if there are such. `false` if its faces are more than one fan,
    /// or meet at an edge of three faces, or if it has no faces.
    pub fn walk(&mut self, mesh: &TriangleMesh, v: Vertex) -> bool {
        self.corners.clear();
        self.crossings.clear();
        self.closed = false;
        let corners = mesh.vertex_corners(v);
        // The halfedges of a corner's face that meet there: (from the corner, to the corner).
        let sides = |corner: usize| {
            let (face, k) = (Face((corner / 3) as u32), corner % 3);
            (face.halfedge(k), face.halfedge((k + 2) % 3))
        };
        let at_rim = corners.iter().map(|c| c.index()).find_map(|c| {
            let (out, back) = sides(c);
            let is_rim = |h| matches!(mesh.neighbour(h), Neighbour::Boundary);
            // Leave by the other side.
            if is_rim(out) { Some((c, back)) } else { is_rim(back).then_some((c, out)) }
        });
        let Some((start, mut exit)) = at_rim.or(corners.first().map(|c| (c.index(), sides(c.index()).1)))
        else {
            return false;
        };
        let mut corner = start;
        loop {
            self.corners.push(corner);
            match mesh.neighbour(exit) {
                Neighbour::Boundary => break,
                Neighbour::Nonmanifold(_) => return false,
                Neighbour::Twin(other) => {
                    let edge = mesh.edge(exit);
                    self.crossings.push(Crossing { edge, forward: mesh.edge_halfedges(edge)[0] == exit });
                    let (face, k) = (other.face(), other.index() % 3);
                    if mesh.origin(other) == v {
                        corner = 3 * face.index() + k;
                        exit = sides(corner).1;
                    } else {
                        corner = 3 * face.index() + (k + 1) % 3;
                        exit = sides(corner).0;
                    }
                    if corner == start {
                        self.closed = true;
                        break;
                    }
                    if self.corners.len() >= corners.len() {
                        return false;
                    }
                }
            }
        }
        self.corners.len() == corners.len()
    }
}
