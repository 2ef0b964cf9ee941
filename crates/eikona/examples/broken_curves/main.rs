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
//! A curve is a level set of a slowly varying function at a random level. The truth is the exact
//! distance to the undamaged curve, to the given curve itself if that is closed, or to the outline
//! of the union if closed curves cross. For nested curves it is determined up to a constant, since
//! any of them can be the zero. Numbers are percentages of the range of the truth and of the area.

mod breaking;
mod surfaces;
mod truth;

use breaking::{Damage, Whole};
use eikona::geometry::{lay_out, mean_edge_length};
use eikona::mesh::random::Random;
use eikona::mesh::{SurfaceCurves, TriangleMesh};
use eikona::signed_heat::{DiffusionTime, LevelSets, SolveOptions, Solver, SolverOptions};
use truth::{Error, Fine, error, vertex_areas};

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

const DAMAGES: [Damage; 25] = [
    Damage::None,
    Damage::Noise(0.1),
    Damage::Noise(0.3),
    Damage::Noise(1.0),
    Damage::EdgeWalk(None),
    Damage::NestedWhole(0.2),
    Damage::Crossing(0.3),
    Damage::OneGap(0.02),
    Damage::OneGap(0.1),
    Damage::OneGap(0.4),
    Damage::Halved(4.0),
    Damage::Halved(10.0),
    Damage::Halved(20.0),
    Damage::EdgeWalk(Some(8.0)),
    Damage::HalvedNoise(8.0, 0.3),
    Damage::HalvedNoise(8.0, 1.0),
    Damage::Displaced(6.0, 0.5),
    Damage::Displaced(10.0, 1.0),
    Damage::WithOffset(8.0, 1.5),
    Damage::WithOffsets(8.0, 1.0),
    Damage::WithOffsets(8.0, 2.0),
    Damage::WithOffsets(8.0, 4.0),
    Damage::WalkAndStrips(8.0, 2),
    Damage::Outliers(6.0, 5.0),
    Damage::Nested(8.0, 0.2),
];

/// Errors of one method on curves with one kind of damage.
#[derive(Clone, Default)]
struct Cell(Vec<Error>);

impl Cell {
    fn mean(&self, of: fn(&Error) -> f64) -> f64 {
        100.0 * self.0.iter().map(of).sum::<f64>() / self.0.len() as f64
    }
    fn worst(&self, of: fn(&Error) -> f64) -> f64 {
        100.0 * self.0.iter().map(of).fold(0.0, f64::max)
    }
}

type Table = Vec<Vec<Cell>>;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let functions = arguments
        .next()
        .map_or(5, |word| word.parse().expect("the first argument must be the number of functions"));
    let seed = arguments.next().map_or(0, |word| word.parse().expect("the second argument must be a seed"));
    let only = arguments.next().unwrap_or_default();
    let mut table: Table = vec![vec![Cell::default(); METHODS.len()]; DAMAGES.len()];
    let surfaces: Vec<_> =
        surfaces::surfaces().into_iter().filter(|(name, _)| name.contains(&only)).collect();
    for (name, mesh) in &surfaces {
        eprintln!("{name}: {} faces", mesh.face_count());
        measure(mesh, functions, seed, &mut table);
    }
    let sphere = surfaces.iter().find(|(name, _)| name.starts_with("geodesic"));
    if let Some((_, sphere)) = sphere {
        println!("error of the truth on a circle of the sphere: {:.3} %", 100.0 * error_of_truth(sphere));
    }
    print(&table);
}

fn measure(mesh: &TriangleMesh, functions: usize, seed: u64, table: &mut Table) {
    let edge = mean_edge_length(mesh, &lay_out(mesh));
    let areas = vertex_areas(mesh);
    let fine = Fine::new(mesh);
    let solvers = [AUTO, T1, T3, T10].map(|time| {
        let options = SolverOptions::default().with_time(time);
        (time, Solver::new(mesh, &options).unwrap())
    });
    for (k, (_, function)) in surfaces::eigenfunctions(mesh, functions).iter().enumerate() {
        let mut random = Random::from_seed(seed + k as u64);
        let mut sorted = function.clone();
        sorted.sort_by(f64::total_cmp);
        let share = random.range(0.2, 0.8);
        // Slightly off the values at vertices.
        let level = sorted[(share * sorted.len() as f64) as usize] + 1e-9;
        let distance = fine.distance(function, level);
        let whole = Whole { mesh, distance: &distance, edge };
        for (damage, row) in DAMAGES.into_iter().zip(table.iter_mut()) {
            let mut same = random.clone();
            let curves = whole.damaged(damage, &mut random);
            if curves.is_empty() {
                continue;
            }
            let source = SurfaceCurves { curves, points: Vec::new() };
            let own = match whole.union(damage, &mut same.clone()) {
                Some(union) => Some(fine.distance(&union, 0.0)),
                None => {
                    whole.side(damage, &mut same).map(|side| fine.distance_to_curves(mesh, &source, &side))
                }
            };
            let truth = own.as_ref().unwrap_or(&distance);
            let up_to_constant = matches!(damage, Damage::Nested(..) | Damage::NestedWhole(..));
            for ((time, level_sets), cell) in METHODS.into_iter().zip(row) {
                let solver = &solvers.iter().find(|(t, _)| *t == time).unwrap().1;
                let options = SolveOptions::default().with_level_sets(level_sets);
                let solution = solver.solve(&source, &options).unwrap();
                cell.0.push(error(&areas, truth, solution.distance.as_slice(), up_to_constant));
            }
        }
    }
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
    let columns: [(&str, fn(&Cell) -> f64); 4] = [
        ("root mean square, mean", |cell| cell.mean(|e| e.rms)),
        ("root mean square, worst", |cell| cell.worst(|e| e.rms)),
        ("area on the wrong side, mean", |cell| cell.mean(|e| e.wrong)),
        ("area on the wrong side, worst", |cell| cell.worst(|e| e.wrong)),
    ];
    for (title, of) in columns {
        let numbers: String = (0..METHODS.len()).map(|m| format!("{m:7}")).collect();
        println!("\n{title:30}{numbers}");
        for (damage, row) in DAMAGES.iter().zip(table).filter(|(_, row)| !row[0].0.is_empty()) {
            let values: String = row.iter().map(|cell| format!("{:7.2}", of(cell))).collect();
            println!("{:30}{values}", format!("{damage:?}"));
        }
    }
}
