//! Supernodal Cholesky factorisation: analysed once a pattern, factored once a matrix, solved once a right-hand side.

use crate::error::NumericError;
use crate::graph::{Adjacency, Graph};
use crate::kernels::{self, Vectorized, dispatch};
use crate::memory::Zeroed;
use crate::multifrontal;
use crate::ordering::Ordering;
use crate::scalar::Scalar;
use crate::tree::Tree;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::cholesky::{simplicial, supernodal};
use std::ops::Range;
use std::sync::Arc;

/// Set in a slot when the contribution lands on the mirrored place, as its conjugate.
const MIRRORED: u32 = 1 << 31;

/// What depends on the pattern only: the order of elimination, the shape of the factor, and where each contribution goes.
///
/// # Cost
/// O(entries of the factor) time, O(entries of the matrix) memory.
#[derive(Debug)]
pub struct Symbolic {
    unknowns: usize,
    /// Unknown at each place of the elimination order, and the inverse.
    order: Vec<u32>,
    place: Vec<u32>,
    /// Lower triangle of the permuted matrix, by columns, the diagonal first in each.
    col_ptr: Vec<u32>,
    row_idx: Vec<u32>,
    /// Entry to which contribution k is added, with the flags above.
    slots: Vec<u32>,
    factor: supernodal::SymbolicSupernodalCholesky<u32>,
    tree: Tree,
    /// Rows of the highest panel.
    largest_height: usize,
}

impl Symbolic {
    /// Analyses the pattern of a system.
    ///
    /// # Errors
    /// [`NumericError::TooLarge`] past 2^31 entries, [`NumericError::WrongLength`] for a wrong number of places.
    pub fn new(graph: &Graph, ordering: Ordering<'_>) -> Result<Symbolic, NumericError> {
        let n = graph.unknowns;
        let too_large = NumericError::TooLarge { unknowns: n };
        if n >= MIRRORED as usize || graph.pairs.len() >= (MIRRORED as usize) / 2 - n {
            return Err(too_large);
        }
        let adjacency = Adjacency::of(n, &graph.pairs);
        let order = ordering.order(graph, &adjacency)?;
        let order = postordered(order, &adjacency);
        drop(adjacency);
        let mut place = vec![0u32; n];
        for (p, &unknown) in order.iter().enumerate() {
            place[unknown as usize] = p as u32;
        }
        let (col_ptr, row_idx, slots) = permuted_lower_triangle(graph, &place);
        let (upper_ptr, upper_idx) = transposed(n, &col_ptr, &row_idx);
        let upper = SymbolicSparseColMatRef::new_unsorted_checked(n, n, &upper_ptr, None, &upper_idx);

        let mut parents = vec![0i32; n];
        let mut counts = vec![0u32; n];
        let scratch = simplicial::prefactorize_symbolic_cholesky_scratch::<u32>(n, upper_idx.len())
            .or(supernodal::factorize_supernodal_symbolic_cholesky_scratch::<u32>(n));
        let mut memory = MemBuffer::try_new(scratch).map_err(|_| too_large.clone())?;
        let stack = MemStack::new(&mut memory);
        let columns = simplicial::prefactorize_symbolic_cholesky(&mut parents, &mut counts, upper, stack);
        let factor = supernodal::factorize_supernodal_symbolic_cholesky(
            upper,
            columns,
            &counts,
            stack,
            Default::default(),
        )
        .map_err(|_| too_large)?;
        let tree = Tree::of(&factor);
        let heights = (0..factor.n_supernodes())
            .map(|s| factor.supernode_end()[s] - factor.supernode_begin()[s] + factor.nnz_per_super()[s]);
        let largest_height = heights.max().unwrap_or(0) as usize;
        Ok(Symbolic { unknowns: n, order, place, col_ptr, row_idx, slots, factor, tree, largest_height })
    }

