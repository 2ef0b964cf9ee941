//! Bytes to meshes, all operations on meshes, and back to bytes in every format.

use eikona_mesh::io::{Encoding, MeshFile, MeshFormat, MeshOut, read_mesh_bytes, write_mesh_bytes};
use eikona_mesh::{
    Orientation, Quality, Topology, TriangleMesh, drop_broken_polygons, drop_degenerate_faces,
    drop_duplicate_faces, drop_unreferenced_vertices, orient, split_nonmanifold_vertices, validate, weld,
    weld_polygons,
};
use std::hint::black_box;

const FORMATS: [MeshFormat; 7] = [
    MeshFormat::Obj,
    MeshFormat::Ply,
    MeshFormat::Stl,
    MeshFormat::Off,
    MeshFormat::Glb,
    MeshFormat::Gltf,
    MeshFormat::Vtp,
];

/// Reads the bytes; whatever can be read must survive all operations on it.
///
/// # Panics
/// If our own output cannot be read again or has lost vertices or faces, or a repair makes an
/// invalid mesh.
pub fn check(bytes: &[u8], format: MeshFormat) {
    black_box(MeshFormat::sniff(bytes));
    let file = match read_mesh_bytes(bytes, format) {
        Ok(file) => file,
        Err(fault) => {
            assert!(!fault.to_string().is_empty());
            return;
        }
    };
    for target in FORMATS {
        for encoding in [Encoding::Binary, Encoding::Ascii] {
            let mut out = MeshOut::from(&file);
            out.encoding = encoding;
            check_written(&out, target, file.mesh.vertex_count(), file.mesh.face_count());
        }
    }
    black_box(weld_polygons(&file.mesh, 0.0).map(|r| r.provenance.dropped_faces()).ok());
    if let Ok((mesh, _)) = file.mesh.triangulate() {
        check_mesh(&mesh);
    }
    let sound = drop_broken_polygons(&file.mesh).mesh;
    if file.mesh.positions.iter().flatten().all(|x| x.is_finite()) {
        let (mesh, _) = sound.triangulate().expect("valid polygons make a mesh");
        check_mesh(&mesh);
    }
}

/// A format must return everything that it accepts.
fn check_written(out: &MeshOut, format: MeshFormat, vertices: usize, faces: usize) {
    let mut bytes = Vec::new();
    if write_mesh_bytes(&mut bytes, format, out).is_err() {
        return;
    }
    if format == MeshFormat::Obj && vertices == 0 {
        return; // an OBJ file without vertices is refused on purpose: any text would pass for one
    }
    let again: MeshFile = match read_mesh_bytes(&bytes, format) {
        Ok(file) => file,
        Err(fault) => {
            panic!("our own {format:?} cannot be read: {fault}\n{}", String::from_utf8_lossy(&bytes))
        }
    };
    assert_eq!(again.mesh.face_count(), faces, "faces of {format:?} {:?}", out.encoding);
    if format != MeshFormat::Stl {
        assert_eq!(again.mesh.vertex_count(), vertices, "vertices of {format:?} {:?}", out.encoding);
    }
}

fn check_mesh(mesh: &TriangleMesh) {
    black_box((Topology::of(mesh), Quality::of(mesh), validate(mesh)));
    let orientation = Orientation::of(mesh);
    if orientation.is_orientable() {
        let turned = orient(mesh).mesh;
        assert!(Orientation::of(&turned).flipped_faces().is_empty(), "orienting twice flips faces again");
    }
    let size = mesh.positions().iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    for tolerance in [0.0, 1e-6 * size, 0.3 * size, size, f64::MAX, f64::MIN_POSITIVE] {
        if let Ok(welded) = weld(mesh, tolerance) {
            assert!(welded.provenance.dropped_vertices().is_empty(), "welding merges vertices");
            black_box(drop_unreferenced_vertices(&welded.mesh).mesh);
        }
    }
    black_box((drop_degenerate_faces(mesh), drop_duplicate_faces(mesh)));
    if let Ok(split) = split_nonmanifold_vertices(mesh) {
        assert_eq!(split.mesh.face_count(), mesh.face_count());
        assert!(
            Topology::of(&split.mesh).nonmanifold_vertices.is_empty(),
            "a vertex is still nonmanifold after splitting"
        );
    }
}
