//! Selection of isoline levels.

use super::ContourError;
use eikona_mesh::round_step;

/// Largest number of levels that a spacing may give.
pub const MAX_LEVELS: usize = 10_000;

/// Returns all multiples of `spacing` within the range of the values, in increasing order.
/// Nonfinite values are ignored.
///
/// ```
/// use eikona::contour::spaced_levels;
/// assert_eq!(spaced_levels(&[-1.2, f64::NAN, 0.9], 0.5)?, [-1.0, -0.5, 0.0, 0.5]);
/// # Ok::<(), eikona::contour::ContourError>(())
/// ```
///
/// # Errors
/// [`ContourError::Parameter`] if the spacing is not positive and finite, or so small that there
/// are more than [`MAX_LEVELS`] levels.
pub fn spaced_levels(values: &[f64], spacing: f64) -> Result<Vec<f64>, ContourError> {
    let refuse = |bound| Err(ContourError::Parameter { name: "spacing", value: spacing, bound });
    if !(spacing > 0.0 && spacing.is_finite()) {
        return refuse("it must be above 0 and finite");
    }
    let Some([low, high]) = finite_range(values) else { return Ok(Vec::new()) };
    let (first, last) = ((low / spacing).ceil(), (high / spacing).floor());
    let span = last - first;
    if !span.is_finite() || span >= MAX_LEVELS as f64 {
        return refuse("it would give more than 10,000 levels; make it larger");
    }
    let count = (span + 1.0).max(0.0) as usize;
    // Adding 0 turns -0 into 0.
    Ok((0..count).map(|k| (first + k as f64) * spacing + 0.0).collect())
}

/// Returns about `count` levels within the range of the values, at multiples of 1, 2 or 5 times a
/// power of ten.
///
/// ```
/// use eikona::contour::round_levels;
/// assert_eq!(round_levels(&[-1.0, 1.0], 5)?, [-1.0, -0.5, 0.0, 0.5, 1.0]);
/// # Ok::<(), eikona::contour::ContourError>(())
/// ```
///
/// # Errors
/// As [`spaced_levels`].
pub fn round_levels(values: &[f64], count: usize) -> Result<Vec<f64>, ContourError> {
    let Some([low, high]) = finite_range(values) else { return Ok(Vec::new()) };
    let raw = (high - low) / count.max(1) as f64;
    if !(raw > 0.0 && raw.is_finite()) {
        return Ok(vec![low]);
    }
    spaced_levels(values, round_step(high - low, count.max(1) as f64))
}

fn finite_range(values: &[f64]) -> Option<[f64; 2]> {
    let finite = values.iter().copied().filter(|x| x.is_finite());
    finite.map(|x| [x, x]).reduce(|[low, high], [x, _]| [low.min(x), high.max(x)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_spacings_are_refused() {
        for spacing in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-300] {
            assert!(spaced_levels(&[0.0, 1.0], spacing).is_err(), "{spacing}");
        }
        assert_eq!(spaced_levels(&[0.1, 0.9], 1.0).unwrap(), [0.0; 0]);
        assert!(spaced_levels(&[-f64::MAX, f64::MAX], 1.0).is_err());
    }

    #[test]
    fn round_levels_have_about_the_requested_count() {
        for exponent in [-200, -3, 0, 7, 200] {
            let size = 10f64.powi(exponent);
            let levels = round_levels(&[-0.37 * size, 0.61 * size], 12).unwrap();
            assert!((6..=24).contains(&levels.len()), "{} at {size:e}", levels.len());
            assert!(levels.contains(&0.0));
        }
        assert_eq!(round_levels(&[2.0, 2.0], 12).unwrap(), [2.0]);
        assert!(round_levels(&[f64::NAN], 12).unwrap().is_empty());
    }
}