    /// Number of unknowns.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }
    /// Stored entries of the factor.
    pub fn factor_entries(&self) -> usize {
        self.factor.len_val()
    }
    /// Bytes that a [`Cholesky`] of this pattern keeps.
    pub fn factor_bytes<T: Scalar>(&self) -> usize {
        (self.factor.len_val() + self.row_idx.len()) * size_of::<T>()
    }
    /// Bytes that the factor, the permuted matrix and the fronts in work will take, known before factoring.
    pub fn predicted_bytes<T: Scalar>(&self) -> usize {
        self.factor_bytes::<T>() + self.tree.stack_entries().iter().sum::<usize>() * size_of::<T>()
    }
}

/// The numbers of a system, in the order of its [`Graph`].
#[derive(Clone, Debug, Default)]
pub struct SymmetricMatrix<T> {
    /// The diagonal, which is real also for Hermitian matrices.
    pub diagonal: Vec<f64>,
    /// One value for each pair of the graph: entry (first, second); the mirrored entry is its conjugate.
    pub off_diagonal: Vec<T>,
}

/// A factored system `A x = b` with `A` symmetric (or Hermitian) positive definite.
///
/// ```
/// use eikona_numeric::{Cholesky, Graph, Ordering, Symbolic, SymmetricMatrix};
/// let graph = Graph { unknowns: 2, pairs: vec![[0, 1]] };
/// let symbolic = Symbolic::new(&graph, Ordering::MinimumDegree)?;
/// let matrix = SymmetricMatrix { diagonal: vec![2.0, 3.0], off_diagonal: vec![1.0] };
/// let factor = Cholesky::new(symbolic.into(), &matrix)?;
/// let x = factor.solve(&[3.0, 4.0])?;
/// assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 1.0).abs() < 1e-15);
/// # Ok::<(), eikona_numeric::NumericError>(())
/// ```
#[derive(Debug)]
pub struct Cholesky<T> {
    symbolic: Arc<Symbolic>,
    /// The permuted lower triangle of A, for residuals.
    matrix: Vec<T>,
    values: Zeroed<T>,
}

impl<T: Scalar> Cholesky<T> {
    /// Factors the matrix.
    ///
    /// # Errors
    /// [`NumericError::NonPositivePivot`] with the unknown where the matrix is not positive definite,
    /// [`NumericError::NonFinite`], [`NumericError::OutOfMemory`] with the predicted bytes, [`NumericError::WrongLength`].
    pub fn new(symbolic: Arc<Symbolic>, matrix: &SymmetricMatrix<T>) -> Result<Self, NumericError> {
        let n = symbolic.unknowns;
        for (found, expected) in
            [(matrix.diagonal.len(), n), (matrix.off_diagonal.len(), symbolic.slots.len())]
        {
            if found != expected {
                return Err(NumericError::WrongLength { found, expected });
            }
        }
        let entries = symbolic.permute(matrix)?;
        let mut values = Zeroed::new(symbolic.factor.len_val()).ok_or(symbolic.out_of_memory::<T>())?;
        multifrontal::factor(&symbolic, &entries, &mut values)?;
        Ok(Cholesky { symbolic, matrix: entries, values })
    }

    /// The analysis that the factor was made with.
    pub fn symbolic(&self) -> &Arc<Symbolic> {
        &self.symbolic
    }

    /// The solution of `A x = b`. Unknowns whose right-hand side influences nothing are skipped: few non-zeros cost less.
    ///
    /// Values smaller than 1e-290 are set to zero on the way, since arithmetic on denormal numbers is slow and has no
    /// relative accuracy.
    ///
    /// # Errors
    /// [`NumericError::WrongLength`]; [`NumericError::NonFinite`] when the right-hand side or the solution is not finite.
    ///
    /// # Cost
    /// Two sweeps over the factor.
    pub fn solve(&self, rhs: &[T]) -> Result<Vec<T>, NumericError> {
        self.sweep(&[rhs], None).map(|mut solutions| solutions.remove(0))
    }

    /// The solutions for several right-hand sides, the same as one by one. The factor is read from memory once for all, which
    /// takes most of the time of a single solve.
    ///
    /// # Errors
    /// As for [`solve`](Self::solve).
    pub fn solve_many(&self, rhs: &[impl AsRef<[T]>]) -> Result<Vec<Vec<T>>, NumericError> {
        let rhs: Vec<&[T]> = rhs.iter().map(AsRef::as_ref).collect();
        self.sweep(&rhs, None)
    }

