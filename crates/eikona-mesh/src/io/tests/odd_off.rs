//! OFF files whose lines are not one vertex or face each, and headers as programs write them.

use crate::io::*;

const VERTICES: [&str; 4] = ["10 20 30", "11 20 30", "11 21.5 30", "10 21.5 30"];
const FACES: [&str; 2] = ["3 0 1 2", "3 0 2 3"];

/// Returns a header, the vertices and the faces, with the given text after each vertex and face.
fn off(header: &str, behind_vertex: &str, behind_face: &str) -> String {
    let vertices: String = VERTICES.iter().map(|v| format!("{v}{behind_vertex}\n")).collect();
    let faces: String = FACES.iter().map(|f| format!("{f}{behind_face}\n")).collect();
    format!("{header}{vertices}{faces}")
}

/// Checks that the text is the rectangle 1 by 1.5 at (10, 20, 30).
fn check(text: &str) -> MeshFile {
    let file = read_off(text.as_bytes()).unwrap_or_else(|fault| panic!("{fault}\n{text}"));
    let expected = [[10., 20., 30.], [11., 20., 30.], [11., 21.5, 30.], [10., 21.5, 30.]];
    assert_eq!(file.mesh.positions, expected, "{text}");
    assert!(file.mesh.faces().eq([[0, 1, 2], [0, 2, 3]]), "{text}");
    assert_eq!(file.warnings, [], "{text}");
    file
}

// reports.md F3
#[test]
fn the_number_of_edges_may_be_anywhere_or_missing() {
    for header in [
        "OFF\n4 2 5\n",
        "OFF\n4 2\n5\n",
        "OFF\n4\n2\n5\n",
        "OFF 4 2 5\n",
        "OFF 4 2\n5\n",
        "OFF\n4 2\n",
        "OFF 4 2\n",
        "4 2 5\n",
        "4 2\n5\n",
        "4 2\n",
        "# a\nOFF # b\n# c\n4 2 # d\n# e\n\n5 # f\n# g\n",
        "OFF\n4 2 # no edges\n",
        "OFF\n\n4 2 5\n\n",
        "OFF\n4 2\n5 ",
        "OFF\n4 2 5 ",
        "OFF\t4\t2\t5\n",
        "OFF\n4 2 5 extra\n",
        "OFF\n4 2\n\n\n5\n\n",
    ] {
        check(&off(header, "", ""));
        check(&off(header, "", "").replace('\n', "\r"));
        check(&off(header, "", "").replace('\n', "\r\n\n"));
        check(&off(header, "", "  255 0 0"));
        check(&off(header, " 7", "")); // an unknown value per vertex
    }
    // reports.md F3 with other kinds of vertices
    for (keyword, behind) in
        [("COFF", " 255 0 0 255"), ("COFF", " 1 0 0"), ("NOFF", " 0 0 1"), ("STOFF", " .5 .25")]
    {
        for counts in ["4 2 5\n", "4 2\n5\n", "4\n2\n5\n", "4 2 # c\n# c\n5\n"] {
            check(&off(&format!("{keyword}\n{counts}"), behind, ""));
        }
    }
}

// reports.md F10
#[test]
fn the_keyword_may_be_in_any_case_and_adjoin_the_count() {
    for header in ["OFF4 2 5\n", "OFF4 2\n5\n", "off4 2 5\n", "off\n4 2 5\n", "Off 4 2\n"] {
        check(&off(header, "", ""));
        assert_eq!(MeshFormat::sniff(off(header, "", "").as_bytes()), Some(MeshFormat::Off), "{header}");
    }
    for (header, behind, names) in [
        ("coff\n4 2 5\n", " 255 0 0 255", &["red", "green", "blue"][..]),
        ("Coff4 2\n5\n", " 255 0 0", &["red", "green", "blue"]),
        ("noff\n4 2 5\n", " 0 0 1", &["nx", "ny", "nz"]),
        ("stcnoff\n4 2 5\n", " 0 0 1 1 1 1 1 .5 .5", &["nx", "ny", "nz", "red", "green", "blue"]),
    ] {
        let file = check(&off(header, behind, ""));
        assert!(file.vertex_scalars.iter().map(|s| s.0.as_str()).eq(names.iter().copied()), "{header}");
    }
    for (text, words) in [
        ("nOFF\n3\n1 0 0\n0 0 0\n", "three coordinates"),
        ("4off\n1 0 0\n0 0 0 1\n", "three coordinates"),
        ("4nOFF 3\n1 0 0\n0 0 0 1\n", "three coordinates"),
        ("off binary\n", "binary OFF"),
        ("OFFICE\n1 0 0\n", "this is an OFF file"),
    ] {
        let refusal = read_off(text.as_bytes()).unwrap_err().to_string();
        assert!(refusal.contains(words), "{refusal}");
    }
}

