//! VTP files as VTK and other programs write them, and names that VTK can read.

use super::{triangle_cube, written};
use crate::FileWarning;
use crate::io::*;

/// Returns two triangles, with these arrays at points and cells.
fn vtp(points: &str, cells: &str) -> String {
    format!(
        r#"<?xml version="1.0"?><VTKFile type="PolyData" version="0.1" byte_order="LittleEndian"><PolyData>
        <Piece NumberOfPoints="4" NumberOfPolys="2"><PointData>{points}</PointData><CellData>{cells}</CellData>
        <Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 1 1 0 0 1 0</DataArray></Points>
        <Polys><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 0 2 3</DataArray>
        <DataArray type="Int64" Name="offsets" format="ascii">3 6</DataArray></Polys></Piece></PolyData></VTKFile>"#
    )
}

fn array(name: &str, values: &str) -> String {
    format!(r#"<DataArray type="Float64" Name="{name}" format="ascii">{values}</DataArray>"#)
}

fn check(text: &str) -> MeshFile {
    let file = read_vtp(text.as_bytes()).unwrap_or_else(|fault| panic!("{fault}\n{text}"));
    assert_eq!(file.mesh.positions, [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]], "{text}");
    assert!(file.mesh.faces().eq([[0, 1, 2], [0, 2, 3]]), "{text}");
    file
}

// reports.md F12
#[test]
fn attributes_may_be_padded_with_blanks() {
    let plain = vtp("", "");
    let mut padded = plain.clone();
    for value in
        ["PolyData", "LittleEndian", "4", "Float64", "Int64", "ascii", "connectivity", "offsets", "2"]
    {
        padded = padded.replace(&format!("\"{value}\""), &format!("\"  {value} \""));
    }
    assert_eq!(check(&padded).warnings, []);
    let appended = |offset: &str, encoding: &str| {
        let array = plain.find("<DataArray").unwrap()..plain.find("</Points>").unwrap();
        let data: Vec<u8> =
            [0., 0., 0., 1., 0., 0., 1., 1., 0., 0., 1., 0f64].iter().flat_map(|x| x.to_le_bytes()).collect();
        let mut text = plain.clone().into_bytes();
        let tail =
            [format!("<AppendedData encoding=\"{encoding}\"> _").as_bytes(), &96u32.to_le_bytes(), &data]
                .concat();
        text.truncate(text.len() - "</VTKFile>".len());
        let points = format!("<DataArray type=\"Float64\" format=\"appended\" offset=\"{offset}\"/>");
        text.splice(array, points.into_bytes());
        [text, tail, b"</AppendedData></VTKFile>".to_vec()].concat()
    };
    for (offset, encoding) in [("0", "raw"), ("       0", "raw"), ("0     ", " raw "), ("\n0\t", "raw")] {
        let file = read_vtp(&appended(offset, encoding)).unwrap();
        assert_eq!(file.mesh.positions[2], [1., 1., 0.], "\"{offset}\" \"{encoding}\"");
    }
    for (offset, words) in
        [("x", "its offset is \"x\""), ("", "its offset is \"\""), ("500", "offset 500 is past")]
    {
        let refusal = read_vtp(&appended(offset, "raw")).unwrap_err().to_string();
        assert!(refusal.contains(words), "{refusal}");
    }
}

#[test]
fn comments_and_keys_inside_arrays_are_ignored() {
    for comment in [
        "<!-- a 9 -->",
        "<?note 9?>",
        "<InformationKey name=\"L2\"><Value index=\"0\">9</Value></InformationKey>",
    ] {
        let text = vtp(&array("h", &format!("1 2{comment}3 4")), "");
        assert_eq!(check(&text).vertex_scalars, [("h".to_string(), vec![1., 2., 3., 4.])], "{comment}");
        check(&vtp("", "").replace("\"ascii\">0", &format!("\"ascii\">{comment}0")));
        check(&vtp("", "").replace("1 1 0", &format!("1{comment} 1 0")));
    }
    let cube = triangle_cube();
    let text = String::from_utf8(written(MeshFormat::Vtp, &MeshOut::from(&cube))).unwrap();
    let commented = text.replace("format=\"binary\">\n", "format=\"binary\"><!-- base64 -->\n");
    assert_eq!(read_vtp(commented.as_bytes()).unwrap(), read_vtp(text.as_bytes()).unwrap());
}

