//! glTF 2.0 writer: one mesh of triangles and lines, with a custom attribute per scalar.

use super::MeshOut;
use super::base64;
use super::output::one_word;
use super::rounding;
use serde_json::{Value, json};
use std::collections::HashMap;
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
/// its node. Vertices on seams of texture coordinates are written once per pair of coordinates, the
/// copies after all others.
pub(super) fn write_glb(out: &mut dyn Write, mesh: &MeshOut) -> io::Result<()> {
    let parts = Parts::of(mesh);
    write_glb_head(out, &parts.root(None), parts.bytes.len())?;
    out.write_all(&parts.bytes)
}

/// Writes all that precedes the binary data, which has so many bytes (a multiple of four).
pub(super) fn write_glb_head(out: &mut dyn Write, root: &Value, binary: usize) -> io::Result<()> {
    let mut json = serde_json::to_vec(root)?;
    // Chunks end at multiples of four: JSON is padded with blanks. All numbers have four bytes.
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = u32::try_from(12 + 8 + json.len() + 8 + binary)
        .map_err(|_| io::Error::new(io::ErrorKind::FileTooLarge, "a .glb holds at most 4 GiB"))?;
    out.write_all(b"glTF")?;
    for word in [2, total, json.len() as u32, u32::from_le_bytes(*b"JSON")] {
        out.write_all(&word.to_le_bytes())?;
    }
    out.write_all(&json)?;
    out.write_all(&(binary as u32).to_le_bytes())?;
    out.write_all(b"BIN\0")
}

/// Writes the same as JSON, with the buffer as a data URI.
pub(super) fn write_gltf(out: &mut dyn Write, mesh: &MeshOut) -> io::Result<()> {
    let parts = Parts::of(mesh);
    let uri = format!("data:application/octet-stream;base64,{}", base64::encode(&parts.bytes));
    serde_json::to_writer(out, &parts.root(Some(uri)))?;
    Ok(())
}

type Bounds = ([f32; 3], [f32; 3]);

#[derive(Default)]
pub(super) struct Parts {
    /// The offset subtracted from the positions: the translation of the node.
    pub offset: [f64; 3],
    /// The vertex of the mesh that each written one is.
    pub origins: Vec<u32>,
    /// The positions as written.
    pub positions: Vec<[f32; 3]>,
    pub bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    pub primitives: Vec<Value>,
}

impl Parts {
    pub fn of(mesh: &MeshOut) -> Parts {
        let mut parts = Parts::default();
        let positions = mesh.positions();
        if positions.is_empty() {
            return parts; // glTF has no empty accessors
        }
        let mut attributes = serde_json::Map::new();
        let offset = rounding::offset(positions);
        parts.offset = offset;
        let Corners { origins, vertices, uvs } = Corners::of(mesh);
        let rounded = |v: &u32| [0, 1, 2].map(|k| (positions[*v as usize][k] - offset[k]) as f32);
        parts.positions = origins.iter().map(rounded).collect();
        let position = parts.add_points(parts.positions.clone().into_iter());
        attributes.insert("POSITION".into(), position.into());
        let count = origins.len();
        for (name, values) in &mesh.vertex_scalars {
            let bytes = origins.iter().flat_map(|&v| (values[v as usize] as f32).to_le_bytes());
            let accessor = parts.add(bytes, count, FLOAT, "SCALAR", Some(ARRAY_BUFFER), None);
            attributes.insert(format!("_{}", one_word(name)), accessor.into());
        }
        if let Some(colours) = mesh.vertex_colours {
            let of_origins = origins.iter().flat_map(|&v| colours[v as usize]);
            let bytes = of_origins.flat_map(|c| linear(c).to_le_bytes());
            let accessor = parts.add(bytes, count, FLOAT, "VEC3", Some(ARRAY_BUFFER), None);
            attributes.insert("COLOR_0".into(), accessor.into());
        }
        if mesh.corner_uvs.is_some() {
            // v runs downwards in glTF.
            let bytes =
                uvs.iter().flat_map(|[u, v]| [*u as f32, (1.0 - v) as f32]).flat_map(f32::to_le_bytes);
            let accessor = parts.add(bytes, count, FLOAT, "VEC2", Some(ARRAY_BUFFER), None);
            attributes.insert("TEXCOORD_0".into(), accessor.into());
        }
        parts.origins = origins;
        parts.add_primitive(&attributes, vertices.into_iter(), TRIANGLES);
        let segments = mesh.lines.iter().flat_map(|line| line.windows(2)).flatten().copied();
        parts.add_primitive(&attributes, segments, LINES);
        // Without this, isolated vertices would be lost. Lines of one node join nothing.
        if parts.primitives.is_empty() {
            parts.primitives.push(json!({ "attributes": attributes, "mode": POINTS }));
        }
        parts
    }

