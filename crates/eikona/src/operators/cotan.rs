//! Vertex operators of step III: cotan Laplacian (SHM eq. 10) and divergence (section 5.5).

use crate::geometry::Triangle;
use eikona_mesh::TriangleMesh;
use eikona_numeric::{Complex, Graph, SymmetricMatrix};

/// Cotan Laplacian `C` (SHM eq. 10): real and positive semidefinite, with one null vector per
/// connected component and natural (no-flux) boundary conditions. Defined on every mesh, including
/// nonmanifold ones, as the sum of one matrix per face.
#[derive(Debug)]
pub struct CotanLaplacian {
    /// Pairs of vertices with an entry: three consecutive pairs per face.
    pub graph: Graph,
    /// Entries of the matrix.
    pub matrix: SymmetricMatrix<f64>,
}

impl CotanLaplacian {
    /// Assembles the operator from the layouts of the faces.
    pub fn new(mesh: &TriangleMesh, triangles: &[Triangle]) -> CotanLaplacian {
        let graph = CotanLaplacian::graph_of(mesh);
        let mut matrix = SymmetricMatrix {
            diagonal: vec![0.0; mesh.vertex_count()],
            off_diagonal: Vec::with_capacity(3 * mesh.face_count()),
        };
        for (corners, triangle) in mesh.triangles().iter().zip(triangles) {
            for k in 0..3 {
                let (i, j) = (corners[k], corners[(k + 1) % 3]);
                let weight = 0.5 * triangle.cotangent((k + 2) % 3);
                matrix.off_diagonal.push(-weight);
                matrix.diagonal[i as usize] += weight;
                matrix.diagonal[j as usize] += weight;
            }
        }
        CotanLaplacian { graph, matrix }
    }

    /// Returns the pairs of vertices with an entry, which do not depend on positions.
    pub fn graph_of(mesh: &TriangleMesh) -> Graph {
        let pairs = mesh.triangles().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        Graph { unknowns: mesh.vertex_count(), pairs: pairs.collect() }
    }

    /// Returns the index in `matrix.off_diagonal` of an entry between two vertices, if they share a
    /// face.
    pub fn entry(&self, mesh: &TriangleMesh, i: u32, j: u32) -> Option<usize> {
        let edge = mesh.find_edge(eikona_mesh::Vertex(i), eikona_mesh::Vertex(j))?;
        // Pair 3 f + k belongs to halfedge 3 f + k.
        mesh.edge_halfedges(edge).first().map(|h| h.index())
    }
}

/// Computes the integrated divergence at each vertex of a field with one tangent vector per face,
/// given in the layout of the face.
///
/// The function whose gradient is closest to the field solves `C phi = -divergence`. Boundary
/// vertices get no extra term: it cancels with the natural boundary condition.
///
/// Deviation: SHM section 5.5 and algorithm 8 print `e_ki` in the second term; both edges must
/// leave vertex `i`. Eq. 13 prints `C phi = div`; with C positive semidefinite the sign is minus.
/// (Test `gradient_of_linear_function_is_recovered`.)
pub fn divergence(mesh: &TriangleMesh, triangles: &[Triangle], field: &[Complex]) -> Vec<f64> {
    let mut result = vec![0.0; mesh.vertex_count()];
    for ((corners, t), y) in mesh.triangles().iter().zip(triangles).zip(field) {
        let directions = t.directions();
        for k in 0..3 {
            // Flux through the side from corner k to k + 1, as contributed to its two ends.
            let along = (directions[k].re * y.re + directions[k].im * y.im) * t.lengths[k];
            let flux = 0.5 * t.cotangent((k + 2) % 3) * along;
            result[corners[k] as usize] += flux;
            result[corners[(k + 1) % 3] as usize] -= flux;
        }
    }
    result
}
