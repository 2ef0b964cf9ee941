//! Collects the faces of a file and checks their indices once all vertices are known.

use crate::error::{Fault, FileError, MeshError};
use crate::id::Face;
use crate::polygon::PolygonMesh;

/// The faces read so far. Indices are checked at the end, since a file may list its faces before
/// its vertices.
#[derive(Default)]
pub(super) struct Faces {
    mesh: PolygonMesh,
    corners: usize,
    /// The indices that are not below [`OUTSIDE`], in order; the mesh contains `OUTSIDE` in place
    /// of each.
    outside: Vec<i64>,
}

/// No mesh has a vertex with this index, so it is always out of range.
const OUTSIDE: u32 = u32::MAX;

impl Faces {
    pub fn count(&self) -> usize {
        self.mesh.face_count()
    }

    /// Adds a polygon of 0-based indices as given in the file.
    ///
    /// # Errors
    /// [`MeshError::TooLarge`] if the number of corners exceeds 32 bits.
    pub fn push(&mut self, corners: &[i64]) -> Result<(), FileError> {
        self.corners += corners.len();
        if self.corners > u32::MAX as usize {
            return Err(MeshError::TooLarge { vertices: self.corners, faces: self.count() }.into());
        }
        let Faces { mesh, outside, .. } = self;
        mesh.push_face(corners.iter().map(|&index| match u32::try_from(index) {
            Ok(index) if index < OUTSIDE => index,
            _ => {
                outside.push(index);
                OUTSIDE
            }
        }));
        Ok(())
    }

    /// Adds the triangles of a strip, every second one reversed so that all are consistently
    /// oriented; -1 starts a new strip. Returns the number of triangles omitted because two of
    /// their corners coincide (which is how strips are stitched together).
    pub fn push_strip(&mut self, strip: &[i64]) -> Result<usize, FileError> {
        let mut stitches = 0;
        for run in strip.split(|&index| index == -1) {
            for (k, w) in run.windows(3).enumerate() {
                if w[0] == w[1] || w[1] == w[2] || w[0] == w[2] {
                    stitches += 1;
                } else {
                    self.push(&if k % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] })?;
                }
            }
        }
        Ok(stitches)
    }

    /// Builds the mesh with these positions and all faces.
    ///
    /// # Errors
    /// [`MeshError::Invalid`] with every index without a vertex.
    pub fn finish(mut self, positions: Vec<[f64; 3]>) -> Result<PolygonMesh, FileError> {
        let vertices = positions.len();
        let mut outside = self.outside.into_iter();
        let mut faults = Vec::new();
        for (f, corners) in self.mesh.faces().enumerate() {
            for &corner in corners.iter().filter(|&&corner| corner as usize >= vertices) {
                let as_given = if corner == OUTSIDE { outside.next() } else { None };
                let index = as_given.unwrap_or(i64::from(corner));
                faults.push(Fault::IndexOutOfRange { face: Face(f as u32), index, vertices });
            }
        }
        if !faults.is_empty() {
            return Err(MeshError::Invalid(faults).into());
        }
        self.mesh.positions = positions;
        Ok(self.mesh)
    }
}
