//! Coordinates in formats with 32-bit floats.

use crate::FileWarning;
use crate::io::*;
use crate::mesh::TriangleMesh;

/// Returns a square of 20 by 20 cells of 5 cm with this first corner.
fn patch(corner: [f64; 3]) -> TriangleMesh {
    const N: u32 = 20;
    let at = |v: u32| {
        let (i, j) = (v % (N + 1), v / (N + 1));
        [corner[0] + 0.05 * f64::from(i), corner[1] + 0.05 * f64::from(j), corner[2]]
    };
    let cell = |c: u32| {
        let a = c % N + (c / N) * (N + 1);
        [[a, a + 1, a + N + 2], [a, a + N + 2, a + N + 1]]
    };
    TriangleMesh::new((0..(N + 1) * (N + 1)).map(at).collect(), (0..N * N).flat_map(cell).collect()).unwrap()
}

const UTM: [f64; 3] = [500000.25, 4649776.125, 100.0];

fn round_trip(mesh: &TriangleMesh, format: MeshFormat) -> (MeshFile, Vec<FileWarning>, Vec<u8>) {
    let mut bytes = Vec::new();
    let warnings = write_mesh_bytes(&mut bytes, format, &MeshOut::from(mesh)).unwrap();
    (read_mesh_bytes(&bytes, format).unwrap(), warnings, bytes)
}

fn farthest(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.as_flattened().iter().zip(b.as_flattened()).fold(0.0, |m, (x, y)| f64::max(m, (x - y).abs()))
}

// reports.md F4
#[test]
fn gltf_keeps_an_offset_so_that_utm_coordinates_survive() {
    for corner in [UTM, [-UTM[1], UTM[0], -8e6], [1e15, 0.0, 0.0], [0.0, 0.0, 1e7 + 0.3]] {
        let mesh = patch(corner);
        for format in [MeshFormat::Glb, MeshFormat::Gltf] {
            let (file, warnings, bytes) = round_trip(&mesh, format);
            // Half a unit in the last place of a float of size 1, and of the coordinates
            // themselves.
            let ulp = |x: f64| x.abs().next_up() - x.abs();
            let allowed = 2f64.powi(-25) + corner.iter().map(|&x| ulp(x)).fold(0.0, f64::max);
            let error = farthest(&file.mesh.positions, mesh.positions());
            assert!(error <= allowed, "{corner:?}: {error:e} > {allowed:e}");
            assert_eq!((warnings.len(), file.warnings.len()), (0, 0), "{warnings:?} {:?}", file.warnings);
            assert!(String::from_utf8_lossy(&bytes).contains("\"translation\":["));
        }
    }
    // A mesh near the origin gets no offset: its coordinates are simply rounded.
    for corner in [[0.0; 3], [-0.5, 7.0, 7.0], [f64::from(7.4f32), 0.0, 0.0]] {
        let mesh = patch(corner);
        let (file, _, bytes) = round_trip(&mesh, MeshFormat::Glb);
        assert!(!String::from_utf8_lossy(&bytes).contains("translation"));
        let rounded: Vec<_> = mesh.positions().iter().map(|p| p.map(|x| f64::from(x as f32))).collect();
        assert_eq!(file.mesh.positions, rounded);
    }
    // Without the offset, other programs see the mesh near the origin.
    let (file, _, bytes) = round_trip(&patch(UTM), MeshFormat::Gltf);
    let local = String::from_utf8(bytes).unwrap().replace("\"translation\"", "\"unused\"");
    let local = read_gltf(local.as_bytes()).unwrap().mesh.positions;
    assert!(local.as_flattened().iter().all(|x| x.abs() <= 1.0));
    let (a, b) = (file.mesh.positions[440], local[440]);
    let offset = [0, 1, 2].map(|k| a[k] - b[k]);
    assert!(
        offset.iter().all(|&x| f64::from(x as f32) == x),
        "{offset:?} is exact for programs of 32 bits, too"
    );
}

