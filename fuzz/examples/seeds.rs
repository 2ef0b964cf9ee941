//! Writes the seeds of the fuzz targets: tiny files from our own writers. `cargo run --example
//! seeds` in `fuzz/`. The seeds whose name begins with `odd-` are not written here: they are files
//! as other programs write them.

use eikona_mesh::io::{Encoding, MeshFormat, MeshOut, write_mesh_bytes};
use eikona_mesh::{
    Curve, CurveFile, CurveFormat, PolygonMesh, SpacePolyline, SurfaceCurves, SurfacePoint, TriangleMesh,
    Vertex, format_curves,
};
use std::error::Error;
use std::fs;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("seeds");
    for format in ["obj", "ply", "stl", "off", "gltf", "vtp"] {
        fs::create_dir_all(root.join(format!("read_{format}")))?;
    }
    let positions = vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.5], [0., 1., -0.25], [2., 2., 2.]];
    let triangles = TriangleMesh::new(positions.clone(), vec![[0, 1, 2], [0, 2, 3], [1, 0, 4]])?;
    let mut polygons = PolygonMesh::new(positions);
    polygons.push_face([0, 1, 2, 3]);
    polygons.push_face([1, 0, 4]);
    let scalar = [0.0, 0.5, -0.5, f64::NAN, 1e-3];
    let of_face = [1.0, 2.0, 3.0];
    let colours = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [9, 9, 9], [0, 0, 0]];
    let lines = vec![vec![0, 2], vec![3, 4, 1]];
    use MeshFormat::{Glb, Gltf, Obj, Off, Ply, Stl, Vtp};
    for (format, folder, extension) in [
        (Obj, "read_obj", "obj"),
        (Ply, "read_ply", "ply"),
        (Stl, "read_stl", "stl"),
        (Off, "read_off", "off"),
        (Glb, "read_gltf", "glb"),
        (Gltf, "read_gltf", "gltf"),
        (Vtp, "read_vtp", "vtp"),
    ] {
        for (encoding, name) in [(Encoding::Binary, "binary"), (Encoding::Ascii, "ascii")] {
            if encoding == Encoding::Ascii && !matches!(format, Ply | Stl) {
                continue; // these formats leave no choice
            }
            let mut plain = MeshOut::from(&polygons);
            plain.encoding = encoding;
            let mut full = MeshOut::from(&triangles);
            full.encoding = encoding;
            full.vertex_scalars = vec![("distance", &scalar)];
            full.face_scalars = vec![("part", &of_face)];
            full.vertex_colours = Some(&colours);
            full.lines = &lines;
            for (what, out) in [("polygons", plain), ("full", full)] {
                let mut bytes = Vec::new();
                if write_mesh_bytes(&mut bytes, format, &out).is_ok() {
                    fs::write(root.join(folder).join(format!("{what}-{name}.{extension}")), bytes)?;
                }
            }
        }
    }
    write_choice_seeds(&root.join("solve"))?;
    write_choice_seeds(&root.join("winding"))?;
    write_choice_seeds(&root.join("polar_field"))?;
    write_curve_seeds(&root.join("curves"))
}

/// Bytes enough for a mesh with curves; the choices they stand for are any (SplitMix64).
fn write_choice_seeds(folder: &Path) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    let mut state = 0u64;
    for i in 0..12 {
        let bytes: Vec<u8> = std::iter::repeat_with(|| {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = state;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            (z ^ (z >> 31)).to_le_bytes()
        })
        .take(50)
        .flatten()
        .collect();
        fs::write(folder.join(format!("choices-{i}")), bytes)?;
    }
    Ok(())
}

/// Curves on the bent sheet of the target `curves`: vertices 0 to 11 in rows of four.
fn write_curve_seeds(folder: &Path) -> Result<(), Box<dyn Error>> {
    fs::create_dir_all(folder)?;
    let mesh = eikona_fuzz::curves::mesh();
    let edge = SurfacePoint::Edge { vertices: [0, 5], t: 0.25 };
    let face = SurfacePoint::Face { vertices: [1, 2, 6], bary: [0.25, 0.25, 0.5] };
    let on_surface = CurveFile {
        curves: SurfaceCurves {
            curves: vec![
                Curve::signed([0, 1, 6, 5, 0].map(Vertex)),
                Curve { up: None, ..Curve::signed([edge, Vertex(1).into(), face]) },
            ],
            points: Vec::new(),
        },
        ..CurveFile::default()
    };
    let mut mixed = on_surface.clone();
    mixed.curves.curves.push(Curve::unsigned([Vertex(12), Vertex(13)]));
    mixed.curves.points.push(face);
    let polyline =
        SpacePolyline { points: vec![[0., 0., 1.], [2.5, 1.5, 1.], [9., 0., 1.]], ..Default::default() };
    let in_space = CurveFile { polylines: vec![polyline], ..CurveFile::default() };
    for (what, file) in [("surface", &on_surface), ("mixed", &mixed), ("space", &in_space)] {
        for (format, extension) in [
            (CurveFormat::Json, "json"),
            (CurveFormat::Obj, "obj"),
            (CurveFormat::SignedHeatDemo, "demo.txt"),
            (CurveFormat::SurfaceWinding, "winding.txt"),
        ] {
            if let Ok(text) = format_curves(file, format, mesh) {
                fs::write(folder.join(format!("{what}.{extension}")), text)?;
            }
        }
    }
    Ok(())
}
