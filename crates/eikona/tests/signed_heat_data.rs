//! All surfaces and curves of the data folder, if it exists.

mod exact;

use eikona::contour::plane_cut;
use eikona::curves::trace_curve;
use eikona::signed_heat::{LevelSets, Solution, Solver, SolverOptions};
use eikona_mesh::{Curve, CurveKind, SurfaceCurves, TriangleMesh, Vertex, io, read_curves, weld};
use exact::*;
use std::path::{Path, PathBuf};
use std::time::Instant;

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");

/// Files below a folder with one of these extensions, sorted; none if the folder does not exist.
fn files(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut entries: Vec<PathBuf> = entries.flatten().map(|e| e.path()).collect();
    entries.sort();
    let mut found = Vec::new();
    for path in entries {
        if path.is_dir() {
            found.extend(files(&path, endings));
        } else {
            let name = path.to_string_lossy().to_ascii_lowercase();
            if endings.iter().any(|e| name.ends_with(e)) {
                found.push(path);
            }
        }
    }
    found
}

fn name(path: &Path) -> String {
    path.strip_prefix(DATA).unwrap_or(path).display().to_string()
}

/// Loads the triangles of a file, with coincident vertices of STL files merged.
fn load(path: &Path) -> Result<TriangleMesh, String> {
    let file = io::read_mesh(path).map_err(|e| e.to_string())?;
    let (mesh, _) = file.mesh.triangulate().map_err(|e| e.to_string())?;
    let is_stl = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("stl"));
    if is_stl { weld(&mesh, 0.0).map(|w| w.mesh).map_err(|e| e.to_string()) } else { Ok(mesh) }
}

/// Asserts that NaN values come with a warning, and that the finite values are not all equal.
fn check_values(name: &str, mesh: &TriangleMesh, solution: &Solution) -> (usize, f64) {
    let d = &solution.distance;
    assert_eq!(d.len(), mesh.vertex_count(), "{name}");
    let nan = d.as_slice().iter().filter(|x| x.is_nan()).count();
    assert!(d.as_slice().iter().all(|x| x.is_nan() || x.is_finite()), "{name}: infinite");
    let warned = solution.report.all_warnings().any(|w| w.to_string().contains("is NaN"));
    assert!(nan == 0 || warned, "{name}: {nan} values are NaN without a warning");
    (nan, largest(d.as_slice()))
}

/// Share of the area of the reached faces with a gradient length within a quarter of 1.
fn unit_share(mesh: &TriangleMesh, values: &[f64]) -> f64 {
    let (mut unit, mut total) = (0.0, 0.0);
    for f in mesh.faces() {
        let [a, b, c] = mesh.face_positions(f);
        let [x, y, z] = mesh.face_vertices(f).map(|v| values[v.index()]);
        let normal = cross(sub(b, a), sub(c, a));
        let doubled = norm(normal);
        if doubled == 0.0 || !(x + y + z).is_finite() {
            continue;
        }
        // The gradient rotated by 90 degrees, times twice the area.
        let turned: [f64; 3] = [0, 1, 2].map(|k| x * (c[k] - b[k]) + y * (a[k] - c[k]) + z * (b[k] - a[k]));
        total += doubled;
        if (norm(turned) / doubled - 1.0).abs() < 0.25 {
            unit += doubled;
        }
    }
    unit / total
}

/// The mesh of a curve file, where the file does not name it.
fn host(curve: &str) -> Option<&'static str> {
    Some(match curve {
        "curves/shm/block-points.txt" => "badquality/block.obj",
        "curves/shm/bumpy-sphere.txt" => "curves/shm/bumpy-sphere.obj",
        "curves/shm/cactus.txt" => "curves/shm/cactus.obj",
        "curves/shm/fish-unsigned.txt" => "curves/shm/fish-unsigned.obj",
        "curves/shm/hemisphere-point.txt" => "boundary/hemisphere.obj",
        "curves/shm/mobius-orientable-curve.txt" => "nonorientable/mobius-orientable-curve.obj",
        "curves/shm/polygon-bear.txt" => "polygon/polygon-bear.obj",
        "curves/shm/screwdriver.txt" => "nonmanifold/screwdriver.obj",
        "curves/swn/annulus.txt" => "curves/swn/annulus.obj",
        "curves/swn/asymmetric-torus.txt" => "curves/swn/asymmetric-torus.obj",
        "curves/swn/bunny-brokenheart.txt" | "curves/swn/bunny-heart.txt" => "closed/bunny.obj",
        "curves/swn/double-torus.txt" => "closed/double-torus.obj",
        "curves/swn/spots-on-spot.txt" => "curves/swn/spots-on-spot.obj",
        "curves/swn/torus-phi.txt" => "curves/swn/torus.obj",
        _ => return None,
    })
}

