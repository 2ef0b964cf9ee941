//! Rarely used parts of glTF, and files as exporters write them.

use crate::FileWarning;
use crate::io::*;
use serde_json::{Value, json};

/// Positions, indices of two triangles, and one sparse index with its value.
fn binary() -> Vec<u8> {
    let floats = [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0f32];
    let mut bytes: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    bytes.extend([2, 0, 0, 0]);
    bytes.extend([5f32, 6., 7.].iter().flat_map(|x| x.to_le_bytes()));
    bytes
}

/// Returns a unit square of two triangles, edited.
fn square(edit: impl Fn(&mut Value)) -> Value {
    let mut root = json!({
        "asset": { "version": "2.0" }, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 48 }, { "buffer": 0, "byteOffset": 48, "byteLength": 12 },
            { "buffer": 0, "byteOffset": 60, "byteLength": 2 }, { "buffer": 0, "byteOffset": 64, "byteLength": 12 },
        ],
        "buffers": [{ "byteLength": binary().len() }],
    });
    edit(&mut root);
    root
}

fn chunk(kind: &[u8; 4], content: &[u8]) -> Vec<u8> {
    [&(content.len() as u32).to_le_bytes()[..], kind, content].concat()
}

/// Returns a `.glb` whose JSON is padded with `padding`, and the length that its header should
/// have.
fn glb(root: &Value, padding: u8) -> (Vec<u8>, u32) {
    let mut json = serde_json::to_vec(root).unwrap();
    json.push(padding);
    json.resize(json.len().next_multiple_of(4), padding);
    let chunks = [chunk(b"JSON", &json), chunk(b"BIN\0", &binary())].concat();
    let length = 12 + chunks.len() as u32;
    ([&b"glTF\x02\0\0\0"[..], &length.to_le_bytes(), &chunks].concat(), length)
}

fn read(edit: impl Fn(&mut Value)) -> MeshFile {
    read_gltf(&glb(&square(edit), b' ').0).unwrap()
}

fn refusal(edit: impl Fn(&mut Value)) -> String {
    read_gltf(&glb(&square(edit), b' ').0).unwrap_err().to_string()
}

const SQUARE: [[f64; 3]; 4] = [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];

// reports.md F7
#[test]
fn the_transform_of_a_skinned_mesh_node_is_ignored() {
    for skinned in [true, false] {
        let file = read(|root| {
            root["nodes"] =
                json!([{ "children": [1], "translation": [7, 0, 0] }, { "mesh": 0, "scale": [10, 10, 10] }]);
            root["skins"] = json!([{ "joints": [0] }]);
            if skinned {
                root["nodes"][1]["skin"] = json!(0);
            }
        });
        if skinned {
            assert_eq!(file.mesh.positions, SQUARE);
            assert_eq!(file.warnings, [FileWarning::SkinnedMeshes { count: 1, first_node: 1 }]);
        } else {
            assert_eq!(file.mesh.positions[2], [17., 10., 0.]);
            assert_eq!(file.warnings.len(), 0);
        }
    }
}

#[test]
fn morph_targets_and_instances_are_ignored_with_a_warning() {
    let file = read(|root| {
        root["meshes"][0]["primitives"][0]["targets"] = json!([{ "POSITION": 0 }]);
        root["meshes"][0]["weights"] = json!([1.0]);
        root["nodes"][0]["extensions"] = json!({ "EXT_mesh_gpu_instancing": { "attributes": {} } });
    });
    assert_eq!(file.mesh.positions, SQUARE);
    let expected = [
        FileWarning::MorphTargets { count: 1, first_mesh: 0 },
        FileWarning::Instances { count: 1, first_node: 0 },
    ];
    assert_eq!(file.warnings, expected);
}

fn sparse(root: &mut Value, accessor: usize) {
    root["accessors"][accessor]["sparse"] = json!({
        "count": 1, "indices": { "bufferView": 2, "componentType": 5123 }, "values": { "bufferView": 3 }
    });
}

