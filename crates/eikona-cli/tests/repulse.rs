//! `eikona repulse`.

mod run;

use eikona_mesh::TriangleMesh;
use eikona_mesh::io::{MeshFile, MeshOut, read_mesh, write_mesh};
use run::Folder;
use serde_json::Value;
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

/// A torus whose halves are red and blue, with the height as a value and a number per face.
fn coloured_torus(folder: &Folder) -> TriangleMesh {
    let mesh = eikona_mesh::shapes::torus(1.0, 0.4, 40, 20).unwrap();
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nproperty double height\n\
         property float nx\nproperty float ny\nproperty float nz\nelement face {}\n\
         property list uchar int vertex_indices\nproperty int part\nend_header\n",
        mesh.vertex_count(),
        mesh.face_count()
    );
    for [x, y, z] in mesh.positions() {
        let colour = if *x < 0.0 { "255 0 0" } else { "0 0 255" };
        text += &format!("{x} {y} {z} {colour} {z} 0 0 1\n");
    }
    for (f, [a, b, c]) in mesh.faces().zip(mesh.triangles()) {
        let x: f64 = mesh.face_positions(f).iter().map(|p| p[0]).sum();
        text += &format!("3 {a} {b} {c} {}\n", if x < 0.0 { 7 } else { 1 });
    }
    folder.write("c.ply", &text);
    mesh
}

fn read(folder: &Folder, name: &str) -> MeshFile {
    read_mesh(folder.0.join(name)).unwrap()
}

fn scalar<'a>(scalars: &'a [(String, Vec<f64>)], name: &str) -> &'a [f64] {
    &scalars.iter().find(|(other, _)| other == name).unwrap_or_else(|| panic!("no {name}")).1
}

#[test]
fn colours_and_values_follow_the_surface() {
    let folder = Folder::new();
    let start = coloured_torus(&folder);
    folder.done("repulse c.ply -o run --until steps=20 --checkpoint-every 8");
    let first = read(&folder, "run/frames/000000.ply");
    assert_eq!(first.mesh.positions, start.positions());
    let last = read(&folder, "run/frames/000020.ply");
    assert_ne!(last.mesh.face_count(), start.face_count(), "it was not remeshed");
    for (file, blurred) in [(&first, 0.0), (&last, 0.3)] {
        let [red, green, blue] =
            ["red", "green", "blue"].map(|name| scalar(&file.vertex_scalars, name).to_vec());
        let mut pure = 0;
        for (v, [x, ..]) in file.mesh.positions.iter().enumerate().filter(|(_, p)| p[0].abs() >= blurred) {
            let expected = if *x < 0.0 { [255.0, 0.0, 0.0] } else { [0.0, 0.0, 255.0] };
            assert_eq!([red[v], green[v], blue[v]], expected, "vertex {v} at x = {x}");
            pure += 1;
        }
        assert!(pure > file.mesh.vertex_count() / 2);
        let part = scalar(&file.face_scalars, "part");
        for (corners, part) in file.mesh.faces().zip(part) {
            let x = corners.iter().map(|v| file.mesh.positions[*v as usize][0]).sum::<f64>() / 3.0;
            if x.abs() >= blurred.max(1e-9) {
                assert_eq!(*part, if x < 0.0 { 7.0 } else { 1.0 }, "at x = {x}");
            }
        }
        assert!(!file.vertex_scalars.iter().any(|(name, _)| name == "nx"), "normals of the input are wrong");
    }
    // The surface is still symmetric, and the height grows with z.
    let heights = scalar(&last.vertex_scalars, "height");
    for (p, height) in last.mesh.positions.iter().zip(heights).filter(|(p, _)| p[2].abs() > 0.1) {
        assert!(height * p[2] > 0.0 && height.abs() <= 0.4, "{height} at {p:?}");
    }

    // A resumed run writes the same frames.
    folder.done("repulse c.ply -o part --until steps=11 --checkpoint-every 8");
    folder.done("repulse c.ply -o part --until steps=20 --checkpoint-every 8 --resume");
    for step in 0..=20 {
        let name = format!("frames/{step:06}.ply");
        assert_eq!(folder.bytes(&format!("part/{name}")), folder.bytes(&format!("run/{name}")), "{name}");
    }
    folder.refused("repulse c.ply -o part --until steps=21 --no-data --resume", 2, &["settings"]);
    folder.done("repulse c.ply -o bare --until steps=1 --no-data");
    let bare = read(&folder, "bare/frames/000001.ply");
    assert!(bare.vertex_scalars.is_empty() && bare.face_scalars.is_empty());
    folder.warned("repulse c.ply -o stl --until steps=1 --frames stl", &["frames: STL cannot store colours"]);
    assert!(folder.bytes("stl/frames/000001.stl").len() > 84);
    let listed = folder.json("stl/frames/manifest.json")["frames"][1]["mesh"].clone();
    assert_eq!(listed, "000001.stl");
}

