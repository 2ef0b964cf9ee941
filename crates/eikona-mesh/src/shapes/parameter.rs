//! Validation of the parameters of shapes and damages.

use crate::error::MeshError;
use std::fmt::Display;
use std::ops::RangeInclusive;

/// The largest number of faces of a shape: larger requests are refused before memory is allocated.
pub const MAX_SHAPE_FACES: usize = 1 << 25;

/// Lengths in this range can be raised to the fourth power, as in the square of an area, without
/// overflow or underflow.
const LENGTHS: RangeInclusive<f64> = 1e-70..=1e70;

pub(crate) fn refuse<T>(
    name: &'static str,
    value: impl Display,
    bound: &'static str,
) -> Result<T, MeshError> {
    Err(MeshError::Parameter { name, value: value.to_string(), bound })
}

pub(crate) fn require(
    holds: bool,
    name: &'static str,
    value: impl Display,
    bound: &'static str,
) -> Result<(), MeshError> {
    if holds { Ok(()) } else { refuse(name, value, bound) }
}

pub(crate) fn require_length(name: &'static str, value: f64) -> Result<(), MeshError> {
    require(LENGTHS.contains(&value), name, value, "a length must lie between 1e-70 and 1e70")
}

pub(crate) fn require_share(name: &'static str, value: f64) -> Result<(), MeshError> {
    require((0.0..=1.0).contains(&value), name, value, "a share must lie between 0 and 1")
}

/// Requires at least three, for a closed ring of triangles.
pub(crate) fn require_ring(name: &'static str, value: usize) -> Result<(), MeshError> {
    require(value >= 3, name, value, "a closed ring needs at least 3")
}

pub(crate) fn require_some(name: &'static str, value: usize) -> Result<(), MeshError> {
    require(value >= 1, name, value, "at least 1 is needed")
}

/// Refuses shapes with too many faces. The expected number is an `f64`, so that no product of
/// counts can overflow.
pub(crate) fn limit_faces(name: &'static str, value: impl Display, faces: f64) -> Result<(), MeshError> {
    let bound = "the shape would have more than 2^25 (33,554,432) faces; use a smaller number";
    require(faces <= MAX_SHAPE_FACES as f64, name, value, bound)
}
