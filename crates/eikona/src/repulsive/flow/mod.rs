//! The flow: steps of steepest descent of the tangent-point energy in the fractional inner product,
//! under constraints, without collisions (RS sections 3.3 and 5.3).

mod constraints;

pub use constraints::Quantity;

use crate::repulsive::energy::{check_separation, differential, sum, unit_of_length};
use crate::repulsive::error::RepulsiveError;
use crate::repulsive::faces::face_data;
use crate::repulsive::hierarchical::{Interactions, hierarchical};
use crate::repulsive::metric::{Analysis, Metric, MetricOptions};
use crate::repulsive::options::Exponents;
use crate::setters::setters;
use crate::spatial::{safe_motion, self_intersections};
use constraints::barycentre;
use eikona_mesh::{Edge, Topology, TriangleMesh, VertexField};
use eikona_numeric::{begin_phase, check_stopped};

/// Options of [`Flow`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FlowOptions {
    /// The exponents of the energy. Default: `p = 6`.
    pub exponents: Exponents,
    /// The quantities that keep their value. Default: the area. (Without any, the energy of `p > 4`
    /// falls for ever, since it falls with size.)
    pub keep: Vec<Quantity>,
    /// Whether steps are shortened so that the surface never touches itself. Default: yes.
    pub collisions: bool,
    /// The separation of clusters in the energy, see
    /// [`EnergyOptions::separation`](super::EnergyOptions::separation). Default: 0.3.
    pub separation: f64,
    /// The inner product, by default with tolerance 0.1. Its exponents and threads are those given
    /// here.
    pub metric: MetricOptions,
    /// Number of threads. Default: 1. The result is the same for any number.
    pub threads: usize,
}

impl Default for FlowOptions {
    fn default() -> Self {
        FlowOptions {
            exponents: Exponents::default(),
            keep: vec![Quantity::Area],
            collisions: true,
            separation: 0.3,
            // Tighter solves cost more than their better directions save.
            metric: MetricOptions::default().with_tolerance(0.1),
            threads: 1,
        }
    }
}

setters!(FlowOptions {
    with_exponents: exponents = Exponents,
    with_keep: keep = Vec<Quantity>,
    with_collisions: collisions = bool,
    with_separation: separation = f64,
    with_metric: metric = MetricOptions,
    with_threads: threads = usize
});

/// What one step did.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FlowStep {
    /// The energy after it.
    pub energy: f64,
    /// Its length: the displacement is that many times the descent direction.
    pub step_size: f64,
    /// The rate at which the energy falls along the direction at the start. It is the square of the
    /// norm of the projected gradient in the inner product, and tends to 0 at a minimiser.
    pub descent: f64,
    /// Iterations of the linear solver.
    pub solver_iterations: usize,
    /// How often the step was shortened because the energy did not fall enough.
    pub backtracks: usize,
    /// Whether collisions shortened the step.
    pub limited_by_collision: bool,
    /// The largest deviation of a kept quantity from its value at the start, as a share of it.
    pub deviation: f64,
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
    mesh: TriangleMesh,
    options: FlowOptions,
    /// The values of the kept quantities, each with its size.
    targets: Vec<f64>,
    barycentre: [f64; 3],
    /// The length of the last step.
    step_size: Option<f64>,
    analysis: Option<Analysis>,
    current: Current,
}

/// All that the next steps depend on, except the options: a flow that continues from it takes the
/// same steps to the last bit.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct FlowState {
    /// The positions of the vertices.
    pub positions: Vec<[f64; 3]>,
    /// The vertices of the faces.
    pub triangles: Vec<[u32; 3]>,
    /// The values that the kept quantities have to have, in the order of
    /// [`FlowOptions::keep`].
    pub targets: Vec<f64>,
    /// The barycentre that the surface has to have.
    pub barycentre: [f64; 3],
    /// The length of the last step.
    pub step_size: Option<f64>,
}

/// The energy where the surface is.
struct Current {
    unit: f64,
    interactions: Interactions,
    energy: f64,
    differential: VertexField<[f64; 3]>,
}

/// The energy has to fall by this share of what its slope promises.
const ARMIJO: f64 = 1e-4;
/// Kept quantities may deviate by this share.
const DEVIATION: f64 = 1e-9;
/// Corrections of a step to keep the quantities.
const CORRECTIONS: usize = 8;
/// The farthest that a vertex moves in a step, as a share of the square root of the area: pieces
/// that nothing holds together would fly away.
const LONGEST: f64 = 0.5;
/// The energy with new clusters may be higher by this share, which is about its error.
const RISE: f64 = 1e-3;
/// Shorter steps than this share of the first one tried are not tried.
const SHORTEST: f64 = 1e-12;

