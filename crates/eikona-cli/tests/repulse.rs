//! `eikona repulse`.

mod run;

use run::Folder;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

#[test]
fn a_run_has_its_log_frames_and_checkpoint() {
    let folder = Folder::new();
    folder.done("make torus -o t.ply");
    folder.done("repulse t.ply -o run --until steps=3 --frames-every 2 --report r.json");
    let steps = folder.column("run/log.csv", "step");
    assert_eq!(steps, [0.0, 1.0, 2.0, 3.0]);
    assert!(
        folder
            .read("run/log.csv")
            .starts_with("step,seconds,energy,area,volume,self_distance,faces,step_size,solver_iterations\n")
    );
    let energies = folder.column("run/log.csv", "energy");
    assert!(energies.windows(2).all(|pair| pair[1] < pair[0]), "{energies:?}");
    let areas = folder.column("run/log.csv", "area");
    assert!(areas.iter().all(|area| (area / areas[0] - 1.0).abs() < 1e-8), "{areas:?}");
    assert!(folder.column("run/log.csv", "self_distance").iter().all(|d| *d > 0.0));
    assert_eq!(folder.read("run/log.jsonl").lines().count(), 4);
    let last: serde_json::Value =
        serde_json::from_str(folder.read("run/log.jsonl").lines().last().unwrap()).unwrap();
    assert_eq!(last["energy"].as_f64().unwrap(), energies[3]);
    assert!(last["descent"].as_f64().unwrap() > 0.0);
    let frames = folder.json("run/frames/manifest.json")["frames"].clone();
    let frames: Vec<u64> = frames.as_array().unwrap().iter().map(|f| f["step"].as_u64().unwrap()).collect();
    assert_eq!(frames, [0, 2, 3]);
    for frame in frames {
        let inspected =
            folder.done(&format!("inspect run/frames/{frame:06}.ply --self-intersections")).text();
        assert!(inspected.contains("no two faces intersect"), "{inspected}");
    }
    let result = folder.json("r.json")["result"].clone();
    assert_eq!(result["steps"], 3);
    assert_eq!(result["stopped_by"], "steps");
    assert_eq!(result["energy"].as_f64().unwrap(), energies[3]);
    // The energy of the last frame, with other clusters.
    folder.done("energy run/frames/000003.ply --report e.json");
    let alone = folder.json("e.json")["result"]["energy"].as_f64().unwrap();
    assert!((alone / energies[3] - 1.0).abs() < 5e-3, "{alone} {}", energies[3]);

    folder.done("repulse t.ply -o volume --keep area,volume --until steps=2");
    let volumes = folder.column("volume/log.csv", "volume");
    assert!((volumes[2] / volumes[0] - 1.0).abs() < 1e-8, "{volumes:?}");
    folder.done(&format!("repulse t.ply -o bound --until energy={} --until steps=9", energies[1]));
    assert_eq!(folder.column("bound/log.csv", "step"), [0.0, 1.0]);
    // Nothing is left to do, but one frame is there.
    folder.done("repulse t.ply -o none --until seconds=0 --render");
    assert_eq!(folder.column("none/log.csv", "step"), [0.0]);
    assert!(folder.bytes("none/frames/000000.png").starts_with(b"\x89PNG"));
}

#[test]
fn a_run_settles_if_nothing_tells_it_when_to_stop() {
    let folder = Folder::new();
    folder.done("make icosphere levels=2 -o s.ply");
    folder.done("repulse s.ply -o run --report r.json");
    let result = folder.json("r.json")["result"].clone();
    assert!(["settled", "minimum"].contains(&result["stopped_by"].as_str().unwrap()), "{result}");
}

