//! Gradients and means of vertex functions on faces, times the area, and the transposes.

use crate::geometry::vector::{cross, scale, sub};
use crate::repulsive::faces::FaceDatum;
use crate::spatial::ClusterTree;
use eikona_mesh::TriangleMesh;

/// The faces of a mesh in the order of a tree.
pub(super) struct Elements {
    /// Vertices of each face.
    corners: Vec<[u32; 3]>,
    /// The gradient of the hat function of each corner, times the area.
    hats: Vec<[[f64; 3]; 3]>,
    areas: Vec<f64>,
    /// The corners at each vertex, as three times the place of the face plus the corner in it.
    at_vertex: Vec<u32>,
    starts: Vec<u32>,
}

/// The gradients of the three coordinates of a vector field on a face, one after the other.
pub(super) type Gradient = [f64; 9];

/// The means of the three coordinates on a face.
pub(super) type Mean = [f64; 3];

impl Elements {
    /// `faces` are in the order of the tree, with lengths divided by `unit`.
    pub fn new(mesh: &TriangleMesh, unit: f64, tree: &ClusterTree, faces: &[FaceDatum]) -> Elements {
        let corners = tree.in_order(mesh.triangles());
        let hat = |(corners, face): (&[u32; 3], &FaceDatum)| {
            let [a, b, c] = corners.map(|v| mesh.positions()[v as usize].map(|x| x / unit));
            // The normal times the opposite side, turned by a quarter, over twice the area.
            [sub(c, b), sub(a, c), sub(b, a)].map(|side| scale(cross(face.normal, side), 0.5))
        };
        let hats = corners.iter().zip(faces).map(hat).collect();
        let mut place_of = vec![0u32; corners.len()];
        tree.order().iter().zip(0..).for_each(|(&f, place)| place_of[f as usize] = place);
        let mut starts = vec![0];
        let mut at_vertex = Vec::with_capacity(3 * corners.len());
        for v in mesh.vertices() {
            let own = mesh.vertex_corners(v).iter();
            at_vertex.extend(own.map(|c| 3 * place_of[c.face().index()] + (c.index() % 3) as u32));
            starts.push(at_vertex.len() as u32);
        }
        let areas = faces.iter().map(|face| face.area).collect();
        Elements { corners, hats, areas, at_vertex, starts }
    }

    /// Returns the number of vertices.
    pub fn vertices(&self) -> usize {
        self.starts.len() - 1
    }

    /// Returns the gradients of some vector fields, times the areas: those of a face together.
    pub fn gradients(&self, fields: &[Vec<[f64; 3]>]) -> Vec<Gradient> {
        let mut result = Vec::with_capacity(self.corners.len() * fields.len());
        for (corners, hats) in self.corners.iter().zip(&self.hats) {
            for field in fields {
                let mut gradient = [0.0; 9];
                for (&v, hat) in corners.iter().zip(hats) {
                    let x = field[v as usize];
                    for c in 0..3 {
                        for k in 0..3 {
                            gradient[3 * c + k] += x[c] * hat[k];
                        }
                    }
                }
                result.push(gradient);
            }
        }
        result
    }

    /// Returns the means of some vector fields on the faces, times the areas.
    pub fn means(&self, fields: &[Vec<[f64; 3]>]) -> Vec<Mean> {
        let mut result = Vec::with_capacity(self.corners.len() * fields.len());
        for (corners, area) in self.corners.iter().zip(&self.areas) {
            for field in fields {
                let [a, b, c] = corners.map(|v| field[v as usize]);
                result.push([0, 1, 2].map(|k| (a[k] + b[k] + c[k]) * (area / 3.0)));
            }
        }
        result
    }

    /// Adds `factor` times the transpose of [`gradients`](Self::gradients).
    pub fn add_divergences(&self, gradients: &[Gradient], factor: f64, fields: &mut [Vec<[f64; 3]>]) {
        let many = fields.len();
        for (k, field) in fields.iter_mut().enumerate() {
            for (v, sum) in field.iter_mut().enumerate() {
                for corner in &self.at_vertex[self.starts[v] as usize..self.starts[v + 1] as usize] {
                    let (place, corner) = ((corner / 3) as usize, (corner % 3) as usize);
                    let (g, [x, y, z]) = (&gradients[place * many + k], self.hats[place][corner]);
                    for c in 0..3 {
                        sum[c] += factor * (x * g[3 * c] + y * g[3 * c + 1] + z * g[3 * c + 2]);
                    }
                }
            }
        }
    }

    /// Adds, at the corners of each face, the deviation from the mean on the face, times a power of
    /// the area.
    pub fn add_deviations(&self, power: f64, fields: &[Vec<[f64; 3]>], result: &mut [Vec<[f64; 3]>]) {
        for (corners, area) in self.corners.iter().zip(&self.areas) {
            let weight = area.powf(power);
            for (field, result) in fields.iter().zip(&mut *result) {
                let own = corners.map(|v| field[v as usize]);
                let mean = [0, 1, 2].map(|k| (own[0][k] + own[1][k] + own[2][k]) / 3.0);
                for (&v, own) in corners.iter().zip(own) {
                    (0..3).for_each(|k| result[v as usize][k] += weight * (own[k] - mean[k]));
                }
            }
        }
    }

    /// Adds `factor` times the transpose of [`means`](Self::means).
    pub fn add_means(&self, means: &[Mean], factor: f64, fields: &mut [Vec<[f64; 3]>]) {
        let many = fields.len();
        for (k, field) in fields.iter_mut().enumerate() {
            for (v, sum) in field.iter_mut().enumerate() {
                for corner in &self.at_vertex[self.starts[v] as usize..self.starts[v + 1] as usize] {
                    let place = (corner / 3) as usize;
                    let share = factor * self.areas[place] / 3.0;
                    (0..3).for_each(|c| sum[c] += share * means[place * many + k][c]);
                }
            }
        }
    }
}
