//! Which values can be compared: the function is known up to one constant an island.

use crate::winding::jump_laplace::parts;
use crate::winding::triangulation::Triangulation;
use eikona_mesh::{Face, Neighbour, TriangleMesh};
use std::collections::VecDeque;

/// What hangs together through vertices that have values: as a rule a connected component of the surface. (Surfaces that touch in a
/// vertex where a curve ends are two.)
#[derive(Clone, Debug)]
pub(crate) struct Islands {
    /// Island of each face.
    pub of_face: Vec<u32>,
    pub count: usize,
    /// Faces whose corners all have no value, each with a face that has one, by the fewest faces between: they are of its island. `None`
    /// if there is none; such a face is an island of its own.
    pub without_value: Vec<(Face, Option<Face>)>,
}

impl Islands {
    pub fn of(mesh: &TriangleMesh, triangulation: &Triangulation, excluded: &[bool]) -> Islands {
        let part_of = parts(triangulation, excluded);
        const NONE: u32 = u32::MAX;
        let mut number = vec![NONE; part_of.len()];
        let mut islands =
            Islands { of_face: vec![NONE; mesh.face_count()], count: 0, without_value: Vec::new() };
        let mut without = Vec::new();
        for (f, corners) in mesh.triangles().iter().enumerate() {
            // Corners with values are joined by edges, so they are of one part.
            let Some(&v) = corners.iter().find(|v| !excluded[**v as usize]) else {
                without.push(Face(f as u32));
                continue;
            };
            let number = &mut number[part_of[v as usize] as usize];
            if *number == NONE {
                *number = islands.count as u32;
                islands.count += 1;
            }
            islands.of_face[f] = *number;
        }
        for f in without {
            let nearest = nearest_with_value(mesh, f, &islands.of_face, NONE);
            islands.without_value.push((f, nearest));
        }
        for i in 0..islands.without_value.len() {
            let (f, nearest) = islands.without_value[i];
            islands.of_face[f.index()] =
                nearest.map_or(islands.count as u32, |near| islands.of_face[near.index()]);
            islands.count += usize::from(nearest.is_none());
        }
        islands
    }
}

/// Most faces that are looked at around a face without value.
const MOST_FACES: usize = 1000;

fn nearest_with_value(mesh: &TriangleMesh, from: Face, of_face: &[u32], none: u32) -> Option<Face> {
    let mut seen = vec![from];
    let mut waiting = VecDeque::from([from]);
    while let Some(f) = waiting.pop_front() {
        for k in 0..3 {
            let Neighbour::Twin(other) = mesh.neighbour(f.halfedge(k)) else { continue };
            let beyond = other.face();
            if of_face[beyond.index()] != none {
                return Some(beyond);
            }
            if seen.len() < MOST_FACES && !seen.contains(&beyond) {
                seen.push(beyond);
                waiting.push_back(beyond);
            }
        }
    }
    None
}
