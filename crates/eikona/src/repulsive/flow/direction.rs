//! The direction of a step: steepest descent under the constraints (RS equations 14 and 20).

use super::Flow;
use super::constraints::add_translations;
use super::options::Barycentre;
use crate::repulsive::error::RepulsiveError;
use crate::repulsive::faces::face_data;
use crate::repulsive::metric::{Metric, Preconditioner, Stiffness};
use crate::repulsive::quantity::Quantity;

type Vec3 = [f64; 3];

/// A direction of descent that keeps the constraints to first order.
pub(super) struct Direction {
    pub motion: Vec<Vec3>,
    pub corrections: Corrections,
    /// The way of the pins in this step, carried on to all vertices; `None` if no pin moves.
    pub carried: Option<Vec<Vec3>>,
    /// The rate at which the objective falls.
    pub descent: f64,
    /// Iterations of the linear solver.
    pub iterations: usize,
}

/// For each constraint, the displacement with the smallest norm that changes it, and how much each
/// changes each constraint (a small dense matrix, the Schur complement).
pub(super) struct Corrections {
    pub fields: Vec<Vec<Vec3>>,
    schur: Vec<Vec<f64>>,
}

pub(super) fn product(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a[0] * b[0] + a[1] * b[1] + a[2] * b[2]).sum()
}

impl Corrections {
    pub fn new(rows: &[Vec<Vec3>], fields: Vec<Vec<Vec3>>) -> Corrections {
        let schur = rows.iter().map(|row| fields.iter().map(|field| product(row, field)).collect()).collect();
        Corrections { fields, schur }
    }

    /// Takes the displacement out of a field that changes the constraints by some values.
    pub fn take_out(&self, values: &[f64], from: &mut [Vec3]) {
        for (field, multiplier) in self.fields.iter().zip(self.multipliers(values)) {
            for (p, c) in from.iter_mut().zip(field) {
                (0..3).for_each(|k| p[k] -= multiplier * c[k]);
            }
        }
    }

    /// Solves by elimination with pivoting. Directions that change nothing get nothing.
    fn multipliers(&self, values: &[f64]) -> Vec<f64> {
        let n = values.len();
        // Scaled to a unit diagonal: areas, volumes and coordinates differ in size.
        let scales: Vec<f64> = (0..n).map(|k| self.schur[k][k].abs().sqrt()).collect();
        let scale = |k: usize| if scales[k] > 0.0 { 1.0 / scales[k] } else { 0.0 };
        let row = |i: usize| {
            let entries = (0..n).map(move |j| self.schur[i][j] * scale(i) * scale(j));
            entries.chain([values[i] * scale(i)]).collect::<Vec<f64>>()
        };
        let mut rows: Vec<Vec<f64>> = (0..n).map(row).collect();
        for k in 0..n {
            let pivot = (k..n).max_by(|&i, &j| rows[i][k].abs().total_cmp(&rows[j][k].abs())).unwrap_or(k);
            rows.swap(k, pivot);
            if rows[k][k].abs() <= 1e-13 {
                rows[k].iter_mut().for_each(|x| *x = 0.0);
                rows[k][k] = 1.0;
            }
            for i in (0..n).filter(|i| *i != k) {
                let factor = rows[i][k] / rows[k][k];
                for j in k..=n {
                    rows[i][j] -= factor * rows[k][j];
                }
            }
        }
        (0..n).map(|k| rows[k][n] / rows[k][k] * scale(k)).collect()
    }
}

