//! Polygon meshes as read from a file, and their triangulation.

use crate::error::{Fault, MeshError};
use crate::id::Face;
use crate::mesh::TriangleMesh;
use crate::provenance::Provenance;

mod box_tree;
mod crossing;
mod cut;
mod ears;
mod outline;
mod quality;

pub(crate) use cut::cut_polygon;
pub use quality::{NONPLANAR, PolygonQuality};

/// Vertices and polygons with any number of sides, in the order of the file. Nothing is merged,
/// dropped or flipped.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PolygonMesh {
    /// Position of each vertex.
    pub positions: Vec<[f64; 3]>,
    /// The corners of polygon `f` are `corners[starts[f]..starts[f + 1]]`.
    corners: Vec<u32>,
    /// One entry more than there are polygons (empty if there are none).
    starts: Vec<u32>,
}

impl PolygonMesh {
    /// Creates a mesh without polygons.
    pub fn new(positions: Vec<[f64; 3]>) -> Self {
        PolygonMesh { positions, corners: Vec::new(), starts: vec![0] }
    }
    /// Creates a mesh of triangles.
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
    /// Returns the number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.positions.len()
    }
    /// Returns the number of polygons.
    pub fn face_count(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }
    /// Returns the corners of a polygon.
    pub fn face(&self, f: usize) -> &[u32] {
        &self.corners[self.starts[f] as usize..self.starts[f + 1] as usize]
    }
    /// Iterates over all polygons in order.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        (0..self.face_count()).map(|f| self.face(f))
    }
    /// Returns whether every polygon has three corners.
    pub fn is_triangular(&self) -> bool {
        self.faces().all(|f| f.len() == 3)
    }

    /// Triangulates the polygons. The vertices stay; the parent of a triangle is its polygon.
    ///
    /// A polygon of `n` corners gives `n - 2` triangles with the polygon's orientation:
    /// - a fan from its first corner, if that covers the polygon without folding over, as in every
    ///   convex polygon;
    /// - otherwise, in a quadrilateral, a fan from its second corner if that is better;
    /// - otherwise the result of ear clipping in the projection along the area vector (Newell
    ///   normal).
    ///
    /// A polygon may revisit a vertex: on its way back from a hole (a keyhole: a bridge to the
    /// hole, traversed twice), or where it touches itself. Where it separates at such a vertex,
    /// each part of `m` corners gives `m - 2` triangles; dead ends, edges traversed out and
    /// straight back, are omitted. Self-intersecting polygons, and those whose corners are
    /// collinear, are triangulated too, with triangles that overlap or have no area;
    /// [`PolygonQuality`] reports them.
    ///
    /// ```
    /// use eikona_mesh::{Face, PolygonMesh, Quality};
    /// // An L: the fan from its first corner would fold over.
    /// let corners = [[2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.], [0., 0.]];
    /// let mut mesh = PolygonMesh::new(corners.map(|[x, y]| [x, y, 0.]).to_vec());
    /// mesh.push_face(0..6);
    /// let (triangles, provenance) = mesh.triangulate()?;
    /// assert_eq!(provenance.face_parts(Face(0)).len(), 4);
    /// assert_eq!(Quality::of(&triangles).area, 3.0);
    /// # Ok::<(), eikona_mesh::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// [`MeshError::Invalid`] with all faults. They include polygons with fewer than three corners,
    /// with the same vertex at two successive corners, or with a repeated vertex and no enclosed
    /// area. Face ids in the error are those of the polygons.
    ///
    /// # Cost
    /// O(n) for polygons triangulated as fans, about O(n log n) for others.
    pub fn triangulate(&self) -> Result<(TriangleMesh, Provenance), MeshError> {
        let mut triangles = Vec::with_capacity(self.face_count());
        let mut parent = Vec::with_capacity(self.face_count());
        let mut faults = Vec::new();
        for (f, corners) in self.faces().enumerate() {
            let face = Face(f as u32);
            if corners.len() < 3 {
                faults.push(Fault::TooFewCorners { face, corners: corners.len() });
                continue;
            }
            let vertices = self.positions.len();
            let outside = corners.iter().filter(|v| **v as usize >= vertices);
            let before = faults.len();
            faults.extend(outside.map(|&v| Fault::IndexOutOfRange { face, index: v as i64, vertices }));
            if faults.len() > before {
                continue;
            }
            match cut_polygon(corners, &self.positions, &mut triangles) {
                Ok(()) => parent.resize(triangles.len(), face),
                Err(vertex) => faults.push(Fault::RepeatedVertex { face, vertex }),
            }
        }
        if !faults.is_empty() {
            return Err(MeshError::Invalid(faults));
        }
        let provenance =
            Provenance::identity(self.vertex_count(), self.face_count()).with_face_parents(parent);
        Ok((TriangleMesh::new(self.positions.clone(), triangles)?, provenance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::Vertex;

    #[test]
    fn a_polygon_of_all_vertices_is_checked_in_linear_time() {
        const CORNERS: u32 = 500_000;
        let mut mesh = PolygonMesh::new(vec![[0.0; 3]; CORNERS as usize]);
        mesh.push_face((0..CORNERS).chain([7]));
        let repeated = Fault::RepeatedVertex { face: Face(0), vertex: Vertex(7) };
        assert_eq!(mesh.triangulate().unwrap_err(), MeshError::Invalid(vec![repeated]));
    }
}
