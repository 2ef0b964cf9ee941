//! `eikona field`: prescriptions, outputs and faults.

mod run;

use run::Folder;

#[test]
fn samples_and_faces_are_written() {
    let folder = Folder::new();
    folder.done("make icosphere levels=3 -o s.obj");
    // The corners of a cube: eight vertices far apart.
    let vertices: Vec<String> =
        (0..8).map(|i| format!("{{\"vertex\": {}, \"index\": 0.25}}", 12 + 75 * i)).collect();
    folder.write("s.json", &format!("[{}]", vertices.join(",")));
    folder.write("p.json", r#"[{"vertex": 9}, {"edge": [0, 600], "t": 0.5}]"#);
    folder.refused(
        "field s.obj --singularities s.json --sample p.json --samples v.csv",
        3,
        &["p.json: entry 1"],
    );
    folder.write("p.json", r#"[{"vertex": 9}, {"vertex": 100}]"#);
    let done = folder.done(
        "field s.obj --singularities s.json -n 4 -o f.rawfield --sample p.json --samples v.csv --report r.json \
         --render f.png --size 200x150",
    );
    assert_eq!(run::png_size(&folder.bytes("f.png")), (200, 150));
    assert!(done.stderr.contains("4 directions with 8 prescribed indices"), "{}", done.stderr);
    let report = folder.json("r.json");
    assert!(report["result"]["residual"].as_f64().unwrap() < 1e-10);
    assert_eq!(report["result"]["measured"], serde_json::json!([0.25f64; 8].to_vec()));
    for k in 0..4 {
        let part = |axis: &str| folder.column("v.csv", &format!("v{axis}{k}"));
        let (x, y, z) = (part("x"), part("y"), part("z"));
        assert_eq!(x.len(), 2);
        assert!((0..2).all(|i| ((x[i] * x[i] + y[i] * y[i] + z[i] * z[i]).sqrt() - 1.0).abs() < 1e-12));
    }
    let text = folder.read("f.rawfield");
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("4 1280"));
    assert!(lines.clone().count() == 1280 && lines.all(|line| line.split(' ').count() == 12));
}

#[test]
fn aliased_elements_are_warned_of() {
    let folder = Folder::new();
    folder.done("make icosphere levels=3 -o s.obj");
    folder.write(
        "s.json",
        r#"[{"vertex": 0, "index": -3}, {"vertex": 100, "index": 1}, {"vertex": 50, "index": 4}]"#,
    );
    folder.warned(
        "field s.obj --singularities s.json -n 1 -o f.csv",
        &["vertex 0", "index -3 is seen as", "at edges beside it", "spread it over several points"],
    );
}

#[test]
fn faults_name_the_entry_and_leave_no_file() {
    let folder = Folder::new();
    folder.done("make icosphere levels=2 -o s.obj");
    for (text, expected) in [
        ("[]", "add up to 0 instead of its Euler characteristic 2: +2 is missing"),
        ("", "line 1 column 0"),
        (r#"[{"vertex": 0, "indx": 2}]"#, "unknown field `indx`"),
        (r#"[{"vertex": 0}]"#, "entry 0: the key \"index\" is missing"),
        (r#"[{"edge": [0, 1], "index": 2}]"#, "entry 0: a singularity is"),
        (r#"[{"vertex": 0, "index": 0.3}]"#, "singularity 0 has index 0.3"),
        (r#"[{"vertex": 99999, "index": 2}]"#, "99999"),
        (r#"[{"boundary": 0, "index": 2}]"#, "there are 0 loops"),
    ] {
        folder.write("s.json", text);
        folder.refused("field s.obj --singularities s.json -n 4 -o f.rawfield", 3, &[expected]);
        assert!(!folder.files().contains(&"f.rawfield".to_string()));
    }
    folder.refused("field s.obj -o f.txt", 2, &["use .rawfield or .csv"]);
    folder.refused("field s.obj", 2, &["no output is given"]);
    folder.refused("field s.obj -o f.csv --size 20x20", 2, &["--size has no effect without a picture"]);
    folder.refused("field s.obj --render f.png --map viridis", 2, &["--map has no effect on a picture"]);
    folder.refused("field s.obj -n 0 -o f.csv", 2, &["N = 0 is out of range"]);
}
