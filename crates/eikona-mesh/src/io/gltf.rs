//! glTF 2.0 reader: the geometry of a scene as one mesh.
//!
//! Own reader: the iterators of the crate gltf 1.4 add offsets without overflow checks, never end
//! at stride 0 and panic on some damaged files, such as a length of 0 in the header. It also
//! rejects JSON padded with zeros or in UTF-16. Only a small part of glTF is geometry.

use super::gltf_buffers::{Accessor, Buffer, BufferView, Data};
use super::text::decode_text;
use super::{MeshFile, gltf_scene};
use crate::error::FileError;
use crate::warning::FileWarning;
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::collections::BTreeMap;
use std::path::Path;

pub(super) const GLTF: &str = "glTF";

/// Reads the meshes of a glTF scene, from a `.glb` or from JSON whose buffers are data URIs, as
/// described at [`read_mesh`](super::read_mesh).
///
/// The nodes of the scene are visited depth first; each primitive is placed by its node and
/// appended. Primitives of one mesh that share their vertices keep sharing them. Triangles, strips
/// and fans become faces (reversed where a node mirrors them), lines become lines. Scalar
/// attributes whose name begins with `_` become vertex scalars without it. Materials, normals,
/// texture coordinates and animations are skipped, skins and morph targets with a warning; the
/// transform of a skinned mesh's node is ignored, as the specification requires.
///
/// # Errors
/// [`FileError::Syntax`] with the element, also for a missing buffer; [`FileError::Unsupported`]
/// for compressed geometry and glTF 1.
pub fn read_gltf(bytes: &[u8]) -> Result<MeshFile, FileError> {
    read(bytes, None)
}

