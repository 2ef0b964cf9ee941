//! Polygons as they stand in a file, before they are triangulated.

use crate::error::{Fault, MeshError};
use crate::id::{Face, Vertex};
use crate::mesh::TriangleMesh;

/// Vertices and polygons of any number of sides, in the order of the file; nothing is merged, dropped or turned.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolygonMesh {
    /// Position of each vertex.
    pub positions: Vec<[f64; 3]>,
    /// Corners of polygon `f`: `corners[starts[f]..starts[f + 1]]`.
    corners: Vec<u32>,
    /// One entry more than there are polygons (empty when there is none).
    starts: Vec<u32>,
}

impl PolygonMesh {
    /// No faces yet.
    pub fn new(positions: Vec<[f64; 3]>) -> Self {
        PolygonMesh { positions, corners: Vec::new(), starts: vec![0] }
    }
    /// Triangles only.
    pub fn from_triangles(positions: Vec<[f64; 3]>, faces: &[[u32; 3]]) -> Self {
        PolygonMesh {
            positions,
            corners: faces.iter().flatten().copied().collect(),
            starts: (0..=faces.len() as u32).map(|i| 3 * i).collect(),
        }
    }
    /// Adds a polygon.
    pub fn push_face(&mut self, corners: impl IntoIterator<Item = u32>) {
        if self.starts.is_empty() {
            self.starts.push(0);
        }
        self.corners.extend(corners);
        self.starts.push(self.corners.len() as u32);
    }
    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }
    /// Number of polygons.
    pub fn face_count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }
    /// The corners of a polygon.
    pub fn face(&self, f: usize) -> &[u32] {
        &self.corners[self.starts[f] as usize..self.starts[f + 1] as usize]
    }
    /// All polygons in order.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        (0..self.face_count()).map(|f| self.face(f))
    }
    /// Whether every face has three corners.
    pub fn is_triangular(&self) -> bool {
        self.faces().all(|f| f.len() == 3)
    }

    /// The triangle mesh with the same vertices, polygons cut into fans from their first corner, and for each triangle the
    /// polygon it came from.
    ///
    /// # Errors
    /// [`MeshError::Invalid`] with all faults; polygons with fewer than three corners are among them. Face ids in the error
    /// are those of the polygons.
    pub fn triangulate(&self) -> Result<(TriangleMesh, Vec<Face>), MeshError> {
        let mut triangles = Vec::with_capacity(self.face_count());
        let mut parent = Vec::with_capacity(self.face_count());
        let mut faults = Vec::new();
        // The polygon that named each vertex last: finds repeated corners in time linear in the corners.
        let mut last_named = vec![None; self.positions.len()];
        for (f, corners) in self.faces().enumerate() {
            let face = Face(f as u32);
            if corners.len() < 3 {
                faults.push(Fault::TooFewCorners { face, corners: corners.len() });
                continue;
            }
            let before = faults.len();
            for &v in corners {
                match last_named.get_mut(v as usize) {
                    None => faults.push(Fault::IndexOutOfRange {
                        face,
                        index: v as i64,
                        vertices: self.positions.len(),
                    }),
                    Some(last) if *last == Some(face) => {
                        faults.push(Fault::RepeatedVertex { face, vertex: Vertex(v) });
                    }
                    Some(last) => *last = Some(face),
                }
            }
            if faults.len() > before {
                continue;
            }
            for k in 1..corners.len() - 1 {
                triangles.push([corners[0], corners[k], corners[k + 1]]);
                parent.push(face);
            }
        }
        if !faults.is_empty() {
            return Err(MeshError::Invalid(faults));
        }
        Ok((TriangleMesh::new(self.positions.clone(), triangles)?, parent))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polygon_of_all_vertices_is_checked_in_linear_time() {
        const CORNERS: u32 = 500_000;
        let mut mesh = PolygonMesh::new(vec![[0.0; 3]; CORNERS as usize]);
        mesh.push_face((0..CORNERS).chain([7]));
        let repeated = Fault::RepeatedVertex { face: Face(0), vertex: Vertex(7) };
        assert_eq!(mesh.triangulate().unwrap_err(), MeshError::Invalid(vec![repeated]));
    }
}
