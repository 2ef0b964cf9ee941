//! How long reading and writing large files takes: `cargo test --release -p eikona-mesh io::tests::speed -- --ignored --nocapture`.

use super::written;
use crate::io::*;
use crate::polygon::PolygonMesh;
use std::time::Instant;

/// A square of 2 n^2 triangles with a bump.
fn bump(n: u32) -> PolygonMesh {
    let at = |i: u32| f64::from(i) / f64::from(n);
    let positions = (0..=n)
        .flat_map(|i| (0..=n).map(move |j| [at(i), at(j), (at(i) * 7.0).sin() * (at(j) * 5.0).cos()]))
        .collect();
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let v = i * (n + 1) + j;
            faces.extend([[v, v + n + 1, v + n + 2], [v, v + n + 2, v + 1]]);
        }
    }
    PolygonMesh::from_triangles(positions, &faces)
}

#[test]
#[ignore = "a measurement"]
fn a_million_triangles() {
    let mesh = bump(708);
    println!("{} vertices, {} triangles", mesh.vertex_count(), mesh.face_count());
    for (format, encoding) in [
        (MeshFormat::Ply, Encoding::Binary),
        (MeshFormat::Ply, Encoding::Ascii),
        (MeshFormat::Obj, Encoding::Ascii),
        (MeshFormat::Off, Encoding::Ascii),
        (MeshFormat::Stl, Encoding::Binary),
        (MeshFormat::Stl, Encoding::Ascii),
        (MeshFormat::Glb, Encoding::Binary),
        (MeshFormat::Vtp, Encoding::Binary),
    ] {
        let mut out = MeshOut::from(&mesh);
        out.encoding = encoding;
        let start = Instant::now();
        let bytes = written(format, &out);
        let writing = start.elapsed().as_secs_f64();
        let mut reading = f64::INFINITY;
        for _ in 0..3 {
            let start = Instant::now();
            assert_eq!(read_mesh_bytes(&bytes, format).unwrap().mesh.face_count(), mesh.face_count());
            reading = reading.min(start.elapsed().as_secs_f64());
        }
        let megabytes = bytes.len() as f64 / 1e6;
        println!("{format:?} {encoding:?}: {megabytes:.1} MB, read {reading:.3} s, written {writing:.3} s");
    }
}
