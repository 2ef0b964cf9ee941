//! Multifrontal numeric factorisation.
//!
//! For each supernode, in postorder of the elimination tree: assemble its part of the matrix and
//! the update matrices of its children (extend-add), eliminate its columns with dense kernels, and
//! push its own update matrix for its parent.
//!
//! The backend's supernodal factorisation is not used because the fill-in of a diffusion operator
//! decays exponentially with distance and becomes denormal on meshes of some hundred edges across.
//! Denormal arithmetic made that phase five times slower at 500,000 faces (and slower without bound
//! on larger meshes). Here negligible entries are set to zero front by front.

use crate::error::NumericError;
use crate::kernels::{self, Vectorized, dispatch};
use crate::memory::Zeroed;
use crate::scalar::Scalar;
use crate::symbolic::Symbolic;
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatMut, MatRef, Par};
use std::ops::Range;

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

/// Factors the permuted lower triangle `entries` into `values`, in the layout of the symbolic
/// analysis.
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
                extend_add(target, &update[j * child.size + j..(j + 1) * child.size], &rows[j..], &local, 0);
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
                    extend_add(target, source, &rows[j..], &local, width as u32);
                }
            }
        }
    }
    Ok(())
}

/// Extend-add: adds a column of a child's update matrix to a column of its parent. Row indices
/// ascend in both, so the lower triangle stays below the diagonal.
#[inline(always)]
fn extend_add<T: Scalar>(target: &mut [T], source: &[T], rows: &[u32], local: &[u32], offset: u32) {
    for (&value, &row) in source.iter().zip(rows) {
        target[(local[row as usize] - offset) as usize] += value;
    }
}

/// Child whose update matrix is being assembled into the front.
struct Child {
    supernode: usize,
    start: usize,
    size: usize,
    /// Number of its rows that are columns of the front.
    inside: usize,
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

    fn push(&mut self, supernode: usize, rows: &[u32]) -> usize {
        let start = self.waiting.last().map_or(0, |top| top.end);
        let end = start + rows.len() * rows.len();
        self.waiting.push(Update { supernode, start, end, parent_column: rows[0] });
        start
    }
}

/// Dense Cholesky factorisation of the first `width` columns of a panel, including the rows below.
/// On failure, returns the column.
///
/// Each column is flushed as soon as it is done, so that no product is denormal.
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
        // Recursive blocking without recursion: as soon as a left half is done, it updates the
        // right half, so that a few deep products do most of the work.
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

/// Subtracts the contribution of columns `done` from the columns up to `end`.
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

/// Computes the lower triangle of `update <- -L L^H`, where `L` is the part of the panel below its
/// diagonal block.
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
    fn factors_agree_without_simd() {
        check_without_simd(|k| (k as f64).sin());
        check_without_simd(|k| Complex { re: (k as f64).sin(), im: (k as f64).cos() });
    }
}