/// The share of a turn around z.
fn turn(p: [f64; 3]) -> f64 {
    p[1].atan2(p[0]) / std::f64::consts::TAU + 0.5
}

#[test]
fn texture_coordinates_keep_their_seam() {
    let folder = Folder::new();
    let mesh = eikona_mesh::shapes::torus(1.0, 0.4, 40, 20).unwrap();
    // u goes once around, so it jumps at the seam.
    let mut uvs = Vec::new();
    for f in mesh.faces() {
        let corners = mesh.face_positions(f);
        let middle = turn([0, 1, 2].map(|k| corners.iter().map(|p| p[k]).sum::<f64>() / 3.0));
        let near = |u: f64| u - (u - middle).round();
        uvs.extend(corners.map(|p| [near(turn(p)), p[2]]));
    }
    let mut out = MeshOut::from(&mesh);
    out.corner_uvs = Some(&uvs);
    write_mesh(folder.0.join("uv.obj"), &out).unwrap();
    folder.done("repulse uv.obj -o run --until steps=20 --frames-every 20 --frames obj");
    assert_eq!(read(&folder, "run/frames/000000.obj").corner_uvs.unwrap(), uvs);
    let last = read(&folder, "run/frames/000020.obj");
    assert_ne!(last.mesh.face_count(), mesh.face_count(), "it was not remeshed");
    let uvs = last.corner_uvs.unwrap();
    let (mut sides, mut widest) = ([0, 0], 0f64);
    for (corners, uvs) in last.mesh.faces().zip(uvs.as_chunks::<3>().0) {
        for (v, [u, _]) in corners.iter().zip(uvs) {
            let off = u - turn(last.mesh.positions[*v as usize]);
            assert!((off - off.round()).abs() < 0.03, "u is {u}, but should be {}", u - off);
            sides[0] += usize::from(*u < 0.03);
            sides[1] += usize::from(*u > 0.97);
        }
        let [a, b, c] = uvs.map(|uv| uv[0]);
        widest = widest.max(a.max(b).max(c) - a.min(b).min(c));
    }
    assert!(sides[0] > 50 && sides[1] > 50, "{sides:?}");
    assert!(widest < 0.1, "a face reaches across the seam: {widest}");

    // GLB has one vertex on each side of the seam.
    folder.done("repulse uv.obj -o glb --until steps=0 --frames glb");
    let glb = read(&folder, "glb/frames/000000.glb").mesh;
    assert_eq!(glb.vertex_count(), mesh.vertex_count() + 20);
    assert_eq!(glb.face_count(), mesh.face_count());
}

/// Description and binary data of a GLB file.
fn glb(bytes: &[u8]) -> (Value, &[u8]) {
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
    assert_eq!((&bytes[..4], word(4), word(8)), (&b"glTF"[..], 2, bytes.len()));
    let json = word(12);
    assert_eq!(word(20 + json), bytes.len() - 28 - json);
    (serde_json::from_slice(&bytes[20..20 + json]).unwrap(), &bytes[28 + json..])
}

