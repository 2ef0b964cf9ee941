//! Supernodal Cholesky factorisation: analysed once a pattern, factored once a matrix, solved once
//! a right-hand side.

use crate::error::NumericError;
use crate::kernels::{self, Vectorized, dispatch};
use crate::memory::Zeroed;
use crate::multifrontal;
use crate::scalar::Scalar;
use crate::symbolic::Symbolic;
use std::ops::Range;
use std::sync::Arc;

/// The numbers of a system, in the order of its [`Graph`](crate::Graph).
#[derive(Clone, Debug, Default)]
pub struct SymmetricMatrix<T> {
    /// The diagonal, which is real also for Hermitian matrices.
    pub diagonal: Vec<f64>,
    /// One value for each pair of the graph: entry (first, second); the mirrored entry is its
    /// conjugate.
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
    /// [`NumericError::NonPositivePivot`] with the unknown where the matrix is not positive
    /// definite, [`NumericError::NonFinite`], [`NumericError::OutOfMemory`] with the predicted
    /// bytes, [`NumericError::WrongLength`].
    pub fn new(symbolic: Arc<Symbolic>, matrix: &SymmetricMatrix<T>) -> Result<Self, NumericError> {
        let entries = symbolic.permute(matrix)?;
        let mut values = Zeroed::new(symbolic.factor_entries()).ok_or(symbolic.out_of_memory::<T>())?;
        multifrontal::factor(&symbolic, &entries, &mut values)?;
        Ok(Cholesky { symbolic, matrix: entries, values })
    }

    /// The analysis that the factor was made with.
    pub fn symbolic(&self) -> &Arc<Symbolic> {
        &self.symbolic
    }

    /// The solution of `A x = b`. Unknowns whose right-hand side influences nothing are skipped:
    /// few non-zeros cost less.
    ///
    /// Values smaller than 1e-290 are set to zero on the way, since arithmetic on denormal numbers
    /// is slow and has no relative accuracy.
    ///
    /// # Errors
    /// [`NumericError::WrongLength`]; [`NumericError::NonFinite`] when the right-hand side or the
    /// solution is not finite.
    ///
    /// # Cost
    /// Two sweeps over the factor.
    pub fn solve(&self, rhs: &[T]) -> Result<Vec<T>, NumericError> {
        self.sweep(&[rhs], None).map(|mut solutions| solutions.remove(0))
    }

    /// The solutions for several right-hand sides, the same as one by one. The factor is read from
    /// memory once for all, which takes most of the time of a single solve.
    ///
    /// # Errors
    /// As for [`solve`](Self::solve).
    pub fn solve_many(&self, rhs: &[impl AsRef<[T]>]) -> Result<Vec<Vec<T>>, NumericError> {
        let rhs: Vec<&[T]> = rhs.iter().map(AsRef::as_ref).collect();
        self.sweep(&rhs, None)
    }

    /// Those unknowns of the solution of `A x = b` that are wanted; the others are zero or what
    /// they are in the solution.
    ///
    /// # Errors
    /// As for [`solve`](Self::solve).
    ///
    /// # Cost
    /// The parts of the factor that lie between the right-hand side's non-zeros and the root of the
    /// elimination tree, and between the root and the wanted unknowns; and a look at each unknown.
    pub fn solve_where(&self, rhs: &[T], wanted: impl Fn(usize) -> bool) -> Result<Vec<T>, NumericError> {
        let (supernodes, order) = (self.symbolic.supernodes(), self.symbolic.order());
        let mut needed: Vec<bool> = (0..supernodes.count())
            .map(|s| order[supernodes.columns(s)].iter().any(|&unknown| wanted(unknown as usize)))
            .collect();
        supernodes.mark_ancestors(&mut needed);
        self.sweep(&[rhs], Some(&needed)).map(|mut solutions| solutions.remove(0))
    }

