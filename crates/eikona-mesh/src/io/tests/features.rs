//! Optional features of each format that its reader supports.

use super::triangle_cube;
use crate::io::*;

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

#[test]
fn obj_syntax_variants() {
    let text = "\u{feff}# comment \\\nmtllib a\\b.mtl\r\nv\t0 0 0\r\nv 1 0 0 1.0\r\nv 1 1 0 # trailing\r\nvn 0 0 1\r\n\
        v +0 1e0 \\\r\n -0.5\r\nvt 0 0\r\ng side \\\r\nstill the group\r\ncurv2 0 1\r\n\
        f 1/2/3 2//5 3/7 -1\r\nf 1 \\\r\n  2\\\n 5\r\nl 1 2 -1 -4\r\np 1\r\nv nan 1 2\r\nf -1 -2 -3";
    let file = read_obj(text.as_bytes()).unwrap();
    assert_eq!(file.mesh.vertex_count(), 5);
    assert_eq!(file.mesh.positions[3], [0.0, 1.0, -0.5]);
    assert!(file.mesh.positions[4][0].is_nan());
    let faces: Vec<&[u32]> = file.mesh.faces().collect();
    assert_eq!(faces, [&[0, 1, 2, 3][..], &[0, 1, 4], &[4, 3, 2]]);
    assert_eq!(file.lines, [[0, 1, 3, 0]]);
    assert_eq!(file.corner_uvs, None, "not every corner has texture coordinates");
    let refusal = file.mesh.triangulate().unwrap_err().to_string();
    assert!(refusal.contains("vertex 4") && refusal.contains("not finite"), "{refusal}");
    let old_mac = read_obj(b"v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r").unwrap();
    assert_eq!(old_mac.mesh.face_count(), 1);
    let colours = read_obj(b"v 0 0 0\nv 1 0 0 .5 .25 1\nv 0 1 0 1 1 1 1\n").unwrap();
    assert_eq!(colours.vertex_scalars[1].1[1..], [0.25, 1.0]);
    assert!(colours.vertex_scalars[1].1[0].is_nan());
    assert_eq!(colours.warnings.len(), 1);
}

const PLY_HEADER: &str = "comment made by hand\r\nobj_info none\r\nelement vertex 4\r\nproperty short x\r\nproperty double y\r\n\
    property float32 z\r\nproperty list uint8 float weights\r\nproperty uint16 label\r\nelement material 2\r\nproperty int shine\r\n\
    property list short char names\r\nelement face 2\r\nproperty uchar flags\r\nproperty list int16 float64 vertex_index\r\n\
    element tristrips 1\r\nproperty list int int vertex_indices\r\nend_header\r\n";

/// Returns the body of `PLY_HEADER`, in either byte order.
fn ply_body(big_endian: bool) -> Vec<u8> {
    let mut body = Vec::new();
    let mut put = |bytes: &[u8]| {
        if big_endian { body.extend(bytes.iter().rev()) } else { body.extend(bytes) }
    };
    for i in 0..4i16 {
        // The first byte is a line end: the header must not consume it.
        put(&(10 - i).to_le_bytes());
        put(&(0.1 * f64::from(i)).to_le_bytes());
        put(&0.5f32.to_le_bytes());
        put(&[i as u8]);
        (0..i).for_each(|_| put(&7f32.to_le_bytes()));
        put(&(40000 + i as u16).to_le_bytes());
    }
    for _ in 0..2 {
        put(&1i32.to_le_bytes());
        put(&2i16.to_le_bytes());
        put(&[1]);
        put(&[2]);
    }
    for face in [[0., 1., 2.], [3., 2., 1.]] {
        put(&[200]);
        put(&3i16.to_le_bytes());
        face.iter().for_each(|v: &f64| put(&v.to_le_bytes()));
    }
    let strip = [0i32, 1, 2, 3, -1, 3, 3, 1, 0];
    put(&(strip.len() as i32).to_le_bytes());
    strip.iter().for_each(|v| put(&v.to_le_bytes()));
    body
}

#[test]
fn obj_texture_coordinates_are_kept_if_every_corner_has_them() {
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5 1 0\nvt 0.25\nvt x 2\n";
    let uvs = |faces: &str| read_obj(format!("{corners}{faces}").as_bytes()).unwrap().corner_uvs;
    assert_eq!(uvs("f 1/1 2/2/9 3/-3/\nl 1/3 2"), Some(vec![[0.5, 1.0], [0.25, 0.0], [0.5, 1.0]]));
    assert_eq!(uvs("f 1/4 2/1 3/1\nvt 7 8\n").unwrap()[0], [7.0, 8.0]);
    assert!(uvs("f 1/3 2/3 3/3").unwrap().iter().all(|uv| uv[0].is_nan() && uv[1] == 2.0));
    for without in
        ["", "f 1 2 3", "f 1/1 2/1 3", "f 1/1 2/1 3//1", "f 1/1 2/1 3/4", "f 1/1 2/1 3/0", "f 1/1 2/1 3/-4"]
    {
        assert_eq!(uvs(without), None, "{without}");
    }
    assert_eq!(uvs("f 1/9223372036854775807 2/-9223372036854775808 3/1"), None);
}

