//! Base64 as glTF and VTK files hold it. Own code, because VTK joins pieces that were padded one by one, which decoders of
//! whole texts refuse.

const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// The text of these bytes, padded.
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

/// Decodes piece by piece; blanks and line ends are passed over, padding may stand after any group of four.
pub(super) struct Decoder<'a> {
    text: &'a [u8],
    /// Bytes of the last group that were not asked for yet.
    pending: [u8; 3],
    pending_count: usize,
}

impl<'a> Decoder<'a> {
    pub fn new(text: &'a [u8]) -> Self {
        Decoder { text, pending: [0; 3], pending_count: 0 }
    }

    /// The next bytes, or `None` when there are not so many or a letter is none of base64.
    pub fn read(&mut self, count: usize) -> Option<Vec<u8>> {
        if count > self.text.len() / 4 * 3 + 6 {
            return None;
        }
        let mut bytes = Vec::with_capacity(count);
        while bytes.len() < count {
            if self.pending_count == 0 {
                self.next_group()?;
            }
            let taken = self.pending_count.min(count - bytes.len());
            bytes.extend_from_slice(&self.pending[..taken]);
            self.pending.rotate_left(taken);
            self.pending_count -= taken;
        }
        Some(bytes)
    }

    /// All bytes that are left.
    pub fn read_all(mut self) -> Option<Vec<u8>> {
        let mut bytes = self.pending[..self.pending_count].to_vec();
        bytes.reserve(self.text.len() / 4 * 3);
        while !self.text.trim_ascii_start().is_empty() {
            self.next_group()?;
            bytes.extend_from_slice(&self.pending[..self.pending_count]);
        }
        Some(bytes)
    }

    fn next_group(&mut self) -> Option<()> {
        let (mut bits, mut digits, mut padding) = (0, 0, 0);
        while digits + padding < 4 {
            let Some((&letter, rest)) = self.text.split_first() else {
                // Data URIs may leave the last padding out.
                if digits < 2 {
                    return None;
                }
                padding = 4 - digits;
                break;
            };
            self.text = rest;
            let digit = match letter {
                b'A'..=b'Z' => letter - b'A',
                b'a'..=b'z' => letter - b'a' + 26,
                b'0'..=b'9' => letter - b'0' + 52,
                b'+' | b'-' => 62,
                b'/' | b'_' => 63,
                b'=' if digits >= 2 => {
                    padding += 1;
                    continue;
                }
                b' ' | b'\t' | b'\r' | b'\n' => continue,
                _ => return None,
            };
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
