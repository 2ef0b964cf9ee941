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
