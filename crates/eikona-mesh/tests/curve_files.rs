//! Curve files: round trips, errors, and the published files of signed-heat-demo and SWN on their
//! meshes.

use eikona_mesh::{
    Curve, CurveFile, CurveFormat, CurveKind, FileWarning, PolygonMesh, SpacePolyline, SurfaceCurves,
    SurfacePoint, TriangleMesh, curves_from_lines, format_curves, read_curves, read_curves_bytes,
    write_curves, write_curves_json,
};
use std::path::{Path, PathBuf};

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");

/// Two triangles on the unit square: edges 01, 12, 20, 23, 30.
fn square() -> TriangleMesh {
    let positions = vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
    TriangleMesh::new(positions, vec![[0, 1, 2], [0, 2, 3]]).unwrap()
}

fn vertex(vertex: u32) -> SurfacePoint {
    SurfacePoint::Vertex { vertex }
}

fn sample() -> CurveFile {
    let middle = SurfacePoint::Edge { vertices: [2, 0], t: 0.1 + 0.2 };
    let inside = SurfacePoint::Face { vertices: [0, 1, 2], bary: [0.2, 0.3, 0.5] };
    CurveFile {
        curves: SurfaceCurves {
            curves: vec![
                Curve::signed([vertex(1), inside, middle, vertex(3)]),
                Curve::signed([vertex(0), vertex(1), vertex(2), vertex(0)]),
            ],
            points: Vec::new(),
        },
        ..Default::default()
    }
}

fn syntax_error(text: &str, format: CurveFormat) -> String {
    read_curves_bytes(text.as_bytes(), format, &square()).unwrap_err().to_string()
}

#[test]
fn json_is_lossless() {
    let mut file = sample();
    file.curves.curves[0].up = Some([0.0, 0.0, -1.0]);
    file.curves.curves[1].kind = CurveKind::Unsigned;
    file.curves.points.push(vertex(2));
    let points = vec![[0.1, 1.0 / 3.0, 5e-324], [1e300, -0.0, 2.0]];
    file.polylines.push(SpacePolyline { kind: CurveKind::Signed, closed: true, points });
    let text = format_curves(&file, CurveFormat::Json, &square()).unwrap();
    assert_eq!(read_curves_bytes(text.as_bytes(), CurveFormat::Json, &square()).unwrap(), file);
}