#[test]
fn ply_in_both_byte_orders_with_lists_strips_and_other_elements() {
    let ascii_body = "10 0 .5 0 40000  9 0.1 .5 1 7 40001\n8 0.2 .5 2 7 7 40002\n7 0.30000000000000004 .5 3 7 7 7 40003\n\
        1 2 1 2\n1 2 1 2\n200 3 0 1 2\n200 3 3.0 2 1\n9 0 1 2 3 -1 3 3 1 0";
    let whole = |format: &str, body: &[u8]| {
        [format!("ply\r\nformat {format} 1.0\r\n{PLY_HEADER}").as_bytes(), body].concat()
    };
    let ascii = read_ply(&whole("ascii", ascii_body.as_bytes())).unwrap();
    let little = read_ply(&whole("binary_little_endian", &ply_body(false))).unwrap();
    let big = read_ply(&whole("binary_big_endian", &ply_body(true))).unwrap();
    assert_eq!(ascii.mesh, little.mesh);
    assert_eq!(big.mesh, little.mesh);
    assert_eq!(little.mesh.positions[3], [7.0, 0.1 * 3.0, 0.5]);
    let faces: Vec<&[u32]> = little.mesh.faces().collect();
    // Strip 0 1 2 3 gives (0 1 2) and, reversed, (2 1 3); strip 3 3 1 0 gives a stitch and,
    // reversed, (1 3 0).
    assert_eq!(faces, [[0, 1, 2], [3, 2, 1], [0, 1, 2], [2, 1, 3], [1, 3, 0]]);
    assert_eq!(little.vertex_scalars, [("label".to_string(), vec![40000.0, 40001.0, 40002.0, 40003.0])]);
    assert_eq!(little.face_scalars[0].1[..2], [200.0, 200.0]);
    assert!(little.face_scalars[0].1[2..].iter().all(|x| x.is_nan()));
    assert_eq!(big.warnings, ascii.warnings);
    assert_eq!(big.warnings.len(), 3, "{:?}", big.warnings);
}

#[test]
fn stl_that_begins_with_solid_may_still_be_binary() {
    let mut bytes = b"solid facet normal".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(1u32.to_le_bytes());
    bytes.extend(floats(&[0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0.5]));
    bytes.extend([0, 0]);
    let file = read_stl(&bytes).unwrap();
    assert_eq!(file.mesh.positions, [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.5]]);
    bytes.extend(b"appendix");
    let file = read_stl(&bytes).unwrap();
    assert_eq!((file.mesh.face_count(), file.warnings.len()), (1, 1));
    let ascii = "SOLID a vertex of a name\n FACET NORMAL 0 0 1\n  OUTER LOOP\n   VERTEX 0 0 0\n   VERTEX 1 0 0\n   \
        VERTEX 0 1 1.#QNAN\n  ENDLOOP\n ENDFACET\nENDSOLID\nsolid b\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\n\
        vertex 0 0 0\nvertex 0 0 0\nendloop\nendfacet\nendsolid b\n";
    let file = read_stl(ascii.as_bytes()).unwrap();
    assert_eq!((file.mesh.face_count(), file.warnings.len()), (2, 0));
    assert!(file.mesh.positions[2][2].is_nan());
}

#[test]
fn off_with_every_keyword() {
    let body = "3 1 0\n0 0 0 # first\n\n1 0 0\n0 1 0\n3 0 1 2 255 0 0\n";
    for text in [
        format!("OFF\n{body}"),
        format!("# c\nOFF {body}"),
        body.to_string(),
        format!("OFF # made by hand\r\n# c\r\n{body}"),
        "OFF 3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 0.5 0.5 0.5 1\n".to_string(),
    ] {
        let file = read_off(text.as_bytes()).unwrap();
        assert_eq!((file.mesh.vertex_count(), file.mesh.face(0)), (3, &[0, 1, 2][..]), "{text}");
        assert_eq!(file.warnings.len(), 0);
        assert!(MeshFormat::sniff(text.as_bytes()) == Some(MeshFormat::Off) || text == body);
    }
    let coff = read_off(b"COFF\n1 0 0\n0 0 0 255 128 0 255\n").unwrap();
    assert_eq!(coff.vertex_scalars[1], ("green".to_string(), vec![128.0]));
    let both = read_off(b"STCNOFF\n1 0 0\n0 0 0  0 0 1  0.5 0.25 0 1  0 0\n").unwrap();
    assert_eq!(both.vertex_scalars[2], ("nz".to_string(), vec![1.0]));
    assert_eq!(both.vertex_scalars[4], ("green".to_string(), vec![0.25]));
    for (text, words) in [("4OFF\n1 0 0\n0 0 0 1\n", "three coordinates"), ("OFF BINARY\n", "binary OFF")] {
        let refusal = read_off(text.as_bytes()).unwrap_err().to_string();
        assert!(refusal.contains(words), "{refusal}");
    }
}

