//! `eikona sdf MESH --curve CURVE -o OUT --render PNG --report R.json`, with known answers.

mod run;

use run::{Folder, LINE, data, grid_obj, png_size};
use std::path::Path;

fn grid() -> Folder {
    let folder = Folder::new();
    folder.write("grid.obj", &grid_obj());
    folder.write("line.json", LINE);
    folder
}

fn expected(i: usize) -> f64 {
    (i / 3) as f64 - 5.0
}

#[track_caller]
fn assert_grid(folder: &Folder, file: &str, sign: f64) {
    let distance = folder.column(file, "distance");
    assert_eq!(distance.len(), 33);
    for (i, d) in distance.iter().enumerate() {
        assert!((d - sign * expected(i)).abs() < 1e-9, "vertex {i}: {d}, not {}", sign * expected(i));
    }
}

#[test]
fn the_main_job_on_a_grid_is_exact_and_writes_all_its_files() {
    let folder = grid();
    folder.done(
        "sdf grid.obj --curve line.json -o out.ply --isolines lines.obj --spacing 1 --render out.png --size 320x240 \
         --report r.json",
    );
    assert_eq!(folder.files(), ["grid.obj", "line.json", "lines.obj", "out.ply", "out.png", "r.json"]);
    assert_eq!(png_size(&folder.bytes("out.png")), (320, 240));
    let report = folder.json("r.json");
    assert_eq!((&report["eikona"], &report["version"]), (&"report".into(), &2.into()));
    assert_eq!(report["input"]["mesh"]["vertices"], 33);
    assert_eq!(
        (&report["options"]["level_sets"], &report["options"]["time"]),
        (&"auto".into(), &"auto".into())
    );
    assert_eq!(report["result"]["level_sets"], "zero", "from boundary to boundary the line is whole");
    assert!((report["result"]["distance_max"].as_f64().unwrap() - 5.0).abs() < 1e-9);
    assert!((report["result"]["distance_min"].as_f64().unwrap() + 5.0).abs() < 1e-9);
    assert!(report["result"]["integration_residual"].as_f64().unwrap() < 1e-9);
    assert_eq!(report["outputs"].as_array().unwrap().len(), 4);
    assert_eq!(report["warnings"].as_array().unwrap().len(), 0);
    let phases: Vec<&str> =
        report["phases"].as_array().unwrap().iter().map(|p| p["name"].as_str().unwrap()).collect();
    for wanted in [
        "read mesh",
        "read curve",
        "locate curve",
        "check curve",
        "prepare: factorisation",
        "solve: diffusion",
        "solve: integration",
        "render",
    ] {
        assert!(phases.contains(&wanted), "{wanted} is not among {phases:?}");
    }
    // Isolines at -5 .. 5; those on the boundary may be missing by rounding.
    let lines = folder.read("lines.obj").lines().filter(|l| l.starts_with("l ")).count();
    assert!((9..=11).contains(&lines), "{lines}");
}

#[test]
fn signs_follow_the_curve_and_the_convention() {
    let folder = grid();
    for (flags, sign) in [
        ("", 1.0),
        ("--flip", -1.0),
        ("--sign left-positive", -1.0),
        ("--flip --sign left-positive", 1.0),
        ("--time auto", 1.0),
        ("--level-sets free", 1.0),
        ("--level-sets per-component", 1.0),
        ("--level-sets soft=10", 1.0),
        ("--preserve-normals", 1.0),
        ("--threads 1", 1.0),
    ] {
        folder.done(&format!("sdf grid.obj --curve line.json -o out.csv {flags}"));
        assert_grid(&folder, "out.csv", sign);
    }
    folder.done("sdf grid.obj --curve line.json -o out.csv --unsigned");
    // Unsigned distance is of first order: within a quarter of an edge on this coarse grid.
    for (i, d) in folder.column("out.csv", "distance").iter().enumerate() {
        assert!((d - expected(i).abs()).abs() < 0.25 && *d > -1e-9, "vertex {i}: {d}");
    }
}

