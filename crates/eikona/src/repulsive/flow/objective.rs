//! The energy and all potentials where the surface is.

use super::options::FlowOptions;
use super::state::Memory;
use crate::remesh::Places;
use crate::repulsive::energy::unit_of_length;
use crate::repulsive::error::RepulsiveError;
use crate::repulsive::options::Pairs;
use crate::repulsive::pair_sum::{PairSum, PairSumOptions};
use crate::repulsive::potential::Potential;
use eikona_mesh::{MeshError, TriangleMesh, VertexField};

/// The energy where the surface is.
pub(super) struct Current {
    pub unit: f64,
    pub pair_sum: PairSum,
    pub energy: f64,
    /// The energy and all potentials.
    pub objective: f64,
    /// That of the objective.
    pub differential: VertexField<[f64; 3]>,
    /// The energy per area of each face.
    pub densities: Vec<f64>,
}

impl Current {
    pub fn at(
        mesh: &TriangleMesh,
        potentials: &[Potential],
        options: &FlowOptions,
    ) -> Result<Current, RepulsiveError> {
        let unit = unit_of_length(mesh);
        let pair_sum = PairSumOptions {
            exponents: options.exponents,
            pairs: Pairs::Hierarchical,
            separation: options.separation,
            quadrature: options.quadrature(),
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
    pub fn objective_of(
        &self,
        moved: &TriangleMesh,
        potentials: &[Potential],
    ) -> Result<f64, RepulsiveError> {
        let energy = self.pair_sum.at(moved, false)?.value()?;
        potentials.iter().try_fold(energy, |sum, potential| Ok(sum + potential.value(moved)?))
    }
}

/// The potentials for vertices and faces that the surface has at some time.
pub(super) fn potentials_on(
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
