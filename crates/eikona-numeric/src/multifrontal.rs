//! The numbers of the factor, front by front.
//!
//! Each supernode (some consecutive columns with one pattern below them) gathers its part of the matrix and the updates of
//! its children in the elimination tree, eliminates its columns with dense kernels, and leaves one dense update to its parent.
//!
//! Why not the backend's own numeric phase: the fill-in of a diffusion operator decays exponentially with distance, reaches
//! denormal numbers on meshes of some hundred edges across, and denormal arithmetic made that phase five times slower at
//! 500,000 faces (and slower without bound on larger meshes). Here what is negligible is set to zero front by front.

use crate::cholesky::Symbolic;
use crate::error::NumericError;
use crate::scalar::Scalar;
use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{self, BlockStructure};
use faer::{Accum, MatMut, MatRef, Par};

/// Fill-in below this share of the root of the largest diagonal entry is set to zero. The product of two larger numbers is no denormal. A
/// vector that diffuses so far has gone through entries nearby by then, which are kept; what is smaller in a solution has
/// lost its accuracy ([`Cholesky::solve`](crate::Cholesky::solve)).
const NEGLIGIBLE: f64 = 1e-150;

/// Columns eliminated by plain loops before the rest of the front is updated by a blocked kernel.
const BLOCK: usize = 16;

/// Updates with less work than this (multiplications) are done by plain loops: calling a blocked kernel would cost more.
const SMALL_UPDATE: usize = 4096;

/// Factors the permuted lower triangle `entries` into `values`, laid out as the symbolic factor says.
pub(crate) fn factor<T: Scalar>(
    symbolic: &Symbolic,
    entries: &[T],
    values: &mut [T],
) -> Result<(), NumericError> {
    // Compiled once for each vector width; the widest that the processor has is taken at run time. The operations and their
    // order are the same in all, and so are the digits.
    pulp::Arch::new().dispatch(Fronts { symbolic, entries, values })
}

struct Fronts<'a, T> {
    symbolic: &'a Symbolic,
    entries: &'a [T],
    values: &'a mut [T],
}

impl<T: Scalar> pulp::WithSimd for Fronts<'_, T> {
    type Output = Result<(), NumericError>;
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) -> Self::Output {
        factor_fronts(self.symbolic, self.entries, self.values)
    }
}

#[inline(always)]
fn factor_fronts<T: Scalar>(
    symbolic: &Symbolic,
    entries: &[T],
    values: &mut [T],
) -> Result<(), NumericError> {
    let shape = symbolic.factor();
    let n = symbolic.unknowns();
    let (begin, end) = (shape.supernode_begin(), shape.supernode_end());
    let (row_ptr, val_ptr) = (shape.col_ptr_for_row_idx(), shape.col_ptr_for_val());
    let (col_ptr, row_idx) = symbolic.lower_triangle();
    let largest = (0..n).fold(0.0f64, |m, j| m.max(entries[col_ptr[j] as usize].max_part()));
    let negligible = NEGLIGIBLE * largest.sqrt();
    let mut local = vec![0u32; n];
    let mut child_local: Vec<u32> = Vec::new();
    let mut pending: Vec<Update<T>> = Vec::new();
    let mut spare: Vec<Vec<T>> = Vec::new();
    for s in 0..shape.n_supernodes() {
        let (first, last) = (begin[s] as usize, end[s] as usize);
        let width = last - first;
        let rows = &shape.row_idx()[row_ptr[s] as usize..][..shape.nnz_per_super()[s] as usize];
        let height = width + rows.len();
        let panel = &mut values[val_ptr[s] as usize..val_ptr[s + 1] as usize];
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
        let mut update = spare.pop().unwrap_or_default();
        update.clear();
        update.resize(rows.len() * rows.len(), T::ZERO);
        // The children are the last updates left, as the columns are in postorder.
        while pending.last().is_some_and(|child| (child.parent_column as usize) < last) {
            let Some(child) = pending.pop() else { break };
            let child_rows = &shape.row_idx()[row_ptr[child.supernode] as usize..][..child.size];
            child_local.clear();
            child_local.extend(child_rows.iter().map(|&row| local[row as usize]));
            add_child(&child, &child_local, panel, &mut update, width, height);
            spare.push(child.values);
        }
        eliminate(panel, width, height, negligible)
            .map_err(|column| symbolic.not_positive(first + column))?;
        if rows.is_empty() {
            spare.push(update);
        } else {
            subtract_outer_product(panel, width, height, &mut update);
            pending.push(Update { supernode: s, parent_column: rows[0], size: rows.len(), values: update });
        }
    }
    Ok(())
}

/// What a supernode leaves to its parent: the lower triangle of a dense matrix on its rows.
struct Update<T> {
    supernode: usize,
    /// Its first row, which is a column of the parent.
    parent_column: u32,
    size: usize,
    values: Vec<T>,
}

