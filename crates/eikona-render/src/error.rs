//! Errors of rendering.

use eikona_mesh::CurveError;
use thiserror::Error;

/// Invalid scene, options or output file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RenderError {
    /// A side of the image is zero or too long.
    #[error("an image of {width} x {height} pixels is not supported; each side must be 1 to 16384")]
    ImageSize {
        /// Requested width.
        width: u32,
        /// Requested height.
        height: u32,
    },
    /// There are too many samples for a reasonable amount of memory.
    #[error("{samples} samples exceed the limit of {limit}; make the image smaller or lower `supersampling`")]
    TooManySamples {
        /// Width times height times supersampling squared.
        samples: u64,
        /// Largest number allowed.
        limit: u64,
    },
    /// An option is out of range.
    #[error("{name} = {value} is out of range: {bound}")]
    Option {
        /// Name of the option.
        name: &'static str,
        /// The value given.
        value: f64,
        /// Allowed values.
        bound: &'static str,
    },
    /// A field does not have one value per element.
    #[error("the field has {found} {what}, but the mesh needs {expected}, in its own order")]
    WrongLength {
        /// Kind of the values ("values per vertex").
        what: &'static str,
        /// Number given.
        found: usize,
        /// Number needed.
        expected: usize,
    },
    /// A value or coordinate cannot be drawn. NaN is allowed in fields, where it means "no value";
    /// infinities are not.
    #[error("{what} {index} is {value}; it must be finite (fields may use NaN for \"no value\")")]
    NonFinite {
        /// Owner of the value ("value of vertex", "a coordinate of drawing 3, point").
        what: String,
        /// 0-based index.
        index: usize,
        /// The value given.
        value: f64,
    },
    /// The colour range is empty or not finite.
    #[error("the colour range {min} to {max} is invalid; give finite numbers, the smaller first")]
    Range {
        /// Lower end.
        min: f64,
        /// Upper end.
        max: f64,
    },
    /// There are isolines, but the surface is not coloured by a field that has any.
    #[error("isolines need a scalar field per vertex or per corner as the colouring of the surface")]
    NoIsolines,
    /// There is no colour map of this name.
    #[error("there is no colour map \"{name}\"; choose one of {choices}")]
    UnknownColorMap {
        /// The name given.
        name: String,
        /// All valid names.
        choices: String,
    },
    /// A curve on the surface does not fit the mesh.
    #[error(transparent)]
    Curve(#[from] CurveError),
    /// The pixel array has the wrong length, or encoding failed.
    #[error("the image cannot be encoded as PNG: {reason}")]
    Encoding {
        /// Reason.
        reason: String,
    },
    /// The file cannot be written.
    #[error("{path} cannot be written: {source}; the file, if there was one, is unchanged")]
    Write {
        /// The file.
        path: String,
        /// Error of the operating system.
        source: std::io::Error,
    },
}
