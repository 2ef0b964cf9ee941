//! Solves with the inner product: conjugate gradients with the preconditioner of RS section 5.2.

use super::Metric;
use super::laplacian::ScreenedLaplacian;
use crate::operators::CotanLaplacian;
use crate::repulsive::error::RepulsiveError;
use eikona_mesh::{TriangleMesh, VertexField};
use eikona_numeric::{
    Cholesky, Graph, NumericError, Ordering, Symbolic, check_stopped, for_chunks, side_by_side,
};
use std::sync::Arc;

type Vec3 = [f64; 3];

/// The factor of `C + m M`, where C is the cotan Laplacian and M the lumped mass.
///
/// Deviation: the paper factors C under constraints on positions. The mass gives each connected
/// component its own mean without them.
pub(in crate::repulsive) struct Preconditioner {
    factor: Cholesky<f64>,
    threads: usize,
}

/// The factor of the diagonal by which pinned vertices are held in the preconditioner.
const STIFF: f64 = 1e8;

/// The symbolic analysis, which depends on the connectivity only.
pub(in crate::repulsive) type Analysis = Arc<Symbolic>;

fn analysis_of(graph: &Graph) -> Result<Analysis, NumericError> {
    Ok(Arc::new(Symbolic::new(graph, Ordering::MinimumDegree)?))
}

