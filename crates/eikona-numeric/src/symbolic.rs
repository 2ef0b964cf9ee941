//! Symbolic analysis: everything that depends on the sparsity pattern only.

use crate::compressed_rows::CompressedRows;
use crate::error::NumericError;
use crate::graph::Graph;
use crate::matrix::SymmetricMatrix;
use crate::observer::{check_step, check_stopped};
use crate::ordering::Ordering;
use crate::scalar::Scalar;
use crate::supernodes::{Supernodes, elimination_tree, postorder, renumbered};

/// Flag of a slot whose contribution is stored transposed, as its conjugate.
const MIRRORED: u32 = 1 << 31;

/// Symbolic factorisation: the elimination order, the structure of the factor, and the target entry
/// of each contribution.
///
/// # Cost
/// Time and memory proportional to the entries of the matrix plus the rows of the supernodes, which
/// are far fewer than the entries of the factor.
#[derive(Debug)]
pub struct Symbolic {
    unknowns: usize,
    /// Unknown at each position of the elimination order, and the inverse permutation.
    order: Vec<u32>,
    position: Vec<u32>,
    /// Lower triangle of the permuted matrix by columns, each with its diagonal first.
    col_ptr: Vec<u32>,
    row_idx: Vec<u32>,
    /// Entry to which contribution k is added, with the `MIRRORED` flag.
    slots: Vec<u32>,
    supernodes: Supernodes,
}

impl Symbolic {
    /// Analyses the sparsity pattern of a system.
    ///
    /// # Errors
    /// [`NumericError::TooLarge`] for 2^30 or more unknowns and contributions;
    /// [`NumericError::OutOfMemory`] if minimum degree runs out of memory;
    /// [`NumericError::NotAPair`]; [`NumericError::WrongLength`] and
    /// [`NumericError::NotAnOrder`] if the order does not list every unknown once.
    pub fn new(graph: &Graph, ordering: Ordering<'_>) -> Result<Symbolic, NumericError> {
        let n = graph.unknowns;
        if n + graph.pairs.len() >= (MIRRORED as usize) / 2 {
            return Err(NumericError::TooLarge { unknowns: n });
        }
        graph.check()?;
        check_stopped()?;
        let given = ordering.order(graph)?;
        let given_position = inverse(&given);
        check_stopped()?;
        let rows = rows_left_of_diagonal(graph, &given_position)?;
        check_stopped()?;
        let tree = elimination_tree(&rows);
        check_stopped()?;
        let moved = postorder(&tree);
        check_stopped()?;
        let tree = renumbered(&tree, &moved);
        let position: Vec<u32> = given_position.iter().map(|&p| moved[p as usize]).collect();
        let order = inverse(&position);
        check_stopped()?;
        let (col_ptr, row_idx, slots) = permuted_lower_triangle(graph, &position)?;
        let supernodes = Supernodes::of(&tree, &col_ptr, &row_idx)?;
        Ok(Symbolic { unknowns: n, order, position, col_ptr, row_idx, slots, supernodes })
    }

    /// Returns the number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }
    /// Returns the number of stored entries of the factor.
    pub fn factor_entries(&self) -> usize {
        self.supernodes.entries()
    }
    /// Returns the bytes that a [`Cholesky`](crate::Cholesky) with this pattern occupies.
    pub fn factor_bytes<T: Scalar>(&self) -> usize {
        (self.supernodes.entries() + self.row_idx.len()) * size_of::<T>()
    }
    /// Predicts the peak bytes of a factorisation: the factor, the permuted matrix, and the update
    /// matrices, for which each thread has stacks of its own.
    pub fn predicted_bytes<T: Scalar>(&self, threads: usize) -> usize {
        let stacks: usize = self.supernodes.stack_entries().iter().sum();
        self.factor_bytes::<T>() + threads.max(1) * stacks * size_of::<T>()
    }

