//! Surface winding numbers: integer inside/outside labels from curves on a surface, for broken
//! curves and for surfaces on which a loop need not bound.
//!
//! **Problem.** On a torus a closed curve need not bound a region, and a curve with gaps bounds
//! nothing anywhere. **Idea.** (I) Solve for the smoothest function that jumps by one across the
//! curve, higher on its left. (II) The harmonic part of its derivative encodes the curve's homology
//! class. (III) The shortest closed jumps with the same harmonic part are the nonbounding part of
//! the curve. (IV) Without that part the function is a winding number; rounding it labels the
//! regions.
//!
//! | paper | here | shape | equation |
//! |---|---|---|---|
//! | `Gamma` | [`Winding::jump`], `chain.rs` | E integers | sec 2.2 |
//! | `c` | `coordinates.rs` | corners | sec 2.3.1 |
//! | `u` | `operators/jump_laplacian.rs` | corners | 10 |
//! | `omega` | `operators/jump_laplacian.rs` | halfedges | sec 2.4.2 |
//! | `gamma` | `operators/hodge.rs` | halfedges | sec 3.3 |
//! | `t` | [`Winding::nonbounding`], `nonbounding.rs` | E | 11 |
//! | `sigma`, `v` | [`Winding::residual_function`], `nonbounding.rs` | F, corners | 11 |
//! | `w` | [`Winding::values`] | corners | sec 3.5 |
//! | - | [`Winding::labels`], [`Winding::margin`] | F | sec 3.5.1 |
//! | - | [`CompletionShape`], `straight/` | paths | - |
//! | - | [`Winding::split`], `split.rs` | mesh | - |
//!
//! Internally the curve is a dual 1-chain: an ordered pair of faces per edge and the jump between
//! them. One code path therefore serves oriented, inconsistently oriented and nonorientable
//! surfaces. Only reading a curve needs to know its left side (on nonorientable surfaces it is
//! transported along the curve; [`Curve::up`](eikona_mesh::Curve::up) chooses it).
//!
//! **Special domains.** The boundary of the surface is free: the function does not jump there, and
//! a curve that ends on it has no endpoint there (relative homology). Edges of three or more faces
//! are cuts for the harmonic part; curve steps along them are left out with a warning.
//!
//! **Straight completions.** Where labels meet in gaps of the curve, and where nonbounding loops
//! leave the curve, the method yields paths along edges. Each is straightened to a locally shortest
//! path across faces between the same ends (open ends of the curve, or vertices where pieces meet),
//! homotopic to the edge path on the surface cut open along the curve. The mesh is cut along it.
//! Labels, values, nonbounding jumps, loops and [`Winding::split`] follow; the cost of the linear
//! program, residuals, the largest nonbounding jump and the orientation report stay those of the
//! solution on edges. A path that would cross others, or take in a region whose label is certain,
//! moves less far or not at all. [`CompletionShape::Edges`] keeps the edge paths, as the public
//! program does; curves without completion give the same digits either way. Deviation: the paper
//! has no such step.
//!
//! **Limits.** Where a curve is broken, nonbounding jumps are real numbers and labels near gaps are
//! guesses: see [`Winding::margin`].
//!
//! **Reference.** Nicole Feng, Mark Gillespie and Keenan Crane, *Winding Numbers on Discrete
//! Surfaces*, ACM Trans. Graph. 42 (4), 2023.
//!
//! ```
//! use eikona::mesh::{Curve, Face, SurfaceCurves, Vertex, shapes};
//! use eikona::winding::{WindingOptions, surface_winding_number};
//! // A flat disk; its innermost ring of vertices (1 to 6), counter-clockwise, is the curve.
//! let disk = shapes::disk(20, 6, 20.0)?;
//! let ring = Curve::signed([1, 2, 3, 4, 5, 6, 1].map(Vertex));
//! let curve = SurfaceCurves::from_curve(ring);
//! let winding = surface_winding_number(&disk, &curve, &WindingOptions::default())?;
//! let inside = winding.mesh.vertex_corners(Vertex(0))[0].face();
//! assert_eq!(winding.labels[inside], 1);
//! assert_eq!(winding.labels.iter().filter(|(_, label)| **label == 1).count(), 6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod chain;
mod coordinates;
mod corner_values;
mod decomposition;
mod error;
mod islands;
mod labels;
mod loops;
mod names;
mod nonbounding;
mod operators;
mod options;
mod orientation;
mod solution;
mod solver;
mod split;
mod steps;
mod straight;
mod surface;
mod walks;
mod warnings;

pub use decomposition::Part;
pub use error::{UnsolvedProgram, WindingError};
pub use loops::JumpLoop;
pub use options::{
    Completion, CompletionShape, Diagnosis, EPSILON_RANGE, Reference, SolverOptions, WindingOptions,
};
pub use orientation::{AUTOMATIC_DIAGNOSIS_LIMIT, Orientation};
pub use solution::{CompletionReport, ProgramReport, Winding, WindingReport};
pub use solver::Solver;
pub use split::Split;

use eikona_mesh::{SurfaceCurves, TriangleMesh};

/// Computes the winding number of curves in one call: [`Solver::new`] with default options, and
/// [`Solver::solve`].
///
/// # Errors
/// Those of [`Solver::new`] and [`Solver::solve`].
pub fn surface_winding_number(
    mesh: &TriangleMesh,
    curves: &SurfaceCurves,
    options: &WindingOptions,
) -> Result<Winding, WindingError> {
    Solver::new(mesh, &SolverOptions::default())?.solve(curves, options)
}
