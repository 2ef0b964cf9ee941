//! The line search along a direction: a step that lowers the objective, meets the constraints and
//! touches nothing.
//!
//! What grows or moves on its own does so first ([`Base`]). Then the surface goes along the
//! direction, is corrected, and is remeshed.

use super::constraints::{Constraints, held_centre, holds_barycentre};
use super::direction::{Corrections, Direction};
use super::objective::{Current, potentials_on};
use super::state::Memory;
use super::{Flow, FlowStep};
use crate::geometry::vector::{norm, sub};
use crate::remesh::RemeshCounts;
use crate::repulsive::error::RepulsiveError;
use crate::repulsive::metric::Analysis;
use crate::repulsive::potential::Potential;
use crate::repulsive::quantity::Quantity;
use crate::spatial::{safe_motion, safe_motion_past};
use eikona_mesh::TriangleMesh;
use eikona_numeric::{begin_phase, check_stopped};

type Vec3 = [f64; 3];

/// The energy has to fall by this share of what its slope promises.
const ARMIJO: f64 = 1e-4;
/// Constraints may be missed by this share.
const DEVIATION: f64 = 1e-9;
/// Corrections of a step to meet the constraints.
const CORRECTIONS: usize = 8;
/// The farthest that a vertex moves in a step, as a share of the square root of the area: pieces
/// that nothing holds together would fly away.
const LONGEST: f64 = 0.5;
/// The energy with new clusters may be higher by this share, which is about its error.
const RISE: f64 = 1e-3;
/// The energy of a remeshed surface may be higher by this share: other faces sample it differently.
/// The share doubles each time that it was not enough, since the longer faces go without, the more
/// remeshing changes.
const REMESHED_RISE: f64 = 0.02;
const MOST_DOUBLINGS: u32 = 8;
/// Shorter steps than this share of the first one tried are not tried.
const SHORTEST: f64 = 1e-12;
/// While the surface grows, steps down the objective that are shorter than this are left out.
const SHORTEST_IN_GROWTH: f64 = 1e-3;
/// Growth by less than this share of what a step should bring is put off.
const LEAST_GROWTH: f64 = 1e-3;

/// A step that has been tried.
enum Tried {
    /// The surface cannot be moved so far, or cannot meet the constraints there.
    Impossible,
    /// The energy, which is not low enough.
    TooHigh(f64),
    /// Only a share of the way is free of collisions.
    Collides(f64),
    /// The moved surface, and its deviation from the constraints.
    Done(TriangleMesh, f64),
}

/// Where a step starts that lets the surface grow: its constraints are met there already.
struct Base {
    share: f64,
    targets: Vec<f64>,
    positions: Vec<Vec3>,
    objective: f64,
}

/// Where a step ends.
struct Settled {
    mesh: TriangleMesh,
    memory: Memory,
    potentials: Vec<Potential>,
    current: Current,
    analysis: Option<Analysis>,
    deviation: f64,
    remeshing: Option<RemeshCounts>,
}

impl Flow {
    /// Takes one step from the surface as it is.
    pub(super) fn descend(&mut self) -> Result<Option<FlowStep>, RepulsiveError> {
        begin_phase("direction")?;
        let direction = self.direction()?;
        let grows = self.is_growing();
        if direction.descent.is_nan() || (direction.descent <= 0.0 && !grows) {
            return Ok(None);
        }
        begin_phase("line search")?;
        let first = self.first_step(&direction);
        let mut size = if direction.descent > 0.0 { first } else { 0.0 };
        let mut base = self.base(&direction, if grows { 1.0 } else { 0.0 })?;
        let (mut limited_by_collision, mut backtracks) = (false, 0);
        while size > SHORTEST * first || (size == 0.0 && base.share > 0.0) {
            check_stopped()?;
            // The direction may be none of descent from where growth has taken the surface.
            if base.share > 0.0 && size < SHORTEST_IN_GROWTH * first {
                size = 0.0;
            }
            match self.tried(&direction, &base, size)? {
                Tried::Impossible => {
                    backtracks += 1;
                    (size, base) = self.shorter(&direction, size, base)?;
                }
                // The minimum of the parabola through both values and the slope.
                Tried::TooHigh(objective) => {
                    let promised = size * direction.descent;
                    let excess = objective - base.objective + promised;
                    (size, backtracks) = (size * (0.5 * promised / excess).clamp(0.1, 0.5), backtracks + 1);
                }
                Tried::Collides(safe) => {
                    limited_by_collision = true;
                    size *= safe.min(0.9);
                    if base.share > 0.0 {
                        base = self.base(&direction, base.share * safe.min(0.9))?;
                    }
                }
                Tried::Done(moved, deviation) => {
                    // If not: clusters that were far no longer are.
                    let Some(settled) = self.settled(moved, deviation, &base)? else {
                        backtracks += 1;
                        (size, base) = self.shorter(&direction, size, base)?;
                        continue;
                    };
                    let step = FlowStep {
                        energy: settled.current.energy,
                        objective: settled.current.objective,
                        step_size: size,
                        descent: direction.descent,
                        solver_iterations: direction.iterations,
                        backtracks,
                        limited_by_collision,
                        deviation: settled.deviation,
                        remeshing: settled.remeshing,
                        growth: base.share,
                    };
                    self.memory = settled.memory;
                    // A step without descent says nothing about the length of the next one.
                    if size > 0.0 {
                        self.memory.step_size = Some(size * direction.scale.unwrap_or(1.0));
                    }
                    (self.mesh, self.current) = (settled.mesh, settled.current);
                    (self.potentials, self.analysis) = (settled.potentials, settled.analysis);
                    return Ok(Some(step));
                }
            }
        }
        Ok(None)
    }

