//! How the discrete tangent-point energy converges to that of a smooth surface (RS figure 10):
//! orders in the longest edge h, and of the sum over clusters in their separation.
//!
//! ```sh
//! cargo run --release -p eikona --example consistency        # up to 24,576 faces, 20 s
//! cargo run --release -p eikona --example consistency -- 5   # up to 98,304 faces
//! ```
//!
//! Unlike in the paper, meshes are those of a lattice and are not remeshed. The limit of the
//! perturbed torus is extrapolated from the last three, so the last order is the one before it.

use eikona::geometry::lay_out;
use eikona::mesh::{TriangleMesh, shapes};
use eikona::repulsive::{EnergyOptions, Pairs, tangent_point_energy};

/// The energy of the torus with radii 1 and 1/3 and p = 6, by quadrature of the smooth surface.
const TORUS: f64 = 103.7704318;
const SEPARATIONS: [f64; 4] = [0.8, 0.4, 0.2, 0.1];

fn energy(mesh: &TriangleMesh, options: EnergyOptions) -> f64 {
    tangent_point_energy(mesh, &options.with_threads(2)).expect("it is finite").value
}

fn longest_edge(mesh: &TriangleMesh) -> f64 {
    lay_out(mesh).iter().flat_map(|triangle| triangle.lengths).fold(0.0, f64::max)
}

/// A smooth map close to the identity: a trigonometric polynomial of order 2.
fn perturbed([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        x + 0.05 * (2.0 * y + z).sin() - 0.02 * (x - 2.0 * z).cos(),
        y + 0.04 * (x + 2.0 * z).cos() + 0.03 * (2.0 * x - y).sin(),
        z + 0.05 * (x - 2.0 * y).sin() + 0.02 * (2.0 * x + y).cos(),
    ]
}

/// The order of convergence between errors at two resolutions.
fn order(errors: [f64; 2], sizes: [f64; 2]) -> f64 {
    (errors[0] / errors[1]).abs().ln() / (sizes[0] / sizes[1]).ln()
}

/// The limit of a sequence whose error falls by the same factor from term to term.
fn limit(last: [f64; 3]) -> f64 {
    let [a, b, c] = last;
    c - (c - b) * (c - b) / ((c - b) - (b - a))
}

/// Prints values, their relative errors, and the orders between them.
fn print_errors(sizes: &[f64], values: &[f64], limit: f64) {
    println!("|---|---|---|---|");
    for (k, (size, value)) in sizes.iter().zip(values).enumerate() {
        let error = |k: usize| values[k] / limit - 1.0;
        let order = match k {
            0 => String::new(),
            _ => format!("{:.2}", order([error(k - 1), error(k)], [sizes[k - 1], *size])),
        };
        println!("| {size:.4} | {value:.7} | {:+.2e} | {order} |", error(k));
    }
}

fn main() {
    let levels: u32 =
        std::env::args().nth(1).map_or(4, |word| word.parse().expect("a number is expected")).max(3);
    for (name, map, known) in [
        ("torus of revolution", (|p| p) as fn([f64; 3]) -> [f64; 3], Some(TORUS)),
        ("perturbed torus", perturbed, None),
    ] {
        let meshes: Vec<TriangleMesh> = (0..levels)
            .map(|level| {
                let n = 8 << level;
                let torus = shapes::torus(1.0, 1.0 / 3.0, 3 * n, n).expect("the sizes are valid");
                torus.with_positions(torus.positions().iter().map(|p| map(*p)).collect()).expect("same count")
            })
            .collect();
        let sizes: Vec<f64> = meshes.iter().map(longest_edge).collect();
        let values: Vec<f64> =
            meshes.iter().map(|mesh| energy(mesh, EnergyOptions::default().with_pairs(Pairs::All))).collect();
        let last = values.len() - 3;
        let extrapolated = limit([values[last], values[last + 1], values[last + 2]]);
        println!("\n{name}: limit {}, extrapolated {extrapolated:.7}", known.unwrap_or(extrapolated));
        println!("\n| h | all pairs | error | order in h |");
        print_errors(&sizes, &values, known.unwrap_or(extrapolated));
        let (mesh, exact) = (&meshes[meshes.len() - 1], values[values.len() - 1]);
        println!(
            "\n| separation | clusters, {} faces | error | order in the separation |",
            mesh.face_count()
        );
        let clustered = SEPARATIONS.map(|s| energy(mesh, EnergyOptions::default().with_separation(s)));
        print_errors(&SEPARATIONS, &clustered, exact);
    }
}
