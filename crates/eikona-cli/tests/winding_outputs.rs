//! Reads back every output of `eikona winding`.

mod run;

use eikona_mesh::io::{MeshFile, read_mesh};
use eikona_mesh::{Topology, TriangleMesh};
use eikona_render::label_color;
use run::{Folder, LINE, data, grid_obj, png_size};

/// The grid of 10 x 2 squares, and the line x = 4.5 from boundary to boundary across faces. The
/// label is 1 on its left, where x is smaller, and 0 on the larger right side.
fn across() -> Folder {
    let folder = Folder::new();
    folder.write("grid.obj", &grid_obj());
    folder.write("line.json", LINE);
    folder.write("across.obj", "v 4.5 0 0\nv 4.5 2 0\nl 1 2\n");
    folder
}

const SOLVE: &str = "winding grid.obj --curve across.obj -q";

fn read(folder: &Folder, name: &str) -> (MeshFile, TriangleMesh) {
    let file = read_mesh(folder.0.join(name)).unwrap();
    let mesh = file.mesh.triangulate().unwrap().0;
    (file, mesh)
}

#[track_caller]
fn scalar<'a>(scalars: &'a [(String, Vec<f64>)], name: &str) -> &'a [f64] {
    let found = scalars.iter().find(|s| s.0 == name);
    &found.unwrap_or_else(|| panic!("no {name} in {:?}", scalars.iter().map(|s| &s.0).collect::<Vec<_>>())).1
}

/// The expected label of each face.
fn expected(mesh: &TriangleMesh) -> Vec<f64> {
    let middle = |f| mesh.face_positions(f).iter().map(|p| p[0]).sum::<f64>() / 3.0;
    mesh.faces().map(|f| if middle(f) < 4.5 { 1.0 } else { 0.0 }).collect()
}

/// Checks that the mesh has two disks, which share no vertex, with one label each.
fn assert_split(mesh: &TriangleMesh) {
    let labels = expected(mesh);
    for v in mesh.vertices() {
        let corners = mesh.vertex_corners(v);
        assert!(corners.iter().all(|c| labels[c.face().index()] == labels[corners[0].face().index()]));
    }
    let topology = Topology::of(mesh);
    let characteristics: Vec<i64> = topology.components.iter().map(|c| c.euler_characteristic).collect();
    assert_eq!(characteristics, [1, 1]);
}

#[test]
fn the_mesh_has_labels_margins_and_parents_per_face() {
    let folder = across();
    for name in ["out.ply", "out.vtp"] {
        folder.done(&format!("{SOLVE} -o {name}"));
        let (file, mesh) = read(&folder, name);
        assert!(mesh.face_count() > 40);
        assert_eq!(Topology::of(&mesh).components.len(), 1);
        assert_eq!(scalar(&file.face_scalars, "label"), expected(&mesh), "{name}");
        assert!(scalar(&file.face_scalars, "margin").iter().all(|m| (m - 0.5).abs() < 1e-6));
        let (_, grid) = read(&folder, "grid.obj");
        for (f, parent) in mesh.faces().zip(scalar(&file.face_scalars, "parent")) {
            let parent = grid.face_positions(eikona_mesh::Face(*parent as u32));
            for axis in 0..2 {
                let middle = mesh.face_positions(f).iter().map(|p| p[axis]).sum::<f64>() / 3.0;
                let low = parent.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
                assert!((low..=low + 1.0).contains(&middle));
            }
        }
    }
}