impl Flow {
    /// Starts at a surface.
    ///
    /// # Errors
    /// Those of [`tangent_point_energy`](super::tangent_point_energy), and
    /// [`RepulsiveError::Separation`].
    pub fn new(mesh: &TriangleMesh, options: &FlowOptions) -> Result<Flow, RepulsiveError> {
        let targets = options.keep.iter().map(|quantity| quantity.of(mesh)).collect();
        Flow::with(mesh.clone(), targets, barycentre(mesh), None, options)
    }

    /// Continues from a state, with the options it had.
    ///
    /// # Errors
    /// As for [`new`](Self::new), and [`RepulsiveError::State`] if the state is none of a flow with
    /// these options.
    pub fn resume(state: FlowState, options: &FlowOptions) -> Result<Flow, RepulsiveError> {
        let FlowState { positions, triangles, targets, barycentre, step_size } = state;
        let mesh = TriangleMesh::new(positions, triangles)
            .map_err(|fault| RepulsiveError::State { fault: fault.to_string() })?;
        if targets.len() != options.keep.len() {
            let fault = format!("it keeps {} quantities instead of {}", targets.len(), options.keep.len());
            return Err(RepulsiveError::State { fault });
        }
        Flow::with(mesh, targets, barycentre, step_size, options)
    }

    /// Returns the state, from which [`resume`](Self::resume) continues.
    pub fn state(&self) -> FlowState {
        FlowState {
            positions: self.mesh.positions().to_vec(),
            triangles: self.mesh.triangles().to_vec(),
            targets: self.targets.clone(),
            barycentre: self.barycentre,
            step_size: self.step_size,
        }
    }

    fn with(
        mesh: TriangleMesh,
        targets: Vec<f64>,
        barycentre: [f64; 3],
        step_size: Option<f64>,
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
        let mut options = options.clone();
        options.metric = options.metric.with_exponents(options.exponents).with_threads(options.threads);
        let current = Current::at(&mesh, &options)?;
        Ok(Flow { mesh, options, targets, barycentre, step_size, analysis: None, current })
    }

    /// Returns the surface.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// Returns the energy of the surface.
    pub fn energy(&self) -> f64 {
        self.current.energy
    }

    /// Takes one step. `None` if there is none that lowers the energy: a minimum, up to rounding.
    ///
    /// # Errors
    /// [`RepulsiveError::Numeric`] if an observer stops it; the surface stays as it is.
    ///
    /// # Cost
    /// About 20 us per face and thread.
    pub fn step(&mut self) -> Result<Option<FlowStep>, RepulsiveError> {
        begin_phase("direction")?;
        let Direction { motion, corrections, schur, descent, iterations } = self.direction()?;
        if descent.is_nan() || descent <= 0.0 {
            return Ok(None);
        }
        begin_phase("line search")?;
        let first = self.first_step(&motion, descent);
        let mut size = first;
        let mut limited_by_collision = false;
        let mut backtracks = 0;
        while size > SHORTEST * first {
            check_stopped()?;
            let Some((moved, deviation)) = self.corrected(&motion, size, &corrections, &schur)? else {
                (size, backtracks) = (0.5 * size, backtracks + 1);
                continue;
            };
            let energy = self.current.energy_of(&moved, &self.options);
            let promised = size * descent;
            match energy {
                Err(RepulsiveError::Numeric(stopped)) => return Err(stopped.into()),
                Ok(energy) if energy <= self.current.energy - ARMIJO * promised => {}
                // The minimum of the parabola through both values and the slope.
                Ok(energy) => {
                    let excess = energy - self.current.energy + promised;
                    size *= (0.5 * promised / excess).clamp(0.1, 0.5);
                    backtracks += 1;
                    continue;
                }
                Err(_) => {
                    (size, backtracks) = (0.25 * size, backtracks + 1);
                    continue;
                }
            }
            // Last, since it costs more than an energy, and the more the longer the step.
            if self.options.collisions {
                let way: Vec<[f64; 3]> = moved
                    .positions()
                    .iter()
                    .zip(self.mesh.positions())
                    .map(|(to, from)| [0, 1, 2].map(|k| to[k] - from[k]))
                    .collect();
                let safe = safe_motion(&self.mesh, &way, self.options.threads)?.share;
                if safe < 1.0 {
                    limited_by_collision = true;
                    size *= safe.min(0.9);
                    continue;
                }
            }
            begin_phase("energy")?;
            let current = match Current::at(&moved, &self.options) {
                Ok(current) if current.energy <= (1.0 + RISE) * self.current.energy => current,
                Err(RepulsiveError::Numeric(stopped)) => return Err(stopped.into()),
                // Clusters that were far no longer are.
                _ => {
                    (size, backtracks) = (0.25 * size, backtracks + 1);
                    continue;
                }
            };
            (self.mesh, self.current, self.step_size) = (moved, current, Some(size));
            return Ok(Some(FlowStep {
                energy: self.current.energy,
                step_size: size,
                descent,
                solver_iterations: iterations,
                backtracks,
                limited_by_collision,
                deviation,
            }));
        }
        Ok(None)
    }