    /// Those unknowns of the solution of `A x = b` that are wanted; the others are zero or what they are in the solution.
    ///
    /// # Errors
    /// As for [`solve`](Self::solve).
    ///
    /// # Cost
    /// The parts of the factor that lie between the right-hand side's non-zeros and the root of the elimination tree, and
    /// between the root and the wanted unknowns; and a look at each unknown.
    pub fn solve_where(&self, rhs: &[T], wanted: impl Fn(usize) -> bool) -> Result<Vec<T>, NumericError> {
        let factor = &self.symbolic.factor;
        let mut needed: Vec<bool> = (0..factor.n_supernodes())
            .map(|s| {
                let columns = factor.supernode_begin()[s] as usize..factor.supernode_end()[s] as usize;
                self.symbolic.order[columns].iter().any(|&unknown| wanted(unknown as usize))
            })
            .collect();
        self.symbolic.tree.mark_ancestors(&mut needed);
        self.sweep(&[rhs], Some(&needed)).map(|mut solutions| solutions.remove(0))
    }

    /// Both sweeps for each right-hand side; the second over the needed supernodes only.
    fn sweep(&self, rhs: &[&[T]], needed: Option<&[bool]>) -> Result<Vec<Vec<T>>, NumericError> {
        let s = &*self.symbolic;
        let mut columns = Vec::with_capacity(rhs.len());
        for rhs in rhs {
            if rhs.len() != s.unknowns {
                return Err(NumericError::WrongLength { found: rhs.len(), expected: s.unknowns });
            }
            if let Some(unknown) = rhs.iter().position(|x| !x.finite()) {
                return Err(NumericError::NonFinite { what: "the right-hand side", unknown });
            }
            columns.push(s.order.iter().map(|&i| rhs[i as usize]).collect());
        }
        dispatch(Sweeps { factor: self, columns: &mut columns, needed });
        for x in &mut columns {
            *x = s.place.iter().map(|&p| x[p as usize]).collect();
            if let Some(unknown) = x.iter().position(|x| !x.finite()) {
                return Err(NumericError::NonFinite { what: "the solution", unknown });
            }
        }
        Ok(columns)
    }

    /// The largest entry of `A x - b`, relative to the largest entry of `b` (absolute if `b` is zero).
    pub fn residual(&self, x: &[T], rhs: &[T]) -> f64 {
        let s = &*self.symbolic;
        // In the order of elimination neighbours lie near each other in memory.
        let x: Vec<T> = s.order.iter().map(|&i| x[i as usize]).collect();
        let mut miss: Vec<T> = s.order.iter().map(|&i| rhs[i as usize]).collect();
        let scale = miss.iter().fold(0.0f64, |m, b| m.max(b.max_part()));
        for j in 0..s.unknowns {
            let (begin, end) = (s.col_ptr[j] as usize, s.col_ptr[j + 1] as usize);
            let mut sum = self.matrix[begin] * x[j];
            for (&i, &value) in s.row_idx[begin + 1..end].iter().zip(&self.matrix[begin + 1..end]) {
                miss[i as usize] -= value * x[j];
                sum += value.conj() * x[i as usize];
            }
            miss[j] -= sum;
        }
        let error = miss.iter().fold(0.0f64, |m, e| m.max(e.max_part()));
        if scale > 0.0 { error / scale } else { error }
    }

    /// The columns, rows and panel of a supernode.
    #[inline(always)]
    fn supernode(&self, s: usize) -> (Range<usize>, &[u32], &[T]) {
        let factor = &self.symbolic.factor;
        let columns = factor.supernode_begin()[s] as usize..factor.supernode_end()[s] as usize;
        let first_row = factor.col_ptr_for_row_idx()[s] as usize;
        let rows = &factor.row_idx()[first_row..first_row + factor.nnz_per_super()[s] as usize];
        let values = factor.col_ptr_for_val();
        (columns, rows, &self.values[values[s] as usize..values[s + 1] as usize])
    }