/// The numbers of an accessor, whose bounds are checked.
fn floats(root: &Value, data: &[u8], accessor: &Value) -> Vec<f32> {
    let accessor = &root["accessors"][accessor.as_u64().unwrap() as usize];
    let view = &root["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
    let [start, length] = ["byteOffset", "byteLength"].map(|key| view[key].as_u64().unwrap() as usize);
    let numbers: Vec<f32> =
        data[start..start + length].as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    let width = if accessor["type"] == "VEC3" { 3 } else { 1 };
    assert_eq!(numbers.len(), width * accessor["count"].as_u64().unwrap() as usize);
    for (k, (least, most)) in accessor["min"]
        .as_array()
        .into_iter()
        .flatten()
        .zip(accessor["max"].as_array().unwrap_or(&vec![]))
        .enumerate()
    {
        let own = || numbers.iter().skip(k).step_by(width).map(|x| f64::from(*x));
        assert_eq!(own().fold(f64::INFINITY, f64::min), least.as_f64().unwrap());
        assert_eq!(own().fold(f64::NEG_INFINITY, f64::max), most.as_f64().unwrap());
    }
    numbers
}

#[test]
fn an_animation_plays_the_frames() {
    let folder = Folder::new();
    let start = coloured_torus(&folder);
    let run = "repulse c.ply --remesh off --animation=10 --frames-every 2 --checkpoint-every 2";
    folder.done(&format!("{run} -o run --until steps=6"));
    let bytes = folder.bytes("run/animation.glb");
    let (root, data) = glb(&bytes);
    let primitive = &root["meshes"][0]["primitives"][0];
    let targets = primitive["targets"].as_array().unwrap();
    assert_eq!(targets.len(), 3);
    let sampler = &root["animations"][0]["samplers"][0];
    assert_eq!(sampler["interpolation"], "LINEAR");
    assert_eq!(floats(&root, data, &sampler["input"]), [0.0, 0.1, 0.2, 0.3]);
    let weights = floats(&root, data, &sampler["output"]);
    let base = ["POSITION", "NORMAL"].map(|name| floats(&root, data, &primitive["attributes"][name]));
    for (k, step) in [0, 2, 4, 6].into_iter().enumerate() {
        let mut shown = base.clone();
        for (target, weight) in targets.iter().zip(&weights[3 * k..3 * k + 3]) {
            for (shown, name) in shown.iter_mut().zip(["POSITION", "NORMAL"]) {
                let way = floats(&root, data, &target[name]);
                shown.iter_mut().zip(way).for_each(|(x, d)| *x += weight * d);
            }
        }
        let frame = read(&folder, &format!("run/frames/{step:06}.ply")).mesh.positions;
        for (p, shown) in frame.iter().zip(shown[0].as_chunks::<3>().0) {
            (0..3).for_each(|k| assert!((p[k] - f64::from(shown[k])).abs() < 5e-7));
        }
        for n in shown[1].as_chunks::<3>().0 {
            let length = n.iter().map(|x| x * x).sum::<f32>().sqrt();
            assert!((length - 1.0).abs() < 1e-5);
        }
    }
    assert_eq!(read(&folder, "run/animation.glb").mesh.vertex_count(), start.vertex_count());
    assert!(!floats(&root, data, &primitive["attributes"]["COLOR_0"]).is_empty());

    // A resumed run has the frames of both parts.
    folder.done(&format!("{run} -o part --until steps=3"));
    folder.done("repulse c.ply --remesh off --frames-every 2 -o part --until steps=4 --resume");
    std::fs::remove_file(folder.0.join("part/frames/000003.ply")).unwrap();
    folder.refused(&format!("{run} -o part --until steps=4 --resume"), 1, &["000003.ply"]);
    assert_eq!(glb(&folder.bytes("part/animation.glb")).0["animations"][0]["name"], "frames");
    folder.done(&format!("{run} -o half --until steps=4"));
    folder.done(&format!("{run} -o half --until steps=6 --resume"));
    assert_eq!(folder.bytes("half/animation.glb"), bytes);

    folder.refused("repulse c.ply -o no --animation", 2, &["--remesh off", "frames/"]);
    folder.refused("repulse c.ply -o no --remesh off --animation=0", 2, &["frames per second"]);
    folder.refused("repulse c.ply -o no --remesh off --animation --frames stl", 2, &["STL"]);
}

/// A limit of the size of files stands for a full disk: it fails in mid-run, when the surface has
/// grown.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_a_checkpoint_to_resume() {
    let folder = Folder::new();
    let scene = "mesh = { shape = \"icosphere\", levels = 2 }\nkeep.area = { times = 4, steps = 20 }\n\
                 stop.steps = 24\n";
    folder.write("g.toml", scene);
    folder.done("repulse g.toml -o whole --checkpoint-every 2");
    folder.done("repulse g.toml -o start --until steps=0");
    // The shell counts blocks of 512 or 1024 bytes.
    let size = |name: &str| folder.bytes(name).len();
    let blocks = size("whole/checkpoint") * 7 / 10 / 1024;
    assert!(size("start/checkpoint") < 512 * blocks);
    let command =
        format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" repulse g.toml -o part --checkpoint-every 2");
    let output = Command::new("sh")
        .args(["-c", &command, env!("CARGO_BIN_EXE_eikona")])
        .current_dir(&folder.0)
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("cannot write this file") && message.contains("--resume"), "{message}");
    let done = folder.json("part/checkpoint")["step"].as_u64().unwrap();
    assert!((2..24).contains(&done), "{done}");
    folder.done("repulse g.toml -o part --checkpoint-every 2 --resume");
    folder.assert_same_run("part", "whole");
}