// reports.md F3: layouts that were rejected as truncated
#[test]
fn lines_may_contain_several_vertices_or_faces() {
    let [a, b, c, d] = VERTICES;
    let [f, g] = FACES;
    for text in [
        format!("OFF\n4 2 5\n{a} {b}\n{c} {d}\n{f} {g}\n"),
        format!("OFF\n4 2 5\n{a} {b}\n{c} {d}\n{f} 255 0 0\n{g} 255 0 0\n"),
        format!("OFF 4 2 5 {a} {b} {c} {d} {f} {g}"),
        format!("OFF\n4 2\n{a} {b} {c} {d} {f} {g}\n"),
        format!("OFF\n4 2\n5 {a} {b}\n{c} {d}\n{f}\n{g}\n"),
        format!("OFF\n4 2\n{a} {b}\n{c} {d}\n{f}\n{g}\n"),
        format!("OFF\n4 2 5\n{a}\n{b} {c} {d}\n{f} {g}\n"),
        format!("OFF\n4 2 5\n{}\n", [a, b, c, d, f, g].join(" ").replace(' ', "\n")),
        format!("OFF 4 2\n5\n{a}\n{b}\n{c}\n{d} {f}\n{g}\n"),
    ] {
        check(&text);
    }
    let coloured = [a, b, c, d].map(|v| format!("{v} 0 0 1 255 128 0 255"));
    let file = check(&format!("CNOFF\n4 2 5\n{}\n{f}\n{g}\n", coloured.join(" ")));
    assert_eq!(file.vertex_scalars[4], ("green".to_string(), vec![128.0; 4]));
    let coloured = [a, b, c, d].map(|v| format!("{v} 0.5 0.25 0"));
    let file = check(&format!("COFF 4 2 5 {} {f} {g}", coloured.join(" ")));
    assert_eq!(file.vertex_scalars[1], ("green".to_string(), vec![0.25; 4]));
}

/// Wherever the file is truncated, no coordinate may come from another place in it.
#[test]
fn a_truncated_file_is_an_error_or_keeps_its_vertices() {
    let whole = [
        off("OFF\n4 2\n5\n", "", ""),
        off("OFF\n4 2\n", "", "  1 0 0"),
        off("COFF\n4 2 0\n", " 3 0 1 2", "").replace(" 30", " 0"),
        off("OFF 4 2 5 ", "", "").replace('\n', " "),
    ];
    let mut refused = 0;
    for text in &whole {
        let full = read_off(text.as_bytes()).unwrap().mesh.positions;
        for length in 3..text.len() {
            match read_off(&text.as_bytes()[..length]) {
                Ok(file) => assert!(file.mesh.positions == full, "{}", &text[..length]),
                Err(_) => refused += 1,
            }
        }
    }
    println!("{refused} refused");
    // Two coordinates per vertex are not valid OFF either.
    let refusal = read_off(b"OFF\n4 1 0\n0 0\n1 0\n1 1\n0 1\n4 0 1 2 3\n").unwrap_err().to_string();
    assert!(refusal.contains("line 4") && refusal.contains("vertex 0"), "{refusal}");
    let refusal = read_off(b"OFF\n4 2 0\n0 0 0\n1 0 0\n").unwrap_err().to_string();
    assert!(refusal.contains("after 2 of 4") && refusal.contains("or the counts"), "{refusal}");
}
