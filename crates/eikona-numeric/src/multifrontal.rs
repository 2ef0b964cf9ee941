//! The numbers of the factor, front by front.
//!
//! Each supernode (some consecutive columns with one pattern below them) gathers its part of the
//! matrix and the updates of its children in the elimination tree, eliminates its columns with
//! dense kernels, and leaves one dense update to its parent.
//!
//! Why not the backend's supernodal factorisation: the fill-in of a diffusion operator decays
//! exponentially with distance, reaches denormal numbers on meshes of some hundred edges across,
//! and denormal arithmetic made that phase five times slower at 500,000 faces (and slower without
//! bound on larger meshes). Here what is negligible is set to zero front by front.

use crate::error::NumericError;
use crate::kernels::{self, Vectorized, dispatch};
use crate::memory::Zeroed;
use crate::scalar::Scalar;
use crate::symbolic::Symbolic;
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatMut, MatRef, Par};
use std::ops::Range;

/// Fill-in below this share of the root of the largest diagonal entry is set to zero. The product
/// of two larger numbers is no denormal. A vector that diffuses so far has gone through entries
/// nearby by then, which are kept; what is smaller in a solution has lost its accuracy
/// ([`Cholesky::solve`](crate::Cholesky::solve)).
const NEGLIGIBLE: f64 = 1e-150;

/// Columns eliminated by our own kernels before the rest of the panel is updated by the backend's
/// matrix product.
const BLOCK: usize = 32;

/// Products with fewer multiplications than this are done by our own kernels: calling the backend's
/// would cost more.
const SMALL_PRODUCT: usize = 1 << 16;

/// Factors the permuted lower triangle `entries` into `values`, laid out as the symbolic factor
/// says.
pub(crate) fn factor<T: Scalar>(
    symbolic: &Symbolic,
    entries: &[T],
    values: &mut [T],
) -> Result<(), NumericError> {
    dispatch(Fronts { symbolic, entries, values })
}

struct Fronts<'a, T> {
    symbolic: &'a Symbolic,
    entries: &'a [T],
    values: &'a mut [T],
}

impl<T: Scalar> Vectorized for Fronts<'_, T> {
    type Output = Result<(), NumericError>;
    #[inline(always)]
    fn run<S: pulp::Simd>(self, simd: S) -> Self::Output {
        factor_fronts(simd, self.symbolic, self.entries, self.values)
    }
}

#[inline(always)]
fn factor_fronts<S: pulp::Simd, T: Scalar>(
    simd: S,
    symbolic: &Symbolic,
    entries: &[T],
    values: &mut [T],
) -> Result<(), NumericError> {
    let supernodes = symbolic.supernodes();
    let n = symbolic.unknowns();
    let (col_ptr, row_idx) = symbolic.lower_triangle();
    let largest = (0..n).fold(0.0f64, |m, j| m.max(entries[col_ptr[j] as usize].max_part()));
    let negligible = NEGLIGIBLE * largest.sqrt();
    let mut local = vec![0u32; n];
    let [even, odd] =
        supernodes.stack_entries().map(|size| Stack::new(size).ok_or(symbolic.out_of_memory::<T>()));
    let (mut even, mut odd) = (even?, odd?);
    let mut children: Vec<Child> = Vec::new();
    for s in 0..supernodes.count() {
        let Range { start: first, end: last } = supernodes.columns(s);
        let width = last - first;
        let rows = supernodes.rows(s);
        let height = width + rows.len();
        let panel = &mut values[supernodes.panel(s)];
        for (i, &row) in rows.iter().enumerate() {
            local[row as usize] = (width + i) as u32;
        }
        for column in first..last {
            local[column] = (column - first) as u32;
        }
        for column in first..last {
            let target = &mut panel[(column - first) * height..(column - first + 1) * height];
            for k in col_ptr[column] as usize..col_ptr[column + 1] as usize {
                target[local[row_idx[k] as usize] as usize] = entries[k];
            }
        }
        let (own, below) = if supernodes.is_odd(s) { (&mut odd, &mut even) } else { (&mut even, &mut odd) };
        children.clear();
        while let Some(update) = below.waiting.pop_if(|update| (update.parent_column as usize) < last) {
            let child_rows = supernodes.rows(update.supernode);
            let inside = child_rows.partition_point(|&row| (row as usize) < last);
            children.push(Child {
                start: update.start,
                size: child_rows.len(),
                inside,
                supernode: update.supernode,
            });
        }
        for child in &children {
            let rows = supernodes.rows(child.supernode);
            let update = &below.values[child.start..][..child.size * child.size];
            for (j, &column) in rows[..child.inside].iter().enumerate() {
                let target = &mut panel[local[column as usize] as usize * height..][..height];
                add_rows(target, &update[j * child.size + j..(j + 1) * child.size], &rows[j..], &local, 0);
            }
        }
        eliminate(simd, panel, width, height, negligible)
            .map_err(|column| symbolic.not_positive(first + column))?;
        if !rows.is_empty() {
            let size = rows.len();
            let start = own.push(s, rows);
            let update = &mut own.values[start..start + size * size];
            minus_outer_product(simd, panel, width, height, update);
            for child in &children {
                let rows = supernodes.rows(child.supernode);
                let child_update = &below.values[child.start..][..child.size * child.size];
                for (j, &column) in rows.iter().enumerate().skip(child.inside) {
                    let target = &mut update[(local[column as usize] as usize - width) * size..][..size];
                    let source = &child_update[j * child.size + j..(j + 1) * child.size];
                    add_rows(target, source, &rows[j..], &local, width as u32);
                }
            }
        }
    }
    Ok(())
}

