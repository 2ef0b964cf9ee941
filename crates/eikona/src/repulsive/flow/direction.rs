//! The direction of a step: steepest descent under the constraints (RS equations 14 and 20).

use super::Flow;
use super::constraints::add_translations;
use super::history::{LastStart, lagrangian, product};
use super::inner_product::Solved;
use super::method::Remembers;
use super::options::Barycentre;
use crate::repulsive::error::RepulsiveError;

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
    /// The factor by which L-BFGS scales the inverse of the Laplacian; `None` for steepest descent.
    pub scale: Option<f64>,
}

/// For each constraint, the displacement with the smallest norm that changes it, and how much each
/// changes each constraint (a small dense matrix, the Schur complement).
pub(super) struct Corrections {
    pub fields: Vec<Vec<Vec3>>,
    schur: Vec<Vec<f64>>,
}

impl Corrections {
    pub fn new(rows: &[Vec<Vec3>], fields: Vec<Vec<Vec3>>) -> Corrections {
        let schur = rows.iter().map(|row| fields.iter().map(|field| product(row, field)).collect()).collect();
        Corrections { fields, schur }
    }

    /// Takes the displacement out of a field that changes the constraints by some values. Returns
    /// the multipliers.
    pub fn take_out(&self, values: &[f64], from: &mut [Vec3]) -> Vec<f64> {
        let multipliers = self.multipliers(values);
        for (field, multiplier) in self.fields.iter().zip(&multipliers) {
            for (p, c) in from.iter_mut().zip(field) {
                (0..3).for_each(|k| p[k] -= multiplier * c[k]);
            }
        }
        multipliers
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
        let rows = self.constraints().rows(&self.mesh);
        let inner_product = self.inner_product(&rows)?;
        let differential = self.current.differential.as_slice();
        let quantities = self.quantities.len();
        let (of_quantities, of_centres) = rows.split_at(quantities);
        let mut forces = vec![differential.to_vec()];
        forces.extend(of_quantities.iter().cloned());
        // What L-BFGS remembers mixes coordinates.
        let mixes = self.memory.history.scale().is_some();
        match mixes {
            true => forces.extend(of_centres.iter().cloned()),
            false => forces.extend(of_centres.chunks(3).map(all_axes)),
        }
        let solved = inner_product.solve(forces, self.pin_ways(1.0), &self.memory.history)?;
        let Solved { fields: mut solutions, carried, iterations } = solved;
        let mut fields = solutions.split_off(1);
        if !mixes {
            let of_centres = fields.split_off(quantities);
            fields.extend(of_centres.iter().flat_map(|field| [0, 1, 2].map(|k| one_axis(field, k))));
        }
        let mut motion = solutions.pop().unwrap_or_default();
        let is_stiff = inner_product.is_stiff();
        if self.options.barycentre == Barycentre::Free && self.memory.pins.is_empty() && !is_stiff {
            let order = inner_product.order(self.options.exponents.order());
            add_translations(&self.mesh, &self.memory.components, differential, order, &mut motion);
        }
        self.hold_centre(&self.mesh, &self.memory, std::slice::from_mut(&mut motion));
        self.hold_centre(&self.mesh, &self.memory, &mut fields);
        let corrections = Corrections::new(&rows, fields);
        let changes: Vec<f64> = rows.iter().map(|row| product(row, &motion)).collect();
        let multipliers = corrections.take_out(&changes, &mut motion);
        let descent = product(&motion, differential);
        motion.iter_mut().for_each(|d| *d = d.map(|x| -x));
        let scale = self.memory.history.scale();
        if self.options.method.remembers() == Remembers::Steps {
            let positions = self.mesh.positions().to_vec();
            let differential = lagrangian(differential, &rows, &multipliers);
            self.memory.history.start_at(LastStart { positions, differential, multipliers });
        }
        Ok(Direction { motion, corrections, carried, descent, iterations, scale })
    }
}

/// The sum of three rows, each of which has one coordinate. Inner products act on each coordinate
/// alone, so one solve serves all three.
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