// reports.md F15
#[test]
fn sparse_accessors_replace_elements_of_their_view_or_of_zeros() {
    let file = read(|root| sparse(root, 0));
    assert_eq!(file.mesh.positions, [SQUARE[0], SQUARE[1], [5., 6., 7.], SQUARE[3]]);
    let file = read(|root| {
        sparse(root, 0);
        root["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    });
    assert_eq!(file.mesh.positions, [[0.; 3], [0.; 3], [5., 6., 7.], [0.; 3]]);
    // The last corner of the second triangle becomes 1: the first two bytes of view 1 from
    // offset 2.
    let file = read(|root| {
        root["accessors"][1]["sparse"] = json!({
            "count": 1, "indices": { "bufferView": 2, "componentType": 5121 }, "values": { "bufferView": 1, "byteOffset": 2 }
        });
    });
    assert!(file.mesh.faces().eq([[0, 1, 1], [0, 2, 3]]));
    for (edit, words) in [
        (json!({ "count": 9 }), "9 elements of 2 bytes"),
        (json!({ "indices": { "bufferView": 1, "componentType": 5126 } }), "not valid for sparse indices"),
        (
            json!({ "indices": { "bufferView": 3, "componentType": 5125 } }),
            "out of range: there are 4 elements",
        ),
        (json!({ "values": { "bufferView": 9 } }), "buffer view 9"),
        (json!({ "values": {} }), "accessors[0].sparse.values"),
    ] {
        let refusal = refusal(|root| {
            sparse(root, 0);
            for (key, value) in edit.as_object().unwrap() {
                root["accessors"][0]["sparse"][key] = value.clone();
            }
        });
        assert!(refusal.contains(words), "{refusal}");
    }
}

// reports.md F14
#[test]
fn accessors_without_a_buffer_view_are_zeros() {
    let zeros = |count: usize, kind: &str| json!({ "componentType": 5126, "count": count, "type": kind });
    let add = |root: &mut Value, accessor: Value| {
        root["accessors"].as_array_mut().unwrap().push(accessor);
        root["meshes"][0]["primitives"][0]["attributes"]["_W"] = json!(2);
    };
    let file = read(|root| add(root, zeros(4, "SCALAR")));
    assert_eq!(file.vertex_scalars, [("W".to_string(), vec![0.0; 4])]);
    let file = read(|root| root["accessors"][0] = zeros(4, "VEC3"));
    assert_eq!(file.mesh.positions, [[0.0; 3]; 4]);
    let wrong = refusal(|root| add(root, zeros(usize::MAX, "SCALAR")));
    assert!(wrong.contains("_W has 18446744073709551615 values for 4 vertices"), "{wrong}");
    let huge = refusal(|root| root["accessors"][0] = zeros(1 << 40, "VEC3"));
    assert!(huge.contains("accessor 0") && huge.contains("1099511627776 zeros"), "{huge}");
    // The same accessor without data, because it is compressed.
    let draco = refusal(|root| {
        root["accessors"][0] = zeros(4, "VEC3");
        root["meshes"][0]["primitives"][0]["extensions"] = json!({ "KHR_draco_mesh_compression": {} });
    });
    assert!(draco.contains("without compression"), "{draco}");
}

// reports.md F16, F17
#[test]
fn padded_chunks_and_trailing_bytes_are_accepted() {
    let whole = read(|_| {});
    let (nul, _) = glb(&square(|_| {}), 0);
    assert_eq!(read_gltf(&nul).unwrap(), whole);
    let (plain, length) = glb(&square(|_| {}), b' ');
    for tail in [&b"\n"[..], b"\0", &[0; 7], &[0; 8], &[0; 12], b"\r\n\0"] {
        assert_eq!(read_gltf(&[&plain, tail].concat()).unwrap(), whole, "{tail:?}");
    }
    let junk = read_gltf(&[&plain[..], b"appendix"].concat()).unwrap();
    let declared = format!("{length} bytes");
    assert_eq!(junk.warnings, [FileWarning::TrailingBytes { bytes: 8, declared }]);
    assert_eq!(junk.mesh, whole.mesh);
    for declared in [0, 12, 13, length - 1, length + 1, u32::MAX] {
        let mut bytes = plain.clone();
        bytes[8..12].copy_from_slice(&declared.to_le_bytes());
        assert_eq!(read_gltf(&bytes).unwrap(), whole, "{declared}");
    }
    for cut in 1..binary().len() {
        let refusal = read_gltf(&plain[..plain.len() - cut]).unwrap_err().to_string();
        assert!(refusal.contains("truncated"), "{refusal}");
    }
}

// reports.md F11
#[test]
fn a_missing_buffer_is_an_error_only_if_it_is_needed() {
    let folder = super::Folder::new("gltf-buffers");
    let path = folder.0.join("k.gltf");
    let external = |uri: &str| square(|root| root["buffers"][0]["uri"] = json!(uri));
    let refusal = |uri: &str| {
        std::fs::write(&path, external(uri).to_string()).unwrap();
        read_mesh(&path).unwrap_err().to_string()
    };
    let missing = refusal("missing%20one.bin");
    assert!(missing.contains("k.gltf: glTF, buffer 0: its file missing one.bin does not exist"), "{missing}");
    std::fs::create_dir(folder.0.join("folder.bin")).unwrap();
    let unreadable = refusal("folder.bin");
    assert!(unreadable.contains("folder.bin can not be read"), "{unreadable}");
    std::fs::write(folder.0.join("short.bin"), [0; 9]).unwrap();
    let short = refusal("short.bin");
    assert!(short.contains("it has 9 bytes instead of 76"), "{short}");
    assert!(refusal("data:;base64,!!").contains("not base64"));
    let file = read(|root| {
        root["buffers"].as_array_mut().unwrap().push(json!({ "byteLength": 1, "uri": "sound.bin" }))
    });
    assert_eq!(file.mesh.positions, SQUARE);
}

// reports.md, "expected usize"
#[test]
fn json_errors_give_the_place_without_rust_types() {
    let cases: [(fn(&mut Value), &[&str]); 8] = [
        (
            |r| r["accessors"][0]["count"] = json!("four"),
            &["accessors[0].count", "expected an integer", "string \"four\""],
        ),
        (
            |r| r["accessors"][1]["bufferView"] = json!(-1),
            &["accessors[1].bufferView", "expected an integer", "`-1`"],
        ),
        (|r| r["nodes"][0]["mesh"] = json!(0.5), &["nodes[0].mesh", "`0.5`", "expected an integer"]),
        (|r| r["nodes"] = json!({}), &["nodes", "expected an array, found an object"]),
        (|r| r["buffers"][0] = json!("x"), &["buffers[0]", "expected an object"]),
        (|r| r["nodes"][0]["translation"] = json!([1, 2]), &["nodes[0].translation", "length 2", "length 3"]),
        (|r| r["nodes"][0]["scale"] = json!([1, 2, "3"]), &["nodes[0].scale[2]", "expected a number"]),
        (|r| r["accessors"][0] = json!({}), &["accessors[0]", "the member \"componentType\" is missing"]),
    ];
    for (edit, words) in cases {
        let refusal = refusal(edit);
        assert!(words.iter().all(|w| refusal.contains(w)), "{refusal}");
        for type_name in ["usize", "u32", "f64", "struct", "sequence", "map", " at line"] {
            assert!(!refusal.contains(type_name), "{refusal}");
        }
    }
    let broken = read_gltf(b"{\n\"asset\": }").unwrap_err().to_string();
    assert!(broken.contains("JSON line 2, column 10"), "{broken}");
    assert!(read_gltf(b"{} junk").unwrap_err().to_string().contains("trailing"));
}
