//! Supernodal Cholesky factorisation: numeric factor, triangular solves and residuals.

use crate::error::NumericError;
use crate::kernels::{self, Vectorized, dispatch};
use crate::matrix::SymmetricMatrix;
use crate::memory::Zeroed;
use crate::observer::{check_step, check_stopped};
use crate::parallel;
use crate::resources::Resources;
use crate::scalar::Scalar;
use crate::symbolic::Symbolic;
use crate::threads::together;
use std::ops::Range;
use std::sync::Arc;

/// Cholesky factor of a system `A x = b` with `A` symmetric (or Hermitian) positive definite.
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
    /// Permuted lower triangle of A, for residuals.
    matrix: Vec<T>,
    values: Zeroed<T>,
    /// Threads of the factorisation, on which several right-hand sides are solved too.
    threads: usize,
}

/// Factors with fewer entries are swept on one thread: starting a thread takes some ten
/// microseconds, as long as a sweep over this many entries.
const WORTH_THREADS: usize = 1 << 15;

/// Fewest right-hand sides per thread. Each thread reads the whole factor, which takes as long as
/// the arithmetic of one or two right-hand sides. Measured on 5,000 and 20,000 unknowns, two
/// threads are 1.0 and 1.1 times as fast as one with 2 right-hand sides, and 1.5 and 1.3 times
/// with 8. If no second core is free, they take 1.5 and 1.2 times as long.
const SHARE: usize = 4;

impl<T: Scalar> Cholesky<T> {
    /// Factors a matrix on one thread.
    ///
    /// # Errors
    /// [`NumericError::NonPositivePivot`] with the unknown if the matrix is not positive definite,
    /// [`NumericError::NonFinite`], [`NumericError::OutOfMemory`] with the predicted bytes,
    /// [`NumericError::WrongLength`].
    pub fn new(symbolic: Arc<Symbolic>, matrix: &SymmetricMatrix<T>) -> Result<Self, NumericError> {
        Cholesky::on_threads(symbolic, matrix, 1)
    }

    /// Factors a matrix on several threads, which [`solve_many`](Self::solve_many) uses too. The
    /// digits are the same for any number of threads.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    ///
    /// # Cost
    /// Each thread takes memory for fronts of its own: see [`Symbolic::predicted_bytes`].
    pub fn on_threads(
        symbolic: Arc<Symbolic>,
        matrix: &SymmetricMatrix<T>,
        threads: usize,
    ) -> Result<Self, NumericError> {
        check_stopped()?;
        let entries = symbolic.permute(matrix)?;
        check_stopped()?;
        let mut values =
            Zeroed::new(symbolic.factor_entries()).ok_or(symbolic.out_of_memory::<T>(threads))?;
        parallel::factor(&symbolic, &entries, &mut values, threads)?;
        Ok(Cholesky { symbolic, matrix: entries, values, threads })
    }

    /// Factors a matrix if its factor is predicted to stay within the memory limit.
    ///
    /// # Errors
    /// As for [`new`](Self::new), and [`NumericError::MemoryLimit`] before anything is allocated.
    pub fn within(
        resources: Resources,
        symbolic: Arc<Symbolic>,
        matrix: &SymmetricMatrix<T>,
    ) -> Result<Self, NumericError> {
        resources.check(symbolic.predicted_bytes::<T>(resources.threads))?;
        Cholesky::on_threads(symbolic, matrix, resources.threads)
    }

    /// Returns the symbolic analysis of the factor.
    pub fn symbolic(&self) -> &Arc<Symbolic> {
        &self.symbolic
    }

    /// Solves `A x = b`.
    ///
    /// The forward sweep skips supernodes whose right-hand side is zero, so sparse right-hand sides
    /// cost less. Values below 1e-290 are set to zero on the way, since arithmetic on denormal
    /// numbers is slow and has no relative accuracy.
    ///
    /// # Errors
    /// [`NumericError::WrongLength`]; [`NumericError::NonFinite`] if the right-hand side or the
    /// solution is not finite.
    ///
    /// # Cost
    /// Two sweeps over the factor.
    pub fn solve(&self, rhs: &[T]) -> Result<Vec<T>, NumericError> {
        self.sweep(&[rhs], None).map(|mut solutions| solutions.remove(0))
    }

