//! Why a system could not be analysed, factored or solved.

use thiserror::Error;

/// Why a system could not be analysed, factored or solved.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NumericError {
    /// A pivot is zero or negative: the matrix is not positive definite.
    #[error("the pivot of unknown {unknown} is not positive: the matrix is not positive definite there")]
    NonPositivePivot {
        /// The unknown, in the caller's numbering.
        unknown: usize,
    },
    /// An entry of the matrix or of a right-hand side is NaN or infinite.
    #[error("{what} of unknown {unknown} is not finite")]
    NonFinite {
        /// "a matrix entry" or "the right-hand side".
        what: &'static str,
        /// The unknown, in the caller's numbering.
        unknown: usize,
    },
    /// An array does not have one value an unknown.
    #[error("{found} values were given, {expected} are needed")]
    WrongLength {
        /// The number given.
        found: usize,
        /// The number needed.
        expected: usize,
    },
    /// An order of elimination that names an unknown twice, or one that does not exist.
    #[error("the order of elimination names unknown {unknown} twice, or it does not exist")]
    NotAnOrder {
        /// The unknown.
        unknown: usize,
    },
    /// A contribution that does not join two unknowns of the system.
    #[error("contribution {contribution} joins unknowns {} and {}; two different ones below {unknowns} are needed", pair[0], pair[1])]
    NotAPair {
        /// Its index in [`Graph::pairs`](crate::Graph::pairs).
        contribution: usize,
        /// What it joins.
        pair: [u32; 2],
        /// Number of unknowns.
        unknowns: usize,
    },
    /// The factor would not fit.
    #[error(
        "the factor of {unknowns} unknowns needs {needed_bytes} bytes, which can not be allocated; use a smaller mesh"
    )]
    OutOfMemory {
        /// Number of unknowns.
        unknowns: usize,
        /// Predicted bytes.
        needed_bytes: usize,
    },
    /// More entries than 32-bit indices can name.
    #[error("a system of {unknowns} unknowns exceeds 32-bit indices; split the mesh")]
    TooLarge {
        /// Number of unknowns.
        unknowns: usize,
    },
}