#[test]
fn files_are_written_completely_and_detected_by_content() {
    let folder = std::env::temp_dir().join(format!("eikona-curves-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let (mesh, file) = (square(), sample());
    for (name, format) in [("a.txt", CurveFormat::SignedHeatDemo), ("b.txt", CurveFormat::SurfaceWinding)] {
        let path = folder.join(name);
        write_curves(&path, &file, format, &mesh).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(CurveFormat::detect(&path, &bytes), format);
        let back = read_curves(&path, &mesh).unwrap();
        // The formats identify an edge by its number, so its endpoints come back in the edge's own
        // order.
        let located = |c: &SurfaceCurves| c.segments(&mesh).unwrap();
        for (a, b) in located(&back.curves).iter().zip(located(&file.curves)) {
            for k in 0..2 {
                let (p, q) = (a.ends[k].position(&mesh), b.ends[k].position(&mesh));
                assert!((0..3).all(|i| (p[i] - q[i]).abs() < 1e-15), "{p:?} {q:?}");
            }
        }
        assert_eq!(back.curves.segment_count(), 6);
        assert!(back.curves.curves[1].is_closed() && !back.curves.curves[0].is_closed());
    }
    let path = folder.join("c.json");
    write_curves_json(&path, &file, &mesh).unwrap();
    assert_eq!(read_curves(&path, &mesh).unwrap(), file);
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 3, "no temporary file remains");
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn obj_lines_are_polylines_in_space_or_curves_on_the_mesh() {
    let mesh = square();
    let text = format_curves(&sample(), CurveFormat::Obj, &mesh).unwrap();
    let back = read_curves_bytes(text.as_bytes(), CurveFormat::Obj, &mesh).unwrap();
    assert_eq!(back.polylines.len(), 2);
    assert_eq!((back.polylines[0].points.len(), back.polylines[0].closed), (4, false));
    assert_eq!((back.polylines[1].points.len(), back.polylines[1].closed), (3, true));

    let own = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\nl 1/1 2/2\nl -2 -3\nl 3 4\n";
    let file = read_curves_bytes(own.as_bytes(), CurveFormat::Obj, &mesh).unwrap();
    assert_eq!(file.curves.curves, [Curve::signed([0, 1, 2, 3].map(vertex))]);
    assert_eq!(file.warnings.len(), 1, "one line was reversed: {:?}", file.warnings);
    assert_eq!(curves_from_lines(&[vec![0, 1, 2], vec![3]], &mesh).unwrap().curves.points, [vertex(3)]);
    assert!(curves_from_lines(&[vec![0, 9]], &mesh).unwrap_err().to_string().contains("vertex 9"));
}

#[test]
fn a_file_without_curves_survives_obj() {
    // Found by fuzzing.
    let text = format_curves(&CurveFile::default(), CurveFormat::Obj, &square()).unwrap();
    let back = read_curves_bytes(text.as_bytes(), CurveFormat::Obj, &square()).unwrap();
    assert!(back.curves.is_empty() && back.polylines.is_empty());
    assert_eq!(back.warnings.len(), 1);
}

#[test]
fn obj_curves_and_meshes_share_their_syntax() {
    // reports.md F23
    let expected = [SpacePolyline {
        kind: CurveKind::Signed,
        closed: false,
        points: vec![[0., 0., 9.], [2., 1., 9.], [1., 1., 9.]],
    }];
    let path = Path::new("c.obj");
    for text in [
        "v 0 0 9\rv 2 1 9\rv 1 1 9\rl 1 2 3\r",
        "v 0 0 9\nv 2 1 9\nv 1 1 9\nl 1 2 \\\n3\n",
        "v 0 \\\r\n0 9\r\nv 2 1 9\r\nv 1 1 9\r\nl 1 2 3",
        "\u{feff}# a\nv 0 0 9 # b\nv 2 1 9\nv 1 1 9\nl 1 2 3 # note\n",
        "l 1 2 3\nv 0 0 9\nv 2 1 9\nv 1 1 9\n",
        "v 0 0 9\nv 2 1 9\nv 1 1 9\nl 1.0 2.0 3.0\n",
        "v 0 0 9\nv 2 1 9\nv 1 1 9\nl -3/1 -2/2 -1/3\n",
        "v 0 0 9\nv 2 1 9\nv 1 1 9\nl 1 1 2 2 2 3\nl 3 3\n",
    ] {
        assert_eq!(CurveFormat::detect(path, text.as_bytes()), CurveFormat::Obj, "{text:?}");
        let file = read_curves_bytes(text.as_bytes(), CurveFormat::Obj, &square()).unwrap();
        assert_eq!(file.polylines, expected, "{text:?}");
    }
}

#[test]
fn lines_on_unreferenced_vertices_are_polylines_in_space() {
    // reports.md F9: vertices 4 to 7 belong to a curve object in the mesh's own file.
    let mut positions = square().positions().to_vec();
    let own = [[0.5, 0., 0.], [0.5, 1., 0.], [0.2, 0.2, 0.], [0.4, 0.2, 0.]];
    positions.extend(own);
    let mesh = TriangleMesh::new(positions, square().triangles().to_vec()).unwrap();
    let read = |lines: &[&[u32]]| {
        let lines: Vec<Vec<u32>> = lines.iter().map(|line| line.to_vec()).collect();
        curves_from_lines(&lines, &mesh).unwrap()
    };
    let file = read(&[&[0, 1, 2], &[4, 5], &[0, 4, 6], &[5, 6, 7, 5], &[3], &[7]]);
    assert_eq!(file.curves.curves, [Curve::signed([0, 1, 2].map(vertex))]);
    assert_eq!(file.curves.points, [vertex(3)]);
    let points: Vec<_> = file.polylines.iter().map(|p| (p.closed, p.points.clone())).collect();
    let corner = mesh.positions()[0];
    let expected =
        [(false, vec![corner, own[0], own[2]]), (true, own[1..].to_vec()), (false, own[..2].to_vec())];
    assert_eq!(points, expected);
    assert_eq!(file.warnings, [FileWarning::SkippedPoints { count: 1 }]);
}

#[test]
fn repeated_closing_points_are_all_dropped_at_once() {
    // Found by fuzzing: each write and read removed one more point.
    let loop_of_obj = b"v 0 0 9\nv 2 1 9\nv 1 1 9\nl 1 2 3 1 1\nl 2 2 2\n";
    let read = read_curves_bytes(loop_of_obj, CurveFormat::Obj, &square()).unwrap();
    assert_eq!(read.polylines[0].points, [[0., 0., 9.], [2., 1., 9.], [1., 1., 9.]]);
    assert!(read.polylines[0].closed);
    for format in [CurveFormat::Json, CurveFormat::Obj] {
        let text = format_curves(&read, format, &square()).unwrap();
        let again = read_curves_bytes(text.as_bytes(), format, &square()).unwrap();
        assert_eq!(again.polylines, read.polylines, "{text}");
    }
}

#[test]
fn swn_segments_are_joined_by_position_and_comments_leave_gaps() {
    let text = "#offset 0\nv 0\nv 1\nv 1\nv 2\nl 0 1\n#l 9 9\nn\nl 2 3\nv 3\nl 4 0\n";
    let file = read_curves_bytes(text.as_bytes(), CurveFormat::SurfaceWinding, &square()).unwrap();
    let nodes: Vec<_> = file.curves.curves.iter().map(|c| c.nodes.clone()).collect();
    assert_eq!(nodes, [vec![vertex(3), vertex(0), vertex(1), vertex(2)]]);
    let from_one = read_curves_bytes(b"v 1\nv 2\nl 1 2\n", CurveFormat::SurfaceWinding, &square()).unwrap();
    assert_eq!(from_one.curves.curves[0].nodes, [vertex(0), vertex(1)]);
}

#[test]
fn flag_1_reverses_a_curve_of_signed_heat_demo() {
    let text = "# comment\nsigned_curve 1\nl 1 2 3\nunsigned_curve\nv 0\nf 0 0.25 0.25\nunsigned_point\nv 3\nsigned_curve\n";
    let file = read_curves_bytes(text.as_bytes(), CurveFormat::SignedHeatDemo, &square()).unwrap();
    assert_eq!(file.curves.curves[0].nodes, [vertex(2), vertex(1), vertex(0)]);
    assert_eq!(file.curves.curves[1].kind, CurveKind::Unsigned);
    assert_eq!(file.curves.points, [vertex(3)]);
    let inside = file.curves.curves[1].nodes[1].locate(&square()).unwrap();
    assert_eq!(inside.position(&square()), [0.75, 0.5, 0.0]);
    assert_eq!(file.warnings.len(), 1, "the empty block is skipped: {:?}", file.warnings);
}

#[test]
fn errors_give_line_value_and_remedy() {
    use CurveFormat::*;
    for (format, text, parts) in [
        (SignedHeatDemo, "signed_curve\nv 4\n", ["line 2", "vertex 4", "numbered from 0"]),
        (SignedHeatDemo, "signed_curve\nl 1 0\n", ["line 2", "vertex 0", "numbered from 1"]),
        (SignedHeatDemo, "signed_curve\ne 1 1.5\n", ["line 2", "1.5", "[0, 1]"]),
        (SignedHeatDemo, "signed_curve\nf 0 NaN 0\n", ["line 2", "NaN", "finite"]),
        (SignedHeatDemo, "v 0\n", ["line 1", "precedes the first block", "signed_curve"]),
        (SignedHeatDemo, "signed_curve 2\n", ["line 1", "\"2\"", "expected 1"]),
        (SurfaceWinding, "v 0\n", ["line 1", "vertex 0", "numbered from 1"]),
        (SurfaceWinding, "#offset 0\nv 0\nl 0 1\n", ["line 3", "node 1", "#offset"]),
        (SurfaceWinding, "v 1\nl 1\n", ["line 2", "node index", "add it"]),
        (SurfaceWinding, "v 99999999999999999999\n", ["line 1", "99999999999999999999", "integer"]),
        (SurfaceWinding, "v -9223372036854775808\n", ["line 1", "-9223372036854775808", "does not exist"]),
        (Obj, "v 0 0 0\nl 1 2\n", ["line 2", "vertex 2", "(1 to 1)"]),
        (Json, "{\"eikona\":\"curves\",\"version\":1,\n\"curvs\":[]}", ["line 2", "curvs", "polylines"]),
        (Json, "{\"eikona\":\"curves\",\"version\":2}", ["version 2", "\"version\": 1", "newer"]),
        (
            Json,
            "{\"eikona\":\"curves\",\"version\":1,\"curves\":[{\"nodes\":[{\"vertex\":0},\n{\"edge\":[1,3],\"t\":0.5}]}]}",
            ["line 2 (curve 0, node 1)", "vertices 1 and 3", "correct it"],
        ),
        (
            Json,
            "{\"eikona\":\"curves\",\"version\":1,\"points\":[{\"vertx\":0}]}",
            ["line 1", "vertx", "`vertex`"],
        ),
        (
            Json,
            "{\"eikona\":\"curves\",\"version\":1,\n\"points\":[{\"edge\":[0,1]}]}",
            ["line 2", "\"edge\": [i, j]", "\"t\": t"],
        ),
        (
            Json,
            "{\"eikona\":\"curves\",\"version\":1,\"curves\":[{\"nodes\":[]}]}",
            ["curve 0", "0 node", "2"],
        ),
    ] {
        let message = syntax_error(text, format);
        for part in parts {
            assert!(message.contains(part), "{text:?}: {message:?} does not contain {part:?}");
        }
    }
}

#[test]
fn formats_reject_what_they_can_not_hold() {
    let mesh = square();
    let mut file = sample();
    file.curves.points.push(vertex(0));
    assert!(format_curves(&file, CurveFormat::SurfaceWinding, &mesh).is_err());
    file.polylines.push(SpacePolyline { points: vec![[0.0; 3], [f64::NAN; 3]], ..Default::default() });
    for format in [CurveFormat::Json, CurveFormat::Obj, CurveFormat::SignedHeatDemo] {
        assert!(format_curves(&file, format, &mesh).is_err());
    }
}

/// Every prefix of valid files, and every single damaged byte, is read or gives an error, never a
/// panic.
#[test]
fn damaged_files_give_errors() {
    let mesh = square();
    let mut tried = 0;
    for format in
        [CurveFormat::Json, CurveFormat::Obj, CurveFormat::SignedHeatDemo, CurveFormat::SurfaceWinding]
    {
        let text = format_curves(&sample(), format, &mesh).unwrap().into_bytes();
        for end in 0..text.len() {
            let _ = read_curves_bytes(&text[..end], format, &mesh);
            for byte in *b"-9 {e\n\xff" {
                let mut damaged = text.clone();
                damaged[end] = byte;
                let _ = read_curves_bytes(&damaged, format, &mesh);
                tried += 1;
            }
        }
    }
    assert!(tried > 1000);
}

/// Reads vertices and faces of an OBJ file, just enough for the host meshes.
fn host_mesh(path: &Path) -> TriangleMesh {
    let text = String::from_utf8_lossy(&std::fs::read(path).unwrap()).into_owned();
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words.first() {
            Some(&"v") => positions.push([1, 2, 3].map(|k| words[k].parse::<f64>().unwrap())),
            Some(&"f") => faces.push(
                words[1..].iter().map(|w| w.split('/').next().unwrap().parse::<u32>().unwrap() - 1).collect(),
            ),
            _ => {}
        }
    }
    let mut mesh = PolygonMesh::new(positions);
    faces.into_iter().for_each(|f: Vec<u32>| mesh.push_face(f));
    mesh.triangulate().unwrap().0
}

#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn the_published_curve_files_lie_on_their_meshes() {
    // File, mesh, signed and unsigned curves, points, segments (from data/MANIFEST.md), closed
    // curves.
    let files = [
        ("shm/block-points", "badquality/block", 0, 0, 9, 0),
        ("shm/bumpy-sphere", "curves/shm/bumpy-sphere", 32, 0, 0, 341),
        ("shm/cactus", "curves/shm/cactus", 3, 0, 0, 291),
        ("shm/fish-unsigned", "curves/shm/fish-unsigned", 0, 2, 1, 28),
        ("shm/hemisphere-point", "boundary/hemisphere", 0, 0, 1, 0),
        ("shm/mobius-orientable-curve", "nonorientable/mobius-orientable-curve", 3, 0, 0, 306),
        ("shm/polygon-bear", "polygon/polygon-bear", 8, 0, 0, 90),
        ("shm/screwdriver", "nonmanifold/screwdriver", 5, 0, 0, 287),
        ("swn/annulus", "curves/swn/annulus", 0, 0, 0, 193),
        ("swn/asymmetric-torus", "curves/swn/asymmetric-torus", 0, 0, 0, 112),
        ("swn/bunny-brokenheart", "closed/bunny", 0, 0, 0, 92),
        ("swn/bunny-heart", "closed/bunny", 0, 0, 0, 97),
        ("swn/double-torus", "closed/double-torus", 0, 0, 0, 90),
        ("swn/spots-on-spot", "curves/swn/spots-on-spot", 0, 0, 0, 260),
        ("swn/torus-phi", "curves/swn/torus", 0, 0, 0, 88),
    ];
    let mut run = 0;
    for (name, host, signed, unsigned, points, segments) in files {
        let path = PathBuf::from(DATA).join(format!("curves/{name}.txt"));
        run += 1;
        let mesh = host_mesh(&PathBuf::from(DATA).join(format!("{host}.obj")));
        let file = read_curves(&path, &mesh).unwrap();
        assert_eq!(file.curves.segment_count(), segments, "{name}");
        let located = file.curves.segments(&mesh).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(located.len(), segments, "{name}");
        let count = |kind| file.curves.curves.iter().filter(|c| c.kind == kind).count();
        let closed = file.curves.curves.iter().filter(|c| c.is_closed()).count();
        println!(
            "{name}: {} curves, {closed} closed, {segments} segments, {} warnings",
            file.curves.curves.len(),
            file.warnings.len()
        );
        if name.starts_with("shm") {
            assert_eq!((count(CurveKind::Signed), count(CurveKind::Unsigned)), (signed, unsigned), "{name}");
        }
        assert_eq!(file.curves.points.len(), points, "{name}");
        for format in [CurveFormat::Json, CurveFormat::SignedHeatDemo, CurveFormat::SurfaceWinding] {
            let Ok(text) = format_curves(&file, format, &mesh) else { continue };
            let back = read_curves_bytes(text.as_bytes(), format, &mesh).unwrap();
            assert_eq!(back.curves.segment_count(), segments, "{name}, {format:?}");
            assert_eq!(back.curves.segments(&mesh).unwrap().len(), segments, "{name}, {format:?}");
        }
        match name {
            "swn/bunny-heart" => assert_eq!((file.curves.curves.len(), closed), (1, 1)),
            "swn/bunny-brokenheart" => assert_eq!(closed, 0),
            "swn/asymmetric-torus" => assert_eq!(closed, file.curves.curves.len()),
            _ => {}
        }
    }
    println!("{run} curve files ran on their meshes");
}
