//! Remeshing of a surface that deforms: faces keep their quality and size.
//!
//! Each round splits long edges and collapses short ones, flips edges until the mesh is Delaunay,
//! and moves vertices along the surface. No operation lets the surface touch itself or pass
//! through itself: those that change faces are tested exactly against all faces near them, motions
//! by continuous collision detection ([`safe_motion`](crate::spatial::safe_motion)). All works
//! without a consistent orientation.
//!
//! **Reference.** Yu, Brakensiek, Schumacher and Crane, *Repulsive Surfaces*, ACM Transactions on
//! Graphics 40 (6), 2021, section 6; Long Chen and Michael Holst, *Efficient mesh optimization
//! schemes based on optimal Delaunay triangulations*, Computer Methods in Applied Mechanics and
//! Engineering 200, 2011.

mod barrier;
mod changing;
mod guard;
mod options;
mod passes;
mod places;
mod smooth;

pub(crate) use barrier::Barrier;
pub use options::RemeshOptions;
pub use passes::RemeshCounts;
pub use places::Places;

use changing::Changing;
use eikona_mesh::{Edge, Face, MeshError, Topology, TriangleMesh, Vertex};
use eikona_numeric::{NumericError, check_stopped, mapped};
use passes::Passes;
use places::nearest_from;
use thiserror::Error;

/// A remeshed surface.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Remeshed {
    /// The surface.
    pub mesh: TriangleMesh,
    /// Where its vertices lie on the original surface.
    pub places: Places,
    /// For each vertex, the length of edges to aim for.
    pub sizes: Vec<f64>,
    /// The new number of each fixed vertex.
    pub fixed: Vec<Vertex>,
    /// How often each operation was done.
    pub counts: RemeshCounts,
}

/// Why a surface cannot be remeshed.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum RemeshError {
    /// Three or more faces meet at an edge, or the faces at a vertex form several fans.
    #[error("the mesh is not manifold at {at}; split the mesh there")]
    Nonmanifold {
        /// The first such edge or vertex.
        at: String,
    },
    /// A length is not positive, or there is not one per vertex.
    #[error("{fault}; give one positive length per vertex")]
    Sizes {
        /// What is wrong.
        fault: String,
    },
    /// A fixed vertex is none of the mesh.
    #[error("{vertex} cannot stay where it is: the mesh has {count} vertices")]
    Fixed {
        /// The vertex.
        vertex: Vertex,
        /// The number of vertices.
        count: usize,
    },
    /// Positions became invalid.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The observer stopped the computation.
    #[error(transparent)]
    Numeric(#[from] NumericError),
}

