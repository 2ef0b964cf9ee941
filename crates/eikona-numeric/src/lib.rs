//! Sparse symmetric and Hermitian positive definite linear systems: supernodal multifrontal
//! Cholesky factorisation, analysed once per pattern and factored once per matrix. The crate knows
//! no mesh and hides the linear-algebra backend (`faer`).
//!
//! The steps are [`Graph`] (sparsity pattern) -> [`Symbolic`] (ordering, elimination tree,
//! predicted memory) -> [`Cholesky`] (numeric factor) -> [`Cholesky::solve`]. Results
//! have the same digits every time, on any number of threads.
//!
//! [`ConjugateGradient`] solves systems that are known by their products only.
//!
//! [`minimise_jumps`] solves one linear program: weighted L1 fitting of jumps on a graph, the dual
//! of minimum-cost flow.

mod cholesky;
mod complex;
mod compressed_rows;
mod conjugate_gradient;
mod dissection;
mod error;
mod flow;
mod graph;
mod half;
mod kernels;
mod matrix;
mod memory;
mod multifrontal;
mod observer;
mod ordering;
mod pack;
mod parallel;
mod resources;
mod scalar;
mod supernodes;
mod symbolic;
mod threads;

pub use cholesky::Cholesky;
pub use complex::Complex;
pub use compressed_rows::CompressedRows;
pub use conjugate_gradient::ConjugateGradient;
pub use error::NumericError;
pub use flow::{
    Certificate, InfeasibleCycle, JumpError, JumpMethod, JumpOptions, JumpSolution, JumpStatistics, JumpTerm,
    minimise_jumps,
};
pub use graph::Graph;
pub use half::HalfSolution;
pub use matrix::SymmetricMatrix;
pub use observer::{Observer, begin_phase, check_step, check_stopped, observed};
pub use ordering::{Ordering, nested_dissection_order};
pub use pack::{Instructions, Pack, Vectorized, vectorized};
pub use resources::Resources;
pub use scalar::Scalar;
pub use symbolic::Symbolic;
pub use threads::{for_chunks, mapped, side_by_side, together};
