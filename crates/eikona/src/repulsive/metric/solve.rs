//! Solves with the inner product: conjugate gradients with the preconditioner of RS section 5.2.

use super::Metric;
use super::laplacian::ScreenedLaplacian;
use crate::repulsive::error::RepulsiveError;
use eikona_mesh::{TriangleMesh, VertexField};
use eikona_numeric::{Cholesky, NumericError, Ordering, Symbolic, check_stopped};
use std::sync::Arc;

/// The factor of `C + m M`, where C is the cotan Laplacian and M the lumped mass.
///
/// Deviation: the paper factors C under constraints on positions. The mass gives each connected
/// component its own mean without them.
pub(in crate::repulsive) struct Preconditioner {
    factor: Cholesky<f64>,
}

/// The factor of the diagonal by which pinned vertices are held in the preconditioner.
const STIFF: f64 = 1e8;

/// The symbolic analysis, which depends on the connectivity only.
pub(in crate::repulsive) type Analysis = Arc<Symbolic>;

impl Preconditioner {
    /// Factors the matrix, with the analysis of another surface of the same connectivity.
    pub fn new(
        mesh: &TriangleMesh,
        unit: f64,
        threads: usize,
        analysis: Option<&Analysis>,
        pinned: &[bool],
    ) -> Result<Preconditioner, NumericError> {
        let laplacian = ScreenedLaplacian::new(mesh, unit)?;
        Preconditioner::factored(&laplacian, threads, analysis, pinned)
    }

    /// As [`new`](Self::new), for a matrix that is there already.
    pub fn factored(
        laplacian: &ScreenedLaplacian,
        threads: usize,
        analysis: Option<&Analysis>,
        pinned: &[bool],
    ) -> Result<Preconditioner, NumericError> {
        let symbolic = match analysis {
            Some(analysis) => analysis.clone(),
            None => Arc::new(Symbolic::new(&laplacian.graph, Ordering::MinimumDegree)?),
        };
        let mut matrix = laplacian.matrix.clone();
        matrix.diagonal.iter_mut().zip(pinned).filter(|(_, p)| **p).for_each(|(x, _)| *x *= STIFF);
        Ok(Preconditioner { factor: Cholesky::on_threads(symbolic, &matrix, threads)? })
    }

    /// The analysis, for surfaces of the same connectivity.
    pub fn analysis(&self) -> Analysis {
        self.factor.symbolic().clone()
    }

    /// Solves for the coordinates of some vector fields.
    pub fn solve(&self, fields: &[Vec<[f64; 3]>]) -> Result<Vec<Vec<[f64; 3]>>, NumericError> {
        let coordinates = fields.iter().flat_map(|field| [0, 1, 2].map(|k| (field, k)));
        let rhs: Vec<Vec<f64>> = coordinates.map(|(field, k)| field.iter().map(|x| x[k]).collect()).collect();
        let solutions = self.factor.solve_many(&rhs)?;
        let field =
            |three: &[Vec<f64>]| (0..three[0].len()).map(|v| [0, 1, 2].map(|k| three[k][v])).collect();
        Ok(solutions.chunks(3).map(field).collect())
    }
}

/// The solution of systems with the inner product.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct MetricSolution {
    /// One displacement per force. Its mean over the vertices is zero, unless some are pinned.
    pub displacements: Vec<VertexField<[f64; 3]>>,
    /// Number of iterations.
    pub iterations: usize,
    /// The largest change by the last iteration, as a share of the solution, in the norm of the
    /// product: about the error.
    pub change: f64,
}

/// More iterations mean that rounding has taken over.
const MOST_ITERATIONS: usize = 200;

fn dot(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a[0] * b[0] + a[1] * b[1] + a[2] * b[2]).sum()
}

/// `a + s b`
fn plus(a: &mut [[f64; 3]], s: f64, b: &[[f64; 3]]) {
    a.iter_mut().zip(b).for_each(|(a, b)| (0..3).for_each(|k| a[k] += s * b[k]));
}

fn centre(field: &mut [[f64; 3]]) {
    let mean = field.iter().fold([0.0; 3], |sum, x| [sum[0] + x[0], sum[1] + x[1], sum[2] + x[2]]);
    let mean = mean.map(|x| x / field.len() as f64);
    field.iter_mut().for_each(|x| (0..3).for_each(|k| x[k] -= mean[k]));
}

impl Metric {
    /// Returns the displacements whose products are some forces, all of them in common passes over
    /// the kernel matrices.
    ///
    /// The sum of the forces is taken out of them, since translations have no product.
    ///
    /// # Errors
    /// [`RepulsiveError::Numeric`] if an observer stops it.
    ///
    /// # Cost
    /// 5 to 20 iterations, each with a product, a product with the fractional Laplacian, and two
    /// solves with the factor.
    pub fn solve(&self, forces: &[VertexField<[f64; 3]>]) -> Result<MetricSolution, RepulsiveError> {
        let forces: Vec<Vec<[f64; 3]>> = forces.iter().map(|force| force.as_slice().to_vec()).collect();
        let (displacements, iterations, change) = self.solutions(forces)?;
        Ok(MetricSolution {
            displacements: displacements.into_iter().map(VertexField::from).collect(),
            iterations,
            change,
        })
    }

