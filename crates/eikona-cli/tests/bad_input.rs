//! Input on which the public solvers fail, and usage errors. The command gives the right answer, or
//! the right exit code with a message that names the element and without output files.

mod run;

use run::{Folder, LINE, grid_obj};

fn grid() -> Folder {
    let folder = Folder::new();
    folder.write("grid.obj", &grid_obj());
    folder.write("line.json", LINE);
    folder
}

/// The grid with more vertices and faces at its end; `line.json` still fits.
fn with_mesh(more: &str) -> Folder {
    let folder = grid();
    folder.write("mesh.obj", &(grid_obj() + more));
    folder
}

#[track_caller]
fn assert_line_distance(distance: &[f64]) {
    for (i, d) in distance.iter().enumerate().take(33) {
        let expected = (i / 3) as f64 - 5.0;
        assert!((d - expected).abs() < 1e-6, "vertex {i}: {d}, not {expected}");
    }
}

const SECOND_SQUARE: &str = "v 20 0 0\nv 21 0 0\nv 21 1 0\nv 20 1 0\nf 34 35 36\nf 34 36 37\n";

#[test]
fn a_component_without_a_source_is_nan_with_a_warning() {
    let folder = with_mesh(SECOND_SQUARE);
    for level_sets in ["free", "zero", "per-component"] {
        let outcome =
            folder.done(&format!("sdf mesh.obj --curve line.json -o out.csv --level-sets {level_sets}"));
        let distance = folder.column("out.csv", "distance");
        assert_line_distance(&distance);
        assert!(distance[33..].iter().all(|d| d.is_nan()));
        assert!(outcome.stderr.contains("component 1 (2 faces, the first is face 40)"), "{}", outcome.stderr);
    }
    let strict = folder.run("sdf mesh.obj --curve line.json -o out.csv --strict");
    assert_eq!(strict.code, Some(4));
    assert_eq!(folder.column("out.csv", "distance").len(), 37, "outputs are still written");
    for name in ["out.ply", "out.obj", "out.glb", "out.vtp", "out.off"] {
        folder.done(&format!("sdf mesh.obj --curve line.json -o {name} --render out.png --size 200x150"));
        folder.done(&format!("inspect {name}"));
    }
}

#[test]
fn each_component_with_a_source_has_its_own_zero_level() {
    let folder = with_mesh(SECOND_SQUARE);
    folder.write(
        "two.json",
        &LINE.replace(
            r#"}]}]}"#,
            r#"}]},{"nodes":[{"edge":[33,34],"t":0.5},{"edge":[33,35],"t":0.5},{"edge":[35,36],"t":0.5}]}]}"#,
        ),
    );
    for level_sets in ["free", "per-component", "zero"] {
        folder.done(&format!("sdf mesh.obj --curve two.json -o out.csv --level-sets {level_sets}"));
        let distance = folder.column("out.csv", "distance");
        assert_line_distance(&distance);
        for (v, expected) in [(33, -0.5), (34, 0.5), (35, 0.5), (36, -0.5)] {
            assert!((distance[v] - expected).abs() < 1e-6, "vertex {v}: {}", distance[v]);
        }
    }
}

#[test]
fn a_face_of_zero_area_is_harmless() {
    // Vertex 33 lies on the edge from vertex 0 to vertex 3, and a face of zero area connects the
    // three.
    let folder = with_mesh("v 0.5 0 0\nf 1 4 34\n");
    let outcome = folder.done("sdf mesh.obj --curve line.json -o out.csv");
    let distance = folder.column("out.csv", "distance");
    assert_line_distance(&distance);
    assert!((distance[33] + 4.5).abs() < 1e-3, "{}", distance[33]);
    assert!(outcome.stderr.contains("1 degenerate face (first: face 40)"), "{}", outcome.stderr);
    let dropped = folder.done("sdf mesh.obj --curve line.json -o out.csv --drop-degenerate");
    assert!(dropped.stderr.contains("dropped 1 triangles"), "{}", dropped.stderr);
    assert_eq!(folder.column("out.csv", "distance").len(), 34);
}

