//! The cotan Laplacian with a small mass, which makes it invertible.

use crate::geometry::lay_out_in;
use crate::operators::CotanLaplacian;
use eikona_mesh::TriangleMesh;
use eikona_numeric::{Graph, NumericError, SymmetricMatrix, check_stopped};

/// `C + m M`, where C is the cotan Laplacian, M the lumped mass, and `1 / m` the area. It does not
/// depend on the scale.
pub(in crate::repulsive) struct ScreenedLaplacian {
    pub graph: Graph,
    pub matrix: SymmetricMatrix<f64>,
    /// The diagonal of M, in the square of the unit of length.
    pub masses: Vec<f64>,
}

impl ScreenedLaplacian {
    /// Assembles the matrix, with lengths divided by a unit. Vertices without faces get an entry of
    /// 1, so that they keep their place.
    pub fn new(mesh: &TriangleMesh, unit: f64) -> Result<ScreenedLaplacian, NumericError> {
        let triangles = lay_out_in(mesh, unit)?;
        let CotanLaplacian { graph, mut matrix } = CotanLaplacian::new(mesh, &triangles);
        check_stopped()?;
        let area: f64 = triangles.iter().map(|t| t.area).sum();
        let shift = 1.0 / area;
        let mut masses = vec![0.0; mesh.vertex_count()];
        for (corners, triangle) in mesh.triangles().iter().zip(&triangles) {
            for &v in corners {
                matrix.diagonal[v as usize] += shift * triangle.area / 3.0;
                masses[v as usize] += triangle.area / 3.0;
            }
        }
        matrix.diagonal.iter_mut().chain(&mut masses).filter(|x| **x == 0.0).for_each(|x| *x = 1.0);
        Ok(ScreenedLaplacian { graph, matrix, masses })
    }

    /// Returns the product with a vector field.
    pub fn product(&self, field: &[[f64; 3]]) -> Vec<[f64; 3]> {
        symmetric_product(&self.graph, &self.matrix, field)
    }
}

/// Returns the product of a symmetric matrix with a vector field.
pub(super) fn symmetric_product(
    graph: &Graph,
    matrix: &SymmetricMatrix<f64>,
    field: &[[f64; 3]],
) -> Vec<[f64; 3]> {
    let diagonal = field.iter().zip(&matrix.diagonal);
    let mut image: Vec<[f64; 3]> = diagonal.map(|(x, d)| x.map(|x| d * x)).collect();
    for (pair, entry) in graph.pairs.iter().zip(&matrix.off_diagonal) {
        let [i, j] = pair.map(|v| v as usize);
        for k in 0..3 {
            image[i][k] += entry * field[j][k];
            image[j][k] += entry * field[i][k];
        }
    }
    image
}
