//! The inner product in which a step is steepest: solves for given right-hand sides.

use super::Flow;
use super::history::History;
use super::method::Remembers;
use super::options::Barycentre;
use crate::repulsive::error::RepulsiveError;
use crate::repulsive::faces::face_data;
use crate::repulsive::metric::{Bending, LocalMetric, LocalOrder, Metric, Preconditioner, Stiffness};
use crate::repulsive::potential::Potential;
use crate::repulsive::quantity::Quantity;
use eikona_numeric::NumericError;

type Vec3 = [f64; 3];

/// The preconditioner knows nothing of stiff potentials, so its first solutions are rough near
/// them, and steps along these make bad faces.
const STIFF_TOLERANCE: f64 = 0.02;
/// The length of step for which stiff potentials count, at first and at most, in a unit in which
/// the area is 1.
const FIRST_STEP: f64 = 0.1;
const LONGEST_STEP: f64 = 1.0;

/// The inner product of a method at a surface.
pub(super) enum InnerProduct {
    Fractional(Box<Metric>),
    /// That of differential operators, corrected by what L-BFGS remembers.
    Local(Box<LocalMetric>),
}

/// The solutions for some forces.
pub(super) struct Solved {
    pub fields: Vec<Vec<Vec3>>,
    /// The way of the pins, carried on to all vertices.
    pub carried: Option<Vec<Vec3>>,
    /// Iterations of the linear solver.
    pub iterations: usize,
}

impl InnerProduct {
    /// Solves for the displacements with the given products, and carries the way of the pins on to
    /// all vertices.
    pub fn solve(
        &self,
        mut forces: Vec<Vec<Vec3>>,
        ways: Option<Vec<Vec3>>,
        history: &History,
    ) -> Result<Solved, NumericError> {
        match self {
            InnerProduct::Fractional(metric) => {
                if let Some(ways) = &ways {
                    forces.push(metric.force_of(ways)?);
                }
                let (mut fields, iterations, _) = metric.solutions(forces)?;
                let carried = ways.map(|ways| less(ways, &fields.pop().unwrap_or_default()));
                Ok(Solved { fields, carried, iterations })
            }
            InnerProduct::Local(metric) => {
                let fields = history.solve(forces, |forces| metric.solve(forces))?;
                let carry = |ways: Vec<Vec3>| {
                    let response = metric.solve(vec![metric.product(&ways)])?;
                    Ok::<_, NumericError>(less(ways, &response[0]))
                };
                Ok(Solved { fields, carried: ways.map(carry).transpose()?, iterations: 0 })
            }
        }
    }

    /// Whether it holds potentials, so that it moves the surface as a whole, too.
    pub fn is_stiff(&self) -> bool {
        matches!(self, InnerProduct::Fractional(metric) if metric.is_stiff())
    }

    /// The order, given that of the fractional inner product.
    pub fn order(&self, fractional: f64) -> f64 {
        match self {
            InnerProduct::Fractional(_) => fractional,
            InnerProduct::Local(metric) => metric.order(),
        }
    }
}

fn less(mut ways: Vec<Vec3>, response: &[Vec3]) -> Vec<Vec3> {
    ways.iter_mut().zip(response).for_each(|(way, x)| (0..3).for_each(|k| way[k] -= x[k]));
    ways
}

impl Flow {
    /// The inner product here. Where the method remembers steps, the last one is remembered.
    pub(super) fn inner_product(&mut self, rows: &[Vec<Vec3>]) -> Result<InnerProduct, RepulsiveError> {
        let method = self.options.method;
        let Some(order) = method.local_order() else { return self.fractional_inner_product() };
        let metric = self.local_metric(order)?;
        if method.remembers() == Remembers::Steps {
            let (positions, differential) = (self.mesh.positions(), self.current.differential.as_slice());
            self.memory.history.add_step(method, positions, differential, rows, &metric)?;
        }
        Ok(InnerProduct::Local(Box::new(metric)))
    }

    pub(super) fn local_metric(&mut self, order: LocalOrder) -> Result<LocalMetric, NumericError> {
        let pinned = self.pinned();
        let (unit, threads) = (self.current.unit, self.options.threads);
        let metric = LocalMetric::new(order, &self.mesh, unit, threads, self.analysis.as_ref(), pinned)?;
        self.analysis = metric.analysis().or(self.analysis.take());
        Ok(metric)
    }

    fn fractional_inner_product(&mut self) -> Result<InnerProduct, RepulsiveError> {
        let unit = self.current.unit;
        let faces = face_data(&self.mesh, unit, self.options.threads)?;
        let pinned = self.pinned();
        let analysis = self.analysis.as_ref();
        let preconditioner = Preconditioner::new(&self.mesh, unit, self.options.threads, analysis, &pinned)?;
        self.analysis = Some(preconditioner.analysis());
        let tree = self.current.tree(&faces);
        let stiffness = self.stiffness()?;
        let mut options = self.options.metric;
        if !stiffness.is_none() {
            options.tolerance = options.tolerance.min(STIFF_TOLERANCE);
        }
        let metric = Metric::on(&self.mesh, unit, tree, &faces, &options, preconditioner, pinned, stiffness)?;
        Ok(InnerProduct::Fractional(Box::new(metric)))
    }

    /// The second derivatives of the potentials, times the length of the last step.
    ///
    /// Deviation: the published program adds sums of the kernel over the obstacles instead,
    /// whatever their weight. With second derivatives, a step is implicit in the potentials to
    /// first order, and its length does not depend on how stiff they are. That of the Willmore
    /// energy is the bi-Laplacian.
    fn stiffness(&self) -> Result<Stiffness, RepulsiveError> {
        let mut diagonal = vec![0.0; self.mesh.vertex_count()];
        for potential in &self.potentials {
            let own = potential.stiffness(&self.mesh)?;
            diagonal.iter_mut().zip(own.as_slice()).for_each(|(sum, own)| *sum += own);
        }
        if diagonal.iter().all(|x| *x == 0.0) {
            diagonal.clear();
        }
        let bending: f64 = self.potentials.iter().map(Potential::bending).sum();
        if diagonal.is_empty() && bending == 0.0 {
            return Ok(Stiffness::default());
        }
        let bends = bending > 0.0;
        let bending = bends.then(|| Bending::new(&self.mesh, self.current.unit, bending)).transpose()?;
        let exponents = self.options.exponents;
        let power = 2.0 - 2.0 * (exponents.order() - 1.0) - exponents.degree();
        let unit = Quantity::Area.of(&self.mesh).powf(0.5 * power);
        let step = self.memory.step_size.unwrap_or(FIRST_STEP * unit).min(LONGEST_STEP * unit);
        let mut stiffness =
            Stiffness { diagonal, bending, drifts: self.options.barycentre == Barycentre::Free };
        stiffness.scale(step);
        Ok(stiffness)
    }
}
