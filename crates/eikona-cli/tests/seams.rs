//! Boundaries that touch without sharing vertices: T-junctions, cracks and seams are reported, give
//! warnings, and can be stitched.

mod run;

use run::{Folder, data, grid_obj};
use std::fmt::Write as _;

/// reports.md F6: a square next to two rectangles of half its height.
const T_JUNCTION: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 .5 0\nv 2 0 0\nv 2 .5 0\nv 2 1 0
f 1 2 3\nf 1 3 4\nf 2 6 7\nf 2 7 5\nf 5 7 8\nf 5 8 3\n";
const UPWARD: &str = "v 0 0 0\nv 0 1 0\nl 1 2\n";

/// Strips of unit height from x = 0 to 1 and from 1 + gap to 2, with 10 columns and the given
/// numbers of rows; and the positions of their vertices.
fn strips(rows: [usize; 2], gap: f64) -> (String, Vec<[f64; 2]>) {
    const COLUMNS: usize = 10;
    let mut places: Vec<[f64; 2]> = Vec::new();
    let mut faces = String::new();
    for (n, [from, to]) in rows.into_iter().zip([[0.0, 1.0], [1.0 + gap, 2.0]]) {
        let first = places.len() + 1;
        for j in 0..=n {
            let x = |i: usize| from + (to - from) * i as f64 / COLUMNS as f64;
            places.extend((0..=COLUMNS).map(|i| [x(i), j as f64 / n as f64]));
        }
        for (i, j) in (0..COLUMNS).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let a = first + j * (COLUMNS + 1) + i;
            let (b, c, d) = (a + 1, a + COLUMNS + 2, a + COLUMNS + 1);
            let _ = writeln!(faces, "f {a} {b} {c}\nf {a} {c} {d}");
        }
    }
    let vertices: String = places.iter().map(|[x, y]| format!("v {x:?} {y:?} 0\n")).collect();
    (vertices + &faces, places)
}

#[test]
fn a_t_junction_is_reported_and_stitched() {
    let folder = Folder::new();
    folder.write("t.obj", T_JUNCTION);
    folder.write("c.obj", UPWARD);
    let text = folder.done("inspect t.obj").text();
    let line = "1 vertices inside edges of other faces (T-junctions): the surface is disconnected there; \
     add --stitch";
    assert!(text.contains(line), "{text}");
    assert!(text.contains("vertex 4 lies inside edge 1 (vertex 1 to vertex 2)"), "{text}");
    folder.done("inspect t.obj --json --report r.json");
    let faults = &folder.json("r.json")["result"]["faults"]["hanging_vertices"];
    assert_eq!((faults["count"].as_u64(), faults["largest_gap"].as_f64()), (Some(1), Some(0.0)));
    folder.warned(
        "sdf t.obj --curve c.obj -o d.csv",
        &["1 boundary vertex lies inside an edge", "vertex 4 between vertex 1 and vertex 2", "--stitch"],
    );
    let stitched = folder.done("sdf t.obj --curve c.obj -o d.csv --stitch --strict --report r.json");
    assert!(stitched.stderr.contains("1 inserted into edges, 1 face split"), "{}", stitched.stderr);
    let right = [0.0, 1.0, 1.0, 0.0, 1.0, 2.0, 2.0, 2.0];
    for (v, (d, right)) in folder.column("d.csv", "distance").iter().zip(right).enumerate() {
        assert!((d - right).abs() < 1e-12, "vertex {v}: {d}, not {right}");
    }
    let repair = &folder.json("r.json")["input"]["repairs"][0];
    assert_eq!((repair["repair"].as_str(), repair["inserted_vertices"].as_u64()), (Some("stitch"), Some(1)));
}

#[test]
fn stitching_a_seam_of_different_resolutions_gives_the_distance_of_the_whole() {
    // reports.md F6: 20 against 21 was off by 0.53, 10 against 11 by 0.36, 1 against 20 by 0.46.
    let folder = Folder::new();
    for (rows, gap) in [[20, 21], [10, 11], [1, 20], [20, 1]].into_iter().flat_map(|r| [(r, 0.0), (r, 1e-7)])
    {
        let (obj, places) = strips(rows, gap);
        folder.write("s.obj", &obj);
        folder.write("c.obj", "v .5 0 0\nv .5 1 0\nl 1 2\n");
        folder.warned("sdf s.obj --curve c.obj -o d.csv", &["touch", "--stitch"]);
        folder.done("sdf s.obj --curve c.obj -o d.csv --stitch --report r.json");
        let map = folder.json("r.json")["input"]["repairs"][0]["vertex_map"].clone();
        let distance = folder.column("d.csv", "distance");
        assert_eq!(distance.len() + 2, places.len(), "the ends of the seam are merged");
        for (v, [x, _]) in places.iter().enumerate() {
            let d = distance[map[v].as_u64().unwrap() as usize];
            assert!((d - (x - 0.5)).abs() < 1e-6 * gap.signum() + 1e-11, "{rows:?} {gap} vertex {v}: {d}");
        }
    }
}