impl Preconditioner {
    /// Factors the matrix, with the analysis of another surface of the same connectivity.
    pub fn new(
        mesh: &TriangleMesh,
        unit: f64,
        threads: usize,
        analysis: Option<&Analysis>,
        pinned: &[bool],
    ) -> Result<Preconditioner, NumericError> {
        let analyse = || analysis.cloned().map_or_else(|| analysis_of(&CotanLaplacian::graph_of(mesh)), Ok);
        let (analysis, laplacian) = side_by_side(threads, analyse, || ScreenedLaplacian::new(mesh, unit));
        Preconditioner::factored(&laplacian?, threads, Some(&analysis?), pinned)
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
            None => analysis_of(&laplacian.graph)?,
        };
        let mut matrix = laplacian.matrix.clone();
        matrix.diagonal.iter_mut().zip(pinned).filter(|(_, p)| **p).for_each(|(x, _)| *x *= STIFF);
        Ok(Preconditioner { factor: Cholesky::on_threads(symbolic, &matrix, threads)?, threads })
    }

    /// The analysis, for surfaces of the same connectivity.
    pub fn analysis(&self) -> Analysis {
        self.factor.symbolic().clone()
    }

    /// Solves for the coordinates of some vector fields.
    pub fn solve(&self, fields: &[impl AsRef<[Vec3]> + Sync]) -> Result<Vec<Vec<Vec3>>, NumericError> {
        let mut rhs = vec![Vec::new(); 3 * fields.len()];
        for_chunks(self.threads, &mut rhs, 3, |field, coordinates| {
            for (k, coordinate) in coordinates.iter_mut().enumerate() {
                *coordinate = fields[field].as_ref().iter().map(|x| x[k]).collect();
            }
            check_stopped()
        })?;
        let coordinates = self.factor.solve_many(&rhs)?;
        let mut solutions = vec![Vec::new(); fields.len()];
        for_chunks(self.threads, &mut solutions, 1, |field, solution| {
            let [x, y, z] = [0, 1, 2].map(|k| &coordinates[3 * field + k]);
            solution[0] = x.iter().zip(y).zip(z).map(|((x, y), z)| [*x, *y, *z]).collect();
            check_stopped()
        })?;
        Ok(solutions)
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

/// Conjugate gradients for one right-hand side.
struct Column {
    solution: Vec<Vec3>,
    residual: Vec<Vec3>,
    direction: Vec<Vec3>,
    /// That of the residual with the preconditioned one.
    product: f64,
    /// The squared norm of the solution, and of the last change to it, in the norm of A. Changes
    /// are orthogonal in it, so the error is about that of the next ones.
    whole: f64,
    last: f64,
}

impl Column {
    fn new(residual: Vec<Vec3>) -> Column {
        let solution = vec![[0.0; 3]; residual.len()];
        Column { solution, residual, direction: Vec::new(), product: 0.0, whole: 0.0, last: 0.0 }
    }

    fn start(&mut self, conditioned: &mut Vec<Vec3>) {
        self.product = dot(&self.residual, conditioned);
        self.last = self.product;
        self.direction = std::mem::take(conditioned);
    }

    /// Goes along the direction, whose product is given.
    fn advance(&mut self, image: &[Vec3]) {
        let step = self.product / dot(&self.direction, image);
        self.last = 0.0;
        if step.is_finite() && step > 0.0 {
            self.last = step * self.product;
            self.whole += self.last;
            plus(&mut self.solution, step, &self.direction);
            plus(&mut self.residual, -step, image);
        }
    }

    /// Turns the direction, given the preconditioned residual.
    fn turn(&mut self, conditioned: &[Vec3]) {
        let before = self.product;
        self.product = dot(&self.residual, conditioned);
        let ratio = if before > 0.0 { self.product / before } else { 0.0 };
        for (d, z) in self.direction.iter_mut().zip(conditioned) {
            (0..3).for_each(|k| d[k] = z[k] + ratio * d[k]);
        }
    }

    /// The last change, as a share of the solution.
    fn change(&self) -> f64 {
        if self.last > 0.0 { (self.last / self.whole).sqrt() } else { 0.0 }
    }
}

fn of_columns(columns: &[Column], field: impl Fn(&Column) -> &Vec<Vec3>) -> Vec<&[Vec3]> {
    columns.iter().map(|column| field(column).as_slice()).collect()
}

/// Does some work for all columns, each with a field of its own.
fn with_columns(
    threads: usize,
    columns: &mut [Column],
    fields: Vec<Vec<Vec3>>,
    work: impl Fn(&mut Column, &mut Vec<Vec3>) + Sync,
) -> Result<(), NumericError> {
    let mut pairs: Vec<(&mut Column, Vec<Vec3>)> = columns.iter_mut().zip(fields).collect();
    for_chunks(threads, &mut pairs, 1, |_, pair| {
        let (column, field) = &mut pair[0];
        work(column, field);
        check_stopped()
    })
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
        let threads = self.options.threads;
        let mut columns: Vec<Column> = forces.into_iter().map(Column::new).collect();
        columns.iter_mut().for_each(|column| self.project(&mut column.residual));
        let conditioned = self.precondition(&of_columns(&columns, |column| &column.residual))?;
        with_columns(threads, &mut columns, conditioned, |column, conditioned| column.start(conditioned))?;
        let mut iterations = 0;
        while iterations < MOST_ITERATIONS
            && columns.iter().any(|column| column.change() > self.options.tolerance)
        {
            check_stopped()?;
            iterations += 1;
            let images = self.products(&of_columns(&columns, |column| &column.direction))?;
            with_columns(threads, &mut columns, images, |column, image| {
                self.project(image);
                column.advance(image);
            })?;
            let conditioned = self.precondition(&of_columns(&columns, |column| &column.residual))?;
            with_columns(threads, &mut columns, conditioned, |column, conditioned| column.turn(conditioned))?;
        }
        let change = columns.iter().map(Column::change).fold(0.0, f64::max);
        let scale = 1.0 / self.scale();
        let solution = |mut column: Column| {
            self.project(&mut column.solution);
            column.solution.iter_mut().for_each(|x| *x = x.map(|x| scale * x));
            column.solution
        };
        Ok((columns.into_iter().map(solution).collect(), iterations, change))
    }

    /// Two solves around the fractional Laplacian of order `2 - s`.
    ///
    /// Deviation: the Laplacian sees means on faces only, so it vanishes for a function that is 1,
    /// -1 and 0 at the corners of each face; regular triangulations have them. Deviations from the
    /// means are weighted as the Laplacian would; they are small for smooth functions.
    fn precondition(&self, residual: &[&[Vec3]]) -> Result<Vec<Vec<Vec3>>, NumericError> {
        let mut inner = self.preconditioner.solve(residual)?;
        inner.iter_mut().for_each(|x| self.clear_pins(x));
        let fields: Vec<&[Vec3]> = inner.iter().map(Vec::as_slice).collect();
        let mut image = self.fractional_products(&fields)?;
        self.elements.add_deviations(&self.deviations, &fields, &mut image)?;
        image.iter_mut().for_each(|x| self.clear_pins(x));
        let mut outer = self.preconditioner.solve(&image)?;
        for_chunks(self.options.threads, &mut outer, 1, |i, outer| {
            if self.drifts() {
                self.add_drift(residual[i], &mut outer[0]);
            }
            self.project(&mut outer[0]);
            check_stopped()
        })?;
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
