//! Inner products of differential operators, of order 0, 1 and 2: what the fractional one is
//! compared with (RS section 8.2.1).

use super::laplacian::ScreenedLaplacian;
use super::solve::{Analysis, Preconditioner};
use eikona_mesh::TriangleMesh;
use eikona_numeric::NumericError;

type Vec3 = [f64; 3];

/// The order of an inner product.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::repulsive) enum LocalOrder {
    /// L2: the lumped mass M.
    Zero,
    /// H1: `L = C + m M`, the cotan Laplacian with the mass of the preconditioner.
    One,
    /// H2: the bi-Laplacian `L M^-1 L`. The small mass in L makes it definite.
    Two,
}

/// An inner product of differential operators at a surface.
pub(in crate::repulsive) struct LocalMetric {
    order: LocalOrder,
    laplacian: ScreenedLaplacian,
    /// That of the Laplacian; `None` for order 0, which needs none.
    factor: Option<Preconditioner>,
    /// The diagonal of M.
    masses: Vec<f64>,
    /// Vertices that do not move; empty if all do.
    pinned: Vec<bool>,
}

impl LocalMetric {
    /// Assembles and factors, with the analysis of another surface of the same connectivity.
    pub fn new(
        order: LocalOrder,
        mesh: &TriangleMesh,
        unit: f64,
        threads: usize,
        analysis: Option<&Analysis>,
        pinned: Vec<bool>,
    ) -> Result<LocalMetric, NumericError> {
        let laplacian = ScreenedLaplacian::new(mesh, unit)?;
        let factor = match order {
            LocalOrder::Zero => None,
            _ => Some(Preconditioner::factored(&laplacian, threads, analysis, &pinned)?),
        };
        let masses = laplacian.masses.iter().map(|mass| mass * unit * unit).collect();
        Ok(LocalMetric { order, laplacian, factor, masses, pinned })
    }

    /// The order, as a number.
    pub fn order(&self) -> f64 {
        match self.order {
            LocalOrder::Zero => 0.0,
            LocalOrder::One => 1.0,
            LocalOrder::Two => 2.0,
        }
    }

    /// The analysis, for surfaces of the same connectivity.
    pub fn analysis(&self) -> Option<Analysis> {
        self.factor.as_ref().map(Preconditioner::analysis)
    }

    /// Returns the displacements whose products are some forces, at the vertices that move.
    ///
    /// Without pins, the means of the forces are taken out of them: the displacements then keep the
    /// barycentre at fixed areas.
    pub fn solve(&self, mut forces: Vec<Vec<Vec3>>) -> Result<Vec<Vec<Vec3>>, NumericError> {
        forces.iter_mut().for_each(|force| self.project(force));
        match self.order {
            LocalOrder::Zero => {
                forces.iter_mut().for_each(|force| self.divide_by_mass(force));
                Ok(forces)
            }
            LocalOrder::One => self.solve_laplacian(&forces),
            LocalOrder::Two => {
                let mut inner = self.solve_laplacian(&forces)?;
                for (x, mass) in inner.iter_mut().flat_map(|field| field.iter_mut().zip(&self.masses)) {
                    *x = x.map(|x| mass * x);
                }
                self.solve_laplacian(&inner)
            }
        }
    }

    /// Returns the product with a displacement: the force. With pins, that of order 2 measures the
    /// Laplacian at the vertices that move, so that [`solve`](Self::solve) is its exact inverse.
    pub fn product(&self, field: &[Vec3]) -> Vec<Vec3> {
        match self.order {
            LocalOrder::Zero => field.iter().zip(&self.masses).map(|(x, mass)| x.map(|x| mass * x)).collect(),
            LocalOrder::One => self.laplacian.product(field),
            LocalOrder::Two => {
                let mut inner = self.laplacian.product(field);
                self.clear_pins(&mut inner);
                self.divide_by_mass(&mut inner);
                self.laplacian.product(&inner)
            }
        }
    }

    /// Clears a force at the pinned vertices; without any, takes out its mean, in proportion to the
    /// mass.
    pub fn project(&self, force: &mut [Vec3]) {
        if !self.pinned.is_empty() {
            return self.clear_pins(force);
        }
        let total: f64 = self.masses.iter().sum();
        let sum = force.iter().fold([0.0; 3], |sum, x| [0, 1, 2].map(|k| sum[k] + x[k]));
        for (x, mass) in force.iter_mut().zip(&self.masses) {
            (0..3).for_each(|k| x[k] -= mass / total * sum[k]);
        }
    }

    /// Clears a field at the pinned vertices.
    pub fn clear_pins(&self, field: &mut [Vec3]) {
        let pinned = field.iter_mut().zip(&self.pinned).filter(|(_, pinned)| **pinned);
        pinned.for_each(|(x, _)| *x = [0.0; 3]);
    }

    fn solve_laplacian(&self, forces: &[Vec<Vec3>]) -> Result<Vec<Vec<Vec3>>, NumericError> {
        let Some(factor) = &self.factor else { return Ok(forces.to_vec()) };
        let mut fields = factor.solve(forces)?;
        fields.iter_mut().for_each(|field| self.clear_pins(field));
        Ok(fields)
    }

    fn divide_by_mass(&self, field: &mut [Vec3]) {
        field.iter_mut().zip(&self.masses).for_each(|(x, mass)| *x = x.map(|x| x / mass));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repulsive::energy::unit_of_length;
    use eikona_mesh::shapes;

    #[test]
    fn solves_are_inverse_to_products() {
        let mesh = shapes::bumpy_sphere(6, 0.3, 3.0).unwrap();
        let count = mesh.vertex_count();
        let force = |v: usize| [0.3, 0.7, 1.1].map(|x| (x * (v * v) as f64).sin());
        for order in [LocalOrder::Zero, LocalOrder::One, LocalOrder::Two] {
            for pins in [0, 3] {
                let pinned = (0..if pins > 0 { count } else { 0 }).map(|v| v < pins).collect();
                let unit = unit_of_length(&mesh);
                let metric = LocalMetric::new(order, &mesh, unit, 1, None, pinned).unwrap();
                let mut force: Vec<Vec3> = (0..count).map(force).collect();
                let solution = metric.solve(vec![force.clone()]).unwrap().remove(0);
                metric.project(&mut force);
                let mut image = metric.product(&solution);
                metric.clear_pins(&mut image);
                let off = image.iter().flatten().zip(force.iter().flatten()).map(|(a, b)| (a - b).abs());
                let off = off.fold(0.0, f64::max);
                // Pins are held by a stiff diagonal, which costs digits.
                let tolerance = if pins > 0 { 1e-6 } else { 1e-11 };
                assert!(off < tolerance, "{order:?} with {pins} pins: {off}");
                assert!(solution[..pins].iter().all(|x| *x == [0.0; 3]));
            }
        }
    }
}
