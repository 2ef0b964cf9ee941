//! Errors of isolines and plane cuts.

use thiserror::Error;

/// Error of isolines and plane cuts.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ContourError {
    /// A field of the wrong length.
    #[error("the field has {found} values, the mesh has {expected} vertices; give one value per vertex")]
    WrongLength {
        /// Number of values given.
        found: usize,
        /// Number of vertices.
        expected: usize,
    },
    /// A parameter out of range.
    #[error("{name} = {value} is out of range: {bound}")]
    Parameter {
        /// The parameter's name.
        name: &'static str,
        /// The value given.
        value: f64,
        /// The accepted range.
        bound: &'static str,
    },
    /// A plane with an invalid point or normal.
    #[error(
        "the plane's {name} is ({}, {}, {}); it must be finite and, for a normal, not zero",
        value[0], value[1], value[2]
    )]
    BadPlane {
        /// "point" or "normal".
        name: &'static str,
        /// The value given.
        value: [f64; 3],
    },
}
