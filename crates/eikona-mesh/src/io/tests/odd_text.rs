//! Text encodings, PLY files whose header and body disagree, OBJ lines that end in a backslash.

use super::{polygon_cube, triangle_cube, written};
use crate::FileWarning;
use crate::io::*;

/// Returns a text in the encodings of Windows, with and without a byte-order mark.
fn encodings(text: &str) -> Vec<(&'static str, Vec<u8>)> {
    let units: Vec<u16> = text.encode_utf16().collect();
    let little: Vec<u8> = units.iter().flat_map(|u| u.to_le_bytes()).collect();
    let big: Vec<u8> = units.iter().flat_map(|u| u.to_be_bytes()).collect();
    let wide: Vec<u8> = text.chars().flat_map(|c| (c as u32).to_le_bytes()).collect();
    let wide_big: Vec<u8> = text.chars().flat_map(|c| (c as u32).to_be_bytes()).collect();
    vec![
        ("UTF-8 with mark", [b"\xef\xbb\xbf", text.as_bytes()].concat()),
        ("UTF-16 LE with mark", [b"\xff\xfe", little.as_slice()].concat()),
        ("UTF-16 BE with mark", [b"\xfe\xff", big.as_slice()].concat()),
        ("UTF-16 LE", little),
        ("UTF-16 BE", big),
        ("UTF-32 LE with mark", [b"\xff\xfe\0\0", wide.as_slice()].concat()),
        ("UTF-32 LE", wide),
        ("UTF-32 BE", wide_big),
    ]
}

// reports.md F5
#[test]
fn every_text_format_is_read_in_utf_16() {
    let square = "# gr\u{f6}\u{df}e \u{4e2d} \u{1f600}\r\nv 0 0 0\r\nv 10 0 0\r\nv 10 10 0\r\nv 0 10 0\r\nf 1 2 3\r\nf 1 3 4\r\n";
    for (name, bytes) in encodings(square) {
        assert_eq!(MeshFormat::sniff(&bytes), Some(MeshFormat::Obj), "{name}");
        let mesh = read_obj(&bytes).unwrap().mesh;
        assert_eq!(mesh.positions, [[0., 0., 0.], [10., 0., 0.], [10., 10., 0.], [0., 10., 0.]], "{name}");
        assert!(mesh.faces().eq([[0, 1, 2], [0, 2, 3]]), "{name}");
    }
    let cube = triangle_cube();
    let mut out = MeshOut::from(&cube);
    out.encoding = Encoding::Ascii;
    use MeshFormat::{Gltf, Obj, Off, Ply, Stl, Vtp};
    for format in [Obj, Off, Ply, Stl, Vtp, Gltf] {
        let text = String::from_utf8(written(format, &out)).unwrap();
        let plain = read_mesh_bytes(text.as_bytes(), format).unwrap();
        for (name, bytes) in encodings(&text) {
            assert_eq!(MeshFormat::sniff(&bytes), Some(format), "{name}");
            assert_eq!(read_mesh_bytes(&bytes, format).unwrap(), plain, "{format:?} {name}");
        }
    }
}

#[test]
fn binary_data_in_utf_16_is_an_error() {
    let ply = written(MeshFormat::Ply, &MeshOut::from(&polygon_cube()));
    let as_text: String = ply.iter().map(|&b| char::from(b)).collect();
    for (name, bytes) in encodings(&as_text).into_iter().skip(1) {
        let refusal = read_ply(&bytes).unwrap_err().to_string();
        assert!(refusal.contains("UTF-16") && refusal.contains("copy it again"), "{name}: {refusal}");
    }
    let vtp =
        "<VTKFile type=\"PolyData\"><PolyData/><AppendedData encoding=\"raw\">_abc</AppendedData></VTKFile>";
    let refusal = read_vtp(&encodings(vtp)[1].1).unwrap_err().to_string();
    assert!(refusal.contains("UTF-16"), "{refusal}");
}

const PLY: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
    property list uchar int vertex_indices\nend_header\n";
const BODY: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n";

fn ascii_ply(header: &str, body: &str) -> Result<MeshFile, crate::FileError> {
    read_ply(format!("ply\nformat ascii 1.0\n{header}{body}").as_bytes())
}

fn binary_ply(tail: &[u8]) -> MeshFile {
    let mut bytes = format!("ply\nformat binary_little_endian 1.0\n{PLY}").into_bytes();
    let floats = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0f32];
    bytes.extend(floats.iter().flat_map(|x| x.to_le_bytes()));
    bytes.push(3);
    bytes.extend([0i32, 1, 2].iter().flat_map(|i| i.to_le_bytes()));
    bytes.extend(tail);
    read_ply(&bytes).unwrap()
}

