//! Sparse symmetric and Hermitian positive definite linear systems: supernodal multifrontal
//! Cholesky factorisation, analysed once per pattern and factored once per matrix. The crate knows
//! no mesh and hides the linear-algebra backend (`faer`).
//!
//! The steps are [`Graph`] (sparsity pattern) -> [`Symbolic`] (ordering, elimination tree,
//! predicted memory) -> [`Cholesky`] (numeric factor) -> [`Cholesky::solve`]. Everything runs on
//! one thread and returns the same digits every time; callers may factor independent systems on
//! separate threads.
//!
//! [`minimise_jumps`] solves one linear program: weighted L1 fitting of jumps on a graph, the dual
//! of minimum-cost flow.

mod cholesky;
mod dissection;
mod error;
mod flow;
mod graph;
mod kernels;
mod memory;
mod multifrontal;
mod ordering;
mod scalar;
mod supernodes;
mod symbolic;

pub use cholesky::{Cholesky, SymmetricMatrix};
pub use error::NumericError;
pub use flow::{
    Certificate, Contradiction, FlowError, JumpMethod, JumpOptions, JumpSolution, JumpStatistics, JumpTerm,
    minimise_jumps,
};
pub use graph::Graph;
pub use ordering::{Ordering, nested_dissection_order};
pub use scalar::{Complex, Scalar};
pub use symbolic::Symbolic;
