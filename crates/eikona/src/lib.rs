//! Geometry processing for imperfect input: signed distance along a surface ([`signed_heat`]) and
//! inside/outside by winding numbers ([`winding`]), from curves with gaps, noise and crossings;
//! directions with prescribed singularities ([`polar_field`]); and the energy of surfaces that
//! repel themselves ([`repulsive`]). This version works on triangle meshes.
//!
//! Meshes, curves and files come from [`eikona_mesh`], re-exported as [`mesh`]; complex numbers and
//! sparse systems from [`eikona_numeric`], re-exported as [`numeric`]. `docs/conventions.md` is the
//! single reference for signs, orientations and units.

pub use eikona_mesh as mesh;
pub use eikona_numeric as numeric;

pub mod contour;
pub mod curves;
pub mod cut;
pub mod geometry;
pub mod operators;
mod option_name;
mod phases;
pub mod polar_field;
pub mod remesh;
pub mod repulsive;
mod setters;
pub mod signed_heat;
pub mod spatial;
mod warning;
pub mod winding;

pub use option_name::OptionNameError;
pub use warning::Warning;

/// Compiles the program in the README.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
