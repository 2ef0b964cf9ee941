//! Repulsive surfaces: an energy that grows without bound as a surface touches itself.
//!
//! **Problem.** Move a surface, to untangle, shrink or grow it, so that it never passes through
//! itself. **Idea.** The tangent-point energy compares each point with the spheres that touch the
//! surface there and pass through another point: their radius is small for points that are close in
//! space but not along the surface. [`Flow`] steps down the energy, steepest in a fractional inner
//! product ([`Metric`]), in which steps do not get shorter on finer meshes.
//!
//! | paper | here | shape | equation |
//! |---|---|---|---|
//! | `X_S`, `n_S`, `a_S` | `faces.rs` | F centroids, normals, areas | sec 3.1 |
//! | `K_p(S, T)` | `kernel.rs`, `all_pairs.rs` | pairs of faces | 9 |
//! | `adm(S)` | `hierarchical.rs`, `leaf_sums.rs` | near faces and far clusters | 17 |
//! | (none) | `near_contact.rs`, `contact_sums.rs` | parts of faces in near contact | [`Quadrature`] |
//! | `E` | [`TangentPointEnergy::value`] | number | 3 |
//! | `dE` | [`TangentPointEnergy::differential`] | V vectors | sec 4.2 |
//! | `A = B + B0` | [`Metric::product`] | V x V on vectors | 7, 8, 12, 13 |
//! | `L^(2-s)` | [`Metric::fractional_product`] | V x V on vectors | 11, sec 5.2 |
//! | `x` | `flow/direction.rs` | V vectors | 14, 20 |
//! | compared methods | [`Method`], `metric/local.rs` | V vectors | sec 8.2.1 |
//! | `h` | `flow/mod.rs`, `corrected` | V vectors | 15, 21 |
//! | `E_area` | [`Potential`], `potential/totals.rs` | number, V vectors | sec 7.3.1 |
//! | `E_obs` | [`Obstacle`], `potential/far_field.rs` | number, V vectors | sec 7.3.2 |
//! | `E_i`, `E_a` | [`ImplicitSurface`], `potential/implicit.rs` | number, V vectors | sec 7.3.3 |
//! | `E_b`, `E_c` | `potential/boundary.rs` | number, V vectors | sec 7.3.4 |
//! | `E_Willmore` | `potential/willmore.rs` | number, V vectors | sec 7.3.5 |
//!
//! The sum runs over ordered pairs of different faces:
//! `E = sum over S != T of |n_S . (X_S - X_T)|^alpha / |X_S - X_T|^beta a_S a_T`.
//!
//! Deviation: equation 2 of the paper has a factor `2^p`, which its text drops in equation 3; the
//! published programs and this module leave it out.
//!
//! **Reference.** Chris Yu, Caleb Brakensiek, Henrik Schumacher and Keenan Crane, *Repulsive
//! Surfaces*, ACM Transactions on Graphics 40 (6), 2021.

mod all_pairs;
mod contact_sums;
mod energy;
mod error;
mod faces;
mod flow;
mod hierarchical;
mod kernel;
mod leaf_sums;
mod metric;
mod moments;
mod near_contact;
mod options;
mod pair_sum;
mod potential;
mod quantity;

pub use energy::{TangentPointEnergy, tangent_point_energy};
pub use error::RepulsiveError;
pub use flow::{Barycentre, Flow, FlowOptions, FlowState, FlowStep, Growth, Method, Pin, Remeshing};
pub use metric::{Metric, MetricOptions, MetricSolution};
pub use options::{EnergyOptions, Exponents, Pairs, Quadrature};
pub use potential::{ImplicitSurface, Obstacle, Potential, PotentialKind, SampledDistance, StartPositions};
pub use quantity::Quantity;
