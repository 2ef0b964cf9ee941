//! Discrete operators: where mesh and matrix meet. Laplacians are positive semidefinite.

mod cotan;
mod crouzeix_raviart;

pub use cotan::{CotanLaplacian, divergence};
pub use crouzeix_raviart::{ComplexFrames, ConnectionLaplacian, EdgeFrames, RealFrames};
