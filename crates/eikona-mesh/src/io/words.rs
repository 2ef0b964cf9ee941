//! Words, lines and numbers of text formats, parsed directly from the bytes.

use crate::error::FileError;

/// Iterates over a text word by word. Lines end with LF, CR LF or CR; all other bytes up to the
/// blank separate words.
#[derive(Clone)]
pub(super) struct Words<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
    /// A byte that starts a comment up to the end of the line.
    comment: Option<u8>,
    /// Set if a backslash joins a line with the next. Returns whether the text after it begins a
    /// statement of its own, in which case the lines are not joined.
    continuation: Option<fn(&[u8]) -> bool>,
    /// The first line that was not joined for that reason.
    not_joined: Option<usize>,
}

impl<'a> Words<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Words { bytes, at: 0, line: 1, comment: None, continuation: None, not_joined: None }
    }
    /// Enables comments from `#` to the end of the line.
    pub fn with_comments(mut self) -> Self {
        self.comment = Some(b'#');
        self
    }
    /// Enables line continuation by a backslash, unless the next line begins a statement of its
    /// own.
    pub fn with_continuation(mut self, begins_statement: fn(&[u8]) -> bool) -> Self {
        self.continuation = Some(begins_statement);
        self
    }
    /// Returns the first line with a final backslash that was not joined with the next one, a
    /// statement of its own.
    pub fn not_joined(&self) -> Option<usize> {
        self.not_joined
    }
    /// Returns the line of the next word, from 1.
    pub fn line(&self) -> usize {
        self.line
    }
    /// Returns the number of remaining bytes.
    pub fn remaining(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// Returns the next word of this line, or `None` at its end.
    #[inline]
    pub fn word_on_line(&mut self) -> Option<&'a [u8]> {
        self.skip_blanks();
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&b| self.ends_word(b)).unwrap_or(rest.len());
        // A lone backslash that continues nothing is a word of its own.
        let length = if length == 0 && rest.first() == Some(&b'\\') { 1 } else { length };
        self.at += length;
        (length > 0).then(|| &rest[..length])
    }

    /// Returns the next word of this or a later line, or `None` at the end of the text.
    #[inline]
    pub fn word(&mut self) -> Option<&'a [u8]> {
        loop {
            if let Some(word) = self.word_on_line() {
                return Some(word);
            }
            if !self.next_line() {
                return None;
            }
        }
    }

    /// Advances to the next line; returns false if there is none.
    pub fn next_line(&mut self) -> bool {
        loop {
            self.skip_blanks();
            match self.bytes.get(self.at) {
                None => return false,
                Some(b'\n' | b'\r') => break self.skip_line_end(),
                Some(_) => {
                    let rest = &self.bytes[self.at..];
                    let stop = |&b: &u8| b == b'\n' || b == b'\r' || b == b'\\';
                    self.at += rest.iter().position(stop).unwrap_or(rest.len());
                    if self.bytes.get(self.at) == Some(&b'\\') && !self.skip_line_backslash() {
                        self.at += 1;
                    }
                }
            }
        }
        self.at < self.bytes.len()
    }

    /// Creates an error on the current line.
    pub fn fault(&self, format: &'static str, problem: impl Into<String>) -> FileError {
        FileError::syntax(format, format!("line {}", self.line), problem)
    }

    #[inline]
    fn ends_word(&self, b: u8) -> bool {
        b <= b' ' || (b == b'#' && self.comment.is_some()) || (b == b'\\' && self.continuation.is_some())
    }

    #[inline]
    fn skip_blanks(&mut self) {
        while let Some(&b) = self.bytes.get(self.at) {
            match b {
                b'\n' | b'\r' => return,
                _ if b <= b' ' => self.at += 1,
                b'\\' if self.skip_line_backslash() => {}
                _ if Some(b) == self.comment => {
                    let rest = &self.bytes[self.at..];
                    let end = rest.iter().position(|&b| b == b'\n' || b == b'\r');
                    self.at += end.unwrap_or(rest.len());
                }
                _ => return,
            }
        }
    }

    /// Skips a backslash at the end of a line, and the line end too if it joins the lines. Returns
    /// whether there was one.
    fn skip_line_backslash(&mut self) -> bool {
        let Some(begins_statement) = self.continuation else { return false };
        let next = match &self.bytes[self.at..] {
            [_, b'\r', b'\n', next @ ..] | [_, b'\n' | b'\r', next @ ..] => next,
            _ => return false,
        };
        self.at += 1;
        if begins_statement(next) {
            self.not_joined.get_or_insert(self.line);
        } else {
            self.skip_line_end();
        }
        true
    }

    fn skip_line_end(&mut self) {
        let crlf = self.bytes[self.at..].starts_with(b"\r\n");
        self.at += if crlf { 2 } else { 1 };
        self.line += 1;
    }
}

/// Parses a number; accepts NaN and infinities.
#[inline]
pub(super) fn number(word: &[u8]) -> Option<f64> {
    let unsigned = word.strip_prefix(b"+").unwrap_or(word);
    match fast_float2::parse(unsigned) {
        Ok(value) => Some(value),
        // Old Microsoft runtimes print NaN as 1.#QNAN or -1.#IND and infinity as 1.#INF.
        Err(_) if word.windows(2).any(|w| w == b".#") => {
            let infinite = word.ends_with(b"#INF");
            Some(if !infinite {
                f64::NAN
            } else if word.starts_with(b"-") {
                f64::NEG_INFINITY
            } else {
                f64::INFINITY
            })
        }
        Err(_) => None,
    }
}

/// Parses an integer; accepts "3.0".
#[inline]
pub(super) fn integer(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, word),
    };
    // 18 digits always fit.
    if digits.is_empty() || digits.len() > 18 || !digits.iter().all(u8::is_ascii_digit) {
        return number(word).and_then(whole);
    }
    let value = digits.iter().fold(0i64, |n, d| 10 * n + i64::from(d - b'0'));
    Some(if negative { -value } else { value })
}

/// Converts a float to the integer that it represents, if any.
#[inline]
pub(super) fn whole(value: f64) -> Option<i64> {
    // Beyond 2^53 a float no longer represents a unique integer.
    (value.fract() == 0.0 && value.abs() <= 9_007_199_254_740_992.0).then_some(value as i64)
}

/// Formats a word for an error message.
pub(super) fn shown(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text: String = String::from_utf8_lossy(word).chars().take(LONGEST).collect();
    format!("\"{}\"", text.escape_debug())
}

/// A float formatted so that it reads back bit for bit, short, and with `nan` and `inf` as in C.
pub(super) struct Number(pub f64);

impl std::fmt::Display for Number {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let x = self.0;
        if x.is_nan() {
            f.write_str("nan")
        } else if x == 0.0 || (1e-5..1e16).contains(&x.abs()) || x.is_infinite() {
            write!(f, "{x}")
        } else {
            write!(f, "{x:e}")
        }
    }
}
