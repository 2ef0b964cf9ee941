//! Measures time and memory of the signed heat method on a sphere of 100,000 faces, on one thread,
//! one case per process: `cargo run -p eikona --example constraint_times -- CASE [PIECES
//! [COEFFICIENT]]`, where CASE is `free`, `zero`, `levels`, `soft` or `normals`.

use eikona::contour::plane_cut;
use eikona::mesh::{Curve, SurfaceCurves, TriangleMesh, shapes};
use eikona::signed_heat::{DiffusionTime, LevelSets, SolveOptions, Solver, SolverOptions};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let case = arguments.first().map_or("free", String::as_str);
    let pieces: usize = arguments.get(1).map_or(Ok(1), |n| n.parse())?;
    let level_sets = match case {
        "zero" => LevelSets::Zero,
        "levels" => LevelSets::PerComponent,
        "soft" => LevelSets::Soft(100.0),
        _ => LevelSets::Free,
    };
    let mesh = shapes::geodesic_sphere(71)?;
    let source = parallels(&mesh, pieces)?;
    println!("{case}: {} faces, {} pieces of curves", mesh.face_count(), source.curves.len());
    let coefficient: f64 = arguments.get(2).map_or(Ok(1.0), |t| t.parse())?;
    let time = DiffusionTime::Coefficient(coefficient);
    let solver = Solver::new(&mesh, &SolverOptions::default().with_time(time))?;
    let options =
        SolveOptions::default().with_level_sets(level_sets).with_preserve_source_normals(case == "normals");
    let report = solver.solve(&source, &options)?.report;
    for (phase, duration) in report.preparation.phases.0.iter().chain(&report.phases.0) {
        println!("  {phase:14} {:8.1} ms", duration.as_secs_f64() * 1e3);
    }
    println!("  residuals {:.1e} {:.1e}", report.diffusion_residual, report.integration_residual);
    println!("  normals {:?}", report.normal_constraints);
    println!("  constraint violation {:?}", report.constraint_violation);
    if let Ok(status) = std::fs::read_to_string("/proc/self/status") {
        status.lines().filter(|line| line.starts_with("VmHWM")).for_each(|line| println!("  {line}"));
    }
    Ok(())
}

/// Returns parallels of the sphere with the south on their left, cut into this many pieces with
/// gaps between them; one piece is a full circle.
fn parallels(mesh: &TriangleMesh, pieces: usize) -> Result<SurfaceCurves, Box<dyn std::error::Error>> {
    let circles = pieces.div_ceil(100);
    let mut curves = Vec::new();
    for i in 0..circles {
        let z = 0.3 - 0.9 * i as f64 / circles as f64;
        let circle = plane_cut(mesh, [0.0, 0.0, z], [0.0, 0.0, 1.0])?.remove(0);
        if pieces == 1 {
            curves.push(circle);
            continue;
        }
        let length = circle.nodes.len() * circles / pieces;
        curves.extend(
            circle
                .nodes
                .chunks(length.max(3))
                .map(|c| Curve::signed(c[..c.len().max(2) - 1].iter().copied())),
        );
    }
    curves.retain(|c| c.nodes.len() > 1);
    Ok(SurfaceCurves { curves, points: Vec::new() })
}
