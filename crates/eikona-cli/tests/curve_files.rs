//! Curve files in the wild, and lines in the mesh's own file (reports.md F8, F9, F23).

mod run;

use flate2::{Compression, write::GzEncoder};
use run::Folder;
use std::io::Write;

/// A unit square of 4 x 4 cells with 25 vertices.
fn square() -> (Folder, String) {
    let folder = Folder::new();
    folder.done("make grid nx=4 ny=4 width=1 height=1 -o grid.obj");
    let text = String::from_utf8(folder.bytes("grid.obj")).unwrap();
    (folder, text)
}

fn distances(folder: &Folder, mesh: &str, options: &str) -> Vec<f64> {
    folder.done(&format!("sdf {mesh} {options} -o d.csv"));
    folder.column("d.csv", "distance")
}

/// Checks the distance to the upward line x = 0.5 at the 25 vertices of the grid.
#[track_caller]
fn assert_is_line(folder: &Folder, distance: &[f64]) {
    let grid = folder.read("grid.obj");
    let vertices = grid.lines().filter_map(|line| line.strip_prefix("v "));
    let x = vertices.map(|v| v.split(' ').next().unwrap().parse::<f64>().unwrap());
    for (x, d) in x.zip(distance) {
        assert!((d - (x - 0.5)).abs() < 1e-6, "{d} at x = {x}");
    }
}

#[test]
fn stray_lines_in_the_mesh_file_do_not_stop_commands_without_need_of_them() {
    let (folder, grid) = square();
    for (name, stray) in [
        ("far.obj", "v 5 5 5\nv 6 6 6\nl 26 27\n"),
        ("one_point.obj", "v 0.5 0.5 0\nl 26 26\n"),
        ("apart.obj", "v 9 9 9\nv 9.1 9 9\nv 9 9.1 9\nf 26 27 28\nl 1 26\n"),
        ("index_of_no_face.obj", "v 9 9 9\nl 1 26\n"),
    ] {
        folder.write(name, &format!("{grid}{stray}"));
        let outcome = folder.done(&format!("inspect {name} --json"));
        assert!(outcome.text().contains("\"faces_in_file\""), "{name}");
        assert!(outcome.stderr.contains("warning"), "{name}: {}", outcome.stderr);
        folder.done(&format!("render {name} -o {name}.png --size 64x64"));
        folder.write("line.obj", "v 0.5 0 0\nv 0.5 1 0\nl 1 2\n");
        assert_is_line(&folder, &distances(&folder, name, "--curve line.obj"));
        folder.done(&format!("sdf {name} --points 0 -o p.csv"));
        folder.refused(&format!("sdf {name} -o d2.csv"), 3, &[name]);
    }
    folder.refused("sdf far.obj -o d2.csv", 3, &["off its surface", "--curve FILE"]);
}

#[test]
fn lines_over_their_own_vertices_in_the_mesh_file_are_traced() {
    let (folder, grid) = square();
    let own = "v 0.5 0 0\nv 0.5 1 0\nl 26 27\n";
    let variations = [
        ("two vertices of their own", own.to_string()),
        ("three, as an object", "o curve\nv 0.5 0 0\nv 0.5 0.4 0\nv 0.5 1 0\nl 26 27 28\n".into()),
        ("single segments", "v 0.5 0 0\nv 0.5 0.4 0\nv 0.5 1 0\nl 26 27\nl 27 28\n".into()),
        ("from the mesh into space", "v 0.5 1 0\nl 11 26\n".into()),
        ("a little off the surface", "v 0.5 0 0.001\nv 0.5 1 -0.001\nl 26 27\n".into()),
        ("beside a stray one", format!("{own}v 5 5 5\nv 6 6 6\nl 28 29\n")),
        ("on vertices of the mesh", "l 11 12 13 14 15\n".into()),
    ];
    for (name, lines) in variations {
        folder.write("own.obj", &format!("{grid}{lines}"));
        let distance = distances(&folder, "own.obj", "");
        assert_is_line(&folder, &distance);
        assert!(distance[25..].iter().all(|d| d.is_nan()), "{name}: unreferenced vertices have no distance");
    }
    // A separate file gives the same. (Two more unknowns may change the elimination order.)
    folder.write("own.obj", &format!("{grid}{own}"));
    folder.write("line.obj", "v 0.5 0 0\nv 0.5 1 0\nl 1 2\n");
    let alone = distances(&folder, "grid.obj", "--curve line.obj");
    let own = distances(&folder, "own.obj", "");
    assert!(own.iter().zip(&alone).all(|(a, b)| (a - b).abs() < 1e-12), "{own:?} and {alone:?}");
    // A closed curve.
    folder.write(
        "loop.obj",
        &format!("{grid}v 0.25 0.25 0\nv 0.75 0.25 0\nv 0.75 0.75 0\nv 0.25 0.75 0\nl 26 27 28 29 26\n"),
    );
    let distance = distances(&folder, "loop.obj", "");
    assert!(distance[12] < -0.1 && distance[0] > 0.1, "{distance:?}");
}

