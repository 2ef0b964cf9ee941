//! The content of a file takes precedence over its name.

use super::{Folder, triangle_cube, written};
use crate::FileWarning;
use crate::io::*;

// reports.md, wrong extension
#[test]
fn content_decides_over_a_wrong_name() {
    use MeshFormat::{Glb, Gltf, Obj, Off, Ply, Stl, Vtp};
    let folder = Folder::new("names");
    let cube = triangle_cube();
    for encoding in [Encoding::Binary, Encoding::Ascii] {
        let mut out = MeshOut::from(&cube);
        out.encoding = encoding;
        for content in [Obj, Ply, Stl, Off, Glb, Gltf, Vtp] {
            let bytes = written(content, &out);
            let right = read_mesh_bytes(&bytes, content).unwrap();
            for extension in ["obj", "ply", "stl", "off", "glb", "gltf", "vtp", "STL", "txt", ""] {
                let path = folder.0.join(format!("mesh.{extension}"));
                std::fs::write(&path, &bytes).unwrap();
                let (file, format) = read_mesh_as(&path, None).unwrap();
                assert_eq!((format, &file.mesh), (content, &right.mesh), "{content:?} as {extension}");
                let named = MeshFormat::from_path(&path);
                let is_gltf = |f: MeshFormat| matches!(f, Glb | Gltf);
                let fits = named.is_none_or(|n| n == content || is_gltf(n) && is_gltf(content));
                let expected =
                    named.filter(|_| !fits).map(|named| FileWarning::MisnamedFile { named, read: content });
                assert_eq!(file.warnings, Vec::from_iter(expected), "{content:?} as {extension}");
            }
        }
    }
    // A given format takes precedence over both.
    let path = folder.0.join("mesh.obj");
    std::fs::write(&path, written(Ply, &MeshOut::from(&cube))).unwrap();
    assert!(read_mesh_as(&path, Some(Obj)).is_err());
}

#[test]
fn binary_files_may_begin_like_other_formats() {
    let cube = triangle_cube();
    let mut bytes = written(MeshFormat::Stl, &MeshOut::from(&cube));
    for head in [
        &b"ply\n"[..],
        b"glTF\x02\0\0\0",
        b"{ \"",
        b"<VTKFile",
        b"OFF 1 1",
        b"v 1 2 3",
        b"solid facet",
        b"g \0",
    ] {
        bytes[..head.len()].copy_from_slice(head);
        assert_eq!(MeshFormat::sniff(&bytes), Some(MeshFormat::Stl), "{head:?}");
        assert_eq!(read_stl(&bytes).unwrap().mesh.face_count(), 12);
    }
    bytes[80] = 0; // a facet count of 0: now the name decides
    bytes[..8].copy_from_slice(b"g part  ");
    assert_eq!(MeshFormat::sniff(&bytes), None);
    assert_eq!(MeshFormat::detect("part.stl", &bytes), Some(MeshFormat::Stl));
}

#[test]
fn foreign_files_are_identified() {
    let folder = Folder::new("foreign");
    let refusal = |name: &str, content: &[u8]| {
        std::fs::write(folder.0.join(name), content).unwrap();
        read_mesh(folder.0.join(name)).unwrap_err().to_string()
    };
    for (name, content, words) in [
        ("a.obj", &b"<!DOCTYPE HTML>\n<p>Not found"[..], "an HTML page"),
        ("a.ply", b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "git lfs pull"),
        ("a.stl", b"PK\x03\x04 and so on", "ZIP archive"),
        ("a.vtp", b"# vtk DataFile Version 3.0\n", "legacy VTK"),
        ("a.off", b"<?xml version=\"1.0\"?>\n<COLLADA></COLLADA>", "a COLLADA file"),
        ("a.stp", b"ISO-10303-21;\n", "a STEP file"),
        ("empty.obj", b"", "the file is empty"),
        ("empty.stl", b"", "the file is empty"),
        ("noise.xyz", b"1 2 3\n", "end in .obj"),
        ("a.vtu", b"<VTKFile type=\"UnstructuredGrid\"></VTKFile>", "UnstructuredGrid"),
    ] {
        let refusal = refusal(name, content);
        assert!(refusal.contains(words) && refusal.contains(name), "{refusal}");
    }
}
