//! Multifrontal numeric factorisation.
//!
//! For each supernode, in postorder of the elimination tree: assemble its part of the matrix and
//! the update matrices of its children (extend-add), eliminate its columns with dense kernels, and
//! push its own update matrix for its parent.
//!
//! The backend's supernodal factorisation is not used because the fill-in of a diffusion operator
//! decays exponentially with distance and becomes denormal on meshes of some hundred edges across.
//! Denormal arithmetic made that phase five times slower at 500,000 faces (and slower without
//! bound on larger meshes). Here negligible entries are set to zero front by front.
//!
//! Measured on the vertex Laplacian of a torus with 249,218 vertices, on one thread with the same
//! order (`examples/cholesky.rs`): for diffusion times of 10,000, 1 and 0.01 squared edge lengths,
//! factoring takes 0.45, 0.48 and 0.32 s, and with the backend 0.65, 0.73 and 3.3 s. The backend's
//! factor has 4 % more entries, and it solves in 0.09 to 0.11 s instead of 0.03 to 0.07 s. Its
//! analysis is faster, 0.06 to 0.11 s instead of 0.15 to 0.17 s, but starts from a sorted matrix
//! instead of contributions in any order.

use crate::kernels;
use crate::memory::Zeroed;
use crate::observer::{check_at, check_stopped};
use crate::scalar::{Backend, Scalar};
use crate::supernodes::Supernodes;
use crate::symbolic::Symbolic;
use crate::threads::together;
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatMut, MatRef, Par};
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// Drop tolerance: fill-in below this multiple of the square root of the largest diagonal entry is
/// set to zero, so that products of kept entries are never denormal. A solution that has decayed
/// this far has passed through nearby entries, which are kept; smaller solution values have lost
/// their accuracy anyway ([`Cholesky::solve`](crate::Cholesky::solve)).
const NEGLIGIBLE: f64 = 1e-150;

/// Columns eliminated by our own kernels before the backend's matrix product updates the rest of
/// the panel.
const BLOCK: usize = 32;

/// Products with fewer multiplications than this use our own kernels: calling the backend would
/// cost more than the product.
const SMALL_PRODUCT: usize = 1 << 16;

/// A numeric factorisation: what all fronts share.
pub(crate) struct Problem<'a, T> {
    pub symbolic: &'a Symbolic,
    /// The permuted lower triangle.
    entries: &'a [T],
    negligible: f64,
    /// Multiplications in all fronts, and in those that are finished.
    work: f64,
    finished: AtomicU64,
}

/// Why a factorisation ended early.
pub(crate) enum Stop {
    /// The column at this place of the elimination order has no positive pivot.
    NotPositive(usize),
    NoMemory,
    /// The observer stopped it.
    Observer,
}