/// Adds a column of a child's update to a column of its parent. Rows come in the same order in the
/// parent, so the lower triangle stays below the diagonal.
#[inline(always)]
fn add_rows<T: Scalar>(target: &mut [T], source: &[T], rows: &[u32], local: &[u32], offset: u32) {
    for (&value, &row) in source.iter().zip(rows) {
        target[(local[row as usize] - offset) as usize] += value;
    }
}

/// A child whose update is being added to the front.
struct Child {
    supernode: usize,
    start: usize,
    size: usize,
    /// How many of its rows are columns of the front.
    inside: usize,
}

/// Updates that wait for their parents: dense matrices on the rows of a supernode, of which the
/// lower triangle counts.
struct Stack<T> {
    values: Zeroed<T>,
    waiting: Vec<Waiting>,
}

struct Waiting {
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

    fn push(&mut self, supernode: usize, rows: &[u32]) -> usize {
        let start = self.waiting.last().map_or(0, |top| top.end);
        let end = start + rows.len() * rows.len();
        self.waiting.push(Waiting { supernode, start, end, parent_column: rows[0] });
        start
    }
}

/// Dense Cholesky of the first `width` rows of a panel, and the rows below divided by it. On
/// failure the column.
///
/// Columns are flushed as they are done, so that no product of denormal size is ever formed.
#[inline(always)]
fn eliminate<S: pulp::Simd, T: Scalar>(
    simd: S,
    panel: &mut [T],
    width: usize,
    height: usize,
    negligible: f64,
) -> Result<(), usize> {
    let blocks = width.div_ceil(BLOCK);
    for block in 0..blocks {
        let columns = block * BLOCK..((block + 1) * BLOCK).min(width);
        kernels::eliminate_columns(simd, panel, columns.clone(), height, negligible)?;
        // As by halving the blocks again and again: whenever a left half is done its right half is
        // updated at once, so that most of the work is done by few, deep products.
        let done = block + 1;
        let depth = 1 << done.trailing_zeros();
        let right = (done + depth).min(blocks);
        if done < blocks {
            let begin = (done - depth) * BLOCK;
            update_columns(panel, begin..columns.end, (right * BLOCK).min(width), height);
        }
    }
    Ok(())
}

/// Subtracts what columns `done` contribute to the columns from there to `end`.
#[inline(always)]
fn update_columns<T: Scalar>(panel: &mut [T], done: Range<usize>, end: usize, height: usize) {
    let count = end - done.end;
    let (left, right) = panel[..end * height].split_at_mut(done.end * height);
    let left = MatRef::from_column_major_slice(&left[done.start * height..], height, done.len());
    let left = left.split_at_row(done.end).1;
    let right = MatMut::from_column_major_slice_mut(right, height, count).split_at_row_mut(done.end).1;
    let (top, below) = right.split_at_row_mut(count);
    let (left_top, left_below) = left.split_at_row(count);
    let minus_one = -T::real(1.0);
    triangular::matmul(
        top,
        BlockStructure::TriangularLower,
        Accum::Add,
        left_top,
        BlockStructure::Rectangular,
        left_top.adjoint(),
        BlockStructure::Rectangular,
        minus_one,
        Par::Seq,
    );
    matmul(below, Accum::Add, left_below, left_top.adjoint(), minus_one, Par::Seq);
}

/// The lower triangle of `update <- -L L^H`, for the rows `L` of the panel below its columns.
#[inline(always)]
fn minus_outer_product<S: pulp::Simd, T: Scalar>(
    simd: S,
    panel: &[T],
    width: usize,
    height: usize,
    update: &mut [T],
) {
    let size = height - width;
    if width * size * size < SMALL_PRODUCT {
        return kernels::minus_outer_product(simd, panel, width, height, update);
    }
    let below = MatRef::from_column_major_slice(panel, height, width).split_at_row(width).1;
    triangular::matmul(
        MatMut::from_column_major_slice_mut(update, size, size),
        BlockStructure::TriangularLower,
        Accum::Replace,
        below,
        BlockStructure::Rectangular,
        below.adjoint(),
        BlockStructure::Rectangular,
        -T::real(1.0),
        Par::Seq,
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Complex, Graph, Ordering, SymmetricMatrix};

    /// A band matrix that is diagonally dominant, with fronts of all kinds.
    fn agrees_without_vectors<T: Scalar>(value: impl Fn(usize) -> T) {
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
        factor(&symbolic, &entries, &mut fast).unwrap();
        factor_fronts(pulp::Scalar128b, &symbolic, &entries, &mut plain).unwrap();
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
    fn processors_without_vectors_get_the_same_factor() {
        agrees_without_vectors(|k| (k as f64).sin());
        agrees_without_vectors(|k| Complex { re: (k as f64).sin(), im: (k as f64).cos() });
    }
}