/// Returns a glTF file of four points on a 2 by 1 rectangle, with these primitives and nodes.
fn gltf(primitives: &str, nodes: &str) -> String {
    let mut bytes = floats(&[0., 0., 0., 2., 0., 0., 0., 1., 0., 2., 1., 0.]);
    bytes.extend([0u8, 1, 2, 3]);
    bytes.extend([0u16, 1, 2].iter().flat_map(|i| i.to_le_bytes()));
    let uri = super::super::base64::encode(&bytes);
    format!(
        r#"{{"asset":{{"version":"2.0"}},"meshes":[{{"primitives":[{primitives}]}}],"nodes":[{nodes}],
        "buffers":[{{"byteLength":{},"uri":"data:application/octet-stream;base64,{uri}"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":10}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},
        {{"bufferView":1,"componentType":5121,"count":4,"type":"SCALAR"}},
        {{"bufferView":1,"byteOffset":4,"componentType":5123,"count":3,"type":"SCALAR"}},
        {{"bufferView":0,"componentType":5126,"count":12,"type":"SCALAR"}}]}}"#,
        bytes.len()
    )
}

#[test]
fn gltf_strips_fans_lines_and_shared_vertices() {
    let primitives = r#"{"attributes":{"POSITION":0},"indices":1,"mode":5},{"attributes":{"POSITION":0},"indices":1,"mode":6},
        {"attributes":{"POSITION":0},"indices":2},{"attributes":{"POSITION":0},"mode":2},{"attributes":{"POSITION":0},"mode":3},
        {"attributes":{"POSITION":0},"indices":1,"mode":1},{"attributes":{"POSITION":0},"mode":0}"#;
    let file = read_gltf(gltf(primitives, "").as_bytes()).unwrap();
    let faces: Vec<&[u32]> = file.mesh.faces().collect();
    assert_eq!(faces, [[0, 1, 2], [2, 1, 3], [0, 1, 2], [0, 2, 3], [0, 1, 2]]);
    assert_eq!(file.mesh.vertex_count(), 4);
    assert_eq!(file.lines, [vec![0, 1, 2, 3, 0], vec![0, 1, 2, 3], vec![0, 1], vec![2, 3]]);
    let mirrored = read_gltf(gltf(primitives, r#"{"mesh":0,"scale":[-1,1,1]}"#).as_bytes()).unwrap();
    let turned: Vec<&[u32]> = mirrored.mesh.faces().collect();
    assert_eq!(turned, [[1, 0, 2], [1, 2, 3], [0, 2, 1], [0, 3, 2], [0, 2, 1]]);
    assert_eq!(mirrored.mesh.positions[1], [-2.0, 0.0, 0.0]);
}

#[test]
fn gltf_nodes_place_their_meshes() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    // A quarter turn about z with scale 3, inside a translation; and a copy by a matrix.
    let nodes = format!(
        r#"{{"children":[1],"translation":[10,0,0]}},{{"mesh":0,"rotation":[0,0,{half},{half}],"scale":[3,3,3]}},
        {{"mesh":0,"matrix":[1,0,0,0, 0,2,0,0, 0,0,1,0, 0,0,5,1]}}"#
    );
    let file = read_gltf(gltf(r#"{"attributes":{"POSITION":0},"indices":2}"#, &nodes).as_bytes()).unwrap();
    assert_eq!((file.mesh.vertex_count(), file.mesh.face_count()), (8, 2));
    for (read, expected) in
        [(file.mesh.positions[3], [7.0, 6.0, 0.0]), (file.mesh.positions[7], [2.0, 2.0, 5.0])]
    {
        assert!(read.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{read:?}");
    }
    assert_eq!(file.mesh.face(1), [4, 5, 6]);
}

fn vtp(attributes: &str, arrays: [&str; 4], appended: &[u8]) -> Vec<u8> {
    let [points, heights, connectivity, offsets] = arrays;
    let array = |name: &str, kind: &str, rest: &str| {
        let tail = if rest.starts_with("offset") || rest.is_empty() { "" } else { ">" };
        match tail {
            "" => format!(r#"<DataArray type="{kind}" Name="{name}" format="appended" {rest}/>"#),
            _ => format!(r#"<DataArray type="{kind}" Name="{name}" {rest}</DataArray>"#),
        }
    };
    let head = format!(
        r#"<?xml version="1.0"?><!-- c --><VTKFile type="PolyData" {attributes}><PolyData><Piece NumberOfPoints="3">
        <PointData>{}</PointData><Points>{}</Points><Polys>{}{}</Polys></Piece></PolyData>"#,
        array("height &amp; more", "Float32", heights),
        array("Points", "Float32", points),
        array("connectivity", "Int32", connectivity),
        array("offsets", "Int64", offsets)
    );
    [head.as_bytes(), appended, b"</VTKFile>"].concat()
}

#[test]
fn vtp_ascii_raw_base64_and_zlib() {
    let points = floats(&[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
    let heights = floats(&[0.5, 1.5, 2.5]);
    let connectivity: Vec<u8> = [0i32, 1, 2].iter().flat_map(|i| i.to_le_bytes()).collect();
    let offsets = 3i64.to_le_bytes().to_vec();
    let arrays = [points, heights, connectivity, offsets];
    let check = |bytes: &[u8], name: &str| {
        let file = read_vtp(bytes).unwrap_or_else(|fault| panic!("{name}: {fault}"));
        assert_eq!(file.mesh.positions, [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]], "{name}");
        assert_eq!(file.mesh.face(0), [0, 1, 2]);
        assert_eq!(file.vertex_scalars, [("height & more".to_string(), vec![0.5, 1.5, 2.5])]);
        assert_eq!(MeshFormat::sniff(bytes), Some(MeshFormat::Vtp));
    };
    let ascii = [">0 0 0 1 0 0 0 1 0", "format=\"ascii\">\n.5 1.5 2.5\n", ">0 1 2", ">3"];
    check(&vtp("", ascii, b""), "ascii");

    let appended = |pieces: [Vec<u8>; 4], encoding: &str, attributes: &str| {
        let mut data = format!("<AppendedData encoding=\"{encoding}\">\n _").into_bytes();
        let mut offset = 0;
        let places = pieces.map(|piece| {
            let place = format!("offset=\"{offset}\"");
            offset += piece.len();
            data.extend(piece);
            place
        });
        data.extend(b"</AppendedData>");
        vtp(attributes, places.each_ref().map(String::as_str), &data)
    };
    let raw = |bytes: &Vec<u8>| [&(bytes.len() as u32).to_le_bytes()[..], bytes].concat();
    check(&appended(arrays.each_ref().map(raw), "raw", ""), "raw");
    let base64 = |bytes: &Vec<u8>| super::super::base64::encode(&raw(bytes)).into_bytes();
    check(&appended(arrays.each_ref().map(base64), "base64", ""), "base64");
    // Two blocks if there is enough data; the header is encoded separately.
    let zlib = |bytes: &Vec<u8>| {
        let size = bytes.len().div_ceil(2) / 4 * 4 + 4;
        let blocks: Vec<Vec<u8>> = bytes
            .chunks(size)
            .map(|b| {
                let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
                std::io::Write::write_all(&mut encoder, b).unwrap();
                encoder.finish().unwrap()
            })
            .collect();
        let header = [blocks.len(), size, bytes.len() % size].into_iter().chain(blocks.iter().map(Vec::len));
        let header: Vec<u8> = header.flat_map(|n| (n as u64).to_le_bytes()).collect();
        [super::super::base64::encode(&header), super::super::base64::encode(&blocks.concat())]
            .concat()
            .into_bytes()
    };
    let attributes = r#"header_type="UInt64" compressor="vtkZLibDataCompressor""#;
    check(&appended(arrays.each_ref().map(zlib), "base64", attributes), "zlib");
}

#[test]
fn base64_of_every_length() {
    for n in 0..20u8 {
        let bytes: Vec<u8> = (0..n).map(|i| i.wrapping_mul(91)).collect();
        let text = super::super::base64::encode(&bytes);
        assert_eq!(text.len() % 4, 0);
        assert_eq!(super::super::base64::Decoder::new(text.as_bytes()).read_all(), Some(bytes));
    }
    assert_eq!(super::super::base64::encode(b"eikona"), "ZWlrb25h");
    assert_eq!(super::super::base64::Decoder::new(b"ZQ== aW\nth").read_all(), Some(b"eika".to_vec()));
    assert_eq!(super::super::base64::Decoder::new(b"ZW!h").read_all(), None);
}

#[test]
fn a_written_binary_stl_does_not_begin_like_an_ascii_one() {
    let bytes = super::written(MeshFormat::Stl, &MeshOut::from(&triangle_cube()));
    assert!(!bytes.starts_with(b"solid"));
    assert_eq!(bytes.len(), 84 + 12 * 50);
}