#[test]
fn a_killed_run_is_resumed_bit_for_bit() {
    let folder = Folder::new();
    folder.done("make torus -o t.ply");
    folder.done("repulse t.ply -o whole --until steps=12 --checkpoint-every 2");
    let mut child = Command::new(env!("CARGO_BIN_EXE_eikona"))
        .args("repulse t.ply -o part --until steps=12 --checkpoint-every 2 -qq".split(' '))
        .current_dir(&folder.0)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    // Killed as soon as it is under way.
    let start = Instant::now();
    while !folder.0.join("part/frames/000003.ply").exists() && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(folder.json("part/checkpoint")["step"].as_u64().unwrap() < 12, "it was not killed in mid-run");
    folder.done("repulse t.ply -o part --until steps=12 --checkpoint-every 2 --resume");
    assert_eq!(folder.bytes("part/frames/000012.ply"), folder.bytes("whole/frames/000012.ply"));
    for column in ["step", "energy", "step_size", "self_distance"] {
        let [part, whole] = ["part", "whole"].map(|name| folder.column(&format!("{name}/log.csv"), column));
        assert_eq!(part, whole, "{column}");
    }
    // A run that is done goes on.
    folder.done("repulse t.ply -o part --until steps=13 --resume");
    assert_eq!(folder.column("part/log.csv", "step").len(), 14);
}

#[test]
fn faults_name_what_to_do_and_leave_no_folder() {
    let folder = Folder::new();
    folder.done("make torus nu=12 nv=6 -o t.ply");
    folder.write("book.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nf 1 2 3\nf 2 1 4\nf 1 2 5\n");
    folder.write("flip.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.5\nf 1 2 3\nf 2 3 4\n");
    folder.write("cross.obj", "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 -1\nv 2 1 3\nv 1 2 3\nf 1 2 3\nf 4 5 6\n");
    folder.write("nan.obj", "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n");
    for (command, code, words) in [
        ("repulse t.ply", 2, vec!["--output"]),
        ("repulse t.ply -o run --until step=3", 2, vec!["steps=K"]),
        ("repulse t.ply -o run --until steps=-3", 2, vec!["steps=K"]),
        ("repulse t.ply -o run --keep mass", 2, vec!["area, volume"]),
        ("repulse t.ply -o run --p 2", 2, vec!["p = 6"]),
        ("repulse t.ply -o run --frames-every 0", 2, vec!["--frames-every"]),
        ("repulse t.ply -o t.ply", 2, vec!["this is a file"]),
        ("repulse none.ply -o run", 3, vec!["no such file"]),
        ("repulse nan.obj -o run", 3, vec!["nan"]),
        ("repulse book.obj -o run", 3, vec!["3 faces", "split"]),
        ("repulse flip.obj -o run --keep volume", 3, vec!["oriented", "orient the mesh"]),
        ("repulse cross.obj -o run", 3, vec!["1 pairs", "face 0 and face 1", "below 4"]),
        ("repulse t.ply -o run --resume", 3, vec!["checkpoint", "without --resume"]),
    ] {
        folder.refused(command, code, &words);
    }
    folder.done("repulse cross.obj -o crossing --p 3.5 --until steps=1");
    let found = folder.done("inspect cross.obj --self-intersections --json").text();
    let found: serde_json::Value = serde_json::from_str(&found).unwrap();
    assert_eq!(found["self_intersections"], serde_json::json!({"count": 1, "pairs": [[0, 1]]}));
    folder.done("repulse t.ply -o run --until steps=1");
    folder.refused("repulse t.ply -o run --until steps=2", 2, &["holds a run", "--resume"]);
    folder.refused("repulse t.ply -o run --until steps=2 --keep none --resume", 2, &["settings"]);
    folder.refused("repulse t.ply -o . --until steps=2", 2, &["not empty"]);
    folder.done("make torus nu=12 nv=6 minor=0.3 -o other.ply");
    folder.refused("repulse other.ply -o run --until steps=2 --resume", 2, &["settings"]);
    let checkpoint = folder.read("run/checkpoint");
    folder.write("run/checkpoint", &checkpoint[..checkpoint.len() / 2]);
    folder.refused("repulse t.ply -o run --resume", 3, &["no checkpoint"]);
}
