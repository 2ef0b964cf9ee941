//! Curves number vertices, edges and faces as in the mesh file, whatever the repairs.

mod run;

use run::{Folder, grid_obj};

/// The grid of [`grid_obj`] with an extra first face, which shifts the numbers of the others by
/// one.
fn grid_behind(face: &str) -> String {
    let grid = grid_obj();
    let at = grid.find("f ").unwrap();
    format!("{}{face}\n{}", &grid[..at], &grid[at..])
}

/// The corners of all faces of a triangle mesh, from 0.
fn faces(obj: &str) -> Vec<[u32; 3]> {
    let corners = |l: &str| l.split(' ').map(|w| w.parse::<u32>().unwrap() - 1).collect::<Vec<_>>();
    obj.lines().filter_map(|l| l.strip_prefix("f ")).map(|l| corners(l).try_into().unwrap()).collect()
}

/// The number of an edge: edges are numbered in the order in which the faces visit them.
fn edge(faces: &[[u32; 3]], ends: [u32; 2]) -> usize {
    let mut met: Vec<[u32; 2]> = Vec::new();
    for [a, b, c] in faces {
        for [p, q] in [[a, b], [b, c], [c, a]] {
            let side = [*p.min(q), *p.max(q)];
            if !met.contains(&side) {
                met.push(side);
            }
        }
    }
    met.iter().position(|e| *e == ends).unwrap()
}

/// The line x = 4.5: across these edges, and from the first to the second face.
const EDGES: [[u32; 2]; 5] = [[12, 15], [12, 16], [13, 16], [13, 17], [14, 17]];
const FACES: [[u32; 3]; 2] = [[12, 15, 16], [13, 17, 14]];

fn by_edges(obj: &str) -> String {
    let faces = faces(obj);
    let nodes: String = EDGES.iter().map(|&e| format!("e {} 0.5\n", edge(&faces, e))).collect();
    format!("signed_curve\n{nodes}")
}

fn by_faces(obj: &str) -> String {
    let faces = faces(obj);
    let node = |f: &[u32; 3]| format!("f {} 0.5 0.25 0.25\n", faces.iter().position(|g| g == f).unwrap());
    format!("signed_curve\n{}", FACES.iter().map(node).collect::<String>())
}

#[track_caller]
fn assert_equal(folder: &Folder, a: &str, b: &str) {
    let (a, b) = (folder.column(a, "distance"), folder.column(b, "distance"));
    assert_eq!(a.len(), b.len());
    for (v, (a, b)) in a.iter().zip(&b).enumerate() {
        assert!((a - b).abs() < 1e-9, "vertex {v}: {a}, not {b}");
    }
}

/// Unit squares in a row along x, each with its own vertices, and the line x = 2 on vertices of the
/// third.
fn loose_squares() -> String {
    let (mut vertices, mut faces) = (String::new(), String::new());
    for x in 0..6 {
        let a = 4 * x + 1;
        vertices += &format!("v {x} 0 0\nv {} 0 0\nv {} 1 0\nv {x} 1 0\n", x + 1, x + 1);
        faces += &format!("f {a} {} {}\nf {a} {} {}\n", a + 1, a + 2, a + 2, a + 3);
    }
    format!("{vertices}{faces}l 9 12\n")
}

#[test]
fn lines_of_the_mesh_keep_their_position_when_vertices_are_merged() {
    let folder = Folder::new();
    folder.write("loose.obj", &loose_squares());
    folder.done("sdf loose.obj --weld -o out.csv");
    // The kept vertices: four of the first square, then the two on the right of each.
    let x = [0.0, 1.0, 1.0, 0.0].into_iter().chain((2..=6).flat_map(|x| [f64::from(x); 2]));
    let distance = folder.column("out.csv", "distance");
    assert_eq!(distance.len(), 14);
    for (v, (d, x)) in distance.iter().zip(x).enumerate() {
        assert!((d - (x - 2.0)).abs() < 1e-9, "vertex {v}: {d}, not {}", x - 2.0);
    }
    folder.done("winding loose.obj --weld --input-labels labels.csv");
    let labels = folder.column("labels.csv", "label");
    assert_eq!(labels, [[1.0; 4].as_slice(), &[0.0; 8]].concat());
}

#[test]
fn lines_are_joined_where_their_vertices_are_merged() {
    let folder = Folder::new();
    // Two lines of two vertices each, which meet at (2, 1) with separate vertices.
    let mesh = loose_squares().replace("l 9 12\n", "l 9 12\nl 7 8\n");
    folder.write("loose.obj", &mesh);
    let facts = folder.done("inspect loose.obj --weld --json").text();
    let facts: serde_json::Value = serde_json::from_str(&facts).unwrap();
    assert_eq!(facts["curves"]["curves"].as_array().unwrap().len(), 1, "{}", facts["curves"]);
    assert_eq!(facts["curves"]["curves"][0]["nodes"], 3);
}