#[inline(always)]
fn add_child<T: Scalar>(
    child: &Update<T>,
    local: &[u32],
    panel: &mut [T],
    update: &mut [T],
    width: usize,
    height: usize,
) {
    let size = child.size;
    for j in 0..size {
        let column = local[j] as usize;
        let source = &child.values[j * size + j..(j + 1) * size];
        // Rows come in the same order in the parent, so the lower triangle stays below the diagonal.
        let target = if column < width {
            &mut panel[column * height..(column + 1) * height]
        } else {
            let below = height - width;
            &mut update[(column - width) * below..(column - width + 1) * below]
        };
        let offset = if column < width { 0 } else { width as u32 };
        for (&value, &row) in source.iter().zip(&local[j..]) {
            target[(row - offset) as usize] += value;
        }
    }
}

#[inline(always)]
fn flush<T: Scalar>(values: &mut [T], negligible: f64) {
    for value in values {
        if value.max_part() < negligible {
            *value = T::ZERO;
        }
    }
}

/// Dense Cholesky of the first `width` rows of a panel, and the rows below divided by it. On failure the column.
///
/// Columns are flushed as they are done, so that no product of denormal size is ever formed.
#[inline(always)]
fn eliminate<T: Scalar>(panel: &mut [T], width: usize, height: usize, negligible: f64) -> Result<(), usize> {
    for begin in (0..width).step_by(BLOCK) {
        let end = (begin + BLOCK).min(width);
        eliminate_columns(panel, begin, end, height, negligible)?;
        if end < width {
            update_columns(panel, begin, end, width, height);
        }
    }
    Ok(())
}

/// Eliminates columns `begin..end` by plain loops.
#[inline(always)]
fn eliminate_columns<T: Scalar>(
    panel: &mut [T],
    begin: usize,
    end: usize,
    height: usize,
    negligible: f64,
) -> Result<(), usize> {
    for j in begin..end {
        let (done, rest) = panel.split_at_mut(j * height);
        let column = &mut rest[j..height];
        subtract_columns(column, done, begin..j, height, j);
        let pivot = column[0].real_part();
        if pivot.is_nan() || pivot <= 0.0 {
            return Err(j);
        }
        let root = pivot.sqrt();
        let inverse = 1.0 / root;
        column[0] = T::real(root);
        column[1..].iter_mut().for_each(|x| *x = x.scale(inverse));
        flush(&mut column[1..], negligible);
    }
    Ok(())
}

/// `target <- target - sum of conj(c[0]) c` over the given columns of a panel, each from `row` on. Four at a time, so that the
/// target is read and written less often.
#[inline(always)]
fn subtract_columns<T: Scalar>(
    target: &mut [T],
    panel: &[T],
    columns: std::ops::Range<usize>,
    height: usize,
    row: usize,
) {
    let n = target.len();
    let column = |k: usize| &panel[k * height + row..][..n];
    let mut k = columns.start;
    while k + 4 <= columns.end {
        let (a, b, c, d) = (column(k), column(k + 1), column(k + 2), column(k + 3));
        let (fa, fb, fc, fd) = (a[0].conj(), b[0].conj(), c[0].conj(), d[0].conj());
        for i in 0..n {
            target[i] -= (a[i] * fa + b[i] * fb) + (c[i] * fc + d[i] * fd);
        }
        k += 4;
    }
    for k in k..columns.end {
        let a = column(k);
        let factor = a[0].conj();
        for i in 0..n {
            target[i] -= a[i] * factor;
        }
    }
}

/// Subtracts what columns `begin..end` contribute to columns `end..width`.
#[inline(always)]
fn update_columns<T: Scalar>(panel: &mut [T], begin: usize, end: usize, width: usize, height: usize) {
    let (done, rest) = panel.split_at_mut(end * height);
    let done =
        MatRef::from_column_major_slice(&done[begin * height..], height, end - begin).split_at_row(end).1;
    let rest = MatMut::from_column_major_slice_mut(rest, height, width - end).split_at_row_mut(end).1;
    let (top, below) = rest.split_at_row_mut(width - end);
    let (done_top, done_below) = done.split_at_row(width - end);
    let minus_one = -T::real(1.0);
    triangular::matmul(
        top,
        BlockStructure::TriangularLower,
        Accum::Add,
        done_top,
        BlockStructure::Rectangular,
        done_top.adjoint(),
        BlockStructure::Rectangular,
        minus_one,
        Par::Seq,
    );
    matmul(below, Accum::Add, done_below, done_top.adjoint(), minus_one, Par::Seq);
}

/// `update <- update - L L^H` in the lower triangle, for the rows `L` of the panel below its columns.
#[inline(always)]
fn subtract_outer_product<T: Scalar>(panel: &[T], width: usize, height: usize, update: &mut [T]) {
    let size = height - width;
    if width * size * size < SMALL_UPDATE {
        for j in 0..size {
            let target = &mut update[j * size + j..(j + 1) * size];
            subtract_columns(target, panel, 0..width, height, width + j);
        }
        return;
    }
    let below = MatRef::from_column_major_slice(panel, height, width).split_at_row(width).1;
    triangular::matmul(
        MatMut::from_column_major_slice_mut(update, size, size),
        BlockStructure::TriangularLower,
        Accum::Add,
        below,
        BlockStructure::Rectangular,
        below.adjoint(),
        BlockStructure::Rectangular,
        -T::real(1.0),
        Par::Seq,
    );
}