// reports.md F21
#[test]
fn content_beyond_the_ply_header_is_ignored_with_a_warning() {
    let more = ascii_ply(PLY, &format!("{BODY}3 0 2 3\n")).unwrap();
    assert_eq!(more.mesh.face_count(), 1);
    let declared = "4 vertex, 1 face".to_string();
    assert_eq!(more.warnings, [FileWarning::TrailingLines { line: 15, declared: declared.clone() }]);
    assert_eq!(ascii_ply(PLY, &format!("{BODY}\n  \n")).unwrap().warnings.len(), 0);
    let second_face: Vec<u8> =
        [3].into_iter().chain([0i32, 2, 3].iter().flat_map(|i| i.to_le_bytes())).collect();
    let more = binary_ply(&second_face);
    assert_eq!(more.mesh.face_count(), 1);
    assert_eq!(more.warnings, [FileWarning::TrailingBytes { bytes: 13, declared }]);
    for filling in [&b""[..], b"\n", b"\r\n", &[0; 7]] {
        assert_eq!(binary_ply(filling).warnings.len(), 0);
    }
    let less = ascii_ply(&PLY.replace("face 1", "face 2"), BODY).unwrap_err().to_string();
    assert!(
        less.contains("face 1") && less.contains("declares 2") && less.contains("or its header is wrong"),
        "{less}"
    );
}

#[test]
fn ply_lines_that_do_not_match_the_header_are_errors() {
    let with_normals = BODY.replace("0\n1", "0 0 0 1\n1").replace("1 1 0\n", "1 1 0 0 0 1\n");
    let refusal = ascii_ply(PLY, &with_normals).unwrap_err().to_string();
    assert!(
        refusal.contains("line 10: the line has 6 values") && refusal.contains("3 properties"),
        "{refusal}"
    );
    let refusal = ascii_ply(PLY, &BODY.replace("1 1 0", "1 1")).unwrap_err().to_string();
    assert!(refusal.contains("line 12: the line has 2 values"), "{refusal}");
    // Without a line per element, the words decide.
    assert_eq!(ascii_ply(PLY, &BODY.replace('\n', " ")).unwrap().mesh.positions[2], [1., 1., 0.]);
}

#[test]
fn ply_properties_with_the_same_name_are_renamed() {
    let header =
        PLY.replace("float z\n", "float z\nproperty float a\nproperty float a_2\nproperty float a\n");
    let file = ascii_ply(&header, "0 0 0 1 2 3\n0 0 0 1 2 3\n0 0 0 1 2 3\n0 0 0 1 2 3\n3 0 1 2\n").unwrap();
    let names: Vec<(&str, f64)> = file.vertex_scalars.iter().map(|(n, v)| (n.as_str(), v[0])).collect();
    assert_eq!(names, [("a", 1.0), ("a_2", 2.0), ("a_3", 3.0)]);
    assert_eq!(file.warnings.len(), 1, "{:?}", file.warnings);
}

// reports.md F25
#[test]
fn a_backslash_does_not_swallow_the_next_obj_statement() {
    let square = |name: &str| format!("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n{name}f 1 2 3\nf 1 3 4\n");
    for name in [
        "g part\\\n",
        "g \\\r\n",
        "o C:\\x\\\n",
        "usemtl a\\\n",
        "mtllib a.mtl \\\n",
        "s 1\\\n",
        "vn 0 0 1 \\\n",
        "vt 0 0\\\n",
    ] {
        let file = read_obj(square(name).as_bytes()).unwrap();
        assert_eq!(file.mesh.face_count(), 2, "{name}");
        assert_eq!(file.warnings, [FileWarning::UnjoinedLine { line: 5 }], "{name}");
    }
    let faces = read_obj(square("f 1 2 4 \\\n").as_bytes()).unwrap();
    assert_eq!((faces.mesh.face_count(), faces.warnings.len()), (3, 1));
    // Continued lines may contain names and numbers.
    for joined in ["g part \\\n one\n", "g a \\\nv\n", "g \\\nf alpha\n", "# comment \\\n", "curv2 0 \\\n1\n"]
    {
        let file = read_obj(square(joined).as_bytes()).unwrap();
        assert_eq!((file.mesh.face_count(), file.warnings.len()), (2, 0), "{joined}");
    }
    let split = read_obj(square("").replace("f 1 3 4", "f 1 \\\n3 \\\r\n 4").as_bytes()).unwrap();
    assert_eq!((split.mesh.face(1), split.warnings.len()), (&[0, 2, 3][..], 0));
}