    /// Solves for several right-hand sides, with the same digits as one by one.
    ///
    /// # Errors
    /// As for [`solve`](Self::solve).
    ///
    /// # Cost
    /// The threads of the factorisation share the right-hand sides, at least four each. A thread
    /// reads the factor from memory once for all of its own, which takes most of the time of a
    /// single solve.
    pub fn solve_many(&self, rhs: &[impl AsRef<[T]>]) -> Result<Vec<Vec<T>>, NumericError> {
        let rhs: Vec<&[T]> = rhs.iter().map(AsRef::as_ref).collect();
        self.sweep(&rhs, None)
    }

    /// Solves `A x = b` for the wanted unknowns only. Each other entry of the result is either its
    /// solution value or zero.
    ///
    /// # Errors
    /// As for [`solve`](Self::solve).
    ///
    /// # Cost
    /// The parts of the factor between the right-hand side's non-zeros and the root of the
    /// elimination tree, and between the root and the wanted unknowns; plus one test per unknown.
    pub fn solve_where(&self, rhs: &[T], wanted: impl Fn(usize) -> bool) -> Result<Vec<T>, NumericError> {
        let (supernodes, order) = (self.symbolic.supernodes(), self.symbolic.order());
        let mut needed: Vec<bool> = (0..supernodes.count())
            .map(|s| order[supernodes.columns(s)].iter().any(|&unknown| wanted(unknown as usize)))
            .collect();
        supernodes.mark_ancestors(&mut needed);
        self.sweep(&[rhs], Some(&needed)).map(|mut solutions| solutions.remove(0))
    }

    /// Refuses a right-hand side of the wrong length or with values that are not finite.
    pub(crate) fn check(&self, rhs: &[T]) -> Result<(), NumericError> {
        let expected = self.symbolic.unknowns();
        if rhs.len() != expected {
            return Err(NumericError::WrongLength { found: rhs.len(), expected });
        }
        match rhs.iter().position(|x| !x.finite()) {
            Some(unknown) => Err(NumericError::NonFinite { what: "the right-hand side", unknown }),
            None => Ok(()),
        }
    }

    /// Runs both sweeps for each right-hand side; the backward sweep covers the needed supernodes
    /// only.
    fn sweep(&self, rhs: &[&[T]], needed: Option<&[bool]>) -> Result<Vec<Vec<T>>, NumericError> {
        let s = &*self.symbolic;
        rhs.iter().try_for_each(|rhs| self.check(rhs))?;
        let solve = &|rhs: &[&[T]], solutions: &mut [Vec<T>]| {
            for (x, rhs) in solutions.iter_mut().zip(rhs) {
                *x = s.order().iter().map(|&i| rhs[i as usize]).collect();
            }
            dispatch(Sweeps { factor: self, columns: solutions, needed })?;
            for x in solutions {
                *x = s.position().iter().map(|&p| x[p as usize]).collect();
            }
            check_stopped()
        };
        let most = if s.factor_entries() < WORTH_THREADS { 1 } else { self.threads };
        let threads = most.min(rhs.len() / SHARE).max(1);
        let share = rhs.len().div_ceil(threads).max(1);
        let mut solutions = vec![Vec::new(); rhs.len()];
        let shares = rhs.chunks(share).zip(solutions.chunks_mut(share));
        let tasks = shares.map(|(rhs, solutions)| move || solve(rhs, solutions));
        together(tasks).into_iter().collect::<Result<(), _>>()?;
        match solutions.iter().find_map(|x| x.iter().position(|x| !x.finite())) {
            Some(unknown) => Err(NumericError::NonFinite { what: "the solution", unknown }),
            None => Ok(solutions),
        }
    }

