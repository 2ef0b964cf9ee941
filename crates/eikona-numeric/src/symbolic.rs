//! What depends on the pattern of a system only.

use crate::cholesky::SymmetricMatrix;
use crate::error::NumericError;
use crate::graph::Graph;
use crate::ordering::Ordering;
use crate::scalar::Scalar;
use crate::supernodes::{Supernodes, elimination_tree, postorder, renumbered};

/// Set in a slot when the contribution lands on the mirrored place, as its conjugate.
const MIRRORED: u32 = 1 << 31;

/// What depends on the pattern only: the order of elimination, the shape of the factor, and where
/// each contribution goes.
///
/// # Cost
/// Time proportional to the entries of the matrix and the rows of the supernodes, which are far
/// fewer than the entries of the factor; memory likewise.
#[derive(Debug)]
pub struct Symbolic {
    unknowns: usize,
    /// Unknown at each place of the elimination order, and the inverse.
    order: Vec<u32>,
    place: Vec<u32>,
    /// Lower triangle of the permuted matrix, by columns, the diagonal first in each.
    col_ptr: Vec<u32>,
    row_idx: Vec<u32>,
    /// Entry to which contribution k is added, with the flag above.
    slots: Vec<u32>,
    supernodes: Supernodes,
}

impl Symbolic {
    /// Analyses the pattern of a system.
    ///
    /// # Errors
    /// [`NumericError::TooLarge`] past 2^30 entries, [`NumericError::NotAPair`],
    /// [`NumericError::WrongLength`] and [`NumericError::NotAnOrder`] for an order that does not
    /// name every unknown once.
    pub fn new(graph: &Graph, ordering: Ordering<'_>) -> Result<Symbolic, NumericError> {
        let n = graph.unknowns;
        if n + graph.pairs.len() >= (MIRRORED as usize) / 2 {
            return Err(NumericError::TooLarge { unknowns: n });
        }
        graph.check()?;
        let given = ordering.order(graph)?;
        let given_place = inverse(&given);
        let (row_start, columns) = rows_left_of_diagonal(graph, &given_place);
        let tree = elimination_tree(&row_start, &columns);
        drop((row_start, columns));
        let moved = postorder(&tree);
        let tree = renumbered(&tree, &moved);
        let place: Vec<u32> = given_place.iter().map(|&p| moved[p as usize]).collect();
        let order = inverse(&place);
        let (col_ptr, row_idx, slots) = permuted_lower_triangle(graph, &place);
        let supernodes = Supernodes::of(&tree, &col_ptr, &row_idx);
        Ok(Symbolic { unknowns: n, order, place, col_ptr, row_idx, slots, supernodes })
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }
    /// Stored entries of the factor.
    pub fn factor_entries(&self) -> usize {
        self.supernodes.entries()
    }
    /// Bytes that a [`Cholesky`](crate::Cholesky) of this pattern keeps.
    pub fn factor_bytes<T: Scalar>(&self) -> usize {
        (self.supernodes.entries() + self.row_idx.len()) * size_of::<T>()
    }
    /// Bytes that the factor, the permuted matrix and the fronts in work will take, known before
    /// factoring.
    pub fn predicted_bytes<T: Scalar>(&self) -> usize {
        self.factor_bytes::<T>() + self.supernodes.stack_entries().iter().sum::<usize>() * size_of::<T>()
    }

    /// The shape of the factor.
    pub(crate) fn supernodes(&self) -> &Supernodes {
        &self.supernodes
    }
    /// Unknown at each place of the elimination order.
    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }
    /// Place of each unknown in the elimination order.
    pub(crate) fn place(&self) -> &[u32] {
        &self.place
    }
    /// Columns and rows of the permuted lower triangle.
    pub(crate) fn lower_triangle(&self) -> (&[u32], &[u32]) {
        (&self.col_ptr, &self.row_idx)
    }
    pub(crate) fn out_of_memory<T: Scalar>(&self) -> NumericError {
        NumericError::OutOfMemory { unknowns: self.unknowns, needed_bytes: self.predicted_bytes::<T>() }
    }
    /// The error for a pivot at this place of the elimination order.
    pub(crate) fn not_positive(&self, place: usize) -> NumericError {
        NumericError::NonPositivePivot { unknown: self.order[place] as usize }
    }

    /// The numbers of the permuted lower triangle.
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
            entries[self.col_ptr[self.place[i] as usize] as usize] = T::real(value);
        }
        for (&slot, &value) in self.slots.iter().zip(&matrix.off_diagonal) {
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

/// Row and column of a pair in the lower triangle.
fn below_diagonal(pair: [u32; 2], place: &[u32]) -> (u32, u32) {
    let (a, b) = (place[pair[0] as usize], place[pair[1] as usize]);
    (a.max(b), a.min(b))
}

/// For each row the columns left of the diagonal, in any order.
fn rows_left_of_diagonal(graph: &Graph, place: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let entries = graph.pairs.iter().map(|&pair| below_diagonal(pair, place));
    let (start, sorted) = bucket_sorted(graph.unknowns, entries, |(row, _)| row);
    (start, sorted.into_iter().map(|(_, column)| column).collect())
}

/// The lower triangle by columns with sorted rows, equal entries merged, the diagonal first; and
/// the slot of each pair.
fn permuted_lower_triangle(graph: &Graph, place: &[u32]) -> (Vec<u32>, Vec<u32>, Vec<u32>) {
    let n = graph.unknowns;
    let pairs = &graph.pairs;
    let entries = pairs.iter().enumerate().map(|(k, &pair)| (below_diagonal(pair, place), k as u32));
    // Sorted by row first, then stably by column.
    let (_, by_row) = bucket_sorted(n, entries, |((row, _), _)| row);
    let (start, sorted) = bucket_sorted(n, by_row.into_iter(), |((_, column), _)| column);
    let mut slots = vec![0; pairs.len()];
    let mut col_ptr = Vec::with_capacity(n + 1);
    let mut row_idx = Vec::with_capacity(n + pairs.len());
    col_ptr.push(0);
    for column in 0..n as u32 {
        row_idx.push(column);
        for &((row, _), k) in &sorted[start[column as usize] as usize..start[column as usize + 1] as usize] {
            if row_idx.last() != Some(&row) {
                row_idx.push(row);
            }
            let mirrored = if place[pairs[k as usize][0] as usize] == row { 0 } else { MIRRORED };
            slots[k as usize] = (row_idx.len() as u32 - 1) | mirrored;
        }
        col_ptr.push(row_idx.len() as u32);
    }
    (col_ptr, row_idx, slots)
}

/// Items sorted stably by a key below `buckets`, and where each key starts.
fn bucket_sorted<I: Copy + Default>(
    buckets: usize,
    items: impl ExactSizeIterator<Item = I> + Clone,
    key: impl Fn(I) -> u32,
) -> (Vec<u32>, Vec<I>) {
    let mut start = vec![0u32; buckets + 1];
    for item in items.clone() {
        start[key(item) as usize + 1] += 1;
    }
    for i in 0..buckets {
        start[i + 1] += start[i];
    }
    let mut next = start.clone();
    let mut sorted = vec![I::default(); items.len()];
    for item in items {
        let slot = &mut next[key(item) as usize];
        sorted[*slot as usize] = item;
        *slot += 1;
    }
    (start, sorted)
}