impl<'a, T: Scalar> Problem<'a, T> {
    pub fn new(symbolic: &'a Symbolic, entries: &'a [T]) -> Problem<'a, T> {
        let (col_ptr, _) = symbolic.lower_triangle();
        let diagonal = (0..symbolic.unknowns()).map(|j| entries[col_ptr[j] as usize].max_part());
        let negligible = NEGLIGIBLE * diagonal.fold(0.0, f64::max).sqrt();
        let supernodes = symbolic.supernodes();
        let work = (0..supernodes.count()).map(|s| supernodes.work(s)).sum();
        Problem { symbolic, entries, negligible, work, finished: AtomicU64::new(0) }
    }

    /// Lets the observer stop the factorisation.
    fn check(&self) -> Result<(), Stop> {
        check_at(|| self.finished.load(Relaxed) as f64 / self.work).map_err(|_| Stop::Observer)
    }

    /// Factors consecutive supernodes that contain all their descendants. `values` are their
    /// panels.
    #[inline(always)]
    pub fn factor_range<S: pulp::Simd>(
        &self,
        simd: S,
        range: Range<usize>,
        values: &mut [T],
        workspace: &mut Workspace<T>,
    ) -> Result<(), Stop> {
        let supernodes = self.symbolic.supernodes();
        let begin = if range.is_empty() { 0 } else { supernodes.panel(range.start).start };
        let Workspace { even, odd, local } = workspace;
        even.waiting.clear();
        odd.waiting.clear();
        for s in range {
            let last = supernodes.columns(s).end as u32;
            let (own, below) =
                if supernodes.is_odd(s) { (&mut *odd, &mut *even) } else { (&mut *even, &mut *odd) };
            let mut children: Vec<Child<T>> = Vec::new();
            while let Some(update) = below.waiting.pop_if(|update| update.parent_column < last) {
                let rows = supernodes.rows(update.supernode);
                let update = &below.values[update.start..][..rows.len() * rows.len()];
                children.push(Child { rows, update });
            }
            let rows = supernodes.rows(s);
            let update = own.push(s, rows);
            let panel = supernodes.panel(s);
            let panel = &mut values[panel.start - begin..panel.end - begin];
            self.front(simd, s, panel, &children, update, local, 1)?;
        }
        Ok(())
    }

    /// Factors one front: assembles the matrix and the update matrices of the children, eliminates
    /// the columns of the supernode, and writes its own update matrix.
    #[inline(always)]
    pub fn front<S: pulp::Simd>(
        &self,
        simd: S,
        s: usize,
        panel: &mut [T],
        children: &[Child<T>],
        update: &mut [T],
        local: &mut [u32],
        threads: usize,
    ) -> Result<(), Stop> {
        self.check()?;
        let (col_ptr, row_idx) = self.symbolic.lower_triangle();
        let Range { start: first, end: last } = self.symbolic.supernodes().columns(s);
        let rows = self.symbolic.supernodes().rows(s);
        let width = last - first;
        let height = width + rows.len();
        for (i, &row) in rows.iter().enumerate() {
            local[row as usize] = (width + i) as u32;
        }
        for column in first..last {
            local[column] = (column - first) as u32;
        }
        for column in first..last {
            if height > LONG {
                self.check()?;
            }
            let target = &mut panel[(column - first) * height..(column - first + 1) * height];
            for k in col_ptr[column] as usize..col_ptr[column + 1] as usize {
                target[local[row_idx[k] as usize] as usize] = self.entries[k];
            }
        }
        // Rows of each child that are columns of the front.
        let inside = |child: &Child<T>| child.rows.partition_point(|&row| (row as usize) < last);
        for child in children {
            for (j, &column) in child.rows[..inside(child)].iter().enumerate() {
                if child.rows.len() > LONG {
                    self.check()?;
                }
                let target = &mut panel[local[column as usize] as usize * height..][..height];
                extend_add(target, child.column(j), &child.rows[j..], local, 0);
            }
        }
        eliminate(simd, panel, width, height, self.negligible, threads).map_err(|stop| match stop {
            Stop::NotPositive(column) => Stop::NotPositive(first + column),
            stop => stop,
        })?;
        if !rows.is_empty() {
            minus_outer_product(simd, panel, width, height, update, threads)?;
            let size = rows.len();
            for child in children {
                for (j, &column) in child.rows.iter().enumerate().skip(inside(child)) {
                    if child.rows.len() > LONG {
                        self.check()?;
                    }
                    let target = &mut update[(local[column as usize] as usize - width) * size..][..size];
                    extend_add(target, child.column(j), &child.rows[j..], local, width as u32);
                }
            }
        }
        self.finished.fetch_add(self.symbolic.supernodes().work(s) as u64, Relaxed);
        Ok(())
    }
}

/// Update matrix of a child that is assembled into a front.
pub(crate) struct Child<'a, T> {
    /// The rows of the child's supernode.
    pub rows: &'a [u32],
    /// A square matrix on these rows, lower triangle only.
    pub update: &'a [T],
}

impl<T> Child<'_, T> {
    /// Column `j` from the diagonal down.
    fn column(&self, j: usize) -> &[T] {
        let size = self.rows.len();
        &self.update[j * size + j..(j + 1) * size]
    }
}