#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn every_curve_file() {
    let mut count = 0;
    for path in files(&Path::new(DATA).join("curves"), &[".txt"]) {
        let curve = name(&path);
        let Some(host) = host(&curve) else {
            println!("{curve}: belongs to a point cloud");
            continue;
        };
        let mesh = load(&Path::new(DATA).join(host)).unwrap();
        let file = read_curves(&path, &mesh).unwrap();
        let mut source = file.curves;
        for curve in &mut source.curves {
            *curve = trace_curve(&mesh, curve).unwrap().curve;
        }
        let solver = Solver::new(&mesh, &SolverOptions::default()).unwrap();
        for level_sets in [LevelSets::Free, LevelSets::Zero] {
            let start = Instant::now();
            let options = levels(level_sets).with_confidence(true);
            let solution = solver.solve(&source, &options).unwrap();
            let (nan, size) = check_values(&curve, &mesh, &solution);
            let values = solution.distance.as_slice();
            let at_nodes: Vec<f64> = source
                .curves
                .iter()
                .flat_map(|c| &c.nodes)
                .chain(&source.points)
                .map(|p| p.locate(&mesh).unwrap().interpolate(&mesh, values))
                .collect();
            let at_vertices = source
                .curves
                .iter()
                .flat_map(|c| &c.nodes)
                .all(|n| matches!(n, eikona_mesh::SurfacePoint::Vertex { .. }));
            let share = unit_share(&mesh, values);
            let on_curve = largest(&at_nodes) / size;
            println!(
                "{curve}, {level_sets:?}: {} faces, {} curves, {} points, {nan} NaN, on the curve {on_curve:.1e}, unit {:.0} %, {:?}",
                mesh.face_count(),
                source.curves.len(),
                source.points.len(),
                100.0 * share,
                start.elapsed()
            );
            assert!(size > 0.0, "{curve}: flat");
            let held = if at_vertices { 1e-6 } else { 5e-3 };
            assert!(level_sets != LevelSets::Zero || on_curve < held, "{curve}: {on_curve:e} on the curve");
            // Loops around a handle and contradictory curves bound no region: no function has a
            // unit gradient then.
            let contradictory =
                ["bumpy-sphere", "asymmetric-torus", "block-points"].iter().any(|n| curve.contains(n));
            assert!(contradictory || share > 0.85, "{curve}: gradient of length 1 on {share} of the area");
            assert!(contradictory || on_curve < 0.25, "{curve}: {on_curve:e} on the curve");
        }
        count += 1;
    }
    println!("{count} curve files run");
    assert_eq!(count, 15);
}

/// A plane cut through the centre of the bounding box; around the first face if the plane misses
/// the mesh.
fn some_source(mesh: &TriangleMesh) -> SurfaceCurves {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in mesh.positions() {
        for k in 0..3 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    let middle = [0, 1, 2].map(|k| 0.5 * (low[k] + high[k]));
    let curves = plane_cut(mesh, middle, [1.0, 0.3, 0.2]).unwrap();
    if !curves.is_empty() {
        return SurfaceCurves { curves, points: Vec::new() };
    }
    let [a, b, c] = mesh.triangles()[0].map(Vertex);
    SurfaceCurves::from_curve(Curve::signed([a, b, c, a]))
}

#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn every_surface_file() {
    let endings = [".obj", ".off", ".ply", ".stl", ".ply.gz", ".glb", ".gltf"];
    let paths = files(Path::new(DATA), &endings);
    let (mut solved, mut refused) = (0, 0);
    for path in &paths {
        let name = name(path);
        if name.contains("dragon_vrip.ply.gz") {
            println!("{name}: skipped, 871,414 faces take too long for a test");
            continue;
        }
        let start = Instant::now();
        let mesh = match load(path) {
            Ok(mesh) => mesh,
            Err(error) => {
                println!("{name}: reading failed: {error}");
                assert!(["face ", "vertex ", "line "].iter().any(|id| error.contains(id)), "{name}: {error}");
                refused += 1;
                continue;
            }
        };
        let solver = match Solver::new(&mesh, &SolverOptions::default().with_threads(2)) {
            Ok(solver) => solver,
            Err(error) => {
                println!("{name}: factoring failed: {error}");
                let text = error.to_string();
                assert!(["face ", "vertex ", "edge "].iter().any(|id| text.contains(id)), "{name}: {text}");
                refused += 1;
                continue;
            }
        };
        let mut source = some_source(&mesh);
        if solved % 3 == 2 {
            source.curves.iter_mut().for_each(|c| c.kind = CurveKind::Unsigned);
        }
        for level_sets in [LevelSets::Free, LevelSets::Zero] {
            match solver.solve(&source, &levels(level_sets)) {
                Ok(solution) => {
                    let (nan, size) = check_values(&name, &mesh, &solution);
                    let share = unit_share(&mesh, solution.distance.as_slice());
                    println!(
                        "{name}, {level_sets:?}: {} faces, {nan} NaN, up to {size:.3e}, unit {:.0} %, {} stages, residuals {:.0e} {:.0e}, {:?}",
                        mesh.face_count(),
                        100.0 * share,
                        solution.report.stages,
                        solution.report.diffusion_residual,
                        solution.report.integration_residual,
                        start.elapsed()
                    );
                }
                Err(error) => {
                    println!("{name}, {level_sets:?}: solving failed: {error}");
                    let text = error.to_string();
                    assert!(
                        ["face ", "vertex ", "edge ", "curve "].iter().any(|id| text.contains(id)),
                        "{name}: {text}"
                    );
                    refused += 1;
                }
            }
        }
        solved += 1;
    }
    println!("{} surface files, {solved} solved, {refused} failures", paths.len());
    assert_eq!(paths.len(), 86);
}