#[test]
fn a_face_that_repeats_a_vertex_is_refused_or_dropped() {
    let folder = with_mesh("f 1 4 4\n");
    folder.refused(
        "sdf mesh.obj --curve line.json -o out.csv",
        3,
        &["mesh.obj", "face 40", "vertex 3", "--drop-degenerate"],
    );
    folder.refused("inspect mesh.obj", 3, &["face 40", "vertex 3"]);
    folder.done("sdf mesh.obj --curve line.json -o out.csv --drop-degenerate");
    assert_line_distance(&folder.column("out.csv", "distance"));
}

#[test]
fn a_sliver_is_solved() {
    let folder = with_mesh("v 0.5 -1e-12 0\nf 1 34 4\n");
    folder.done("sdf mesh.obj --curve line.json -o out.csv");
    assert_line_distance(&folder.column("out.csv", "distance"));
}

#[test]
fn unreferenced_vertices_keep_their_number() {
    let folder = with_mesh("v 7 7 7\n");
    let outcome = folder.done("sdf mesh.obj --curve line.json -o out.csv");
    let distance = folder.column("out.csv", "distance");
    assert_line_distance(&distance);
    assert!(distance.len() == 34 && distance[33].is_nan());
    assert!(outcome.stderr.contains("used by no face"), "{}", outcome.stderr);
    // An unreferenced vertex before all others shifts every index by one.
    let moved = |line: &str| {
        let words = line.split(' ').map(|w| w.parse::<u32>().map_or(w.to_string(), |i| (i + 1).to_string()));
        words.collect::<Vec<_>>().join(" ")
    };
    let lines: Vec<String> =
        grid_obj().lines().map(|l| if l.starts_with('f') { moved(l) } else { l.to_string() }).collect();
    folder.write("front.obj", &format!("v 7 7 7\n{}\n", lines.join("\n")));
    folder.write("space.obj", "v 5 0 0\nv 5 2 0\nl 1 2\n");
    folder.done("sdf front.obj --curve space.obj -o out.csv");
    let distance = folder.column("out.csv", "distance");
    assert!(distance.len() == 34 && distance[0].is_nan());
    assert_line_distance(&distance[1..]);
}

