//! Slivers: faces that are nearly degenerate.

use crate::id::Face;
use crate::mesh::TriangleMesh;
use crate::quality::TriangleShape;

/// The height, relative to its longest edge, below which a face is a sliver.
///
/// The cotangents of such a face are as large as the inverse of its height, and numbers of ordinary
/// size next to them lose as many digits. Where whole regions consist of slivers, the loss is the
/// square of that; see [`Sliver`].
pub const SLIVER: f64 = 1e-6;

/// A nearly degenerate face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sliver {
    /// The face.
    pub face: Face,
    /// Its height above its longest edge, relative to that edge.
    pub height: f64,
}

/// Returns the faces with a height below [`SLIVER`] times their longest edge, in increasing order,
/// including those of zero area.
///
/// ```
/// use eikona_mesh::{Face, TriangleMesh, slivers};
/// let positions = vec![[0., 0., 0.], [2., 0., 0.], [1., 1e-7, 0.], [1., 1., 0.]];
/// let mesh = TriangleMesh::new(positions, vec![[0, 1, 2], [0, 1, 3]])?;
/// let found = slivers(&mesh);
/// assert_eq!((found.len(), found[0].face), (1, Face(0)));
/// assert!((found[0].height / 5e-8 - 1.0).abs() < 1e-9);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn slivers(mesh: &TriangleMesh) -> Vec<Sliver> {
    mesh.faces()
        .map(|face| Sliver { face, height: TriangleShape::of(mesh.face_positions(face)).relative_height() })
        .filter(|sliver| sliver.height < SLIVER)
        .collect()
}
