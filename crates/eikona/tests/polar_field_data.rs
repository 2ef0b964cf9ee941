//! Automatic fields on all surfaces of the data folder, if it exists.

use eikona::mesh::{Topology, TriangleMesh, io, weld};
use eikona::polar_field::{AutomaticOptions, FieldOptions, PolarFieldError, Solver, SolverOptions};
use std::path::{Path, PathBuf};

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");

/// Larger files take long in tests.
const MOST_FACES: usize = 60_000;

/// Mesh files below a folder, sorted.
fn files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut entries: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    entries.sort();
    let mut found = Vec::new();
    for path in entries {
        let name = path.to_string_lossy().to_ascii_lowercase();
        if path.is_dir() {
            found.extend(files(&path));
        } else if [".obj", ".ply", ".off", ".stl"].iter().any(|end| name.ends_with(end)) {
            found.push(path);
        }
    }
    found
}

fn load(path: &Path) -> Option<TriangleMesh> {
    let mesh = io::read_mesh(path).ok()?.mesh.triangulate().ok()?.0;
    let is_stl = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("stl"));
    if is_stl { weld(&mesh, 0.0).ok().map(|w| w.mesh) } else { Some(mesh) }
}

#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn automatic_indices_add_up_on_every_surface_that_has_fields() {
    let (mut solved, mut refused) = (0, 0);
    let mut worst = [0.0f64; 2];
    for path in files(Path::new(DATA)) {
        let name = path.strip_prefix(DATA).unwrap_or(&path).display().to_string();
        let Some(mesh) = load(&path).filter(|mesh| (1..MOST_FACES).contains(&mesh.face_count())) else {
            continue;
        };
        let topology = Topology::of(&mesh);
        let solver = match Solver::new(&mesh, &SolverOptions::default()) {
            Ok(solver) => solver,
            Err(PolarFieldError::FlatFace { .. }) => {
                refused += 1;
                continue;
            }
            Err(fault) => {
                let has_fields = topology.is_manifold() && topology.is_orientable();
                assert!(!has_fields, "{name}: {fault}");
                refused += 1;
                continue;
            }
        };
        for degree in [1, 4] {
            let found = solver.automatic(&AutomaticOptions::default().with_degree(degree)).unwrap();
            let sum: f64 = found.singularities.iter().map(|s| s.index).sum();
            let chi: i64 = topology.components.iter().map(|c| c.euler_characteristic).sum();
            assert!((sum - chi as f64).abs() < 1e-6, "{name}, N = {degree}: {sum} instead of {chi}");
            let options =
                FieldOptions::default().with_degree(degree).with_generators(found.generators.clone());
            let field = solver.solve(&found.singularities, &options);
            let report = field.unwrap_or_else(|fault| panic!("{name}, N = {degree}: {fault}")).report;
            worst = [worst[0].max(report.residual), worst[1].max(report.closure)];
        }
        solved += 1;
    }
    println!(
        "{solved} surfaces solved for N = 1 and 4, {refused} refused; largest residual and closure {worst:?}"
    );
    assert!(solved >= 40, "only {solved} surfaces of the data folder have fields");
    assert!(worst.iter().all(|x| *x < 1e-8), "{worst:?}");
}
