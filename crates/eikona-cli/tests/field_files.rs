//! Files of fields: formats of other programs, and `eikona field-inspect`.

mod run;

use run::Folder;
use serde_json::Value;

fn inspected(folder: &Folder, files: &str) -> Value {
    serde_json::from_str(&folder.done(&format!("field-inspect {files} --json")).text()).unwrap()
}

fn indices(seen: &Value) -> Vec<(u64, f64)> {
    let list = seen["singular_vertices"].as_array().unwrap();
    list.iter().map(|s| (s["vertex"].as_u64().unwrap(), s["index"].as_f64().unwrap())).collect()
}

#[test]
fn fields_and_prescriptions_survive_the_formats_of_other_programs() {
    let folder = Folder::new();
    folder.done("make icosphere levels=4 -o s.ply");
    folder.done(
        "field s.ply --auto -o f.rawfield --save-matching f.matching --save-singularities f.sings --report r.json",
    );
    folder.done("field s.ply --singularities f.sings -o f.csv");
    folder.done("field s.ply --singularities f.sings -o f.rosy");
    let plain = inspected(&folder, "f.rawfield s.ply");
    assert_eq!(indices(&plain).len(), 8, "{plain}");
    assert!(indices(&plain).iter().all(|(_, index)| *index == 0.25));
    assert_eq!((&plain["index_sum"], &plain["euler_characteristic"]), (&2.0.into(), &2.into()));
    for other in
        ["f.rawfield s.ply --matching f.matching", "f.csv s.ply", "f.rosy s.ply", "f.rawfield s.ply -n 4"]
    {
        assert_eq!(indices(&inspected(&folder, other)), indices(&plain), "{other}");
    }
    let rows: Vec<String> = indices(&plain).iter().map(|(v, _)| format!("{v} 1")).collect();
    let sings = folder.read("f.sings");
    let mut lines: Vec<&str> = sings.lines().collect();
    assert_eq!(lines.remove(0), "4 8");
    assert_eq!(lines, rows);
    let matching = folder.read("f.matching");
    assert_eq!(matching.lines().next(), Some("4 7680"));
    assert!(matching.lines().skip(1).all(|row| row.split(' ').count() == 5));
    let text = folder.done("field-inspect f.rawfield s.ply").text();
    assert!(text.contains("index sum   +2, Euler characteristic 2") && text.contains("(+1/4)"), "{text}");
}

#[test]
fn wrong_files_are_refused_with_the_line() {
    let folder = Folder::new();
    folder.done("make tetrahedron -o t.ply");
    folder.write("good.rawfield", "1 4\n1 0 0\n0 1 0\n0 0 1\n1 1 0\n");
    for (name, text, words) in [
        ("empty.rawfield", "", vec!["line 1", "empty"]),
        ("short.rawfield", "1 4\n1 0 0\n", vec!["line 2", "1 rows", "4"]),
        ("wide.rawfield", "1 4\n1 0 0\n0 1\n0 0 1\n1 1 0\n", vec!["line 3", "2 numbers instead of 3"]),
        ("word.rawfield", "1 4\n1 0 zero\n", vec!["line 2", "zero is not a number"]),
        ("nan.rawfield", "1 4\n1 0 0\n1 0 nan\n1 0 0\n1 0 0\n", vec!["line 3", "finite"]),
        ("none.rawfield", "0 4\n", vec!["N = 0"]),
        ("more.rawfield", "1 3\n1 0 0\n0 1 0\n0 0 1\n", vec!["3 vectors", "4 faces"]),
        ("three.rosy", "4\n3\n1 0 0\n", vec!["line 2", "N = 4"]),
        ("head.csv", "a,b,c\n", vec!["line 1", "vx0"]),
    ] {
        folder.write(name, text);
        folder.refused(&format!("field-inspect {name} t.ply"), 3, &words);
    }
    folder.refused("field-inspect missing.rawfield t.ply", 3, &["missing.rawfield"]);
    folder.refused("field-inspect t.ply t.ply", 2, &[".rawfield"]);
    folder.refused("field-inspect good.rawfield t.ply -n 4", 3, &["N = 1"]);
    folder.write("m.matching", "1 1\n0 9 0 1 0\n");
    folder.refused("field-inspect good.rawfield t.ply --matching m.matching", 3, &["row 0", "face 9"]);
    folder.write("m.matching", "2 1\n0 1 0 1 0\n");
    folder.refused("field-inspect good.rawfield t.ply --matching m.matching", 3, &["N = 2"]);
    for (text, words) in [
        ("", vec!["empty"]),
        ("1 1\n0 1 2\n", vec!["line 2", "index times N"]),
        ("1 2\n0 1\n", vec!["2 singularities", "1 rows"]),
        ("4 1\n0 4\n", vec!["N = 4", "-n 4"]),
        ("1 1\n-1 2\n", vec!["line 2", "-1"]),
        ("1 1\n99 2\n", vec!["line 2", "99"]),
    ] {
        folder.write("s.sings", text);
        folder.refused("field t.ply -n 1 --singularities s.sings -o out.csv", 3, &words);
    }
    folder.refused("field t.ply -n 2 --auto -o out.rosy", 2, &["N = 4"]);
}

