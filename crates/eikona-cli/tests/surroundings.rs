//! Help, completions, reports, pictures, inspection, damage and benchmarks.

mod run;

use run::{Folder, data, grid_obj, png_size};

/// The commands in a help text.
fn examples(help: &str) -> Vec<String> {
    let lines = help.lines().map(str::trim).filter_map(|l| l.strip_prefix("eikona "));
    // Several spaces separate explanations; redirections to files need a shell.
    lines
        .map(|l| l.split("   ").next().unwrap_or(l).split(" > ").next().unwrap_or(l).trim().to_string())
        .collect()
}

#[test]
fn the_examples_in_every_help_text_work() {
    let mut ran = 0;
    for verb in [
        "sdf",
        "winding",
        "inspect",
        "make",
        "render",
        "demo",
        "bench",
        "bench sdf",
        "bench winding",
        "bench field",
        "field",
        "field-inspect",
        "",
    ] {
        let folder = Folder::new();
        folder.write("distance.ply", ""); // overwritten by the examples
        let help = folder.done(&format!("{verb} --help"));
        let examples = examples(&help.text());
        assert!(!examples.is_empty(), "the help of {verb:?} has no example");
        for example in examples {
            // Large sizes and the other program take too long for a test.
            if example.contains("--peer") {
                continue;
            }
            // The demo is the example of its own help too.
            if verb.is_empty() && example.starts_with("demo") {
                continue;
            }
            folder.done(&example);
            ran += 1;
        }
    }
    println!("{ran} examples ran");
    assert!(ran >= 12);
}

#[test]
fn completions_and_version_are_printed() {
    let folder = Folder::new();
    for shell in ["bash", "zsh", "fish"] {
        let text = folder.done(&format!("completions {shell}")).text();
        assert!(text.contains("level-sets") && text.contains("inspect"), "{shell}");
    }
    assert_eq!(folder.done("--version").text().trim(), concat!("eikona ", env!("CARGO_PKG_VERSION")));
    assert!(folder.files().is_empty());
}

