//! Sheets of faces that hang on the rest of the surface by single vertices only: diffusion across edges does not enter them, so
//! distance goes on through such a vertex as from a point.

use crate::geometry::Triangle;
use eikona_mesh::{Face, TriangleMesh, Vertex};
use std::cmp::Ordering;
use std::collections::hash_map::Entry;
use std::collections::{BinaryHeap, HashMap};

/// The faces of a mesh sorted into sheets, which are connected across edges.
pub(crate) struct Sheets {
    of_face: Vec<u32>,
    /// The vertices that each sheet shares with others: `joints[joint_start[s]..joint_start[s + 1]]`.
    joints: Vec<Vertex>,
    joint_start: Vec<u32>,
}

/// Where distance enters a sheet: away from a vertex where it is positive, towards it where it is negative.
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
        let mut shared: Vec<(u32, Vertex)> = Vec::new();
        for v in mesh.vertices() {
            let mut sheets: Vec<u32> =
                mesh.vertex_corners(v).iter().map(|c| of_face[c.face().index()]).collect();
            sheets.sort_unstable();
            sheets.dedup();
            if sheets.len() > 1 {
                shared.extend(sheets.into_iter().map(|s| (s, v)));
            }
        }
        shared.sort_unstable();
        let joint_start =
            (0..=count).map(|s| shared.partition_point(|&(sheet, _)| sheet < s) as u32).collect();
        Sheets { of_face, joints: shared.into_iter().map(|(_, v)| v).collect(), joint_start }
    }

    pub fn of_face(&self, face: Face) -> u32 {
        self.of_face[face.index()]
    }

    fn joints(&self, sheet: u32) -> &[Vertex] {
        let s = sheet as usize;
        &self.joints[self.joint_start[s] as usize..self.joint_start[s + 1] as usize]
    }

    /// Where distance enters the sheets that are not reached yet, in rounds from sheet to sheet: a sheet is entered at all vertices
    /// that it shares with sheets of earlier rounds. `sign_at` tells the sign of the distance at the vertices of reached
    /// sheets. Sorted by vertex, then by sheet; all entrances at a vertex have one sign. In an entered sheet the distance grows away from each entrance, so that its sign is that of the nearest one.
    ///
    /// # Cost
    /// Each sheet is visited once, whatever the number of rounds: O(n), but O(n log n) for sheets with entrances of both signs.
    pub fn entrances<E>(
        &self,
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        reached: &[bool],
        sign_at: impl FnOnce(&[Vertex]) -> Result<Vec<f64>, E>,
    ) -> Result<Vec<Entrance>, E> {
        let mut entered = vec![false; self.joint_start.len() - 1];
        for (sheet, _) in self.of_face.iter().zip(reached).filter(|(_, reached)| **reached) {
            entered[*sheet as usize] = true;
        }
        let all = 0..entered.len() as u32;
        let is_entered = |c: &eikona_mesh::Corner| entered[self.of_face(c.face()) as usize];
        let mut front: Vec<Vertex> =
            all.filter(|s| entered[*s as usize]).flat_map(|s| self.joints(s)).copied().collect();
        front.sort_unstable();
        front.dedup();
        front.retain(|v| !mesh.vertex_corners(*v).iter().all(is_entered));
        if front.is_empty() {
            return Ok(Vec::new());
        }
        let mut sign: HashMap<Vertex, f64> = front.iter().copied().zip(sign_at(&front)?).collect();
        let mut entrances: Vec<Entrance> = Vec::new();
        while !front.is_empty() {
            let mut round: Vec<Entrance> = Vec::new();
            for &vertex in &front {
                for sheet in mesh.vertex_corners(vertex).iter().map(|c| self.of_face(c.face())) {
                    if !entered[sheet as usize] {
                        round.push(Entrance { vertex, sheet, sign: sign[&vertex] });
                    }
                }
            }
            round.sort_unstable_by_key(|e| (e.sheet, e.vertex));
            round.dedup();
            front.clear();
            for own in round.chunk_by(|a, b| a.sheet == b.sheet) {
                let sheet = own[0].sheet;
                entered[sheet as usize] = true;
                let signs = self.spread(mesh, triangles, own);
                for &v in self.joints(sheet) {
                    if let Entry::Vacant(unknown) = sign.entry(v) {
                        unknown.insert(signs.at(v));
                        front.push(v);
                    }
                }
            }
            entrances.extend(round);
        }
        entrances.sort_unstable_by_key(|e| (e.vertex, e.sheet));
        Ok(entrances)
    }

    /// The sign of the nearest entrance, along edges of the sheet.
    fn spread(&self, mesh: &TriangleMesh, triangles: &[Triangle], entrances: &[Entrance]) -> Signs {
        let (sheet, sign) = (entrances[0].sheet, entrances[0].sign);
        if entrances.iter().all(|e| e.sign == sign) {
            return Signs::Same(sign);
        }
        let mut signs = HashMap::new();
        let mut queue: BinaryHeap<Step> =
            entrances.iter().map(|e| Step { length: 0.0, vertex: e.vertex, sign: e.sign }).collect();
        while let Some(Step { length, vertex, sign }) = queue.pop() {
            if signs.contains_key(&vertex) {
                continue;
            }
            signs.insert(vertex, sign);
            for corner in mesh.vertex_corners(vertex).iter().filter(|c| self.of_face(c.face()) == sheet) {
                let (out, back) = (corner.halfedge(), corner.halfedge().previous());
                for (h, other) in [(out, mesh.tip(out)), (back, mesh.origin(back))] {
                    let side = triangles[h.face().index()].lengths[h.side()];
                    queue.push(Step { length: length + side, vertex: other, sign });
                }
            }
        }
        Signs::ByVertex(signs)
    }
}

/// The sign of the distance in a sheet.
enum Signs {
    Same(f64),
    ByVertex(HashMap<Vertex, f64>),
}

impl Signs {
    fn at(&self, v: Vertex) -> f64 {
        match self {
            Signs::Same(sign) => *sign,
            Signs::ByVertex(signs) => signs.get(&v).copied().unwrap_or(1.0),
        }
    }
}

/// A way from an entrance; the shortest is the greatest, so that a heap gives it first.
struct Step {
    length: f64,
    vertex: Vertex,
    sign: f64,
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