#[test]
fn arrays_with_the_same_name_are_all_read() {
    let twice = array("h", "1 2 3 4") + &array("h", "5 6 7 8") + &array("h_2", "0 0 0 0");
    let file = check(&vtp(&twice, &(array("h", "1 2") + &array("h", "3 4"))));
    let names: Vec<(&str, f64)> = file.vertex_scalars.iter().map(|(n, v)| (n.as_str(), v[0])).collect();
    assert_eq!(names, [("h", 1.0), ("h_2", 5.0), ("h_2_2", 0.0)]);
    assert_eq!(file.face_scalars[1], ("h_2".to_string(), vec![3.0, 4.0]));
    assert_eq!(file.warnings.len(), 3, "{:?}", file.warnings);
    let vectors = array("v_0", "9 9 9 9") + &array("v", "1 2 3 4 5 6 7 8");
    let names: Vec<String> = check(&vtp(&vectors, "")).vertex_scalars.into_iter().map(|s| s.0).collect();
    assert_eq!(names, ["v_0", "v_0_2", "v_1"]);
}

// reports.md F24
#[test]
fn bit_arrays_are_read_and_unsupported_arrays_are_ignored() {
    // As VTK 9.7 writes the bits 0 1 0 1: the highest bit of a byte comes first.
    let bits = r#"<DataArray type="Bit" Name="mask" format="binary">AQAAAFQ=</DataArray>"#;
    let expected = [("mask".to_string(), vec![0., 1., 0., 1.])];
    let file = check(&vtp(bits, ""));
    assert_eq!((file.vertex_scalars.as_slice(), file.warnings.len()), (&expected[..], 0));
    let ascii = r#"<DataArray type="Bit" Name="mask" format="ascii">0 1 0 1</DataArray>"#;
    assert_eq!(check(&vtp(ascii, "")).vertex_scalars, expected);
    let pairs = bits.replace("type=", "NumberOfComponents=\"2\" type=");
    let file = check(&vtp("", &pairs));
    assert_eq!(
        file.face_scalars,
        [("mask_0".to_string(), vec![0., 0.]), ("mask_1".to_string(), vec![1., 1.])]
    );
    for (unread, words) in [
        (
            r#"<DataArray type="Float16" Name="a" format="binary">AQAAAFQ=</DataArray>"#,
            "of \"PointData\" were ignored: a (its type is Float16)",
        ),
        (
            r#"<Array type="String" Name="tags" format="ascii">116 0</Array>"#,
            "of \"PointData\" were ignored: tags (its type is String)",
        ),
        (
            r#"<DataArray type="String" Name="tags" format="ascii">116 0</DataArray>"#,
            "of \"PointData\" were ignored: tags (its type is String)",
        ),
        (
            r#"<DataArray type="Float64" Name="b" format="ascii">1 2 3</DataArray>"#,
            "of \"PointData\" were ignored: b (it has 3 values for 4 elements)",
        ),
    ] {
        let file = check(&vtp(&(unread.to_string() + &array("h", "1 2 3 4")), ""));
        assert_eq!(file.vertex_scalars, [("h".to_string(), vec![1., 2., 3., 4.])], "{unread}");
        assert!(
            file.warnings.len() == 1 && file.warnings[0].to_string().contains(words),
            "{:?}",
            file.warnings
        );
    }
    // Points are required: without them there is no mesh.
    let refusal = read_vtp(
        vtp("", "")
            .replace("Float64\" NumberOf", "Float16\" NumberOf")
            .replace("ascii\">0 0", "binary\">AQAA")
            .as_bytes(),
    );
    assert!(refusal.is_err());
}

