//! Round trips: write, read, compare.

use super::{Folder, cube_positions, polygon_cube, triangle_cube, written};
use crate::FileWarning;
use crate::error::{FileError, MeshError};
use crate::io::*;
use crate::mesh::TriangleMesh;
use crate::polygon::PolygonMesh;

const ALL: [MeshFormat; 7] = [
    MeshFormat::Obj,
    MeshFormat::Ply,
    MeshFormat::Stl,
    MeshFormat::Off,
    MeshFormat::Glb,
    MeshFormat::Gltf,
    MeshFormat::Vtp,
];

fn rounded(positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    positions.iter().map(|p| p.map(|x| f64::from(x as f32))).collect()
}

fn faces(mesh: &PolygonMesh) -> Vec<Vec<u32>> {
    mesh.faces().map(<[u32]>::to_vec).collect()
}

#[test]
fn triangle_meshes_survive_every_format_in_order() {
    let cube = triangle_cube();
    for format in ALL {
        for encoding in [Encoding::Binary, Encoding::Ascii] {
            let mut out = MeshOut::from(&cube);
            out.encoding = encoding;
            let bytes = written(format, &out);
            assert_eq!(MeshFormat::sniff(&bytes), Some(format), "{format:?} {encoding:?}");
            let file = read_mesh_bytes(&bytes, format).unwrap();
            assert_eq!(file.warnings, [], "{format:?}");
            let in_f32 = matches!(format, MeshFormat::Glb | MeshFormat::Gltf);
            if format == MeshFormat::Stl {
                let soup: Vec<_> = cube.faces().flat_map(|f| cube.face_positions(f)).collect();
                let soup = if encoding == Encoding::Binary { rounded(&soup) } else { soup };
                assert_eq!(file.mesh.positions, soup);
                assert_eq!(file.mesh.face(11), [33, 34, 35]);
                continue;
            }
            let expected = if in_f32 { rounded(&cube_positions()) } else { cube_positions() };
            assert_eq!(file.mesh, PolygonMesh::from_triangles(expected, cube.triangles()), "{format:?}");
        }
    }
}

#[test]
fn polygons_scalars_and_lines_survive() {
    let mesh = polygon_cube();
    let heights: Vec<f64> = (0..9).map(|i| (i as f64).sin() * 1e-7).collect();
    let mut broken = heights.clone();
    broken[4] = f64::NAN;
    let areas: Vec<f64> = (0..7).map(|i| 1.0 / (i as f64 + 1.0)).collect();
    let lines = [vec![0, 1, 3], vec![7, 8]];
    let mut out = MeshOut::from(&mesh);
    out.vertex_scalars = vec![("signed_distance", &heights), ("winding", &broken)];
    out.face_scalars = vec![("area", &areas)];
    let flow: Vec<[f64; 3]> = (0..7).map(|i| [0.1, 0.7, -3.0].map(|x| x * f64::from(i))).collect();
    out.face_vectors = vec![("flow", &flow)];
    out.lines = &lines;
    for (format, encoding) in [
        (MeshFormat::Ply, Encoding::Binary),
        (MeshFormat::Ply, Encoding::Ascii),
        (MeshFormat::Vtp, Encoding::Binary),
    ] {
        out.encoding = encoding;
        let file = read_mesh_bytes(&written(format, &out), format).unwrap();
        assert_eq!(file.mesh, mesh, "{format:?}");
        let mut scalars = file.vertex_scalars;
        if format == MeshFormat::Ply {
            assert_eq!(scalars.remove(0), ("quality".to_string(), heights.clone()));
            assert_eq!(file.lines, [vec![0, 1], vec![1, 3], vec![7, 8]]);
        } else {
            assert_eq!(file.lines, lines);
        }
        assert_eq!(scalars[0], ("signed_distance".to_string(), heights.clone()));
        assert_eq!(scalars[1].0, "winding");
        for (read, given) in scalars[1].1.iter().zip(&broken) {
            assert_eq!(read.to_bits(), given.to_bits());
        }
        let components = (0..3).map(|k| (format!("flow_{k}"), flow.iter().map(|v| v[k]).collect()));
        let expected: Vec<_> =
            std::iter::once(("area".to_string(), areas.clone())).chain(components).collect();
        assert_eq!(file.face_scalars, expected);
        assert_eq!(file.warnings, []);
    }
    for format in [MeshFormat::Obj, MeshFormat::Off] {
        let mut bytes = Vec::new();
        let left_out = write_mesh_bytes(&mut bytes, format, &out).unwrap();
        let file = read_mesh_bytes(&bytes, format).unwrap();
        assert_eq!(faces(&file.mesh), faces(&mesh));
        assert_eq!(file.mesh.positions, mesh.positions);
        let lost: usize = if format == MeshFormat::Obj { 3 } else { 5 };
        assert_eq!(left_out.len(), lost, "{left_out:?}");
        assert_eq!(file.lines.len(), if format == MeshFormat::Obj { 2 } else { 0 });
    }
    for format in [MeshFormat::Stl, MeshFormat::Glb, MeshFormat::Gltf] {
        let refusal = write_mesh_bytes(&mut Vec::new(), format, &out).unwrap_err().to_string();
        assert!(refusal.contains("face 2 has 4 corners") && refusal.contains("triangulate"), "{refusal}");
    }
}

