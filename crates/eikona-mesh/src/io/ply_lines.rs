//! Ascii PLY whose lines do not have the values that the header announces.

use super::ply_header::{Element, Kind, PLY};
use super::words::Words;
use crate::error::FileError;

/// The first line that has another number of values than its element, if the body has a line for every element: then not the
/// counts but the properties in the header are wrong, and reading value after value would shift the coordinates. `before` is
/// the number of lines before the body.
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
    let announced = elements.iter().try_fold(0usize, |n, e| n.checked_add(e.count))?;
    if lines.len() < announced {
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
                "there are {values} values, but the header announces {expected} properties for each {}; correct the header",
                element.name
            );
            return Some(FileError::syntax(PLY, format!("line {}", before + line), problem));
        }
    }
    None
}
