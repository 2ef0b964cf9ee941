//! Threads and memory of a factorisation.

use crate::error::NumericError;

/// Threads and memory that a factorisation may use.
///
/// ```
/// use eikona_numeric::{NumericError, Resources};
/// let small = Resources { memory_limit: Some(1000), ..Resources::default() };
/// assert!(small.check(1000).is_ok());
/// let refused = NumericError::MemoryLimit { needed_bytes: 1001, limit_bytes: 1000 };
/// assert_eq!(small.check(1001), Err(refused));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resources {
    /// Number of threads. Default: 1. The result is the same for any number.
    pub threads: usize,
    /// Memory limit in bytes. Default: no limit.
    pub memory_limit: Option<usize>,
}

impl Default for Resources {
    fn default() -> Self {
        Resources { threads: 1, memory_limit: None }
    }
}

impl Resources {
    /// Checks that this many bytes are within the limit.
    ///
    /// # Errors
    /// [`NumericError::MemoryLimit`].
    pub fn check(&self, needed_bytes: usize) -> Result<(), NumericError> {
        match self.memory_limit.filter(|&limit| needed_bytes > limit) {
            Some(limit_bytes) => Err(NumericError::MemoryLimit { needed_bytes, limit_bytes }),
            None => Ok(()),
        }
    }
}