#[test]
fn face_numbers_count_dropped_faces() {
    let folder = Folder::new();
    folder.write("grid.obj", &grid_obj());
    folder.write("flat.obj", &grid_behind("f 1 4 7")); // three collinear vertices
    for (curve, of) in [("e.txt", by_edges as fn(&str) -> String), ("f.txt", by_faces)] {
        folder.write(curve, &of(&grid_obj()));
        folder.done(&format!("sdf grid.obj --curve {curve} -o whole.csv"));
        folder.write(curve, &of(&grid_behind("f 1 4 7")));
        folder.done(&format!("sdf flat.obj --drop-degenerate --curve {curve} -o out.csv"));
        assert_equal(&folder, "out.csv", "whole.csv");
        folder.done(&format!("sdf flat.obj --weld --drop-degenerate --curve {curve} -o out.csv"));
        assert_equal(&folder, "out.csv", "whole.csv");
    }
}

#[test]
fn points_on_dropped_faces_are_refused() {
    let folder = Folder::new();
    folder.write("flat.obj", &grid_behind("f 1 4 7"));
    folder.write("face.txt", "signed_curve\nv 15\nf 0 0.5 0.25 0.25\n");
    folder.write("edge.txt", "signed_curve\nv 15\ne 2 0.5\n"); // from the third corner to the first
    folder.write("point.txt", "unsigned_point\nf 0 0.5 0.25 0.25\n");
    let sdf = "sdf flat.obj --drop-degenerate -o out.csv";
    folder.refused(&format!("{sdf} --curve face.txt"), 3, &["face.txt", "curve 0, node 1", "0, 3"]);
    folder.refused(&format!("{sdf} --curve edge.txt"), 3, &["edge.txt", "curve 0, node 1", "6"]);
    folder.refused(&format!("{sdf} --points point.txt"), 3, &["point.txt", "point 0"]);
}

#[test]
fn face_numbers_count_broken_faces() {
    let folder = Folder::new();
    folder.write("grid.obj", &grid_obj());
    folder.write("f.txt", &by_faces(&grid_obj()));
    folder.done("sdf grid.obj --curve f.txt -o whole.csv");
    let broken = grid_behind("f 1 1 4");
    folder.write("broken.obj", &broken);
    folder.write("f.txt", &by_faces(&broken));
    for repair in ["--drop-degenerate", "--weld"] {
        folder.done(&format!("sdf broken.obj {repair} --curve f.txt -o out.csv"));
        assert_equal(&folder, "out.csv", "whole.csv");
    }
    let sdf = "sdf broken.obj --drop-degenerate -o no.csv";
    folder.write("on.txt", "signed_curve\nv 15\nf 0 0.5 0.25 0.25\n");
    folder.refused(&format!("{sdf} --curve on.txt"), 3, &["on.txt", "face 0", "dropped"]);
    folder.write("beyond.txt", "signed_curve\nv 15\nv 33\n");
    folder.refused(&format!("{sdf} --curve beyond.txt"), 3, &["beyond.txt", "vertex 33", "the mesh has 33"]);
    // It is not defined whether a side from a vertex to itself counts as an edge.
    folder.write("e.txt", &by_edges(&broken));
    folder.refused(&format!("{sdf} --curve e.txt"), 3, &["e.txt", "line 2", "ambiguous", "JSON"]);
}

#[test]
fn faces_of_stl_files_keep_their_numbers() {
    let folder = Folder::new();
    let stl = |obj: &str| {
        let place = |v: u32| format!("vertex {} {} 0\n", v / 3, v % 3);
        let facet = |f: &[u32; 3]| {
            format!("facet normal 0 0 1\nouter loop\n{}endloop\nendfacet\n", f.map(place).concat())
        };
        format!("solid s\n{}endsolid s\n", faces(obj).iter().map(facet).collect::<String>())
    };
    folder.write("grid.stl", &stl(&grid_obj()));
    folder.write("f.txt", &by_faces(&grid_obj()));
    folder.done("sdf grid.stl --curve f.txt -o whole.csv");
    for face in ["f 1 1 4", "f 1 4 7"] {
        folder.write("more.stl", &stl(&grid_behind(face)));
        folder.write("f.txt", &by_faces(&grid_behind(face)));
        folder.done("sdf more.stl --drop-degenerate --curve f.txt -o out.csv");
        // Vertices are numbered in the order of their first corner; sorted, both results agree.
        let sorted = |name: &str| {
            let mut distance = folder.column(name, "distance");
            distance.sort_by(f64::total_cmp);
            distance
        };
        for (a, b) in sorted("out.csv").iter().zip(sorted("whole.csv")) {
            assert!((a - b).abs() < 1e-9, "{face}: {a}, not {b}");
        }
    }
}

/// Six unit squares in a row along x, as polygons after these faces; vertex `2 x + y + 1` of the
/// OBJ file lies at (x, y).
fn squares_behind(faces: &str) -> String {
    let vertices: String = (0..14).map(|v| format!("v {} {} 0\n", v / 2, v % 2)).collect();
    let square = |x: i32| format!("f {} {} {} {}\n", 2 * x + 1, 2 * x + 3, 2 * x + 4, 2 * x + 2);
    vertices + faces + &(0..6).map(square).collect::<String>()
}

