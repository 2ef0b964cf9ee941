//! Diagnosis of ascii PLY files whose lines do not match the properties in the header.

use super::ply_header::{Element, Kind, PLY};
use super::words::Words;
use crate::error::FileError;

/// Finds the first line whose number of values differs from the number of properties of its
/// element.
///
/// Applies only if the body has at least one line per element: then the properties in the header
/// are wrong rather than the counts, and reading value by value would shift the coordinates.
/// `before` is the number of lines before the body.
///
/// # Cost
/// O(bytes).
pub(super) fn misfit(body: &[u8], before: usize, elements: &[Element]) -> Option<FileError> {
    let mut lines = Vec::new();
    let mut words = Words::new(body);
    loop {
        let line = words.line();
        let values = std::iter::from_fn(|| words.word_on_line()).count();
        if values > 0 {
            lines.push((line, values));
        }
        if !words.next_line() {
            break;
        }
    }
    let declared = elements.iter().try_fold(0usize, |n, e| n.checked_add(e.count))?;
    if lines.len() < declared {
        return None;
    }
    let mut rest = lines.as_slice();
    for element in elements {
        let (own, others) = rest.split_at(element.count);
        rest = others;
        let expected = element.properties.len();
        if element.properties.iter().any(|p| matches!(p.kind, Kind::List { .. })) {
            continue;
        }
        if let Some((line, values)) = own.iter().find(|(_, values)| *values != expected) {
            let problem = format!(
                "the line has {values} values, but the header declares {expected} properties per {}; correct the header",
                element.name
            );
            return Some(FileError::syntax(PLY, format!("line {}", before + line), problem));
        }
    }
    None
}
