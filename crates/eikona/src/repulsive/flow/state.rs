//! What a flow has to remember.

use super::constraints::{Constraints, held_centre, quantities};
use super::history::History;
use super::options::{Barycentre, FlowOptions, Pin, Remeshing};
use crate::geometry::vector::{add, distance, scale};
use crate::remesh::Places;
use crate::repulsive::error::RepulsiveError;
use eikona_mesh::{Topology, TriangleMesh, Vertex};
use eikona_numeric::check_stopped;
use serde::{Deserialize, Serialize};

type Vec3 = [f64; 3];

/// All that the next steps depend on, except the surface at the start and the options: a flow that
/// continues from it takes the same steps to the last bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FlowState {
    pub(super) positions: Vec<Vec3>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) memory: Memory,
}

/// What a flow remembers besides its surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Memory {
    /// The prescribed quantities at the start.
    pub first: Vec<f64>,
    /// The barycentre at the start, or that of the last component.
    pub barycentre: Vec3,
    /// The connected component of each vertex.
    pub components: Vec<u32>,
    /// The values of the constraints that are barycentres of components, at the start.
    pub centres: Vec<f64>,
    /// The pinned vertices, in the order of the options, and where they were at the start.
    pub pins: Vec<(u32, Vec3)>,
    /// Steps done, where those that collisions shortened count in part.
    pub time: f64,
    /// The number of steps since the surface was last remeshed.
    pub rejections: u32,
    /// The length of the last step.
    pub step_size: Option<f64>,
    /// The mean length of edges at the start, or what remeshing was asked for.
    pub edge_length: f64,
    /// Where the vertices lie on the surface at the start.
    pub places: Places,
    /// What the method remembers of earlier steps.
    #[serde(default)]
    pub history: History,
}

impl Memory {
    pub fn new(mesh: &TriangleMesh, options: &FlowOptions) -> Result<Memory, RepulsiveError> {
        let count = mesh.vertex_count();
        if let Some(pin) = options.pins.iter().find(|pin| pin.vertex.index() >= count) {
            let fault = format!("{} is pinned, but the mesh has {count} vertices", pin.vertex);
            return Err(RepulsiveError::Constraint { fault });
        }
        let mut pins: Vec<u32> = options.pins.iter().map(|pin| pin.vertex.0).collect();
        pins.sort_unstable();
        if let Some(pair) = pins.windows(2).find(|pair| pair[0] == pair[1]) {
            let fault = format!("{} is pinned twice", Vertex(pair[0]));
            return Err(RepulsiveError::Constraint { fault });
        }
        let topology = Topology::in_steps(mesh, check_stopped)?;
        // Vertices without faces belong nowhere, and do not move.
        let components: Vec<u32> =
            topology.component_of_vertex.iter().map(|(_, c)| c.unwrap_or(u32::MAX)).collect();
        let holds_components = options.barycentre == Barycentre::PerComponent && options.pins.is_empty();
        let held = if holds_components { components.as_slice() } else { &[] };
        let centres = Constraints { quantities: &[], components: held }.values(mesh);
        let barycentre = held_centre(mesh, held);
        let asked = match options.remeshing {
            Remeshing::Uniform { length } | Remeshing::Adaptive { length } => length,
            Remeshing::Off => None,
        };
        let length = |e| {
            let [a, b] = mesh.edge_vertices(e).map(|v| mesh.position(v));
            distance(a, b)
        };
        let mean = mesh.edges().map(length).sum::<f64>() / mesh.edge_count().max(1) as f64;
        Ok(Memory {
            first: quantities(options).iter().map(|quantity| quantity.of(mesh)).collect(),
            barycentre,
            components,
            centres,
            pins: options.pins.iter().map(|pin| (pin.vertex.0, mesh.position(pin.vertex))).collect(),
            time: 0.0,
            rejections: 0,
            step_size: None,
            edge_length: asked.unwrap_or(mean),
            places: Places::identity(mesh),
            history: History::default(),
        })
    }

    /// Checks that a state belongs to a surface at the start and options.
    pub fn check(
        &self,
        start: &TriangleMesh,
        mesh: &TriangleMesh,
        options: &FlowOptions,
    ) -> Result<(), String> {
        let count = mesh.vertex_count();
        let quantities = quantities(options).len();
        if self.first.len() != quantities || self.pins.len() != options.pins.len() {
            return Err(format!(
                "it keeps {} quantities and {} vertices instead of {quantities} and {}",
                self.first.len(),
                self.pins.len(),
                options.pins.len()
            ));
        }
        let constraints = quantities + self.centres.len();
        if !self.history.fits(options.method, count, constraints) {
            return Err(format!(
                "what it remembers of earlier steps is not of the method {}",
                options.method
            ));
        }
        let fits = self.components.len() == count
            && self.places.len() == count
            && self.pins.iter().all(|(v, _)| (*v as usize) < count)
            && self.places.fit(start);
        if fits { Ok(()) } else { Err("its vertices are not those of its surface".into()) }
    }

    /// Which vertices are pinned; empty if none is.
    pub fn pinned(&self, count: usize) -> Vec<bool> {
        let mut pinned = vec![false; if self.pins.is_empty() { 0 } else { count }];
        self.pins.iter().for_each(|(v, _)| pinned[*v as usize] = true);
        pinned
    }

    /// The values that the quantities have to have at a time.
    pub fn targets(&self, options: &FlowOptions, time: f64) -> Vec<f64> {
        let of = |(quantity, first): (_, &f64)| match options.growth.iter().find(|g| g.quantity == quantity) {
            Some(growth) => {
                let share = (time / growth.steps as f64).min(1.0);
                first + share * (growth.times * first + growth.plus - first)
            }
            None => *first,
        };
        quantities(options).into_iter().zip(&self.first).map(of).collect()
    }

    /// Where the pins have to be at a time.
    pub fn pins_at(&self, options: &FlowOptions, time: f64) -> Vec<(u32, Vec3)> {
        let of = |(pin, &(vertex, start)): (&Pin, &(u32, Vec3))| {
            (vertex, add(start, scale(pin.motion, (time / pin.steps as f64).min(1.0))))
        };
        options.pins.iter().zip(&self.pins).map(of).collect()
    }

    /// Whether something grows or moves after a time.
    pub fn changes_after(&self, options: &FlowOptions, time: f64) -> bool {
        time < options.growing_steps() as f64
    }
}
