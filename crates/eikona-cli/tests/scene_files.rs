//! `eikona repulse SCENE`.

mod run;

use run::{Folder, data};

#[test]
fn both_grammars_say_the_same() {
    let folder = Folder::new();
    folder.done("make torus nu=24 nv=10 minor=0.3 -o t.obj");
    let original = "repel_mesh t.obj 6 12\r\nconstrain area\r\nconstrain barycenter\r\niteration_limit 3\r\n";
    let toml = "mesh = \"t.obj\"\nstop.steps = 3\n";
    for (k, (name, text)) in [("s.txt", original), ("s", original), ("s.toml", toml)].into_iter().enumerate()
    {
        folder.write(name, text);
        folder.done(&format!("repulse {name} -o run{k}"));
    }
    folder.done("repulse t.obj -o run3 --until steps=3");
    let last = folder.bytes("run3/frames/000003.ply");
    for k in 0..3 {
        assert_eq!(folder.bytes(&format!("run{k}/frames/000003.ply")), last, "run{k}");
    }
}

#[test]
fn a_scene_grows_in_a_container() {
    let folder = Folder::new();
    let scene = r#"
mesh = { shape = "icosphere", levels = 3 }
[keep]
barycentre = "floating"
area = { times = 1.5, steps = 6 }
[[obstacle]]
mesh = { shape = "icosphere", levels = 3, move = [0, 0, 2.2] }
weight = 0.1
[[implicit]]
plane = { point = [0, 0, -1.5], normal = [0, 0, 1] }
action = "repel"
power = 2
weight = 0.1
[stop]
steps = 8
"#;
    folder.write("s.toml", scene);
    folder.done("repulse s.toml -o run --checkpoint-every 4 --report r.json");
    let report = folder.json("r.json");
    let area = report["result"]["area"].as_f64().unwrap();
    let first: f64 =
        folder.read("run/log.csv").lines().nth(1).unwrap().split(',').nth(3).unwrap().parse().unwrap();
    assert!((area / (1.5 * first) - 1.0).abs() < 1e-6, "{area} from {first}");
    // It stays above the plane and below the other sphere.
    let ply = eikona_mesh::io::read_mesh(folder.0.join("run/frames/000008.ply")).unwrap().mesh;
    let heights = ply.positions.iter().map(|p| p[2]);
    assert!(heights.clone().fold(f64::INFINITY, f64::min) > -1.5);
    let off = |p: &[f64; 3]| (p[0] * p[0] + p[1] * p[1] + (p[2] - 2.2) * (p[2] - 2.2)).sqrt();
    assert!(ply.positions.iter().map(off).fold(f64::INFINITY, f64::min) > 0.98);
}

#[test]
fn pins_stay_and_move() {
    let folder = Folder::new();
    folder.done("make cylinder -o c.obj");
    let pinned = "mesh = \"c.obj\"\n[keep]\nboundary_vertices = true\n[stop]\nsteps = 4\n";
    folder.write("s.toml", pinned);
    folder.done("repulse s.toml -o run");
    let rim = |name: &str| {
        let mesh = eikona_mesh::io::read_mesh(folder.0.join(name)).unwrap().mesh.triangulate().unwrap().0;
        let rim = mesh.vertices().filter(|v| mesh.is_boundary_vertex(*v));
        let mut rim: Vec<[f64; 3]> = rim.map(|v| mesh.position(v)).collect();
        rim.sort_by(|p, q| p.partial_cmp(q).unwrap());
        rim
    };
    assert_eq!(rim("run/frames/000000.ply"), rim("run/frames/000004.ply"));
    assert_ne!(folder.bytes("run/frames/000000.ply"), folder.bytes("run/frames/000004.ply"));
    let moved = "mesh = { shape = \"icosphere\", levels = 3 }\n[[pin]]\nvertices = [0]\n[[pin]]\n\
                 vertices = [1]\nmove = [0.3, 0, 0]\nsteps = 5\n[stop]\nsteps = 5\n[keep]\narea = true\n";
    folder.write("m.toml", moved);
    folder.done("repulse m.toml -o moved");
    let positions = |name: &str| eikona_mesh::io::read_mesh(folder.0.join(name)).unwrap().mesh.positions;
    let (before, after) = (positions("moved/frames/000000.ply"), positions("moved/frames/000005.ply"));
    assert_eq!(before[0], after[0]);
    (0..3).for_each(|k| assert!((before[1][k] + [0.3, 0.0, 0.0][k] - after[1][k]).abs() < 1e-9));
}