#[test]
fn curve_obj_files_are_read_like_mesh_files() {
    let (folder, _) = square();
    folder.write("plain.obj", "v 0.5 0 0\nv 0.5 0.5 0\nv 0.5 1 0\nl 1 2 3\n");
    let plain = distances(&folder, "grid.obj", "--curve plain.obj");
    assert_is_line(&folder, &plain);
    for (name, text) in [
        ("CR line ends", "v 0.5 0 0\rv 0.5 0.5 0\rv 0.5 1 0\rl 1 2 3\r"),
        ("CR LF line ends", "v 0.5 0 0\r\nv 0.5 0.5 0\r\nv 0.5 1 0\r\nl 1 2 3\r\n"),
        ("continued line", "v 0.5 0 0\nv 0.5 0.5 0\nv 0.5 1 0\nl 1 2 \\\n3\n"),
        ("comment behind", "v 0.5 0 0 # a\nv 0.5 0.5 0\nv 0.5 1 0\nl 1 2 3 # note\n"),
        ("indices ahead", "l 1 2 3\nv 0.5 0 0\nv 0.5 0.5 0\nv 0.5 1 0\n"),
        ("decimal indices", "v 0.5 0 0\nv 0.5 0.5 0\nv 0.5 1 0\nl 1.0 2.0 3.0\n"),
        ("negative indices", "v 0.5 0 0\nv 0.5 0.5 0\nv 0.5 1 0\nl -3 -2 -1\n"),
        ("texture indices", "v 0.5 0 0\nv 0.5 0.5 0\nv 0.5 1 0\nvt 0 0\nl 1/1 2/1 3/1\n"),
        ("repeated vertices", "v 0.5 0 0\nv 0.5 0.5 0\nv 0.5 1 0\nl 1 1 2 2 3\n"),
        ("mark", "\u{feff}v 0.5 0 0\nv 0.5 0.5 0\nv 0.5 1 0\nl 1 2 3\n"),
        ("tabs and blanks", "  v\t0.5 0 0\n\n v 0.5  0.5 0\nv 0.5 1 0 \n\tl 1 2\t3\n"),
        ("other statements", "mtllib a\nv 0.5 0 0\nv 0.5 0.5 0\nv 0.5 1 0\ng a\nusemtl b\ns off\nl 1 2 3\n"),
    ] {
        folder.write("c.obj", text);
        assert_eq!(distances(&folder, "grid.obj", "--curve c.obj"), plain, "{name}");
    }
    let wide: Vec<u8> =
        "v 0.5 0 0\nv 0.5 0.5 0\nv 0.5 1 0\nl 1 2 3\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let marked = [b"\xff\xfe".as_slice(), &wide].concat();
    std::fs::write(folder.0.join("c.obj"), marked).unwrap();
    assert_eq!(distances(&folder, "grid.obj", "--curve c.obj"), plain, "UTF-16");
    let zipped = |text: &[u8]| {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(text).unwrap();
        encoder.finish().unwrap()
    };
    std::fs::write(folder.0.join("c.obj.gz"), zipped(&folder.bytes("plain.obj"))).unwrap();
    assert_eq!(distances(&folder, "grid.obj", "--curve c.obj.gz"), plain, "gzip");
    // Other text formats.
    for (name, text) in [
        ("demo.txt", "signed_curve # upwards\rv 10 # a\rv 11\rv 12\rv 13\rv 14\r"),
        ("swn.txt", "#offset 0\rv 10 # a\rv 11\rv 12\rv 13\rv 14\rl 0 1 # b\rl 1 2\rl 2 3\rl 3 4\r"),
    ] {
        folder.write(name, text);
        assert_is_line(&folder, &distances(&folder, "grid.obj", &format!("--curve {name}")));
        std::fs::write(folder.0.join("z.txt.gz"), zipped(text.as_bytes())).unwrap();
        assert_is_line(&folder, &distances(&folder, "grid.obj", "--curve z.txt.gz"));
    }
}

#[test]
fn faults_of_curve_files_name_the_line_or_vertex() {
    let (folder, _) = square();
    for (text, words) in [
        ("v 0.5 0 0\nv 0.5 1 0\nl 1 3\n", ["vertex 3", "line 3"]),
        ("v 0.5 0 0\nv 0.5 1 0\nl 1 x\n", ["x", "line 3"]),
        ("v 0.5 0 0\nv 0.5 1 0\nl 0 1\n", ["vertex 0", "line 3"]),
        ("v 0.5 0 0\nv nan 1 0\nl 1 2\n", ["vertex 2", "not finite"]),
        ("v 0.5 0 0\nv 0.5 1 0\n", ["no l lines", "no curve"]),
        ("l 1 2 3\n", ["no v lines", "no curve"]),
    ] {
        folder.write("c.obj", text);
        folder.refused("sdf grid.obj --curve c.obj -o d.csv", 3, &words);
    }
}