    /// Twice the last step; at first, one that would lower the energy to zero if it fell at the
    /// rate at its start. No vertex moves farther than [`LONGEST`].
    fn first_step(&self, motion: &[[f64; 3]], descent: f64) -> f64 {
        let fastest =
            motion.iter().map(|d| d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).fold(0.0, f64::max).sqrt();
        let far = LONGEST * Quantity::Area.of(&self.mesh).sqrt() / fastest;
        let to_zero = self.current.energy / descent;
        self.step_size.map_or(to_zero, |last| to_zero.min(2.0 * last)).min(far)
    }

    /// Solves for the descent direction and the constraints, in common (RS equation 20).
    fn direction(&mut self) -> Result<Direction, RepulsiveError> {
        let Current { unit, interactions, differential, .. } = &self.current;
        let faces = face_data(&self.mesh, *unit)?;
        let metric = Metric::on(
            &self.mesh,
            *unit,
            interactions.tree.clone(),
            &faces,
            &self.options.metric,
            self.analysis.as_ref(),
        )?;
        let rows: Vec<Vec<[f64; 3]>> =
            self.options.keep.iter().map(|quantity| quantity.differential(&self.mesh)).collect();
        let forces = std::iter::once(differential.as_slice().to_vec()).chain(rows.iter().cloned());
        let (mut solutions, iterations, _) = metric.solutions(forces.collect())?;
        self.analysis = Some(metric.analysis());
        let corrections = solutions.split_off(1);
        let mut motion = solutions.pop().unwrap_or_default();
        let product = |a: &[[f64; 3]], b: &[[f64; 3]]| -> f64 {
            a.iter().zip(b).map(|(a, b)| a[0] * b[0] + a[1] * b[1] + a[2] * b[2]).sum()
        };
        let matrix = rows.iter().map(|row| corrections.iter().map(|c| product(row, c)).collect()).collect();
        let schur = Schur(matrix);
        let wanted: Vec<f64> = rows.iter().map(|row| product(row, &motion)).collect();
        let multipliers = schur.solve(&wanted);
        for (correction, multiplier) in corrections.iter().zip(multipliers) {
            for (d, c) in motion.iter_mut().zip(correction) {
                (0..3).for_each(|k| d[k] -= multiplier * c[k]);
            }
        }
        let descent = product(&motion, differential.as_slice());
        motion.iter_mut().for_each(|d| *d = d.map(|x| -x));
        Ok(Direction { motion, corrections, schur, descent, iterations })
    }

    /// Moves the surface, and corrects it until it keeps the quantities (RS equation 21). `None` if
    /// that fails. Returns the largest deviation, too.
    fn corrected(
        &self,
        motion: &[[f64; 3]],
        size: f64,
        corrections: &[Vec<[f64; 3]>],
        schur: &Schur,
    ) -> Result<Option<(TriangleMesh, f64)>, RepulsiveError> {
        let mut positions: Vec<[f64; 3]> = self
            .mesh
            .positions()
            .iter()
            .zip(motion)
            .map(|(p, d)| [0, 1, 2].map(|k| p[k] + size * d[k]))
            .collect();
        let sizes = self.sizes();
        for _ in 0..=CORRECTIONS {
            check_stopped()?;
            let Ok(moved) = self.mesh.with_positions(positions.clone()) else { return Ok(None) };
            let shift = barycentre(&moved);
            for p in &mut positions {
                (0..3).for_each(|k| p[k] += self.barycentre[k] - shift[k]);
            }
            // Measured after the shift, which changes the volume of an open surface.
            let Ok(mesh) = self.mesh.with_positions(positions.clone()) else { return Ok(None) };
            let off: Vec<f64> = self
                .options
                .keep
                .iter()
                .zip(&self.targets)
                .map(|(quantity, target)| quantity.of(&mesh) - target)
                .collect();
            let deviation = off.iter().zip(&sizes).map(|(off, size)| off.abs() / size).fold(0.0, f64::max);
            if deviation <= DEVIATION {
                return Ok(Some((mesh, deviation)));
            }
            if !deviation.is_finite() {
                return Ok(None);
            }
            for (correction, multiplier) in corrections.iter().zip(schur.solve(&off)) {
                for (p, c) in positions.iter_mut().zip(correction) {
                    (0..3).for_each(|k| p[k] -= multiplier * c[k]);
                }
            }
        }
        Ok(None)
    }

