//! Kernel matrices whose entries are computed in each product, for all pairs of faces: the exact
//! inner product, to compare with and for small meshes.

use super::kernel::{KernelKind, Kernels};
use crate::repulsive::faces::FaceDatum;
use eikona_numeric::{NumericError, check_stopped, for_chunks};

/// Returns `diag((H a) / a) u - H u`, like the product with stored entries.
///
/// # Cost
/// O(F^2).
pub(super) fn times<const N: usize>(
    kind: KernelKind,
    kernels: Kernels,
    faces: &[FaceDatum],
    columns: &[[f64; N]],
    many: usize,
    threads: usize,
) -> Result<Vec<[f64; N]>, NumericError> {
    let mut result = vec![[0.0; N]; columns.len()];
    for_chunks(threads, &mut result, many, |own, result| {
        check_stopped()?;
        for other in (0..faces.len()).filter(|other| *other != own) {
            let (s, t) = (&faces[own], &faces[other]);
            let entry = kernels.entry(kind, s, t);
            for k in 0..many {
                let (x, y) = (&columns[own * many + k], &columns[other * many + k]);
                (0..N).for_each(|c| result[k][c] += entry * (t.area / s.area * x[c] - y[c]));
            }
        }
        Ok::<(), NumericError>(())
    })?;
    Ok(result)
}
