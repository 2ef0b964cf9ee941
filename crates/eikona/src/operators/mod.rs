//! Discrete operators, assembled from meshes into sparse matrices. Laplacians are positive
//! semidefinite.

mod cotan;
mod crouzeix_raviart;
mod hodge;
mod jump_laplacian;

pub use cotan::{CotanLaplacian, divergence};
pub use crouzeix_raviart::{ComplexFrames, ConnectionLaplacian, EdgeFrames, RealFrames};
pub(crate) use hodge::Hodge;
pub(crate) use jump_laplacian::{
    JumpLaplacian, darboux_derivative, differences, parts, right_hand_side, solve_jump_equation,
};