#[test]
fn gltf_keeps_scalars_and_lines_on_shared_vertices() {
    let cube = triangle_cube();
    let values: Vec<f64> = (0..8).map(|i| i as f64 / 8.0).collect();
    let lines = [vec![0, 1, 3]];
    let mut out = MeshOut::from(&cube);
    out.vertex_scalars = vec![("winding", &values)];
    out.lines = &lines;
    let colours = [[255, 0, 128]; 8];
    out.vertex_colours = Some(&colours);
    for format in [MeshFormat::Glb, MeshFormat::Gltf] {
        let file = read_mesh_bytes(&written(format, &out), format).unwrap();
        assert_eq!((file.mesh.vertex_count(), file.mesh.face_count()), (8, 12));
        assert_eq!(file.vertex_scalars, [("winding".to_string(), values.clone())]);
        assert_eq!(file.lines, [[0, 1], [1, 3]]);
    }
}

#[test]
fn gltf_keeps_vertices_with_degenerate_lines() {
    // Found by fuzzing: a line of no or one node counted as a user of the vertices.
    let points = PolygonMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0]]);
    for lines in [vec![], vec![vec![]], vec![vec![1]]] {
        let mut out = MeshOut::from(&points);
        out.lines = &lines;
        let file = read_mesh_bytes(&written(MeshFormat::Glb, &out), MeshFormat::Glb).unwrap();
        assert_eq!(file.mesh.positions, points.positions);
    }
}

#[test]
fn colours_are_written_as_each_format_defines_them() {
    let mesh = polygon_cube();
    let colours: Vec<[u8; 3]> = (0..9).map(|i| [i * 28, 255 - i, 7]).collect();
    let mut out = MeshOut::from(&mesh);
    out.vertex_colours = Some(&colours);
    for (format, largest) in [(MeshFormat::Obj, 1.0), (MeshFormat::Off, 255.0), (MeshFormat::Ply, 255.0)] {
        let file = read_mesh_bytes(&written(format, &out), format).unwrap();
        for (k, name) in ["red", "green", "blue"].into_iter().enumerate() {
            assert_eq!(file.vertex_scalars[k].0, name);
            for (read, given) in file.vertex_scalars[k].1.iter().zip(&colours) {
                assert_eq!((read * 255.0 / largest).round(), f64::from(given[k]), "{format:?}");
            }
        }
        assert_eq!(file.mesh, mesh);
    }
}