// reports.md F4
#[test]
fn binary_stl_warns_of_rounded_vertices() {
    let mesh = patch(UTM);
    let (file, warnings, _) = round_trip(&mesh, MeshFormat::Stl);
    // Floats near 4.6e6 are 0.5 apart, so y from .125 to 1.125 in steps of .05 has 3 values; x
    // keeps its 21.
    assert_eq!(warnings.len(), 1);
    for part in [
        "of STL change coordinates by up to 2.",
        "shortest edge is 5.0e-2",
        "378 of 441 positions then coincide",
        "write .ply",
    ] {
        assert!(warnings[0].to_string().contains(part), "{part}: {}", warnings[0]);
    }
    assert!(
        matches!(file.warnings[..], [FileWarning::LostDigits { faces: 720, of: 800, .. }]),
        "{:?}",
        file.warnings
    );
    let mut ascii = MeshOut::from(&mesh);
    ascii.encoding = Encoding::Ascii;
    assert_eq!(write_mesh_bytes(&mut Vec::new(), MeshFormat::Stl, &ascii).unwrap(), []);
    for format in [MeshFormat::Ply, MeshFormat::Obj, MeshFormat::Off, MeshFormat::Vtp] {
        let (file, warnings, _) = round_trip(&mesh, format);
        assert_eq!((file.mesh.positions.as_slice(), warnings.len()), (mesh.positions(), 0));
    }
    for harmless in [[0.0; 3], [1000.0, -1000.0, 0.0]] {
        let (file, warnings, _) = round_trip(&patch(harmless), MeshFormat::Stl);
        assert_eq!((warnings.len(), file.warnings.len()), (0, 0), "{warnings:?}");
    }
}

#[test]
fn gltf_warns_where_an_offset_does_not_help() {
    // Two patches too far apart for their cells.
    let (near, far) = (patch([0.0; 3]), patch([1e7, 0.0, 0.0]));
    let both: Vec<_> = near.positions().iter().chain(far.positions()).copied().collect();
    let shifted = far.triangles().iter().map(|t| t.map(|v| v + 441));
    let mesh = TriangleMesh::new(both, near.triangles().iter().copied().chain(shifted).collect()).unwrap();
    let (_, warnings, _) = round_trip(&mesh, MeshFormat::Glb);
    assert!(warnings.len() == 1 && warnings[0].to_string().contains("floats of GLB change"), "{warnings:?}");
}

#[test]
fn points_without_edges_and_single_points_are_kept_too() {
    use crate::polygon::PolygonMesh;
    for positions in [vec![UTM], vec![UTM; 3], vec![UTM, [UTM[0] + 1.0, UTM[1], UTM[2]]], vec![]] {
        let mesh = PolygonMesh::new(positions.clone());
        let mut bytes = Vec::new();
        assert_eq!(write_mesh_bytes(&mut bytes, MeshFormat::Glb, &MeshOut::from(&mesh)).unwrap().len(), 0);
        assert_eq!(read_gltf(&bytes).unwrap().mesh.positions, positions);
    }
}

#[test]
fn degenerate_faces_alone_do_not_indicate_lost_digits() {
    // Exact doubles, or 32-bit floats of a mesh that is large for its position.
    let text = "v 0 0 0\nv 0 0 0\nv 1 0 0\nv 0.1 1 0\nf 1 2 3\nf 1 3 4\n";
    assert_eq!(read_mesh_bytes(text.as_bytes(), MeshFormat::Obj).unwrap().warnings.len(), 0);
    let far = "v 4649776.1 0 0\nv 4649776.1 0 0\nv 4649777.1 0 0\nf 1 2 3\n";
    assert_eq!(read_mesh_bytes(far.as_bytes(), MeshFormat::Obj).unwrap().warnings.len(), 0);
    let floats = far.replace(".1", ".5");
    assert_eq!(read_mesh_bytes(floats.as_bytes(), MeshFormat::Obj).unwrap().warnings.len(), 1);
}