/// Extend-add: adds a column of a child's update matrix to a column of its parent. Row indices
/// ascend in both, so the lower triangle stays below the diagonal.
#[inline(always)]
fn extend_add<T: Scalar>(target: &mut [T], source: &[T], rows: &[u32], local: &[u32], offset: u32) {
    for (&value, &row) in source.iter().zip(rows) {
        target[(local[row as usize] - offset) as usize] += value;
    }
}

/// Memory in which one thread factors subtrees, one after the other.
pub(crate) struct Workspace<T> {
    even: Stack<T>,
    odd: Stack<T>,
    /// Place of each row in the current front.
    pub local: Vec<u32>,
}

impl<T: Scalar> Workspace<T> {
    /// `None` if there is not enough memory.
    pub fn new(symbolic: &Symbolic) -> Option<Self> {
        let [even, odd] = symbolic.supernodes().stack_entries().map(Stack::new);
        Some(Workspace { even: even?, odd: odd?, local: vec![0; symbolic.unknowns()] })
    }

    /// The update matrix of the last supernode of a range.
    pub fn last_update(&self, supernodes: &Supernodes, s: usize) -> &[T] {
        let stack = if supernodes.is_odd(s) { &self.odd } else { &self.even };
        let size = supernodes.rows(s).len();
        stack.waiting.last().map_or(&[], |top| &stack.values[top.start..][..size * size])
    }
}

/// Stack of update matrices that wait for assembly: dense square matrices on the rows of a
/// supernode, lower triangle only.
struct Stack<T> {
    values: Zeroed<T>,
    waiting: Vec<Update>,
}

struct Update {
    supernode: usize,
    start: usize,
    end: usize,
    /// Its first row, which is a column of the parent.
    parent_column: u32,
}

impl<T: Scalar> Stack<T> {
    fn new(entries: usize) -> Option<Self> {
        Zeroed::new(entries).map(|values| Stack { values, waiting: Vec::new() })
    }

    /// Returns the space for the update matrix of a supernode; none is kept for a root.
    fn push(&mut self, supernode: usize, rows: &[u32]) -> &mut [T] {
        let Some(&parent_column) = rows.first() else { return &mut [] };
        let start = self.waiting.last().map_or(0, |top| top.end);
        let end = start + rows.len() * rows.len();
        self.waiting.push(Update { supernode, start, end, parent_column });
        &mut self.values[start..end]
    }
}

/// Dense Cholesky factorisation of the first `width` columns of a panel, including the rows below.
/// [`Stop::NotPositive`] holds the column of the panel.
///
/// Each column is flushed as soon as it is done, so that no product is denormal.
#[inline(always)]
fn eliminate<S: pulp::Simd, T: Scalar>(
    simd: S,
    panel: &mut [T],
    width: usize,
    height: usize,
    negligible: f64,
    threads: usize,
) -> Result<(), Stop> {
    let blocks = width.div_ceil(BLOCK);
    for block in 0..blocks {
        let columns = block * BLOCK..((block + 1) * BLOCK).min(width);
        kernels::eliminate_columns(simd, panel, columns.clone(), height, negligible)
            .map_err(Stop::NotPositive)?;
        // Recursive blocking without recursion: as soon as a left half is done, it updates the
        // right half, so that a few deep products do most of the work.
        let done = block + 1;
        let depth = 1 << done.trailing_zeros();
        let right = (done + depth).min(blocks);
        if done < blocks {
            let begin = (done - depth) * BLOCK;
            update_columns(panel, begin..columns.end, (right * BLOCK).min(width), height, threads)?;
        }
    }
    Ok(())
}