#[test]
fn faults_of_a_scene_leave_no_folder() {
    let folder = Folder::new();
    folder.write("s.txt", "repel_mesh t.obj 6 12\nconstrian area\n");
    let words = ["s.txt: 2 faults", "line 1: there is no file t.obj", "line 2: ", "`constrain`"];
    folder.refused("repulse s.txt -o run", 3, &words);
    folder.write("s.toml", "p = 6\n");
    folder.refused("repulse s.toml -o run", 3, &["s.toml: nothing says what to move"]);
    folder.refused("repulse none.txt -o run", 3, &["none.txt: no such file"]);
}

#[test]
fn what_does_not_fit_names_the_line() {
    let folder = Folder::new();
    folder.done("make icosphere levels=2 -o s.obj");
    folder.done("make torus -o o.obj");
    let refused = |text: &str, words: &[&str]| {
        folder.write("s.txt", text);
        folder.refused("repulse s.txt -o run", 3, words);
        assert!(!folder.0.join("run").exists(), "{text}");
    };
    refused("repel_mesh s.obj\nconstrain vertices 999\n", &["line 2", "999", "162 vertices"]);
    refused("repel_mesh s.obj\nminimize willmore 1 3\n", &["line 2", "takes no target"]);
    refused("repel_mesh s.obj\nobstacle o.obj\n", &["intersect", "move the obstacle away"]);
    folder.refused("repulse s.txt -o run --p 4", 2, &["--p goes with a mesh"]);
}

#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn scenes_of_the_data_folder_run() {
    let folder = Folder::new();
    let mut count = 0;
    for name in ["Boundary", "HandcuffsPole", "HopfLink", "KleinBottle", "LungGrowing", "Lowres", "Walnut"] {
        let scene = data().join("repulsive").join(name).join("scene.txt");
        folder.done(&format!("repulse {} -o {name} --until steps=2 --frames-every 2", scene.display()));
        assert!(folder.read(&format!("{name}/log.csv")).lines().count() == 4, "{name}");
        count += 1;
    }
    println!("{count} files");
}

#[test]
fn every_method_runs() {
    let folder = Folder::new();
    folder.done("make torus nu=24 nv=10 minor=0.3 -o t.obj");
    let mut energies = Vec::new();
    for method in ["hs", "aqp", "bqn", "h1", "h1-lbfgs", "h2", "l2", "willmore"] {
        folder.write("s.txt", &format!("repel_mesh t.obj\nconstrain area\nmethod {method}\n"));
        folder.done(&format!("repulse s.txt -o {method} --until steps=5"));
        let column = folder.column(&format!("{method}/log.csv"), "energy");
        assert!(column[5] < column[0], "{method}: {column:?}");
        energies.push(column[5].to_bits());
    }
    energies.sort_unstable();
    energies.dedup();
    // AQP takes the steps of H1 where its extrapolation does not help.
    assert!(energies.len() >= 7, "{energies:?}");
}

/// Coarse rings: where the energy knows of centroids alone, faces slip between each other's unless
/// collisions are looked for (RS figure 27). Adaptive quadrature keeps them apart, too.
#[test]
fn coarse_rings_slip_through_each_other_unless_collisions_are_detected() {
    let folder = Folder::new();
    let scene =
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes/slip-through.toml");
    let scene = std::fs::read_to_string(scene).unwrap();
    assert!(scene.contains("collisions = true"));
    folder.write("held.toml", &scene);
    let free = scene.replace("collisions = true", "collisions = false");
    folder.write("free.toml", &free);
    folder.write("adaptive.toml", &free.replace("midpoint", "adaptive"));
    let intersecting = |name: &str| {
        folder.done(&format!("repulse {name}.toml -o {name} --until steps=60 --frames-every 10"));
        let frames = (0..=6).map(|k| format!("{name}/frames/{:06}.ply", 10 * k));
        let count = frames.map(|frame| {
            let mesh =
                eikona_mesh::io::read_mesh(folder.0.join(frame)).unwrap().mesh.triangulate().unwrap().0;
            eikona::spatial::self_intersections(&mesh, 1).unwrap().len()
        });
        count.sum::<usize>()
    };
    assert_eq!(intersecting("held"), 0);
    assert!(intersecting("free") > 10);
    assert_eq!(intersecting("adaptive"), 0);
}

/// The scenes that come with the project take a step.
#[test]
fn examples_run() {
    let folder = Folder::new();
    let scenes = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/scenes");
    let mut names: Vec<_> = std::fs::read_dir(&scenes).unwrap().map(|entry| entry.unwrap().path()).collect();
    names.sort();
    assert!(names.len() > 10);
    for path in names {
        let name = path.file_stem().unwrap().to_str().unwrap();
        let run = format!("repulse {} -o {name} --until steps=1", path.display());
        if name == "klein-bottle" {
            folder.warned(&run, &["intersect at the start"]);
        } else {
            folder.done(&run);
        }
        assert_eq!(folder.column(&format!("{name}/log.csv"), "step"), [0.0, 1.0], "{name}");
    }
}

