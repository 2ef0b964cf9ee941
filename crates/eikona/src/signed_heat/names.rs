//! Options of the signed heat method as text, for hosts such as the command line.

use crate::OptionNameError;
use crate::option_name::option_names;
use crate::signed_heat::options::{DiffusionTime, LevelSets, SOFT_WEIGHT_RANGE, SignConvention};
use crate::signed_heat::time::TIME_COEFFICIENTS;
use std::fmt;
use std::str::FromStr;

option_names!(
    SignConvention,
    "left-negative" => SignConvention::LeftNegative,
    "left-positive" => SignConvention::LeftPositive,
);

/// `auto`, `smooth`, `gaps`, `rough-gaps` or a coefficient.
///
/// ```
/// use eikona::signed_heat::DiffusionTime;
/// assert_eq!("auto".parse(), Ok(DiffusionTime::Automatic));
/// assert_eq!("1.5".parse(), Ok(DiffusionTime::Coefficient(1.5)));
/// assert_eq!(DiffusionTime::SmoothCurves.to_string(), "smooth");
/// assert!("-1".parse::<DiffusionTime>().is_err());
/// ```
impl FromStr for DiffusionTime {
    type Err = OptionNameError;
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(match text {
            "auto" => DiffusionTime::Automatic,
            "smooth" => DiffusionTime::SmoothCurves,
            "gaps" => DiffusionTime::ForGaps,
            "rough-gaps" => DiffusionTime::ForRoughGaps,
            _ => match text.parse::<f64>() {
                Ok(c) if TIME_COEFFICIENTS.contains(&c) => DiffusionTime::Coefficient(c),
                _ => {
                    let expected = "auto, smooth or a number from 1e-9 to 1e9 (the paper uses 1)";
                    return Err(OptionNameError::new(text, expected));
                }
            },
        })
    }
}

impl fmt::Display for DiffusionTime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DiffusionTime::Coefficient(c) => write!(f, "{c}"),
            DiffusionTime::Automatic => f.write_str("auto"),
            DiffusionTime::SmoothCurves => f.write_str("smooth"),
            DiffusionTime::ForGaps => f.write_str("gaps"),
            DiffusionTime::ForRoughGaps => f.write_str("rough-gaps"),
        }
    }
}

/// The weight of `soft` without a number, which holds a curve tightly.
const SOFT_WEIGHT: f64 = 100.0;

/// `auto`, `free`, `zero`, `per-component`, `soft` or `soft=W`.
///
/// ```
/// use eikona::signed_heat::LevelSets;
/// assert_eq!("soft=3".parse(), Ok(LevelSets::Soft(3.0)));
/// assert_eq!(LevelSets::PerComponent.to_string(), "per-component");
/// assert!("soft=-1".parse::<LevelSets>().is_err());
/// ```
impl FromStr for LevelSets {
    type Err = OptionNameError;
    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(match text {
            "auto" => LevelSets::Automatic,
            "zero" => LevelSets::Zero,
            "free" => LevelSets::Free,
            "per-component" => LevelSets::PerComponent,
            "soft" => LevelSets::Soft(SOFT_WEIGHT),
            _ => match text.strip_prefix("soft=").map(str::parse::<f64>) {
                Some(Ok(w)) if SOFT_WEIGHT_RANGE.contains(&w) => LevelSets::Soft(w),
                Some(_) => {
                    let (low, high) = (SOFT_WEIGHT_RANGE.start(), SOFT_WEIGHT_RANGE.end());
                    let expected =
                        format!("soft=W with a weight W from {low:e} to {high:e}, such as soft=100");
                    return Err(OptionNameError::new(text, expected));
                }
                None => {
                    let expected = "auto, zero, soft, soft=W, per-component or free";
                    return Err(OptionNameError::new(text, expected));
                }
            },
        })
    }
}

impl fmt::Display for LevelSets {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LevelSets::Automatic => f.write_str("auto"),
            LevelSets::Free => f.write_str("free"),
            LevelSets::Zero => f.write_str("zero"),
            LevelSets::PerComponent => f.write_str("per-component"),
            LevelSets::Soft(weight) => write!(f, "soft={weight}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_survives_as_text() {
        use DiffusionTime::*;
        for time in [Automatic, SmoothCurves, ForGaps, ForRoughGaps, Coefficient(2.5)] {
            assert_eq!(time.to_string().parse(), Ok(time));
        }
        use LevelSets as L;
        for level_sets in [L::Automatic, L::Free, L::Zero, L::PerComponent, L::Soft(0.125)] {
            assert_eq!(level_sets.to_string().parse(), Ok(level_sets));
        }
        for sign in [SignConvention::LeftNegative, SignConvention::LeftPositive] {
            assert_eq!(sign.to_string().parse(), Ok(sign));
        }
        let fault = "left".parse::<SignConvention>().unwrap_err().to_string();
        assert_eq!(fault, "\"left\" is not valid; expected left-negative, left-positive");
    }
}