#[test]
fn a_crack_is_reported_as_a_fault() {
    // reports.md C: "faults none" on a crack of 1e-7.
    let folder = Folder::new();
    let (obj, _) = strips([6, 6], 1e-7);
    folder.write("s.obj", &obj);
    let text = folder.done("inspect s.obj").text();
    assert!(
        text.contains("7 boundary vertices at a small gap from another one (cracks), widest gap 1.0e-7"),
        "{text}"
    );
    let mended = folder.done("inspect s.obj --stitch").text();
    assert!(mended.contains("faults       none") && mended.contains("1 boundary loop"), "{mended}");
    folder.warned(
        "sdf s.obj --points 0 -o d.csv",
        &["7 boundary vertices touch another one", "1.0e-7", "--stitch"],
    );
}

#[test]
fn a_seam_of_equal_vertices_names_weld() {
    let folder = Folder::new();
    let (obj, _) = strips([6, 6], 0.0);
    folder.write("s.obj", &obj);
    folder.warned("sdf s.obj --points 0 -o d.csv", &["7 boundary vertices touch another one", "add --weld"]);
    // For a curve from one part to the other, the error also names the repairs.
    folder.write("c.obj", "v .2 .5 0\nv 1.8 .5 0\nl 1 2\n");
    folder.refused("sdf s.obj --curve c.obj -o d.csv", 3, &["no path on the surface", "--weld", "--stitch"]);
    for repair in ["--weld", "--stitch"] {
        folder.done(&format!("sdf s.obj --curve c.obj -o d.csv --strict {repair}"));
    }
}

#[test]
fn winding_warns_of_a_t_junction_and_is_right_after_stitching() {
    let folder = Folder::new();
    let (obj, places) = strips([10, 11], 0.0);
    folder.write("s.obj", &obj);
    // A square around the middle of the seam, counter-clockwise.
    folder.write("c.obj", "v .5 .25 0\nv 1.5 .25 0\nv 1.5 .75 0\nv .5 .75 0\nl 1 2 3 4 1\n");
    folder.refused("winding s.obj --curve c.obj -o w.ply", 3, &["--stitch"]);
    folder.write("open.obj", "v .5 .25 0\nv .5 .75 0\nl 1 2\n");
    folder.warned("winding s.obj --curve open.obj -o w.ply", &["inside edges of other faces", "--stitch"]);
    folder.done("winding s.obj --curve c.obj --input-labels in.npy --stitch");
    let labels = folder.npy("in.npy");
    let faces: Vec<Vec<usize>> = obj
        .lines()
        .filter_map(|l| l.strip_prefix("f "))
        .map(|l| l.split(' ').map(|w| w.parse::<usize>().unwrap() - 1).collect())
        .collect();
    assert_eq!(labels.len(), faces.len(), "one label per face of the file");
    for (label, corners) in labels.iter().zip(&faces) {
        let all =
            |inside: &dyn Fn(f64, f64) -> bool| corners.iter().all(|&v| inside(places[v][0], places[v][1]));
        if all(&|x, y| (0.5..=1.5).contains(&x) && (0.25..=0.75).contains(&y)) {
            assert_eq!(*label, 1, "{corners:?}");
        }
        if all(&|x, _| x <= 0.5) || all(&|x, _| x >= 1.5) || all(&|_, y| y <= 0.25) || all(&|_, y| y >= 0.75)
        {
            assert_eq!(*label, 0, "{corners:?}");
        }
    }
}