    /// `x <- L^-1 x`
    #[inline(always)]
    fn forward<S: pulp::Simd>(&self, simd: S, xs: &mut [Vec<T>], gathered: &mut [T]) {
        for s in 0..self.symbolic.factor.n_supernodes() {
            let (columns, rows, panel) = self.supernode(s);
            let width = columns.len();
            let gathered = &mut gathered[..width + rows.len()];
            for x in &mut *xs {
                let top = &mut x[columns.clone()];
                top.iter_mut().for_each(flush);
                if top.iter().all(|v| *v == T::ZERO) {
                    continue;
                }
                gathered[..width].copy_from_slice(top);
                gathered[width..].fill(T::ZERO);
                kernels::forward(simd, panel, width, gathered);
                top.copy_from_slice(&gathered[..width]);
                for (&row, &change) in rows.iter().zip(&gathered[width..]) {
                    x[row as usize] += change;
                }
            }
        }
    }

    /// `x <- L^-H x`; unknowns of supernodes that are not needed become zero.
    #[inline(always)]
    fn backward<S: pulp::Simd>(
        &self,
        simd: S,
        xs: &mut [Vec<T>],
        gathered: &mut [T],
        needed: Option<&[bool]>,
    ) {
        for s in (0..self.symbolic.factor.n_supernodes()).rev() {
            let (columns, rows, panel) = self.supernode(s);
            let width = columns.len();
            let gathered = &mut gathered[..width + rows.len()];
            for x in &mut *xs {
                if needed.is_some_and(|needed| !needed[s]) {
                    x[columns.clone()].fill(T::ZERO);
                    continue;
                }
                gathered[..width].copy_from_slice(&x[columns.clone()]);
                for (value, &row) in gathered[width..].iter_mut().zip(rows) {
                    *value = x[row as usize];
                }
                kernels::backward(simd, panel, width, gathered);
                gathered[..width].iter_mut().for_each(flush);
                x[columns.clone()].copy_from_slice(&gathered[..width]);
            }
        }
    }
}

/// Both sweeps of a solve.
struct Sweeps<'a, T> {
    factor: &'a Cholesky<T>,
    columns: &'a mut [Vec<T>],
    needed: Option<&'a [bool]>,
}

impl<T: Scalar> Vectorized for Sweeps<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run<S: pulp::Simd>(self, simd: S) {
        let mut gathered = vec![T::ZERO; self.factor.symbolic.largest_height];
        self.factor.forward(simd, self.columns, &mut gathered);
        self.factor.backward(simd, self.columns, &mut gathered, self.needed);
    }
}

/// Smaller values are treated as zero in solves.
const SMALLEST: f64 = 1e-290;

#[inline(always)]
fn flush<T: Scalar>(x: &mut T) {
    if x.max_part() < SMALLEST {
        *x = T::ZERO;
    }
}

