//! Options of remeshing.

use super::barrier::Barrier;
use crate::setters::setters;
use eikona_mesh::{TriangleMesh, Vertex};
use std::sync::Arc;

/// Options of [`remesh`](super::remesh).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RemeshOptions {
    /// Rounds of all operations. Default: 5.
    pub rounds: usize,
    /// Vertices that stay where they are. Default: none.
    pub fixed: Vec<Vertex>,
    /// Whether operations are refused by which the surface would touch itself or the obstacle.
    /// Default: yes.
    pub collisions: bool,
    /// A surface that stays as it is. Default: none.
    pub obstacle: Option<TriangleMesh>,
    /// What the surface stays out of, besides. Default: nothing.
    pub(crate) barrier: Option<Arc<dyn Barrier>>,
    /// Number of threads. Default: 1. The result is the same for any number.
    pub threads: usize,
}

impl Default for RemeshOptions {
    fn default() -> Self {
        RemeshOptions {
            rounds: 5,
            fixed: Vec::new(),
            collisions: true,
            obstacle: None,
            barrier: None,
            threads: 1,
        }
    }
}

setters!(RemeshOptions {
    with_rounds: rounds = usize,
    with_fixed: fixed = Vec<Vertex>,
    with_collisions: collisions = bool,
    with_obstacle: obstacle = Option<TriangleMesh>,
    with_threads: threads = usize
});
