//! What we *solve*: sparse symmetric and Hermitian positive definite systems by supernodal Cholesky
//! factorisation, analysed once and solved many times. Knows no mesh, and hides the linear-algebra
//! backend (`faer`).
//!
//! The way of a system: [`Graph`] (which unknowns meet) -> [`Symbolic`] (ordering, elimination
//! tree, predicted memory) -> [`Cholesky`] (numbers) -> [`Cholesky::solve`]. Everything runs on one
//! thread and gives the same digits every time; two independent systems may be factored on two
//! threads by the caller.
//!
//! Beside the systems stands one linear program: [`minimise_jumps`], for the methods whose fields
//! may jump.

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
