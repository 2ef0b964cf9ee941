//! The flow: steps of steepest descent of the tangent-point energy in the fractional inner product,
//! under constraints, without collisions (RS sections 3.3, 5.3 and 6).

mod constraints;
mod direction;
mod history;
mod inner_product;
mod method;
mod options;
mod past_steps;
mod remeshing;
mod state;

pub use method::Method;
pub use options::{Barycentre, FlowOptions, Growth, Pin, Remeshing};
pub use state::FlowState;

use crate::geometry::vector::{norm, sub};
use crate::remesh::{Places, RemeshCounts};
use crate::repulsive::energy::unit_of_length;
use crate::repulsive::error::RepulsiveError;
use crate::repulsive::metric::Analysis;
use crate::repulsive::options::{Exponents, Pairs, check_separation};
use crate::repulsive::pair_sum::{PairSum, PairSumOptions};
use crate::repulsive::potential::Potential;
use crate::repulsive::quantity::{Quantity, check_oriented};
use crate::spatial::{intersections_with, safe_motion, safe_motion_past, self_intersections};
use constraints::{Constraints, held_centre, holds_barycentre, quantities};
use direction::{Corrections, Direction};
use eikona_mesh::{MeshError, Topology, TriangleMesh, VertexField};
use eikona_numeric::{begin_phase, check_stopped};
use state::Memory;

type Vec3 = [f64; 3];

/// What one step did.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FlowStep {
    /// The energy after it.
    pub energy: f64,
    /// The energy and all potentials after it.
    pub objective: f64,
    /// Its length: the displacement is that many times the descent direction.
    pub step_size: f64,
    /// The rate at which the objective falls along the direction at the start. It is the square of
    /// the norm of the projected gradient in the inner product, and tends to 0 at a minimiser.
    pub descent: f64,
    /// Iterations of the linear solver.
    pub solver_iterations: usize,
    /// How often the step was shortened because the energy did not fall enough.
    pub backtracks: usize,
    /// Whether collisions shortened the step.
    pub limited_by_collision: bool,
    /// The largest deviation from a constraint, as a share of the quantity or of the square root of
    /// the area.
    pub deviation: f64,
    /// What remeshing did after the step; `None` if it was off, or could not be done without
    /// collisions.
    pub remeshing: Option<RemeshCounts>,
}

/// A surface that moves to lower its tangent-point energy.
///
/// ```
/// use eikona::mesh::shapes;
/// use eikona::repulsive::{Flow, FlowOptions, Quantity};
/// let torus = shapes::torus(1.0, 0.25, 40, 14)?;
/// let mut flow = Flow::new(&torus, &FlowOptions::default())?;
/// let before = flow.energy();
/// for _ in 0..5 {
///     flow.step()?;
/// }
/// assert!(flow.energy() < 0.8 * before);
/// let [kept, given] = [flow.mesh(), &torus].map(|mesh| Quantity::Area.of(mesh));
/// assert!((kept / given - 1.0).abs() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Flow {
    start: TriangleMesh,
    mesh: TriangleMesh,
    options: FlowOptions,
    quantities: Vec<Quantity>,
    memory: Memory,
    /// With values for the vertices and faces as they are now.
    potentials: Vec<Potential>,
    current: Current,
    /// That of the preconditioner, for surfaces of the same connectivity.
    analysis: Option<Analysis>,
}