/// Subtracts the contribution of columns `done` from the columns between them and `end`.
#[inline(always)]
fn update_columns<T: Scalar>(
    panel: &mut [T],
    done: Range<usize>,
    end: usize,
    height: usize,
    threads: usize,
) -> Result<(), Stop> {
    let count = end - done.end;
    let (left, right) = panel[..end * height].split_at_mut(done.end * height);
    let left = matrix(&left[done.start * height..], height, done.len());
    let left = left.split_at_row(done.end).1;
    let right = matrix_mut(right, height, count).split_at_row_mut(done.end).1;
    let (top, below) = right.split_at_row_mut(count);
    let (left_top, left_below) = left.split_at_row(count);
    let mut products: Vec<Product<T>> = Vec::new();
    split_lower(top, left_top, &mut products);
    split_rows(below, left_below, left_top, &mut products);
    run(products, Accum::Add, threads)
}

/// Computes the lower triangle of `update <- -L L^H`, where `L` are the rows of the panel below its
/// columns.
#[inline(always)]
fn minus_outer_product<S: pulp::Simd, T: Scalar>(
    simd: S,
    panel: &[T],
    width: usize,
    height: usize,
    update: &mut [T],
    threads: usize,
) -> Result<(), Stop> {
    let size = height - width;
    if width * size * size < SMALL_PRODUCT {
        kernels::minus_outer_product(simd, panel, width, height, update);
        return Ok(());
    }
    let mut products: Vec<Product<T>> = Vec::new();
    let left = matrix(panel, height, width).split_at_row(width).1;
    split_lower(matrix_mut(update, size, size), left, &mut products);
    run(products, Accum::Replace, threads)
}

/// Columns of more entries are worth a look at the observer each.
const LONG: usize = 1024;

/// Large products are split into blocks of so many rows and columns, which threads share. The
/// blocks do not depend on the number of threads, and so neither do the digits.
const STRIP: usize = 512;

/// Work, in multiplications, from which products are shared between threads: starting a thread
/// takes some ten microseconds.
const WORTH_A_THREAD: usize = 1 << 22;

/// A part of `target <- target - left right^H` (or without the first term).
struct Product<'a, T: Backend> {
    target: MatMut<'a, T::Raw>,
    left: MatRef<'a, T::Raw>,
    right: MatRef<'a, T::Raw>,
    /// Only the lower triangle of the target counts.
    lower: bool,
}

impl<'a, T: Scalar> Product<'a, T> {
    fn lower(target: MatMut<'a, T::Raw>, left: MatRef<'a, T::Raw>) -> Self {
        Product { target, left, right: left, lower: true }
    }

    fn work(&self) -> usize {
        self.left.nrows() * self.left.ncols() * self.right.nrows()
    }

    /// Runs on this thread only: `matmul` hands `Par::Seq` down to its kernels and never reads the
    /// process-wide setting of the backend, which only its solvers, determinants and operators do
    /// (`get_global_parallelism` in `linalg/{solvers,mat_ops}.rs`, `linalg/reductions` and
    /// `sparse/solvers.rs` of faer 0.24).
    fn run(self, accumulate: Accum) {
        let Product { target, left, right, lower } = self;
        if lower {
            triangular::matmul(
                target,
                BlockStructure::TriangularLower,
                accumulate,
                left,
                BlockStructure::Rectangular,
                right.adjoint(),
                BlockStructure::Rectangular,
                T::MINUS_ONE,
                Par::Seq,
            );
        } else {
            matmul(target, accumulate, left, right.adjoint(), T::MINUS_ONE, Par::Seq);
        }
    }
}

/// A matrix by columns, for the backend.
fn matrix<T: Scalar>(values: &[T], rows: usize, columns: usize) -> MatRef<'_, T::Raw> {
    MatRef::from_column_major_slice(bytemuck::cast_slice(values), rows, columns)
}

fn matrix_mut<T: Scalar>(values: &mut [T], rows: usize, columns: usize) -> MatMut<'_, T::Raw> {
    MatMut::from_column_major_slice_mut(bytemuck::cast_slice_mut(values), rows, columns)
}

