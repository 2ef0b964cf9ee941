//! Tests of the file formats, and their helper shapes.

mod data_folder;
mod detection;
mod features;
mod malformed;
mod odd_gltf;
mod odd_off;
mod odd_stl;
mod odd_text;
mod odd_vtp;
mod round_trips;
mod rounding;

use super::{MeshFormat, MeshOut, write_mesh_bytes};
use crate::mesh::TriangleMesh;
use crate::polygon::PolygonMesh;

/// Returns the positions of a cube with awkward coordinates: none of them is exact in 32 bits.
fn cube_positions() -> Vec<[f64; 3]> {
    (0..8).map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 1 { 0.1 + k as f64 } else { -1.0 / 3.0 })).collect()
}

const QUADS: [[u32; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

fn triangle_cube() -> TriangleMesh {
    let faces = QUADS.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh::new(cube_positions(), faces).unwrap()
}

/// Returns the cube with one quad cut into two triangles and one corner cut off: triangles, quads
/// and a pentagon.
fn polygon_cube() -> PolygonMesh {
    let mut mesh = PolygonMesh::new(cube_positions());
    mesh.positions.push([0.5, 0.25, -0.125]);
    mesh.push_face([0, 2, 3]);
    mesh.push_face([0, 3, 1]);
    for quad in &QUADS[1..5] {
        mesh.push_face(*quad);
    }
    mesh.push_face([1, 3, 8, 7, 5]);
    mesh
}

fn written(format: MeshFormat, mesh: &MeshOut) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_mesh_bytes(&mut bytes, format, mesh).unwrap();
    bytes
}

/// A separate folder in the system's temporary folder, removed at the end.
struct Folder(std::path::PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("eikona-io-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Folder(path)
    }
    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(&self.0)
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).ok();
    }
}
