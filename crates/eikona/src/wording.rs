//! Helpers for the text of messages.

/// Formats a count with its noun: "1 face", "2 faces".
pub(crate) fn counted(count: usize, one: &str, several: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { several })
}