#[test]
fn obj_stores_texture_coordinates_or_a_scalar() {
    let mesh = TriangleMesh::new(vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], vec![[0, 1, 2]]).unwrap();
    let values = [0.5, 0.25, -1.0];
    let mut out = MeshOut::from(&mesh);
    out.vertex_scalars = vec![("distance", &values)];
    let text = String::from_utf8(written(MeshFormat::Obj, &out)).unwrap();
    assert!(text.ends_with("vt 0.5 0\nvt 0.25 0\nvt -1 0\nf 1/1 2/2 3/3\n"), "{text}");
    out.obj_scalar_as_texture = false;
    let text = String::from_utf8(written(MeshFormat::Obj, &out)).unwrap();
    assert!(text.ends_with("\nf 1 2 3\n"), "{text}");
    let uvs = [[0., 0.], [1., 0.], [0., 0.125]];
    out.corner_uvs = Some(&uvs);
    let text = String::from_utf8(written(MeshFormat::Obj, &out)).unwrap();
    assert!(text.ends_with("vt 0 0\nvt 1 0\nvt 0 0.125\nf 1/1 2/2 3/3\n"), "{text}");
    assert_eq!(read_mesh_bytes(text.as_bytes(), MeshFormat::Obj).unwrap().corner_uvs, Some(uvs.to_vec()));
    let ply = read_mesh_bytes(&written(MeshFormat::Ply, &out), MeshFormat::Ply).unwrap();
    assert_eq!(ply.mesh.face(0), [0, 1, 2]);
    let (element, names) = ("face".to_string(), vec!["texcoord".to_string()]);
    assert_eq!(ply.warnings, [FileWarning::IgnoredFields { element, names, reason: None }]);
}

#[test]
fn a_read_file_is_written_back_unchanged() {
    let text = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        property uchar red\nproperty float quality\nelement face 1\nproperty list uchar int vertex_index\nproperty int label\n\
        element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n\
        0 0 0 255 1.5\n1 0 0 0 2.5\n0 1e-300 0 7 -inf\n3 0 1 2 9\n2 0\n";
    let file = read_ply(text).unwrap();
    assert_eq!(file.face_scalars, [("label".to_string(), vec![9.0])]);
    for format in [MeshFormat::Ply, MeshFormat::Vtp] {
        assert_eq!(read_mesh_bytes(&written(format, &MeshOut::from(&file)), format).unwrap(), file);
    }
}

#[test]
fn extreme_numbers_survive_text_bit_for_bit() {
    let positions = vec![
        [f64::MAX, f64::MIN_POSITIVE, -0.0],
        [5e-324, 1e16, 123456789.12345679],
        [1e-5, 0.1 + 0.2, -1e300],
    ];
    let mesh = PolygonMesh::from_triangles(positions.clone(), &[[0, 1, 2]]);
    let mut out = MeshOut::from(&mesh);
    out.encoding = Encoding::Ascii;
    for format in [MeshFormat::Obj, MeshFormat::Off, MeshFormat::Ply, MeshFormat::Stl] {
        let read = read_mesh_bytes(&written(format, &out), format).unwrap().mesh.positions;
        assert_eq!(read.as_flattened().len(), 9);
        for (a, b) in read.as_flattened().iter().zip(positions.as_flattened()) {
            assert_eq!(a.to_bits(), b.to_bits(), "{format:?} {b}");
        }
    }
    out.encoding = Encoding::Binary;
    for format in [MeshFormat::Stl, MeshFormat::Glb] {
        let refusal = write_mesh_bytes(&mut Vec::new(), format, &out).unwrap_err().to_string();
        assert!(refusal.contains("vertex 0") && refusal.contains("32-bit"), "{refusal}");
    }
}

#[test]
fn wrong_lengths_and_indices_are_errors() {
    let cube = triangle_cube();
    let mut out = MeshOut::from(&cube);
    out.vertex_scalars = vec![("a", &[1.0])];
    let refusal = write_mesh_bytes(&mut Vec::new(), MeshFormat::Ply, &out).unwrap_err();
    assert!(
        matches!(refusal, FileError::Mesh(MeshError::WrongLength { found: 1, expected: 8, .. })),
        "{refusal}"
    );
    out.vertex_scalars = vec![("a b", &[1.0; 8]), ("a_b", &[1.0; 8])];
    let refusal = write_mesh_bytes(&mut Vec::new(), MeshFormat::Ply, &out).unwrap_err().to_string();
    assert!(refusal.contains("a_b"), "{refusal}");
    let wrong = PolygonMesh::from_triangles(cube_positions(), &[[0, 1, 8]]);
    let refusal =
        write_mesh_bytes(&mut Vec::new(), MeshFormat::Obj, &MeshOut::from(&wrong)).unwrap_err().to_string();
    assert!(refusal.contains("face 0 refers to vertex 8"), "{refusal}");
}

