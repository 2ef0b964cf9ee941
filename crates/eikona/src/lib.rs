//! eikona answers four questions about imperfect geometry: how far and on which side, inside or
//! outside, which direction, and how a surface can move without touching itself. This version
//! answers the first two, on triangle meshes: see [`signed_heat`] and [`winding`].
//!
//! Meshes, curves and files are those of [`eikona_mesh`], re-exported as [`mesh`]; complex numbers
//! and sparse systems those of [`eikona_numeric`], re-exported as [`numeric`]. Signs, orientations
//! and units are defined in `docs/conventions.md`.

pub use eikona_mesh as mesh;
pub use eikona_numeric as numeric;

pub mod contour;
pub mod curves;
pub mod cut;
pub mod geometry;
pub mod operators;
mod option_name;
mod phases;
pub mod signed_heat;
pub mod spatial;
pub mod winding;
mod wording;

pub use option_name::OptionNameError;

/// The program of the README compiles.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
