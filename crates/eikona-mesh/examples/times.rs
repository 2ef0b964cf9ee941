//! Timings for a million triangles on one thread: `cargo run -p eikona-mesh --example times`.

use eikona_mesh::io::{Encoding, MeshFormat, MeshOut, read_mesh_bytes, write_mesh_bytes};
use eikona_mesh::{Orientation, Quality, Topology, damage, shapes, validate, weld};
use std::time::Instant;

fn timed<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let start = Instant::now();
    let result = work();
    println!("{what}: {:.3} s", start.elapsed().as_secs_f64());
    result
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = shapes::geodesic_sphere(224)?;
    println!("{} vertices, {} triangles", mesh.vertex_count(), mesh.face_count());
    for (format, encoding) in [
        (MeshFormat::Ply, Encoding::Binary),
        (MeshFormat::Ply, Encoding::Ascii),
        (MeshFormat::Obj, Encoding::Ascii),
        (MeshFormat::Off, Encoding::Ascii),
        (MeshFormat::Stl, Encoding::Binary),
        (MeshFormat::Glb, Encoding::Binary),
        (MeshFormat::Vtp, Encoding::Binary),
    ] {
        let mut out = MeshOut::from(&mesh);
        out.encoding = encoding;
        let mut bytes = Vec::new();
        timed(&format!("write {format:?} {encoding:?}"), || write_mesh_bytes(&mut bytes, format, &out))?;
        timed(&format!("read {format:?} {encoding:?}"), || read_mesh_bytes(&bytes, format))?;
    }
    let loose = damage::unweld(&mesh)?.mesh;
    timed("weld", || weld(&loose, 0.0))?;
    timed("topology", || Topology::of(&mesh));
    timed("orientation", || Orientation::of(&mesh));
    timed("quality", || Quality::of(&mesh));
    timed("validate", || validate(&mesh));
    Ok(())
}
