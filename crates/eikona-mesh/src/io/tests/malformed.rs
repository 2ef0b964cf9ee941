//! Damaged files: each gives an error with place and cause; none causes a panic, a hang or a huge
//! allocation.

use super::{polygon_cube, triangle_cube, written};
use crate::io::*;

const PLY3: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
const FACE: &str = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";

fn ply(format: &str, elements: &str, body: &[u8]) -> Vec<u8> {
    [format!("ply\nformat {format} 1.0\n{elements}").as_bytes(), body].concat()
}

#[test]
fn errors_give_place_value_and_remedy() {
    use MeshFormat::*;
    let points = "0 0 0 1 0 0 0 1 0\n";
    let ascii = |body: &str| ply("ascii", &format!("{PLY3}{FACE}"), format!("{points}{body}").as_bytes());
    let glb = |edit: fn(&mut Vec<u8>)| {
        let mut bytes = written(Glb, &MeshOut::from(&triangle_cube()));
        edit(&mut bytes);
        bytes
    };
    let gltf = |from: &str, to: &str| {
        let text = String::from_utf8(written(Gltf, &MeshOut::from(&triangle_cube()))).unwrap();
        assert!(text.contains(from), "{text}");
        text.replace(from, to).into_bytes()
    };
    let vtp = |from: &str, to: &str| {
        let text = String::from_utf8(written(Vtp, &MeshOut::from(&triangle_cube()))).unwrap();
        assert!(text.contains(from), "{text}");
        text.replacen(from, to, 1).into_bytes()
    };
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let table: Vec<(&str, MeshFormat, Vec<u8>, &[&str])> = vec![
        ("empty", Obj, b"".to_vec(), &["no vertices"]),
        ("zero index", Obj, format!("{triangle}f 0 1 2").into(), &["line 4", "vertex 0", "from 1"]),
        (
            "index past the end",
            Obj,
            format!("{triangle}f 1 2 3\nf 1 2 4\nf 9 9 9\n").into(),
            &["line 5", "vertex 4", "1 to 3"],
        ),
        (
            "index of 20 digits",
            Obj,
            format!("{triangle}f 1 2 99999999999999999999\n").into(),
            &["line 4", "not a vertex number"],
        ),
        (
            "index past 32 bits",
            Obj,
            format!("{triangle}f 1 2 4294967297\n").into(),
            &["line 4", "4294967297", "correct"],
        ),
        (
            "negative index too far",
            Obj,
            format!("{triangle}f -1 -2 -4").into(),
            &["line 4", "-4", "only 3 vertices"],
        ),
        ("line index", Obj, format!("{triangle}\\\n\nl 1 x").into(), &["line 6", "\"x\""]),
        ("two coordinates", Obj, b"v 1 2\n".to_vec(), &["line 1", "2 coordinates", "needs 3"]),
        ("no number", Obj, b"v 1 2 3,5\n".to_vec(), &["line 1", "3,5"]),
        ("binary noise", Obj, (0..=255).collect(), &["OBJ"]),
        ("no magic", Ply, b"plx\n".to_vec(), &["line 1", "ply"]),
        ("no end", Ply, b"ply\nformat ascii 1.0\n".to_vec(), &["end_header"]),
        ("no format", Ply, b"ply\nend_header\n".to_vec(), &["line 2", "format"]),
        ("unknown format", Ply, b"ply\nformat utf8 1.0\n".to_vec(), &["line 2", "utf8"]),
        (
            "unknown type",
            Ply,
            b"ply\nformat ascii 1.0\nelement vertex 1\nproperty real x\n".to_vec(),
            &["line 4", "\"real\""],
        ),
        (
            "negative count",
            Ply,
            b"ply\nformat ascii 1.0\nelement vertex -1\n".to_vec(),
            &["line 3", "\"-1\""],
        ),
        (
            "huge count",
            Ply,
            ply(
                "binary_little_endian",
                &format!("{}end_header\n", PLY3.replace('3', "3000000000000")),
                &[0; 36],
            ),
            &["vertex", "36 bytes are left"],
        ),
        (
            "count that overflows",
            Ply,
            ply("ascii", &format!("{}end_header\n", PLY3.replace('3', "18446744073709551615")), b"0 0 0"),
            &["PLY"],
        ),
        (
            "no coordinates",
            Ply,
            ply("ascii", "element vertex 1\nproperty int x\nend_header\n", b"1"),
            &["x, y and z"],
        ),
        ("no vertices", Ply, ply("ascii", "end_header\n", b""), &["no element \"vertex\""]),
        (
            "ascii truncated",
            Ply,
            ply("ascii", &format!("{PLY3}{FACE}"), b"0 0 0\n1 0 0 0 0 "),
            &["vertex 2", "property z", "truncated"],
        ),
        (
            "ascii word",
            Ply,
            ply("ascii", &format!("{PLY3}{FACE}"), b"0 0 0\n1 zero 0 0 0 0 0 0 0 0"),
            &["vertex 1", "property y", "zero"],
        ),
        ("negative index", Ply, ascii("3 0 1 -7\n"), &["face 0", "vertex -7", "0 to 2"]),
        (
            "index past the end",
            Ply,
            ascii("3 0 3 4294967295\n"),
            &["face 0 refers to vertex 3", "vertex 4294967295"],
        ),
        ("index with a fraction", Ply, ascii("3 0 1 1.5\n"), &["face 0", "1.5"]),
        ("list past the end", Ply, ascii("2000000000 0 1 2\n"), &["face 0", "truncated"]),
        (
            "negative list",
            Ply,
            ply(
                "ascii",
                &format!("{PLY3}{}", FACE.replace("uchar", "int")),
                format!("{points}-3 0 1 2").as_bytes(),
            ),
            &["face 0", "length -3"],
        ),
        (
            "binary list past the end",
            Ply,
            ply("binary_little_endian", &format!("{PLY3}{}", FACE.replace("uchar", "uint")), &[255; 44]),
            &["face 0", "truncated"],
        ),
        ("short binary STL", Stl, vec![b'x'; 50], &["50 bytes"]),
        (
            "truncated binary STL",
            Stl,
            written(Stl, &MeshOut::from(&triangle_cube()))[..600].to_vec(),
            &["12 facets", "contains 10", "truncated"],
        ),
        (
            "huge STL count",
            Stl,
            [vec![b'x'; 80], vec![255; 104]].concat(),
            &["4294967295 facets", "contains 2"],
        ),
        (
            "ascii STL truncated",
            Stl,
            b"solid\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\n".to_vec(),
            &["inside a facet"],
        ),
        (
            "ascii STL quad",
            Stl,
            b"solid\nfacet\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\nendfacet\n".to_vec(),
            &["line 7", "exactly three"],
        ),
        ("ascii STL word", Stl, b"solid\nfacet\nvertex 0 0\n".to_vec(), &["line 3", "number"]),
        ("ascii STL noise", Stl, b"solid\nfacet\nwhat\n".to_vec(), &["line 3", "what"]),
        ("empty OFF", Off, b"# nothing\n".to_vec(), &["empty"]),
        ("OFF of noise", Off, b"hello\n".to_vec(), &["hello", "this is an OFF file"]),
        (
            "OFF truncated",
            Off,
            b"OFF\n900000000000 1 0\n0 0 0\n1 1 1\n".to_vec(),
            &["2 of 900000000000", "truncated"],
        ),
        ("OFF face truncated", Off, b"OFF\n1 1 0\n0 0 0\n999999999 0\n".to_vec(), &["0 of 1", "faces"]),
        (
            "OFF index",
            Off,
            b"OFF\n1 1 0\n0 0 0\n3 0 0 1\n".to_vec(),
            &["face 0 refers to vertex 1", "0 to 0"],
        ),
        ("OFF negative count", Off, b"OFF\n1 1 0\n0 0 0\n-3 0 0 1\n".to_vec(), &["face 0", "-3 corners"]),
        ("COFF without colours", Off, b"COFF\n1 0 0\n0 0 0\n".to_vec(), &["line 3", "red"]),
        ("GLB 1", Glb, glb(|b| b[4] = 1), &["version 1", "convert"]),
        ("GLB truncated", Glb, glb(|b| b.truncate(b.len() - 5)), &["byte", "truncated"]),
        ("GLB without chunks", Glb, glb(|b| b.truncate(12)), &["no JSON chunk"]),
        ("glTF noise", Gltf, b"{\"asset\":[".to_vec(), &["JSON line 1"]),
        (
            "glTF with Draco",
            Gltf,
            gltf("\"asset\"", "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],\"asset\""),
            &["KHR_draco", "without compression"],
        ),
        (
            "glTF huge count",
            Gltf,
            gltf("\"count\":8", "\"count\":18446744073709551615"),
            &["accessor 0", "96 bytes"],
        ),
        (
            "glTF offset",
            Gltf,
            gltf("\"byteOffset\":0", "\"byteOffset\":18446744073709551615"),
            &["past the end"],
        ),
        ("glTF stride 0", Gltf, gltf("\"byteOffset\":0", "\"byteStride\":0"), &["stride of 0"]),
        (
            "glTF index",
            Gltf,
            gltf("\"count\":8", "\"count\":7"),
            &["primitive 0", "out of range", "7 vertices"],
        ),
        ("glTF sparse", Gltf, gltf("\"count\":8", "\"sparse\":{},\"count\":8"), &["sparse"]),
        ("glTF no buffer", Gltf, gltf("data:", "http://data:"), &["another file"]),
        ("glTF mode", Gltf, gltf("\"mode\":4", "\"mode\":9"), &["mode 9"]),
        (
            "glTF node cycle",
            Gltf,
            gltf("{\"mesh\":0}", "{\"mesh\":0,\"children\":[0]}"),
            &["node 0", "twice"],
        ),
        ("glTF missing mesh", Gltf, gltf("{\"mesh\":0}", "{\"mesh\":4}"), &["mesh 4", "there are 1"]),
        (
            "glTF missing accessor",
            Gltf,
            gltf("\"POSITION\":0", "\"POSITION\":7"),
            &["accessor 7", "there are 2"],
        ),
        ("VTP of noise", Vtp, b"<a><b></a>".to_vec(), &["well-formed"]),
        ("VTU", Vtp, vtp("PolyData", "UnstructuredGrid"), &["UnstructuredGrid", "expected"]),
        (
            "VTP with LZ4",
            Vtp,
            vtp("header_type", "compressor=\"vtkLZ4DataCompressor\" header_type"),
            &["vtkLZ4", "uncompressed"],
        ),
        (
            "VTP with false data",
            Vtp,
            vtp("\"binary\">\n", "\"binary\">\n////////////"),
            &["Points", "ends early"],
        ),
        ("VTP type", Vtp, vtp("Float64", "Float16"), &["Float16"]),
        ("VTP offset", Vtp, vtp("format=\"binary\"", "format=\"appended\" offset=\"99\""), &["offset"]),
    ];
    println!("{} malformed files", table.len());
    for (name, format, bytes, words) in table {
        let message = match read_mesh_bytes(&bytes, format) {
            Err(fault) => fault.to_string(),
            Ok(file) => panic!("{format:?} {name}: read as {file:?}"),
        };
        for word in words {
            assert!(message.contains(word), "{format:?} {name}: \"{message}\" does not contain \"{word}\"");
        }
    }
}

