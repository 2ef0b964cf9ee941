//! Finds equal positions and faces.

use crate::id::Face;
use crate::mesh::TriangleMesh;
use std::hash::{BuildHasher, RandomState};

/// Returns the first equal position for each one (itself if it is the first). Zero equals minus
/// zero.
pub(crate) fn first_at_position(positions: &[[f64; 3]]) -> Vec<u32> {
    const EMPTY: u32 = u32::MAX;
    // A table of vertex numbers with open addressing, a few times smaller than a map that stores
    // the positions. The hash is randomised, so that no input can defeat it; the result does not
    // depend on it.
    let hashing = RandomState::new();
    let mask = (2 * positions.len()).next_power_of_two() - 1;
    let mut table = vec![EMPTY; mask + 1];
    let mut first = Vec::with_capacity(positions.len());
    for (i, p) in positions.iter().enumerate() {
        let mut slot = hashing.hash_one(p.map(|x| (x + 0.0).to_bits())) as usize & mask;
        while table[slot] != EMPTY && positions[table[slot] as usize] != *p {
            slot = (slot + 1) & mask;
        }
        if table[slot] == EMPTY {
            table[slot] = i as u32;
        }
        first.push(table[slot]);
    }
    first
}

/// Returns, for each face, the first one with the same three vertices in any order; itself if there
/// is none before it.
pub(crate) fn first_with_same_vertices(mesh: &TriangleMesh) -> Vec<Face> {
    let mut keyed: Vec<([u32; 3], Face)> = mesh
        .faces()
        .map(|f| {
            let mut vertices = mesh.triangles()[f.index()];
            vertices.sort_unstable();
            (vertices, f)
        })
        .collect();
    keyed.sort_unstable();
    let mut first_of: Vec<Face> = mesh.faces().collect();
    for group in keyed.chunk_by(|a, b| a.0 == b.0) {
        for (_, f) in group {
            first_of[f.index()] = group[0].1;
        }
    }
    first_of
}