#[test]
fn curve_files_keep_the_numbers_of_the_file_after_stitching() {
    let folder = Folder::new();
    folder.write("t.obj", T_JUNCTION);
    // x = 1 along the split edge, and x = 0.5 across two split faces with edge and face nodes.
    let node = |text: &str| format!("{{\"nodes\":[{text}]}}");
    let file = |curve: &str| format!("{{\"eikona\":\"curves\",\"version\":1,\"curves\":[{curve}]}}");
    folder.write(
        "x1.json",
        &file(&node(r#"{"edge":[1,2],"t":0},{"edge":[2,1],"t":0.75},{"edge":[1,2],"t":1}"#)),
    );
    let inner = r#"{"edge":[0,1],"t":0.5},{"face":[0,1,2],"bary":[0.5,0.2,0.3]},{"edge":[0,2],"t":0.5},{"edge":[2,3],"t":0.5}"#;
    folder.write("x05.json", &file(&node(inner)));
    for (curve, shift) in [("x1.json", 1.0), ("x05.json", 0.5)] {
        folder.done(&format!("sdf t.obj --stitch --curve {curve} -o d.csv"));
        let x = [0.0, 1.0, 1.0, 0.0, 1.0, 2.0, 2.0, 2.0];
        for (v, (d, x)) in folder.column("d.csv", "distance").iter().zip(x).enumerate() {
            assert!((d - (x - shift)).abs() < 1e-9, "{curve} vertex {v}: {d}, not {}", x - shift);
        }
    }
    // Edges 5 and 7 of the file connect vertex 1 to 5 and to 6; the split face precedes them.
    folder.write("n.txt", "signed_curve\ne 5 0.5\ne 7 0.5\n");
    let by_file = folder.done("inspect t.obj --stitch --curve n.txt").text();
    assert!(by_file.contains("1 segment, length 0.250000;"), "{by_file}");
    folder.done("winding t.obj --stitch --curve x1.json --reference 5 --keep-short -o w.csv");
    let parents = folder.column("w.csv", "parent");
    // The node at (1, 0.25) splits the lower part of face 0 again, and face 3 next to it.
    assert_eq!(parents, [0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 3.0, 4.0, 5.0]);
}

#[test]
fn lines_of_the_mesh_survive_stitching() {
    let folder = Folder::new();
    let (mut obj, places) = strips([6, 6], 0.0);
    // The line x = 1 on the second part, whose vertices are merged into those of the first.
    let second = places.len() / 2;
    let nodes: Vec<String> = (0..=6).map(|j| (second + 11 * j + 1).to_string()).collect();
    let _ = writeln!(obj, "l {}", nodes.join(" "));
    folder.write("s.obj", &obj);
    folder.done("sdf s.obj --stitch -o d.csv --report r.json");
    let map = folder.json("r.json")["input"]["repairs"][0]["vertex_map"].clone();
    let distance = folder.column("d.csv", "distance");
    for (v, [x, _]) in places.iter().enumerate() {
        let d = distance[map[v].as_u64().unwrap() as usize];
        assert!((d - (x - 1.0)).abs() < 1e-9, "vertex {v}: {d}");
    }
}

#[test]
fn a_mesh_without_seams_is_unchanged_and_gives_no_warning() {
    let folder = Folder::new();
    folder.write("g.obj", &grid_obj());
    let said = folder.done("sdf g.obj --points 0 --stitch --strict -o a.csv").stderr;
    assert!(said.contains("--stitch found no boundaries to join"), "{said}");
    folder.done("sdf g.obj --points 0 --strict -o b.csv");
    assert_eq!(folder.read("a.csv"), folder.read("b.csv"));
    // A gap of 3e-5 of the size counts as intended.
    let (obj, _) = strips([6, 7], 1e-4);
    folder.write("s.obj", &obj);
    let said = folder.done("sdf s.obj --points 0 -o a.csv").stderr;
    assert!(!said.contains("touch"), "{said}");
    for (wrong, words) in [("--stitch=-1", "0 or more"), ("--stitch=x", "0 or more")] {
        folder.refused(&format!("sdf g.obj --points 0 -o c.csv {wrong}"), 2, &[words]);
    }
}

#[test]
fn a_seam_on_a_component_without_source_gives_no_warning() {
    // The source is on a third, distant component; the seam is on others, which have no distance
    // anyway.
    let folder = Folder::new();
    let (obj, places) = strips([3, 4], 0.0);
    let n = places.len();
    let away = format!("{obj}v 5 0 0\nv 6 0 0\nv 5 1 0\nf {} {} {}\n", n + 1, n + 2, n + 3);
    folder.write("s.obj", &away);
    let said = folder.done(&format!("sdf s.obj --points {n} -o d.csv")).stderr;
    assert!(!said.contains("touch"), "{said}");
    folder.warned("sdf s.obj --points 0 -o d.csv", &["touch"]);
}

#[test]
fn slivers_are_listed_with_their_height() {
    // reports.md F26.
    let folder = Folder::new();
    folder.write("n.obj", "v 0 0 0\nv 5e-8 0 0\nv 5e-8 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
    let text = folder.done("inspect n.obj").text();
    assert!(text.contains("2 faces of almost zero height (slivers)"), "{text}");
    assert!(text.contains("face 0 has a height of 5.0e-8 times its longest edge"), "{text}");
}

#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn only_data_files_with_seams_give_a_warning() {
    let data = data();
    let folder = Folder::new();
    let mut run = 0;
    let touching =
        [("badquality/capsule.obj", 0), ("nonmanifold/screwdriver.obj", 0), ("nonmanifold/truck.obj", 385)];
    let clean = [
        // overlaps itself: vertices lie on edges of the other sheet, which the boundary crosses
        "curves/swn/annulus.obj",
        "nonmanifold/chair_model.obj",
        "synthetic/projective-plane-roman.obj",
        "synthetic/annulus-2twists.obj",
        "closed/fandisk.obj",
    ];
    let files = touching.into_iter().map(|t| (t, true)).chain(clean.map(|name| ((name, 0), false)));
    for ((name, point), touch) in files {
        run += 1;
        let said =
            folder.done(&format!("sdf {} --points {point} -o d.csv", data.join(name).display())).stderr;
        assert_eq!(said.contains("boundaries touch"), touch, "{name}: {said}");
    }
    println!("{run} files ran");
    assert_eq!(run, touching.len() + clean.len());
}