#[test]
fn elements_without_properties_take_no_time() {
    let header = format!("{PLY3}element nothing 18446744073709551\nend_header\n");
    let file = read_ply(&ply("ascii", &header, b"0 0 0 0 0 0 0 0 0")).unwrap();
    assert_eq!(file.mesh.vertex_count(), 3);
}

#[test]
fn deep_nesting_does_not_overflow_the_stack() {
    let deep = 200_000;
    let json = format!("{{\"extras\":{}{}}}", "[".repeat(deep), "]".repeat(deep));
    let _ = read_gltf(json.as_bytes());
    let xml = format!("<VTKFile type=\"PolyData\">{}{}</VTKFile>", "<a>".repeat(deep), "</a>".repeat(deep));
    let _ = read_vtp(xml.as_bytes());
    let nodes: Vec<String> = (0..deep).map(|i| format!("{{\"children\":[{}]}}", i + 1)).collect();
    let chain = format!("{{\"nodes\":[{},{{}}]}}", nodes.join(","));
    assert_eq!(read_gltf(chain.as_bytes()).unwrap().mesh.vertex_count(), 0);
}

/// SplitMix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % bound as u64) as usize
    }
}

/// Truncates files and overwrites, repeats and drops parts of them; whatever can still be read has
/// no index out of range.
#[test]
fn no_damage_makes_a_reader_panic() {
    use MeshFormat::*;
    let (triangles, polygons) = (triangle_cube(), polygon_cube());
    let (values, lines) = (vec![0.5; 9], [vec![0, 1, 2]]);
    let mut seeds: Vec<(MeshFormat, Vec<u8>)> = Vec::new();
    for encoding in [Encoding::Binary, Encoding::Ascii] {
        for (format, out) in [
            (Obj, MeshOut::from(&polygons)),
            (Ply, MeshOut::from(&polygons)),
            (Off, MeshOut::from(&polygons)),
            (Vtp, MeshOut::from(&polygons)),
            (Stl, MeshOut::from(&triangles)),
            (Glb, MeshOut::from(&triangles)),
            (Gltf, MeshOut::from(&triangles)),
        ] {
            let vertices = out.positions().len();
            let mut out = out;
            out.encoding = encoding;
            out.vertex_scalars = vec![("a", &values[..vertices])];
            out.lines = &lines;
            seeds.push((format, written(format, &out)));
        }
    }
    seeds.push((Stl, b"solid\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 0 0\nvertex 0 0 0\nendloop\nendfacet\nendsolid\n".to_vec()));
    seeds.push((Obj, b"v 0 0 0\\\n 1 1 1\nv 1 0 0\r\nf 1/1/1 -1//2 \\\r\n 2/ \nl 1 2\n#\\\n\\".to_vec()));
    let interesting = [
        &b"\\\n"[..],
        b"\\",
        b"-1",
        b"99999999999",
        b"\xff\xff\xff\xff",
        b"\0\0\0\0",
        b"#",
        b"\r",
        b"nan",
        b"1e999",
        b"\"",
        b"<",
        b"=",
        b"OFF",
        b"_",
    ];
    let mut random = Random(1);
    let mut read = 0;
    for (format, seed) in &seeds {
        for length in 0..seed.len().min(400) {
            let _ = read_mesh_bytes(&seed[..length], *format);
        }
        for _ in 0..1500 {
            let mut bytes = seed.clone();
            for _ in 0..1 + random.below(4) {
                let at = random.below(bytes.len() + 1);
                let to = (at + random.below(12)).min(bytes.len());
                match random.below(4) {
                    0 => drop(
                        bytes.splice(at..to, interesting[random.below(interesting.len())].iter().copied()),
                    ),
                    1 => drop(bytes.drain(at..to)),
                    2 => bytes[at..to].iter_mut().for_each(|b| *b = random.below(256) as u8),
                    _ => {
                        let part = bytes[at..to].to_vec();
                        bytes.splice(at..at, part);
                    }
                }
            }
            for reader in [*format, MeshFormat::sniff(&bytes).unwrap_or(*format)] {
                if let Ok(file) = read_mesh_bytes(&bytes, reader) {
                    let vertices = file.mesh.vertex_count();
                    let corners = file.mesh.faces().flatten().chain(file.lines.iter().flatten());
                    assert!(corners.into_iter().all(|&v| (v as usize) < vertices));
                    assert!(file.vertex_scalars.iter().all(|(_, values)| values.len() == vertices));
                    assert!(
                        file.face_scalars.iter().all(|(_, values)| values.len() == file.mesh.face_count())
                    );
                    read += 1;
                }
            }
        }
    }
    println!("{read} damaged files could still be read");
}
