//! The numbers behind the accessors of a glTF file, every offset checked.

use super::base64::Decoder;
use super::gltf::{GLTF, Root};
use crate::error::FileError;
use serde::Deserialize;
use std::borrow::Cow;
use std::fs;
use std::path::{Component, Path, PathBuf};

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Accessor {
    buffer_view: Option<usize>,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
    #[serde(default)]
    normalized: bool,
    count: usize,
    #[serde(rename = "type")]
    shape: String,
    sparse: Option<serde::de::IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct BufferView {
    buffer: usize,
    #[serde(default)]
    byte_offset: usize,
    byte_length: usize,
    byte_stride: Option<usize>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Buffer {
    uri: Option<String>,
    byte_length: usize,
}

/// The accessors of a file with the bytes behind them.
pub(super) struct Data<'a> {
    root: &'a Root,
    buffers: Vec<Cow<'a, [u8]>>,
}

/// `count` elements of `size` bytes, `stride` bytes apart.
struct Elements<'a> {
    accessor: &'a Accessor,
    bytes: &'a [u8],
    stride: usize,
    size: usize,
}

impl<'a> Data<'a> {
    /// Gets all buffers: from the binary chunk of a `.glb`, from data URIs, or from files in `folder`.
    pub fn load(root: &'a Root, binary: Option<&'a [u8]>, folder: Option<&Path>) -> Result<Self, FileError> {
        let mut buffers = Vec::with_capacity(root.buffers.len());
        for (b, buffer) in root.buffers.iter().enumerate() {
            let fault = |problem: String| FileError::syntax(GLTF, format!("buffer {b}"), problem);
            let bytes = match (&buffer.uri, binary) {
                (Some(uri), _) => match uri.strip_prefix("data:") {
                    Some(data) => {
                        Cow::Owned(inline(data).ok_or_else(|| fault("its data URI is not base64".into()))?)
                    }
                    None => Cow::Owned(beside(uri, folder)?),
                },
                (None, Some(binary)) if b == 0 => Cow::Borrowed(binary),
                _ => return Err(fault("it has neither a URI nor a binary chunk".into())),
            };
            if bytes.len() < buffer.byte_length {
                let problem = format!(
                    "{} bytes are announced, but it has {}; it is cut off",
                    buffer.byte_length,
                    bytes.len()
                );
                return Err(fault(problem));
            }
            buffers.push(bytes);
        }
        Ok(Data { root, buffers })
    }

    /// Whether an accessor has one component.
    pub fn is_scalar(&self, accessor: usize) -> bool {
        self.root.accessors.get(accessor).is_some_and(|a| a.shape == "SCALAR")
    }

    /// Vectors of N components; normalized integers are mapped to [0, 1] or [-1, 1].
    pub fn floats<const N: usize>(&self, accessor: usize, user: &str) -> Result<Vec<[f64; N]>, FileError> {
        let elements = self.elements(accessor, N, user)?;
        let kind = elements.accessor.component_type;
        let scale = match (elements.accessor.normalized, kind) {
            (true, 5120) => 1.0 / 127.0,
            (true, 5121) => 1.0 / 255.0,
            (true, 5122) => 1.0 / 32767.0,
            (true, 5123) => 1.0 / 65535.0,
            _ => 1.0,
        };
        let size = elements.size / N;
        Ok(elements
            .iter()
            .map(|e| {
                let mut values = [0.0; N];
                for (value, bytes) in values.iter_mut().zip(e.chunks_exact(size)) {
                    *value = component(bytes, kind);
                    if scale != 1.0 {
                        *value = (*value * scale).max(-1.0);
                    }
                }
                values
            })
            .collect())
    }

    /// Vertex indices.
    pub fn indices(&self, accessor: usize, user: &str) -> Result<Vec<i64>, FileError> {
        let elements = self.elements(accessor, 1, user)?;
        let kind = elements.accessor.component_type;
        if !matches!(kind, 5121 | 5123 | 5125) {
            let problem = format!("component type {kind} is none of indices; 5121, 5123 and 5125 are");
            return Err(FileError::syntax(GLTF, format!("accessor {accessor}"), problem));
        }
        Ok(elements.iter().map(|e| component(e, kind) as i64).collect())
    }

