//! Why no winding number could be computed.

use crate::contour::EmbedError;
use eikona_mesh::{CurveError, Edge, Face};
use eikona_numeric::FlowError;
use eikona_numeric::NumericError;
use thiserror::Error;

/// Why no winding number could be computed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WindingError {
    /// The curve is not on the mesh.
    #[error(transparent)]
    Curve(#[from] CurveError),
    /// The mesh has no faces.
    #[error("the mesh has no faces, so there is nothing to be inside of")]
    NoFaces,
    /// There is no curve.
    #[error("there is no curve, so every region is outside; give at least one oriented curve")]
    NoCurve,
    /// A curve without direction bounds nothing.
    #[error("curve {curve} has no direction, so it has no inside; give it as a signed curve")]
    Unsigned {
        /// 0-based index of the curve.
        curve: usize,
    },
    /// The mesh could not be cut along the curves.
    #[error(transparent)]
    Embed(#[from] EmbedError),
    /// An edge is walked too often.
    #[error("edge {} is walked more than {most} times in one direction; leave repeated copies of the curve out", edge.index())]
    Multiplicity {
        /// The edge.
        edge: Edge,
        /// The largest multiplicity that is accepted.
        most: i32,
    },
    /// An option is out of range.
    #[error("{name} = {value} is out of range: {bound}")]
    Option {
        /// The option.
        name: &'static str,
        /// The value given.
        value: f64,
        /// What is allowed.
        bound: &'static str,
    },
    /// A linear system could not be solved.
    #[error(transparent)]
    Numeric(#[from] NumericError),
    /// The linear program could not be solved.
    #[error(
        "the nonbounding part of the curve could not be found ({0}); if edges differ in length by many orders of magnitude, remesh first"
    )]
    Program(#[from] FlowError),
}

impl WindingError {
    pub(crate) fn no_such_reference(face: Face) -> WindingError {
        let bound = "the reference face does not exist; faces are numbered from 0";
        WindingError::Option { name: "reference", value: face.index() as f64, bound }
    }
}
