//! The header of a PLY file: the elements that it declares and their properties.

use super::words::{Words, integer, shown};
use crate::error::FileError;

pub(super) const PLY: &str = "PLY";

#[derive(Clone, Copy)]
pub(super) enum Encoding {
    Ascii,
    Binary { big_endian: bool },
}

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Type {
    fn parse(word: &[u8]) -> Option<Type> {
        Some(match word {
            b"char" | b"int8" => Type::I8,
            b"uchar" | b"uint8" => Type::U8,
            b"short" | b"int16" => Type::I16,
            b"ushort" | b"uint16" => Type::U16,
            b"int" | b"int32" => Type::I32,
            b"uint" | b"uint32" => Type::U32,
            b"int64" => Type::I64,
            b"uint64" => Type::U64,
            b"float" | b"float32" => Type::F32,
            b"double" | b"float64" => Type::F64,
            _ => return None,
        })
    }
    pub fn size(self) -> usize {
        match self {
            Type::I8 | Type::U8 => 1,
            Type::I16 | Type::U16 => 2,
            Type::I32 | Type::U32 | Type::F32 => 4,
            Type::I64 | Type::U64 | Type::F64 => 8,
        }
    }
}

#[derive(Clone, Copy)]
pub(super) enum Kind {
    Scalar(Type),
    List { count: Type, item: Type },
}

pub(super) struct Property {
    pub name: String,
    pub kind: Kind,
}

pub(super) struct Element {
    pub name: String,
    pub count: usize,
    pub properties: Vec<Property>,
}

pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Bytes before the body.
    pub length: usize,
    /// Lines before the body.
    pub lines: usize,
}

impl Header {
    pub fn parse(bytes: &[u8]) -> Result<Header, FileError> {
        let mut words = Words::new(bytes);
        if words.word_on_line() != Some(b"ply") {
            return Err(words.fault(PLY, "the file does not begin with the line \"ply\""));
        }
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        while words.next_line() {
            let Some(keyword) = words.word_on_line() else { continue };
            match keyword {
                b"format" => {
                    encoding = Some(match words.word_on_line() {
                        Some(b"ascii") => Encoding::Ascii,
                        Some(b"binary_little_endian") => Encoding::Binary { big_endian: false },
                        Some(b"binary_big_endian") => Encoding::Binary { big_endian: true },
                        other => {
                            let problem = format!(
                                "unknown format {}; expected ascii, binary_little_endian or binary_big_endian",
                                shown(other.unwrap_or_default())
                            );
                            return Err(words.fault(PLY, problem));
                        }
                    });
                }
                b"element" => {
                    let name = text(words.word_on_line().unwrap_or_default());
                    let count = words.word_on_line().unwrap_or_default();
                    let count = integer(count).and_then(|n| usize::try_from(n).ok()).ok_or_else(|| {
                        words.fault(
                            PLY,
                            format!(
                                "the number of elements is {}; expected `element NAME COUNT`",
                                shown(count)
                            ),
                        )
                    })?;
                    elements.push(Element { name, count, properties: Vec::new() });
                }
                b"property" => {
                    let property = parse_property(&mut words)?;
                    let Some(element) = elements.last_mut() else {
                        return Err(words.fault(PLY, "a property precedes the first element; add an `element NAME COUNT` line before it"));
                    };
                    element.properties.push(property);
                }
                b"end_header" => {
                    let Some(encoding) = encoding else {
                        return Err(words.fault(
                            PLY,
                            "the header has no format line; add \"format ascii 1.0\" or the like",
                        ));
                    };
                    let end = bytes.len() - words.remaining();
                    let length = end + line_end(bytes, end);
                    return Ok(Header { encoding, elements, length, lines: words.line() });
                }
                // comment, obj_info, and whatever else
                _ => {}
            }
        }
        Err(words
            .fault(PLY, "the header has no line \"end_header\"; the file is truncated or not a PLY file"))
    }
}

/// Returns the number of bytes that end the header. If its lines end with a lone CR, a following LF
/// is the first byte of the data.
fn line_end(bytes: &[u8], end: usize) -> usize {
    let first = bytes.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(0);
    let lone_cr = bytes[first..].starts_with(b"\r") && !bytes[first..].starts_with(b"\r\n");
    let rest = bytes.get(end..).unwrap_or_default();
    let blanks = rest.iter().take_while(|b| matches!(b, b' ' | b'\t')).count();
    match &rest[blanks..] {
        [b'\r', b'\n', ..] if !lone_cr => blanks + 2,
        [b'\r' | b'\n', ..] => blanks + 1,
        _ => blanks,
    }
}

fn parse_property(words: &mut Words) -> Result<Property, FileError> {
    let kind = |words: &mut Words, word: Option<&[u8]>| {
        let word = word.unwrap_or_default();
        Type::parse(word).ok_or_else(|| {
            words.fault(
                PLY,
                format!(
                    "unknown type {}; expected char, uchar, short, ushort, int, uint, float or double",
                    shown(word)
                ),
            )
        })
    };
    let kind = match words.word_on_line() {
        Some(b"list") => {
            let (count, item) = (words.word_on_line(), words.word_on_line());
            Kind::List { count: kind(words, count)?, item: kind(words, item)? }
        }
        word => Kind::Scalar(kind(words, word)?),
    };
    match words.word_on_line() {
        Some(name) => Ok(Property { name: text(name), kind }),
        None => Err(words.fault(PLY, "the property has no name")),
    }
}

fn text(word: &[u8]) -> String {
    String::from_utf8_lossy(word).into_owned()
}