    /// Appends points of vertices and returns their accessor.
    pub fn add_points(&mut self, points: impl Iterator<Item = [f32; 3]> + Clone) -> usize {
        // The bounds must be those of the rounded values.
        let bounds = bounds(points.clone());
        let count = points.clone().count();
        let bytes = points.flatten().flat_map(f32::to_le_bytes);
        self.add(bytes, count, FLOAT, "VEC3", Some(ARRAY_BUFFER), Some(bounds))
    }

    /// Appends an array and returns its accessor.
    fn add(
        &mut self,
        bytes: impl Iterator<Item = u8>,
        count: usize,
        component: u32,
        shape: &str,
        target: Option<u32>,
        bounds: Option<Bounds>,
    ) -> usize {
        let start = self.bytes.len(); // a multiple of four: all numbers have four bytes
        self.bytes.extend(bytes);
        let accessor = self.declare([start, self.bytes.len()], count, component, shape, target);
        if let Some((least, most)) = bounds {
            self.accessors[accessor]["min"] = json!(least);
            self.accessors[accessor]["max"] = json!(most);
        }
        accessor
    }

    /// Describes an array from a start to an end, and returns its accessor.
    fn declare(
        &mut self,
        [start, end]: [usize; 2],
        count: usize,
        component: u32,
        shape: &str,
        target: Option<u32>,
    ) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": start, "byteLength": end - start });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.views.push(view);
        self.accessors.push(json!({
            "bufferView": self.views.len() - 1, "componentType": component, "count": count, "type": shape
        }));
        self.accessors.len() - 1
    }

    /// Describes an array of floats that is written later, and returns its accessor and its end.
    pub fn declare_floats(
        &mut self,
        start: usize,
        count: usize,
        (shape, width): (&str, usize),
        bounds: Option<(Value, Value)>,
    ) -> (usize, usize) {
        let end = start + 4 * width * count;
        let target = (shape == "VEC3").then_some(ARRAY_BUFFER);
        let accessor = self.declare([start, end], count, FLOAT, shape, target);
        if let Some((least, most)) = bounds {
            self.accessors[accessor]["min"] = least;
            self.accessors[accessor]["max"] = most;
        }
        (accessor, end)
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
        let accessor = self.add(bytes, count, UNSIGNED_INT, "SCALAR", Some(ELEMENT_ARRAY_BUFFER), None);
        self.primitives.push(json!({ "attributes": attributes, "indices": accessor, "mode": mode }));
    }

    pub fn root(&self, uri: Option<String>) -> Value {
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

/// Returns the least and the largest coordinates.
pub(super) fn bounds(points: impl Iterator<Item = [f32; 3]> + Clone) -> Bounds {
    let bound = |pick: fn(f32, f32) -> f32, start: f32| {
        points.clone().fold([start; 3], |b, p| [0, 1, 2].map(|k| pick(b[k], p[k])))
    };
    (bound(f32::min, f32::INFINITY), bound(f32::max, f32::NEG_INFINITY))
}

/// The corners of faces as glTF has them: texture coordinates belong to vertices.
struct Corners {
    /// The vertex of the mesh that each vertex is. Those of the mesh keep their numbers.
    origins: Vec<u32>,
    /// The vertices of the faces.
    vertices: Vec<u32>,
    /// The texture coordinates of the vertices, if the mesh has any.
    uvs: Vec<[f64; 2]>,
}

impl Corners {
    fn of(mesh: &MeshOut) -> Corners {
        let mut origins: Vec<u32> = (0..mesh.positions().len() as u32).collect();
        let mut vertices: Vec<u32> = mesh.faces().flatten().copied().collect();
        let Some(of_corners) = mesh.corner_uvs else { return Corners { origins, vertices, uvs: Vec::new() } };
        let mut uvs = vec![[0.0; 2]; origins.len()];
        let mut taken = vec![false; origins.len()];
        let mut copies: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
        for (v, uv) in vertices.iter_mut().zip(of_corners) {
            // As written: corners that differ only by rounding share a vertex.
            let key = (*v, uv.map(|x| (x as f32).to_bits()));
            let origin = *v as usize;
            *v = *copies.entry(key).or_insert_with(|| {
                if !std::mem::replace(&mut taken[origin], true) {
                    uvs[origin] = *uv;
                    return origin as u32;
                }
                origins.push(origin as u32);
                uvs.push(*uv);
                origins.len() as u32 - 1
            });
        }
        Corners { origins, vertices, uvs }
    }
}

/// Converts an sRGB value in 255ths to linear (IEC 61966-2-1).
fn linear(srgb: u8) -> f32 {
    let s = f32::from(srgb) / 255.0;
    if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
}