    fn elements(&self, index: usize, components: usize, user: &str) -> Result<Elements<'_>, FileError> {
        let fault = |problem: String| FileError::syntax(GLTF, format!("accessor {index} ({user})"), problem);
        let accessors = &self.root.accessors;
        let accessor = accessors.get(index).ok_or_else(|| {
            fault(format!("it does not exist: there are {}, numbered from 0", accessors.len()))
        })?;
        if accessor.sparse.is_some() {
            return Err(FileError::Unsupported(format!(
                "accessor {index} ({user}) is sparse, which is not read; export the file without sparse accessors"
            )));
        }
        let expected = if components == 3 { "VEC3" } else { "SCALAR" };
        if accessor.shape != expected {
            return Err(fault(format!("its type is \"{}\", expected {expected}", accessor.shape)));
        }
        let component_size = match accessor.component_type {
            5120 | 5121 => 1,
            5122 | 5123 => 2,
            5125 | 5126 => 4,
            other => {
                return Err(fault(format!("component type {other} is not known; 5120 to 5126 but 5124 are")));
            }
        };
        let size = components * component_size;
        let Some(view) = accessor.buffer_view else {
            return Err(FileError::Unsupported(format!(
                "accessor {index} ({user}) has no buffer view, so its data are compressed or missing; export the file without compression"
            )));
        };
        let views = &self.root.buffer_views;
        let view = views.get(view).ok_or_else(|| {
            fault(format!("it names buffer view {view}, but there are {}, numbered from 0", views.len()))
        })?;
        let stride = view.byte_stride.unwrap_or(size);
        if stride < size {
            return Err(fault(format!("its elements have {size} bytes, but lie {stride} bytes apart")));
        }
        let bytes = self
            .buffers
            .get(view.buffer)
            .and_then(|b| b.get(view.byte_offset..)?.get(..view.byte_length)?.get(accessor.byte_offset..))
            .ok_or_else(|| fault("its buffer view reaches past the end of its buffer".into()))?;
        let needed = match accessor.count {
            0 => Some(0),
            n => (n - 1).checked_mul(stride).and_then(|b| b.checked_add(size)),
        };
        if needed.is_none_or(|n| n > bytes.len()) {
            let problem = format!(
                "{} elements of {size} bytes are announced, but the view has {} bytes for them",
                accessor.count,
                bytes.len()
            );
            return Err(fault(problem));
        }
        Ok(Elements { accessor, bytes, stride, size })
    }
}

impl<'a> Elements<'a> {
    fn iter(&self) -> impl Iterator<Item = &'a [u8]> {
        // The last element may be shorter than the stride.
        self.bytes.chunks(self.stride).take(self.accessor.count).filter_map(|e| e.get(..self.size))
    }
}

fn component(bytes: &[u8], kind: u32) -> f64 {
    match (kind, bytes) {
        (5120, &[a]) => f64::from(a as i8),
        (5121, &[a]) => f64::from(a),
        (5122, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
        (5123, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
        (5125, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (5126, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => f64::NAN, // sizes and types have been matched in `elements`
    }
}

/// The bytes of a data URI without its "data:".
fn inline(data: &str) -> Option<Vec<u8>> {
    let (kind, text) = data.split_once(',')?;
    if kind.ends_with(";base64") { Decoder::new(text.as_bytes()).read_all() } else { None }
}

/// The bytes of a file that a URI names.
fn beside(uri: &str, folder: Option<&Path>) -> Result<Vec<u8>, FileError> {
    let Some(folder) = folder else {
        return Err(FileError::Unsupported(format!(
            "the buffer \"{uri}\" is another file; read the glTF file by its path, or convert it to .glb"
        )));
    };
    let name = PathBuf::from(percent_decoded(uri));
    let plain = name.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
    if !plain || uri.contains("://") {
        return Err(FileError::Unsupported(format!(
            "the buffer \"{uri}\" does not lie in the folder of the glTF file; put it there, or convert the file to .glb"
        )));
    }
    let path = folder.join(name);
    fs::read(&path).map_err(|fault| FileError::io(&path, fault))
}

fn percent_decoded(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let code = after
            .get(..2)
            .and_then(|hex| std::str::from_utf8(hex).ok())
            .and_then(|hex| u8::from_str_radix(hex, 16).ok());
        match code {
            Some(byte) if first == b'%' => {
                bytes.push(byte);
                rest = &after[2..];
            }
            _ => {
                bytes.push(first);
                rest = after;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
