//! Accuracy and time of the hierarchical tangent-point energy against the sum over all pairs.
//!
//! ```sh
//! cargo run --release -p eikona --example tangent_point                # separations 0.25 to 0.7
//! cargo run --release -p eikona --example tangent_point -- 0.5 400000  # one, and faces at most
//! ```

use eikona::mesh::{TriangleMesh, shapes};
use eikona::repulsive::{EnergyOptions, Pairs, tangent_point_energy};
use std::time::Instant;

fn main() {
    let mut arguments =
        std::env::args().skip(1).map(|word| word.parse::<f64>().expect("a number is expected"));
    let separations = arguments.next().map_or(vec![0.7, 0.6, 0.5, 0.4, 0.3, 0.25, 0.2], |one| vec![one]);
    let most = arguments.next().unwrap_or(25_000.0) as usize;
    let mut meshes: Vec<(String, TriangleMesh)> = Vec::new();
    for level in 2..=7 {
        meshes.push((format!("sphere {level}"), shapes::icosphere(level).expect("the size is valid")));
    }
    for times in [1, 2, 4, 8] {
        let rings = shapes::linked_rings(2, 0.3, 28 * times, 11 * times).expect("the sizes are valid");
        meshes.push((format!("linked rings {times}"), rings));
    }
    for (name, mesh) in meshes.into_iter().filter(|(_, mesh)| mesh.face_count() <= most) {
        let options = EnergyOptions::default();
        // All pairs of 80,000 faces take a minute, of 330,000 a quarter of an hour.
        let exact = (mesh.face_count() < 100_000).then(|| {
            tangent_point_energy(&mesh, &options.with_pairs(Pairs::All).with_threads(2))
                .expect("it is finite")
        });
        for &separation in &separations {
            let options = options.with_separation(separation);
            let start = Instant::now();
            let found = tangent_point_energy(&mesh, &options).expect("it is finite");
            let time = start.elapsed().as_secs_f64();
            print!("{name:>14} {:>7} faces, {separation:.2}: {:.4} s", mesh.face_count(), time);
            if let Some(exact) = &exact {
                let off = found.value / exact.value - 1.0;
                let gradients = [found.differential.as_slice(), exact.differential.as_slice()];
                let apart: f64 = gradients[0]
                    .iter()
                    .flatten()
                    .zip(gradients[1].iter().flatten())
                    .map(|(a, b)| (a - b).powi(2))
                    .sum();
                let apart = apart.sqrt() / exact.gradient_norm();
                let longer = found.gradient_norm() / exact.gradient_norm() - 1.0;
                print!(
                    ", energy {:+.4} %, norm of gradient {:+.4} %, gradient {:.4} %",
                    100.0 * off,
                    100.0 * longer,
                    100.0 * apart
                );
            }
            println!();
        }
    }
}