#[test]
fn a_vertex_index_out_of_range_is_refused() {
    let folder = with_mesh("f 1 4 99\n");
    folder.refused("sdf mesh.obj --curve line.json -o out.ply --report r.json", 3, &["mesh.obj", "99"]);
    folder.write("mesh.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n");
    folder.refused("sdf mesh.off --points 0 -o out.ply", 3, &["face 0", "vertex 7", "3 vertices"]);
    folder.write("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    folder.refused("sdf nan.obj --points 0 -o out.ply", 3, &["vertex 0"]);
}

#[test]
fn curves_that_do_not_fit_the_mesh_are_refused() {
    let folder = grid();
    folder.write("out_of_range.json", &LINE.replace("17", "99"));
    folder.refused(
        "sdf grid.obj --curve out_of_range.json -o out.ply",
        3,
        &["out_of_range.json", "vertex 99", "33"],
    );
    folder.refused("sdf grid.obj --points 3,99 -o out.ply", 3, &["vertex 99", "0 to 32"]);
    folder.write("one.json", r#"{"eikona":"curves","version":1,"curves":[{"nodes":[{"vertex":15}]}]}"#);
    folder.refused("sdf grid.obj --curve one.json -o out.ply", 3, &["one.json", "curve 0"]);
    folder.write("still.txt", "signed_curve\nv 15\nv 15\n");
    folder.refused("sdf grid.obj --curve still.txt -o out.ply", 3, &["curve 0"]);
    folder.write("wide.json", &LINE.replace(r#"{"vertex":16},"#, ""));
    folder.refused(
        "sdf grid.obj --curve wide.json -o out.ply --no-trace",
        3,
        &["wide.json", "curve 0, node 0", "--trace"],
    );
    folder.write("space.obj", "v 5 0 0\nv 5 2 0\nl 1 2\n");
    folder.refused("sdf grid.obj --curve space.obj -o out.ply --no-trace", 3, &["space.obj", "polyline 0"]);
    folder.write("edge.json", &LINE.replace(r#"{"vertex":16}"#, r#"{"edge":[15,29],"t":0.5}"#));
    folder.refused("sdf grid.obj --curve edge.json -o out.ply", 3, &["15 and 29"]);
    folder.write("bad.json", "{");
    folder.refused("sdf grid.obj --curve bad.json -o out.ply", 3, &["bad.json", "line 1"]);
    folder.write("empty.json", r#"{"eikona":"curves","version":1}"#);
    folder.refused("sdf grid.obj --curve empty.json -o out.ply", 3, &["empty.json", "no curve"]);
    folder.refused("sdf grid.obj -o out.ply", 2, &["--curve", "--points"]);
    // Edge numbers are ambiguous once polygons are triangulated.
    folder.write("quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    folder.write("edges.txt", "signed_curve\ne 0 0.5\ne 2 0.5\n");
    folder.refused("sdf quad.obj --curve edges.txt -o out.ply", 3, &["edges.txt", "line 2", "polygons"]);
}

#[test]
fn a_segment_inside_an_edge_has_the_sign_of_its_own_direction() {
    let folder = grid();
    // Only edge nodes: parts of an edge of the line x = 5, upwards and downwards.
    let up = r#"{"eikona":"curves","version":1,"curves":[{"nodes":[{"edge":[15,16],"t":0.2},{"edge":[15,16],"t":0.8}]}]}"#;
    folder.write("up.json", up);
    folder.write("down.json", &up.replace("0.2", "0.9").replace("0.8", "0.3"));
    for (curve, sign) in [("up.json", 1.0), ("down.json", -1.0)] {
        folder.done(&format!("sdf grid.obj --curve {curve} -o out.csv"));
        let distance = folder.column("out.csv", "distance");
        assert!(
            distance[31] * sign > 3.0 && distance[1] * sign < -3.0,
            "{curve}: {} {}",
            distance[1],
            distance[31]
        );
    }
}

#[test]
fn unsigned_distance_is_nonnegative_up_to_discretisation() {
    let folder = Folder::new();
    folder.done("make grid nx=40 ny=20 width=2 height=1 -o g.ply");
    folder.write("line.obj", "v 0.51 0.3 0\nv 1.33 0.71 0\nl 1 2\n");
    folder.done("sdf g.ply --curve line.obj --unsigned -o out.csv");
    let distance = folder.column("out.csv", "distance");
    // Between nodes of the curve the value may dip below zero by a fraction of the edge length
    // 0.05.
    let lowest = distance.iter().fold(f64::INFINITY, |a, b| a.min(*b));
    assert!(lowest > -0.01, "{lowest}");
}

#[test]
fn distance_to_a_point_in_a_square_is_euclidean() {
    let folder = Folder::new();
    folder.done("make grid nx=40 ny=20 width=2 height=1 -o g.obj");
    let text = folder.read("g.obj");
    let positions: Vec<Vec<f64>> = text
        .lines()
        .filter_map(|l| Some(l.strip_prefix("v ")?.split(' ').map(|x| x.parse().unwrap()).collect()))
        .collect();
    let middle =
        positions.iter().position(|p| (p[0] - 1.0).abs() < 1e-9 && (p[1] - 0.5).abs() < 1e-9).unwrap();
    folder.done(&format!("sdf g.obj --points {middle} -o out.csv"));
    for (p, d) in positions.iter().zip(folder.column("out.csv", "distance")) {
        let expected = (p[0] - 1.0).hypot(p[1] - 0.5);
        assert!((d - expected).abs() < 0.05, "at {p:?}: {d}, not {expected}");
    }
}

#[test]
fn usage_errors_exit_with_code_2() {
    let folder = grid();
    folder.refused("sfd grid.obj", 2, &["sfd", "sdf"]);
    folder.refused("sdf grid.obj --curv line.json -o out.ply", 2, &["--curve"]);
    folder.refused("sdf grid.obj --curve line.json -o out.xyz", 2, &["out.xyz", ".ply"]);
    folder.refused("sdf grid.obj --curve line.json -o out.stl", 2, &["STL", ".ply"]);
    folder.refused("sdf grid.obj --curve line.json", 2, &["-o OUT.ply"]);
    folder.refused(
        "sdf grid.obj --curve line.json -o out.ply --time 0",
        2,
        &["auto, smooth or a number from 1e-9"],
    );
    folder.refused("sdf grid.obj --curve line.json -o out.ply --level-sets hard", 2, &["per-component"]);
    folder.refused("sdf grid.obj --curve line.json -o out.ply --isolines out.txt", 2, &[".svg", ".json"]);
    folder.refused("sdf grid.obj --curve line.json -o out.ply --isolines i.obj --spacing -1", 2, &[]);
    folder.refused(
        "sdf grid.obj --curve line.json -o out.ply --isolines i.obj --spacing 1e-9",
        2,
        &["spacing", "10,000"],
    );
    folder.refused("sdf grid.obj --curve line.json -o x.csv --report x.csv", 2, &["x.csv", "two outputs"]);
    folder.refused("sdf grid.obj --curve line.json -o out.ply --render o.png --size 0x0", 2, &["0 x 0"]);
    folder.refused("sdf grid.obj --curve line.json -o out.ply --render o.png --map jet", 2, &["viridis"]);
    folder.refused("sdf grid.obj --curve line.json -o no/such/folder/out.ply", 2, &["no/such/folder"]);
    folder.refused("sdf grid.obj --curve line.json -o .", 2, &["folder"]);
    folder.refused("make tours -o t.ply", 2, &["tours", "torus"]);
    folder.refused("make torus nw=3 -o t.ply", 2, &["nw", "nu"]);
    folder.refused("make torus", 2, &["-o torus.ply"]);
    folder.refused("make torus -o t.ply --cut axis=z,at=9 --curve-out c.json", 2, &["does not meet"]);
    folder.refused("render grid.obj -o out.jpg", 2, &["png"]);
    folder.refused("completions tcsh", 2, &["bash"]);
    folder.refused("", 2, &["Usage"]);
}

#[test]
fn numbers_out_of_range_are_refused_before_any_work() {
    let folder = grid();
    // The mesh does not exist, so it is never read.
    for (flags, words) in [
        ("--size 0x0", ["--size", "0 x 0"]),
        ("--size 9", ["--size", "1200x900"]),
        ("--size 16000x16000", ["--size", "smaller"]),
        ("--zoom 0", ["--zoom", "1e-6 to 1e6"]),
        ("--zoom -2", ["--zoom", "1e-6 to 1e6"]),
        ("--azimuth nan", ["--azimuth", "finite"]),
        ("--elevation inf", ["--elevation", "finite"]),
        ("--range 1,0", ["--range", "-1,1"]),
        ("--spacing 0", ["--spacing", "above 0"]),
        ("--spacing -1", ["--spacing", "above 0"]),
        ("--spacing nan", ["--spacing", "above 0"]),
    ] {
        folder.refused(&format!("sdf none.obj --points 0 --render o.png {flags}"), 2, &words);
        folder.refused(&format!("render none.obj -o o.png {flags}"), 2, &words);
    }
    for (flags, words) in [
        ("--time -1", ["--time", "from 1e-9"]),
        ("--time nan", ["--time", "from 1e-9"]),
        ("--time 1e-300", ["--time", "from 1e-9 to 1e9"]),
        ("--levels 0,,1", ["--levels", "finite"]),
        ("--levels 0,nan", ["--levels", "finite"]),
        ("--memory-limit -1", ["--memory-limit", "2GiB"]),
        ("--weld=-1", ["--weld", "0 or more"]),
        ("--render o.jpg", ["o.jpg", "name it o.png"]),
        ("--render o", ["PNG", "name it o.png"]),
        ("--isolines o.txt", ["o.txt", ".svg"]),
        ("--out-format csv", ["out.ply", "standard output"]),
        ("--points 1,,2", ["missing", "12,40"]),
        ("--points 1,", ["missing", "12,40"]),
        ("--points 1.5", ["1.5 is not a vertex number", "12,40"]),
        ("--points -1", ["-1 is not a vertex number", "12,40"]),
    ] {
        folder.refused(&format!("sdf none.obj -o out.ply --points 0 {flags}"), 2, &words);
    }
    folder.refused(
        "sdf grid.obj --points nothing.json -o out.ply",
        3,
        &["nothing.json", "no such file", "12,40"],
    );
    folder.refused("render none.obj -o o.png --report o.png", 2, &["two outputs"]);
    folder.refused("render none.obj -o o.jpeg", 2, &["o.png"]);
    for (flags, words) in [
        ("--jitter -1", ["--jitter", "0 or more"]),
        ("--remove-faces 2", ["--remove-faces", "from 0 to 1"]),
        ("--flip-faces nan", ["--flip-faces", "from 0 to 1"]),
        ("--holes -1", ["--holes", "-1"]),
        ("--broken-curve c.json --cut axis=z --keep 0", ["--keep", "above 0"]),
        ("--broken-curve c.json --cut axis=z --drop -0.1", ["--drop", "from 0 to 1"]),
        ("--curve-out c.json --cut axis=z --drop 0.1", ["--drop", "--broken-curve"]),
        ("--curve-out c.xyz --cut axis=z", ["c.xyz", ".json"]),
        ("--curve-out c.json", ["--cut", "--curve circle"]),
        ("--cut axis=z", ["--curve-out", "--broken-curve"]),
        ("--curve-out c.json --cut axis=q", ["axis=q", "x, y, z"]),
        ("--curve-out c.json --cut axis=z,at=nan%", ["at=nan%", "30%"]),
        ("--curve-out c.json --cut z=1", ["\"z\"", "axis"]),
        ("--curve-out c.json --cut about=1:2", ["about=1:2", "0:0.5:1"]),
        ("--out-format ply", ["t.ply", "standard output"]),
    ] {
        let command = format!("make torus -o t.ply {flags}");
        folder.refused(&command, 2, &words);
        assert!(!folder.run(&command).stderr.contains("vertices"), "{command} made the mesh first");
    }
}

#[test]
fn misplaced_files_and_unknown_flags_get_a_hint() {
    let folder = grid();
    folder.refused("sdf grid.obj line.json -o out.ply", 2, &["line.json", "--curve"]);
    folder.refused("sdf line.json --points 0 -o out.ply", 3, &["line.json", "pass it with --curve"]);
    folder.refused("bench sdf --faces -1", 2, &["1 to 100000000"]);
    folder.refused("bench sdf --faces 0", 2, &["1 to 100000000"]);
    let outcome = folder.run("sdf grid.obj -p 0 -o out.ply");
    assert!(outcome.code == Some(2) && !outcome.stderr.contains("-- -p"), "{}", outcome.stderr);
    folder.write("points.obj", "v 0 0 0\nv 1 0 0\n");
    assert!(folder.done("points.obj").text().contains("no faces"));
    folder.refused("render points.obj -o out.png", 3, &["points.obj", "no faces"]);
    folder.refused("line.json", 3, &["line.json", "pass it with --curve"]);
}

#[cfg(unix)]
#[test]
fn a_closed_stderr_pipe_is_harmless() {
    use std::process::{Command, Stdio};
    let folder = grid();
    let mut child = Command::new(env!("CARGO_BIN_EXE_eikona"))
        .args(["sdf", "grid.obj", "--curve", "line.json", "-o", "out.csv", "--timings"])
        .current_dir(&folder.0)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stderr.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert_eq!(folder.column("out.csv", "distance").len(), 33);
}

#[test]
fn svg_is_refused_as_soon_as_the_mesh_is_not_flat() {
    let folder = grid();
    folder.done("make torus nu=12 nv=8 -o t.obj");
    // The curve, which would be read next, does not exist.
    folder.refused("sdf t.obj --curve none.json --isolines i.svg", 2, &["i.svg", "z of the mesh", ".obj"]);
    folder.done("sdf grid.obj --curve line.json --isolines i.svg");
    assert!(folder.read("i.svg").starts_with("<svg"));
}

#[test]
fn curve_names_and_curve_files_are_distinguished() {
    let folder = grid();
    let remedy = "eikona sdf MESH --curve line.json";
    folder.refused("make torus -o t.ply --curve line.json --curve-out c.json", 2, &["torus-knot", remedy]);
    folder.refused("make torus -o t.ply --curve none.obj --curve-out c.json", 2, &["eikona sdf MESH"]);
    folder.refused("make torus -o t.ply --curve circl --curve-out c.json", 2, &["circl", "circle, latitude"]);
    folder.refused(
        "sdf grid.obj --curve circle -o out.ply",
        3,
        &["no such file", "eikona make", "--curve circle"],
    );
}

#[test]
fn zero_damage_changes_nothing() {
    let folder = Folder::new();
    folder.done("make torus nu=12 nv=8 -o a.ply --curve-out whole.json --cut axis=x,at=0.1");
    folder.done("make torus nu=12 nv=8 -o b.ply --jitter 0 --holes 0 --remove-faces 0 --flip-faces 0");
    assert_eq!(folder.bytes("a.ply"), folder.bytes("b.ply"));
    for seed in ["", "--seed 4"] {
        let cut = "--broken-curve c.json --cut axis=x,at=0.1";
        folder.done(&format!("make torus nu=12 nv=8 -o a.ply {cut} --drop 0 {seed}"));
        let facts = folder.done("inspect a.ply --curve c.json --json").text();
        let facts: serde_json::Value = serde_json::from_str(&facts).unwrap();
        let whole = folder.done("inspect a.ply --curve whole.json --json").text();
        let whole: serde_json::Value = serde_json::from_str(&whole).unwrap();
        let length = |facts: &serde_json::Value| facts["curves"]["length"].as_f64().unwrap();
        assert!((length(&facts) - length(&whole)).abs() < 1e-9 * length(&whole));
        assert!(facts["curves"]["curves"].as_array().unwrap().iter().all(|c| c["closed"] == true));
    }
}

#[test]
fn a_short_diffusion_time_gives_a_warning() {
    let folder = grid();
    for (time, warned) in [("1e-9", true), ("0.009", true), ("0.01", false), ("1", false), ("auto", false)] {
        let outcome = folder.done(&format!("sdf grid.obj --curve line.json -o out.csv --time {time}"));
        assert_eq!(outcome.stderr.contains("is below 0.01"), warned, "{time}: {}", outcome.stderr);
    }
}

#[test]
fn many_warnings_of_a_kind_are_counted_and_all_reported() {
    let folder = Folder::new();
    folder.done("make torus nu=12 nv=8 -o u.ply --unweld"); // 192 separate triangles
    let outcome = folder.done("sdf u.ply --points 0 -o out.csv --report r.json");
    let lines: Vec<&str> = outcome.stderr.lines().filter(|l| l.contains("reached by no curve")).collect();
    assert_eq!(lines.len(), 5, "{}", outcome.stderr);
    let rest = "and 186 more of kind unreached_component (the report lists all)";
    assert!(outcome.stderr.contains(rest), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("add --weld"), "other kinds are still printed");
    let warnings = folder.json("r.json")["warnings"].as_array().unwrap().clone();
    let of_components = warnings.iter().filter(|w| w["kind"] == "unreached_component");
    assert_eq!(of_components.count(), 191);
    let outcome = folder.done("sdf u.ply --points 0 -o out.csv");
    assert!(outcome.stderr.contains("--report R.json"), "{}", outcome.stderr);
    assert!(folder.done("sdf u.ply --points 0 -o out.csv -qq").stderr.is_empty());
}

#[test]
fn missing_and_invalid_files_exit_with_code_3() {
    let folder = grid();
    folder.refused("sdf nothing.obj --curve line.json -o out.ply", 3, &["nothing.obj", "no such file"]);
    folder.refused("nothing.obj", 3, &["nothing.obj", "no such file"]);
    folder.refused("sdf grid.obj --curve nothing.json -o out.ply", 3, &["nothing.json", "no such file"]);
    folder.refused("inspect .", 3, &["folder"]);
    folder.write("text.ply", "hello");
    folder.refused("inspect text.ply", 3, &["text.ply"]);
    folder.write("empty.obj", "");
    folder.refused("inspect empty.obj", 3, &["empty.obj"]);
    folder.write("points.obj", "v 0 0 0\nv 1 0 0\n");
    folder.refused("sdf points.obj --points 0 -o out.ply", 3, &["no faces"]);
    folder.refused("render grid.obj -o out.png --field heat", 3, &["heat"]);
}

#[test]
fn other_failures_exit_with_code_1() {
    let folder = grid();
    folder.refused("sdf grid.obj --curve line.json -o out.ply --memory-limit 1kB", 1, &["limit"]);
    folder.refused(
        "bench sdf --faces 100 --peer potpourri3d --python no-such-python",
        1,
        &["pip install potpourri3d"],
    );
    // An output that cannot be written prevents the others too: a file cannot contain a file.
    folder.write("file", "");
    folder.refused("sdf grid.obj --curve line.json -o out.ply --render file/out.png", 2, &["file"]);
}

#[cfg(unix)]
#[test]
fn an_unwritable_folder_leaves_no_output() {
    use std::os::unix::fs::PermissionsExt;
    let folder = grid();
    let locked = folder.0.join("locked");
    std::fs::create_dir(&locked).unwrap();
    std::fs::set_permissions(&locked, std::fs::Permissions::from_mode(0o555)).unwrap();
    // The superuser can write to any folder but /proc.
    let target =
        if std::fs::write(locked.join("probe"), "").is_ok() { "/proc/out.png" } else { "locked/out.png" };
    let _ = std::fs::remove_file(locked.join("probe"));
    folder.refused(
        &format!("sdf grid.obj --curve line.json -o out.ply --render {target}"),
        1,
        &["out.png", "no output"],
    );
    std::fs::set_permissions(&locked, std::fs::Permissions::from_mode(0o755)).unwrap();
}

#[cfg(unix)]
#[test]
fn an_interruption_exits_with_130_and_leaves_no_output() {
    use std::process::{Command, Stdio};
    let folder = Folder::new();
    let mut child = Command::new(env!("CARGO_BIN_EXE_eikona"))
        .args([
            "make",
            "geodesic_sphere",
            "frequency=350",
            "-o",
            "big.ply",
            "--curve-out",
            "c.json",
            "--cut",
            "axis=z",
        ])
        .current_dir(&folder.0)
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(250));
    let running = child.try_wait().unwrap().is_none();
    assert!(
        Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success() || !running
    );
    let status = child.wait().unwrap();
    if running && status.code() != Some(0) {
        assert_eq!(status.code(), Some(130));
        assert!(folder.files().is_empty(), "{:?}", folder.files());
    } else {
        println!("the command was done before it could be interrupted");
    }
}