impl Flow {
    /// Solves for the direction, for the corrections, and for what pins carry along, in common.
    pub(super) fn direction(&mut self) -> Result<Direction, RepulsiveError> {
        let unit = self.current.unit;
        let faces = face_data(&self.mesh, unit)?;
        let pinned = self.pinned();
        let analysis = self.analysis.as_ref();
        let preconditioner = Preconditioner::new(&self.mesh, unit, self.options.threads, analysis, &pinned)?;
        self.analysis = Some(preconditioner.analysis());
        let tree = self.current.interactions.tree.clone();
        let stiffness = self.stiffness()?;
        let is_stiff = !stiffness.diagonal.is_empty();
        let mut options = self.options.metric;
        if is_stiff {
            options.tolerance = options.tolerance.min(STIFF_TOLERANCE);
        }
        let metric = Metric::on(&self.mesh, unit, tree, &faces, &options, preconditioner, pinned, stiffness)?;
        let differential = self.current.differential.as_slice();
        let constraints = self.constraints();
        let rows = constraints.rows(&self.mesh);
        let quantities = constraints.quantities.len();
        let (of_quantities, of_centres) = rows.split_at(quantities);
        let mut forces = vec![differential.to_vec()];
        forces.extend(of_quantities.iter().cloned());
        forces.extend(of_centres.chunks(3).map(all_axes));
        let ways = self.pin_ways(1.0);
        if let Some(ways) = &ways {
            forces.push(metric.force_of(ways)?);
        }
        let (mut solutions, iterations, _) = metric.solutions(forces)?;
        let carried = ways.map(|mut ways| {
            let response = solutions.pop().unwrap_or_default();
            ways.iter_mut().zip(response).for_each(|(way, x)| (0..3).for_each(|k| way[k] -= x[k]));
            ways
        });
        let mut fields = solutions.split_off(1);
        let of_centres = fields.split_off(quantities);
        fields.extend(of_centres.iter().flat_map(|field| [0, 1, 2].map(|k| one_axis(field, k))));
        let mut motion = solutions.pop().unwrap_or_default();
        if self.options.barycentre == Barycentre::Free && self.memory.pins.is_empty() && !is_stiff {
            let order = self.options.exponents.order();
            add_translations(&self.mesh, &self.memory.components, differential, order, &mut motion);
        }
        let corrections = Corrections::new(&rows, fields);
        let changes: Vec<f64> = rows.iter().map(|row| product(row, &motion)).collect();
        corrections.take_out(&changes, &mut motion);
        let descent = product(&motion, differential);
        motion.iter_mut().for_each(|d| *d = d.map(|x| -x));
        Ok(Direction { motion, corrections, carried, descent, iterations })
    }
}

/// The preconditioner knows nothing of stiff potentials, so its first solutions are rough near
/// them, and steps along these make bad faces.
const STIFF_TOLERANCE: f64 = 0.02;
/// The length of step for which stiff potentials count, at first and at most, in a unit in which
/// the area is 1.
const FIRST_STEP: f64 = 0.1;
const LONGEST_STEP: f64 = 1.0;

impl Flow {
    /// The second derivatives of the potentials, times the length of the last step.
    ///
    /// Deviation: the published program adds sums of the kernel over the obstacles instead,
    /// whatever their weight. With second derivatives, a step is implicit in the potentials to
    /// first order, and its length does not depend on how stiff they are.
    fn stiffness(&self) -> Result<Stiffness, RepulsiveError> {
        let mut diagonal = vec![0.0; self.mesh.vertex_count()];
        for potential in &self.potentials {
            let own = potential.stiffness(&self.mesh)?;
            diagonal.iter_mut().zip(own.as_slice()).for_each(|(sum, own)| *sum += own);
        }
        if diagonal.iter().all(|x| *x == 0.0) {
            return Ok(Stiffness::default());
        }
        let exponents = self.options.exponents;
        let power = 2.0 - 2.0 * (exponents.order() - 1.0) - exponents.degree();
        let unit = Quantity::Area.of(&self.mesh).powf(0.5 * power);
        let step = self.memory.step_size.unwrap_or(FIRST_STEP * unit).min(LONGEST_STEP * unit);
        diagonal.iter_mut().for_each(|x| *x *= step);
        Ok(Stiffness { diagonal, drifts: self.options.barycentre == Barycentre::Free })
    }
}

/// The sum of three rows, each of which has one coordinate. The inner product acts on each
/// coordinate alone, so one solve serves all three.
fn all_axes(rows: &[Vec<Vec3>]) -> Vec<Vec3> {
    (0..rows[0].len()).map(|v| [0, 1, 2].map(|k| rows[k][v][k])).collect()
}

fn one_axis(field: &[Vec3], k: usize) -> Vec<Vec3> {
    let only = |x: &Vec3| {
        let mut own = [0.0; 3];
        own[k] = x[k];
        own
    };
    field.iter().map(only).collect()
}
