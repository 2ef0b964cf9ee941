//! Format detection by content, or by file name if the content does not decide.

use super::text::decode_text;
use super::words::Words;
use super::{MeshFormat, off, stl};
use std::path::Path;

/// Number of bytes examined; comments before the first statement may be long.
const HEAD: usize = 1 << 16;

impl MeshFormat {
    /// Returns the format of a file name's extension, ignoring a final `.gz`.
    ///
    /// ```
    /// use eikona_mesh::io::MeshFormat;
    /// assert_eq!(MeshFormat::from_path("scan.PLY.gz"), Some(MeshFormat::Ply));
    /// assert_eq!(MeshFormat::from_path("scan"), None);
    /// ```
    pub fn from_path(path: impl AsRef<Path>) -> Option<MeshFormat> {
        let name = path.as_ref().file_name()?.to_string_lossy().to_ascii_lowercase();
        let (_, extension) = name.strip_suffix(".gz").unwrap_or(&name).rsplit_once('.')?;
        Some(match extension {
            "obj" => MeshFormat::Obj,
            "ply" => MeshFormat::Ply,
            "stl" => MeshFormat::Stl,
            "off" => MeshFormat::Off,
            "glb" => MeshFormat::Glb,
            "gltf" => MeshFormat::Gltf,
            "vtp" => MeshFormat::Vtp,
            _ => return None,
        })
    }

    /// Returns the format of the content, judged by its first bytes and, for binary STL, its
    /// length.
    ///
    /// ```
    /// use eikona_mesh::io::MeshFormat;
    /// assert_eq!(MeshFormat::sniff(b"ply\nformat ascii 1.0\n"), Some(MeshFormat::Ply));
    /// assert_eq!(MeshFormat::sniff(b"8 12 0\n"), None); // OFF without its keyword
    /// ```
    pub fn sniff(bytes: &[u8]) -> Option<MeshFormat> {
        if stl::is_binary(bytes) {
            return Some(MeshFormat::Stl);
        }
        if bytes.starts_with(b"glTF") {
            return Some(MeshFormat::Glb);
        }
        let head = decode_text(bytes.get(..HEAD).unwrap_or(bytes));
        let head = head.trim_ascii_start();
        // Its body may be binary.
        if head.strip_prefix(b"ply").is_some_and(|rest| rest.first().is_none_or(u8::is_ascii_whitespace)) {
            return Some(MeshFormat::Ply);
        }
        if stl::is_ascii(head) {
            return contains(head, b"facet").then_some(MeshFormat::Stl);
        }
        if head.starts_with(b"<") {
            // Data appended to the XML may be binary.
            return contains(head, b"<VTKFile").then_some(MeshFormat::Vtp);
        }
        if head.contains(&0) {
            return None; // the others are text
        }
        if let Some(members) = head.strip_prefix(b"{") {
            let first = members.trim_ascii_start().first();
            return matches!(first, None | Some(b'"' | b'}')).then_some(MeshFormat::Gltf);
        }
        match Words::new(head).with_comments().word()? {
            b"v" | b"vn" | b"vt" | b"f" | b"o" | b"g" | b"s" | b"mtllib" | b"usemtl" => Some(MeshFormat::Obj),
            word => off::Header::parse(word).map(|_| MeshFormat::Off),
        }
    }

    /// Returns the format of the content if [`sniff`](Self::sniff) recognises it, else that of the
    /// name.
    ///
    /// ```
    /// use eikona_mesh::io::MeshFormat;
    /// let bytes = b"ply\nformat ascii 1.0\n";
    /// assert_eq!(MeshFormat::detect("part.stl", bytes), Some(MeshFormat::Ply));
    /// assert_eq!(MeshFormat::detect("part.off", b"8 12 0\n"), Some(MeshFormat::Off));
    /// ```
    pub fn detect(path: impl AsRef<Path>, bytes: &[u8]) -> Option<MeshFormat> {
        MeshFormat::sniff(bytes).or_else(|| MeshFormat::from_path(path))
    }
}

/// Returns whether a text contains an ASCII word, ignoring case.
fn contains(text: &[u8], part: &[u8]) -> bool {
    text.windows(part.len()).any(|w| w.eq_ignore_ascii_case(part))
}

/// Returns the kind of file and the remedy, for content that is recognised but not supported.
pub(super) fn foreign(bytes: &[u8]) -> Option<(&'static str, &'static str)> {
    const UNPACK: &str = "unpack it first";
    const EXPORT: &str = "export the mesh as .obj, .ply, .stl, .off, .glb or .vtp";
    const KINDS: [(&[u8], &str, &str); 18] = [
        (b"version https://git-lfs", "a Git LFS pointer", "fetch the file itself with `git lfs pull`"),
        (b"<!doctype html", "an HTML page", "download the file itself"),
        (b"<html", "an HTML page", "download the file itself"),
        (b"PK\x03\x04", "a ZIP archive (as 3MF files are)", UNPACK),
        (b"BZh", "compressed by bzip2", UNPACK),
        (b"\xfd7zXZ\0", "compressed by xz", UNPACK),
        (b"\x28\xb5\x2f\xfd", "compressed by zstd", UNPACK),
        (b"7z\xbc\xaf", "a 7z archive", UNPACK),
        (b"# vtk DataFile", "a legacy VTK file", "save it as .vtp"),
        (b"ISO-10303-21", "a STEP file", EXPORT),
        (b"$MeshFormat", "a Gmsh file", EXPORT),
        (b"Kaydara FBX", "an FBX file", EXPORT),
        (b"BLENDER", "a Blender file", EXPORT),
        (b"#usda", "a USD file", EXPORT),
        (b"PXR-USDC", "a USD file", EXPORT),
        (b"#VRML", "a VRML file", EXPORT),
        (b"%PDF", "a PDF file", EXPORT),
        (b"\x93NUMPY", "a NumPy array", EXPORT),
    ];
    let head = decode_text(bytes.get(..HEAD).unwrap_or(bytes));
    let begins = |magic: &[u8]| head.get(..magic.len()).is_some_and(|h| h.eq_ignore_ascii_case(magic));
    if head.starts_with(b"<") && contains(&head, b"<COLLADA") {
        return Some(("a COLLADA file", EXPORT));
    }
    KINDS.into_iter().find(|(magic, ..)| begins(magic)).map(|(_, kind, remedy)| (kind, remedy))
}
