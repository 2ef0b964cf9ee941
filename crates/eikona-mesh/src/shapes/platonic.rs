//! Regular solids with vertices on the unit sphere.

use super::vector::{Vec3, scale};
use crate::error::MeshError;
use crate::mesh::TriangleMesh;
use std::f64::consts::TAU;

/// The regular tetrahedron with vertices on the unit sphere: V = 4, E = 6, F = 4, outward oriented.
///
/// Its edges have length sqrt(8/3).
///
/// ```
/// let mesh = eikona_mesh::shapes::tetrahedron()?;
/// assert_eq!((mesh.vertex_count(), mesh.edge_count(), mesh.face_count()), (4, 6, 4));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn tetrahedron() -> Result<TriangleMesh, MeshError> {
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let positions = corners.iter().map(|&p| scale(p, 1.0 / 3f64.sqrt())).collect();
    TriangleMesh::new(positions, vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])
}

/// The regular octahedron with vertices on the axes at distance 1: V = 6, E = 12, F = 8, outward
/// oriented.
///
/// ```
/// let mesh = eikona_mesh::shapes::octahedron()?;
/// assert_eq!((mesh.vertex_count(), mesh.edge_count(), mesh.face_count()), (6, 12, 8));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn octahedron() -> Result<TriangleMesh, MeshError> {
    let positions = vec![
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
    ];
    let faces = (0..4).flat_map(|i| [[i, (i + 1) % 4, 4], [(i + 1) % 4, i, 5]]).collect();
    TriangleMesh::new(positions, faces)
}

/// The regular icosahedron with vertices on the unit sphere, two of them at the poles: V = 12, E =
/// 30, F = 20, outward oriented.
///
/// ```
/// let mesh = eikona_mesh::shapes::icosahedron()?;
/// assert_eq!((mesh.vertex_count(), mesh.edge_count(), mesh.face_count()), (12, 30, 20));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn icosahedron() -> Result<TriangleMesh, MeshError> {
    let faces = ICOSAHEDRON_FACES.map(|f| f.map(|v| v as u32)).to_vec();
    TriangleMesh::new(icosahedron_positions().to_vec(), faces)
}

/// Returns the north pole, five vertices at latitude atan(1/2), five at the opposite latitude half
/// a step further east, and the south pole.
pub(super) fn icosahedron_positions() -> [Vec3; 12] {
    let (z, r) = (1.0 / 5f64.sqrt(), 2.0 / 5f64.sqrt());
    let at = |steps: f64, z: f64| {
        let (s, c) = (TAU * steps / 5.0).sin_cos();
        [r * c, r * s, z]
    };
    std::array::from_fn(|i| match i {
        0 => [0.0, 0.0, 1.0],
        11 => [0.0, 0.0, -1.0],
        1..=5 => at((i - 1) as f64, z),
        _ => at((i - 6) as f64 + 0.5, -z),
    })
}

pub(super) const ICOSAHEDRON_FACES: [[usize; 3]; 20] = {
    let mut faces = [[0; 3]; 20];
    let mut i = 0;
    while i < 5 {
        let (upper, upper_next) = (1 + i, 1 + (i + 1) % 5);
        let (lower, lower_next) = (6 + i, 6 + (i + 1) % 5);
        faces[i] = [0, upper, upper_next];
        faces[5 + i] = [upper, lower, upper_next];
        faces[10 + i] = [lower, lower_next, upper_next];
        faces[15 + i] = [11, lower_next, lower];
        i += 1;
    }
    faces
};