#[test]
fn files_are_written_atomically() {
    let folder = Folder::new("atomic");
    let cube = triangle_cube();
    let path = folder.0.join("cube.ply");
    write_mesh(&path, &MeshOut::from(&cube)).unwrap();
    let before = std::fs::read(&path).unwrap();
    let failed = write_atomically(&path, |out| {
        out.write_all(b"half")?;
        Err::<(), _>(std::io::Error::other("no more"))
    });
    assert!(failed.unwrap_err().to_string().contains("cube.ply: no more"));
    let panicked = std::panic::catch_unwind(|| write_atomically::<()>(&path, |_| panic!("in the middle")));
    assert!(panicked.is_err());
    assert_eq!(std::fs::read(&path).unwrap(), before);
    assert_eq!(folder.names(), ["cube.ply"]);
    let mut out = MeshOut::from(&cube);
    out.vertex_scalars = vec![("short", &[])];
    assert!(
        write_mesh(folder.0.join("other.ply"), &out)
            .unwrap_err()
            .to_string()
            .contains("other.ply: found 0 values")
    );
    assert!(write_mesh(folder.0.join("missing/cube.ply"), &MeshOut::from(&cube)).is_err());
    assert!(write_mesh(folder.0.join("cube.xyz"), &MeshOut::from(&cube)).is_err());
    assert_eq!(folder.names(), ["cube.ply"]);
}

#[test]
fn paths_determine_format_and_compression() {
    let folder = Folder::new("paths");
    let cube = triangle_cube();
    for name in ["a.OBJ", "a.ply.gz", "a.off", "a.vtp", "a.obj.gz"] {
        let path = folder.0.join(name);
        write_mesh(&path, &MeshOut::from(&cube)).unwrap();
        assert_eq!(
            read_mesh(&path).unwrap().mesh,
            PolygonMesh::from_triangles(cube_positions(), cube.triangles())
        );
    }
    assert!(std::fs::read(folder.0.join("a.ply.gz")).unwrap().starts_with(&[0x1f, 0x8b]));
    // No extension, only content.
    std::fs::copy(folder.0.join("a.ply.gz"), folder.0.join("unnamed")).unwrap();
    assert_eq!(read_mesh(folder.0.join("unnamed")).unwrap().mesh.face_count(), 12);
    std::fs::write(folder.0.join("noise"), "what is this").unwrap();
    let refusal = read_mesh(folder.0.join("noise")).unwrap_err().to_string();
    assert!(refusal.contains("noise") && refusal.contains("end in .obj"), "{refusal}");
    assert!(matches!(read_mesh(folder.0.join("absent.obj")), Err(FileError::Io { .. })));
    // A glTF file with its buffer next to it.
    let text = String::from_utf8(written(MeshFormat::Gltf, &MeshOut::from(&cube))).unwrap();
    let start = text.find("data:").unwrap();
    let uri_end = start + text[start..].find('"').unwrap();
    let glb = written(MeshFormat::Glb, &MeshOut::from(&cube));
    let json_length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    std::fs::write(folder.0.join("the data.bin"), &glb[20 + json_length + 8..]).unwrap();
    let external = format!("{}the%20data.bin{}", &text[..start], &text[uri_end..]);
    std::fs::write(folder.0.join("a.gltf"), &external).unwrap();
    assert_eq!(read_mesh(folder.0.join("a.gltf")).unwrap().mesh.face_count(), 12);
    let refusal = read_gltf(external.as_bytes()).unwrap_err().to_string();
    assert!(refusal.contains("another file"), "{refusal}");
    let refusal = std::fs::write(folder.0.join("b.gltf"), external.replace("the%20data", "../the%20data"))
        .map(|()| read_mesh(folder.0.join("b.gltf")).unwrap_err().to_string())
        .unwrap();
    assert!(refusal.contains("is not in the folder"), "{refusal}");
}