impl Symbolic {
    /// The shape of the factor.
    pub(crate) fn factor(&self) -> &supernodal::SymbolicSupernodalCholesky<u32> {
        &self.factor
    }
    pub(crate) fn tree(&self) -> &Tree {
        &self.tree
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
    fn permute<T: Scalar>(&self, matrix: &SymmetricMatrix<T>) -> Result<Vec<T>, NumericError> {
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

/// Rearranges an order of elimination so that every subtree of the elimination tree is contiguous. The factor has the same
/// number of entries, and chains of columns become supernodes.
fn postordered(order: Vec<u32>, adjacency: &Adjacency) -> Vec<u32> {
    const NONE: u32 = u32::MAX;
    let n = order.len();
    let mut place = vec![0u32; n];
    for (p, &unknown) in order.iter().enumerate() {
        place[unknown as usize] = p as u32;
    }
    // Liu's algorithm with path compression.
    let mut parent = vec![NONE; n];
    let mut ancestor = vec![NONE; n];
    for j in 0..n as u32 {
        for &neighbour in adjacency.of_unknown(order[j as usize]) {
            let mut i = place[neighbour as usize];
            while i < j {
                let next = ancestor[i as usize];
                ancestor[i as usize] = j;
                if next == NONE {
                    parent[i as usize] = j;
                    break;
                }
                if next == j {
                    break;
                }
                i = next;
            }
        }
    }
    let mut first_child = vec![NONE; n];
    let mut next_sibling = vec![NONE; n];
    let mut roots = Vec::new();
    for j in (0..n as u32).rev() {
        match parent[j as usize] {
            NONE => roots.push(j),
            p => {
                next_sibling[j as usize] = first_child[p as usize];
                first_child[p as usize] = j;
            }
        }
    }
    let mut result = Vec::with_capacity(n);
    let mut stack = Vec::new();
    while let Some(root) = roots.pop() {
        stack.push(root);
        while let Some(&j) = stack.last() {
            let child = first_child[j as usize];
            if child == NONE {
                result.push(order[j as usize]);
                stack.pop();
            } else {
                first_child[j as usize] = next_sibling[child as usize];
                stack.push(child);
            }
        }
    }
    result
}

/// The lower triangle by columns with sorted rows, equal entries merged, the diagonal first; and the slot of each pair.
fn permuted_lower_triangle(graph: &Graph, place: &[u32]) -> (Vec<u32>, Vec<u32>, Vec<u32>) {
    let n = graph.unknowns;
    let row_and_column = |pair: &[u32; 2]| {
        let (a, b) = (place[pair[0] as usize], place[pair[1] as usize]);
        (a.max(b), a.min(b))
    };
    // Sorted by row first, then stably by column.
    let pairs = &graph.pairs;
    let (_, by_row) = bucket_sorted(n, 0..pairs.len() as u32, |k| row_and_column(&pairs[k as usize]).0);
    let (start, sorted) = bucket_sorted(n, by_row.iter().copied(), |k| row_and_column(&pairs[k as usize]).1);
    let mut slots = vec![0; pairs.len()];
    let mut col_ptr = Vec::with_capacity(n + 1);
    let mut row_idx = Vec::with_capacity(n + pairs.len());
    col_ptr.push(0);
    for column in 0..n as u32 {
        row_idx.push(column);
        for &k in &sorted[start[column as usize] as usize..start[column as usize + 1] as usize] {
            let pair = &pairs[k as usize];
            let row = row_and_column(pair).0;
            if row_idx.last() != Some(&row) {
                row_idx.push(row);
            }
            let mirrored = if place[pair[0] as usize] == row { 0 } else { MIRRORED };
            slots[k as usize] = (row_idx.len() as u32 - 1) | mirrored;
        }
        col_ptr.push(row_idx.len() as u32);
    }
    (col_ptr, row_idx, slots)
}

/// Items sorted stably by a key below `buckets`, and where each key starts.
fn bucket_sorted(
    buckets: usize,
    items: impl ExactSizeIterator<Item = u32> + Clone,
    key: impl Fn(u32) -> u32,
) -> (Vec<u32>, Vec<u32>) {
    let mut start = vec![0u32; buckets + 1];
    for k in items.clone() {
        start[key(k) as usize + 1] += 1;
    }
    for i in 0..buckets {
        start[i + 1] += start[i];
    }
    let mut next = start.clone();
    let mut sorted = vec![0u32; items.len()];
    for k in items {
        let slot = &mut next[key(k) as usize];
        sorted[*slot as usize] = k;
        *slot += 1;
    }
    (start, sorted)
}

/// The pattern of the transpose, by columns.
fn transposed(n: usize, col_ptr: &[u32], row_idx: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut start = vec![0u32; n + 1];
    for &row in row_idx {
        start[row as usize + 1] += 1;
    }
    for i in 0..n {
        start[i + 1] += start[i];
    }
    let mut next = start.clone();
    let mut columns = vec![0u32; row_idx.len()];
    for column in 0..n {
        for &row in &row_idx[col_ptr[column] as usize..col_ptr[column + 1] as usize] {
            columns[next[row as usize] as usize] = column as u32;
            next[row as usize] += 1;
        }
    }
    (start, columns)
}
