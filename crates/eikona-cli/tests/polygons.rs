//! Nonconvex polygons and polygons with holes on the command line.

mod run;

use eikona_mesh::io::read_mesh;
use run::Folder;
use serde_json::{Value, json};

/// A hexagon of area 3 whose fan from the first corner folds over.
const L: &str = "v 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nv 0 0 0\nf 1 2 3 4 5 6\n";
/// A square of side 3 with a hole of side 1, as one polygon with a bridge.
const KEYHOLE: &str = "v 0 0 0\nv 3 0 0\nv 3 3 0\nv 0 3 0\nv 1 1 0\nv 1 2 0\nv 2 2 0\nv 2 1 0\n\
                       f 1 2 3 4 1 5 6 7 8 5\n";

fn inspected(folder: &Folder, words: &str) -> Value {
    serde_json::from_str(&folder.done(&format!("inspect --json {words}")).text()).unwrap()
}

#[track_caller]
fn near(value: &Value, expected: f64) {
    let value = value.as_f64().unwrap();
    assert!((value - expected).abs() < 1e-9, "{value} instead of {expected}");
}

// reports.md F2
#[test]
fn an_l_has_area_3_planar_distances_and_regions_of_area_2_and_1() {
    let folder = Folder::new();
    folder.write("L.obj", L);
    let facts = inspected(&folder, "L.obj");
    near(&facts["quality"]["area"], 3.0);
    assert_eq!(facts["polygons"]["nonconvex"], json!({"count": 1, "first": 0}));
    assert_eq!(facts["polygons"]["nonplanar"], json!({"count": 0, "first": null}));
    assert_eq!(facts["polygons"]["self_crossing"]["count"], 0);
    assert_eq!(facts["topology"]["components"][0]["euler_characteristic"], 1);
    let text = folder.done("inspect L.obj");
    assert!(text.text().contains("1 not convex (first: face 0)"), "{}", text.text());
    assert!(text.stderr.contains("triangulated 1 polygon into 4 triangles"), "{}", text.stderr);

    // From (0, 1) to the reflex corner: the unit square above it is on the left.
    folder.write("line.obj", "v 0 1 0\nv 1 1 0\nl 1 2\n");
    folder.done("sdf L.obj --curve line.obj -o d.csv");
    let expected = [1.0, 0.0, 0.0, -1.0, -1.0, 1.0]; // 1 - y
    for (found, right) in folder.column("d.csv", "distance").iter().zip(expected) {
        assert!((found - right).abs() < 1e-9, "{found} instead of {right}");
    }
    folder.done("winding L.obj --curve line.obj -o w.ply");
    let file = read_mesh(folder.0.join("w.ply")).unwrap();
    let (mesh, _) = file.mesh.triangulate().unwrap();
    let (_, labels) = file.face_scalars.iter().find(|(name, _)| name == "label").unwrap();
    let mut areas = [0.0; 2];
    for (f, label) in mesh.faces().zip(labels) {
        let [a, b, c] = mesh.face_positions(f);
        areas[*label as usize] += ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2.0;
    }
    assert!((areas[0] - 2.0).abs() < 1e-9 && (areas[1] - 1.0).abs() < 1e-9, "{areas:?}");
}

// reports.md F22
#[test]
fn a_polygon_with_a_hole_has_area_8_and_is_not_dropped() {
    let folder = Folder::new();
    folder.write("key.obj", KEYHOLE);
    for words in ["key.obj", "key.obj --drop-degenerate", "key.obj --weld"] {
        let facts = inspected(&folder, words);
        near(&facts["quality"]["area"], 8.0);
        assert_eq!(facts["topology"]["boundary_loops"], json!([4, 4]), "{words}");
        assert_eq!(facts["topology"]["euler_characteristic"], 0, "{words}");
        assert_eq!(facts["mesh"]["triangles"], 8, "{words}");
    }
}

#[test]
fn a_bow_tie_gives_a_warning() {
    let folder = Folder::new();
    folder.write("tie.obj", "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n");
    folder.warned("inspect tie.obj", &["tie.obj", "1 self-crossing polygon (first: face 0)"]);
    let facts = inspected(&folder, "tie.obj");
    assert_eq!(facts["polygons"]["self_crossing"], json!({"count": 1, "first": 0}));
}

#[test]
fn repeated_corners_are_refused_or_removed() {
    // reports.md F22: a remedy must not delete the face.
    let folder = Folder::new();
    let vertices = "v 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nv 0 0 0\n";
    folder.write(
        "side.json",
        r#"{"eikona":"curves","version":1,"curves":[{"nodes":[{"vertex":5},{"vertex":0}]}]}"#,
    );
    // Alone; repeating the first corner at the end; and after a dropped face, which shifts face
    // numbers.
    let faces = ["f 1 2 2 3 4 5 6", "f 1 2 3 4 5 6 1", "f 1 2 1 2\nf 1 2 2 2 3 4 5 6"];
    for (faces, doubled) in faces.into_iter().zip([1, 1, 2]) {
        folder.write("twice.obj", &format!("{vertices}{faces}\n"));
        folder.refused("inspect twice.obj", 3, &["twice", "--drop-degenerate removes corners"]);
        near(&inspected(&folder, "twice.obj --drop-degenerate")["quality"]["area"], 3.0);
        folder.done("sdf twice.obj --drop-degenerate --curve side.json -o d.csv --report r.json");
        // The L lies on the left of its lower side: the distance is -y.
        for (d, y) in folder.column("d.csv", "distance").iter().zip([0., 1., 1., 2., 2., 0.]) {
            assert!((d + y).abs() < 1e-9, "{faces}: {d} at y = {y}");
        }
        assert_eq!(folder.json("r.json")["input"]["repairs"][0]["corners"], doubled, "{faces}");
    }
}
