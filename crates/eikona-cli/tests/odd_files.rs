//! Files from the field: what the command says of them, and what it writes for them.

mod run;

use run::{Folder, grid_obj};
use std::fs;

/// A square of 20 by 20 cells of 5 cm in UTM coordinates, and the line across its middle.
fn utm() -> (String, &'static str) {
    let mut text = String::new();
    for k in 0..441 {
        let (x, y) = (f64::from(k % 21), f64::from(k / 21));
        text += &format!("v {} {} 100\n", 500_000.25 + 0.05 * x, 4_649_776.125 + 0.05 * y);
    }
    for k in 0..400 {
        let a = k % 20 + k / 20 * 21 + 1;
        text += &format!("f {a} {} {}\nf {a} {} {}\n", a + 1, a + 22, a + 22, a + 21);
    }
    (text, "v 500000.75 4649776.125 100\nv 500000.75 4649777.125 100\nl 1 2\n")
}

// reports.md F4
#[test]
fn utm_coordinates_survive_in_gltf_and_are_warned_of_in_stl() {
    let folder = Folder::new();
    let (mesh, curve) = utm();
    folder.write("u.obj", &mesh);
    folder.write("c.obj", curve);
    for output in ["sdf u.obj --curve c.obj -o o.glb", "winding u.obj --curve c.obj --split o.glb"] {
        assert!(!folder.done(&format!("{output} --strict")).text().contains("warning"), "{output}");
        let facts = folder.done("inspect o.glb").text();
        assert!(
            facts
                .contains("1.000000 x 1.000000 x 0.000000, from (500000.250000, 4649776.125000, 100.000000)"),
            "{facts}"
        );
    }
    folder.warned(
        "winding u.obj --curve c.obj --split us.stl",
        &["us.stl", "378 of 441 positions then coincide", "write .ply"],
    );
    folder.warned("inspect us.stl", &["720 of 800 faces", "32-bit floats", "0.5 apart"]);
}

// reports.md F11
#[test]
fn a_gltf_file_without_its_buffer_names_the_buffer() {
    let folder = Folder::new();
    folder.write(
        "k.gltf",
        r#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
        "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"missing.bin"}]}"#,
    );
    folder.refused("inspect k.gltf", 3, &["k.gltf", "buffer 0", "missing.bin does not exist"]);
    folder.refused("inspect absent.gltf", 3, &["absent.gltf: there is no such file"]);
}

// reports.md, wrong extension
#[test]
fn a_mesh_is_treated_by_its_content_and_not_by_its_name() {
    let folder = Folder::new();
    folder.write("grid.obj", &grid_obj());
    folder.done("make grid nx=2 ny=2 -o grid.ply");
    folder.done("make grid nx=2 ny=2 -o grid.stl");
    fs::rename(folder.0.join("grid.ply"), folder.0.join("p.stl")).unwrap();
    fs::rename(folder.0.join("grid.stl"), folder.0.join("s.ply")).unwrap();
    folder.warned("inspect p.stl", &["the file name suggests STL, but the content is PLY"]);
    folder.warned("inspect s.ply", &["the file name suggests PLY, but the content is STL"]);
    for name in ["p.stl", "s.ply"] {
        let facts = folder.done(&format!("inspect {name}")).text();
        assert!(facts.contains("9 vertices") && facts.contains("8 triangles"), "{facts}");
    }
}

// reports.md F5
#[test]
fn meshes_and_curves_in_utf_16_give_the_same_distance() {
    let folder = Folder::new();
    let curve = "v 5 0 0\nv 5 2 0\nl 1 2\n";
    let wide = |text: &str| {
        let units = text.encode_utf16().flat_map(u16::to_le_bytes);
        b"\xff\xfe".iter().copied().chain(units).collect::<Vec<u8>>()
    };
    folder.write("g.obj", &grid_obj());
    folder.write("c.obj", curve);
    fs::write(folder.0.join("g16.obj"), wide(&grid_obj())).unwrap();
    fs::write(folder.0.join("c16.obj"), wide(curve)).unwrap();
    folder.done("sdf g.obj --curve c.obj -o d.csv");
    folder.done("sdf g16.obj --curve c16.obj -o d16.csv");
    assert_eq!(folder.read("d.csv"), folder.read("d16.csv"));
}

#[test]
fn a_file_whose_faces_were_all_dropped_is_not_called_empty() {
    let folder = Folder::new();
    folder.write("d.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    folder.refused(
        "sdf d.obj --points 0 --drop-degenerate -o o.csv",
        3,
        &["the repairs dropped all 1 faces"],
    );
    folder.write("e.obj", "v 0 0 0\n");
    folder.refused("sdf e.obj --points 0 -o o.csv", 3, &["there are no faces in this file"]);
}
