//! Times, accuracy and iterations of the fractional inner product.
//!
//! ```sh
//! cargo run --release -p eikona --example metric            # separations 0.3 to 1
//! cargo run --release -p eikona --example metric -- 0.5 400000 2   # one, faces at most, threads
//! ```

use eikona::mesh::{TriangleMesh, VertexField, shapes};
use eikona::repulsive::{EnergyOptions, Metric, MetricOptions, tangent_point_energy};
use std::time::Instant;

fn main() {
    let mut arguments =
        std::env::args().skip(1).map(|word| word.parse::<f64>().expect("a number is expected"));
    let separations = arguments.next().map_or(vec![0.3, 0.4, 0.5, 0.6, 0.8, 1.0], |one| vec![one]);
    let most = arguments.next().unwrap_or(25_000.0) as usize;
    let threads = arguments.next().unwrap_or(1.0) as usize;
    let mut meshes: Vec<(String, TriangleMesh)> = Vec::new();
    for level in 3..=7 {
        meshes.push((format!("sphere {level}"), shapes::icosphere(level).expect("the size is valid")));
    }
    for times in [2, 4, 8] {
        let rings = shapes::linked_rings(2, 0.3, 28 * times, 11 * times).expect("the sizes are valid");
        meshes.push((format!("linked rings {times}"), rings));
    }
    for (name, mesh) in meshes.into_iter().filter(|(_, mesh)| mesh.face_count() <= most) {
        let energy = tangent_point_energy(&mesh, &EnergyOptions::default()).expect("it is finite");
        let positions: VertexField<[f64; 3]> = mesh.positions().to_vec().into();
        for &separation in &separations {
            let options = MetricOptions::default().with_separation(separation).with_threads(threads);
            let start = Instant::now();
            let metric = Metric::new(&mesh, &options).expect("it is finite");
            let built = start.elapsed().as_secs_f64();
            let image = metric.product(&positions).expect("nothing stops it");
            let multiplied = start.elapsed().as_secs_f64();
            let square: f64 =
                image.iter().map(|(v, y)| (0..3).map(|k| y[k] * positions[v][k]).sum::<f64>()).sum();
            let solution =
                metric.solve(std::slice::from_ref(&energy.differential)).expect("nothing stops it");
            let solved = start.elapsed().as_secs_f64();
            println!(
                "{name:>14} {:>7} faces, {separation:.2}: built {built:.3} s, product {:.4} s, solve {:.3} s, {} iterations to {:.1e}, <x,Ax> {square:.6}",
                mesh.face_count(),
                multiplied - built,
                solved - multiplied,
                solution.iterations,
                solution.change,
            );
        }
    }
}
