//! Mesh file input and output. Readers take bytes and keep the order and count of vertices and
//! faces; nothing is welded, dropped or flipped. Writers report what their format could not hold,
//! and leave no half-written file behind.
//!
//! | format | read | written |
//! |---|---|---|
//! | OBJ | polygons, `l` lines, vertex colours, texture coordinates | polygons, lines, colours, texture coordinates, a scalar as texture u |
//! | PLY | ascii and binary; polygons, strips, edges; all scalar properties | ascii or binary; all but polylines of more than 2 nodes stay whole |
//! | STL | ascii and binary, three vertices per facet | ascii or binary, triangles only |
//! | OFF | with colours and normals | polygons, colours |
//! | GLB, glTF | all primitives, placed by their nodes; `_NAME` scalars | GLB: triangles, lines, scalars, colours, texture coordinates, animations ([`stage_animation`]) |
//! | VTP | ascii, base64 and raw data, zlib | polygons, lines, scalars, colours |
//!
//! Text may be UTF-8, UTF-16 or UTF-32. Writing to a format of 32-bit floats (STL, GLB, glTF) gives
//! a warning if they can not represent the coordinates; glTF keeps an offset in the translation of
//! its node.
//!
//! Coordinates that are NaN or infinite are kept as read;
//! [`TriangleMesh::new`](crate::TriangleMesh::new) then reports their vertices. Counts in a file's
//! header are checked against its length before memory is allocated.

mod atomic;
mod base64;
mod detect;
mod faces;
mod gltf;
mod gltf_animation;
mod gltf_buffers;
mod gltf_scene;
mod gltf_write;
mod names;
mod obj;
mod off;
mod output;
mod ply;
mod ply_header;
mod ply_lines;
mod ply_write;
mod rounding;
mod stl;
mod text;
mod vtp;
mod vtp_arrays;
mod vtp_write;
mod words;
mod write;

#[cfg(test)]
mod tests;

pub use atomic::{StagedFile, discard_temporary_files, publish_files, stage_file, write_atomically};
pub use gltf::read_gltf;
pub use gltf_animation::{Animation, stage_animation};
pub use obj::read_obj;
pub use off::read_off;
pub use output::{Encoding, MeshOut};
pub use ply::read_ply;
pub use stl::read_stl;
pub use text::decode_text;
pub use vtp::read_vtp;
pub use write::{stage_mesh, write_mesh, write_mesh_bytes};

use crate::error::FileError;
use crate::polygon::PolygonMesh;
use crate::warning::FileWarning;
use serde::Serialize;
use std::fs;
use std::io::Read;
use std::path::Path;

/// A mesh file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum MeshFormat {
    /// Wavefront OBJ.
    Obj,
    /// Stanford PLY.
    Ply,
    /// Stereolithography STL.
    Stl,
    /// Object File Format of Geomview.
    Off,
    /// glTF 2.0 as a single binary file.
    Glb,
    /// glTF 2.0 as JSON.
    Gltf,
    /// VTK PolyData, as XML.
    Vtp,
}

impl MeshFormat {
    /// Returns the usual name of the format: "OBJ", "glTF".
    ///
    /// ```
    /// use eikona_mesh::io::MeshFormat;
    /// assert_eq!(MeshFormat::Stl.name(), "STL");
    /// ```
    pub fn name(self) -> &'static str {
        match self {
            MeshFormat::Obj => "OBJ",
            MeshFormat::Ply => "PLY",
            MeshFormat::Stl => "STL",
            MeshFormat::Off => "OFF",
            MeshFormat::Glb => "GLB",
            MeshFormat::Gltf => "glTF",
            MeshFormat::Vtp => "VTP",
        }
    }
}

/// The contents of a mesh file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshFile {
    /// Vertices and polygons in the order of the file.
    pub mesh: PolygonMesh,
    /// Polylines, as 0-based vertices.
    pub lines: Vec<Vec<u32>>,
    /// Isolated points (`p` lines of OBJ), as 0-based vertices. Not written.
    pub points: Vec<u32>,
    /// Named values, one per vertex, in the order of the file. NaN where the file has none.
    pub vertex_scalars: Vec<(String, Vec<f64>)>,
    /// Named values, one per face, in the order of the file. NaN where the file has none.
    pub face_scalars: Vec<(String, Vec<f64>)>,
    /// Texture coordinates u, v, one pair per corner, in the order of the faces and their corners;
    /// from OBJ files in which every corner has them. [`MeshOut::from`](MeshOut) ignores them.
    pub corner_uvs: Option<Vec<[f64; 2]>>,
    /// What was omitted or looked odd, one sentence each.
    pub warnings: Vec<FileWarning>,
}

/// The maximum size of a file in bytes (uncompressed), so that 32-bit indices suffice.
const MOST_BYTES: u64 = u32::MAX as u64;

