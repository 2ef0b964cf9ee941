//! STL files as programs write them, in violation of the format.

use crate::FileWarning;
use crate::io::*;

/// Returns two facets of a triangle, with this text between statements.
fn ascii(end: &str) -> String {
    let corners = ["vertex 0 0 0", "vertex 1 0 0", "vertex 0 1 0.5"].join(end);
    let facet = ["facet normal 0 0 1", "outer loop", &corners, "endloop", "endfacet", ""].join(end);
    format!("solid part{end}{facet}{facet}endsolid part{end}")
}

fn check(bytes: &[u8], facets: usize) -> Vec<FileWarning> {
    let text = String::from_utf8_lossy(bytes);
    let file = read_stl(bytes).unwrap_or_else(|fault| panic!("{fault}\n{text}"));
    assert_eq!(file.mesh.face_count(), facets, "{text}");
    for corners in file.mesh.positions.chunks(3) {
        assert_eq!(corners, [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.5]], "{text}");
    }
    file.warnings
}

// reports.md F18, F19
#[test]
fn ascii_stl_is_read_by_words_not_lines() {
    let plain = ascii("\n");
    let facet_per_line =
        plain.replace("loop\n", "loop ").replace("1\nouter", "1 outer").replace("\nendloop", " endloop");
    for text in [
        plain.clone(),
        plain
            .replace("endloop", "end loop")
            .replace("endfacet", "end facet")
            .replace("endsolid", "end solid"),
        plain.replace("endloop", "end\tloop").replace("outer loop", "outer\nloop"),
        plain.replace("outer loop", "outerloop"),
        ascii(" "),
        ascii("\t "),
        ascii("\r"),
        ascii("\r\n\r\n"),
        ascii("\n \t\n"),
        facet_per_line,
        plain.replace("endloop\nendfacet", "endloop endfacet"),
        plain.replace("endfacet\n", "endfacet "),
        plain.to_uppercase(),
        plain.replace("facet", "Facet").replace("vertex", "Vertex").replace("solid", "Solid"),
        format!("\n\n  {plain}"),
        format!("\u{feff}{plain}"),
        plain.replace("0 0 0", "0\n0\n0"),
        plain.replace("facet normal 0 0 1", "facet\nnormal\n0 0 1"),
        plain.replace("facet normal 0 0 1", "facet"),
        plain.replace("normal 0 0 1", "normal nan nan 1.#QNAN"),
        plain.replace("endfacet\n", ""),
        plain.replace("solid part\n", "solid\n"),
        plain.replace("solid part\n", "solid vertex of a facet, end loop\n"),
        plain.replace("0.5", ".5 // the third"),
        plain.replacen("solid part\n", "", 1),
    ] {
        assert_eq!(check(text.as_bytes(), 2), []);
        assert_eq!(MeshFormat::sniff(text.as_bytes()), Some(MeshFormat::Stl), "{text}");
    }
    check(format!("{plain}{plain}").as_bytes(), 4);
    check(format!("{}{}", ascii(" "), ascii(" ")).as_bytes(), 4);
    assert_eq!(check(plain.replace("endsolid part\n", "").as_bytes(), 2).len(), 1);
    assert_eq!(check(b"solid empty\nendsolid empty\n", 0).len(), 0);
}

#[test]
fn errors_in_ascii_stl_give_the_line() {
    let plain = ascii("\n");
    for (text, words) in [
        (plain.replacen("vertex 1 0 0\n", "", 1), &["line 7", "2 vertices"][..]),
        (plain.replacen("endloop", "vertex 9 9 9\nendloop", 1), &["line 9", "4 vertices"]),
        (plain.replace("1 0 0", "1 x 0"), &["line 5", "\"x\" is not a number"]),
        (plain.replacen("endloop", "end of loop", 1), &["line 7", "\"end\""]),
        (plain.replacen("facet normal 0 0 1\n", "", 1), &["line 7", "without a facet"]),
    ] {
        let refusal = read_stl(text.as_bytes()).unwrap_err().to_string();
        assert!(words.iter().all(|w| refusal.contains(w)), "{refusal}");
    }
    let inside = plain.find("vertex 1").unwrap();
    let refusal = read_stl(&plain.as_bytes()[..inside]).unwrap_err().to_string();
    assert!(refusal.contains("inside a facet, after 1"), "{refusal}");
}

fn binary(count: u32, facets: usize, head: &[u8], tail: &[u8]) -> Vec<u8> {
    let floats = [0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 0.5f32];
    let facet: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).chain([0, 0]).collect();
    let mut bytes = head.to_vec();
    bytes.resize(80, b' ');
    bytes.extend(count.to_le_bytes());
    bytes.extend(facet.repeat(facets));
    bytes.extend(tail);
    bytes
}

// reports.md F20
#[test]
fn facets_beyond_the_header_count_are_read_with_a_warning() {
    for (count, head) in [
        (0, &b""[..]),
        (u32::MAX, b""),
        (1, b""),
        (0, b"solid part\nfacet normal"),
        (0, b"s\0o\0l\0i\0d\0"),
        (0, b"\xff\xfes\0"),
    ] {
        let warnings = check(&binary(count, 2, head, b""), 2);
        assert_eq!(warnings, [FileWarning::FacetCount { declared: count as usize, found: 2 }]);
    }
    assert_eq!(check(&binary(0, 2, b"", b"odd"), 2).len(), 2, "count and left-over bytes");
    // A file that is padded, or followed by text, has no more facets than its header declares.
    for tail in [&[0; 50][..], b"MATERIAL=1", &[0xff; 100]] {
        let warnings = check(&binary(2, 2, b"", tail), 2);
        let declared = "2 facets".to_string();
        assert_eq!(warnings, [FileWarning::TrailingBytes { bytes: tail.len(), declared }]);
    }
    assert_eq!(check(&binary(0, 0, b"", b""), 0).len(), 0);
    let refusal = read_stl(&binary(3, 2, b"", b"")).unwrap_err().to_string();
    assert!(refusal.contains("declares 3 facets") && refusal.contains("its count is wrong"), "{refusal}");
}