/// Remeshes a surface, so that its edges have about the given lengths (one per vertex) and its
/// faces are nearly equilateral.
///
/// Edges longer than 1.5 times the length are split, those shorter than half of it collapsed.
/// Boundaries keep their corners. Edges between two fixed vertices stay. Vertices without faces are
/// dropped.
///
/// # Errors
/// [`RemeshError::Nonmanifold`], [`RemeshError::Sizes`], [`RemeshError::Fixed`];
/// [`RemeshError::Numeric`] if an observer stops it.
///
/// # Cost
/// O(F log F) per round: about 5 us per face and round.
///
/// ```
/// use eikona::mesh::shapes;
/// use eikona::remesh::{RemeshOptions, remesh};
/// let sphere = shapes::icosphere(2)?;
/// let finer = remesh(&sphere, &[0.15; 162], &RemeshOptions::default())?;
/// assert!((1000..2500).contains(&finer.mesh.face_count()));
/// // Colours follow.
/// let heights: Vec<[f64; 1]> = sphere.positions().iter().map(|p| [p[2]]).collect();
/// let pulled = finer.places.pull_vertices(&sphere, &heights);
/// let off = finer.mesh.positions().iter().zip(&pulled).map(|(p, h)| (p[2] - h[0]).abs());
/// assert!(off.fold(0.0, f64::max) < 0.05);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn remesh(mesh: &TriangleMesh, sizes: &[f64], options: &RemeshOptions) -> Result<Remeshed, RemeshError> {
    check(mesh, sizes, options)?;
    let count = mesh.vertex_count();
    let mut fixed = vec![false; count];
    options.fixed.iter().for_each(|v| fixed[v.index()] = true);
    let mut state = State {
        mesh: mesh.clone(),
        sizes: sizes.to_vec(),
        fixed,
        near: mesh.vertices().map(|v| mesh.vertex_corners(v).first().map_or(0, |c| c.face().0)).collect(),
        origin: (0..count as u32).collect(),
    };
    let mut counts = RemeshCounts::default();
    for _ in 0..options.rounds {
        check_stopped()?;
        let done = state.change_faces(options)?;
        counts.splits += done.splits;
        counts.collapses += done.collapses;
        counts.flips += done.flips;
        counts.refused += done.refused;
        let State { mesh, sizes, fixed, .. } = &state;
        let positions = smooth::smoothed(mesh, sizes, fixed, options)?;
        state.mesh = state.mesh.with_positions(positions)?;
    }
    let place = |vertex: usize| {
        let place = nearest_from(mesh, Face(state.near[vertex]), state.mesh.positions()[vertex]);
        (place.face.0, place.weights)
    };
    let places = Places(mapped(options.threads, state.near.len(), place)?);
    let mut number = vec![None; count];
    for (new, &old) in state.origin.iter().enumerate().filter(|(_, old)| (**old as usize) < count) {
        number[old as usize] = Some(Vertex(new as u32));
    }
    let fixed = options.fixed.iter().filter_map(|v| number[v.index()]).collect();
    Ok(Remeshed { mesh: state.mesh, places, sizes: state.sizes, fixed, counts })
}

/// The surface between two rounds.
struct State {
    mesh: TriangleMesh,
    sizes: Vec<f64>,
    fixed: Vec<bool>,
    /// A face of the original surface near each vertex.
    near: Vec<u32>,
    /// The original vertex that each vertex is; beyond them if it is new.
    origin: Vec<u32>,
}

impl State {
    /// Splits, collapses and flips edges.
    fn change_faces(&mut self, options: &RemeshOptions) -> Result<RemeshCounts, RemeshError> {
        let changing = Changing::new(&self.mesh, self.sizes.clone(), self.fixed.clone(), self.near.clone());
        let mut passes = Passes::new(changing, options);
        passes.split_long()?;
        passes.collapse_short()?;
        passes.flip_to_delaunay()?;
        if passes.counts.changed() {
            let (mesh, kept) = passes.mesh.compact()?;
            self.mesh = mesh;
            self.sizes = kept.iter().map(|v| passes.mesh.sizes[*v as usize]).collect();
            self.fixed = kept.iter().map(|v| passes.mesh.fixed[*v as usize]).collect();
            self.near = kept.iter().map(|v| passes.mesh.near[*v as usize]).collect();
            self.origin =
                kept.iter().map(|v| self.origin.get(*v as usize).copied().unwrap_or(u32::MAX)).collect();
        }
        Ok(passes.counts)
    }
}

fn check(mesh: &TriangleMesh, sizes: &[f64], options: &RemeshOptions) -> Result<(), RemeshError> {
    let topology = Topology::in_steps(mesh, check_stopped)?;
    let edge = topology.nonmanifold_edges.first().map(|e: &Edge| e.to_string());
    let vertex = || topology.nonmanifold_vertices.first().map(|at| at.vertex.to_string());
    if let Some(at) = edge.or_else(vertex) {
        return Err(RemeshError::Nonmanifold { at });
    }
    let count = mesh.vertex_count();
    if sizes.len() != count {
        let fault = format!("{} lengths are given for {count} vertices", sizes.len());
        return Err(RemeshError::Sizes { fault });
    }
    if let Some(v) = sizes.iter().position(|x| !(*x > 0.0 && x.is_finite())) {
        let fault = format!("the length at {} is {}", Vertex(v as u32), sizes[v]);
        return Err(RemeshError::Sizes { fault });
    }
    match options.fixed.iter().find(|v| v.index() >= count) {
        Some(&vertex) => Err(RemeshError::Fixed { vertex, count }),
        None => Ok(()),
    }
}
