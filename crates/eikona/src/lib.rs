//! eikona: geometry that is imperfect, measured all the same. (crate docs to be completed)
pub mod geometry;
pub mod operators;
pub mod signed_heat;
