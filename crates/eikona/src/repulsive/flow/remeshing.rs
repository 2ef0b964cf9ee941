//! Remeshing after a step (RS section 6).

use super::Flow;
use super::constraints::Constraints;
use super::direction::Corrections;
use super::history::History;
use super::options::Remeshing;
use super::state::Memory;
use crate::geometry::vector::distance;
use crate::remesh::{RemeshCounts, RemeshOptions, remesh};
use crate::repulsive::error::RepulsiveError;
use crate::repulsive::metric::{Analysis, Preconditioner};
use crate::repulsive::options::Exponents;
use crate::repulsive::quantity::Quantity;
use crate::spatial::{intersections_with, self_intersections};
use eikona_mesh::{TriangleMesh, Vertex};

/// The range of adaptive edge lengths, as shares of that in its middle.
const SMALLEST: f64 = 0.25;
const LARGEST: f64 = 2.0;
/// The growth of adaptive edge lengths per length along the surface.
const GRADING: f64 = 0.5;
/// A length spreads by so many edges per step.
const GRADING_SWEEPS: usize = 4;

/// A remeshed surface that meets the constraints.
pub(super) struct RemeshedStep {
    pub mesh: TriangleMesh,
    pub memory: Memory,
    /// That of the preconditioner.
    pub analysis: Analysis,
    pub deviation: f64,
    pub counts: RemeshCounts,
}

impl Flow {
    /// Remeshes a surface, and moves it a little so that it meets the constraints again. `None` if
    /// remeshing is off, or fails to do both without collisions.
    ///
    /// Deviation: the paper does five rounds of smoothing and flips per step. One is enough, since
    /// the next step continues from it.
    pub(super) fn remeshed(
        &self,
        moved: &TriangleMesh,
        memory: &Memory,
    ) -> Result<Option<RemeshedStep>, RepulsiveError> {
        if self.options.remeshing == Remeshing::Off {
            return Ok(None);
        }
        let mut options = RemeshOptions::default()
            .with_rounds(1)
            .with_fixed(self.memory.pins.iter().map(|(v, _)| Vertex(*v)).collect())
            .with_collisions(self.options.collisions)
            .with_obstacle(self.options.obstacle.clone())
            .with_threads(self.options.threads);
        if !self.barriers.is_empty() {
            options.barrier = Some(self.barriers.clone());
        }
        let sizes = self.edge_lengths(moved);
        let done = remesh(moved, &sizes, &options).map_err(RepulsiveError::from_remeshing)?;
        let mut memory = memory.clone();
        let threads = self.options.threads;
        memory.places = done.places.then(moved.triangles(), &self.memory.places, &self.start, threads)?;
        let component = |v| self.memory.components[done.places.near_vertex(moved, v) as usize];
        memory.components = (0..done.mesh.vertex_count()).map(component).collect();
        memory.pins.iter_mut().zip(&done.fixed).for_each(|(pin, v)| pin.0 = v.0);
        let mut analysis = self.analysis.as_ref();
        if done.counts.changed() {
            analysis = None;
            memory.history = History::default();
        }
        let pinned = memory.pinned(done.mesh.vertex_count());
        let preconditioner =
            Preconditioner::new(&done.mesh, self.current.unit, self.options.threads, analysis, &pinned)?;
        let constraints =
            Constraints { quantities: &self.quantities, components: self.held_components(&memory) };
        let rows = constraints.rows(&done.mesh);
        let mut fields = preconditioner.solve(&rows)?;
        fields.iter_mut().for_each(|field| clear_pins(field, &pinned));
        self.hold_centre(&done.mesh, &memory, &mut fields);
        let corrections = Corrections::new(&rows, fields);
        let targets = self.targets_at(&memory, memory.time);
        let positions = done.mesh.positions().to_vec();
        let Some((mesh, deviation)) =
            self.corrected(&done.mesh, positions, &constraints, &corrections, &targets)?
        else {
            return Ok(None);
        };
        if self.options.collisions && self.collides(&mesh)? {
            return Ok(None);
        }
        let (counts, analysis) = (done.counts, preconditioner.analysis());
        Ok(Some(RemeshedStep { mesh, memory, deviation, counts, analysis }))
    }

    /// Whether a surface intersects itself or an obstacle.
    fn collides(&self, mesh: &TriangleMesh) -> Result<bool, RepulsiveError> {
        let threads = self.options.threads;
        if !self.barriers.allow(mesh)? {
            return Ok(true);
        }
        if !self_intersections(mesh, threads)?.is_empty() {
            return Ok(true);
        }
        match &self.options.obstacle {
            Some(obstacle) => Ok(!intersections_with(mesh, obstacle, threads)?.is_empty()),
            None => Ok(false),
        }
    }

    /// The edge length to aim for at each vertex.
    ///
    /// The energy per area of a face is a mean of `(2 r)^-p` over the area, where r is the radius
    /// of the sphere that touches it and passes through another point: high powers, so the mean is
    /// near the smallest radius. That is small where the surface is curved, and where it comes
    /// close to itself.
    fn edge_lengths(&self, mesh: &TriangleMesh) -> Vec<f64> {
        let length = self.memory.edge_length;
        let mut sizes = vec![length; mesh.vertex_count()];
        if !matches!(self.options.remeshing, Remeshing::Adaptive { .. }) || self.current.densities.is_empty()
        {
            return sizes;
        }
        let Exponents { alpha, beta } = self.options.exponents;
        let area = Quantity::Area.of(mesh);
        let radii: Vec<f64> =
            self.current.densities.iter().map(|x| (x / area).powf(1.0 / (alpha - beta))).collect();
        let mut sorted = radii.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let median = sorted[sorted.len() / 2];
        let size = |radius: f64| length * (radius / median).clamp(SMALLEST, LARGEST);
        sizes.fill(f64::INFINITY);
        for (corners, radius) in mesh.triangles().iter().zip(radii) {
            corners.iter().for_each(|v| sizes[*v as usize] = sizes[*v as usize].min(size(radius)));
        }
        // Lengths of neighbours differ little, else faces get flat.
        for _ in 0..GRADING_SWEEPS {
            for e in mesh.edges() {
                let [a, b] = mesh.edge_vertices(e);
                let most = GRADING * distance(mesh.position(a), mesh.position(b));
                let [a, b] = [a.index(), b.index()];
                (sizes[a], sizes[b]) = (sizes[a].min(sizes[b] + most), sizes[b].min(sizes[a] + most));
            }
        }
        // Vertices without faces.
        sizes.iter_mut().filter(|x| !x.is_finite()).for_each(|x| *x = length);
        sizes
    }
}

fn clear_pins(field: &mut [[f64; 3]], pinned: &[bool]) {
    field.iter_mut().zip(pinned).filter(|(_, pinned)| **pinned).for_each(|(x, _)| *x = [0.0; 3]);
}
