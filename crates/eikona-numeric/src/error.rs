//! Errors of analysis, factorisation and solve.

use thiserror::Error;

/// Error of analysis, factorisation or solve. Unknowns are in the caller's numbering.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NumericError {
    /// A pivot is zero, negative or NaN: the matrix is not positive definite.
    #[error("the matrix is not positive definite: the pivot of unknown {unknown} is not positive")]
    NonPositivePivot {
        /// The unknown whose pivot failed.
        unknown: usize,
    },
    /// An entry of the matrix, a right-hand side or the solution is NaN or infinite.
    #[error("{what} at unknown {unknown} is not finite")]
    NonFinite {
        /// "a matrix entry", "the right-hand side" or "the solution".
        what: &'static str,
        /// The unknown; for a matrix entry, that of its column in the permuted lower triangle.
        unknown: usize,
    },
    /// An array has the wrong length.
    #[error("an array has {found} values, but {expected} are needed")]
    WrongLength {
        /// Length of the array.
        found: usize,
        /// Required length.
        expected: usize,
    },
    /// An elimination order lists an unknown twice, or one that does not exist.
    #[error("the elimination order lists unknown {unknown} twice, or there is no such unknown")]
    NotAnOrder {
        /// The unknown.
        unknown: usize,
    },
    /// A contribution does not couple two different unknowns of the system.
    #[error("contribution {contribution} couples unknowns {} and {}; they must be different and less than {unknowns}", pair[0], pair[1])]
    NotAPair {
        /// Its index in [`Graph::pairs`](crate::Graph::pairs).
        contribution: usize,
        /// The pair of unknowns.
        pair: [u32; 2],
        /// Number of unknowns.
        unknowns: usize,
    },
    /// There is not enough memory to order or to factor the matrix.
    #[error(
        "{what} of {unknowns} unknowns needs {needed_bytes} bytes, which cannot be allocated; use a smaller mesh"
    )]
    OutOfMemory {
        /// "the factor" or "the elimination order".
        what: &'static str,
        /// Number of unknowns.
        unknowns: usize,
        /// Predicted bytes.
        needed_bytes: usize,
    },
    /// The pattern has 2^30 or more unknowns and contributions, or indices overflow while it is
    /// ordered.
    #[error("a system of {unknowns} unknowns is too large to analyse; split the mesh")]
    TooLarge {
        /// Number of unknowns.
        unknowns: usize,
    },
    /// The factors would exceed the memory limit.
    #[error(
        "the factorisation needs about {needed_bytes} bytes, more than the memory limit of {limit_bytes}; raise the limit or use a coarser mesh"
    )]
    MemoryLimit {
        /// Predicted bytes.
        needed_bytes: usize,
        /// The given limit.
        limit_bytes: usize,
    },
    /// The observer stopped the computation.
    #[error("the computation was stopped")]
    Stopped,
}
