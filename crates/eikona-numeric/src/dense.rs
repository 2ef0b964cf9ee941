//! Small dense systems.

use crate::error::NumericError;
use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};

/// The solution of a small dense symmetric positive definite system, given row by row (only the lower triangle is read).
///
/// ```
/// let x = eikona_numeric::solve_dense(&[2.0, 0.0, 1.0, 3.0], &[3.0, 4.0])?;
/// assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 1.0).abs() < 1e-15);
/// # Ok::<(), eikona_numeric::NumericError>(())
/// ```
///
/// # Errors
/// [`NumericError::WrongLength`], [`NumericError::NonPositivePivot`].
///
/// # Cost
/// O(n^3).
pub fn solve_dense(matrix: &[f64], rhs: &[f64]) -> Result<Vec<f64>, NumericError> {
    let n = rhs.len();
    if matrix.len() != n * n {
        return Err(NumericError::WrongLength { found: matrix.len(), expected: n * n });
    }
    if n == 0 {
        return Ok(Vec::new());
    }
    let a = Mat::from_fn(n, n, |i, j| matrix[i * n + j]);
    let factor =
        Llt::new(a.as_ref(), Side::Lower).map_err(|_| NumericError::NonPositivePivot { unknown: 0 })?;
    let b = Mat::from_fn(n, 1, |i, _| rhs[i]);
    let x = factor.solve(&b);
    Ok((0..n).map(|i| x[(i, 0)]).collect())
}
