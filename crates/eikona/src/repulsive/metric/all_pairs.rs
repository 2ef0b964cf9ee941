//! Kernel matrices whose entries are computed in each product, for all pairs of faces: the exact
//! inner product, to compare with and for small meshes.

use super::kernel::{Kernels, Which};
use crate::repulsive::faces::FaceDatum;
use eikona_numeric::{NumericError, check_stopped, together};

/// Returns `diag((H a) / a) u - H u`, like the product with stored entries.
///
/// # Cost
/// O(F^2).
pub(super) fn times<const N: usize>(
    which: Which,
    kernels: Kernels,
    faces: &[FaceDatum],
    columns: &[[f64; N]],
    many: usize,
    threads: usize,
) -> Result<Vec<[f64; N]>, NumericError> {
    let mut result = vec![[0.0; N]; columns.len()];
    let share = faces.len().div_ceil(threads.max(1)).max(1);
    let tasks = result.chunks_mut(share * many).enumerate().map(|(i, result)| {
        move || -> Result<(), NumericError> {
            for (j, result) in result.chunks_mut(many).enumerate() {
                check_stopped()?;
                let own = i * share + j;
                for other in (0..faces.len()).filter(|other| *other != own) {
                    let (s, t) = (&faces[own], &faces[other]);
                    let entry = kernels.entry(which, s, t);
                    for k in 0..many {
                        let (x, y) = (&columns[own * many + k], &columns[other * many + k]);
                        (0..N).for_each(|c| result[k][c] += entry * (t.area / s.area * x[c] - y[c]));
                    }
                }
            }
            Ok(())
        }
    });
    together(tasks.collect::<Vec<_>>()).into_iter().collect::<Result<(), NumericError>>()?;
    Ok(result)
}