#[test]
fn gaps_are_closed_straight_or_along_edges() {
    let folder = across();
    // The line with a gap from y = 0.7 to 1.3.
    folder.write("gap.obj", "v 4.5 0 0\nv 4.5 0.7 0\nv 4.5 1.3 0\nv 4.5 2 0\nl 1 2\nl 3 4\n");
    let solve = "winding grid.obj --curve gap.obj -q -o out.ply --bounding loops.obj --report r.json";
    let longest = |folder: &Folder| {
        let text = std::fs::read_to_string(folder.0.join("loops.obj")).unwrap();
        let x = text.lines().filter_map(|l| l.strip_prefix("v ")).map(|l| {
            let x: f64 = l.split(' ').next().unwrap().parse().unwrap();
            (x - 4.5).abs()
        });
        x.fold(0.0, f64::max)
    };
    folder.done(solve);
    let (file, mesh) = read(&folder, "out.ply");
    assert_eq!(scalar(&file.face_scalars, "label"), expected(&mesh));
    assert!(longest(&folder) < 1e-9, "the completion runs straight on");
    let report = std::fs::read_to_string(folder.0.join("r.json")).unwrap();
    let report: serde_json::Value = serde_json::from_str(&report).unwrap();
    let completion = &report["result"]["completion"];
    assert!(completion["straightened"] == 1 && completion["on_edges"] == 0, "{completion}");
    assert!((completion["length_after"].as_f64().unwrap() - 0.6).abs() < 1e-9, "{completion}");
    folder.done(&format!("{solve} --completion-shape edges"));
    assert!(longest(&folder) > 0.1, "a path along edges deviates");
}

#[test]
fn tables_have_the_same_labels() {
    let folder = across();
    folder.done(&format!("{SOLVE} -o out.ply"));
    folder.done(&format!("{SOLVE} -o out.csv"));
    folder.done(&format!("{SOLVE} -o out.npy"));
    let (file, _) = read(&folder, "out.ply");
    for column in ["label", "parent"] {
        assert_eq!(folder.column("out.csv", column), scalar(&file.face_scalars, column));
    }
    assert_eq!(folder.column("out.csv", "margin").len(), file.mesh.face_count());
    let labels: Vec<f64> = folder.npy("out.npy").into_iter().map(f64::from).collect();
    assert_eq!(labels, scalar(&file.face_scalars, "label"));
}

#[test]
fn texture_coordinates_are_homogeneous_winding_numbers() {
    let folder = across();
    folder.done(&format!("{SOLVE} -o out.obj"));
    let (file, mesh) = read(&folder, "out.obj");
    let uvs = file.corner_uvs.unwrap();
    assert_eq!(uvs.len(), 3 * mesh.face_count());
    for (f, label) in expected(&mesh).into_iter().enumerate() {
        for uv in &uvs[3 * f..3 * f + 3] {
            // The curve has no endpoint inside, so every corner has a value, and each is an
            // integer.
            assert!((uv[0] - label).abs() < 1e-6 && uv[1] == 1.0, "face {f}: {uv:?}, not {label}");
        }
    }
}