#[test]
fn every_command_writes_a_report() {
    let folder = Folder::new();
    for (verb, command) in [
        (
            "make",
            "make torus nu=20 nv=10 -o t.ply --seed 3 --jitter 0.1 --curve-out c.json --cut axis=x,at=0.9",
        ),
        ("inspect", "inspect t.ply"),
        ("sdf", "sdf t.ply --points 0 -o d.ply"),
        ("render", "render d.ply -o d.png --size 200x150"),
        ("winding", "winding t.ply --curve c.json -o w.npy"),
        ("bench", "bench sdf --faces 300 --repeats 1"),
        ("bench", "bench winding --faces 300"),
        ("bench", "bench field --faces 300"),
        ("bench", "bench repulse --faces 300"),
    ] {
        folder.done(&format!("{command} --report r.json"));
        let report = folder.json("r.json");
        assert_eq!(report["verb"], verb);
        assert_eq!(report["version"], 2);
        assert!(report["seconds"].as_f64().unwrap() > 0.0);
        assert!(!report["phases"].as_array().unwrap().is_empty(), "{verb}");
        let last = report["outputs"].as_array().unwrap().last().unwrap();
        assert_eq!(last["kind"], "report");
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let folder = Folder::new();
    folder.done(
        "make bumpy_sphere frequency=12 -o s.ply --jitter 0.2 --seed 5 --broken-curve c.json --cut axis=z",
    );
    folder.done("make bumpy_sphere frequency=12 -o again.ply --jitter 0.2 --seed 5");
    assert_eq!(folder.bytes("s.ply"), folder.bytes("again.ply"));
    for threads in [1, 2, 5] {
        folder.done(&format!(
            "sdf s.ply --curve c.json -o d{threads}.ply --render d{threads}.png --size 300x200 --threads {threads}"
        ));
        assert_eq!(folder.bytes("d1.ply"), folder.bytes(&format!("d{threads}.ply")));
        assert_eq!(folder.bytes("d1.png"), folder.bytes(&format!("d{threads}.png")));
    }
    folder.done("make bumpy_sphere frequency=12 -o other.ply --jitter 0.2 --seed 6");
    assert_ne!(folder.bytes("s.ply"), folder.bytes("other.ply"));
}

#[test]
fn pictures_have_the_requested_size() {
    let folder = Folder::new();
    folder.done("make torus nu=20 nv=10 -o t.ply --curve-out c.json --cut axis=z");
    folder.done("sdf t.ply --curve c.json -o d.ply");
    for flags in [
        "",
        "--field quality --isolines 5",
        "--field none",
        "--isolines 0 --map gray --range -1,1",
        "--spacing 0.1 --curve c.json",
        "--azimuth -30 --elevation 80 --zoom 2 --up z --ortho --transparent --no-bar --wireframe",
    ] {
        folder.done(&format!("render d.ply -o d.png --size 161x97 {flags}"));
        assert_eq!(png_size(&folder.bytes("d.png")), (161, 97), "{flags}");
    }
    let outcome = folder.done("render t.ply -o - --size 64x48");
    assert_eq!(png_size(&outcome.stdout), (64, 48));
}

#[test]
fn inspection_counts_faults_and_pieces() {
    let folder = Folder::new();
    folder.done("make torus nu=20 nv=10 -o t.ply --flip-faces 0.1 --broken-curve c.json --cut axis=x,at=20% --keep 0.2 --drop 0.1");
    let outcome = folder.done("inspect t.ply --curve c.json --json");
    let facts: serde_json::Value = serde_json::from_slice(&outcome.stdout).unwrap();
    assert_eq!(facts["topology"]["components"][0]["genus"], 1);
    assert_eq!(facts["topology"]["euler_characteristic"], 0);
    assert_eq!(facts["topology"]["consistently_oriented"], false);
    assert_eq!(facts["topology"]["faces_to_flip"], 40);
    let flipped = &facts["faults"]["inconsistent_edges"];
    assert!(flipped["count"].as_u64().unwrap() > 50);
    assert_eq!(flipped["first"].as_array().unwrap().len(), 5);
    assert!(flipped["advice"].as_str().unwrap().contains("40 faces"));
    let pieces = facts["curves"]["curves"].as_array().unwrap();
    assert_eq!(facts["curves"]["open_ends"].as_array().unwrap().len(), 2 * pieces.len());
    let all = folder.done("inspect t.ply --json --all");
    let facts: serde_json::Value = serde_json::from_slice(&all.stdout).unwrap();
    let count = facts["faults"]["inconsistent_edges"]["count"].as_u64().unwrap() as usize;
    assert_eq!(facts["faults"]["inconsistent_edges"]["first"].as_array().unwrap().len(), count);
    assert_eq!(folder.done("t.ply").stdout, folder.done("inspect t.ply").stdout);
}

#[test]
fn every_shape_is_made_inspected_and_solved() {
    let folder = Folder::new();
    let list = folder.done("make").text();
    let names: Vec<&str> = list
        .lines()
        .skip(2)
        .filter(|l| !l.starts_with(' '))
        .filter_map(|l| l.split_once(':'))
        .map(|l| l.0)
        .collect();
    assert!(names.len() >= 20, "{names:?}");
    for name in &names {
        folder.done(&format!("make {name} -o s.obj -q"));
        folder.done("inspect s.obj");
        folder.done("sdf s.obj --points 0 -o d.csv -q");
        assert!(folder.column("d.csv", "distance").iter().filter(|d| d.is_finite()).count() > 0, "{name}");
    }
    println!("{} shapes", names.len());
}

#[test]
fn curves_are_made_whole_and_broken() {
    let folder = Folder::new();
    folder.done("make torus -o t.ply --curve-out k.json --curve torus-knot,p=2,q=3");
    folder.done("sdf t.ply --curve k.json --unsigned -o d.csv");
    let broken = |flags: &str| {
        folder.done(&format!("make torus -o t.ply --broken-curve b.json --cut axis=z,at=0.1 {flags}"));
        folder.read("b.json")
    };
    let even = broken("");
    assert_eq!(even, broken(""));
    assert_ne!(even, broken("--seed 1"));
    assert_eq!(broken("--seed 1"), broken("--seed 1"));
    let facts = folder.done("inspect t.ply --curve b.json --json");
    let facts: serde_json::Value = serde_json::from_slice(&facts.stdout).unwrap();
    let kept = facts["curves"]["length"].as_f64().unwrap();
    folder.done("make torus -o t.ply --curve-out w.json --cut axis=z,at=0.1");
    let facts = folder.done("inspect t.ply --curve w.json --json");
    let facts: serde_json::Value = serde_json::from_slice(&facts.stdout).unwrap();
    let share = kept / facts["curves"]["length"].as_f64().unwrap();
    assert!((0.5..0.8).contains(&share), "{share}"); // 10 % kept for every 5 % dropped
}

#[test]
fn the_benchmark_measures_every_mode() {
    let folder = Folder::new();
    for shape in ["sphere", "torus"] {
        let text =
            folder.done(&format!("bench sdf --faces 2000,4000 --shape {shape} --repeats 1 --json")).text();
        let bench: serde_json::Value = serde_json::from_str(&text).unwrap();
        let runs = bench["runs"].as_array().unwrap();
        assert_eq!(runs.len(), 2);
        for run in runs {
            let modes: Vec<&str> =
                run["modes"].as_array().unwrap().iter().map(|m| m["mode"].as_str().unwrap()).collect();
            assert_eq!(modes, ["auto", "free", "zero", "per-component", "soft"]);
            for mode in run["modes"].as_array().unwrap() {
                assert!(mode["l2_error"].as_f64().unwrap() < 5e-3, "{mode}");
            }
        }
    }
}

#[test]
fn the_benchmark_measures_winding_numbers() {
    let folder = Folder::new();
    for shape in ["torus", "double-torus"] {
        let text = folder.done(&format!("bench winding --faces 9000 --shape {shape} --json")).text();
        let bench: serde_json::Value = serde_json::from_str(&text).unwrap();
        let [closed, broken] = bench["runs"].as_array().unwrap().as_slice() else { panic!("two states") };
        assert_eq!((closed["curve"].as_str(), closed["endpoints"].as_u64()), (Some("closed"), Some(0)));
        assert_eq!(closed["right"].as_f64(), Some(1.0));
        assert!(broken["endpoints"].as_u64().unwrap() >= 18);
        assert!(broken["right"].as_f64().unwrap() > 0.9, "{broken}");
        for run in [closed, broken] {
            assert!(run["gap"].as_f64().unwrap() < 1e-9, "{run}");
            assert!(run["objective"].as_f64().unwrap() > 0.01, "some loops bound nothing");
            assert!(run["phases"].as_array().unwrap().len() > 5);
        }
    }
}

#[test]
fn the_benchmark_measures_fields() {
    let folder = Folder::new();
    let text = folder.done("bench field --faces 3000 --threads 2 --json").text();
    let bench: serde_json::Value = serde_json::from_str(&text).unwrap();
    let [run] = bench["runs"].as_array().unwrap().as_slice() else { panic!("one size") };
    assert_eq!(run["threads"], 2);
    assert!(run["residual"].as_f64().unwrap() < 1e-10, "{run}");
    assert_eq!(run["edits"].as_array().unwrap().len(), 3, "{run}");
    assert!(run["automatic_singularities"].as_u64().unwrap() > 0, "{run}");
    let table = folder.done("bench field --faces 300").text();
    assert!(table.contains("one singularity moved: vertex"), "{table}");
    folder.refused("bench field --faces 300 --peer libigl --python no-such-python", 1, &["--python PATH"]);
}

#[test]
fn the_benchmark_measures_repulsion() {
    let folder = Folder::new();
    let text = folder.done("bench repulse --faces 1500 --threads 2 --json").text();
    let bench: serde_json::Value = serde_json::from_str(&text).unwrap();
    let [run] = bench["runs"].as_array().unwrap().as_slice() else { panic!("one size") };
    assert_eq!(run["threads"], 2);
    for energy in run["energies"].as_array().unwrap() {
        assert!(energy["off"][0].as_f64().unwrap().abs() < 0.01, "{energy}");
    }
    let steps = run["steps"].as_array().unwrap();
    assert_eq!(steps.len(), 2);
    for step in steps {
        let phases: Vec<&str> =
            step["phases"].as_array().unwrap().iter().map(|phase| phase[0].as_str().unwrap()).collect();
        assert_eq!(phases, ["direction", "line search", "remeshing", "energy"], "{step}");
    }
    let table = folder.done("bench repulse --faces 300").text();
    assert!(table.contains("step with collision detection"), "{table}");
}

#[test]
fn the_winding_benchmark_takes_threads_and_one_size_per_process() {
    let folder = Folder::new();
    let table = folder.done("bench winding --faces 300 --threads 2").text();
    assert!(table.contains("2 thread(s)"), "{table}");
    let measured = "bench winding --in-this-process --faces 300";
    folder.refused(measured, 2, &["--curve closed or --curve broken"]);
    folder.refused(&format!("{measured},400 --curve closed"), 2, &["one size"]);
    for curve in ["closed", "broken"] {
        let run = folder.done(&format!("{measured} --curve {curve}")).text();
        let run: serde_json::Value = serde_json::from_str(&run).unwrap();
        assert_eq!((run["curve"].as_str(), run["endpoints"] == 0), (Some(curve), curve == "closed"));
    }
}

#[test]
fn small_numbers_are_shown_with_an_exponent() {
    let folder = Folder::new();
    let small = |line: &str| match line.strip_prefix("v ") {
        Some(numbers) => {
            let numbers = numbers.split(' ').map(|x| format!("{:e}", 1e-9 * x.parse::<f64>().unwrap()));
            format!("v {}\n", numbers.collect::<Vec<_>>().join(" "))
        }
        None => format!("{line}\n"),
    };
    let mesh: String = (grid_obj() + "l 16 17 18\n").lines().map(small).collect();
    folder.write("small.obj", &mesh);
    let text = folder.done("inspect small.obj").text();
    for words in [
        "1.000000e-8 x 2.000000e-9 x 0.000000e0, from (0.000000, 0.000000, 0.000000)",
        "area         2.000000e-17",
        "segments, length 2.000000e-9",
        "nodes, length 2.000000e-9",
        "the nearest other end is at most 2.000000e-9 away",
    ] {
        assert!(text.contains(words), "no {words:?} in\n{text}");
    }
    let outcome = folder.done("sdf small.obj -o out.csv");
    assert!(outcome.stderr.contains("distance from -5.000000e-9 to 5.000000e-9"), "{}", outcome.stderr);
    let words = ["z=1e-20 does not meet", "between 0 and 0"];
    folder.refused("make grid nx=2 ny=2 -o g.obj --cut axis=z,at=1e-20 --curve-out c.json", 2, &words);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_leaves_no_files() {
    use std::process::{Command, Stdio};
    let folder = Folder::new();
    folder.write("grid.obj", &grid_obj());
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let words = "sdf grid.obj --points 0 -o - --out-format csv --isolines i.obj --report r.json";
    let output = Command::new(env!("CARGO_BIN_EXE_eikona"))
        .args(words.split(' '))
        .current_dir(&folder.0)
        .stdout(Stdio::from(full))
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("cannot write to standard output"), "{stderr}");
    assert_eq!(folder.files(), ["grid.obj"]);
}

#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn wild_meshes_are_inspected_or_refused() {
    let mut ran = 0;
    let data = data();
    let folder = Folder::new();
    for part in ["badquality", "nonmanifold", "nonorientable", "soup"] {
        for entry in std::fs::read_dir(data.join(part)).unwrap() {
            let path = entry.unwrap().path().display().to_string();
            let outcome = folder.run_words([path.as_str()], &[]);
            assert!(matches!(outcome.code, Some(0 | 3)), "{path}: {}", outcome.stderr);
            ran += 1;
        }
    }
    println!("{ran} files ran");
    assert!(ran > 20, "{ran}");
}
