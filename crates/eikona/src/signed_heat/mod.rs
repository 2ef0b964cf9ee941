//! Signed distance along a triangle mesh to curves that may be broken, by the signed heat method.
//!
//! **Problem.** Curves with gaps, noise and crossings bound no region, so "how far, and on which
//! side" has no exact answer. **Method.** (I) Diffuse the *normals* of the curves for a short time:
//! far from the curves the diffused vectors point along the gradient of the distance, and across
//! gaps they average. (II) Normalise them. (III) Find the function whose gradient is closest to
//! them in the least-squares sense. Steps I and III are sparse linear systems, factored once for
//! all curves; level set constraints factor the second, smaller system again.
//!
//! | paper | here | shape, unit | equation |
//! |---|---|---|---|
//! | `M`, `L` (nabla) | [`ConnectionLaplacian`](crate::operators::ConnectionLaplacian) | E x E complex, or real | 7, 9 |
//! | `C`, `b` | [`CotanLaplacian`](crate::operators::CotanLaplacian), [`divergence`](crate::operators::divergence) | V x V real, V | 10, sec 5.5 |
//! | `t` | [`ChosenTime`], [`DiffusionTime`] | length^2 | 12, sec 6 |
//! | `X_0` | `source.rs` | E | 11; for points and unsigned curves not A.1, A.2 |
//! | `X`, `Y` | `diffusion.rs`; [`Solution::gradient`] | E; F unit vectors | 12, sec 6 |
//! | `phi` | [`Solution::distance`] | V, length | 13, 14 |
//! | `A` | [`LevelSets`], `level_sets.rs` | rows of constraints | 14, sec 7.1 |
//!
//! **Sign.** Negative on the left of an oriented curve (positive in the paper and in
//! geometry-central; see [`SignConvention`]). Distances to isolated points and unsigned curves are
//! positive on all sides.
//!
//! **Domains.** Any triangle mesh:
//!
//! * With boundary, and with several components. Each component has its own shift; those that no
//!   source reaches get NaN and a warning.
//! * Nonmanifold. At a nonmanifold edge along a curve, [`Curve::up`](eikona_mesh::Curve::up)
//!   selects the sheets on the left.
//! * Inconsistently oriented. Faces are reoriented where that gives a consistent orientation;
//!   elsewhere the orientation of the faces does not matter.
//! * Nonorientable. The side is transported along the curve; [`Curve::up`](eikona_mesh::Curve::up)
//!   chooses it.
//! * With zero-area faces, which are mollified (see [`Triangle`](crate::geometry::Triangle)).
//!
//! **Limits.** First-order accurate in the edge length near corners and gaps of curves, better on
//! smooth curves with [`DiffusionTime::Automatic`]. The completion of a gap is an extrapolation:
//! ask for [`Confidence`]. Where curves bound no region, the fit of section 7.1 is smooth across
//! the jump that the distance would have; the L1 fit (section 7.2) is not in this version.
//!
//! **Reference.** Nicole Feng and Keenan Crane, *A Heat Method for Generalized Signed Distance*,
//! ACM Trans. Graph. 43 (4), 2024.
//!
//! ```
//! use eikona::mesh::{Curve, SurfaceCurves, shapes};
//! use eikona::signed_heat::{SolveOptions, SolverOptions, signed_distance};
//! // A flat disk; its innermost ring of vertices (1 to 6), counter-clockwise, is the curve.
//! let disk = shapes::disk(20, 6, 20.0)?;
//! let ring = Curve::signed([1, 2, 3, 4, 5, 6, 1].map(eikona::mesh::Vertex));
//! let source = SurfaceCurves::from_curve(ring);
//! let (solver, solve) = (SolverOptions::default(), SolveOptions::default());
//! let solution = signed_distance(&disk, &source, &solver, &solve)?;
//! let distance = solution.distance.as_slice();
//! assert!(distance[0] < 0.0, "the centre is on the left of the curve");
//! assert!((distance[disk.vertex_count() - 1] - 19.0).abs() < 0.3, "the rim is 19 from the ring");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod automatic;
mod condition;
mod confidence;
mod crossings;
mod diffusion;
mod error;
mod integration;
mod level_sets;
mod names;
mod normals;
mod options;
mod refinement;
mod report;
mod sheets;
mod slivers;
mod solution;
mod solver;
mod source;
mod time;

pub use crate::phases::Phases;
pub use automatic::ChosenLevelSets;
pub use error::SignedHeatError;
pub use options::{DiffusionTime, LevelSets, SOFT_WEIGHT_RANGE, SignConvention, SolveOptions, SolverOptions};
pub use report::{NormalConstraints, Preparation, Report};
pub use solution::{Confidence, Solution};
pub use solver::Solver;
pub use time::{ChosenTime, TIME_COEFFICIENTS};

use eikona_mesh::{SurfaceCurves, TriangleMesh};

/// Computes the signed distance in one call: builds a [`Solver`] for this source and solves once.
///
/// The result is the same as from a [`Solver`] with these options.
///
/// # Errors
/// Those of [`Solver::new`] and [`Solver::solve`].
///
/// # Cost
/// Two sparse factorisations, and one more of the smaller system for [`LevelSets`] other than
/// `Free`. For several sources on one mesh, keep the [`Solver`].
pub fn signed_distance(
    mesh: &TriangleMesh,
    source: &SurfaceCurves,
    solver: &SolverOptions,
    solve: &SolveOptions,
) -> Result<Solution, SignedHeatError> {
    let options = SolverOptions { time: solver.time.for_source(mesh, source), ..*solver };
    Solver::new(mesh, &options)?.solve(source, solve)
}
