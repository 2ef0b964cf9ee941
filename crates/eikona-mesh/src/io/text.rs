//! Text encodings. The readers need bytes in which digits and keywords are ASCII.

use std::borrow::Cow;

/// Decodes UTF-16 and UTF-32 to UTF-8 and strips a byte-order mark; returns all other bytes
/// unchanged.
///
/// Windows programs and PowerShell's `>` write UTF-16.
///
/// Both are recognised by their byte-order mark or, without one, by the zero bytes of the first two
/// characters. Invalid code units become U+FFFD.
///
/// ```
/// use eikona_mesh::io::decode_text;
/// assert_eq!(*decode_text(b"\xff\xfev\0 \01\0"), *b"v 1");
/// assert_eq!(*decode_text(b"\xef\xbb\xbfv 1"), *b"v 1");
/// assert_eq!(*decode_text(b"v 1"), *b"v 1");
/// ```
///
/// # Cost
/// O(1) for UTF-8, O(bytes) otherwise.
pub fn decode_text(bytes: &[u8]) -> Cow<'_, [u8]> {
    let text = match Encoding::of(bytes) {
        Encoding::Bytes => return Cow::Borrowed(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)),
        Encoding::Utf16(order) => {
            let units = bytes.as_chunks().0.iter().map(|&pair| match order {
                Order::Little => u16::from_le_bytes(pair),
                Order::Big => u16::from_be_bytes(pair),
            });
            char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect::<String>()
        }
        Encoding::Utf32(order) => {
            let units = bytes.as_chunks().0.iter().map(|&four| match order {
                Order::Little => u32::from_le_bytes(four),
                Order::Big => u32::from_be_bytes(four),
            });
            units.map(|u| char::from_u32(u).unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
        }
    };
    const MARK: char = '\u{feff}';
    Cow::Owned(text.strip_prefix(MARK).map(str::to_owned).unwrap_or(text).into_bytes())
}

/// Returns whether the bytes are UTF-16 or UTF-32. Binary data does not survive conversion to
/// either.
pub(super) fn is_wide(bytes: &[u8]) -> bool {
    !matches!(Encoding::of(bytes), Encoding::Bytes)
}

#[derive(Clone, Copy)]
enum Order {
    Little,
    Big,
}

/// The encoding of a file.
enum Encoding {
    /// UTF-8, another superset of ASCII, or binary.
    Bytes,
    Utf16(Order),
    Utf32(Order),
}

impl Encoding {
    fn of(bytes: &[u8]) -> Encoding {
        use Order::{Big, Little};
        let ascii = |b: u8| matches!(b, b'\t' | b'\n' | b'\r' | b' '..=b'~');
        match *bytes {
            // Text has no NUL after the mark of UTF-16, so this is the mark of UTF-32.
            [0xff, 0xfe, 0, 0, ..] => Encoding::Utf32(Little),
            [0, 0, 0xfe, 0xff, ..] => Encoding::Utf32(Big),
            [0xff, 0xfe, ..] => Encoding::Utf16(Little),
            [0xfe, 0xff, ..] => Encoding::Utf16(Big),
            [a, 0, 0, 0, b, 0, 0, 0, ..] if ascii(a) && ascii(b) => Encoding::Utf32(Little),
            [0, 0, 0, a, 0, 0, 0, b, ..] if ascii(a) && ascii(b) => Encoding::Utf32(Big),
            [a, 0, b, 0, ..] if ascii(a) && ascii(b) => Encoding::Utf16(Little),
            [0, a, 0, b, ..] if ascii(a) && ascii(b) => Encoding::Utf16(Big),
            _ => Encoding::Bytes,
        }
    }
}