#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn public_fields_have_the_indices_of_their_surfaces() {
    let folder = Folder::new();
    let data = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");
    let files = [
        ("vase-2", "boundary/vase.off", 1.0, 4),
        ("vase-4", "boundary/vase.off", 1.0, 6),
        ("vase-7", "boundary/vase.off", 1.0, 9),
        ("vase-11", "boundary/vase.off", 1.0, 5),
        ("lilium", "boundary/lilium.obj", 1.0, 15),
        ("torus_twosings", "fields/torus.obj", 0.0, 2),
        ("torus-hex", "fields/torus.obj", 0.0, 0),
        ("rocker-arm2500", "fields/rocker-arm2500.obj", 0.0, 4),
        ("train-station-5", "boundary/train-station.off", 0.0, 16),
    ];
    for (name, mesh, chi, singular) in files {
        let seen = inspected(&folder, &format!("{data}/fields/{name}.rawfield {data}/{mesh}"));
        assert_eq!(seen["euler_characteristic"].as_f64(), Some(chi), "{name}");
        assert!((seen["index_sum"].as_f64().unwrap() - chi).abs() < 1e-9, "{name}: {seen}");
        assert_eq!(indices(&seen).len(), singular, "{name}");
    }
    println!("{} fields of the data folder", files.len());
}

const MIXED: &str = r#"[{"face": [50, 82, 83], "bary": [0.7, 0.2, 0.1], "index": 0.25},
    {"face": [750, 782, 783], "bary": [0.3, 0.3, 0.4], "index": -0.25},
    {"edge": [350, 382], "t": 0.3, "index": 0.5},
    {"vertex": 1200, "index": -0.5}]"#;

fn mixed() -> Folder {
    let folder = Folder::new();
    folder.write("s.json", MIXED);
    folder.done("make torus -o t.ply");
    folder
}

#[test]
fn split_meshes_have_every_singular_point_as_a_vertex() {
    let folder = mixed();
    folder.warned(
        "field t.ply --singularities s.json -o plain.rawfield",
        &["3 singular points", "inside faces or edges", "--split"],
    );
    for format in ["rawfield", "rosy", "csv", "npy"] {
        folder.done(&format!(
            "field t.ply --singularities s.json --split split.obj -o f.{format} --save-singularities f.sings \
             --save-matching f.matching"
        ));
        let seen = inspected(&folder, &format!("f.{format} split.obj"));
        let expected: Vec<(u64, f64)> = folder
            .read("f.sings")
            .lines()
            .skip(1)
            .map(|row| row.split_once(' ').unwrap())
            .map(|(vertex, turns)| (vertex.parse().unwrap(), turns.parse::<f64>().unwrap() / 4.0))
            .collect();
        assert_eq!(expected.len(), 4);
        assert_eq!(expected[0], (1200, -0.5));
        assert!(expected[1..].iter().all(|(v, _)| *v >= 2560), "{expected:?}");
        assert_eq!(indices(&seen), expected, "{format}");
        let matched = inspected(&folder, &format!("f.{format} split.obj --matching f.matching"));
        assert_eq!(indices(&matched), expected, "{format}");
    }
    // Lists of vertices need the split mesh, others do not.
    folder.refused("field t.ply --singularities s.json --save-singularities x.sings", 3, &["--split"]);
    folder.done("field t.ply --singularities s.json --split split.ply --save-singularities again.json");
    folder.done("field t.ply --singularities again.json -o again.csv");
    folder.refused("field t.ply --split split.xyz", 2, &["split.xyz", ".obj"]);
}

