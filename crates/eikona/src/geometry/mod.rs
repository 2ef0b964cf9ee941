//! Lengths, areas, angles and frames.

pub mod vector;
