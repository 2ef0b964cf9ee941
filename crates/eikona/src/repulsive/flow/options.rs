//! Options of the flow.

use super::method::Method;
use crate::repulsive::error::RepulsiveError;
use crate::repulsive::metric::MetricOptions;
use crate::repulsive::options::{Exponents, Quadrature};
use crate::repulsive::potential::Potential;
use crate::repulsive::quantity::Quantity;
use crate::setters::setters;
use eikona_mesh::{TriangleMesh, Vertex};

/// From this alpha on, the energy of surfaces that cross themselves is infinite.
pub(super) const CROSSING: f64 = 4.0;

/// Options of [`Flow`](super::Flow).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FlowOptions {
    /// How the direction of a step is chosen. Default: [`Method::Fractional`].
    pub method: Method,
    /// The exponents of the energy. Default: `p = 6`.
    pub exponents: Exponents,
    /// Terms that are added to the energy. Default: none. Those with a value per vertex or face
    /// are for the mesh at the start.
    pub potentials: Vec<Potential>,
    /// A surface that stays where it is, and that the moving one never touches, unless collisions
    /// are off. It repels only if a potential says so. Default: none.
    pub obstacle: Option<TriangleMesh>,
    /// The quantities that keep their value. Default: the area. (Without any, the energy of `p > 4`
    /// falls for ever, since it falls with size.)
    pub keep: Vec<Quantity>,
    /// Quantities that grow or shrink to a target. Default: none.
    pub growth: Vec<Growth>,
    /// What happens to the barycentre, unless vertices are pinned. Default: it stays.
    pub barycentre: Barycentre,
    /// Vertices that stay where they are, or move as prescribed. Default: none.
    pub pins: Vec<Pin>,
    /// Whether steps are shortened so that the surface never touches itself, the obstacle, or an
    /// implicit surface that repels. Default: yes.
    pub collisions: bool,
    /// Whether and how the surface is remeshed after each step. Default: to edges of the mean
    /// length at the start.
    pub remeshing: Remeshing,
    /// The separation of clusters in the energy, see
    /// [`EnergyOptions::separation`](crate::repulsive::EnergyOptions::separation). Default: 0.3.
    pub separation: f64,
    /// How the energy of two faces is integrated. `None`, the default: adaptively with separation
    /// 0.5 if alpha is 4 or more, else by the midpoint rule, since surfaces may cross then.
    /// Adaptive quadrature costs 5 to 15 % of a step, and is accurate where the surface is closer
    /// to itself than the size of its faces: there, the midpoint rule has energies that change by
    /// as much as the surface is remeshed.
    pub quadrature: Option<Quadrature>,
    /// The inner product, by default with tolerance 0.1. Its exponents and threads are those given
    /// here.
    pub metric: MetricOptions,
    /// Number of threads. Default: 1. The result is the same for any number.
    pub threads: usize,
}

impl Default for FlowOptions {
    fn default() -> Self {
        FlowOptions {
            method: Method::Fractional,
            exponents: Exponents::default(),
            potentials: Vec::new(),
            obstacle: None,
            keep: vec![Quantity::Area],
            growth: Vec::new(),
            barycentre: Barycentre::Kept,
            pins: Vec::new(),
            collisions: true,
            remeshing: Remeshing::Uniform { length: None },
            separation: 0.3,
            quadrature: None,
            // Tighter solves cost more than their better directions save.
            metric: MetricOptions::default().with_tolerance(0.1),
            threads: 1,
        }
    }
}

setters!(FlowOptions {
    with_method: method = Method,
    with_exponents: exponents = Exponents,
    with_potentials: potentials = Vec<Potential>,
    with_obstacle: obstacle = Option<TriangleMesh>,
    with_keep: keep = Vec<Quantity>,
    with_growth: growth = Vec<Growth>,
    with_barycentre: barycentre = Barycentre,
    with_pins: pins = Vec<Pin>,
    with_collisions: collisions = bool,
    with_remeshing: remeshing = Remeshing,
    with_separation: separation = f64,
    with_quadrature: quadrature = Option<Quadrature>,
    with_metric: metric = MetricOptions,
    with_threads: threads = usize
});

