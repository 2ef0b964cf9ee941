//! Why there is no picture.

use eikona_mesh::CurveError;
use thiserror::Error;

/// What can be wrong with a scene, its options or the file to write.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RenderError {
    /// A side of the picture is zero or too long.
    #[error("a picture of {width} x {height} pixels can not be made; each side must be 1 to 16384")]
    ImageSize {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
    },
    /// More samples than fit in a reasonable amount of memory.
    #[error("{samples} samples are more than {limit}; make the picture smaller or lower `supersampling`")]
    TooManySamples {
        /// Width times height times supersampling squared.
        samples: u64,
        /// The most that are drawn.
        limit: u64,
    },
    /// An option is out of its range.
    #[error("{name} = {value} is out of range: {bound}")]
    Option {
        /// Its name.
        name: &'static str,
        /// The value given.
        value: f64,
        /// What is allowed.
        bound: &'static str,
    },
    /// A field does not have one value an element.
    #[error("{found} {what} were given, {expected} are needed: one an element, in the order of the mesh")]
    WrongLength {
        /// What the values are ("values per vertex").
        what: &'static str,
        /// The number given.
        found: usize,
        /// The number needed.
        expected: usize,
    },
    /// A value that can not be drawn. NaN is allowed in fields, where it means "no value";
    /// infinities are not.
    #[error("{what} {index} is {value}; it must be finite (a field may hold NaN for \"no value\")")]
    NonFinite {
        /// What holds the value ("value of vertex", "point of curve 3,").
        what: String,
        /// 0-based index.
        index: usize,
        /// The value given.
        value: f64,
    },
    /// A colour range that is empty or not finite.
    #[error("the colour range {min} to {max} is empty; give finite numbers, the smaller first")]
    Range {
        /// Lower end.
        min: f64,
        /// Upper end.
        max: f64,
    },
    /// No colour map has this name.
    #[error("there is no colour map \"{name}\"; choose one of {choices}")]
    UnknownColorMap {
        /// The name given.
        name: String,
        /// All names.
        choices: String,
    },
    /// A curve on the surface does not fit the mesh.
    #[error(transparent)]
    Curve(#[from] CurveError),
    /// The pixels do not make a picture, or encoding failed.
    #[error("the picture can not be encoded as PNG: {reason}")]
    Encoding {
        /// What the encoder says.
        reason: String,
    },
    /// The file can not be written.
    #[error("{path} can not be written: {source}; the file, if there was one, is unchanged")]
    Write {
        /// The file.
        path: String,
        /// What the system says.
        source: std::io::Error,
    },
}