const AT_2: &str = r#"{"eikona":"curves","version":1,"curves":[{"nodes":[{"vertex":4},{"vertex":5}]}]}"#;

#[test]
fn labels_are_per_polygon_not_per_triangle() {
    let folder = Folder::new();
    folder.write("row.obj", &squares_behind(""));
    folder.write("line.json", AT_2);
    let winding = "winding row.obj --curve line.json";
    for (reference, left, right) in [("", 1, 0), ("--reference 1", 0, -1), ("--reference 3", 1, 0)] {
        let command = format!("{winding} {reference} --strict");
        folder.done(&format!("{command} --input-labels in.npy"));
        assert_eq!(folder.npy("in.npy"), [left, left, right, right, right, right], "{reference}");
        folder.done(&format!("{command} --input-labels in.csv"));
        assert_eq!(folder.column("in.csv", "label")[1..3], [f64::from(left), f64::from(right)]);
    }
    for face in [6, 11] {
        let words = ["--reference", &format!("face {face} does not exist"), "6 faces, numbered from 0 to 5"];
        folder.refused(&format!("{winding} --reference {face} -o o.ply"), 2, &words);
    }
    // A share of 0.7 of the third square lies on the left, but less than half of its first
    // triangle.
    folder.write("across.obj", "v 2.7 0 0\nv 2.7 1 0\nl 1 2\n");
    folder.done("winding row.obj --curve across.obj --input-labels in.npy");
    assert_eq!(folder.npy("in.npy"), [1, 1, 1, 0, 0, 0]);
    for curve in ["line.json", "across.obj"] {
        for name in ["out.csv", "out.ply", "out.vtp"] {
            folder.done(&format!("winding row.obj --curve {curve} -o {name}"));
            assert_parents(&folder, name, 0);
        }
        folder.done(&format!("winding row.obj --curve {curve} --split out.ply"));
        assert_parents(&folder, "out.ply", 0);
    }
}

/// Checks that the parts of each square have its number as parent, counted from `first`.
#[track_caller]
fn assert_parents(folder: &Folder, name: &str, first: u32) {
    if name.ends_with(".csv") {
        let mut parents = folder.column(name, "parent");
        parents.dedup();
        assert_eq!(parents, (first..first + 6).map(f64::from).collect::<Vec<_>>(), "{name}");
        return;
    }
    let file = eikona_mesh::io::read_mesh(folder.0.join(name)).unwrap();
    let parents = &file.face_scalars.iter().find(|s| s.0 == "parent").unwrap().1;
    assert!(parents.len() >= 12);
    for (corners, parent) in file.mesh.faces().zip(parents) {
        let middle = corners.iter().map(|&v| file.mesh.positions[v as usize][0]).sum::<f64>() / 3.0;
        assert_eq!(middle.floor() + f64::from(first), *parent, "{name}");
    }
}

#[test]
fn labels_count_dropped_faces() {
    let folder = Folder::new();
    // One face repeats a vertex, and one has zero area.
    folder.write("row.obj", &squares_behind("f 1 1 3\nf 1 3 5\n"));
    folder.write("line.json", AT_2);
    let winding = "winding row.obj --drop-degenerate --curve line.json";
    folder.done(&format!("{winding} --weld --reference 4 --input-labels in.npy"));
    assert_eq!(folder.npy("in.npy")[1..5], [i32::MIN, 1, 1, 0]);
    for (reference, left, right) in [("", 1, 0), ("--reference 3", 0, -1), ("--reference 4", 1, 0)] {
        let dropped = "2 dropped faces have no label (first: face 0)";
        let words = ["in.npy", dropped, "written as -2147483648"];
        folder.warned(&format!("{winding} {reference} --input-labels in.npy"), &words);
        let labels = folder.npy("in.npy");
        assert_eq!(labels, [i32::MIN, i32::MIN, left, left, right, right, right, right], "{reference}");
        let words = ["in.csv", dropped, "written as an empty field"];
        folder.warned(&format!("{winding} {reference} --input-labels in.csv"), &words);
        let rows: String = (2..8).map(|f| format!("{f},{}\n", if f < 4 { left } else { right })).collect();
        assert_eq!(folder.read("in.csv"), format!("face,label\n0,\n1,\n{rows}"));
    }
    for face in [0, 1] {
        let words = [&format!("--reference {face}: face {face} was dropped"), "name another face"];
        folder.refused(&format!("{winding} --reference {face} -o o.ply"), 2, &words);
    }
    folder.refused(&format!("{winding} --reference 8 -o o.ply"), 2, &["8 faces, numbered from 0 to 7"]);
    for name in ["out.csv", "out.ply"] {
        folder.done(&format!("{winding} -o {name}"));
        assert_parents(&folder, name, 2);
    }
    assert!(folder.done("winding --help").text().contains("-2147483648"));
}