    /// The sizes to which deviations are compared: the volume may be zero.
    fn sizes(&self) -> Vec<f64> {
        let area = Quantity::Area.of(&self.mesh);
        let size = |(quantity, target): (&Quantity, &f64)| match quantity {
            Quantity::Area => target.abs(),
            Quantity::Volume => target.abs().max(1e-3 * area.powf(1.5)),
        };
        self.options.keep.iter().zip(&self.targets).map(size).collect()
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
    if options.keep.contains(&Quantity::Volume) {
        let is_inconsistent = |e: &Edge| match mesh.edge_halfedges(*e) {
            &[g, h] => mesh.follows_edge(g) == mesh.follows_edge(h),
            _ => false,
        };
        if let Some(edge) = mesh.edges().find(is_inconsistent) {
            return Err(RepulsiveError::Inconsistent { edge });
        }
    }
    if options.exponents.alpha >= 4.0 {
        let pairs = self_intersections(mesh, options.threads)?;
        if !pairs.is_empty() {
            return Err(RepulsiveError::Intersecting { pairs });
        }
    }
    Ok(())
}

impl Current {
    fn at(mesh: &TriangleMesh, options: &FlowOptions) -> Result<Current, RepulsiveError> {
        let unit = unit_of_length(mesh);
        let faces = face_data(mesh, unit)?;
        let interactions = Interactions::new(&faces, options.separation)?;
        let rows = hierarchical(&interactions, &faces, options.exponents, true, options.threads)?;
        let degree = options.exponents.degree();
        let energy = sum(&faces, &rows)? * unit.powf(degree);
        let differential = differential(mesh, unit, &faces, &rows, unit.powf(degree - 1.0));
        Ok(Current { unit, interactions, energy, differential })
    }

    /// The energy after a motion, with near faces and far clusters as they are.
    fn energy_of(&self, moved: &TriangleMesh, options: &FlowOptions) -> Result<f64, RepulsiveError> {
        let faces = face_data(moved, self.unit)?;
        let rows = hierarchical(&self.interactions, &faces, options.exponents, false, options.threads)?;
        Ok(sum(&faces, &rows)? * self.unit.powf(options.exponents.degree()))
    }
}

/// A direction of descent that keeps the quantities to first order.
struct Direction {
    motion: Vec<[f64; 3]>,
    /// For each quantity, the displacement with the smallest norm that changes it.
    corrections: Vec<Vec<[f64; 3]>>,
    schur: Schur,
    descent: f64,
    iterations: usize,
}

/// The changes of the quantities along the corrections: a small dense matrix.
struct Schur(Vec<Vec<f64>>);

impl Schur {
    /// Solves by elimination with pivoting. Directions that change nothing get nothing.
    fn solve(&self, rhs: &[f64]) -> Vec<f64> {
        let n = rhs.len();
        let mut rows: Vec<Vec<f64>> =
            self.0.iter().zip(rhs).map(|(row, x)| row.iter().copied().chain([*x]).collect()).collect();
        let largest = rows.iter().flat_map(|row| &row[..n]).fold(0.0f64, |m, x| m.max(x.abs()));
        for k in 0..n {
            let pivot = (k..n).max_by(|&i, &j| rows[i][k].abs().total_cmp(&rows[j][k].abs())).unwrap_or(k);
            rows.swap(k, pivot);
            if rows[k][k].abs() <= 1e-14 * largest {
                rows[k].iter_mut().for_each(|x| *x = 0.0);
                rows[k][k] = 1.0;
            }
            for i in 0..n {
                if i != k {
                    let factor = rows[i][k] / rows[k][k];
                    for j in k..=n {
                        rows[i][j] -= factor * rows[k][j];
                    }
                }
            }
        }
        (0..n).map(|k| rows[k][n] / rows[k][k]).collect()
    }
}