/// The energy where the surface is.
struct Current {
    unit: f64,
    pair_sum: PairSum,
    energy: f64,
    /// The energy and all potentials.
    objective: f64,
    /// That of the objective.
    differential: VertexField<Vec3>,
    /// The energy per area of each face.
    densities: Vec<f64>,
}

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
    /// Starts at a surface.
    ///
    /// # Errors
    /// Those of [`tangent_point_energy`](super::tangent_point_energy),
    /// [`RepulsiveError::Separation`], [`RepulsiveError::Constraint`],
    /// [`RepulsiveError::Intersecting`] and those of surfaces that are not manifold.
    pub fn new(mesh: &TriangleMesh, options: &FlowOptions) -> Result<Flow, RepulsiveError> {
        Flow::with(mesh, mesh.clone(), None, options)
    }

    /// Continues from a state, with the surface at the start and the options it had.
    ///
    /// # Errors
    /// As for [`new`](Self::new), and [`RepulsiveError::State`] if the state is none of a flow with
    /// these options.
    pub fn resume(
        start: &TriangleMesh,
        state: FlowState,
        options: &FlowOptions,
    ) -> Result<Flow, RepulsiveError> {
        let FlowState { positions, triangles, memory } = state;
        let mesh = TriangleMesh::new(positions, triangles)
            .map_err(|fault| RepulsiveError::State { fault: fault.to_string() })?;
        memory.check(start, &mesh, options).map_err(|fault| RepulsiveError::State { fault })?;
        Flow::with(start, mesh, Some(memory), options)
    }

    /// Returns the state, from which [`resume`](Self::resume) continues.
    pub fn state(&self) -> FlowState {
        FlowState {
            positions: self.mesh.positions().to_vec(),
            triangles: self.mesh.triangles().to_vec(),
            memory: self.memory.clone(),
        }
    }

    fn with(
        start: &TriangleMesh,
        mesh: TriangleMesh,
        memory: Option<Memory>,
        options: &FlowOptions,
    ) -> Result<Flow, RepulsiveError> {
        if mesh.face_count() == 0 {
            return Err(RepulsiveError::NoFaces);
        }
        let Exponents { alpha, beta } = options.exponents;
        Exponents::new(alpha, beta)?;
        check_surface(&mesh, options)?;
        check_separation(options.separation)?;
        check_separation(options.metric.separation)?;
        options.quadrature.check()?;
        let mut options = options.clone();
        options.metric = options.metric.with_exponents(options.exponents).with_threads(options.threads);
        options.check()?;
        let memory = match memory {
            Some(memory) => memory,
            None => Memory::new(&mesh, &options)?,
        };
        let potentials = potentials_on(start, mesh.triangles(), &memory, &options)?;
        let current = Current::at(&mesh, &potentials, &options)?;
        Ok(Flow {
            start: start.clone(),
            mesh,
            quantities: quantities(&options),
            options,
            memory,
            potentials,
            current,
            analysis: None,
        })
    }

    /// Returns the surface.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// Returns the energy of the surface.
    pub fn energy(&self) -> f64 {
        self.current.energy
    }

    /// Returns the energy of the surface and all potentials.
    pub fn objective(&self) -> f64 {
        self.current.objective
    }

    /// Returns where the vertices lie on the surface at the start, by which data follow it.
    pub fn places(&self) -> &Places {
        &self.memory.places
    }

    /// Returns whether a quantity still grows, or a pin still moves.
    pub fn is_growing(&self) -> bool {
        self.memory.changes_after(&self.options, self.memory.time)
    }

    /// Takes one step. `None` if there is none that lowers the energy: a minimum, up to rounding.
    ///
    /// # Errors
    /// [`RepulsiveError::Numeric`] if an observer stops it; the surface stays as it is.
    ///
    /// # Cost
    /// About 25 us per face and thread.
    pub fn step(&mut self) -> Result<Option<FlowStep>, RepulsiveError> {
        if self.options.method.has_history() { self.step_with_history() } else { self.descend() }
    }

    /// Takes one step from the surface as it is.
    fn descend(&mut self) -> Result<Option<FlowStep>, RepulsiveError> {
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
    fn safe_share(&self, moved: &TriangleMesh) -> Result<f64, RepulsiveError> {
        if !self.options.collisions {
            return Ok(1.0);
        }
        let ways = moved.positions().iter().zip(self.mesh.positions());
        let ways: Vec<Vec3> = ways.map(|(to, from)| sub(*to, *from)).collect();
        let threads = self.options.threads;
        Ok(match &self.options.obstacle {
            Some(obstacle) => safe_motion_past(&self.mesh, &ways, obstacle, threads)?.share,
            None => safe_motion(&self.mesh, &ways, threads)?.share,
        })
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
    fn current_at(
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
    fn corrected(
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

    fn constraints(&self) -> Constraints<'_> {
        Constraints { quantities: &self.quantities, components: self.held_components(&self.memory) }
    }

    /// Whether the barycentre of each component is held.
    fn holds_components(&self) -> bool {
        self.options.barycentre == Barycentre::PerComponent && self.options.pins.is_empty()
    }

    fn held_components<'a>(&self, memory: &'a Memory) -> &'a [u32] {
        if self.holds_components() { &memory.components } else { &[] }
    }

    /// The values that the constraints have to have at a time.
    fn targets_at(&self, memory: &Memory, time: f64) -> Vec<f64> {
        let mut targets = memory.targets(&self.options, time);
        targets.extend(&memory.centres);
        targets
    }

    /// Which vertices are pinned; empty if none is.
    fn pinned(&self) -> Vec<bool> {
        self.memory.pinned(self.mesh.vertex_count())
    }

    /// The ways of the pins in a step, zero elsewhere; `None` if no pin moves.
    fn pin_ways(&self, share: f64) -> Option<Vec<Vec3>> {
        let moves = self.options.pins.iter().any(|pin| pin.motion != [0.0; 3]);
        (moves && self.is_growing()).then(|| {
            let mut ways = vec![[0.0; 3]; self.mesh.vertex_count()];
            for (v, to) in self.memory.pins_at(&self.options, self.memory.time + share) {
                ways[v as usize] = sub(to, self.mesh.positions()[v as usize]);
            }
            ways
        })
    }
}

