//! The data arrays of a VTK XML file: ascii, base64 or raw; inline or appended; plain or in zlib
//! blocks.

use super::base64::Decoder;
use super::words::{Words, number, shown, whole};
use crate::error::FileError;
use roxmltree::Node;
use std::borrow::Cow;
use std::io::Read;

pub(super) const VTP: &str = "VTP";

/// Returns an attribute without surrounding blanks, with which some programs reserve space for
/// numbers.
pub(super) fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Option<&'a str> {
    node.attribute(name).map(str::trim)
}

/// Returns all text of an element, including that after comments and child elements.
fn text<'a>(array: Node<'a, '_>) -> Cow<'a, str> {
    let mut parts = array.children().filter(Node::is_text).filter_map(|n| n.text());
    let first = parts.next().unwrap_or_default();
    parts.fold(Cow::Borrowed(first), |text, part| Cow::Owned(text.into_owned() + " " + part))
}

/// Separates the XML from the appended data, which need not be text and begins after the
/// underscore.
pub(super) fn split_appended(bytes: &[u8]) -> Result<(String, &[u8]), FileError> {
    const TAG: &[u8] = b"<AppendedData";
    const LATIN: &[u8] = b"ISO-8859-1";
    let tag = bytes.windows(TAG.len()).position(|w| w == TAG);
    let (xml, appended) = match tag {
        None => (bytes.to_vec(), &[][..]),
        Some(tag) => {
            let rest = &bytes[tag..];
            let body = rest.iter().position(|&b| b == b'>').map(|end| end + 1).unwrap_or(rest.len());
            let data = rest[body..].iter().position(|&b| b == b'_').map(|u| body + u + 1);
            // The opening tag stays, for its encoding.
            let mut xml = bytes[..tag + body].to_vec();
            xml.extend_from_slice(b"</AppendedData></VTKFile>");
            (xml, data.and_then(|start| rest.get(start..)).unwrap_or_default())
        }
    };
    let xml = String::from_utf8(xml).or_else(|fault| {
        let place = fault.utf8_error().valid_up_to();
        let xml = fault.into_bytes();
        let declaration = xml.split(|&b| b == b'>').next().unwrap_or_default();
        if declaration.windows(LATIN.len()).any(|w| w.eq_ignore_ascii_case(LATIN)) {
            // Latin-1 coincides with the first 256 code points of Unicode.
            return Ok(xml.into_iter().map(char::from).collect());
        }
        Err(FileError::syntax(
            VTP,
            format!("byte {place}"),
            "the XML is not UTF-8; check that this is a VTP file",
        ))
    })?;
    Ok((xml, appended))
}

#[derive(Clone, Copy, PartialEq)]
enum Storage {
    Base64,
    Raw,
}

/// How the arrays of a file are stored.
pub(super) struct Arrays<'a> {
    appended: &'a [u8],
    appended_storage: Storage,
    big_endian: bool,
    /// Bytes per number in the headers of arrays.
    header: usize,
    compressed: bool,
}

/// Bytes that are returned piece by piece.
enum Source<'a> {
    Base64(Decoder<'a>),
    Raw(&'a [u8]),
}

impl Source<'_> {
    fn read(&mut self, count: usize) -> Option<Vec<u8>> {
        match self {
            Source::Base64(decoder) => decoder.read(count),
            Source::Raw(bytes) => {
                let (taken, rest) = bytes.split_at_checked(count)?;
                *bytes = rest;
                Some(taken.to_vec())
            }
        }
    }
}

impl<'a> Arrays<'a> {
    pub fn new(file: Node, appended: &'a [u8]) -> Result<Self, FileError> {
        let compressed = match attribute(file, "compressor") {
            None | Some("") => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => {
                return Err(FileError::Unsupported(format!(
                    "the compressor {other} is not supported; save the file uncompressed or with zlib"
                )));
            }
        };
        let section = file.children().find(|n| n.has_tag_name("AppendedData"));
        let raw = section.is_some_and(|s| attribute(s, "encoding") == Some("raw"));
        Ok(Arrays {
            appended,
            appended_storage: if raw { Storage::Raw } else { Storage::Base64 },
            big_endian: attribute(file, "byte_order") == Some("BigEndian"),
            header: if attribute(file, "header_type") == Some("UInt64") { 8 } else { 4 },
            compressed,
        })
    }

    /// Returns whether the appended data is raw bytes.
    pub fn has_raw_data(&self) -> bool {
        self.appended_storage == Storage::Raw
    }

    pub fn integers(&self, array: Node) -> Result<Vec<i64>, FileError> {
        let values = self.floats(array)?;
        let mut integers = Vec::with_capacity(values.len());
        for value in values {
            integers.push(whole(value).ok_or_else(|| fault(array, format!("{value} is not an integer")))?);
        }
        Ok(integers)
    }

    /// Returns whether an array contains numbers of a known type.
    pub fn is_numeric(array: Node) -> bool {
        const TYPES: [&str; 11] = [
            "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64", "Float32", "Float64",
            "Bit",
        ];
        let is_ascii = attribute(array, "format").is_none_or(|f| f == "ascii");
        attribute(array, "type").map_or(is_ascii, |kind| TYPES.contains(&kind))
    }