    /// Both sweeps for each right-hand side; the second over the needed supernodes only.
    fn sweep(&self, rhs: &[&[T]], needed: Option<&[bool]>) -> Result<Vec<Vec<T>>, NumericError> {
        let s = &*self.symbolic;
        let mut columns = Vec::with_capacity(rhs.len());
        for rhs in rhs {
            if rhs.len() != s.unknowns() {
                return Err(NumericError::WrongLength { found: rhs.len(), expected: s.unknowns() });
            }
            if let Some(unknown) = rhs.iter().position(|x| !x.finite()) {
                return Err(NumericError::NonFinite { what: "the right-hand side", unknown });
            }
            columns.push(s.order().iter().map(|&i| rhs[i as usize]).collect());
        }
        dispatch(Sweeps { factor: self, columns: &mut columns, needed });
        for x in &mut columns {
            *x = s.place().iter().map(|&p| x[p as usize]).collect();
            if let Some(unknown) = x.iter().position(|x| !x.finite()) {
                return Err(NumericError::NonFinite { what: "the solution", unknown });
            }
        }
        Ok(columns)
    }

    /// The largest entry of `A x - b`, relative to the largest entry of `b` (absolute if `b` is
    /// zero).
    ///
    /// # Panics
    /// Unless `x` and `rhs` have one value an unknown.
    pub fn residual(&self, x: &[T], rhs: &[T]) -> f64 {
        let s = &*self.symbolic;
        // In the order of elimination neighbours lie near each other in memory.
        let x: Vec<T> = s.order().iter().map(|&i| x[i as usize]).collect();
        let mut miss: Vec<T> = s.order().iter().map(|&i| rhs[i as usize]).collect();
        let (col_ptr, row_idx) = s.lower_triangle();
        let scale = miss.iter().fold(0.0f64, |m, b| m.max(b.max_part()));
        for j in 0..s.unknowns() {
            let (begin, end) = (col_ptr[j] as usize, col_ptr[j + 1] as usize);
            let mut sum = self.matrix[begin] * x[j];
            for (&i, &value) in row_idx[begin + 1..end].iter().zip(&self.matrix[begin + 1..end]) {
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
        let supernodes = self.symbolic.supernodes();
        (supernodes.columns(s), supernodes.rows(s), &self.values[supernodes.panel(s)])
    }

    /// `x <- L^-1 x`
    #[inline(always)]
    fn forward<S: pulp::Simd>(&self, simd: S, xs: &mut [Vec<T>], gathered: &mut [T]) {
        for s in 0..self.symbolic.supernodes().count() {
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
        for s in (0..self.symbolic.supernodes().count()).rev() {
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
        let mut gathered = vec![T::ZERO; self.factor.symbolic.supernodes().largest_height()];
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Complex, Graph, Ordering};

    #[test]
    fn processors_without_vectors_get_the_same_solution() {
        let n = 200u32;
        let pairs: Vec<[u32; 2]> =
            (1..n).flat_map(|j| [[j, j - 1], [j, j / 2]]).filter(|[a, b]| a != b).collect();
        let value = |k: usize| Complex { re: (k as f64).sin(), im: (k as f64).cos() };
        let matrix = SymmetricMatrix {
            diagonal: vec![9.0; n as usize],
            off_diagonal: (0..pairs.len()).map(value).collect(),
        };
        let symbolic =
            Symbolic::new(&Graph { unknowns: n as usize, pairs }, Ordering::MinimumDegree).unwrap();
        let factor = Cholesky::new(symbolic.into(), &matrix).unwrap();
        let mut columns = vec![(0..n as usize).map(value).collect::<Vec<Complex>>()];
        let mut plain = columns.clone();
        dispatch(Sweeps { factor: &factor, columns: &mut columns, needed: None });
        Sweeps { factor: &factor, columns: &mut plain, needed: None }.run(pulp::Scalar128b);
        for (a, b) in columns[0].iter().zip(&plain[0]) {
            assert!((*a - *b).abs_sq().sqrt() < 1e-14, "{a} {b}");
        }
    }
}
