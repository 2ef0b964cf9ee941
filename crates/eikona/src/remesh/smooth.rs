//! Moves vertices along the surface to even out its faces.

use super::barrier::allows_motion;
use super::changing::Vec3;
use super::options::RemeshOptions;
use super::passes::{SMOOTH_BOUNDARY, centroid, turns_little};
use crate::geometry::vector::{add, cross, dot, norm, scale, sub};
use crate::spatial::{contacts, joined};
use eikona_mesh::TriangleMesh;
use eikona_numeric::{NumericError, check_stopped};

/// The share of the way that vertices go.
const RELAXATION: f64 = 0.5;
/// The longest way, relative to the length to aim for.
const LONGEST: f64 = 0.25;
/// Rounds in which those vertices are held back that would collide, or turn a face.
const ROUNDS: usize = 8;

/// Moves each vertex in its tangent plane towards the mean of the circumcentres around it, weighted
/// by area (Chen and Holst 2011), and those at a smooth boundary along it. Returns the new
/// positions.
///
/// Deviation: the paper takes barycentres at faces with a boundary edge. Vertices that would turn a
/// face by 60 degrees or make the surface touch itself stay where they are.
pub(super) fn smoothed(
    mesh: &TriangleMesh,
    sizes: &[f64],
    fixed: &[bool],
    options: &RemeshOptions,
) -> Result<Vec<Vec3>, NumericError> {
    let mut motion = tangential_motion(mesh, sizes, fixed);
    let whole = options.obstacle.as_ref().map_or(mesh.clone(), |obstacle| joined(mesh, obstacle));
    let mut ways = vec![[0.0; 3]; whole.vertex_count()];
    let moved = |motion: &[Vec3]| -> Vec<Vec3> {
        mesh.positions().iter().zip(motion).map(|(p, d)| add(*p, *d)).collect()
    };
    let barrier = options.barrier.as_deref().filter(|_| options.collisions);
    for _ in 0..ROUNDS {
        check_stopped()?;
        let after = moved(&motion);
        let mut held: Vec<u32> = Vec::new();
        for (f, corners) in mesh.faces().zip(mesh.triangles()) {
            let now = corners.map(|v| after[v as usize]);
            let before = mesh.face_positions(f);
            let ways = corners.map(|v| motion[v as usize]);
            let clears = barrier.is_none_or(|barrier| allows_motion(barrier, before, now, ways));
            if !clears || !turns_little(&before, &now) {
                held.extend(corners);
            }
        }
        if held.is_empty() && options.collisions {
            ways[..motion.len()].copy_from_slice(&motion);
            let contacts = contacts(&whole, mesh.face_count(), &ways, options.threads)?;
            let vertices = contacts.into_iter().flat_map(|contact| contact.vertices(&whole));
            held.extend(vertices.map(|v| v.0).filter(|v| (*v as usize) < motion.len()));
        }
        if held.is_empty() {
            return Ok(after);
        }
        held.into_iter().for_each(|v| motion[v as usize] = [0.0; 3]);
    }
    Ok(mesh.positions().to_vec())
}

fn tangential_motion(mesh: &TriangleMesh, sizes: &[f64], fixed: &[bool]) -> Vec<Vec3> {
    let mut sums = vec![([0.0; 3], 0.0, [0.0; 3]); mesh.vertex_count()];
    for (f, corners) in mesh.faces().zip(mesh.triangles()) {
        let triangle = mesh.face_positions(f);
        let [a, b, c] = triangle;
        let normal = cross(sub(b, a), sub(c, a));
        let area = 0.5 * norm(normal);
        let size = corners.iter().map(|v| sizes[*v as usize]).sum::<f64>() / 3.0;
        let weight = area / (size * size);
        let centre = circumcentre(&triangle).unwrap_or_else(|| centroid(&triangle));
        for &v in corners {
            let (sum, total, normals) = &mut sums[v as usize];
            *sum = add(*sum, scale(centre, weight));
            *total += weight;
            *normals = add(*normals, normal);
        }
    }
    let mut motion: Vec<Vec3> = sums
        .iter()
        .zip(mesh.positions())
        .map(|(&(sum, total, normal), &p)| {
            let way = sub(scale(sum, 1.0 / total), p);
            sub(way, scale(normal, dot(way, normal) / dot(normal, normal)))
        })
        .collect();
    along_boundary(mesh, &mut motion);
    for (v, way) in motion.iter_mut().enumerate() {
        let longest = LONGEST * sizes[v];
        let length = RELAXATION * norm(*way);
        *way = match length.is_finite() && !fixed[v] {
            true => scale(*way, RELAXATION * (longest / length).min(1.0)),
            false => [0.0; 3],
        };
        if length == 0.0 {
            *way = [0.0; 3];
        }
    }
    motion
}

/// Vertices at the boundary go towards the middle between their neighbours, along the boundary;
/// those at corners stay.
fn along_boundary(mesh: &TriangleMesh, motion: &mut [Vec3]) {
    let mut ends: Vec<Vec<u32>> = Vec::new();
    let mut number = vec![u32::MAX; mesh.vertex_count()];
    for e in mesh.edges().filter(|e| mesh.is_boundary_edge(*e)) {
        let [a, b] = mesh.edge_vertices(e);
        for (v, other) in [(a, b), (b, a)] {
            if number[v.index()] == u32::MAX {
                number[v.index()] = ends.len() as u32;
                ends.push(Vec::new());
            }
            ends[number[v.index()] as usize].push(other.0);
        }
    }
    for (v, &number) in number.iter().enumerate().filter(|(_, number)| **number != u32::MAX) {
        let p = mesh.positions()[v];
        motion[v] = match ends[number as usize].as_slice() {
            &[before, after] => {
                let [before, after] = [before, after].map(|v| mesh.positions()[v as usize]);
                let (s, t, whole) = (sub(p, before), sub(after, p), sub(after, before));
                if dot(s, t) > SMOOTH_BOUNDARY * norm(s) * norm(t) {
                    scale(whole, 0.5 * dot(sub(t, s), whole) / dot(whole, whole))
                } else {
                    [0.0; 3]
                }
            }
            _ => [0.0; 3],
        };
    }
}

/// `None` if the triangle is flat.
fn circumcentre([a, b, c]: &[Vec3; 3]) -> Option<Vec3> {
    let (s, t) = (sub(*b, *a), sub(*c, *a));
    let normal = cross(s, t);
    let offset = add(scale(cross(t, normal), -dot(s, s)), scale(cross(s, normal), dot(t, t)));
    let offset = scale(offset, -0.5 / dot(normal, normal));
    offset.iter().all(|x| x.is_finite()).then(|| add(*a, offset))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::distance;

    #[test]
    fn circumcentres_are_as_far_from_all_corners() {
        let triangle = [[0.1, 0.2, 0.3], [2.0, -0.4, 0.7], [0.3, 1.5, -0.6]];
        let centre = circumcentre(&triangle).unwrap();
        let [r, s, t] = triangle.map(|p| distance(p, centre));
        assert!((r - s).abs() < 1e-14 && (r - t).abs() < 1e-14);
        let normal = cross(sub(triangle[1], triangle[0]), sub(triangle[2], triangle[0]));
        assert!(dot(normal, sub(centre, triangle[0])).abs() < 1e-14);
        assert_eq!(circumcentre(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]), None);
    }
}
