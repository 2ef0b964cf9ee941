//! Errors of the signed distance to broken curves with known truth, for the defaults and for
//! explicit options. The table is the basis of the rules of `LevelSets::Automatic` and
//! `DiffusionTime::Automatic` (SHM section 9.5.3).
//!
//! ```sh
//! cargo run -p eikona --example broken_curves                    # five functions on each surface
//! cargo run -p eikona --example broken_curves -- 2 1000          # two functions, another seed
//! cargo run -p eikona --example broken_curves -- 5 1 torus       # surfaces named "..torus.."
//! ```
//!
//! Numbers are percentages of the range of the truth and of the area. `study.rs` describes the
//! curves and their truth.

mod breaking;
mod study;
mod surfaces;
mod truth;

use eikona::mesh::TriangleMesh;
use eikona::signed_heat::{DiffusionTime, LevelSets, SolveOptions, Solver, SolverOptions};
use study::{Arguments, DAMAGES, Errors, visit_cases};
use truth::{Fine, error, vertex_areas};

const AUTO: DiffusionTime = DiffusionTime::Automatic;
const T1: DiffusionTime = DiffusionTime::Coefficient(1.0);
const T3: DiffusionTime = DiffusionTime::Coefficient(3.0);
const T10: DiffusionTime = DiffusionTime::Coefficient(10.0);

/// Columns of the table; the first is the default.
const METHODS: [(DiffusionTime, LevelSets); 12] = [
    (AUTO, LevelSets::Automatic),
    (T1, LevelSets::Automatic),
    (T3, LevelSets::Automatic),
    (T10, LevelSets::Automatic),
    (T1, LevelSets::Zero),
    (T1, LevelSets::Free),
    (T3, LevelSets::Free),
    (T3, LevelSets::PerComponent),
    (T3, LevelSets::Soft(3.0)),
    (T3, LevelSets::Soft(10.0)),
    (T3, LevelSets::Soft(100.0)),
    (AUTO, LevelSets::Zero),
];

/// Errors per damage and method.
type Table = Vec<Vec<Errors>>;

fn main() {
    let arguments = Arguments::read(5);
    let mut table: Table = vec![vec![Errors::default(); METHODS.len()]; DAMAGES.len()];
    let surfaces = arguments.surfaces();
    for (name, mesh) in &surfaces {
        eprintln!("{name}: {} faces", mesh.face_count());
        measure(mesh, &arguments, &mut table);
    }
    let sphere = surfaces.iter().find(|(name, _)| name.starts_with("geodesic"));
    if let Some((_, sphere)) = sphere {
        println!("error of the truth on a circle of the sphere: {:.3} %", 100.0 * error_of_truth(sphere));
    }
    print(&table);
}

fn measure(mesh: &TriangleMesh, arguments: &Arguments, table: &mut Table) {
    let solvers = [AUTO, T1, T3, T10].map(|time| {
        let options = SolverOptions::default().with_time(time);
        (time, Solver::new(mesh, &options).unwrap())
    });
    visit_cases(mesh, arguments, |case| {
        for ((time, level_sets), errors) in METHODS.into_iter().zip(&mut table[case.damage]) {
            let solver = &solvers.iter().find(|(t, _)| *t == time).unwrap().1;
            let options = SolveOptions::default().with_level_sets(level_sets);
            let solution = solver.solve(&case.source, &options).unwrap();
            errors.0.push(case.error(solution.distance.as_slice()));
        }
    });
}

/// Returns the error of the truth, in the same measure, where there is a closed form: a circle of
/// latitude on the unit sphere.
fn error_of_truth(sphere: &TriangleMesh) -> f64 {
    let height: Vec<f64> = sphere.positions().iter().map(|p| p[2]).collect();
    let found = Fine::new(sphere).distance(&height, 0.3 + 1e-9);
    let exact: Vec<f64> = height.iter().map(|z| z.clamp(-1.0, 1.0).asin() - 0.3f64.asin()).collect();
    error(&vertex_areas(sphere), &exact, &found, false).rms
}

fn print(table: &Table) {
    for (m, (time, level_sets)) in METHODS.iter().enumerate() {
        println!("{m:4}: {time:?}, {level_sets:?}");
    }
    let columns: [(&str, fn(&Errors) -> f64); 4] = [
        ("root mean square, mean", |errors| errors.mean(|e| e.rms)),
        ("root mean square, worst", |errors| errors.worst(|e| e.rms)),
        ("area on the wrong side, mean", |errors| errors.mean(|e| e.wrong)),
        ("area on the wrong side, worst", |errors| errors.worst(|e| e.wrong)),
    ];
    for (title, of) in columns {
        let numbers: String = (0..METHODS.len()).map(|m| format!("{m:7}")).collect();
        println!("\n{title:30}{numbers}");
        for (damage, row) in DAMAGES.iter().zip(table).filter(|(_, row)| !row[0].0.is_empty()) {
            let values: String = row.iter().map(|errors| format!("{:7.2}", of(errors))).collect();
            println!("{:30}{values}", format!("{damage:?}"));
        }
    }
}
