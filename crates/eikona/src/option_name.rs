//! Names of options as text.

use thiserror::Error;

/// A text that names no value of an option.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("\"{text}\" is not valid; expected {expected}")]
pub struct OptionNameError {
    /// The text given.
    pub text: String,
    /// The texts that are accepted.
    pub expected: String,
}

impl OptionNameError {
    pub(crate) fn new(text: &str, expected: impl Into<String>) -> Self {
        OptionNameError { text: text.to_string(), expected: expected.into() }
    }
}

/// Implements `FromStr` and `Display` for an enum without fields, by one list of names.
macro_rules! option_names {
    ($option:ty, $($name:literal => $value:path),+ $(,)?) => {
        impl std::str::FromStr for $option {
            type Err = $crate::OptionNameError;
            fn from_str(text: &str) -> Result<Self, Self::Err> {
                match text {
                    $($name => Ok($value),)+
                    _ => Err($crate::OptionNameError::new(text, [$($name),+].join(", "))),
                }
            }
        }
        impl std::fmt::Display for $option {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(match self {
                    $($value => $name,)+
                })
            }
        }
    };
}
pub(crate) use option_names;