/// Splits the lower triangle of a square product into blocks.
fn split_lower<'a, T: Scalar>(
    mut target: MatMut<'a, T::Raw>,
    mut left: MatRef<'a, T::Raw>,
    products: &mut Vec<Product<'a, T>>,
) {
    while target.ncols() > 0 {
        let columns = target.ncols().min(STRIP);
        let (strip, others) = target.split_at_col_mut(columns);
        let (diagonal, below) = strip.split_at_row_mut(columns);
        let (left_top, left_below) = left.split_at_row(columns);
        products.push(Product::lower(diagonal, left_top));
        split_rows(below, left_below, left_top, products);
        (target, left) = (others.split_at_row_mut(columns).1, left_below);
    }
}

/// Splits a rectangular product into blocks of rows.
fn split_rows<'a, T: Scalar>(
    mut target: MatMut<'a, T::Raw>,
    mut left: MatRef<'a, T::Raw>,
    right: MatRef<'a, T::Raw>,
    products: &mut Vec<Product<'a, T>>,
) {
    while target.nrows() > 0 {
        let rows = target.nrows().min(STRIP);
        let (block, target_rest) = target.split_at_row_mut(rows);
        let (left_block, left_rest) = left.split_at_row(rows);
        products.push(Product { target: block, left: left_block, right, lower: false });
        (target, left) = (target_rest, left_rest);
    }
}

/// Runs products that write to different places.
fn run<T: Scalar>(products: Vec<Product<T>>, accumulate: Accum, threads: usize) -> Result<(), Stop> {
    let work: usize = products.iter().map(Product::work).sum();
    if work < WORTH_A_THREAD {
        products.into_iter().for_each(|product| product.run(accumulate));
        return Ok(());
    }
    let workers = threads.clamp(1, products.len());
    let waiting = Mutex::new(products);
    let next = || waiting.lock().ok().and_then(|mut waiting| waiting.pop());
    let take_turns = || {
        while let Some(product) = next() {
            check_stopped().map_err(|_| Stop::Observer)?;
            product.run(accumulate);
        }
        Ok(())
    };
    together((0..workers).map(|_| take_turns)).into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parallel::factor;
    use crate::{Complex, Graph, Ordering, SymmetricMatrix};

    /// Compares the factor with and without SIMD, for a diagonally dominant band matrix with fronts
    /// of many shapes.
    fn check_without_simd<T: Scalar>(value: impl Fn(usize) -> T) {
        let n = 300u32;
        let pairs: Vec<[u32; 2]> = (0..n)
            .flat_map(|i| [1, 2, 7, 40].into_iter().map(move |d| [i, i + d]))
            .filter(|[_, j]| *j < n)
            .collect();
        let matrix = SymmetricMatrix {
            diagonal: vec![9.0; n as usize],
            off_diagonal: (0..pairs.len()).map(value).collect(),
        };
        let symbolic =
            Symbolic::new(&Graph { unknowns: n as usize, pairs }, Ordering::MinimumDegree).unwrap();
        let entries = symbolic.permute(&matrix).unwrap();
        let mut fast = vec![T::ZERO; symbolic.factor_entries()];
        let mut plain = fast.clone();
        factor(&symbolic, &entries, &mut fast, 1).unwrap();
        let all = 0..symbolic.supernodes().count();
        let mut workspace = Workspace::new(&symbolic).unwrap();
        let problem = Problem::new(&symbolic, &entries);
        assert!(problem.factor_range(pulp::Scalar128b, all, &mut plain, &mut workspace).is_ok());
        for s in 0..symbolic.supernodes().count() {
            let (columns, rows) =
                (symbolic.supernodes().columns(s).len(), symbolic.supernodes().rows(s).len());
            let panel = symbolic.supernodes().panel(s);
            for (i, (a, b)) in fast[panel.clone()].iter().zip(&plain[panel]).enumerate() {
                let above_diagonal = i % (columns + rows) < i / (columns + rows);
                assert!(above_diagonal || (*a - *b).abs_sq().sqrt() < 1e-13, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn factors_agree_without_simd() {
        check_without_simd(|k| (k as f64).sin());
        check_without_simd(|k| Complex { re: (k as f64).sin(), im: (k as f64).cos() });
    }
}
