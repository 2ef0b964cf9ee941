//! Islands: the sets of faces on which the winding number is determined up to one constant.

use crate::geometry::IntrinsicTriangulation;
use crate::operators::parts;
use eikona_mesh::{Face, Neighbour, TriangleMesh};
use std::collections::{BTreeMap, VecDeque};

/// Sets of faces joined through vertices with values: usually the connected components of the mesh.
/// (Two surfaces that touch only in a vertex at which a curve ends are two islands.)
#[derive(Clone, Debug)]
pub(crate) struct Islands {
    /// Island of each face.
    pub of_face: Vec<u32>,
    pub count: usize,
    /// Faces without a value at any corner, each with the nearest face that has one (fewest faces
    /// in between), whose island it joins. `None` if no such face is reachable; the face is then an
    /// island of its own.
    pub without_value: Vec<(Face, Option<Face>)>,
}

impl Islands {
    pub fn of(mesh: &TriangleMesh, triangulation: &IntrinsicTriangulation, excluded: &[bool]) -> Islands {
        let part_of = parts(triangulation, excluded);
        const NONE: u32 = u32::MAX;
        let mut number = vec![NONE; part_of.len()];
        let mut islands =
            Islands { of_face: vec![NONE; mesh.face_count()], count: 0, without_value: Vec::new() };
        let mut without = Vec::new();
        for (f, corners) in mesh.triangles().iter().enumerate() {
            // Corners with values are joined by edges, so they lie in one part.
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
        let nearest = nearest_with_value(mesh, &without, &islands.of_face, NONE);
        for f in without {
            let near = nearest.get(&f).copied();
            islands.of_face[f.index()] =
                near.map_or(islands.count as u32, |near| islands.of_face[near.index()]);
            islands.count += usize::from(near.is_none());
            islands.without_value.push((f, near));
        }
        islands
    }
}

/// Returns for each of these faces the nearest face with an island (fewest faces in between).
fn nearest_with_value(
    mesh: &TriangleMesh,
    without: &[Face],
    of_face: &[u32],
    none: u32,
) -> BTreeMap<Face, Face> {
    let beyond = |f: Face, k: usize| match mesh.neighbour(f.halfedge(k)) {
        Neighbour::Twin(other) => Some(other.face()),
        _ => None,
    };
    let mut nearest: BTreeMap<Face, Face> = BTreeMap::new();
    let mut waiting = VecDeque::new();
    for &f in without {
        let near = (0..3).filter_map(|k| beyond(f, k)).find(|other| of_face[other.index()] != none);
        if let Some(near) = near {
            nearest.insert(f, near);
            waiting.push_back((f, near));
        }
    }
    while let Some((f, near)) = waiting.pop_front() {
        for other in (0..3).filter_map(|k| beyond(f, k)) {
            if of_face[other.index()] == none && !nearest.contains_key(&other) {
                nearest.insert(other, near);
                waiting.push_back((other, near));
            }
        }
    }
    nearest
}