/// Reads like [`read_gltf`], with buffers in other files of this folder.
pub(super) fn read_beside(bytes: &[u8], folder: &Path) -> Result<MeshFile, FileError> {
    read(bytes, Some(folder))
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Root {
    pub scene: Option<usize>,
    #[serde(default)]
    pub scenes: Vec<Scene>,
    #[serde(default)]
    pub nodes: Vec<Node>,
    #[serde(default)]
    pub meshes: Vec<Mesh>,
    #[serde(default)]
    pub accessors: Vec<Accessor>,
    #[serde(default)]
    pub buffer_views: Vec<BufferView>,
    #[serde(default)]
    pub buffers: Vec<Buffer>,
    #[serde(default)]
    extensions_required: Vec<String>,
}

#[derive(Deserialize)]
pub(super) struct Scene {
    #[serde(default)]
    pub nodes: Vec<usize>,
}

#[derive(Deserialize)]
pub(super) struct Node {
    pub mesh: Option<usize>,
    pub skin: Option<usize>,
    #[serde(default)]
    pub children: Vec<usize>,
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    #[serde(default)]
    pub extensions: Extensions,
}

#[derive(Deserialize)]
pub(super) struct Mesh {
    pub primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
pub(super) struct Primitive {
    pub attributes: BTreeMap<String, usize>,
    pub indices: Option<usize>,
    pub mode: Option<u32>,
    #[serde(default)]
    pub targets: Vec<IgnoredAny>,
    #[serde(default)]
    pub extensions: Extensions,
}

type Extensions = BTreeMap<String, IgnoredAny>;

fn read(bytes: &[u8], folder: Option<&Path>) -> Result<MeshFile, FileError> {
    let text;
    let chunks = if bytes.starts_with(b"glTF") {
        glb_chunks(bytes)?
    } else {
        text = decode_text(bytes);
        Chunks { json: &text, binary: None, left_over: 0 }
    };
    let root = parse(chunks.json)?;
    for extension in &root.extensions_required {
        // These change how surfaces look, or (quantization) only allow more component types, all of
        // which are supported.
        let harmless =
            ["KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "KHR_mesh_quantization"];
        if !harmless.iter().any(|h| extension.starts_with(h)) {
            return Err(FileError::Unsupported(format!(
                "the glTF file requires the extension {extension}, which is not supported; export it without compression and extensions"
            )));
        }
    }
    let data = Data::load(&root, chunks.binary, folder);
    let mut file = gltf_scene::read(&root, &data)?;
    if chunks.left_over > 0 {
        let declared = format!("{} bytes", bytes.len() - chunks.left_over);
        file.warnings.push(FileWarning::TrailingBytes { bytes: chunks.left_over, declared });
    }
    Ok(file)
}

/// Parses the required part of the JSON.
fn parse(json: &[u8]) -> Result<Root, FileError> {
    // Old exporters pad the chunk with zeros instead of spaces.
    let end = json.iter().rposition(|b| *b != 0).map_or(0, |last| last + 1);
    let mut deserializer = serde_json::Deserializer::from_slice(&json[..end]);
    let root = serde_path_to_error::deserialize(&mut deserializer)
        .map_err(|fault| (fault.path().to_string(), fault.into_inner()))
        .and_then(|root| deserializer.end().map(|()| root).map_err(|fault| (".".into(), fault)));
    root.map_err(|(path, fault)| {
        let line = format!("JSON line {}, column {}", fault.line(), fault.column());
        let place = if fault.is_data() && path != "." { format!("{path} ({line})") } else { line };
        FileError::syntax(GLTF, place, plain_words(&fault.to_string()))
    })
}

/// Rewrites an error of serde without names of Rust types.
fn plain_words(message: &str) -> String {
    let message = message.rsplit_once(" at line ").map_or(message, |(what, _)| what);
    if let Some(field) = message.strip_prefix("missing field ") {
        return format!("the member {} is missing", field.replace('`', "\""));
    }
    let typed = message.strip_prefix("invalid type: ").or_else(|| message.strip_prefix("invalid value: "));
    let Some((found, expected)) = typed.and_then(|m| m.rsplit_once(", expected ")) else {
        return message.to_string();
    };
    let found = match found {
        "sequence" => "an array",
        "map" => "an object",
        other => other,
    };
    let expected = match expected {
        "usize" | "u32" | "u64" => "an integer of 0 or more",
        "f64" => "a number",
        "a sequence" => "an array",
        "a map" => "an object",
        other if other.starts_with("struct ") => "an object",
        other => other,
    };
    format!("expected {expected}, found {found}")
}

/// The chunks of a file.
struct Chunks<'a> {
    json: &'a [u8],
    binary: Option<&'a [u8]>,
    /// Number of bytes after the end given in the header, other than padding.
    left_over: usize,
}

/// Splits a `.glb` into chunks, up to the length in its header unless a chunk contradicts it.
fn glb_chunks(bytes: &[u8]) -> Result<Chunks<'_>, FileError> {
    let word = |at: usize| {
        let bytes = bytes.get(at..)?.first_chunk::<4>()?;
        Some(u32::from_le_bytes(*bytes))
    };
    let cut_off = |at: usize| {
        FileError::syntax("GLB", format!("byte {at}"), "the file ends inside a chunk; it is truncated")
    };
    match word(4) {
        Some(2) => {}
        Some(version) => {
            return Err(FileError::Unsupported(format!(
                "glTF version {version} is not supported; convert the file to glTF 2"
            )));
        }
        None => return Err(cut_off(4)),
    }
    let mut end = word(8).ok_or_else(|| cut_off(8))? as usize;
    let (mut json, mut binary) = (None, None);
    let mut at: usize = 12;
    while at < bytes.len() && (at < end || json.is_none()) {
        let length = word(at).ok_or_else(|| cut_off(at))? as usize;
        let kind = word(at + 4).ok_or_else(|| cut_off(at))?;
        let chunk = bytes.get(at + 8..).and_then(|b| b.get(..length)).ok_or_else(|| cut_off(at))?;
        match &kind.to_le_bytes() {
            b"JSON" if json.is_none() => json = Some(chunk),
            b"BIN\0" if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        at += 8 + length;
        if at > end {
            end = bytes.len();
        }
    }
    let rest = bytes.get(at..).unwrap_or_default();
    let filling = rest.iter().all(|b| matches!(b, 0 | b' ' | b'\n' | b'\r'));
    match json {
        Some(json) => Ok(Chunks { json, binary, left_over: if filling { 0 } else { rest.len() } }),
        None => Err(FileError::syntax("GLB", "byte 12", "there is no JSON chunk")),
    }
}
