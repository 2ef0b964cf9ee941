//! Every surface in the developers' data folder, checked against the counts in its manifest; 0
//! files if the folder does not exist.

use crate::io::{MeshFormat, read_mesh};
use std::collections::HashSet;
use std::path::PathBuf;
use std::time::Instant;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");

/// Returns path, V and F of the manifest rows that describe a surface.
fn surfaces() -> Vec<(String, usize, usize)> {
    let manifest = std::fs::read_to_string(PathBuf::from(DATA).join("MANIFEST.md")).unwrap_or_default();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let name = *cells.get(1)?;
        MeshFormat::from_path(name)?;
        let faces = cells.get(5)?.split(' ').next()?; // may continue: "1034 (sides 3..11)"
        Some((name.to_string(), cells.get(4)?.parse().ok()?, faces.parse().ok()?))
    };
    manifest.lines().filter_map(row).collect()
}

#[test]
fn every_surface_has_the_counts_of_the_manifest() {
    let surfaces = surfaces();
    let mut wrong = Vec::new();
    for (name, vertices, faces) in &surfaces {
        let start = Instant::now();
        let file = match read_mesh(PathBuf::from(DATA).join(name)) {
            Ok(file) => file,
            Err(fault) => {
                wrong.push(format!("{name}: {fault}"));
                continue;
            }
        };
        let seconds = start.elapsed().as_secs_f64();
        if seconds > 0.2 {
            println!("{name}: {seconds:.3} s");
        }
        let mut found = file.mesh.vertex_count();
        if MeshFormat::from_path(name) == Some(MeshFormat::Stl) {
            assert_eq!(found, 3 * faces, "{name}");
            // The manifest counts positions, where 0 and -0 are equal.
            let distinct: HashSet<[u64; 3]> =
                file.mesh.positions.iter().map(|p| p.map(|x| (x + 0.0).to_bits())).collect();
            found = distinct.len();
        }
        if (found, file.mesh.face_count()) != (*vertices, *faces) {
            wrong.push(format!(
                "{name}: V {found}, F {}; expected {vertices}, {faces}",
                file.mesh.face_count()
            ));
        }
    }
    println!("ran {} files", surfaces.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(surfaces.is_empty() || surfaces.len() == 86, "{} surfaces in the manifest", surfaces.len());
}

#[test]
fn spot_is_the_same_in_ply_and_obj() {
    let folder = PathBuf::from(DATA).join("closed");
    if !folder.is_dir() {
        return println!("ran 0 files");
    }
    let ply = read_mesh(folder.join("spot.ply")).unwrap().mesh;
    let obj = read_mesh(folder.join("spot.obj")).unwrap().mesh;
    assert!(ply.faces().eq(obj.faces()));
    for (p, o) in ply.positions.iter().flatten().zip(obj.positions.iter().flatten()) {
        assert_eq!(*p as f32, *o as f32);
    }
    println!("ran 2 files");
}

#[test]
fn lines_of_obj_files_are_kept() {
    let path = PathBuf::from(DATA).join("soup/chair.obj");
    if !path.is_file() {
        return println!("ran 0 files");
    }
    let file = read_mesh(path).unwrap();
    assert_eq!(file.lines.len(), 164);
    println!("ran 1 file");
}
