//! The same polygon through all readers.

use super::*;
use eikona_mesh::io::{MeshFormat, read_mesh_bytes};

// reports.md F2
#[test]
fn an_l_has_area_3_in_every_format_with_polygons() {
    let obj = "v 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nv 0 0 0\nf 1 2 3 4 5 6\n";
    let numbers = "2 0 0\n2 1 0\n1 1 0\n1 2 0\n0 2 0\n0 0 0\n";
    let off = format!("OFF\n6 1 0\n{numbers}6 0 1 2 3 4 5\n");
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n{numbers}6 0 1 2 3 4 5\n"
    );
    let vtp = format!(
        r#"<?xml version="1.0"?>
<VTKFile type="PolyData" version="0.1" byte_order="LittleEndian"><PolyData>
<Piece NumberOfPoints="6" NumberOfPolys="1">
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">{numbers}</DataArray></Points>
<Polys><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2 3 4 5</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">6</DataArray></Polys>
</Piece></PolyData></VTKFile>"#
    );
    for (text, format) in [
        (obj, MeshFormat::Obj),
        (off.as_str(), MeshFormat::Off),
        (ply.as_str(), MeshFormat::Ply),
        (vtp.as_str(), MeshFormat::Vtp),
    ] {
        let file = read_mesh_bytes(text.as_bytes(), format).unwrap_or_else(|e| panic!("{format:?}: {e}"));
        covered(&file.mesh, 4, 3.0);
    }
}