#[test]
fn stored_fields_are_restored_to_the_last_digit() {
    let folder = mixed();
    folder.write("p.json", r#"[{"vertex": 77}, {"face": [50, 82, 83], "bary": [0.1, 0.2, 0.7]}]"#);
    folder
        .done("field t.ply --singularities s.json -o f.npz --sample p.json --samples v.csv --report r.json");
    folder.done("field t.ply --singularities s.json -o f.json");
    let given = folder.json("r.json")["result"]["measured"].clone();
    for (from, to) in [("f.npz", "g.json"), ("f.json", "g.npz")] {
        folder.done(&format!(
            "field t.ply --field {from} -o {to} --sample p.json --samples w.csv --report r.json --split split.ply"
        ));
        assert_eq!(folder.read("v.csv"), folder.read("w.csv"));
        assert_eq!(folder.json("r.json")["result"]["measured"], given);
    }
    assert_eq!(folder.bytes("f.npz"), folder.bytes("g.npz"));
    assert_eq!(folder.bytes("f.json"), folder.bytes("g.json"));
    folder.done("make icosphere levels=4 -o s.ply");
    folder.refused("field s.ply --field f.npz -o x.csv", 3, &["not one of this mesh", "face 0"]);
    folder.done("make torus minor=0.5 -o thick.ply");
    folder.refused("field thick.ply --field f.json -o x.csv", 3, &["not one of this mesh", "shape of face"]);
    folder.refused("field t.ply --field f.npz -n 2 -o x.csv", 2, &["--field", "--degree"]);
    folder.refused("field t.ply --field s.json -o x.csv", 3, &["s.json", "not a stored field"]);
    folder.refused("field t.ply --field t.ply -o x.csv", 2, &["t.ply", ".npz or .json"]);
    folder.refused("field t.ply --field none.npz -o x.csv", 3, &["none.npz"]);
    std::fs::write(folder.0.join("cut.npz"), &folder.bytes("f.npz")[..5000]).unwrap();
    folder.refused("field t.ply --field cut.npz -o x.csv", 3, &["cut.npz", "archive"]);
    folder.write("zero.json", &folder.read("f.json").replace("\"degree\":4", "\"degree\":0"));
    folder.refused("field t.ply --field zero.json -o x.csv", 3, &["zero.json", "N = 0"]);
    folder.write("unknown.json", &folder.read("f.json").replace("\"turns\"", "\"rotations\""));
    folder.refused("field t.ply --field unknown.json -o x.csv", 3, &["unknown field `rotations`"]);
    folder.done("field t.ply -n 2 -o two.npz");
    folder.refused("field t.ply --field two.npz -o x.rosy", 2, &["N = 4", "N = 2"]);
    assert!(!folder.files().contains(&"x.csv".to_string()));
}

#[test]
fn vectors_per_face_go_with_the_mesh_and_as_arrays() {
    let folder = mixed();
    folder.done("field t.ply --auto -n 3 -o f.vtp");
    folder.done("field t.ply --auto -n 3 -o f.ply");
    folder.done("field t.ply --auto -n 3 -o f.csv");
    let vtp = folder.read("f.vtp");
    for k in 0..3 {
        assert!(vtp.contains(&format!("Name=\"v{k}\" NumberOfComponents=\"3\"")), "v{k}");
    }
    let header = String::from_utf8_lossy(&folder.bytes("f.ply")[..900]).into_owned();
    assert!(header.contains("property double v2_2"), "{header}");
    folder.done("field t.ply --auto -n 3 -o f.npy");
    assert_eq!(indices(&inspected(&folder, "f.npy t.ply")), indices(&inspected(&folder, "f.csv t.ply")));
    folder.refused("field-inspect f.npy t.ply -n 4", 3, &["N = 3", "not 4"]);
    std::fs::write(folder.0.join("cut.npy"), &folder.bytes("f.npy")[..5000]).unwrap();
    folder.refused("field-inspect cut.npy t.ply", 3, &["cut.npy", "shorter"]);
    folder.refused("field t.ply -o f.vtu", 2, &["f.vtu", ".rawfield"]);
}

#[test]
fn samples_have_the_length_of_the_field_if_asked() {
    let folder = mixed();
    folder.write("p.json", r#"[{"face": [50, 82, 83], "bary": [0.69, 0.21, 0.1]}, {"vertex": 77}]"#);
    folder.done("field t.ply --singularities s.json --sample p.json --samples unit.csv");
    folder.done("field t.ply --singularities s.json --sample p.json --samples own.csv --scaled");
    let length = |file: &str| -> Vec<f64> {
        let column = |k| folder.column(file, k);
        let [x, y, z] = ["vx0", "vy0", "vz0"].map(column);
        (0..2).map(|i| (x[i] * x[i] + y[i] * y[i] + z[i] * z[i]).sqrt()).collect()
    };
    assert!(length("unit.csv").iter().all(|x| (x - 1.0).abs() < 1e-12));
    // The first point is close to a singular one.
    let own = length("own.csv");
    assert!(own[0] > 0.0 && own[0] < 0.6 * own[1], "{own:?}");
    folder.refused("field t.ply --auto -o f.csv --scaled", 2, &["--samples"]);
}

#[test]
fn render_draws_fields_of_any_format_and_streamlines() {
    let folder = mixed();
    folder.done("field t.ply --auto --save-singularities a.json --save-cycles c.json -o f.rawfield --streamlines l.obj");
    for format in ["csv", "rosy", "npy", "npz", "json"] {
        folder.done(&format!("field t.ply --singularities a.json --cycles c.json -o f.{format}"));
    }
    // The same vectors give the same picture, whatever the file.
    let picture = |options: &str| {
        folder.done(&format!("render t.ply {options} -o p.png --size 320x240"));
        folder.bytes("p.png")
    };
    let marks = picture("--directions f.rawfield");
    assert!(marks != picture(""));
    for format in ["csv", "rosy", "npy"] {
        assert!(picture(&format!("--directions f.{format}")) == marks, "{format}");
    }
    let stored = picture("--directions f.npz");
    assert!(stored == picture("--directions f.json") && stored != marks);
    folder.done("field t.ply --field f.npz --render p.png --size 320x240");
    assert!(folder.bytes("p.png") == stored);
    assert!(picture("--lines l.obj") != picture(""));
    folder.refused("render t.ply --lines t.ply -o x.png", 3, &["t.ply", "no polylines"]);
    folder.refused("render t.ply --directions none.npy -o x.png", 3, &["none.npy"]);
    // As many faces, but another surface.
    folder.done("make icosphere levels=4 -o s.ply");
    folder.warned("render s.ply --directions f.rawfield -o p.png", &["out of the plane", "this mesh"]);
}

#[test]
fn trivial_connections_are_constant_in_faces() {
    let folder = Folder::new();
    folder.done("make icosphere levels=3 -o s.ply");
    folder.write("poles.json", r#"[{"vertex": 0, "index": 1}, {"vertex": 11, "index": 1}]"#);
    folder.done("field s.ply -n 1 --singularities poles.json --trivial -o f.rawfield --report r.json");
    let seen = inspected(&folder, "f.rawfield s.ply");
    assert_eq!(seen["index_sum"], 2.0);
    assert_eq!(seen["components"][0]["index_sum"], 2.0);
    assert_eq!(folder.json("r.json")["result"]["measured"], serde_json::json!([1.0, 1.0]));
    folder.write("p.json", r#"[{"face": [0, 0, 0], "bary": [1, 0, 0]}]"#);
    folder.write(
        "face.json",
        r#"[{"vertex": 0, "index": 1}, {"face": [1, 2, 3], "bary": [0.2, 0.3, 0.5], "index": 1}]"#,
    );
    folder.refused(
        "field s.ply --singularities poles.json --trivial --align boundary -o x.csv",
        2,
        &["--trivial"],
    );
}
