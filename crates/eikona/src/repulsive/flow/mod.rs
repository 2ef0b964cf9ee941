//! The flow: steps of steepest descent of the tangent-point energy in the fractional inner product,
//! under constraints, without collisions (RS sections 3.3, 5.3 and 6).

mod constraints;
mod direction;
mod history;
mod inner_product;
mod line_search;
mod method;
mod objective;
mod options;
mod past_steps;
mod remeshing;
mod state;

pub use method::Method;
pub use options::{Barycentre, FlowOptions, Growth, Pin, Remeshing};
pub use state::FlowState;

use crate::geometry::vector::sub;
use crate::remesh::{Places, RemeshCounts};
use crate::repulsive::error::RepulsiveError;
use crate::repulsive::metric::Analysis;
use crate::repulsive::options::{Exponents, check_separation};
use crate::repulsive::potential::{Barriers, Potential};
use crate::repulsive::quantity::{Quantity, check_oriented};
use crate::spatial::{intersections_with, self_intersections};
use constraints::{Constraints, hold_centre, holds_barycentre, quantities};
use eikona_mesh::{Topology, TriangleMesh};
use eikona_numeric::check_stopped;
use objective::{Current, potentials_on};
use options::CROSSING;
use state::Memory;
use std::sync::Arc;

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
    /// What remeshing did after the step; `None` if it was off, could not be done without
    /// collisions, or would have raised the energy too much.
    pub remeshing: Option<RemeshCounts>,
    /// How much of what grows or moves on its own was done, as a share of what one step should
    /// bring: 1 if nothing was in the way, 0 if all was, or if the schedule is over.
    pub growth: f64,
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
    /// The implicit obstacles; none if collisions are off.
    barriers: Arc<Barriers>,
    current: Current,
    /// That of the preconditioner, for surfaces of the same connectivity.
    analysis: Option<Analysis>,
}

impl Flow {
    /// Starts at a surface.
    ///
    /// # Errors
    /// Those of [`tangent_point_energy`](super::tangent_point_energy),
    /// [`RepulsiveError::Separation`], [`RepulsiveError::Constraint`],
    /// [`RepulsiveError::Intersecting`], [`RepulsiveError::IntersectsObstacle`],
    /// [`RepulsiveError::EdgeThroughBarrier`], [`RepulsiveError::FaceAtBarrier`] and those of
    /// surfaces that are not manifold.
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
        options.quadrature().check()?;
        let mut options = options.clone();
        options.metric = options.metric.with_exponents(options.exponents).with_threads(options.threads);
        options.check()?;
        let of_barriers = if options.collisions { options.potentials.as_slice() } else { &[] };
        let barriers = Arc::new(Barriers::of(of_barriers)?);
        barriers.check(&mesh)?;
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
            barriers,
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

    /// Returns how much of the schedule is done, as a share of the longest one among the quantities
    /// that grow and the pins that move: 1 if it is over, or if there is none.
    ///
    /// ```
    /// use eikona::mesh::shapes;
    /// use eikona::repulsive::{Flow, FlowOptions, Growth, Quantity};
    /// let growth = Growth { quantity: Quantity::Area, times: 1.2, plus: 0.0, steps: 4 };
    /// let options = FlowOptions::default().with_keep(vec![]).with_growth(vec![growth]);
    /// let mut flow = Flow::new(&shapes::icosphere(2)?, &options)?;
    /// assert_eq!(flow.growth_done(), 0.0);
    /// let step = flow.step()?.unwrap();
    /// assert_eq!((step.growth, flow.growth_done()), (1.0, 0.25));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn growth_done(&self) -> f64 {
        match self.options.growing_steps() {
            0 => 1.0,
            steps => (self.memory.time / steps as f64).min(1.0),
        }
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

    /// Translates motions so that they hold what is held by a translation, if anything is.
    fn hold_centre(&self, mesh: &TriangleMesh, memory: &Memory, motions: &mut [Vec<Vec3>]) {
        if holds_barycentre(&self.options) || self.holds_components() {
            hold_centre(mesh, self.held_components(memory), motions);
        }
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
    let must_be_embedded = match options.method {
        Method::Willmore => options.collisions,
        _ => options.exponents.alpha >= CROSSING,
    };
    if must_be_embedded {
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
