//! Procedural shapes: deterministic meshes given by formulas, with element counts in closed form.
//!
//! Each shape is a function whose docs give counts, parametrisation and orientation. [`make`] makes
//! any of them by name from `key = value` pairs, like the command `eikona make`;
//! [`shape_descriptions`] lists them. Curves in space that accompany the shapes ([`circle`],
//! [`torus_knot`], ...) can be broken into pieces by [`break_polyline`].
//!
//! | family | shapes |
//! |---|---|
//! | spheres | [`geodesic_sphere`], [`icosphere`], [`uv_sphere`], [`cube_sphere`], [`bumpy_sphere`] |
//! | solids | [`tetrahedron`], [`octahedron`], [`icosahedron`], [`cuboid`] |
//! | of revolution | [`torus`], [`punctured_torus`], [`cylinder`], [`cone`] |
//! | flat | [`grid`], [`grid_with_holes`], [`strip`], [`disk`], [`annulus`] |
//! | tubes | [`tube`], [`trefoil_tube`], [`figure_eight_tube`], [`linked_rings`] |
//! | from blocks | [`chain_of_genus`], [`clay_animal`], [`handcuffs`], [`joined_rings`], [`borromean_rings`], [`knotted_tunnel`] |
//! | one-sided | [`moebius_band`], [`klein_bottle`], [`projective_plane`] |
//!
//! Every shape has at most [`MAX_SHAPE_FACES`] faces and no face of zero area.

use crate::vector::{Vec3, norm, scale};
mod boxes;
mod curves;
mod flat;
mod holes;
mod lattice;
mod one_sided;
pub(crate) mod parameter;
mod platonic;
mod polycube;
mod registry;
mod revolution;
mod spheres;
#[cfg(test)]
mod tests;
mod tubes;

pub use boxes::cuboid;
pub use curves::{
    break_polyline, break_polyline_at_random, circle, figure_eight_knot, latitude_circle, torus_knot,
    trefoil, wavy_latitude,
};
pub use flat::{annulus, disk, grid, strip};
pub use holes::{Hole, grid_with_holes};
pub use lattice::Diagonal;
pub use one_sided::{klein_bottle, moebius_band, projective_plane};
pub use parameter::MAX_SHAPE_FACES;
pub use platonic::{icosahedron, octahedron, tetrahedron};
pub use polycube::{
    TunnelKnot, borromean_rings, chain_of_genus, clay_animal, handcuffs, joined_rings, knotted_tunnel,
};
pub use registry::{Parameter, ShapeDescription, make, shape_descriptions, shape_names};
pub use revolution::{Ends, cone, cylinder, punctured_torus, torus};
pub use spheres::{bumpy_sphere, cube_sphere, geodesic_sphere, icosphere, uv_sphere};
pub use tubes::{figure_eight_tube, linked_rings, trefoil_tube, tube};

/// Normalises a vector of ordinary length; the zero vector stays zero.
fn unit(a: Vec3) -> Vec3 {
    let length = norm(a);
    if length > 0.0 { scale(a, 1.0 / length) } else { a }
}
