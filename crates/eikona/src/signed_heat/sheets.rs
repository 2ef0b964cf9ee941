//! Sheets of faces attached to the rest of the surface at single vertices only. Diffusion crosses
//! edges and does not enter them, so the distance is continued from such a vertex as from a point.
//! Deviation: the paper does not treat such surfaces.

use crate::geometry::Triangle;
use eikona_mesh::{Corner, Face, TriangleMesh, Vertex};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Partition of the faces of a mesh into sheets, the connected components across edges.
pub(crate) struct Sheets {
    of_face: Vec<u32>,
    sheets: usize,
    /// Vertices that several sheets share.
    joints: Vec<Vertex>,
}

/// Vertex at which the distance enters a sheet. The gradient points away from the vertex if the
/// distance there is positive, and towards it if negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Entrance {
    pub vertex: Vertex,
    pub sheet: u32,
    pub sign: f64,
}

impl Sheets {
    pub fn of(mesh: &TriangleMesh) -> Sheets {
        let mut of_face = vec![u32::MAX; mesh.face_count()];
        let mut count = 0;
        let mut waiting = Vec::new();
        for first in mesh.faces() {
            if of_face[first.index()] != u32::MAX {
                continue;
            }
            of_face[first.index()] = count;
            waiting.push(first);
            while let Some(face) = waiting.pop() {
                for e in mesh.face_edges(face) {
                    for other in mesh.edge_halfedges(e).iter().map(|h| h.face()) {
                        if of_face[other.index()] == u32::MAX {
                            of_face[other.index()] = count;
                            waiting.push(other);
                        }
                    }
                }
            }
            count += 1;
        }
        let sheet_of = |c: &Corner| of_face[c.face().index()];
        let is_joint = |v: &Vertex| {
            let corners = mesh.vertex_corners(*v);
            corners.iter().any(|c| sheet_of(c) != sheet_of(&corners[0]))
        };
        let joints = mesh.vertices().filter(is_joint).collect();
        Sheets { of_face, sheets: count as usize, joints }
    }

    pub fn of_face(&self, face: Face) -> u32 {
        self.of_face[face.index()]
    }

    /// Returns which faces belong to sheets without a reached face ("hanging" sheets).
    pub fn hanging(&self, reached: &[bool]) -> Vec<bool> {
        let mut sheet_reached = vec![false; self.sheets];
        for (sheet, _) in self.of_face.iter().zip(reached).filter(|(_, reached)| **reached) {
            sheet_reached[*sheet as usize] = true;
        }
        self.of_face.iter().map(|sheet| !sheet_reached[*sheet as usize]).collect()
    }

    /// Returns the vertices that reached faces share with `hanging` ones.
    pub fn front(&self, mesh: &TriangleMesh, hanging: &[bool]) -> Vec<Vertex> {
        let is_front = |v: &Vertex| {
            let mut corners = mesh.vertex_corners(*v).iter().map(|c| hanging[c.face().index()]);
            let first = corners.next();
            corners.any(|h| Some(h) != first)
        };
        self.joints.iter().copied().filter(is_front).collect()
    }

    /// Returns the entrances of the `hanging` sheets, given the distance at the front.
    ///
    /// Dijkstra's algorithm finds the shortest paths along edges of these sheets. A vertex is an
    /// entrance of each sheet around it, except the one in which the path to it ends. So a sheet is
    /// not entered where another of its joints gives a path that is shorter or as short. The
    /// entrances are sorted by vertex, then by sheet. All entrances at a vertex have the sign of
    /// the distance where their path began.
    ///
    /// # Cost
    /// Visits each vertex of the hanging sheets once: O(n log n).
    pub fn entrances(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        hanging: &[bool],
        front: &[(Vertex, f64)],
    ) -> Vec<Entrance> {
        let mut entrances = Vec::new();
        let mut settled = vec![false; mesh.vertex_count()];
        let mut queue: BinaryHeap<Step> = front
            .iter()
            .map(|&(vertex, d)| Step {
                length: d.abs(),
                vertex,
                sign: if d < 0.0 { -1.0 } else { 1.0 },
                through: None,
            })
            .collect();
        while let Some(Step { length, vertex, sign, through }) = queue.pop() {
            if std::mem::replace(&mut settled[vertex.index()], true) {
                continue;
            }
            for corner in mesh.vertex_corners(vertex).iter().filter(|c| hanging[c.face().index()]) {
                let sheet = self.of_face(corner.face());
                if through != Some(sheet) {
                    entrances.push(Entrance { vertex, sheet, sign });
                }
                let (out, back) = (corner.halfedge(), corner.halfedge().previous());
                for (h, other) in [(out, mesh.tip(out)), (back, mesh.origin(back))] {
                    if !settled[other.index()] {
                        let side = triangles[h.face().index()].lengths[h.side()];
                        let length = length + AS_STRAIGHT * side;
                        queue.push(Step { length, vertex: other, sign, through: Some(sheet) });
                    }
                }
            }
        }
        entrances.sort_unstable_by_key(|e| (e.vertex, e.sheet));
        entrances.dedup();
        entrances
    }
}

/// Paths along edges are longer than geodesics, by a factor of 1 / 0.92 at most on squares divided
/// along both diagonals.
const AS_STRAIGHT: f64 = 0.92;

/// Path from the front. The shortest one is the greatest, so that a max-heap returns it first.
struct Step {
    length: f64,
    vertex: Vertex,
    /// Sign of the distance where the path began.
    sign: f64,
    /// Sheet of the last edge.
    through: Option<u32>,
}

impl Ord for Step {
    fn cmp(&self, other: &Self) -> Ordering {
        other.length.total_cmp(&self.length).then_with(|| other.vertex.cmp(&self.vertex))
    }
}
impl PartialOrd for Step {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Step {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Step {}