#[test]
fn all_curve_formats_give_the_same_distance() {
    let folder = grid();
    folder.write("space.obj", "v 5 -0.25 3\nv 5 2 3\nl 1 2\n");
    folder.write("demo.txt", "signed_curve\nv 15\nv 16\nv 17\n");
    folder.write("swn.txt", "v 16\nv 17\nv 18\nl 1 2\nl 2 3\n");
    folder.write("far.json", &LINE.replace(r#"{"vertex":16},"#, ""));
    folder.write("own.obj", &(grid_obj() + "l 16 17 18\n"));
    for curve in ["space.obj", "demo.txt", "swn.txt", "far.json"] {
        folder.done(&format!("sdf grid.obj --curve {curve} -o out.csv"));
        assert_grid(&folder, "out.csv", 1.0);
    }
    folder.done("sdf own.obj -o out.csv");
    assert_grid(&folder, "out.csv", 1.0);
}

#[test]
fn every_output_format_can_be_read_again() {
    let folder = grid();
    for name in ["out.ply", "out.ply.gz", "out.obj", "out.off", "out.vtp", "out.glb", "out.gltf"] {
        folder.done(&format!("sdf grid.obj --curve line.json -o {name} -q"));
        let facts = folder.done(&format!("inspect {name} --json"));
        let facts: serde_json::Value = serde_json::from_slice(&facts.stdout).unwrap();
        assert_eq!(facts["mesh"]["vertices"], 33, "{name}");
        assert_eq!(facts["mesh"]["triangles"], 40, "{name}");
    }
    folder.done("sdf grid.obj --curve line.json -o out.npy --confidence");
    let bytes = folder.bytes("out.npy");
    let header = u16::from_le_bytes(bytes[8..10].try_into().unwrap()) as usize;
    assert_eq!((10 + header) % 64, 0);
    assert!(String::from_utf8_lossy(&bytes[10..10 + header]).contains("'shape': (33, 3"));
    assert_eq!(bytes.len(), 10 + header + 33 * 3 * 8);
    let first = f64::from_le_bytes(bytes[10 + header..18 + header].try_into().unwrap());
    assert!((first + 5.0).abs() < 1e-9);
    folder.done("sdf grid.obj --curve line.json -o out.csv --confidence");
    assert!(folder.column("out.csv", "confidence").iter().all(|c| (0.0..=1.0).contains(c)));
    for (i, d) in folder.column("out.csv", "distance_to_data").iter().enumerate() {
        assert!((d - expected(i).abs()).abs() < 1e-6, "vertex {i}: {d}");
    }
}

#[test]
fn meshes_are_read_from_and_written_to_pipes() {
    let folder = grid();
    let words = ["sdf", "-", "--curve", "line.json", "-o", "-", "--out-format", "csv"];
    let outcome = folder.run_words(words, grid_obj().as_bytes());
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    folder.write("out.csv", &outcome.text());
    assert_grid(&folder, "out.csv", 1.0);
    let made = folder.done("make icosahedron -o - --out-format stl");
    let outcome = folder.run_words(["inspect", "-", "--json"], &made.stdout);
    let facts: serde_json::Value = serde_json::from_slice(&outcome.stdout).unwrap();
    assert_eq!((&facts["mesh"]["vertices"], &facts["mesh"]["format"]), (&12.into(), &"stl".into()));
    let none = folder.run_words(["inspect", "-"], b"");
    assert_eq!(none.code, Some(3));
    let unnamed = folder.run_words(["sdf", "-", "--curve", "line.json", "-o", "-"], grid_obj().as_bytes());
    assert_eq!(unnamed.code, Some(2), "{}", unnamed.stderr);
}

#[test]
fn standard_input_may_be_gzipped() {
    let folder = grid();
    folder.done("make torus nu=12 nv=8 -o t.ply.gz");
    let bytes = folder.bytes("t.ply.gz");
    assert!(bytes.starts_with(&[0x1f, 0x8b]));
    for words in [vec!["inspect", "-", "--json"], vec!["inspect", "-", "--json", "--in-format", "ply"]] {
        let outcome = folder.run_words(words, &bytes);
        let facts: serde_json::Value = serde_json::from_slice(&outcome.stdout).unwrap();
        assert_eq!(facts["mesh"]["vertices"], 96, "{}", outcome.stderr);
    }
    folder.done("inspect t.ply.gz --in-format ply");
    let torn = folder.run_words(["inspect", "-"], &bytes[..bytes.len() / 2]);
    assert!(torn.code == Some(3) && torn.stderr.contains("gzip"), "{}", torn.stderr);
}

#[test]
fn the_output_keeps_the_fields_of_the_input() {
    let folder = grid();
    let rows: String = (0..33)
        .map(|i| format!("{} {} 0 {} 7 {} 10 20 {} 0.5 0.25\n", i / 3, i % 3, 100 + i, 2 * i, 200 + i))
        .collect();
    let faces: String = grid_obj()
        .lines()
        .filter_map(|l| l.strip_prefix("f "))
        .enumerate()
        .map(|(i, l)| {
            let corners: Vec<String> =
                l.split(' ').map(|w| (w.parse::<u32>().unwrap() - 1).to_string()).collect();
            format!("3 {} {i}\n", corners.join(" "))
        })
        .collect();
    let names = ["heat", "quality", "part", "red", "green", "blue", "distance", "confidence"];
    let properties: String = names
        .map(|n| {
            format!(
                "property {} {n}\n",
                if ["red", "green", "blue"].contains(&n) { "uchar" } else { "float" }
            )
        })
        .concat();
    folder.write(
        "in.ply",
        &format!(
            "ply\nformat ascii 1.0\nelement vertex 33\nproperty float x\nproperty float y\nproperty float z\n{properties}\
             element face 40\nproperty list uchar int vertex_indices\nproperty int region\nend_header\n{rows}{faces}"
        ),
    );
    for name in ["out.ply", "out.vtp"] {
        folder.done(&format!("sdf in.ply --curve line.json -o {name}"));
        let fields = folder.done(&format!("inspect {name}")).text();
        let fields = fields.lines().find_map(|l| l.trim().strip_prefix("fields")).unwrap().to_string();
        for wanted in ["distance", "heat", "quality_of_input", "part"] {
            assert!(fields.contains(wanted), "{name}: no {wanted} in {fields}");
        }
        assert!(!fields.contains("confidence"), "a result of an earlier run: {fields}");
        folder.done(&format!("render {name} -o p.png --field region --size 64x48"));
        folder.done(&format!("render {name} -o p.png --field heat --size 64x48"));
    }
    // A second run replaces the old distance and its copy for viewers.
    folder.done("sdf out.ply --curve line.json --flip -o again.ply");
    let header = |name: &str| {
        let bytes = folder.bytes(name);
        let end = bytes.windows(10).position(|w| w == b"end_header").unwrap();
        String::from_utf8(bytes[..end].to_vec()).unwrap()
    };
    assert_eq!(header("again.ply"), header("out.ply"));
    assert!(header("out.ply").contains("property uchar red"));
    folder.done("sdf in.ply --curve line.json -o out.glb");
    folder.done("sdf in.ply --curve line.json -o out.obj --strict");
}

#[test]
fn isolines_can_be_used_as_curves() {
    let folder = Folder::new();
    folder.done("make geodesic_sphere frequency=16 -o s.ply --curve-out c.json --cut axis=z,at=0.2");
    folder.done("sdf s.ply --curve c.json -o a.csv --isolines iso.json --levels -0.1 --time auto");
    folder.done("sdf s.ply --curve iso.json -o b.csv --time auto");
    let (a, b) = (folder.column("a.csv", "distance"), folder.column("b.csv", "distance"));
    // The distance to the isoline -0.1 is larger by 0.1, up to discretisation error.
    for (i, (a, b)) in a.iter().zip(&b).enumerate() {
        assert!((b - a - 0.1).abs() < 0.02, "vertex {i}: {a} and {b}");
    }
}

#[test]
fn repairs_are_made_on_request_and_reported() {
    let folder = grid();
    folder.done("make grid nx=10 ny=2 width=10 height=2 -o loose.ply --unweld");
    let outcome = folder.done("sdf loose.ply --points 0 -o out.csv");
    assert!(outcome.stderr.contains("--weld"), "{}", outcome.stderr);
    let outcome = folder.done("sdf loose.ply --weld --points 0 -o out.csv --report r.json");
    assert!(outcome.stderr.contains("120 vertices into 33"), "{}", outcome.stderr);
    assert_eq!(folder.column("out.csv", "distance").len(), 33);
    let repair = &folder.json("r.json")["input"]["repairs"][0];
    assert_eq!(repair["vertex_map"].as_array().unwrap().len(), 120);
    // Points have the numbers of the file: vertex 119 is a corner of the last face.
    folder.done("sdf loose.ply --weld --points 119 -o out.csv");
    let distance = folder.column("out.csv", "distance");
    let zeros = distance.iter().filter(|d| d.abs() < 1e-9).count();
    assert_eq!(zeros, 1);
    // STL always stores separate triangles.
    folder.done("make grid nx=10 ny=2 width=10 height=2 -o g.stl");
    folder.write("space.obj", "v 5 0 0\nv 5 2 0\nl 1 2\n");
    let outcome = folder.done("sdf g.stl --curve space.obj -o out.csv");
    assert!(outcome.stderr.contains("STL stores separate triangles"), "{}", outcome.stderr);
    assert_eq!(folder.column("out.csv", "distance").len(), 33);
    let off = folder.done("inspect g.stl --weld=off --json");
    assert!(off.text().contains("\"vertices\": 120"));
}

#[test]
fn the_demo_makes_its_picture() {
    let folder = Folder::new();
    let outcome = folder.done("demo -o first");
    assert!(outcome.stderr.contains("$ eikona sdf first/animal.ply --curve first/broken-loop.json"));
    let files =
        ["animal.ply", "broken-loop.json", "distance.ply", "distance.png", "isolines.obj", "report.json"];
    for file in files {
        assert!(folder.0.join("first").join(file).is_file(), "{file}");
    }
    assert_eq!(png_size(&folder.bytes("first/distance.png")), (1200, 900));
    // --report sets the path of the report.
    let outcome = folder.done("demo -o second --report r.json -q");
    assert!(!folder.0.join("second/report.json").exists());
    let report = folder.json("r.json");
    assert_eq!((&report["verb"], &report["input"]["source"]["curves"]), (&"sdf".into(), &11.into()));
    assert!(!outcome.stderr.contains("see second"), "{}", outcome.stderr);
    folder.refused("demo -o third --report no/such/r.json", 2, &["no/such"]);
}

/// Pairs of mesh and curve in the shared data.
const PAIRS: [(&str, &str); 14] = [
    ("closed/bunny.obj", "curves/swn/bunny-brokenheart.txt"),
    ("closed/bunny.obj", "curves/swn/bunny-heart.txt"),
    ("closed/double-torus.obj", "curves/swn/double-torus.txt"),
    ("curves/swn/annulus.obj", "curves/swn/annulus.txt"),
    ("curves/swn/asymmetric-torus.obj", "curves/swn/asymmetric-torus.txt"),
    ("curves/swn/spots-on-spot.obj", "curves/swn/spots-on-spot.txt"),
    ("curves/swn/torus.obj", "curves/swn/torus-phi.txt"),
    ("curves/shm/bumpy-sphere.obj", "curves/shm/bumpy-sphere.txt"),
    ("curves/shm/cactus.obj", "curves/shm/cactus.txt"),
    ("curves/shm/fish-unsigned.obj", "curves/shm/fish-unsigned.txt"),
    ("polygon/polygon-bear.obj", "curves/shm/polygon-bear.txt"),
    ("nonmanifold/screwdriver.obj", "curves/shm/screwdriver.txt"),
    ("badquality/block.obj", "curves/shm/block-points.txt"),
    ("boundary/hemisphere.obj", "curves/shm/hemisphere-point.txt"),
];

#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn curves_of_the_shared_data_are_solved() {
    let mut ran = 0;
    let data = data();
    let folder = Folder::new();
    for (mesh, curve) in PAIRS {
        let path = |name: &str| data.join(name).display().to_string();
        let outcome =
            folder.done(&format!("sdf {} --curve {} -o out.csv --report r.json", path(mesh), path(curve)));
        let distance = folder.column("out.csv", "distance");
        let report = folder.json("r.json");
        assert_eq!(
            distance.len() as u64,
            report["input"]["mesh"]["vertices_in_file"].as_u64().unwrap(),
            "{mesh}"
        );
        let undefined = distance.iter().filter(|d| !d.is_finite()).count();
        assert_eq!(undefined as u64, report["result"]["undefined_vertices"].as_u64().unwrap());
        assert!(undefined == 0 || outcome.stderr.contains("NaN"), "{mesh}: NaN without a warning");
        assert!(distance.iter().any(|d| d.abs() > 0.0), "{mesh}");
        ran += 1;
    }
    println!("{ran} pairs of mesh and curve ran");
    assert_eq!(ran, PAIRS.len());
}

/// All mesh files below a folder, sorted.
fn meshes(folder: &Path) -> Vec<std::path::PathBuf> {
    let mut found = Vec::new();
    let mut waiting = vec![folder.to_path_buf()];
    while let Some(folder) = waiting.pop() {
        for entry in std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()) {
            if entry.is_dir() {
                waiting.push(entry);
            } else if entry
                .extension()
                .is_some_and(|e| ["obj", "ply", "off", "stl"].contains(&&*e.to_string_lossy().to_lowercase()))
            {
                found.push(entry);
            }
        }
    }
    found.sort();
    found
}

