//! Matrix entries on a sparsity pattern.

/// Values of a symmetric or Hermitian matrix, in the order of its [`Graph`](crate::Graph).
#[derive(Clone, Debug, Default)]
pub struct SymmetricMatrix<T> {
    /// Diagonal entries, which are real for Hermitian matrices too.
    pub diagonal: Vec<f64>,
    /// One value per pair of the graph: entry (first, second). The transposed entry is its
    /// conjugate.
    pub off_diagonal: Vec<T>,
}
