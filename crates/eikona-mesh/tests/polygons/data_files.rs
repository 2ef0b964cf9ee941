//! Every mesh file in the data folder that contains polygons.

use super::*;
use eikona_mesh::PolygonQuality;
use eikona_mesh::io::{MeshFormat, read_mesh};
use std::path::{Path, PathBuf};

fn files_below(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            files_below(&path, files);
        } else if MeshFormat::from_path(&path).is_some() {
            files.push(path);
        }
    }
}

#[test]
fn triangle_areas_in_the_data_folder_sum_to_polygon_areas() {
    let mut files = Vec::new();
    files_below(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")), &mut files);
    files.sort();
    let (mut ran, mut polygons, mut planar) = (0, 0, 0);
    for path in files {
        let Ok(file) = read_mesh(&path) else { continue };
        let mesh = file.mesh;
        if mesh.is_triangular() || mesh.face_count() == 0 {
            continue;
        }
        let parts = triangles_of(&mesh).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let quality = PolygonQuality::of(&mesh);
        ran += 1;
        println!(
            "{}: {} polygons, {} nonconvex, {} nonplanar, {} crossing, {} collinear",
            path.file_name().unwrap().display(),
            mesh.face_count(),
            quality.nonconvex.len(),
            quality.nonplanar.len(),
            quality.self_crossing.len(),
            quality.collinear.len()
        );
        for (f, triangles) in parts.iter().enumerate() {
            let place = format!("{} face {f}", path.display());
            let corners = corners_of(&mesh, f);
            assert_eq!(triangles.len(), corners.len() - 2, "{place}");
            polygons += usize::from(corners.len() > 3);
            let face = Face(f as u32);
            if quality.nonplanar.contains(&face) || quality.self_crossing.contains(&face) {
                continue;
            }
            planar += usize::from(corners.len() > 3);
            let area = norm(area_vector(&corners));
            let sum: f64 =
                triangles.iter().map(|t| norm(area_vector(&t.map(|v| mesh.positions[v as usize])))).sum();
            assert!((sum - area).abs() <= 1e-4 * area, "{place}: {sum} instead of {area}");
        }
    }
    println!("{ran} files with {polygons} polygons ran, {planar} of them planar");
}
