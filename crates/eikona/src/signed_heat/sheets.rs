//! Sheets of faces that hang on the rest of the surface by single vertices only: diffusion across
//! edges does not enter them, so distance goes on through such a vertex as from a point. Deviation:
//! the paper has no such surfaces.

use crate::geometry::Triangle;
use eikona_mesh::{Corner, Face, TriangleMesh, Vertex};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// The faces of a mesh sorted into sheets, which are connected across edges.
pub(crate) struct Sheets {
    of_face: Vec<u32>,
    sheets: usize,
    /// The vertices that several sheets share.
    joints: Vec<Vertex>,
}

/// Where distance enters a sheet: away from a vertex where it is positive, towards it where it is
/// negative.
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

    /// The faces of the sheets in which no face is reached.
    pub fn hanging(&self, reached: &[bool]) -> Vec<bool> {
        let mut sheet_reached = vec![false; self.sheets];
        for (sheet, _) in self.of_face.iter().zip(reached).filter(|(_, reached)| **reached) {
            sheet_reached[*sheet as usize] = true;
        }
        self.of_face.iter().map(|sheet| !sheet_reached[*sheet as usize]).collect()
    }

    /// The vertices that reached faces share with `hanging` ones.
    pub fn front(&self, mesh: &TriangleMesh, hanging: &[bool]) -> Vec<Vertex> {
        let is_front = |v: &Vertex| {
            let mut corners = mesh.vertex_corners(*v).iter().map(|c| hanging[c.face().index()]);
            let first = corners.next();
            corners.any(|h| Some(h) != first)
        };
        self.joints.iter().copied().filter(is_front).collect()
    }

    /// Where distance enters the `hanging` sheets, from its values at the front: along the shortest
    /// ways through these sheets, a vertex is an entrance of each sheet around it but the one that
    /// the way to it ends in. So a sheet is not entered where it would be reached sooner, or at the
    /// same time, from another of its joints. Sorted by vertex, then by sheet; all entrances at a
    /// vertex have one sign, that of the distance where its way began.
    ///
    /// # Cost
    /// Each vertex of the hanging sheets is visited once: O(n log n).
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

/// Ways along edges are longer than straight ones: at worst by 1 / 0.92 on squares cut along both
/// diagonals.
const AS_STRAIGHT: f64 = 0.92;

/// A way from the front; the shortest is the greatest, so that a heap gives it first.
struct Step {
    length: f64,
    vertex: Vertex,
    /// Of the distance.
    sign: f64,
    /// The sheet of its last edge.
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