    /// Returns the numbers of an array. Bits are padded to whole bytes.
    pub fn floats(&self, array: Node) -> Result<Vec<f64>, FileError> {
        match attribute(array, "format").unwrap_or("ascii") {
            "ascii" => {
                let text = text(array);
                let mut words = Words::new(text.as_bytes());
                let mut values = Vec::new();
                while let Some(word) = words.word() {
                    values.push(
                        number(word)
                            .ok_or_else(|| fault(array, format!("{} is not a number", shown(word))))?,
                    );
                }
                Ok(values)
            }
            "binary" => self.decode(array, Source::Base64(Decoder::new(text(array).as_bytes()))),
            "appended" => {
                let given = attribute(array, "offset").unwrap_or_default();
                let offset: usize = given.parse().map_err(|_| {
                    fault(array, format!("its offset is \"{given}\", expected an integer of 0 or more"))
                })?;
                let start = self.appended.get(offset..).ok_or_else(|| {
                    let length = self.appended.len();
                    fault(
                        array,
                        format!("its offset {offset} is past the end of the appended data, which has {length} bytes"),
                    )
                })?;
                let source = match self.appended_storage {
                    Storage::Base64 => Source::Base64(Decoder::new(start)),
                    Storage::Raw => Source::Raw(start),
                };
                self.decode(array, source)
            }
            other => {
                Err(fault(array, format!("unknown format \"{other}\"; expected ascii, binary or appended")))
            }
        }
    }

    fn decode(&self, array: Node, mut source: Source) -> Result<Vec<f64>, FileError> {
        let cut_off =
            || fault(array, "its data ends early or is not base64; the file is truncated or damaged".into());
        let mut length = || {
            let bytes = source.read(self.header)?;
            let value = bytes.iter().enumerate().fold(0u64, |n, (i, &b)| {
                let shift = if self.big_endian { bytes.len() - 1 - i } else { i };
                n | u64::from(b) << (8 * shift)
            });
            usize::try_from(value).ok()
        };
        let bytes = if self.compressed {
            let blocks = length().ok_or_else(cut_off)?;
            if blocks == 0 {
                return Ok(Vec::new()); // the rest of the header differs between writers
            }
            let (size, last) = (length().ok_or_else(cut_off)?, length().ok_or_else(cut_off)?);
            let mut compressed = Vec::new();
            for _ in 0..blocks {
                compressed.push(length().ok_or_else(cut_off)?);
            }
            let mut bytes = Vec::new();
            for (i, &stored) in compressed.iter().enumerate() {
                let block = source.read(stored).ok_or_else(cut_off)?;
                let expected = if i + 1 == blocks && last > 0 { last } else { size };
                let before = bytes.len();
                // One extra byte detects a block that is too long.
                let read = flate2::read::ZlibDecoder::new(block.as_slice())
                    .take((expected as u64).saturating_add(1))
                    .read_to_end(&mut bytes);
                if read.is_err() || bytes.len() - before != expected {
                    return Err(fault(array, format!("its zlib block {i} is damaged")));
                }
            }
            bytes
        } else {
            let length = length().ok_or_else(cut_off)?;
            source.read(length).ok_or_else(cut_off)?
        };
        self.numbers(array, &bytes)
    }

    fn numbers(&self, array: Node, bytes: &[u8]) -> Result<Vec<f64>, FileError> {
        match attribute(array, "type").unwrap_or_default() {
            "Bit" => {
                Ok(bytes.iter().flat_map(|b| (0..8).rev().map(move |k| f64::from(b >> k & 1))).collect())
            }
            "Int8" => self.each(array, bytes, |b: [u8; 1]| f64::from(b[0] as i8)),
            "UInt8" => self.each(array, bytes, |b: [u8; 1]| f64::from(b[0])),
            "Int16" => self.each(array, bytes, |b| f64::from(i16::from_le_bytes(b))),
            "UInt16" => self.each(array, bytes, |b| f64::from(u16::from_le_bytes(b))),
            "Int32" => self.each(array, bytes, |b| f64::from(i32::from_le_bytes(b))),
            "UInt32" => self.each(array, bytes, |b| f64::from(u32::from_le_bytes(b))),
            "Int64" => self.each(array, bytes, |b| i64::from_le_bytes(b) as f64),
            "UInt64" => self.each(array, bytes, |b| u64::from_le_bytes(b) as f64),
            "Float32" => self.each(array, bytes, |b| f64::from(f32::from_le_bytes(b))),
            "Float64" => self.each(array, bytes, f64::from_le_bytes),
            other => Err(fault(
                array,
                format!("unknown type \"{other}\"; expected Int8 to UInt64, Float32 or Float64"),
            )),
        }
    }

    fn each<const N: usize>(
        &self,
        array: Node,
        bytes: &[u8],
        value: impl Fn([u8; N]) -> f64,
    ) -> Result<Vec<f64>, FileError> {
        let (numbers, rest) = bytes.as_chunks::<N>();
        if !rest.is_empty() {
            return Err(fault(array, format!("{} bytes are not a multiple of {N} bytes", bytes.len())));
        }
        let turned = |mut b: [u8; N]| {
            if self.big_endian {
                b.reverse();
            }
            b
        };
        Ok(numbers.iter().map(|&b| value(turned(b))).collect())
    }
}

fn fault(array: Node, problem: String) -> FileError {
    let name = attribute(array, "Name").unwrap_or("without a name");
    let parent = array.parent().map_or("", |p| p.tag_name().name());
    FileError::syntax(VTP, format!("{parent}, array {name}"), problem)
}