#[test]
fn growth_and_moving_pins_resume_bit_for_bit() {
    let folder = Folder::new();
    let grows = "keep.volume = { times = 3, steps = 8 }\n[[obstacle]]\n\
                 mesh = { shape = \"icosphere\", levels = 2, scale = 1.6 }\nweight = 0.1\n";
    let moves = "keep.area = { times = 1.3, steps = 6 }\n[[pin]]\nvertices = [0]\nmove = [0, 0, 0.8]\n\
                 steps = 7\n[[pin]]\nvertices = [11]\n";
    for (name, text) in [("grows", grows), ("moves", moves)] {
        let text = format!("mesh = {{ shape = \"icosphere\", levels = 2 }}\n{text}");
        folder.write("s.toml", &text);
        folder.done(&format!("repulse s.toml -o {name} --until steps=10"));
        folder.done(&format!("repulse s.toml -o {name}-part --until steps=3"));
        // Lines do not matter.
        folder.write("s.toml", &format!("# A remark.\n{text}"));
        folder.done(&format!("repulse s.toml -o {name}-part --until steps=5 --resume"));
        folder.done(&format!("repulse s.toml -o {name}-part --until steps=10 --resume"));
        folder.assert_same_run(&format!("{name}-part"), name);
        let done: f64 = folder.rows(name).iter().map(|row| row["growth"].as_f64().unwrap_or(0.0)).sum();
        assert!(done > 6.0, "{name}: {done}");
    }
}

#[test]
fn targets_out_of_reach_are_said() {
    let folder = Folder::new();
    let grows = "keep.volume = { times = 8, steps = 20 }\nstop.steps = 100\n[[obstacle]]\n\
                 mesh = { shape = \"icosphere\", levels = 2, scale = 1.5 }\nweight = 0.1\n";
    let moves = "keep.area = true\nstop.steps = 100\n[[pin]]\nvertices = [0]\nmove = [0, 0, 3]\n\
                 steps = 20\n[[pin]]\nvertices = [11]\n[[obstacle]]\nweight = 0.1\n\
                 mesh = { shape = \"cuboid\", width = 4, depth = 4, height = 0.2, move = [0, 0, 1.9] }\n";
    for (name, text, words) in [
        ("grows", grows, ["blocked: the volume went from 4.04", "% of the way to 32.3", "leaves more room"]),
        ("moves", moves, ["blocked: 1 moving pin went 2", "% of the way", "weaken obstacles"]),
    ] {
        folder.write("s.toml", &format!("mesh = {{ shape = \"icosphere\", levels = 2 }}\n{text}"));
        folder.warned(&format!("repulse s.toml -o {name} --report {name}.json"), &words);
        let report = folder.json(&format!("{name}.json"));
        let result = &report["result"];
        assert_eq!(
            (&result["stopped_by"], &report["warnings"][0]["kind"]),
            (&"blocked".into(), &"blocked".into())
        );
        let done = result["growth_done"].as_f64().unwrap();
        assert!((0.1..0.9).contains(&done), "{done}");
        assert!(result["steps"].as_u64().unwrap() < 60, "{result}");
        // Resumed, it has nothing to add.
        folder.warned(&format!("repulse s.toml -o {name} --resume"), &words);
        assert_eq!(folder.rows(name).len() as u64, result["steps"].as_u64().unwrap() + 1);
    }
}

#[test]
fn several_meshes_keep_the_data_that_they_have() {
    let folder = Folder::new();
    folder.write(
        "c.obj",
        "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 1 0 0\nv 0 0 1 1 0 0\nvt 0.25 0.5\nf 1/1 3/1 2/1\nf 1/1 2/1 4/1\n\
         f 2/1 3/1 4/1\nf 1/1 4/1 3/1\n",
    );
    folder.write(
        "s.toml",
        "mesh = [{ shape = \"icosphere\", levels = 1, move = [5, 0, 0] }, \"c.obj\"]\nremesh = false\n",
    );
    let outcome = folder.done("repulse s.toml -o run --until steps=1 --frames obj");
    let note = "mesh 1 has no colours (grey there), texture coordinates (0 there), but others have";
    assert!(outcome.stderr.contains(note), "{}", outcome.stderr);
    let last = eikona_mesh::io::read_mesh(folder.0.join("run/frames/000001.obj")).unwrap();
    let red = &last.vertex_scalars.iter().find(|(name, _)| name == "red").unwrap().1;
    assert_eq!((red[0], red[42]), (200.0 / 255.0, 1.0));
    let uvs = last.corner_uvs.unwrap();
    assert_eq!((uvs[0], uvs[3 * 80]), ([0.0, 0.0], [0.25, 0.5]));
}