    /// Twice the last step, or 1 where steps are those of Newton; at first, one that would lower
    /// the energy to zero if it fell at the rate at its start. No vertex moves farther than
    /// [`LONGEST`].
    fn first_step(&self, direction: &Direction) -> f64 {
        let Direction { motion, descent, scale, .. } = direction;
        let fastest = motion.iter().map(|d| norm(*d)).fold(0.0, f64::max);
        let far = LONGEST * Quantity::Area.of(&self.mesh).sqrt() / fastest;
        let to_zero = self.current.energy.max(self.current.objective.abs()) / descent;
        let usual = scale.map(|_| 1.0).or(self.memory.step_size.map(|last| 2.0 * last));
        usual.map_or(to_zero, |usual| to_zero.min(usual)).min(far)
    }

    /// A shorter step, or one with less growth if it has no other part.
    fn shorter(&self, direction: &Direction, size: f64, base: Base) -> Result<(f64, Base), RepulsiveError> {
        if size > 0.0 {
            return Ok((0.25 * size, base));
        }
        Ok((0.0, self.base(direction, 0.25 * base.share)?))
    }

    /// Lets the surface grow, and moves its pins, by a share of what a step should bring. If it
    /// cannot, the share gets smaller.
    fn base(&self, direction: &Direction, mut share: f64) -> Result<Base, RepulsiveError> {
        while share > LEAST_GROWTH {
            let targets = self.targets_at(&self.memory, self.memory.time + share);
            let positions = moved_along(self.mesh.positions(), direction.carried.as_deref(), share);
            let corrections = &direction.corrections;
            let met = self.corrected(&self.mesh, positions, &self.constraints(), corrections, &targets)?;
            if let Some((mesh, _)) = met {
                match self.current.objective_of(&mesh, &self.potentials) {
                    Ok(objective) => {
                        let positions = mesh.positions().to_vec();
                        return Ok(Base { share, targets, positions, objective });
                    }
                    Err(RepulsiveError::Numeric(stopped)) => return Err(stopped.into()),
                    Err(_) => {}
                }
            }
            share *= 0.5;
        }
        Ok(Base {
            share: 0.0,
            targets: self.targets_at(&self.memory, self.memory.time),
            positions: self.mesh.positions().to_vec(),
            objective: self.current.objective,
        })
    }

    /// Tries a step.
    fn tried(&self, direction: &Direction, base: &Base, size: f64) -> Result<Tried, RepulsiveError> {
        let positions = moved_along(&base.positions, Some(&direction.motion), size);
        let met = self.corrected(
            &self.mesh,
            positions,
            &self.constraints(),
            &direction.corrections,
            &base.targets,
        )?;
        let Some((moved, deviation)) = met else { return Ok(Tried::Impossible) };
        match self.current.objective_of(&moved, &self.potentials) {
            Err(RepulsiveError::Numeric(stopped)) => return Err(stopped.into()),
            Err(_) => return Ok(Tried::Impossible),
            // Growth alone may have any objective.
            Ok(objective) if size > 0.0 && objective > base.objective - ARMIJO * size * direction.descent => {
                return Ok(Tried::TooHigh(objective));
            }
            Ok(_) => {}
        }
        // Last, since it costs more than an energy, and the more the longer the step.
        let safe = self.safe_share(&moved)?;
        if safe < 1.0 {
            return Ok(Tried::Collides(safe));
        }
        Ok(Tried::Done(moved, deviation))
    }

