//! Steps of methods that remember earlier ones.

use super::direction::Corrections;
use super::history::{History, LastStart};
use super::line_search::moved_along;
use super::method::Remembers;
use super::objective::Current;
use super::{Flow, FlowStep};
use crate::geometry::vector::sub;
use crate::repulsive::error::RepulsiveError;
use crate::repulsive::metric::LocalOrder;
use eikona_mesh::TriangleMesh;
use eikona_numeric::begin_phase;

type Vec3 = [f64; 3];

/// The condition number that AQP assumes: kappa of Kovalsky et al., section 3.
const CONDITION: f64 = 100.0;
/// An extrapolation is halved so often, then left out.
const HALVINGS: usize = 3;

impl Flow {
    /// A step. If it leads nowhere, one without what is remembered.
    pub(super) fn step_with_history(&mut self) -> Result<Option<FlowStep>, RepulsiveError> {
        let before = self.memory.history.clone();
        let mut done = self.extrapolated_step();
        if matches!(done, Ok(None)) && !before.is_empty() {
            self.memory.history = History::default();
            done = self.extrapolated_step();
        }
        if !matches!(done, Ok(Some(_))) {
            self.memory.history = before;
        }
        done
    }

    /// A step from the extrapolated surface, if the method has one. Unless it succeeds, the surface
    /// stays as it is.
    fn extrapolated_step(&mut self) -> Result<Option<FlowStep>, RepulsiveError> {
        if self.options.method.remembers() != Remembers::Surface {
            return self.descend();
        }
        let start = self.extrapolation()?;
        let positions = self.mesh.positions().to_vec();
        self.memory.history.start_at(LastStart { positions, differential: vec![], multipliers: vec![] });
        let kept = start.map(|(mesh, current)| {
            (std::mem::replace(&mut self.mesh, mesh), std::mem::replace(&mut self.current, current))
        });
        let done = self.descend();
        if !matches!(done, Ok(Some(_)))
            && let Some(kept) = kept
        {
            (self.mesh, self.current) = kept;
        }
        done
    }

    /// The surface beyond the current one on the line from where the last step started: at once, or
    /// after halvings, it meets the constraints, has no higher objective, and is reached without
    /// collisions. `None` if there is none.
    fn extrapolation(&mut self) -> Result<Option<(TriangleMesh, Current)>, RepulsiveError> {
        let Some(last) = self.memory.history.last_positions() else { return Ok(None) };
        begin_phase("extrapolation")?;
        let mut ways: Vec<Vec3> =
            self.mesh.positions().iter().zip(last).map(|(here, last)| sub(*here, *last)).collect();
        let rows = self.constraints().rows(&self.mesh);
        let metric = self.local_metric(LocalOrder::One)?;
        metric.clear_pins(&mut ways);
        let corrections = Corrections::new(&rows, metric.solve(rows.clone())?);
        let root = CONDITION.sqrt().recip();
        let mut share = (1.0 - root) / (1.0 + root);
        for _ in 0..=HALVINGS {
            if let Some(found) = self.extrapolated(&ways, share, &corrections)? {
                return Ok(Some(found));
            }
            share *= 0.5;
        }
        Ok(None)
    }

    fn extrapolated(
        &self,
        ways: &[Vec3],
        share: f64,
        corrections: &Corrections,
    ) -> Result<Option<(TriangleMesh, Current)>, RepulsiveError> {
        let positions = moved_along(self.mesh.positions(), Some(ways), share);
        let targets = self.targets_at(&self.memory, self.memory.time);
        let met = self.corrected(&self.mesh, positions, &self.constraints(), corrections, &targets)?;
        let Some((mesh, _)) = met else { return Ok(None) };
        let highest = self.current.objective;
        match self.current.objective_of(&mesh, &self.potentials) {
            Err(RepulsiveError::Numeric(stopped)) => return Err(stopped.into()),
            Ok(objective) if objective <= highest => {}
            _ => return Ok(None),
        }
        if self.safe_share(&mesh)? < 1.0 {
            return Ok(None);
        }
        Ok(self.current_at(&mesh, &self.potentials, highest)?.map(|current| (mesh, current)))
    }
}