    /// Structure of the factor.
    pub(crate) fn supernodes(&self) -> &Supernodes {
        &self.supernodes
    }
    /// Unknown at each position of the elimination order.
    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }
    /// Position of each unknown in the elimination order.
    pub(crate) fn position(&self) -> &[u32] {
        &self.position
    }
    /// Column pointers and row indices of the permuted lower triangle.
    pub(crate) fn lower_triangle(&self) -> (&[u32], &[u32]) {
        (&self.col_ptr, &self.row_idx)
    }
    pub(crate) fn out_of_memory<T: Scalar>(&self, threads: usize) -> NumericError {
        NumericError::OutOfMemory {
            what: "the factor",
            unknowns: self.unknowns,
            needed_bytes: self.predicted_bytes::<T>(threads),
        }
    }
    /// Error for the pivot at a position of the elimination order.
    pub(crate) fn not_positive(&self, position: usize) -> NumericError {
        NumericError::NonPositivePivot { unknown: self.order[position] as usize }
    }

    /// Assembles the values of the permuted lower triangle.
    pub(crate) fn permute<T: Scalar>(&self, matrix: &SymmetricMatrix<T>) -> Result<Vec<T>, NumericError> {
        for (found, expected) in
            [(matrix.diagonal.len(), self.unknowns), (matrix.off_diagonal.len(), self.slots.len())]
        {
            if found != expected {
                return Err(NumericError::WrongLength { found, expected });
            }
        }
        let mut entries = vec![T::ZERO; self.row_idx.len()];
        for (i, &value) in matrix.diagonal.iter().enumerate() {
            check_step(i)?;
            entries[self.col_ptr[self.position[i] as usize] as usize] = T::real(value);
        }
        for (k, (&slot, &value)) in self.slots.iter().zip(&matrix.off_diagonal).enumerate() {
            check_step(k)?;
            let value = if slot & MIRRORED != 0 { value.conj() } else { value };
            entries[(slot & !MIRRORED) as usize] += value;
        }
        match entries.iter().position(|x| !x.finite()) {
            None => Ok(entries),
            Some(entry) => {
                let column = self.col_ptr.partition_point(|&p| p as usize <= entry) - 1;
                let unknown = self.order[column] as usize;
                Err(NumericError::NonFinite { what: "a matrix entry", unknown })
            }
        }
    }
}

fn inverse(permutation: &[u32]) -> Vec<u32> {
    let mut inverse = vec![0; permutation.len()];
    for (i, &p) in permutation.iter().enumerate() {
        inverse[p as usize] = i as u32;
    }
    inverse
}

/// Row and column of a pair in the permuted lower triangle.
fn below_diagonal(pair: [u32; 2], position: &[u32]) -> (u32, u32) {
    let (a, b) = (position[pair[0] as usize], position[pair[1] as usize]);
    (a.max(b), a.min(b))
}

/// Column indices left of the diagonal by rows, unsorted.
fn rows_left_of_diagonal(graph: &Graph, position: &[u32]) -> Result<CompressedRows<u32>, NumericError> {
    CompressedRows::unless_stopped(
        graph.unknowns,
        graph.pairs.iter().map(|&pair| below_diagonal(pair, position)),
    )
}

/// Lower triangle by columns with sorted rows, duplicates merged and the diagonal first; and the
/// slot of each pair.
fn permuted_lower_triangle(
    graph: &Graph,
    position: &[u32],
) -> Result<(Vec<u32>, Vec<u32>, Vec<u32>), NumericError> {
    let n = graph.unknowns;
    let pairs = &graph.pairs;
    let entries = pairs.iter().enumerate().map(|(k, &pair)| {
        let (row, column) = below_diagonal(pair, position);
        (row, (column, (row, k as u32)))
    });
    // Sorted by row first, then stably by column.
    let by_row = CompressedRows::unless_stopped(n, entries)?;
    check_stopped()?;
    let by_column = CompressedRows::unless_stopped(n, by_row.items().iter().copied())?;
    drop(by_row);
    check_stopped()?;
    let mut slots = vec![0; pairs.len()];
    let mut col_ptr = Vec::with_capacity(n + 1);
    let mut row_idx = Vec::with_capacity(n + pairs.len());
    col_ptr.push(0);
    for column in 0..n as u32 {
        check_step(column as usize)?;
        row_idx.push(column);
        for &(row, k) in by_column.row(column as usize) {
            if row_idx.last() != Some(&row) {
                row_idx.push(row);
            }
            let mirrored = if position[pairs[k as usize][0] as usize] == row { 0 } else { MIRRORED };
            slots[k as usize] = (row_idx.len() as u32 - 1) | mirrored;
        }
        col_ptr.push(row_idx.len() as u32);
    }
    check_stopped()?;
    Ok((col_ptr, row_idx, slots))
}
