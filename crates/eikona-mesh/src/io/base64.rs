//! Base64 as used in glTF and VTK files. Implemented here because VTK concatenates separately
//! padded pieces, which decoders of whole texts reject.

const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

const NO_DIGIT: u8 = 64;

/// The value of each letter; `-` and `_` belong to the URL alphabet.
const DIGIT: [u8; 256] = {
    let mut digit = [NO_DIGIT; 256];
    let mut value = 0;
    while value < 64 {
        digit[ALPHABET[value] as usize] = value as u8;
        value += 1;
    }
    digit[b'-' as usize] = 62;
    digit[b'_' as usize] = 63;
    digit
};

/// Encodes bytes, with padding.
pub(super) fn encode(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let byte = |k: usize| u32::from(group.get(k).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for k in 0..4 {
            let digit = ALPHABET[(bits >> (18 - 6 * k)) as usize & 63];
            text.push(if k <= group.len() { char::from(digit) } else { '=' });
        }
    }
    text
}

/// Decodes piece by piece; skips blanks and line ends, and allows padding after any group of four.
pub(super) struct Decoder<'a> {
    text: &'a [u8],
    /// Bytes of the last group that were not requested yet.
    pending: [u8; 3],
    pending_count: usize,
}

impl<'a> Decoder<'a> {
    pub fn new(text: &'a [u8]) -> Self {
        Decoder { text, pending: [0; 3], pending_count: 0 }
    }

    /// Returns the next bytes, or `None` if there are fewer or a letter is not base64.
    pub fn read(&mut self, count: usize) -> Option<Vec<u8>> {
        if count > self.text.len() / 4 * 3 + 6 {
            return None;
        }
        let mut bytes = Vec::with_capacity(count);
        while bytes.len() < count {
            if self.pending_count == 0 {
                self.read_plain_groups(count, &mut bytes);
                if bytes.len() == count {
                    break;
                }
                self.next_group()?;
            }
            let taken = self.pending_count.min(count - bytes.len());
            bytes.extend_from_slice(&self.pending[..taken]);
            self.pending.rotate_left(taken);
            self.pending_count -= taken;
        }
        Some(bytes)
    }

    /// Returns all remaining bytes.
    pub fn read_all(mut self) -> Option<Vec<u8>> {
        let mut bytes = self.pending[..self.pending_count].to_vec();
        bytes.reserve(self.text.len() / 4 * 3);
        loop {
            self.read_plain_groups(usize::MAX, &mut bytes);
            self.text = self.text.trim_ascii_start();
            if self.text.is_empty() {
                return Some(bytes);
            }
            self.next_group()?;
            bytes.extend_from_slice(&self.pending[..self.pending_count]);
        }
    }

    /// Decodes uninterrupted groups of four digits while all their bytes are requested: the bulk of
    /// a text.
    fn read_plain_groups(&mut self, count: usize, bytes: &mut Vec<u8>) {
        while let Some((group, rest)) = self.text.split_first_chunk::<4>() {
            let digits = group.map(|letter| DIGIT[usize::from(letter)]);
            if digits.contains(&NO_DIGIT) || count - bytes.len() < 3 {
                return;
            }
            let [_, three @ ..] = digits.iter().fold(0, |bits, &d| bits << 6 | u32::from(d)).to_be_bytes();
            bytes.extend_from_slice(&three);
            self.text = rest;
        }
    }

    fn next_group(&mut self) -> Option<()> {
        let (mut bits, mut digits, mut padding) = (0, 0, 0);
        while digits + padding < 4 {
            let Some((&letter, rest)) = self.text.split_first() else {
                // Data URIs may omit the final padding.
                if digits < 2 {
                    return None;
                }
                padding = 4 - digits;
                break;
            };
            self.text = rest;
            let digit = match letter {
                b'=' if digits >= 2 => {
                    padding += 1;
                    continue;
                }
                b' ' | b'\t' | b'\r' | b'\n' => continue,
                _ => DIGIT[usize::from(letter)],
            };
            if digit == NO_DIGIT {
                return None;
            }
            if padding > 0 {
                return None;
            }
            bits = bits << 6 | u32::from(digit);
            digits += 1;
        }
        let [_, bytes @ ..] = (bits << (6 * padding)).to_be_bytes();
        self.pending = bytes;
        self.pending_count = digits - 1;
        Some(())
    }
}
