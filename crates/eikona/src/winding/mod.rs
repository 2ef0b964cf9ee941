//! Inside or outside, and how often, of curves on a surface that may be broken, on surfaces where a
//! loop need not bound anything: surface winding numbers.
//!
//! **Problem.** On a torus a closed curve need not be the boundary of a region, and a curve with
//! gaps bounds nothing anywhere. **Idea.** (I) Take the smoothest function that jumps by one across
//! the curve, higher on its left. (II) Its derivative knows which loops it can not be undone along:
//! the harmonic part. (III) The shortest closed jumps with the same harmonic part are what bounds
//! nothing; taken off, (IV) the function is a winding number, and rounded it labels regions.
//!
//! | paper | here | shape | equation |
//! |---|---|---|---|
//! | `Gamma` | [`Winding::jump`], `chain.rs` | E whole numbers | sec 2.2 |
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
//! Inside, the curve is a dual chain: for each edge an ordered pair of faces and the jump between
//! them. So orientable, inconsistently wound and one-sided surfaces are one code; only reading a
//! curve has to know its left (carried along the curve on one-sided surfaces;
//! [`Curve::up`](eikona_mesh::Curve::up) chooses it).
//!
//! **Special domains.** The boundary of the surface is free: nothing jumps there, and a curve that
//! ends on it has no endpoint there (relative homology). Edges of three or more faces are cuts for
//! the harmonic part, and a curve along them is left out with a warning.
//!
//! **Completions are straight.** Where labels meet in gaps of the curve, and where nonbounding
//! loops leave it, the method gives paths along edges. Each is pulled straight: to a shortest path
//! across faces between the same ends (open ends of the curve, or vertices where pieces meet),
//! homotopic to the path along edges on the surface without the curve. The mesh is cut along it.
//! Labels, values, nonbounding jumps, loops and [`Winding::split`] follow; the cost of the linear
//! program, residuals, the largest nonbounding jump and the orientation stay those of the solution
//! on edges. A path that would cross others, or take in a region whose label is certain, moves less
//! far or not at all. [`CompletionShape::Edges`] leaves all as it is, as the public program does;
//! curves without completion give the same digits either way. Deviation: the paper says nothing of
//! it.
//!
//! **Limits.** Where a curve is broken the nonbounding jumps are real numbers, and labels near gaps
//! are guesses: see [`Winding::margin`].
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
mod notes;
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

pub use decomposition::Part;
pub use error::{UnsolvedProgram, WindingError};
pub use loops::JumpLoop;
pub use options::{Completion, CompletionShape, Diagnosis, EPSILONS, Reference, WindingOptions};
pub use orientation::{MOST_STRETCHES, Orientation};
pub use solution::{CompletionReport, ProgramReport, Winding, WindingReport};
pub use solver::Solver;
pub use split::Split;

use eikona_mesh::{SurfaceCurves, TriangleMesh};

/// The winding number of curves in one call: [`Solver::new`] and [`Solver::solve`].
///
/// # Errors
/// Those of [`Solver::new`] and [`Solver::solve`].
pub fn surface_winding_number(
    mesh: &TriangleMesh,
    curves: &SurfaceCurves,
    options: &WindingOptions,
) -> Result<Winding, WindingError> {
    Solver::new(mesh)?.solve(curves, options)
}