#[test]
fn texture_coordinates_are_zero_at_endpoints() {
    let folder = across();
    // A curve that ends inside, at vertex 16 at (5, 1).
    folder.write("half.json", &LINE.replace(r#",{"vertex":17}"#, ""));
    folder.done("winding grid.obj --curve half.json -o out.obj -q");
    let (file, mesh) = read(&folder, "out.obj");
    let uvs = file.corner_uvs.unwrap();
    for f in mesh.faces() {
        for (k, p) in mesh.face_positions(f).into_iter().enumerate() {
            let [u, v] = uvs[3 * f.index() + k];
            let at_end = p == [5.0, 1.0, 0.0];
            assert!(v == if at_end { 0.0 } else { 1.0 } && (u == 0.0 || !at_end), "{u} {v} at {p:?}");
        }
    }
}

#[test]
fn render_divides_texture_coordinates() {
    let folder = across();
    folder.done(&format!("{SOLVE} -o out.obj --render-values v.png --size 160x120 --no-bar"));
    folder.done("render out.obj --field uv-quotient -o uv.png --size 160x120 --no-bar --curve across.obj -q");
    assert_eq!(folder.bytes("uv.png"), folder.bytes("v.png"));
    folder.refused("render grid.obj --field uv-quotient -o no.png", 3, &["no field", "uv-quotient"]);
    folder.refused("render out.obj --field label -o no.png", 3, &["fields are: uv-quotient"]);
    folder.write("quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 1\nf 1/1 2/1 3/1 4/1\n");
    folder.refused("render quad.obj --field uv-quotient -o no.png", 3, &["give triangles"]);
}

#[test]
fn gltf_outputs_are_cut_open_with_labels_per_vertex() {
    let folder = across();
    for name in ["out.glb", "out.gltf"] {
        folder.done(&format!("{SOLVE} -o {name}"));
        let (file, mesh) = read(&folder, name);
        assert_split(&mesh);
        let labels = scalar(&file.vertex_scalars, "label");
        for (f, label) in expected(&mesh).into_iter().enumerate() {
            let corners = mesh.triangles()[f].map(|v| labels[v as usize]);
            assert_eq!(corners, [label; 3], "{name}");
        }
    }
    let json = folder.json("out.gltf");
    let attributes = &json["meshes"][0]["primitives"][0]["attributes"];
    let names: Vec<&str> = attributes.as_object().unwrap().keys().map(String::as_str).collect();
    assert_eq!(names, ["COLOR_0", "POSITION", "_label"]);
    let count = |name: &str| &json["accessors"][attributes[name].as_u64().unwrap() as usize]["count"];
    assert_eq!(count("COLOR_0"), count("POSITION"));
    assert_eq!(count("_label"), count("POSITION"));
}

#[test]
fn the_split_mesh_keeps_the_data_its_format_supports() {
    let folder = across();
    for name in ["s.ply", "s.ply.gz", "s.vtp", "s.obj", "s.off", "s.glb", "s.gltf", "s.stl"] {
        let outcome = folder.done(&format!("{SOLVE} --strict --split {name}"));
        assert!(!outcome.stderr.contains("warning"), "{}", outcome.stderr);
        let (file, mesh) = read(&folder, name);
        let labels = expected(&mesh);
        assert!(labels.contains(&1.0) && labels.contains(&0.0));
        if name.contains(".ply") || name.contains(".vtp") {
            assert_eq!(scalar(&file.face_scalars, "label"), labels, "{name}");
            assert_eq!(scalar(&file.face_scalars, "parent").last(), Some(&39.0));
        }
        if name == "s.stl" {
            continue; // each face has its own vertices
        }
        assert_split(&mesh);
        if name.contains(".gl") || name == "s.vtp" {
            continue; // the reader ignores their colours
        }
        // OBJ colours range from 0 to 1.
        let unit = if name == "s.obj" { 255.0 } else { 1.0 };
        for (k, channel) in ["red", "green", "blue"].into_iter().enumerate() {
            let values = scalar(&file.vertex_scalars, channel);
            for (f, label) in labels.iter().enumerate() {
                let wanted = f64::from(label_color(*label as i64)[k]);
                assert!(
                    mesh.triangles()[f].iter().all(|&v| (values[v as usize] * unit - wanted).abs() < 1e-6)
                );
            }
        }
    }
}

#[test]
fn input_faces_get_the_label_of_their_larger_part() {
    let folder = across();
    folder.done(&format!("{SOLVE} --input-labels in.npy"));
    folder.done(&format!("{SOLVE} --input-labels in.csv"));
    let labels = folder.npy("in.npy");
    // The squares with x from 4 to 5 are cut: three quarters of the face above the diagonal lie on
    // the left, and one quarter of the face below it.
    let wanted: Vec<i32> = (0..40).map(|f| i32::from(f < 16 || (f < 20 && f % 2 == 1))).collect();
    assert_eq!(labels, wanted);
    let column: Vec<i32> = folder.column("in.csv", "label").into_iter().map(|l| l as i32).collect();
    assert_eq!(column, wanted);
    assert_eq!(folder.column("in.csv", "face"), (0..40).map(f64::from).collect::<Vec<_>>());
    // Reversing the curve swaps its left side.
    folder.done(&format!("{SOLVE} --flip --input-labels flip.npy"));
    assert_eq!(folder.npy("flip.npy"), wanted.iter().map(|l| -l).collect::<Vec<_>>());
}

#[test]
fn pictures_are_drawn_for_curves_along_edges_and_across_faces() {
    let folder = across();
    for curve in ["line.json", "across.obj"] {
        folder.done(&format!(
            "winding grid.obj --curve {curve} --render r.png --render-values v.png --size 200x150 --report r.json"
        ));
        assert_eq!(png_size(&folder.bytes("r.png")), (200, 150));
        assert_eq!(png_size(&folder.bytes("v.png")), (200, 150));
        assert_ne!(folder.bytes("r.png"), folder.bytes("v.png"));
        let report = folder.json("r.json");
        let kinds: Vec<&str> =
            report["outputs"].as_array().unwrap().iter().map(|o| o["kind"].as_str().unwrap()).collect();
        assert_eq!(kinds, ["picture", "picture", "report"]);
    }
}

#[test]
fn unsupported_formats_are_refused_with_the_supported_ones() {
    let folder = across();
    let main = [".ply", ".vtp", ".obj", ".glb", ".gltf", ".csv", ".npy"];
    for name in ["out.stl", "out.off", "out.txt", "out", "out.png"] {
        folder.refused(&format!("{SOLVE} -o {name}"), 2, &[&main, &[name][..]].concat());
    }
    for name in ["s.npy", "s.csv", "s"] {
        let split = [name, ".ply", ".vtp", ".obj", ".off", ".stl", ".glb", ".gltf"];
        folder.refused(&format!("{SOLVE} --split {name}"), 2, &split);
    }
    for name in ["in.ply", "in.txt", "in"] {
        folder.refused(&format!("{SOLVE} --input-labels {name}"), 2, &[name, ".npy", ".csv"]);
    }
    for flag in ["--bounding", "--nonbounding", "--bounding-part", "--nonbounding-part"] {
        folder.refused(&format!("{SOLVE} {flag} b.ply"), 2, &["b.ply", ".obj"]);
    }
    for flag in ["--render", "--render-values"] {
        folder.refused(&format!("{SOLVE} {flag} p.jpg"), 2, &["p.jpg", "p.png"]);
    }
    folder.refused(&format!("{SOLVE} -o one.ply --split one.ply"), 2, &["one.ply"]);
    folder.refused(SOLVE, 2, &["no output is given"]);
    // Before any work: the mesh does not exist.
    folder.refused("winding none.obj --curve none.json -o out.stl", 2, &[".npy"]);
}

#[test]
fn tables_of_a_mesh_that_is_not_written_give_a_warning() {
    let folder = across();
    folder.write("quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nl 1 2 3 4 1\n");
    for name in ["out.npy", "out.csv"] {
        let words =
            [name, "mesh that is not being written", "with 40 faces was cut", "-o OUT.ply", "--input-labels"];
        folder.warned(&format!("winding grid.obj --curve across.obj -o {name}"), &words);
        // No warning if the mesh is also written, or if it is the user's own.
        folder.done(&format!("winding grid.obj --curve across.obj -o {name} --split s.ply --strict"));
        folder.done(&format!("winding grid.obj --curve line.json -o {name} --strict"));
        let words = [name, "2 faces", "with 1 faces was triangulated", "--input-labels"];
        folder.warned(&format!("winding quad.obj -o {name}"), &words);
    }
}

#[test]
fn many_labels_are_counted() {
    let folder = across();
    for (lines, words) in [(9, "labels [0, 1, 2, 3, 4, 5, 6, 7, 8, 9];"), (12, "13 labels from 0 to 12;")] {
        let line = |i: i32| format!("v {0} 0 0\nv {0} 2 0\n", 0.3 * f64::from(i));
        let ends: String = (1..=lines).map(line).collect();
        let segments: String = (1..=lines).map(|i| format!("l {} {}\n", 2 * i - 1, 2 * i)).collect();
        folder.write("lines.obj", &(ends + &segments));
        let outcome = folder.done("winding grid.obj --curve lines.obj --report r.json");
        assert!(outcome.stderr.contains(words), "{}", outcome.stderr);
        let all: Vec<i32> = (0..=lines).collect();
        assert_eq!(folder.json("r.json")["result"]["labels"], serde_json::json!(all));
    }
}

#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn curves_of_the_shared_data_are_written_in_every_format() {
    let data = data();
    let folder = Folder::new();
    let curves = data.join("curves/swn");
    let mut ran = 0;
    for (mesh, curve) in [
        (curves.join("torus.obj"), "torus-phi.txt"),
        (curves.join("annulus.obj"), "annulus.txt"),
        (data.join("closed/bunny.obj"), "bunny-brokenheart.txt"),
    ] {
        let solve = format!("winding {} --curve {} -q", mesh.display(), curves.join(curve).display());
        folder.done(&format!("{solve} -o out.glb --split s.ply --input-labels in.npy"));
        let (file, cut) = read(&folder, "s.ply");
        let labels = scalar(&file.face_scalars, "label");
        for v in cut.vertices() {
            let corners = cut.vertex_corners(v);
            assert!(corners.iter().all(|c| labels[c.face().index()] == labels[corners[0].face().index()]));
        }
        let (glb, _) = read(&folder, "out.glb");
        assert_eq!(glb.mesh.vertex_count(), cut.vertex_count());
        let input = read_mesh(&mesh).unwrap();
        assert_eq!(folder.npy("in.npy").len(), input.mesh.face_count());
        ran += 1;
    }
    println!("{ran} files ran");
}

#[test]
fn a_bounding_curve_has_no_nonbounding_part() {
    let folder = Folder::new();
    // The plane cuts the torus in two circles around the tube, which together bound a half.
    folder.done("make torus nu=40 nv=20 -o t.ply --curve-out two.json --cut axis=y,at=0.03");
    folder.done(
        "winding t.ply --curve two.json --bounding-part b.obj --nonbounding-part n.obj --bounding l.obj",
    );
    let segments = |name: &str| {
        let text = String::from_utf8(folder.bytes(name)).unwrap();
        text.lines().filter(|l| l.starts_with("l ")).map(|l| l.split_whitespace().count() - 2).sum::<usize>()
    };
    assert!(segments("b.obj") > 40);
    assert_eq!(segments("n.obj"), 0);
    assert_eq!(segments("l.obj"), segments("b.obj"));
}

#[test]
fn only_oriented_curves_are_accepted() {
    let folder = Folder::new();
    folder.done("make geodesic_sphere -o s.ply --curve-out c.json --cut axis=z,at=0.2");
    folder.refused("winding s.ply -o x.ply", 2, &["there is no curve", "--curve"]);
    folder.refused("winding s.ply --points 0 -o x.ply", 2, &["--points", "oriented"]);
    folder.refused("winding s.ply --curve c.json --unsigned -o x.ply", 2, &["--unsigned", "oriented"]);
    assert!(!folder.files().iter().any(|name| name.contains("x.ply")));
}

#[test]
fn the_suggested_curve_turns_reversed_pieces_around() {
    let folder = Folder::new();
    folder.done(
        "make geodesic_sphere frequency=16 -o s.ply --broken-curve c.json --cut axis=z,at=0.2 --keep 0.1 --drop 0.05 --seed 4",
    );
    let mut curves = folder.json("c.json");
    let pieces = curves["curves"].as_array_mut().unwrap();
    assert!(pieces.len() > 3, "{}", pieces.len());
    let right = pieces.clone();
    pieces[1]["nodes"].as_array_mut().unwrap().reverse();
    folder.write("wrong.json", &curves.to_string());
    folder.done("winding s.ply --curve wrong.json --suggested better.json --report r.json");
    assert_eq!(folder.json("better.json")["curves"].as_array().unwrap(), &right);
    let orientation = &folder.json("r.json")["result"]["orientation"];
    assert_eq!(
        orientation["reversed"].as_array().unwrap().len(),
        right[1]["nodes"].as_array().unwrap().len() - 1
    );
    assert!(orientation["energy_saved"].as_f64().unwrap() > 0.1);
    folder.refused("winding s.ply --curve c.json --suggested x.ply", 2, &["json"]);
    folder.refused("winding s.ply --curve c.json --suggested x.json --diagnose never", 2, &["--diagnose"]);
}

#[test]
fn a_missing_suggestion_is_a_failure() {
    let folder = Folder::new();
    // More pieces of one edge than the diagnosis supports.
    let (n, vertex) = (103, |i: usize, j: usize| 104 * i + j + 1);
    let mut text = String::new();
    for i in 0..=n {
        (0..=n).for_each(|j| text += &format!("v {i} {j} 0\n"));
    }
    for i in 0..n {
        for j in 0..n {
            let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
            if i % 2 == 1 && j % 2 == 1 && i + 1 < n && j + 1 < n {
                text += &format!("l {a} {d}\n");
            }
        }
    }
    folder.write("pieces.obj", &text);
    let words = ["better.json", "it has 2601 stretches, more than the 2000", "leave --suggested out"];
    folder.refused("winding pieces.obj --keep-short -o o.ply --suggested better.json", 1, &words);
}
