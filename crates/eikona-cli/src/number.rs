//! Parsers of numbers and of named options on the command line. They check ranges before any work,
//! and errors state the range.

use eikona::OptionNameError;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// Parses an option by the names that the library gives to its values.
pub fn named<T: FromStr<Err = OptionNameError>>(text: &str) -> Result<T, String> {
    text.parse().map_err(|fault: OptionNameError| format!("expected {}", fault.expected))
}

fn number(text: &str, fits: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite() && fits(*x)).ok_or(format!("expected {expected}"))
}

/// Parses any finite number.
pub fn finite(text: &str) -> Result<f64, String> {
    number(text, |_| true, "a finite number")
}

/// Parses a number above 0.
pub fn above_zero(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0, "a number above 0")
}

/// Parses a number of 0 or more.
pub fn zero_or_more(text: &str) -> Result<f64, String> {
    number(text, |x| x >= 0.0, "a number of 0 or more")
}

/// Parses a share from 0 to 1.
pub fn share(text: &str) -> Result<f64, String> {
    number(text, |x| (0.0..=1.0).contains(&x), "a share from 0 to 1")
}

/// Parses a number in a range that the library defines.
pub fn within(text: &str, range: &RangeInclusive<f64>) -> Result<f64, String> {
    let expected = format!("a number from {} to {}", brief(*range.start()), brief(*range.end()));
    number(text, |x| range.contains(&x), &expected)
}

/// Formats a number as briefly as is exact: "1e-9", "0.5", "1".
pub fn brief(x: f64) -> String {
    let text = format!("{x:?}");
    text.strip_suffix(".0").unwrap_or(&text).to_string()
}

/// Formats a number with this many decimals, or with an exponent if `size`, the largest of the
/// numbers shown together, would lose its leading digits.
pub fn rounded(x: f64, digits: usize, size: f64) -> String {
    const LARGE: f64 = 1e9;
    /// Significant digits to show at least.
    const FIGURES: i32 = 3;
    let small = 10f64.powi(FIGURES - 1 - digits as i32);
    let size = size.abs();
    if size == 0.0 || (small..LARGE).contains(&size) {
        format!("{x:.digits$}")
    } else {
        format!("{x:.digits$e}")
    }
}

/// Writes an index as a signed multiple of 1/N in lowest terms, such as +1/4.
pub fn fraction(index: f64, degree: u32) -> String {
    let (turns, n) = ((index * f64::from(degree)).round() as i64, i64::from(degree));
    let (mut divisor, mut rest) = (n, turns.abs());
    while rest != 0 {
        (divisor, rest) = (rest, divisor % rest);
    }
    match n / divisor {
        1 => format!("{:+}", turns / divisor),
        denominator => format!("{:+}/{denominator}", turns / divisor),
    }
}

/// Parses a number of bytes, with an optional unit.
pub fn bytes(text: &str) -> Result<usize, String> {
    const UNITS: [(&str, f64); 9] = [
        ("KiB", 1024.0),
        ("MiB", 1048576.0),
        ("GiB", 1073741824.0),
        ("TiB", 1099511627776.0),
        ("kB", 1e3),
        ("KB", 1e3),
        ("MB", 1e6),
        ("GB", 1e9),
        ("TB", 1e12),
    ];
    let unit = UNITS.iter().find_map(|(name, bytes)| Some((text.strip_suffix(name)?, *bytes)));
    let (number, unit) = unit.unwrap_or((text, 1.0));
    match number.trim().parse::<f64>() {
        Ok(x) if x >= 0.0 && (x * unit).is_finite() => Ok((x * unit) as usize),
        _ => Err("expected a size such as 2GiB, 500MB or 1000000".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_include_their_ends() {
        assert_eq!(
            (finite("-1e3"), above_zero("1e-300"), zero_or_more("0")),
            (Ok(-1e3), Ok(1e-300), Ok(0.0))
        );
        assert_eq!((share("0"), share("1")), (Ok(0.0), Ok(1.0)));
        for bad in ["", "x", "nan", "inf", "-inf"] {
            assert!(finite(bad).is_err() && above_zero(bad).is_err() && zero_or_more(bad).is_err(), "{bad}");
        }
        assert_eq!((within("1e-9", &(1e-9..=1.0)), within("1", &(1e-9..=1.0))), (Ok(1e-9), Ok(1.0)));
        assert_eq!(within("9e-10", &(1e-9..=1.0)), Err("expected a number from 1e-9 to 1".into()));
        assert!(above_zero("0").is_err() && zero_or_more("-1").is_err() && share("1.01").is_err());
    }

    #[test]
    fn small_and_large_numbers_use_an_exponent() {
        let own = |x: f64| rounded(x, 6, x);
        assert_eq!(
            [own(0.0), own(1.5), own(-1e-4), own(5e8)],
            ["0.000000", "1.500000", "-0.000100", "500000000.000000"]
        );
        assert_eq!([own(9e-5), own(-1e-20), own(1e9)], ["9.000000e-5", "-1.000000e-20", "1.000000e9"]);
        assert_eq!([rounded(1e-9, 3, 1.0), rounded(1e-9, 3, 2e-9)], ["0.000", "1.000e-9"]);
        assert_eq!([brief(1e-20), brief(2.0), brief(0.25)], ["1e-20", "2", "0.25"]);
    }
}
