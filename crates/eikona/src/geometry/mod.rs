//! Lengths, areas, angles: intrinsic first.

mod triangle;

pub use triangle::{Triangle, distance};
