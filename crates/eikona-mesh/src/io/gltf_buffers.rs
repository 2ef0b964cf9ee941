//! The data behind the accessors of a glTF file, with all offsets checked.

use super::base64::Decoder;
use super::gltf::{GLTF, Root};
use crate::error::FileError;
use serde::Deserialize;
use std::borrow::Cow;
use std::cell::Cell;
use std::fs;
use std::io::ErrorKind;
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
    sparse: Option<Sparse>,
}

/// Replacements for some elements of an accessor.
#[derive(Deserialize)]
struct Sparse {
    count: usize,
    indices: SparseIndices,
    values: SparseValues,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct SparseIndices {
    buffer_view: usize,
    #[serde(default)]
    byte_offset: usize,
    component_type: u32,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct SparseValues {
    buffer_view: usize,
    #[serde(default)]
    byte_offset: usize,
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

/// The accessors of a file and their data.
pub(super) struct Data<'a> {
    root: &'a Root,
    /// The buffers, or why one is unusable: a file may refer to buffers that its geometry does not
    /// need.
    buffers: Vec<Result<Cow<'a, [u8]>, String>>,
    /// Number of elements that accessors without data may still create.
    zeros_left: Cell<usize>,
}

/// The location of elements in a buffer view.
struct Place {
    view: usize,
    offset: usize,
    count: usize,
    size: usize,
    /// Whether the stride of the view applies.
    strided: bool,
}

impl<'a> Data<'a> {
    /// Loads all buffers: from the binary chunk of a `.glb`, from data URIs, or from files in
    /// `folder`.
    pub fn load(root: &'a Root, binary: Option<&'a [u8]>, folder: Option<&Path>) -> Self {
        let load = |(b, buffer): (usize, &Buffer)| {
            let bytes = match (&buffer.uri, binary) {
                (Some(uri), _) => Cow::Owned(match uri.strip_prefix("data:") {
                    Some(data) => inline(data).ok_or("its data URI is not base64")?,
                    None => beside(uri, folder)?,
                }),
                (None, Some(binary)) if b == 0 => Cow::Borrowed(binary),
                _ => return Err("it has neither a URI nor a binary chunk".to_string()),
            };
            if bytes.len() < buffer.byte_length {
                return Err(format!(
                    "it has {1} bytes instead of {0}; it is truncated",
                    buffer.byte_length,
                    bytes.len()
                ));
            }
            Ok(bytes)
        };
        let buffers: Vec<Result<Cow<[u8]>, String>> = root.buffers.iter().enumerate().map(load).collect();
        const ZEROS: usize = 1 << 20;
        let bytes: usize = buffers.iter().flatten().map(|b| b.len()).sum();
        Data { root, buffers, zeros_left: Cell::new(bytes.max(ZEROS)) }
    }

    /// Returns whether an accessor has one component.
    pub fn is_scalar(&self, accessor: usize) -> bool {
        self.root.accessors.get(accessor).is_some_and(|a| a.shape == "SCALAR")
    }

    /// Returns whether an accessor refers to no data.
    pub fn is_empty(&self, accessor: usize) -> bool {
        self.root.accessors.get(accessor).is_some_and(|a| a.buffer_view.is_none() && a.sparse.is_none())
    }

    /// Returns the number of elements that an accessor declares.
    pub fn count(&self, accessor: usize) -> usize {
        self.root.accessors.get(accessor).map_or(0, |a| a.count)
    }

    /// Returns vectors of N components; normalized integers are mapped to [0, 1] or [-1, 1].
    pub fn floats<const N: usize>(&self, accessor: usize, user: &str) -> Result<Vec<[f64; N]>, FileError> {
        let (accessor, mut values) = self.elements(accessor, user)?;
        let scale = match (accessor.normalized, accessor.component_type) {
            (true, 5120) => 1.0 / 127.0,
            (true, 5121) => 1.0 / 255.0,
            (true, 5122) => 1.0 / 32767.0,
            (true, 5123) => 1.0 / 65535.0,
            _ => return Ok(values),
        };
        values.as_flattened_mut().iter_mut().for_each(|x| *x = (*x * scale).max(-1.0));
        Ok(values)
    }

    /// Returns vertex indices.
    pub fn indices(&self, accessor: usize, user: &str) -> Result<Vec<i64>, FileError> {
        if let Some(kind) = self.root.accessors.get(accessor).map(|a| a.component_type)
            && !matches!(kind, 5121 | 5123 | 5125)
        {
            let problem =
                format!("component type {kind} is not valid for indices; expected 5121, 5123 or 5125");
            return Err(FileError::syntax(GLTF, format!("accessor {accessor}"), problem));
        }
        let (_, values) = self.elements::<1>(accessor, user)?;
        Ok(values.into_iter().map(|[x]| x as i64).collect())
    }

    /// Returns the unscaled values of an accessor: from its view, or zeros without one, then the
    /// sparse ones.
    fn elements<const N: usize>(
        &self,
        index: usize,
        user: &str,
    ) -> Result<(&'a Accessor, Vec<[f64; N]>), FileError> {
        let fault = |problem: String| FileError::syntax(GLTF, format!("accessor {index} ({user})"), problem);
        let accessors = &self.root.accessors;
        let accessor = accessors.get(index).ok_or_else(|| {
            fault(format!("it does not exist: there are {}, numbered from 0", accessors.len()))
        })?;
        let expected = if N == 3 { "VEC3" } else { "SCALAR" };
        if accessor.shape != expected {
            return Err(fault(format!("its type is \"{}\", expected {expected}", accessor.shape)));
        }
        let kind = accessor.component_type;
        let component_size = component_size(kind).ok_or_else(|| {
            fault(format!("unknown component type {kind}; expected 5120 to 5123, 5125 or 5126"))
        })?;
        let size = N * component_size;
        let vector = |bytes: &[u8]| {
            let mut values = [0.0; N];
            for (value, bytes) in values.iter_mut().zip(bytes.chunks_exact(component_size)) {
                *value = component(bytes, kind);
            }
            values
        };
        let count = accessor.count;
        let mut values: Vec<[f64; N]> = match accessor.buffer_view {
            Some(view) => {
                let place = Place { view, offset: accessor.byte_offset, count, size, strided: true };
                self.bytes(place, &fault)?.map(vector).collect()
            }
            None => {
                let left = self.zeros_left.get().checked_sub(count).ok_or_else(|| {
                    fault(format!("it has no buffer view, and {count} zeros are too many for such a file"))
                })?;
                self.zeros_left.set(left);
                vec![[0.0; N]; count]
            }
        };
        if let Some(Sparse { count, indices, values: replacing }) = &accessor.sparse {
            let kind = indices.component_type;
            let index_size = component_size_of_index(kind).ok_or_else(|| {
                fault(format!(
                    "component type {kind} is not valid for sparse indices; expected 5121, 5123 or 5125"
                ))
            })?;
            let place = |view, offset, size| Place { view, offset, count: *count, size, strided: false };
            let places = self.bytes(place(indices.buffer_view, indices.byte_offset, index_size), &fault)?;
            let replacing = self.bytes(place(replacing.buffer_view, replacing.byte_offset, size), &fault)?;
            for (i, value) in places.map(|bytes| component(bytes, kind) as usize).zip(replacing) {
                let elements = values.len();
                *values.get_mut(i).ok_or_else(|| {
                    fault(format!(
                        "its sparse index {i} is out of range: there are {elements} elements, numbered from 0"
                    ))
                })? = vector(value);
            }
        }
        Ok((accessor, values))
    }

    /// Returns the bytes of each element.
    fn bytes(
        &self,
        place: Place,
        fault: &dyn Fn(String) -> FileError,
    ) -> Result<impl Iterator<Item = &[u8]>, FileError> {
        let Place { view, offset, count, size, strided } = place;
        let views = &self.root.buffer_views;
        let view = views.get(view).ok_or_else(|| {
            fault(format!("buffer view {view} does not exist: there are {}, numbered from 0", views.len()))
        })?;
        let stride = view.byte_stride.filter(|_| strided).unwrap_or(size);
        if stride < size {
            return Err(fault(format!("its elements have {size} bytes but a stride of {stride}")));
        }
        let past_end = || fault("its buffer view extends past the end of its buffer".into());
        let buffer = self.buffers.get(view.buffer).ok_or_else(past_end)?.as_ref();
        let buffer = buffer.map_err(|why| FileError::syntax(GLTF, format!("buffer {}", view.buffer), why))?;
        let bytes = buffer
            .get(view.byte_offset..)
            .and_then(|b| b.get(..view.byte_length)?.get(offset..))
            .ok_or_else(past_end)?;
        let needed = match count {
            0 => Some(0),
            n => (n - 1).checked_mul(stride).and_then(|b| b.checked_add(size)),
        };
        if needed.is_none_or(|n| n > bytes.len()) {
            let problem = format!(
                "it declares {count} elements of {size} bytes, but the view has {} bytes for them",
                bytes.len()
            );
            return Err(fault(problem));
        }
        // The last element may be shorter than the stride.
        Ok(bytes.chunks(stride).take(count).filter_map(move |e| e.get(..size)))
    }
}

fn component_size(kind: u32) -> Option<usize> {
    match kind {
        5120 | 5121 => Some(1),
        5122 | 5123 => Some(2),
        5125 | 5126 => Some(4),
        _ => None,
    }
}

fn component_size_of_index(kind: u32) -> Option<usize> {
    component_size(kind).filter(|_| matches!(kind, 5121 | 5123 | 5125))
}

fn component(bytes: &[u8], kind: u32) -> f64 {
    match (kind, bytes) {
        (5120, &[a]) => f64::from(a as i8),
        (5121, &[a]) => f64::from(a),
        (5122, &[a, b]) => f64::from(i16::from_le_bytes([a, b])),
        (5123, &[a, b]) => f64::from(u16::from_le_bytes([a, b])),
        (5125, &[a, b, c, d]) => f64::from(u32::from_le_bytes([a, b, c, d])),
        (5126, &[a, b, c, d]) => f64::from(f32::from_le_bytes([a, b, c, d])),
        _ => f64::NAN, // `elements` has matched sizes and types
    }
}

/// Decodes a data URI without its "data:".
fn inline(data: &str) -> Option<Vec<u8>> {
    let (kind, text) = data.split_once(',')?;
    if kind.ends_with(";base64") { Decoder::new(text.as_bytes()).read_all() } else { None }
}

/// Reads the file at a URI, or returns why that fails.
fn beside(uri: &str, folder: Option<&Path>) -> Result<Vec<u8>, String> {
    let Some(folder) = folder else {
        return Err(format!(
            "its data is in another file, \"{uri}\"; read the glTF file by its path, or convert it to .glb"
        ));
    };
    let name = PathBuf::from(percent_decoded(uri));
    let plain = name.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
    if !plain || uri.contains("://") {
        return Err(format!(
            "its file \"{uri}\" is not in the folder of the glTF file; put it there, or convert the file to .glb"
        ));
    }
    fs::read(folder.join(&name)).map_err(|fault| {
        let name = name.display();
        if fault.kind() == ErrorKind::NotFound {
            format!(
                "its file {name} does not exist; put it next to the glTF file, or export the mesh as .glb"
            )
        } else {
            format!("its file {name} can not be read ({fault})")
        }
    })
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
