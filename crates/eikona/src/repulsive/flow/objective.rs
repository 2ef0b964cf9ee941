//! The energy and all potentials where the surface is.

use super::method::Method;
use super::options::FlowOptions;
use super::state::Memory;
use crate::remesh::Places;
use crate::repulsive::energy::unit_of_length;
use crate::repulsive::error::RepulsiveError;
use crate::repulsive::faces::FaceDatum;
use crate::repulsive::options::Pairs;
use crate::repulsive::pair_sum::{PairSum, PairSumOptions};
use crate::repulsive::potential::Potential;
use crate::spatial::ClusterTree;
use eikona_mesh::{MeshError, TriangleMesh, VertexField};

/// The energy where the surface is.
pub(super) struct Current {
    pub unit: f64,
    source: Source,
    pub energy: f64,
    /// The energy and all potentials.
    pub objective: f64,
    /// That of the objective.
    pub differential: VertexField<[f64; 3]>,
    /// The tangent-point energy per area of each face; empty for the Willmore energy.
    pub densities: Vec<f64>,
}

/// Where the energy comes from.
enum Source {
    TangentPoint(Box<PairSum>),
    Willmore,
}

/// The energy that the Willmore method descends.
fn willmore() -> Potential {
    Potential::willmore(1.0)
}

impl Current {
    pub fn at(
        mesh: &TriangleMesh,
        potentials: &[Potential],
        options: &FlowOptions,
    ) -> Result<Current, RepulsiveError> {
        let unit = unit_of_length(mesh);
        let mut current = match options.method {
            Method::Willmore => Current::willmore(mesh, unit)?,
            _ => Current::tangent_point(mesh, unit, options)?,
        };
        for potential in potentials {
            current.objective += potential.value(mesh)?;
            let own = potential.differential(mesh)?;
            for (sum, own) in current.differential.as_mut_slice().iter_mut().zip(own.as_slice()) {
                (0..3).for_each(|k| sum[k] += own[k]);
            }
        }
        Ok(current)
    }

    fn willmore(mesh: &TriangleMesh, unit: f64) -> Result<Current, RepulsiveError> {
        let energy = willmore().value(mesh)?;
        let differential = willmore().differential(mesh)?;
        let densities = Vec::new();
        Ok(Current { unit, source: Source::Willmore, energy, objective: energy, differential, densities })
    }

    fn tangent_point(
        mesh: &TriangleMesh,
        unit: f64,
        options: &FlowOptions,
    ) -> Result<Current, RepulsiveError> {
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
        let differential = summed.differential();
        let source = Source::TangentPoint(Box::new(pair_sum));
        Ok(Current { unit, source, energy, objective: energy, differential, densities })
    }

    /// The cluster tree of the faces.
    pub fn tree(&self, faces: &[FaceDatum]) -> ClusterTree {
        match &self.source {
            Source::TangentPoint(pair_sum) => pair_sum.tree(faces),
            Source::Willmore => ClusterTree::new(&faces.iter().map(|face| face.centroid).collect::<Vec<_>>()),
        }
    }

    /// The objective after a motion, with near faces, far clusters and parts as they are.
    pub fn objective_of(
        &self,
        moved: &TriangleMesh,
        potentials: &[Potential],
    ) -> Result<f64, RepulsiveError> {
        let energy = match &self.source {
            Source::TangentPoint(pair_sum) => pair_sum.at(moved, false)?.value()?,
            Source::Willmore => willmore().value(moved)?,
        };
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
