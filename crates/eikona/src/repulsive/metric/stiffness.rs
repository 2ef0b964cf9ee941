//! What potentials add to the inner product, so that steps need not be as short as they are stiff.

use super::laplacian::symmetric_product;
use crate::geometry::lay_out_in;
use crate::operators::CotanLaplacian;
use eikona_mesh::TriangleMesh;
use eikona_numeric::NumericError;

type Vec3 = [f64; 3];

/// Symmetric positive semidefinite terms of the inner product.
#[derive(Debug, Default)]
pub(in crate::repulsive) struct Stiffness {
    /// A diagonal term, per vertex; empty if there is none.
    pub diagonal: Vec<f64>,
    pub bending: Option<Bending>,
    /// Whether the diagonal term lets the surface drift. Otherwise the mean displacement is zero.
    pub drifts: bool,
}

impl Stiffness {
    pub fn is_none(&self) -> bool {
        self.diagonal.is_empty() && self.bending.is_none()
    }

    /// Multiplies all terms.
    pub fn scale(&mut self, by: f64) {
        let bending = self.bending.iter_mut().flat_map(|bending| &mut bending.weights);
        self.diagonal.iter_mut().chain(bending).for_each(|x| *x *= by);
    }

    /// Adds the product with a field.
    pub fn add_product(&self, field: &[Vec3], result: &mut [Vec3]) {
        for ((y, x), h) in result.iter_mut().zip(field).zip(&self.diagonal) {
            (0..3).for_each(|k| y[k] += h * x[k]);
        }
        if let Some(bending) = &self.bending {
            for (y, x) in result.iter_mut().zip(bending.product(field)) {
                (0..3).for_each(|k| y[k] += x[k]);
            }
        }
    }
}

/// The bi-Laplacian `c C M^-1 C` with the cotan Laplacian C and the lumped mass M: the inner
/// product of H2, without a mass. It vanishes for translations.
///
/// With `c = 2`, it is the second derivative of the Willmore energy `f^T C M^-1 C f` where C and M
/// do not change.
#[derive(Debug)]
pub(in crate::repulsive) struct Bending {
    laplacian: CotanLaplacian,
    /// The factor c over the diagonal of M. Zero at boundary vertices, which the Willmore energy
    /// leaves out.
    weights: Vec<f64>,
}

impl Bending {
    /// Assembles it. Areas are those of the mesh, lengths inside are divided by a unit.
    pub fn new(mesh: &TriangleMesh, unit: f64, factor: f64) -> Result<Bending, NumericError> {
        let triangles = lay_out_in(mesh, unit)?;
        let mut masses = vec![0.0; mesh.vertex_count()];
        for (corners, triangle) in mesh.triangles().iter().zip(&triangles) {
            corners.iter().for_each(|&v| masses[v as usize] += triangle.area / 3.0 * unit * unit);
        }
        let inside = mesh.vertices().map(|v| !mesh.is_boundary_vertex(v));
        let weight = |(mass, inside): (f64, bool)| if inside && mass > 0.0 { factor / mass } else { 0.0 };
        let weights = masses.into_iter().zip(inside).map(weight).collect();
        Ok(Bending { laplacian: CotanLaplacian::new(mesh, &triangles), weights })
    }

    fn product(&self, field: &[Vec3]) -> Vec<Vec3> {
        let CotanLaplacian { graph, matrix } = &self.laplacian;
        let mut inner = symmetric_product(graph, matrix, field);
        inner.iter_mut().zip(&self.weights).for_each(|(x, weight)| *x = x.map(|x| weight * x));
        symmetric_product(graph, matrix, &inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repulsive::energy::unit_of_length;
    use crate::repulsive::potential::Potential;
    use eikona_mesh::shapes;

    fn wave(v: usize, by: f64) -> Vec3 {
        [0.3, 0.7, 1.1].map(|x| (x * by * (v * v + 1) as f64).sin())
    }

    fn dot(a: &[Vec3], b: &[Vec3]) -> f64 {
        a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| a * b).sum()
    }

    #[test]
    fn bending_is_the_willmore_energy_and_symmetric() {
        let closed = shapes::bumpy_sphere(6, 0.3, 3.0).unwrap();
        let open = shapes::cylinder(0.8, 2.0, 14, 6, shapes::Ends::Open).unwrap();
        for mesh in [closed, open] {
            let bending = Bending::new(&mesh, unit_of_length(&mesh), 2.0).unwrap();
            // The energy is quadratic in the positions where C and M stay.
            let value = Potential::willmore(1.0).value(&mesh).unwrap();
            let square = dot(mesh.positions(), &bending.product(mesh.positions()));
            assert!((square / (2.0 * value) - 1.0).abs() < 1e-10, "{square} {value}");
            let fields =
                [1.0, 1.7].map(|by| (0..mesh.vertex_count()).map(|v| wave(v, by)).collect::<Vec<_>>());
            let images = [0, 1].map(|i| bending.product(&fields[i]));
            let [there, back] = [dot(&fields[0], &images[1]), dot(&fields[1], &images[0])];
            let size = dot(&fields[0], &images[0]);
            assert!(size > 0.0 && dot(&fields[1], &images[1]) > 0.0);
            assert!((there - back).abs() < 1e-12 * size, "{there} {back}");
            let still = bending.product(&vec![[1.0, 2.0, 3.0]; mesh.vertex_count()]);
            assert!(still.iter().flatten().all(|x| x.abs() < 1e-12 * size));
        }
    }
}
