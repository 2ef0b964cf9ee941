//! Sparsity pattern of a system.

use crate::compressed_rows::CompressedRows;
use crate::error::NumericError;
use crate::observer::check_step;

/// Sparsity pattern of a symmetric system, as a list of off-diagonal contributions.
///
/// Contribution `k` adds the `k`-th off-diagonal value at row `pairs[k][0]`, column `pairs[k][1]`,
/// and its conjugate at the transposed position. Pairs may repeat; their values add up.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    /// Number of unknowns.
    pub unknowns: usize,
    /// Two different unknowns per contribution.
    pub pairs: Vec<[u32; 2]>,
}

impl Graph {
    pub(crate) fn check(&self) -> Result<(), NumericError> {
        for (contribution, &pair) in self.pairs.iter().enumerate() {
            check_step(contribution)?;
            let [a, b] = pair;
            if a == b || a.max(b) as usize >= self.unknowns {
                return Err(NumericError::NotAPair { contribution, pair, unknowns: self.unknowns });
            }
        }
        Ok(())
    }

    /// Returns the neighbours of each unknown, with multiplicity.
    pub(crate) fn adjacency(&self) -> Result<CompressedRows<u32>, NumericError> {
        CompressedRows::unless_stopped(self.unknowns, self.pairs.iter().flat_map(|&[a, b]| [(a, b), (b, a)]))
    }
}