#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn wild_meshes_are_solved_from_a_point_or_refused_with_a_reason() {
    let (mut solved, mut refused) = (0, 0);
    let data = data();
    let folder = Folder::new();
    for part in ["badquality", "boundary", "closed", "nonmanifold", "nonorientable", "polygon", "synthetic"] {
        for mesh in meshes(&data.join(part)) {
            let name = mesh.display().to_string();
            let words = ["sdf", &name, "--points", "0", "-o", "out.csv", "--level-sets", "free"];
            let outcome = folder.run_words(words, &[]);
            match outcome.code {
                Some(0) => {
                    let distance = folder.column("out.csv", "distance");
                    let undefined = distance.iter().filter(|d| !d.is_finite()).count();
                    assert!(
                        undefined == 0 || outcome.stderr.contains("NaN"),
                        "{name}: NaN without a warning"
                    );
                    std::fs::remove_file(folder.0.join("out.csv")).unwrap();
                    solved += 1;
                }
                code => {
                    assert_eq!(code, Some(3), "{name}: {}", outcome.stderr);
                    assert!(folder.files().is_empty(), "{name} left {:?}", folder.files());
                    println!("refused {name}: {}", outcome.stderr.lines().next().unwrap_or(""));
                    refused += 1;
                }
            }
        }
    }
    println!("{} files ran: {solved} solved, {refused} refused", solved + refused);
    assert!(solved > 20 && solved >= refused, "{solved} solved, {refused} refused");
}
