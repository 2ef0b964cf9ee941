//! Numbers on the command line: what is out of range is refused before any work, with the range.

fn number(text: &str, fits: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    text.trim()
        .parse()
        .ok()
        .filter(|x: &f64| x.is_finite() && fits(*x))
        .ok_or(format!("{expected} is expected"))
}

/// Any number but NaN and infinity.
pub fn finite(text: &str) -> Result<f64, String> {
    number(text, |_| true, "a finite number")
}

/// A length, a spacing, a factor.
pub fn above_zero(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0, "a number above 0")
}

/// An amount that may be nothing.
pub fn zero_or_more(text: &str) -> Result<f64, String> {
    number(text, |x| x >= 0.0, "a number that is 0 or more")
}

/// A part of a whole.
pub fn share(text: &str) -> Result<f64, String> {
    number(text, |x| (0.0..=1.0).contains(&x), "a share from 0 to 1")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_of_the_ranges() {
        assert_eq!(
            (finite("-1e3"), above_zero("1e-300"), zero_or_more("0")),
            (Ok(-1e3), Ok(1e-300), Ok(0.0))
        );
        assert_eq!((share("0"), share("1")), (Ok(0.0), Ok(1.0)));
        for bad in ["", "x", "nan", "inf", "-inf"] {
            assert!(finite(bad).is_err() && above_zero(bad).is_err() && zero_or_more(bad).is_err(), "{bad}");
        }
        assert!(above_zero("0").is_err() && zero_or_more("-1").is_err() && share("1.01").is_err());
    }
}
