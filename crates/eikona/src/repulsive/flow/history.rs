//! What methods remember of earlier steps, and the two-loop recursion of L-BFGS.

use super::method::{Method, Remembers};
use crate::repulsive::metric::LocalMetric;
use eikona_numeric::NumericError;
use serde::{Deserialize, Serialize};

type Vec3 = [f64; 3];

/// Steps that L-BFGS remembers.
const MOST_STEPS: usize = 20;
/// A step is remembered only if the cosine of the angle between it and the change of the gradient
/// is larger: the approximation of the Hessian has to stay positive definite.
const LEAST_COSINE: f64 = 1e-8;

/// What a method remembers of earlier steps. It is for one connectivity.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct History {
    last: Option<LastStart>,
    /// The oldest first.
    steps: Vec<PastStep>,
}

/// Where the last step started.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LastStart {
    pub positions: Vec<Vec3>,
    /// That of the Lagrangian; empty for methods that do not use it.
    pub differential: Vec<Vec3>,
    /// One per constraint.
    pub multipliers: Vec<f64>,
}

/// A step, and the change of the differential that it is to explain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct PastStep {
    motion: Vec<Vec3>,
    change: Vec<Vec3>,
    /// Their product, positive.
    curvature: f64,
    /// What to multiply the inverse of the Laplacian with so that it explains the step.
    scale: f64,
}

pub(super) fn product(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a[0] * b[0] + a[1] * b[1] + a[2] * b[2]).sum()
}

/// `a + s b`
fn add(a: &mut [Vec3], s: f64, b: &[Vec3]) {
    a.iter_mut().zip(b).for_each(|(a, b)| (0..3).for_each(|k| a[k] += s * b[k]));
}

fn difference(a: &[Vec3], b: &[Vec3]) -> Vec<Vec3> {
    a.iter().zip(b).map(|(a, b)| [0, 1, 2].map(|k| a[k] - b[k])).collect()
}

/// The differential of the Lagrangian.
pub(super) fn lagrangian(differential: &[Vec3], rows: &[Vec<Vec3>], multipliers: &[f64]) -> Vec<Vec3> {
    let mut sum = differential.to_vec();
    rows.iter().zip(multipliers).for_each(|(row, multiplier)| add(&mut sum, -multiplier, row));
    sum
}

impl History {
    pub fn is_empty(&self) -> bool {
        self.last.is_none() && self.steps.is_empty()
    }

    /// Whether it may be that of a method, on a surface with so many vertices, under so many
    /// constraints.
    pub fn fits(&self, method: Method, vertices: usize, constraints: usize) -> bool {
        let lasts = match method.remembers() {
            Remembers::Nothing => self.last.is_none(),
            Remembers::Surface => self.last.iter().all(|last| last.differential.is_empty()),
            Remembers::Steps => self
                .last
                .iter()
                .all(|last| last.differential.len() == vertices && last.multipliers.len() == constraints),
        };
        let steps = method.remembers() == Remembers::Steps || self.steps.is_empty();
        lasts
            && steps
            && self.last.iter().all(|last| last.positions.len() == vertices)
            && self.steps.iter().all(|step| {
                let lengths = [step.motion.len(), step.change.len()];
                lengths == [vertices; 2] && step.curvature > 0.0 && step.scale > 0.0
            })
    }

    /// The positions where the last step started.
    pub fn last_positions(&self) -> Option<&[Vec3]> {
        self.last.as_ref().map(|last| last.positions.as_slice())
    }

    pub fn start_at(&mut self, start: LastStart) {
        self.last = Some(start);
    }

    /// Remembers the step from the last start to here, unless the objective is not convex along it.
    /// Both differentials are taken with the multipliers of the last start.
    pub fn add_step(
        &mut self,
        method: Method,
        positions: &[Vec3],
        differential: &[Vec3],
        rows: &[Vec<Vec3>],
        metric: &LocalMetric,
    ) -> Result<(), NumericError> {
        let Some(last) = self.last.take() else { return Ok(()) };
        let mut motion = difference(positions, &last.positions);
        let here = lagrangian(differential, rows, &last.multipliers);
        let mut change = difference(&here, &last.differential);
        metric.clear_pins(&mut motion);
        metric.project(&mut change);
        self.last = Some(last);
        let curvature = product(&motion, &change);
        let sizes = product(&motion, &motion) * product(&change, &change);
        if curvature > LEAST_COSINE * sizes.sqrt() {
            self.steps.push(match method {
                Method::Bqn => PastStep::blended(motion, change, curvature, metric),
                _ => PastStep::measured(motion, change, curvature, metric)?,
            });
            self.steps.drain(..self.steps.len().saturating_sub(MOST_STEPS));
        }
        Ok(())
    }

    /// The factor of the inverse of the Laplacian; `None` without any steps.
    pub fn scale(&self) -> Option<f64> {
        self.steps.last().map(|step| step.scale)
    }

    /// Solves with the approximation of the Hessian, given solves with the Laplacian (the two-loop
    /// recursion: Nocedal and Wright, *Numerical Optimization*, algorithm 7.4). Without any steps,
    /// that is the Laplacian.
    ///
    /// The product in H1 of a gradient and a displacement is that of the differential and the
    /// displacement, so no product with the Laplacian is needed.
    pub fn solve<E>(
        &self,
        mut forces: Vec<Vec<Vec3>>,
        laplacian: impl FnOnce(Vec<Vec<Vec3>>) -> Result<Vec<Vec<Vec3>>, E>,
    ) -> Result<Vec<Vec<Vec3>>, E> {
        let mut shares = vec![vec![0.0; self.steps.len()]; forces.len()];
        for (force, shares) in forces.iter_mut().zip(&mut shares) {
            for (step, share) in self.steps.iter().zip(shares).rev() {
                *share = product(&step.motion, force) / step.curvature;
                add(force, -*share, &step.change);
            }
        }
        let mut solutions = laplacian(forces)?;
        let Some(scale) = self.scale() else { return Ok(solutions) };
        for (solution, shares) in solutions.iter_mut().zip(shares) {
            solution.iter_mut().for_each(|x| *x = x.map(|x| scale * x));
            for (step, share) in self.steps.iter().zip(shares) {
                let there = product(&step.change, solution) / step.curvature;
                add(solution, share - there, &step.motion);
            }
        }
        Ok(solutions)
    }
}

