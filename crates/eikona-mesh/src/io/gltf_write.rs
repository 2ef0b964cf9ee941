//! glTF 2.0 writer: one mesh of triangles and lines, with a custom attribute per scalar.

use super::MeshOut;
use super::base64;
use super::output::one_word;
use super::rounding;
use serde_json::{Value, json};
use std::io::{self, Write};

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const POINTS: u32 = 0;
const LINES: u32 = 1;
const TRIANGLES: u32 = 4;

/// Writes a `.glb`. Positions and scalars are 32-bit floats, as glTF requires; a scalar `name` is
/// the attribute `_name`. NaN in a scalar is written as is, though strict validators complain: any
/// number in its place would be wrong. Colours are converted to linear, as glTF defines them, and
/// stored as floats, because MeshLab misreads 16-bit ones. Lines are a second primitive over the
/// same vertices. A mesh far from the origin is stored relative to an offset, the translation of
/// its node.
pub(super) fn write_glb(out: &mut dyn Write, mesh: &MeshOut) -> io::Result<()> {
    let mut parts = Parts::of(mesh);
    let mut json = serde_json::to_vec(&parts.root(None))?;
    // Chunks end at multiples of four: JSON is padded with blanks, binary with zeros.
    json.resize(json.len().next_multiple_of(4), b' ');
    parts.bytes.resize(parts.bytes.len().next_multiple_of(4), 0);
    let total = 12 + 8 + json.len() + 8 + parts.bytes.len();
    let total = u32::try_from(total)
        .map_err(|_| io::Error::new(io::ErrorKind::FileTooLarge, "a .glb holds at most 4 GiB; write PLY"))?;
    out.write_all(b"glTF")?;
    for word in [2, total, json.len() as u32, u32::from_le_bytes(*b"JSON")] {
        out.write_all(&word.to_le_bytes())?;
    }
    out.write_all(&json)?;
    out.write_all(&(parts.bytes.len() as u32).to_le_bytes())?;
    out.write_all(b"BIN\0")?;
    out.write_all(&parts.bytes)
}

/// Writes the same as JSON, with the buffer as a data URI.
pub(super) fn write_gltf(out: &mut dyn Write, mesh: &MeshOut) -> io::Result<()> {
    let parts = Parts::of(mesh);
    let uri = format!("data:application/octet-stream;base64,{}", base64::encode(&parts.bytes));
    serde_json::to_writer(out, &parts.root(Some(uri)))?;
    Ok(())
}

#[derive(Default)]
struct Parts {
    /// The offset subtracted from the positions: the translation of the node.
    offset: [f64; 3],
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    primitives: Vec<Value>,
}

impl Parts {
    fn of(mesh: &MeshOut) -> Parts {
        let mut parts = Parts::default();
        let positions = mesh.positions();
        if positions.is_empty() {
            return parts; // glTF has no empty accessors
        }
        let mut attributes = serde_json::Map::new();
        let offset = rounding::offset(positions);
        parts.offset = offset;
        let rounded = |p: &[f64; 3]| [0, 1, 2].map(|k| (p[k] - offset[k]) as f32);
        let floats = positions.iter().flat_map(rounded);
        // The bounds must be those of the rounded values.
        let bound = |pick: fn(f32, f32) -> f32, start: f32| {
            positions.iter().map(rounded).fold([start; 3], |b, p| [0, 1, 2].map(|k| pick(b[k], p[k])))
        };
        let bounds = Some((bound(f32::min, f32::INFINITY), bound(f32::max, f32::NEG_INFINITY)));
        let position = parts.add(
            floats.flat_map(f32::to_le_bytes),
            positions.len(),
            FLOAT,
            "VEC3",
            ARRAY_BUFFER,
            bounds,
        );
        attributes.insert("POSITION".into(), position.into());
        for (name, values) in &mesh.vertex_scalars {
            let bytes = values.iter().flat_map(|&x| (x as f32).to_le_bytes());
            let accessor = parts.add(bytes, values.len(), FLOAT, "SCALAR", ARRAY_BUFFER, None);
            attributes.insert(format!("_{}", one_word(name)), accessor.into());
        }
        if let Some(colours) = mesh.vertex_colours {
            let bytes = colours.iter().flatten().flat_map(|&c| linear(c).to_le_bytes());
            let accessor = parts.add(bytes, colours.len(), FLOAT, "VEC3", ARRAY_BUFFER, None);
            attributes.insert("COLOR_0".into(), accessor.into());
        }
        let corners = mesh.faces().flatten().copied();
        parts.add_primitive(&attributes, corners, TRIANGLES);
        let segments = mesh.lines.iter().flat_map(|line| line.windows(2)).flatten().copied();
        parts.add_primitive(&attributes, segments, LINES);
        // Without this, isolated vertices would be lost. Lines of one node join nothing.
        if parts.primitives.is_empty() {
            parts.primitives.push(json!({ "attributes": attributes, "mode": POINTS }));
        }
        parts
    }

    /// Appends an array and returns its accessor.
    fn add(
        &mut self,
        bytes: impl Iterator<Item = u8>,
        count: usize,
        component: u32,
        shape: &str,
        target: u32,
        bounds: Option<([f32; 3], [f32; 3])>,
    ) -> usize {
        let start = self.bytes.len(); // a multiple of four: all numbers have four bytes
        self.bytes.extend(bytes);
        self.views.push(json!({
            "buffer": 0, "byteOffset": start, "byteLength": self.bytes.len() - start, "target": target
        }));
        let mut accessor = json!({
            "bufferView": self.views.len() - 1, "componentType": component, "count": count, "type": shape
        });
        if let Some((least, most)) = bounds {
            accessor["min"] = json!(least);
            accessor["max"] = json!(most);
        }
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// Appends a primitive, if it has any indices.
    fn add_primitive(
        &mut self,
        attributes: &serde_json::Map<String, Value>,
        indices: impl Iterator<Item = u32>,
        mode: u32,
    ) {
        let indices: Vec<u32> = indices.collect();
        if indices.is_empty() {
            return;
        }
        let count = indices.len();
        let bytes = indices.into_iter().flat_map(u32::to_le_bytes);
        let accessor = self.add(bytes, count, UNSIGNED_INT, "SCALAR", ELEMENT_ARRAY_BUFFER, None);
        self.primitives.push(json!({ "attributes": attributes, "indices": accessor, "mode": mode }));
    }

    fn root(&self, uri: Option<String>) -> Value {
        let mut root =
            json!({ "asset": { "version": "2.0", "generator": "eikona" }, "scene": 0, "scenes": [{}] });
        if self.primitives.is_empty() {
            return root;
        }
        root["scenes"] = json!([{ "nodes": [0] }]);
        root["nodes"] = json!([{ "mesh": 0 }]);
        if self.offset != [0.0; 3] {
            root["nodes"][0]["translation"] = json!(self.offset);
        }
        root["meshes"] = json!([{ "primitives": self.primitives }]);
        root["accessors"] = json!(self.accessors);
        root["bufferViews"] = json!(self.views);
        let mut buffer = json!({ "byteLength": self.bytes.len() });
        if let Some(uri) = uri {
            buffer["uri"] = uri.into();
        }
        root["buffers"] = json!([buffer]);
        root
    }
}

/// Converts an sRGB value in 255ths to linear (IEC 61966-2-1).
fn linear(srgb: u8) -> f32 {
    let s = f32::from(srgb) / 255.0;
    if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}
