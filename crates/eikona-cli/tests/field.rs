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
        &["vertex 0", "index -3 is seen as", "at edges beside it", "spread them over several points"],
    );
}

/// Vertices of a face: a, b, c.
fn face_of(folder: &Folder, obj: &str) -> [u32; 3] {
    let text = folder.read(obj);
    let line = text.lines().find_map(|l| l.strip_prefix("f ")).unwrap();
    let ids: Vec<u32> = line.split(' ').map(|id| id.parse::<u32>().unwrap() - 1).collect();
    [ids[0], ids[1], ids[2]]
}

/// Runs `field` on a mesh with each list of singularities: bad input, and no output file.
fn refused_lists(folder: &Folder, mesh: &str, flags: &str, lists: &[(String, &[&str])]) {
    for (text, expected) in lists {
        folder.write("s.json", text);
        let command = format!("field {mesh} --singularities s.json {flags} -o f.rawfield --report r.json");
        folder.refused(&command, 3, expected);
    }
}

#[test]
fn faults_name_the_entry_and_leave_no_file() {
    let folder = Folder::new();
    folder.done("make icosphere levels=2 -o s.obj");
    let [a, b, c] = face_of(&folder, "s.obj");
    let edge = format!(r#""edge": [{a}, {b}]"#);
    let face = format!(r#""face": [{a}, {b}, {c}]"#);
    let lists: Vec<(String, &[&str])> = vec![
        ("[]".into(), &["add up to 0 instead of its Euler characteristic 2: +2 is missing"]),
        (r#"[{"vertex": 0, "index": 1}]"#.into(), &["add up to 1", "+1 is missing; add it at a vertex"]),
        (" \n".into(), &["s.json: the file is empty; give a JSON list"]),
        (
            r#"{"vertex": 0, "index": 2}"#.into(),
            &["s.json: line 1", "this is one object, not a list of them"],
        ),
        (
            r#"["a"]"#.into(),
            &["line 1 column 4", r#"expected an object such as {"vertex": 3, "index": 0.25}"#],
        ),
        (r#"[{"vertex": 0, "index": 2}] x"#.into(), &["line 1 column 29: trailing characters"]),
        (r#"[{"vertex": 0, "indx": 2}]"#.into(), &["unknown field `indx`"]),
        (r#"[{"vertex": 0}]"#.into(), &["entry 0: the key \"index\" is missing; add it"]),
        (r#"[{"vertex": 0, "index": NaN}]"#.into(), &["line 1 column 25"]),
        (r#"[{"vertex": 0, "index": 1e400}]"#.into(), &["line 1 column 29: number out of range"]),
        (r#"[{"vertex": 0, "index": 1e9}]"#.into(), &["at most 1000000/4 in magnitude"]),
        (r#"[{"vertex": 0, "index": 0.3}]"#.into(), &["singularity 0 has index 0.3", "choose 0.25 or 0.5"]),
        (r#"[{"vertex": -1, "index": 2}]"#.into(), &["`-1`, expected a whole number of 0 or more"]),
        (r#"[{"vertex": 99999, "index": 2}]"#.into(), &["s.json: entry 0: vertex 99999", "162 vertices"]),
        (r#"[{"boundary": 0, "index": 2}]"#.into(), &["the mesh has 0 boundary loops"]),
        (
            r#"[{"vertex": 7, "index": 1}, {"vertex": 7, "index": 1}]"#.into(),
            &["singularity 1 is on vertex 7, which has another one; add their indices, or move one"],
        ),
        (format!(r#"[{{{edge}, "index": 2}}]"#), &["entry 0: a singularity is", "exactly these keys"]),
        (format!(r#"[{{{edge}, "t": 1.3, "index": 2}}]"#), &["entry 0: t = 1.3 is outside [0, 1]"]),
        (
            format!(r#"[{{"vertex": 0, {edge}, "t": 0.3, "index": 2}}]"#),
            &["entry 0: a singularity is", "exactly these keys"],
        ),
        (
            r#"[{"edge": [0, 1], "t": 0.3, "index": 2}]"#.into(),
            &["entry 0: vertices 0 and 1 are not joined by an edge; name the ends of one"],
        ),
        (
            r#"[{"face": [0, 1, 2], "bary": [0.2, 0.3, 0.5], "index": 2}]"#.into(),
            &["entry 0: vertices 0, 1 and 2 are not the corners of a face; name the three corners of one"],
        ),
        (
            format!(r#"[{{{face}, "bary": [1.2, -0.1, -0.1], "index": 2}}]"#),
            &["entry 0", "must lie in [0, 1]"],
        ),
        (format!(r#"[{{{face}, "bary": [0.2, 0.3, 0.4], "index": 2}}]"#), &["entry 0", "their sum be 1"]),
        (format!(r#"[{{{face}, "bary": [0.2, 0.8], "index": 2}}]"#), &["line 1", "a list of length 3"]),
        (
            format!(
                r#"[{{"edge": [{a}, {b}], "t": 0.3, "index": 1}}, {{"edge": [{b}, {c}], "t": 0.3, "index": 1}},
                    {{"edge": [{c}, {a}], "t": 0.3, "index": 0.25}}, {{"vertex": 100, "index": -0.25}}]"#
            ),
            &["determine the scale in face 0 more than once; move one of them to another face"],
        ),
    ];
    refused_lists(&folder, "s.obj", "-n 4", &lists);
    refused_lists(&folder, "none.obj", "", &[("[]".into(), &["none.obj: no such file"])]);
    folder.refused("field s.obj --singularities none.json -o f.rawfield", 3, &["none.json: no such file"]);
    folder.refused("field s.obj --singularities . -o f.rawfield", 3, &["this is a folder; give a file"]);
    folder.refused("field s.obj -o none/f.rawfield", 2, &["the folder none does not exist"]);
    folder.refused("field s.obj -o f.txt", 2, &["use .rawfield, .rosy, .csv"]);
    folder.refused("field s.obj", 2, &["no output is given"]);
    folder.refused("field s.obj -o f.csv --size 20x20", 2, &["--size has no effect without a picture"]);
    folder.refused("field s.obj --render f.png --map viridis", 2, &["--map has no effect on a picture"]);
    folder.refused("field s.obj -n 0 -o f.csv", 2, &["N = 0 is out of range"]);
    folder.refused("field s.obj -n 1001 -o f.csv", 2, &["N = 1001 is out of range; choose a number from 1"]);
}

#[test]
fn surfaces_without_fields_are_refused() {
    let folder = Folder::new();
    folder.done("make moebius-band -o band.obj");
    folder.done("make disk rings=3 sectors=6 -o disk.obj");
    folder.done("make torus -o torus.obj");
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\n";
    folder.write("fin.obj", &format!("{corners}f 1 2 3\nf 2 1 4\nf 1 2 5\n"));
    folder.write("bow.obj", &format!("{corners}f 1 2 3\nf 1 4 5\n"));
    folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 2 1 4\n");
    folder.write("points.obj", corners);
    folder.write("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n");
    let none = || "[]".to_string();
    let refuse = |mesh: &str, text: String, expected: &[&str]| {
        refused_lists(&folder, mesh, "", &[(text, expected)]);
    };
    refuse("fin.obj", none(), &["edge 0 (vertex 0 to vertex 1) has 3 faces", "split the mesh"]);
    refuse("bow.obj", none(), &["vertex 0 has 2 fans of faces", "duplicate the vertex per fan"]);
    refuse("band.obj", none(), &["component 0 (from face 0) is not orientable", "cut it open"]);
    refuse("flat.obj", none(), &["face 1 has no area; remove it"]);
    refuse("points.obj", none(), &["points.obj: this file has no faces"]);
    refuse("nan.obj", none(), &["vertex 1", "not finite"]);
    let rim = r#"[{"vertex": 30, "index": 1}]"#.to_string();
    refuse("disk.obj", rim, &["singularity 0 is at vertex 30, which is on the boundary; move it inside"]);
    let boundary = r#"[{"boundary": 3, "index": 1}]"#.to_string();
    refuse("disk.obj", boundary, &["boundary loop 3, but the mesh has 1 boundary loop; loops are numbered"]);
    for (cycles, expected) in [
        ("[1]", "1 index is given for homology generators, but the surface has 2 generators"),
        ("[0, 0, 0]", "3 indices are given for homology generators"),
        ("[0.3, 0]", "generator 0 has index 0.3, which is not a whole multiple of 1/4; choose 0.25 or 0.5"),
        ("[\"a\", 0]", "expected a number"),
    ] {
        folder.write("c.json", cycles);
        folder.refused("field torus.obj --cycles c.json -o f.rawfield", 3, &[expected]);
    }
    // Vertices without faces do no harm.
    folder.write("more.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\n");
    folder.write("s.json", r#"[{"boundary": 0, "index": 1}]"#);
    folder.done("field more.obj --singularities s.json -o f.rawfield");
    refuse("more.obj", r#"[{"vertex": 3, "index": 1}]"#.into(), &["at vertex 3, which no face uses"]);
}

#[test]
fn singularities_that_can_not_be_placed_are_warned_of() {
    let folder = Folder::new();
    folder.done("make icosphere levels=2 -o s.obj");
    let [a, b, c] = face_of(&folder, "s.obj");
    // The scales of such a power overflow close to a corner.
    let text = format!(
        r#"[{{"face": [{a}, {b}, {c}], "bary": [0.98, 0.01, 0.01], "index": 40}}, {{"vertex": 90, "index": -38}}]"#
    );
    folder.write("s.json", &text);
    let command = "field s.obj --singularities s.json -o f.rawfield --report r.json";
    folder.warned(
        command,
        &["1 singularity is not exactly at the wanted point (first: in face 0)", "away, or refine"],
    );
    assert_eq!(folder.json("r.json")["result"]["unplaced"], serde_json::json!(["face 0"]));
    // The field of a face vanishes at one point only.
    let text = format!(
        r#"[{{"edge": [{a}, {b}], "t": 0.3, "index": 1}}, {{"face": [{a}, {b}, {c}], "bary": [0.2, 0.3, 0.5], "index": 1}}]"#
    );
    folder.write("s.json", &text);
    let words = ["singularity 1 is inside face 0", "singularity 0 on its own edge", "move one of them"];
    folder.refused("field s.obj --singularities s.json -o none.rawfield", 3, &words);
    assert!(!folder.files().contains(&"none.rawfield".to_string()));
}
