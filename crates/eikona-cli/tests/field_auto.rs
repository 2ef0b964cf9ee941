//! `eikona field` with automatic singularities and things to follow.

mod run;

use run::Folder;
use serde_json::Value;

fn report(folder: &Folder, command: &str) -> Value {
    folder.done(&format!("{command} --report report.json"));
    serde_json::from_str(&folder.read("report.json")).unwrap()
}

#[test]
fn an_automatic_prescription_can_be_edited_and_read_again() {
    let folder = Folder::new();
    folder.done("make cuboid -o box.ply");
    let auto =
        "field box.ply --auto --align creases --save-singularities s.json --save-cycles c.json -o a.rawfield";
    let first = report(&folder, auto);
    let saved: Vec<Value> = serde_json::from_str(&folder.read("s.json")).unwrap();
    assert_eq!(saved.len(), 8, "{saved:?}");
    assert!(saved.iter().all(|s| s["index"] == 0.25 && s["vertex"].is_u64()), "{saved:?}");
    assert_eq!(folder.read("c.json"), "[]\n");
    let followed = first["result"]["followed"].as_array().unwrap();
    assert_eq!(followed.len(), 12);
    assert!(followed.iter().all(|f| f["largest_error"].as_f64().unwrap() < 1e-9), "{followed:?}");
    folder.done("field box.ply --singularities s.json --cycles c.json --align creases -o b.rawfield");
    assert_eq!(folder.read("a.rawfield"), folder.read("b.rawfield"));
    // Edited: two of them joined.
    let mut edited = saved;
    edited[0]["index"] = 0.5.into();
    edited.remove(1);
    folder.write("s.json", &serde_json::to_string(&edited).unwrap());
    let report = report(&folder, "field box.ply --singularities s.json -o b.rawfield");
    assert_eq!(report["result"]["measured"].as_array().unwrap().len(), 7);
}

#[test]
fn numbers_of_saved_singularities_are_those_of_the_file() {
    let folder = Folder::new();
    folder.done("make icosphere levels=3 -o sphere.obj");
    // An unused vertex before all others is left out of the mesh, but not of the numbers.
    let text = folder.read("sphere.obj");
    let moved: String = text
        .lines()
        .map(|line| match line.strip_prefix("f ") {
            Some(corners) => {
                let up = |word: &str| word.split('/').next().unwrap().parse::<u32>().unwrap() + 1;
                let corners: Vec<String> = corners.split_whitespace().map(|w| up(w).to_string()).collect();
                format!("f {}\n", corners.join(" "))
            }
            None => format!("{line}\n"),
        })
        .collect();
    folder.write("moved.obj", &format!("v 9 9 9\n{moved}"));
    for name in ["sphere", "moved"] {
        folder
            .done(&format!("field {name}.obj --auto -n 1 --save-singularities {name}.json --report r.json"));
    }
    let [plain, moved]: [Vec<Value>; 2] =
        ["sphere", "moved"].map(|name| serde_json::from_str(&folder.read(&format!("{name}.json"))).unwrap());
    for (a, b) in plain.iter().zip(&moved) {
        assert_eq!(a["vertex"].as_u64().unwrap() + 1, b["vertex"].as_u64().unwrap());
    }
    assert_eq!(plain.len(), 2);
    // STL has no vertices: they are numbered as welded.
    folder.done("make icosphere levels=3 -o welded.stl");
    for name in ["saved.json", "saved.sings"] {
        folder.done(&format!("field welded.stl --auto --save-singularities {name} -o a.csv"));
        folder.done(&format!("field welded.stl --singularities {name} -o b.csv"));
        assert_eq!(folder.read("a.csv"), folder.read("b.csv"), "{name}");
    }
}

#[test]
fn boundaries_and_curve_files_are_followed() {
    let folder = Folder::new();
    folder.done("make disk -o disk.ply");
    folder.write("line.obj", "v -0.5 0.1 0\nv 0.5 0.2 0\nl 1 2\n");
    let both = report(&folder, "field disk.ply --auto --align boundary --align line.obj -o d.csv");
    let followed = both["result"]["followed"].as_array().unwrap();
    assert_eq!(
        followed.iter().map(|f| f["guide"].as_str().unwrap()).collect::<Vec<_>>(),
        ["boundary loop 0", "curve 0"]
    );
    assert!(followed.iter().all(|f| f["largest_error"].as_f64().unwrap() < 1e-6), "{followed:?}");
    let soft = report(&folder, "field disk.ply --auto --align line.obj --align-weight 0.5 -o d.csv");
    assert_eq!(soft["options"]["align_weight"], 0.5);
    folder.done("make torus -o torus.ply");
    report(&folder, "field torus.ply --auto=curvature -o t.csv");
}

#[test]
fn wrong_guides_are_refused() {
    let folder = Folder::new();
    folder.done("make icosphere levels=3 -o sphere.ply");
    let refused = |more: &str, code: i32, words: &[&str]| {
        folder.refused(&format!("field sphere.ply -o out.csv {more}"), code, words);
    };
    refused("--auto --align boundary", 3, &["no boundary"]);
    refused("--auto --align creases=200", 2, &["creases=30"]);
    refused("--auto -n 3 --align creases", 3, &["even N"]);
    refused("--auto=curvature -n 1", 3, &["even N"]);
    refused("--auto --align missing.obj", 3, &["missing.obj"]);
    refused("--auto --singularities s.json", 2, &["--singularities"]);
    refused("--auto=best", 2, &["smoothest", "curvature"]);
    refused("--align-weight 1", 2, &["--align"]);
    refused("--auto --separation 0.1", 2, &["--separation has no effect", "--streamlines"]);
    refused("--auto --separation 0.1 --glyphs --render out.png", 2, &["--separation has no effect"]);
    refused("--align boundary --align-weight 0", 2, &["0"]);
    // Singularities on both sides of the equator, which the field must turn around.
    folder.write("equator.obj", "v 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nl 1 2 3 4 1\n");
    folder.write("s.json", "[{\"vertex\": 0, \"index\": 1.25}, {\"vertex\": 11, \"index\": 0.75}]");
    refused("--singularities s.json --align equator.obj", 3, &["turns by", "weight"]);
}

#[test]
fn a_surface_without_creases_is_reported() {
    let folder = Folder::new();
    folder.done("make torus -o torus.ply");
    folder.warned(
        "field torus.ply --auto --align creases -o f.csv --report r.json",
        &["no edge bends by more than 30 degrees", "the sharpest bends by"],
    );
    let warning = folder.json("r.json")["warnings"][0].clone();
    assert_eq!((&warning["kind"], &warning["degrees"]), (&"no_creases".into(), &30.0.into()));
    // With a smaller angle, or on a box, there are some.
    folder.done("make cuboid -o box.ply");
    for command in ["torus.ply --align creases=2", "box.ply --align creases"] {
        folder.done(&format!("field {command} --auto -o f.csv --report r.json"));
        let report = folder.json("r.json");
        let warnings = report["warnings"].as_array().unwrap();
        assert!(warnings.iter().all(|w| w["kind"] != "no_creases"), "{command}");
        assert!(!report["result"]["followed"].as_array().unwrap().is_empty(), "{command}");
    }
}