#[test]
fn counts_that_differ_from_the_arrays_give_a_warning() {
    let file = check(&vtp("", "").replace("NumberOfPolys=\"2\"", "NumberOfPolys=\"3\" NumberOfLines=\"1\""));
    assert_eq!(
        file.warnings,
        [
            FileWarning::CellCount { cells: "Lines", declared: "1".into(), found: 0 },
            FileWarning::CellCount { cells: "Polys", declared: "3".into(), found: 2 },
        ]
    );
}

/// VTK numbers cells by vertices, lines, polygons, strips: VTK 9.7 wrote this file with `id` as the
/// cell number.
#[test]
fn cell_values_belong_to_polygons_before_strips() {
    let cells = |tag: &str, connectivity: &str, end: usize| {
        format!(
            r#"<{tag}><DataArray type="Int64" Name="connectivity" format="ascii">{connectivity}</DataArray>
            <DataArray type="Int64" Name="offsets" format="ascii">{end}</DataArray></{tag}>"#
        )
    };
    let text = format!(
        r#"<VTKFile type="PolyData" version="0.1"><PolyData><Piece NumberOfPoints="6" NumberOfVerts="1" NumberOfLines="1"
        NumberOfStrips="1" NumberOfPolys="1"><CellData>{}</CellData><Points><DataArray type="Float32" NumberOfComponents="3"
        format="ascii">0 0 0 1 0 0 1 1 0 0 1 0 2 0 0 2 1 0</DataArray></Points>{}{}{}{}</Piece></PolyData></VTKFile>"#,
        array("id", "0 1 2 3"),
        cells("Verts", "4", 1),
        cells("Lines", "0 2", 2),
        cells("Strips", "1 4 2 5", 4),
        cells("Polys", "0 1 2 3", 4),
    );
    let file = read_vtp(text.as_bytes()).unwrap();
    assert!(file.mesh.faces().eq([&[0, 1, 2, 3][..], &[1, 4, 2], &[2, 4, 5]]));
    assert_eq!(file.face_scalars, [("id".to_string(), vec![2., 3., 3.])]);
}

// reports.md F13
#[test]
fn names_are_written_so_that_xml_and_vtk_can_read_them() {
    let cube = triangle_cube();
    let values = [0.5; 8];
    for (name, in_file) in [
        ("a > b", "a &gt; b"),
        ("a < b & c", "a &lt; b &amp; c"),
        ("\"a\" 'b'", "&quot;a&quot; &apos;b&apos;"),
        ("a]]>b-->", "a]]&gt;b--&gt;"),
        ("a\tb\nc\u{1}\u{85}\u{ffff}", "a_b_c___"),
        ("gr\u{f6}\u{df}e \u{4e2d}", "gr\u{f6}\u{df}e \u{4e2d}"),
    ] {
        let mut out = MeshOut::from(&cube);
        out.vertex_scalars = vec![(name, &values)];
        let faces = [1.0; 12];
        out.face_scalars = vec![(name, &faces)];
        let text = String::from_utf8(written(MeshFormat::Vtp, &out)).unwrap();
        assert!(text.contains(&format!(r#"<PointData Scalars="{in_file}">"#)), "{text}");
        assert_eq!(text.matches(&format!(r#"Name="{in_file}""#)).count(), 2, "{text}");
        let read = read_vtp(text.as_bytes()).unwrap();
        let plain: String =
            name.chars().map(|c| if c.is_control() || c == '\u{ffff}' { '_' } else { c }).collect();
        assert_eq!((&read.vertex_scalars[0].0, &read.face_scalars[0].0), (&plain, &plain));
    }
}

#[test]
fn xml_in_latin_1_is_read_if_declared() {
    let text = vtp(&array("gr\u{f6}\u{df}e", "1 2 3 4"), "");
    let latin = |text: &str| text.chars().map(|c| c as u8).collect::<Vec<u8>>();
    let declared = text.replace("version=\"1.0\"?", "version=\"1.0\" encoding=\"iso-8859-1\"?");
    assert_eq!(read_vtp(&latin(&declared)).unwrap().vertex_scalars[0].0, "gr\u{f6}\u{df}e");
    assert!(read_vtp(&latin(&text)).unwrap_err().to_string().contains("not UTF-8"));
}