impl PastStep {
    /// The step of L-BFGS, with the usual scale.
    fn measured(
        motion: Vec<Vec3>,
        change: Vec<Vec3>,
        curvature: f64,
        metric: &LocalMetric,
    ) -> Result<PastStep, NumericError> {
        let response = metric.solve(vec![change.clone()])?;
        let scale = curvature / product(&change, &response[0]);
        Ok(PastStep { motion, change, curvature, scale })
    }

    /// The step of blended quasi-Newton: `(1 - b) y + b t L s`, where s is the motion, y the
    /// change, t makes the curvature along s that of y, and b is the coefficient of the projection
    /// of y on `t L s`, within 0 and 1.
    fn blended(motion: Vec<Vec3>, mut change: Vec<Vec3>, curvature: f64, metric: &LocalMetric) -> PastStep {
        let mut predicted = metric.product(&motion);
        metric.project(&mut predicted);
        let scale = product(&motion, &predicted) / curvature;
        predicted.iter_mut().for_each(|x| *x = x.map(|x| x / scale));
        let share = product(&change, &predicted) / product(&predicted, &predicted);
        let share = share.clamp(0.0, 1.0);
        add(&mut predicted, -1.0, &change);
        add(&mut change, share, &predicted);
        PastStep { curvature: product(&motion, &change), motion, change, scale }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::repulsive::metric::LocalOrder;
    use eikona_mesh::shapes;

    fn noise(count: usize, seed: f64) -> Vec<Vec3> {
        (0..count).map(|v| [0.3, 0.7, 1.1].map(|x| (x * (v * v) as f64 + seed).sin())).collect()
    }

    #[test]
    fn the_last_step_is_explained() {
        let mesh = shapes::icosphere(2).unwrap();
        let count = mesh.vertex_count();
        let metric = LocalMetric::new(LocalOrder::One, &mesh, 1.0, 1, None, vec![]).unwrap();
        for method in [Method::H1Lbfgs, Method::Bqn] {
            let mut history = History::default();
            // An objective whose Hessian is 3 L + 1.
            let differential = |x: &[Vec3]| {
                let mut image = metric.product(x);
                image.iter_mut().zip(x).for_each(|(y, x)| (0..3).for_each(|k| y[k] = 3.0 * y[k] + x[k]));
                image
            };
            for k in 0..25 {
                let mut positions = noise(count, f64::from(k));
                metric.project(&mut positions);
                let here = differential(&positions);
                history.add_step(method, &positions, &here, &[], &metric).unwrap();
                history.start_at(LastStart { positions, differential: here, multipliers: vec![] });
            }
            assert_eq!(history.steps.len(), MOST_STEPS);
            assert!(history.fits(method, count, 0) && !history.fits(Method::Aqp, count, 0));
            let PastStep { motion, change, .. } = history.steps.last().unwrap().clone();
            let response = history.solve(vec![change], |forces| metric.solve(forces)).unwrap().remove(0);
            let off = response.iter().flatten().zip(motion.iter().flatten()).map(|(a, b)| (a - b).abs());
            assert!(off.fold(0.0, f64::max) < 1e-10, "{method}");
        }
    }

    #[test]
    fn quadratic_objectives_are_minimised_in_as_many_steps_as_unknowns() {
        // Of 12 unknowns, with exact line searches.
        let hessian = |x: &[Vec3]| -> Vec<Vec3> {
            (0..4).map(|v| [0, 1, 2].map(|k| (1 + 3 * v + k) as f64 * x[v][k] + x[3 - v][2 - k])).collect()
        };
        let mut history = History::default();
        let mut x = noise(4, 0.5);
        let first = product(&x, &hessian(&x));
        for _ in 0..12 {
            let differential = hessian(&x);
            let mut motion = history.solve(vec![differential.clone()], Ok::<_, ()>).unwrap().remove(0);
            let size = -product(&motion, &differential) / product(&motion, &hessian(&motion));
            motion.iter_mut().for_each(|d| *d = d.map(|d| size * d));
            add(&mut x, 1.0, &motion);
            let change = hessian(&motion);
            let curvature = product(&motion, &change);
            history.steps.push(PastStep { motion, change, curvature, scale: 1.0 });
        }
        assert!(product(&x, &hessian(&x)) < 1e-20 * first);
    }

    #[test]
    fn steps_of_negative_curvature_are_not_remembered() {
        let mesh = shapes::icosphere(1).unwrap();
        let metric = LocalMetric::new(LocalOrder::One, &mesh, 1.0, 1, None, vec![]).unwrap();
        let mut history = History::default();
        let positions = mesh.positions().to_vec();
        let downwards = |x: &[Vec3]| x.iter().map(|x| x.map(|x| -x)).collect::<Vec<Vec3>>();
        let differential = downwards(&positions);
        history.start_at(LastStart { positions, differential, multipliers: vec![] });
        let moved = noise(mesh.vertex_count(), 0.1);
        history.add_step(Method::H1Lbfgs, &moved, &downwards(&moved), &[], &metric).unwrap();
        assert!(history.scale().is_none());
    }
}
