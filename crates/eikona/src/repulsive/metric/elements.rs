//! Gradients and means of vertex functions on faces, times the area, and the transposes.

use crate::geometry::vector::{cross, scale, sub};
use crate::repulsive::faces::FaceDatum;
use crate::spatial::ClusterTree;
use eikona_mesh::TriangleMesh;
use eikona_numeric::{NumericError, check_stopped, for_chunks};

type Vec3 = [f64; 3];

/// Faces or vertices per unit of work.
const CHUNK: usize = 256;

/// The faces of a mesh in the order of a tree.
pub(super) struct Elements {
    /// Vertices of each face.
    corners: Vec<[u32; 3]>,
    /// The gradient of the hat function of each corner, times the area.
    hats: Vec<[Vec3; 3]>,
    areas: Vec<f64>,
    /// The corners at each vertex, as three times the place of the face plus the corner in it.
    at_vertex: Vec<u32>,
    starts: Vec<u32>,
    threads: usize,
}

/// The gradients of the three coordinates of a vector field on a face, one after the other.
pub(super) type Gradient = [f64; 9];

/// The means of the three coordinates on a face.
pub(super) type Mean = [f64; 3];

impl Elements {
    /// `faces` are in the order of the tree, with lengths divided by `unit`.
    pub fn new(
        mesh: &TriangleMesh,
        unit: f64,
        tree: &ClusterTree,
        faces: &[FaceDatum],
        threads: usize,
    ) -> Elements {
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
        Elements { corners, hats, areas, at_vertex, starts, threads }
    }

    /// Returns the number of vertices.
    pub fn vertices(&self) -> usize {
        self.starts.len() - 1
    }

    /// Returns the gradients of some vector fields, times the areas: those of a face together.
    pub fn gradients(&self, fields: &[&[Vec3]]) -> Result<Vec<Gradient>, NumericError> {
        self.on_faces(fields, |place, corners| {
            let mut gradient = [0.0; 9];
            for (x, hat) in corners.into_iter().zip(&self.hats[place]) {
                for c in 0..3 {
                    for k in 0..3 {
                        gradient[3 * c + k] += x[c] * hat[k];
                    }
                }
            }
            gradient
        })
    }

    /// Returns the means of some vector fields on the faces, times the areas.
    pub fn means(&self, fields: &[&[Vec3]]) -> Result<Vec<Mean>, NumericError> {
        self.on_faces(fields, |place, [a, b, c]| {
            [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) * (self.areas[place] / 3.0))
        })
    }

    /// Adds `factor` times the transpose of [`gradients`](Self::gradients).
    pub fn add_divergences(
        &self,
        gradients: &[Gradient],
        factor: f64,
        fields: &mut [Vec<Vec3>],
    ) -> Result<(), NumericError> {
        let many = fields.len();
        self.at_vertices(fields, |field, _, place, corner| {
            let (g, [x, y, z]) = (&gradients[place * many + field], self.hats[place][corner]);
            [0, 3, 6].map(|c| factor * (x * g[c] + y * g[c + 1] + z * g[c + 2]))
        })
    }

    /// Adds `factor` times the transpose of [`means`](Self::means).
    pub fn add_means(
        &self,
        means: &[Mean],
        factor: f64,
        fields: &mut [Vec<Vec3>],
    ) -> Result<(), NumericError> {
        let many = fields.len();
        self.at_vertices(fields, |field, _, place, _| {
            let share = factor * self.areas[place] / 3.0;
            means[place * many + field].map(|x| share * x)
        })
    }

    /// Adds, at the corners of each face, the deviation from the mean on the face, times the weight
    /// of the face.
    pub fn add_deviations(
        &self,
        weights: &[f64],
        fields: &[&[Vec3]],
        result: &mut [Vec<Vec3>],
    ) -> Result<(), NumericError> {
        let many = fields.len();
        let means = self.on_faces(fields, |_, [a, b, c]| [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0))?;
        self.at_vertices(result, |field, v, place, _| {
            sub(fields[field][v], means[place * many + field]).map(|x| weights[place] * x)
        })
    }

    /// Returns a function of each face and of its corners' values in some fields: the values of a
    /// face together.
    fn on_faces<const N: usize>(
        &self,
        fields: &[&[Vec3]],
        function: impl Fn(usize, [Vec3; 3]) -> [f64; N] + Sync,
    ) -> Result<Vec<[f64; N]>, NumericError> {
        let many = fields.len();
        let mut result = vec![[0.0; N]; self.corners.len() * many];
        for_chunks(self.threads, &mut result, CHUNK * many, |chunk, result| {
            check_stopped()?;
            for (place, own) in (chunk * CHUNK..).zip(result.chunks_mut(many)) {
                for (own, field) in own.iter_mut().zip(fields) {
                    *own = function(place, self.corners[place].map(|v| field[v as usize]));
                }
            }
            Ok::<(), NumericError>(())
        })?;
        Ok(result)
    }

    /// Adds a function of the number of the field, the vertex, and the place and corner of the face
    /// over all faces at the vertex.
    fn at_vertices(
        &self,
        fields: &mut [Vec<Vec3>],
        function: impl Fn(usize, usize, usize, usize) -> Vec3 + Sync,
    ) -> Result<(), NumericError> {
        for (number, field) in fields.iter_mut().enumerate() {
            for_chunks(self.threads, field, CHUNK, |chunk, sums| {
                check_stopped()?;
                for (v, sum) in (chunk * CHUNK..).zip(sums) {
                    for corner in &self.at_vertex[self.starts[v] as usize..self.starts[v + 1] as usize] {
                        let own = function(number, v, (corner / 3) as usize, (corner % 3) as usize);
                        (0..3).for_each(|c| sum[c] += own[c]);
                    }
                }
                Ok::<(), NumericError>(())
            })?;
        }
        Ok(())
    }
}