    /// Returns the solutions, the number of iterations, and the largest change by the last.
    pub(in crate::repulsive) fn solutions(
        &self,
        forces: Vec<Vec<[f64; 3]>>,
    ) -> Result<(Vec<Vec<[f64; 3]>>, usize, f64), NumericError> {
        let many = forces.len();
        let mut residual = forces;
        residual.iter_mut().for_each(|r| self.project(r));
        let mut solution: Vec<Vec<[f64; 3]>> = residual.iter().map(|r| vec![[0.0; 3]; r.len()]).collect();
        let mut conditioned = self.precondition(&residual)?;
        let mut direction = conditioned.clone();
        let mut product: Vec<f64> = (0..many).map(|i| dot(&residual[i], &conditioned[i])).collect();
        // The squared norm of the solution, and of the last change to it, in the norm of A. Changes
        // are orthogonal in it, so the error is about that of the next ones.
        let (mut whole, mut last) = (vec![0.0; many], product.clone());
        let share = |last: f64, whole: f64| if last > 0.0 { (last / whole).sqrt() } else { 0.0 };
        let mut iterations = 0;
        while iterations < MOST_ITERATIONS
            && (0..many).any(|i| share(last[i], whole[i]) > self.options.tolerance)
        {
            check_stopped()?;
            iterations += 1;
            let mut image = self.products(&direction)?;
            image.iter_mut().for_each(|x| self.project(x));
            for i in 0..many {
                let step = product[i] / dot(&direction[i], &image[i]);
                last[i] = 0.0;
                if step.is_finite() && step > 0.0 {
                    last[i] = step * product[i];
                    whole[i] += last[i];
                    plus(&mut solution[i], step, &direction[i]);
                    plus(&mut residual[i], -step, &image[i]);
                }
            }
            conditioned = self.precondition(&residual)?;
            for i in 0..many {
                let before = product[i];
                product[i] = dot(&residual[i], &conditioned[i]);
                let ratio = if before > 0.0 { product[i] / before } else { 0.0 };
                let rest = &conditioned[i];
                for (d, z) in direction[i].iter_mut().zip(rest) {
                    (0..3).for_each(|k| d[k] = z[k] + ratio * d[k]);
                }
            }
        }
        let scale = 1.0 / self.scale();
        for field in &mut solution {
            self.project(field);
            field.iter_mut().for_each(|x| *x = x.map(|x| scale * x));
        }
        let change = (0..many).map(|i| share(last[i], whole[i])).fold(0.0, f64::max);
        Ok((solution, iterations, change))
    }

    /// Two solves around the fractional Laplacian of order `2 - s`.
    ///
    /// Deviation: the Laplacian sees means on faces only, so it vanishes for a function that is 1,
    /// -1 and 0 at the corners of each face; regular triangulations have them. Deviations from the
    /// means are weighted as the Laplacian would; they are small for smooth functions.
    fn precondition(&self, residual: &[Vec<[f64; 3]>]) -> Result<Vec<Vec<[f64; 3]>>, NumericError> {
        let mut inner = self.preconditioner.solve(residual)?;
        inner.iter_mut().for_each(|x| self.clear_pins(x));
        let mut image = self.fractional_products(&inner)?;
        self.elements.add_deviations(self.options.exponents.order() - 1.0, &inner, &mut image);
        image.iter_mut().for_each(|x| self.clear_pins(x));
        let mut outer = self.preconditioner.solve(&image)?;
        for (outer, residual) in outer.iter_mut().zip(residual) {
            if self.drifts() {
                self.add_drift(residual, outer);
            }
            self.project(outer);
        }
        Ok(outer)
    }

    /// Clears a field at the pinned vertices; without any, takes out its mean, unless the surface
    /// drifts.
    fn project(&self, field: &mut [[f64; 3]]) {
        if !self.pinned.is_empty() {
            self.clear_pins(field);
        } else if !self.drifts() {
            centre(field);
        }
    }

    fn drifts(&self) -> bool {
        self.pinned.is_empty() && self.stiffness.drifts && !self.stiffness.diagonal.is_empty()
    }

    /// Adds the translation that balances the sum of the forces: the rest of the preconditioner
    /// takes it to zero.
    fn add_drift(&self, forces: &[[f64; 3]], field: &mut [[f64; 3]]) {
        let stiffness: f64 = self.stiffness.diagonal.iter().sum();
        let sum = forces.iter().fold([0.0; 3], |sum, x| [sum[0] + x[0], sum[1] + x[1], sum[2] + x[2]]);
        field.iter_mut().for_each(|x| (0..3).for_each(|k| x[k] += sum[k] / stiffness));
    }

    fn clear_pins(&self, field: &mut [[f64; 3]]) {
        let pinned = field.iter_mut().zip(&self.pinned).filter(|(_, pinned)| **pinned);
        pinned.for_each(|(x, _)| *x = [0.0; 3]);
    }
}
