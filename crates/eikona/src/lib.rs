//! eikona

pub mod contour;
pub mod geometry;
pub mod spatial;
