//! Power-linear polar fields: N-directional fields with singularities at vertices, inside edges and
//! inside faces, exactly where they are asked for.
//!
//! **Problem.** A field of N directions per point, smooth everywhere except at prescribed points,
//! around which it turns as often as prescribed. **Idea.** (I) In each face the N-th power of the
//! field is a power of a linear field, so it may vanish at any point. How far it turns along each
//! side of a face, and from face to face, is a 1-form on the beveled mesh. (II) The prescribed
//! indices fix its sums around faces, edges, vertices and boundary loops, and along two generators
//! per handle: one such form by trees, then the smoothest one by a sparse factorisation that does
//! not depend on the prescription. (III) The scales at the corners put each zero in its place:
//! their ratios in singular faces and edges follow from the law of sines, the others are the
//! smoothest ones. (IV) Phases follow by integration.
//!
//! | paper | here | shape | equation |
//! |---|---|---|---|
//! | beveled mesh | `bevel.rs` | 3F corners | sec 4.1 |
//! | `theta` | `particular.rs`, `terms.rs`, `smoothness.rs` | split and jump edges | 6, B.1 |
//! | `r`, `kappa` | `bevel.rs` | jump edges, cycles | sec 4.2 |
//! | `H` | `homology.rs` | 2g walks | sec 4.3 |
//! | `I` | [`Singularity`] | cycles | sec 4.3 |
//! | `theta^S` | `targets.rs` | next to singularities | B.1 |
//! | `I_f` (power) | `powers.rs`, [`PolarField::power_of_face`] | F integers | sec 4.4 |
//! | `sigma` | `scale.rs` | corners | 5, 7 |
//! | `psi`, `U` | `field.rs`, [`PolarField::power_at`] | corners | sec 4.4 |
//!
//! All indices are counted in turns of the N-th power internally, so they are integers whose sum on
//! each component is N times its Euler characteristic.
//!
//! **Domain.** Manifold, orientable meshes with any number of components, handles and boundary
//! loops. Others are refused with the element.
//!
//! **Limits.** Where the field turns by more than half a turn of its power from face to face, it
//! shows additional singularities at edges; [`FieldReport::aliased`] lists them. This happens at
//! vertices with fewer faces than about 2N times their index, so refinement does not help; the same
//! index inside a face or edge is not aliased. Far from singularities, directions approach the
//! smoothest ones with refinement, down to 0.3 degrees of the power on regular triangles and 2.5
//! degrees on triangles four times as long as wide. Seen from there, a singularity is off from its
//! point by up to 0.2 edge lengths.
//!
//! **Reference.** Jiabao Brad Wang and Amir Vaxman, *Power-Linear Polar Directional Fields*,
//! arXiv:2506.00222, 2025.
//!
//! ```
//! use eikona::mesh::{SurfacePoint, shapes};
//! use eikona::polar_field::{FieldOptions, Place, Singularity, Solver};
//! // A vector field on a flat disk with one singularity, inside a face.
//! let disk = shapes::disk(6, 12, 1.0)?;
//! let [i, j, k] = disk.triangles()[40];
//! let point = SurfacePoint::Face { vertices: [i, j, k], bary: [0.2, 0.5, 0.3] };
//! let singularities = [
//!     Singularity { place: Place::Point(point), index: 1.0 },
//!     Singularity { place: Place::Boundary(0), index: 0.0 },
//! ];
//! let solver = Solver::new(&disk, &Default::default())?;
//! let field = solver.solve(&singularities, &FieldOptions::default().with_degree(1))?;
//! assert_eq!(field.report.measured, [1.0, 0.0]);
//! // It vanishes there, and only there.
//! assert!(field.vectors_at(SurfacePoint::Vertex { vertex: 0 })?[0][2] == 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod alignment;
mod automatic;
mod bevel;
mod curvature;
mod data;
mod domain;
mod error;
mod face_field;
mod field;
mod guides;
mod homology;
mod inspection;
mod options;
mod particular;
mod per_face;
mod powers;
mod problem;
mod responses;
#[cfg(test)]
mod samples;
mod scale;
mod singularity;
mod smoothness;
mod solution;
mod solver;
mod streamlines;
mod surface;
mod targets;
mod terms;
mod trivial;
#[cfg(test)]
mod twin;

pub use alignment::Followed;
pub use automatic::Prescription;
pub use data::FieldData;
pub use error::PolarFieldError;
pub use guides::{CREASE_DEGREES, Guide};
pub use inspection::{FaceVectors, FieldInspection, Match, inspect_field};
pub use options::{AutomaticOptions, FieldOptions, Smoothness, SolverOptions};
pub use per_face::SampledField;
pub use singularity::{Place, Singularity};
pub use solution::{FieldReport, Measured, PolarField};
pub use solver::Solver;
pub use streamlines::{Streamline, StreamlineEnd, StreamlineOptions};