fn moved_along(positions: &[Vec3], ways: Option<&[Vec3]>, share: f64) -> Vec<Vec3> {
    match ways {
        Some(ways) => {
            let moved = |(p, d): (&Vec3, &Vec3)| [0, 1, 2].map(|k| p[k] + share * d[k]);
            positions.iter().zip(ways).map(moved).collect()
        }
        None => positions.to_vec(),
    }
}

/// Refuses surfaces that cannot flow.
fn check_surface(mesh: &TriangleMesh, options: &FlowOptions) -> Result<(), RepulsiveError> {
    let topology = Topology::in_steps(mesh, check_stopped)?;
    if let Some(&edge) = topology.nonmanifold_edges.first() {
        return Err(RepulsiveError::NonmanifoldEdge { edge, faces: mesh.edge_halfedges(edge).len() });
    }
    if let Some(at) = topology.nonmanifold_vertices.first() {
        return Err(RepulsiveError::NonmanifoldVertex { vertex: at.vertex });
    }
    if quantities(options).contains(&Quantity::Volume) {
        check_oriented(mesh)?;
    }
    if options.exponents.alpha >= 4.0 {
        let pairs = self_intersections(mesh, options.threads)?;
        if !pairs.is_empty() {
            return Err(RepulsiveError::Intersecting { pairs });
        }
    }
    if let Some(obstacle) = options.obstacle.as_ref().filter(|_| options.collisions) {
        let pairs = intersections_with(mesh, obstacle, options.threads)?;
        if !pairs.is_empty() {
            return Err(RepulsiveError::IntersectsObstacle { pairs });
        }
    }
    Ok(())
}

/// The potentials for vertices and faces that the surface has at some time.
fn potentials_on(
    start: &TriangleMesh,
    faces: &[[u32; 3]],
    memory: &Memory,
    options: &FlowOptions,
) -> Result<Vec<Potential>, RepulsiveError> {
    let mut potentials: Vec<Potential> = options.potentials.clone();
    potentials.iter_mut().for_each(|potential| potential.threads = options.threads);
    if potentials.iter().any(Potential::follows_mesh) && memory.places != Places::identity(start) {
        let positions = memory.places.pull_vertices(start, start.positions());
        let fault = |fault: MeshError| RepulsiveError::State { fault: fault.to_string() };
        let at_start = TriangleMesh::new(positions, faces.to_vec()).map_err(fault)?;
        potentials = potentials.iter().map(|p| p.on(&at_start)).collect::<Result<_, _>>()?;
    }
    Ok(potentials)
}

impl Current {
    fn at(
        mesh: &TriangleMesh,
        potentials: &[Potential],
        options: &FlowOptions,
    ) -> Result<Current, RepulsiveError> {
        let unit = unit_of_length(mesh);
        let pair_sum = PairSumOptions {
            exponents: options.exponents,
            pairs: Pairs::Hierarchical,
            separation: options.separation,
            quadrature: options.quadrature,
            threads: options.threads,
        };
        let pair_sum = PairSum::new(mesh, unit, &pair_sum)?;
        let summed = pair_sum.at(mesh, true)?;
        let energy = summed.value()?;
        let densities = summed.densities();
        let mut differential = summed.differential();
        let mut objective = energy;
        for potential in potentials {
            objective += potential.value(mesh)?;
            let own = potential.differential(mesh)?;
            for (sum, own) in differential.as_mut_slice().iter_mut().zip(own.as_slice()) {
                (0..3).for_each(|k| sum[k] += own[k]);
            }
        }
        Ok(Current { unit, pair_sum, energy, objective, differential, densities })
    }

    /// The objective after a motion, with near faces, far clusters and parts as they are.
    fn objective_of(&self, moved: &TriangleMesh, potentials: &[Potential]) -> Result<f64, RepulsiveError> {
        let energy = self.pair_sum.at(moved, false)?.value()?;
        potentials.iter().try_fold(energy, |sum, potential| Ok(sum + potential.value(moved)?))
    }
}
