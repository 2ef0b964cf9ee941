//! Sparsity pattern of a system.

use crate::error::NumericError;

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
        let is_pair = |&[a, b]: &[u32; 2]| a != b && (a.max(b) as usize) < self.unknowns;
        match self.pairs.iter().position(|pair| !is_pair(pair)) {
            Some(contribution) => {
                let pair = self.pairs[contribution];
                Err(NumericError::NotAPair { contribution, pair, unknowns: self.unknowns })
            }
            None => Ok(()),
        }
    }
}

/// Neighbours of each unknown, with multiplicity.
pub(crate) struct Adjacency {
    start: Vec<u32>,
    neighbours: Vec<u32>,
}

impl Adjacency {
    pub(crate) fn of(unknowns: usize, pairs: &[[u32; 2]]) -> Adjacency {
        let mut start = vec![0u32; unknowns + 1];
        for [a, b] in pairs {
            start[*a as usize + 1] += 1;
            start[*b as usize + 1] += 1;
        }
        for i in 0..unknowns {
            start[i + 1] += start[i];
        }
        let mut next = start.clone();
        let mut neighbours = vec![0u32; 2 * pairs.len()];
        for &[a, b] in pairs {
            neighbours[next[a as usize] as usize] = b;
            next[a as usize] += 1;
            neighbours[next[b as usize] as usize] = a;
            next[b as usize] += 1;
        }
        Adjacency { start, neighbours }
    }
    #[inline]
    pub(crate) fn of_unknown(&self, i: u32) -> &[u32] {
        &self.neighbours[self.start[i as usize] as usize..self.start[i as usize + 1] as usize]
    }
    pub(crate) fn starts(&self) -> &[u32] {
        &self.start
    }
    pub(crate) fn neighbours(&self) -> &[u32] {
        &self.neighbours
    }
}
