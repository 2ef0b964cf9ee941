//! How counts and round numbers are shown.

/// Returns a count with its noun.
///
/// ```
/// use eikona_mesh::counted;
/// assert_eq!(counted(1, "vertex", "vertices"), "1 vertex");
/// assert_eq!(counted(0, "face was", "faces were") + " flipped", "0 faces were flipped");
/// ```
pub fn counted(count: usize, one: &str, several: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { several })
}

/// Returns the round number (1, 2 or 5 times a power of ten) that divides the span into about
/// `count` parts.
///
/// ```
/// use eikona_mesh::round_step;
/// assert_eq!(round_step(10.0, 5.0), 2.0);
/// ```
pub fn round_step(span: f64, count: f64) -> f64 {
    let raw = (span / count).clamp(1e-300, 1e300);
    let power = 10f64.powf(raw.log10().floor());
    let fraction = raw / power;
    power
        * if fraction < 1.5 {
            1.0
        } else if fraction < 3.5 {
            2.0
        } else if fraction < 7.5 {
            5.0
        } else {
            10.0
        }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_steps() {
        assert_eq!(round_step(10.0, 5.0), 2.0);
        assert_eq!(round_step(1.0, 10.0), 0.1);
        assert!((round_step(4.7e-6, 10.0) - 5e-7).abs() < 1e-20);
        assert!(round_step(f64::INFINITY, 3.0).is_finite());
        assert!(round_step(0.0, 3.0) > 0.0);
    }
}
