//! Warnings of one run.

use serde::Serialize;
use serde_json::{Map, Value};
use std::fmt;

/// A warning as it stands in the report: an object with its kind, its sentence, the file it is
/// about, and the numbers and elements of the sentence.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Warned {
    /// Stable name of the kind of warning.
    kind: String,
    /// The sentence that is printed.
    message: String,
    /// The file, curve or points that it is about.
    #[serde(skip_serializing_if = "Option::is_none")]
    subject: Option<String>,
    #[serde(flatten)]
    data: Map<String, Value>,
}

impl Warned {
    /// Creates a warning of the command itself.
    pub fn new(kind: &'static str, message: impl Into<String>) -> Warned {
        Warned { kind: kind.into(), message: message.into(), subject: None, data: Map::new() }
    }

    /// Names the file, curve or points that the warning is about, also in its sentence.
    pub fn about(mut self, subject: impl fmt::Display) -> Warned {
        self.message = format!("{subject}: {}", self.message);
        self.subject = Some(subject.to_string());
        self
    }

    /// Adds a number or element of the sentence.
    pub fn with(mut self, name: &str, value: impl Serialize) -> Warned {
        self.data.insert(name.into(), serde_json::to_value(value).unwrap_or_default());
        self
    }

    /// Returns the kind.
    pub fn kind(&self) -> &str {
        &self.kind
    }

    /// Returns the sentence.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// Converts a warning of a library, which serializes its fields.
    fn of_library(kind: &str, warning: &(impl fmt::Display + Serialize)) -> Warned {
        let mut data = match serde_json::to_value(warning) {
            Ok(Value::Object(fields)) => fields,
            _ => Map::new(),
        };
        data.remove("kind");
        Warned { kind: kind.into(), message: warning.to_string(), subject: None, data }
    }
}

impl From<&eikona::Warning> for Warned {
    fn from(warning: &eikona::Warning) -> Warned {
        Warned::of_library(warning.kind(), warning)
    }
}

impl From<&eikona_mesh::FileWarning> for Warned {
    fn from(warning: &eikona_mesh::FileWarning) -> Warned {
        Warned::of_library(warning.kind(), warning)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eikona::Warning;
    use eikona::mesh::Face;

    #[test]
    fn a_warning_of_the_library_keeps_its_fields() {
        let warning = Warning::UnreachedComponent { component: 2, faces: 5, first: Face(7) };
        let warned = Warned::from(&warning).about("a.obj");
        let json = serde_json::to_value(&warned).unwrap();
        assert_eq!(json["kind"], "unreached_component");
        assert_eq!(json["subject"], "a.obj");
        assert_eq!(json["first"]["face"], 7);
        assert_eq!(json["message"].as_str().unwrap(), format!("a.obj: {warning}"));
    }
}