/// Reads a mesh file in the format of its content, or of its name if the content does not decide.
///
/// A name that contradicts the content gives a warning. gzip is decompressed whatever the name. The
/// buffers of a glTF file are looked up next to it.
///
/// [`FileError::Io`] if the file can not be read, [`FileError::Unsupported`] if its format is
/// unknown, else as for [`read_mesh_bytes`]; every error except I/O errors is wrapped in
/// [`FileError::InFile`].
pub fn read_mesh(path: impl AsRef<Path>) -> Result<MeshFile, FileError> {
    read_mesh_as(path, None).map(|(file, _)| file)
}

/// Reads a mesh file like [`read_mesh`], in the given format if any. Also returns the format.
///
/// # Errors
/// As for [`read_mesh`].
pub fn read_mesh_as(
    path: impl AsRef<Path>,
    format: Option<MeshFormat>,
) -> Result<(MeshFile, MeshFormat), FileError> {
    let path = path.as_ref();
    let bytes = read_bytes(path)?;
    read_detected(path, &bytes, format).map_err(|fault| fault.in_file(path))
}

fn read_detected(
    path: &Path,
    bytes: &[u8],
    given: Option<MeshFormat>,
) -> Result<(MeshFile, MeshFormat), FileError> {
    let by_content = MeshFormat::sniff(bytes);
    let by_name = MeshFormat::from_path(path);
    if bytes.is_empty() {
        return Err(FileError::Unsupported("the file is empty".into()));
    }
    if given.or(by_content).is_none()
        && let Some((kind, remedy)) = detect::foreign(bytes)
    {
        return Err(FileError::Unsupported(format!(
            "the content is {kind}, which is not supported; {remedy}"
        )));
    }
    let format = given.or(by_content).or(by_name).ok_or_else(|| {
        let problem = "the mesh format can not be determined from the name or the content; rename the file to end in .obj, .ply, .stl, .off, .glb, .gltf or .vtp";
        FileError::Unsupported(problem.into())
    })?;
    let mut file = match format {
        MeshFormat::Glb | MeshFormat::Gltf => {
            with_rounding_warning(gltf::read_beside(bytes, path.parent().unwrap_or(Path::new("")))?)
        }
        format => read_mesh_bytes(bytes, format)?,
    };
    // Both kinds of glTF have the same reader.
    let kind = |f: MeshFormat| if f == MeshFormat::Gltf { MeshFormat::Glb } else { f };
    if let Some(named) = by_name
        && kind(named) != kind(format)
        && given.is_none()
    {
        file.warnings.insert(0, FileWarning::MisnamedFile { named, read: format });
    }
    Ok((file, format))
}

/// Adds a warning if rounding to 32-bit floats has damaged the mesh.
fn with_rounding_warning(mut file: MeshFile) -> MeshFile {
    file.warnings.extend(rounding::lost_digits(&file.mesh));
    file
}

/// Reads a mesh from the bytes of a file (not compressed). glTF must contain all its buffers.
///
/// ```
/// use eikona_mesh::io::{MeshFormat, read_mesh_bytes};
/// let file = read_mesh_bytes(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nl 1 -1\n", MeshFormat::Obj)?;
/// assert_eq!(file.mesh.face(0), [0, 1, 2]);
/// assert_eq!(file.lines, [[0, 2]]);
/// # Ok::<(), eikona_mesh::FileError>(())
/// ```
///
/// # Errors
/// [`FileError::Syntax`] with the line or element, [`FileError::Mesh`] with all faces that refer to
/// vertices that do not exist, [`FileError::Unsupported`] for unsupported content.
///
/// # Cost
/// O(bytes). About 0.05 s for a million triangles of binary PLY on one thread.
pub fn read_mesh_bytes(bytes: &[u8], format: MeshFormat) -> Result<MeshFile, FileError> {
    if bytes.len() as u64 > MOST_BYTES {
        return Err(FileError::Unsupported(format!(
            "the file has {} bytes, more than 4 GiB; split the mesh",
            bytes.len()
        )));
    }
    let read = match format {
        MeshFormat::Obj => read_obj(bytes),
        MeshFormat::Ply => read_ply(bytes),
        MeshFormat::Stl => read_stl(bytes),
        MeshFormat::Off => read_off(bytes),
        MeshFormat::Glb | MeshFormat::Gltf => read_gltf(bytes),
        MeshFormat::Vtp => read_vtp(bytes),
    };
    read.map(with_rounding_warning)
}

/// Reads a file and decompresses gzip.
fn read_bytes(path: &Path) -> Result<Vec<u8>, FileError> {
    let bytes = fs::read(path).map_err(|fault| FileError::io(path, fault))?;
    without_gzip(bytes, &path.display().to_string())
}

/// Decompresses bytes that begin like gzip; returns others unchanged. `name` is for the error.
///
/// # Errors
/// [`FileError::Syntax`] if the compressed data is damaged.
pub fn without_gzip(bytes: Vec<u8>, name: &str) -> Result<Vec<u8>, FileError> {
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(bytes);
    }
    let mut content = Vec::new();
    flate2::read::MultiGzDecoder::new(bytes.as_slice())
        .take(MOST_BYTES + 1)
        .read_to_end(&mut content)
        .map_err(|fault| FileError::syntax("gzip", name.to_owned(), fault.to_string()))?;
    Ok(content)
}