    /// The share of the way to a moved surface that is free of collisions: 1 if they are allowed.
    pub(super) fn safe_share(&self, moved: &TriangleMesh) -> Result<f64, RepulsiveError> {
        if !self.options.collisions {
            return Ok(1.0);
        }
        let ways = moved.positions().iter().zip(self.mesh.positions());
        let ways: Vec<Vec3> = ways.map(|(to, from)| sub(*to, *from)).collect();
        let threads = self.options.threads;
        let share = match &self.options.obstacle {
            Some(obstacle) => safe_motion_past(&self.mesh, &ways, obstacle, threads)?.share,
            None => safe_motion(&self.mesh, &ways, threads)?.share,
        };
        Ok(share.min(self.barriers.safe_share(&self.mesh, &ways)?))
    }

    /// Remeshes the moved surface, if asked, and computes its energy with new clusters. `None` if
    /// that is too high.
    fn settled(
        &self,
        moved: TriangleMesh,
        deviation: f64,
        base: &Base,
    ) -> Result<Option<Settled>, RepulsiveError> {
        let memory = Memory { time: self.memory.time + base.share, ..self.memory.clone() };
        let highest = base.objective.max(self.current.objective);
        begin_phase("remeshing")?;
        let remeshed = self.remeshed(&moved, &memory)?;
        begin_phase("energy")?;
        if let Some(done) = remeshed {
            let rise = REMESHED_RISE * 2f64.powi(self.memory.rejections.min(MOST_DOUBLINGS) as i32);
            let highest = highest + rise * self.current.energy;
            let potentials = potentials_on(&self.start, done.mesh.triangles(), &done.memory, &self.options);
            if let Ok(potentials) = potentials
                && let Some(current) = self.current_at(&done.mesh, &potentials, highest)?
            {
                return Ok(Some(Settled {
                    mesh: done.mesh,
                    memory: Memory { rejections: 0, ..done.memory },
                    potentials,
                    current,
                    analysis: Some(done.analysis),
                    deviation: done.deviation,
                    remeshing: Some(done.counts),
                }));
            }
        }
        let highest = highest + RISE * self.current.energy;
        let current = self.current_at(&moved, &self.potentials, highest)?;
        let rejections = self.memory.rejections + 1;
        Ok(current.map(|current| Settled {
            mesh: moved,
            memory: Memory { rejections, ..memory },
            potentials: self.potentials.clone(),
            current,
            analysis: self.analysis.clone(),
            deviation,
            remeshing: None,
        }))
    }

    /// The energy at a surface, if the objective is not too high.
    pub(super) fn current_at(
        &self,
        mesh: &TriangleMesh,
        potentials: &[Potential],
        highest: f64,
    ) -> Result<Option<Current>, RepulsiveError> {
        match Current::at(mesh, potentials, &self.options) {
            Ok(current) if current.objective <= highest => Ok(Some(current)),
            Err(RepulsiveError::Numeric(stopped)) => Err(stopped.into()),
            _ => Ok(None),
        }
    }

    /// Corrects positions until they meet the constraints (RS equation 21). `None` if that fails.
    /// Returns the largest deviation, too.
    pub(super) fn corrected(
        &self,
        mesh: &TriangleMesh,
        mut positions: Vec<Vec3>,
        constraints: &Constraints,
        corrections: &Corrections,
        targets: &[f64],
    ) -> Result<Option<(TriangleMesh, f64)>, RepulsiveError> {
        let sizes = constraints.sizes(mesh, targets);
        for _ in 0..=CORRECTIONS {
            check_stopped()?;
            let Ok(mut moved) = mesh.with_positions(positions.clone()) else { return Ok(None) };
            if holds_barycentre(&self.options) || self.holds_components() {
                let shift = sub(self.memory.barycentre, held_centre(&moved, constraints.components));
                positions.iter_mut().for_each(|p| (0..3).for_each(|k| p[k] += shift[k]));
                // Values are measured after the shift, which changes the volume of an open surface.
                let Ok(shifted) = mesh.with_positions(positions.clone()) else { return Ok(None) };
                moved = shifted;
            }
            let values = constraints.values(&moved);
            let off: Vec<f64> = values.iter().zip(targets).map(|(value, target)| value - target).collect();
            let deviation = off.iter().zip(&sizes).map(|(off, size)| off.abs() / size).fold(0.0, f64::max);
            if deviation <= DEVIATION {
                return Ok(Some((moved, deviation)));
            }
            if !deviation.is_finite() {
                return Ok(None);
            }
            corrections.take_out(&off, &mut positions);
        }
        Ok(None)
    }
}

/// Positions after a share of some ways.
pub(super) fn moved_along(positions: &[Vec3], ways: Option<&[Vec3]>, share: f64) -> Vec<Vec3> {
    match ways {
        Some(ways) => {
            let moved = |(p, d): (&Vec3, &Vec3)| [0, 1, 2].map(|k| p[k] + share * d[k]);
            positions.iter().zip(ways).map(moved).collect()
        }
        None => positions.to_vec(),
    }
}