    /// Returns the largest entry of `A x - b`, relative to the largest entry of `b` (absolute if
    /// `b` is zero). Complex entries count by the larger of their parts.
    ///
    /// # Panics
    /// If `x` or `rhs` has fewer values than unknowns.
    pub fn relative_residual(&self, x: &[T], rhs: &[T]) -> f64 {
        let s = &*self.symbolic;
        // In elimination order, neighbours lie close together in memory.
        let x: Vec<T> = s.order().iter().map(|&i| x[i as usize]).collect();
        let mut residual: Vec<T> = s.order().iter().map(|&i| rhs[i as usize]).collect();
        let (col_ptr, row_idx) = s.lower_triangle();
        let scale = residual.iter().fold(0.0f64, |m, b| m.max(b.max_part()));
        for j in 0..s.unknowns() {
            let (begin, end) = (col_ptr[j] as usize, col_ptr[j + 1] as usize);
            let mut sum = self.matrix[begin] * x[j];
            for (&i, &value) in row_idx[begin + 1..end].iter().zip(&self.matrix[begin + 1..end]) {
                residual[i as usize] -= value * x[j];
                sum += value.conj() * x[i as usize];
            }
            residual[j] -= sum;
        }
        let error = residual.iter().fold(0.0f64, |m, e| m.max(e.max_part()));
        if scale > 0.0 { error / scale } else { error }
    }

    /// Columns, rows and panel of a supernode.
    #[inline(always)]
    fn supernode(&self, s: usize) -> (Range<usize>, &[u32], &[T]) {
        let supernodes = self.symbolic.supernodes();
        (supernodes.columns(s), supernodes.rows(s), &self.values[supernodes.panel(s)])
    }

    /// Returns space for the rows of any supernode.
    pub(crate) fn gathering_space(&self) -> Vec<T> {
        vec![T::ZERO; self.symbolic.supernodes().largest_height()]
    }

    /// `x <- L^-1 x`, over supernodes in ascending order. The others must have zeros only.
    #[inline(always)]
    pub(crate) fn forward<S: pulp::Simd>(
        &self,
        simd: S,
        xs: &mut [Vec<T>],
        gathered: &mut [T],
        supernodes: impl Iterator<Item = usize>,
    ) -> Result<(), NumericError> {
        for (step, s) in supernodes.enumerate() {
            check_step(step)?;
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
        Ok(())
    }

    /// `x <- L^-H x`; unknowns of supernodes that are not needed are set to zero.
    #[inline(always)]
    pub(crate) fn backward<S: pulp::Simd>(
        &self,
        simd: S,
        xs: &mut [Vec<T>],
        gathered: &mut [T],
        needed: Option<&[bool]>,
    ) -> Result<(), NumericError> {
        for s in (0..self.symbolic.supernodes().count()).rev() {
            check_step(s)?;
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
        Ok(())
    }
}

/// Forward and backward sweep of a solve.
struct Sweeps<'a, T> {
    factor: &'a Cholesky<T>,
    columns: &'a mut [Vec<T>],
    needed: Option<&'a [bool]>,
}

impl<T: Scalar> Vectorized for Sweeps<'_, T> {
    type Output = Result<(), NumericError>;
    #[inline(always)]
    fn run<S: pulp::Simd>(self, simd: S) -> Self::Output {
        let mut gathered = self.factor.gathering_space();
        let all = 0..self.factor.symbolic.supernodes().count();
        self.factor.forward(simd, self.columns, &mut gathered, all)?;
        self.factor.backward(simd, self.columns, &mut gathered, self.needed)
    }
}

/// Smaller values are flushed to zero in solves.
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
    fn solutions_agree_without_simd() {
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
        dispatch(Sweeps { factor: &factor, columns: &mut columns, needed: None }).unwrap();
        Sweeps { factor: &factor, columns: &mut plain, needed: None }.run(pulp::Scalar128b).unwrap();
        for (a, b) in columns[0].iter().zip(&plain[0]) {
            assert!((*a - *b).abs_sq().sqrt() < 1e-14, "{a} {b}");
        }
    }
}