impl FlowOptions {
    /// Returns how the energy of two faces is integrated: as asked, or as suits the exponents.
    pub fn quadrature(&self) -> Quadrature {
        let suited = match self.exponents.alpha >= CROSSING {
            true => Quadrature::adaptive(),
            false => Quadrature::Midpoint,
        };
        self.quadrature.unwrap_or(suited)
    }

    /// The number of steps after which nothing grows or moves on its own any more.
    pub(super) fn growing_steps(&self) -> u64 {
        let moving = self.pins.iter().filter(|pin| pin.motion != [0.0; 3]).map(|pin| pin.steps);
        self.growth.iter().map(|growth| growth.steps).chain(moving).max().unwrap_or(0)
    }

    /// # Errors
    /// [`RepulsiveError::Constraint`].
    pub(super) fn check(&self) -> Result<(), RepulsiveError> {
        let refuse = |fault: String| Err(RepulsiveError::Constraint { fault });
        for (i, growth) in self.growth.iter().enumerate() {
            let Growth { quantity, times, plus, steps } = growth;
            if steps == &0 || !times.is_finite() || !plus.is_finite() {
                return refuse(format!(
                    "the {quantity} grows to {times} times its value plus {plus} in {steps} steps"
                ));
            }
            if self.growth[..i].iter().any(|other| other.quantity == *quantity) {
                return refuse(format!("the {quantity} grows twice"));
            }
        }
        if let Some(pin) =
            self.pins.iter().find(|pin| pin.steps == 0 || !pin.motion.iter().all(|x| x.is_finite()))
        {
            return refuse(format!("{} moves by {:?} in {} steps", pin.vertex, pin.motion, pin.steps));
        }
        match self.remeshing {
            Remeshing::Uniform { length: Some(length) } | Remeshing::Adaptive { length: Some(length) }
                if !(length > 0.0 && length.is_finite()) =>
            {
                refuse(format!("the length of edges is {length}"))
            }
            _ => Ok(()),
        }
    }
}

/// A quantity that changes linearly from its value `x` at the start to `times x + plus`.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Growth {
    /// The quantity.
    pub quantity: Quantity,
    /// The factor of the value at the start.
    pub times: f64,
    /// What is added to it.
    pub plus: f64,
    /// The number of steps, at least 1. Steps that collisions shorten count in part.
    pub steps: u64,
}

/// What happens to the barycentre of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Barycentre {
    /// It stays.
    #[default]
    Kept,
    /// That of each connected component stays.
    PerComponent,
    /// That of each connected component moves along the force on it (RS section 7.1.1, barycenter
    /// motions).
    Free,
}

/// A vertex that is held.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pin {
    /// The vertex, in the mesh at the start.
    pub vertex: Vertex,
    /// The way that it goes in all; zero if it stays.
    pub motion: [f64; 3],
    /// The number of steps for that, at least 1. Steps that collisions shorten count in part.
    pub steps: u64,
}

impl Pin {
    /// Creates the pin of a vertex that stays where it is.
    pub fn still(vertex: Vertex) -> Pin {
        Pin { vertex, motion: [0.0; 3], steps: 1 }
    }
}

/// How the flow remeshes the surface.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Remeshing {
    /// Not at all: faces and vertices keep their numbers.
    Off,
    /// To edges of one length.
    Uniform {
        /// The length; `None` for the mean length at the start.
        length: Option<f64>,
    },
    /// To edges that are shorter where the surface is curved or comes close to itself, and longer
    /// where it is flat and alone: in proportion to the radius of the spheres that touch it and
    /// pass through another point of it. Uniform for [`Method::Willmore`].
    Adaptive {
        /// The length in the middle of the range, which goes from a quarter of it to twice it;
        /// `None` for the mean length at the start.
        length: Option<f64>,
    },
}
