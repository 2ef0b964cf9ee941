//! Accuracy and time of adaptive quadrature: two spheres that nearly touch, against a uniform
//! subdivision, and surfaces without near contact.
//!
//! ```sh
//! cargo run --release -p eikona --example near_contact
//! ```

use eikona::mesh::{TriangleMesh, shapes};
use eikona::repulsive::{EnergyOptions, Pairs, Quadrature, TangentPointEnergy, tangent_point_energy};
use std::time::Instant;

type Vec3 = [f64; 3];

fn main() {
    let separations = [1.0, 0.7, 0.5, 0.35, 0.25, 0.18];
    let mut ways = vec![("midpoint".to_string(), Quadrature::Midpoint)];
    for separation in separations {
        ways.push((format!("adaptive {separation}"), Quadrature::Adaptive { separation }));
    }
    for (level, gap) in [(2, 0.1), (3, 0.1), (2, 0.03), (3, 0.03), (2, 0.01), (3, 0.01)] {
        let sphere = shapes::icosphere(level).expect("the size is valid");
        let [first, second] = [-1.0, 1.0].map(|side| shifted(&sphere, side * (1.0 + 0.5 * gap)));
        let both = together(&first, &second);
        let finest = if gap < 0.05 { 6 } else { 5 };
        let references = [2, 1, 0].map(|less| finest - less).map(|finest| between(&first, &second, finest));
        // Errors fall by four with each level.
        let limit = references[2] + (references[2] - references[1]) / 3.0;
        println!("two spheres {level}, gap {gap}: {references:.5?}, limit {limit:.5}");
        for (name, quadrature) in &ways {
            let ([both, time], [alone, _]) = (energy(&both, *quadrature), energy(&sphere, *quadrature));
            let off = (both - 2.0 * alone) / limit - 1.0;
            println!(
                "  {name:>14}: {both:14.4}, contact off by {:+8.3} %, {:.2} ms",
                100.0 * off,
                1e3 * time
            );
        }
    }
    let rings = shapes::linked_rings(2, 0.3, 112, 44).expect("the sizes are valid");
    for (name, mesh) in [("sphere 5", shapes::icosphere(5).expect("valid")), ("linked rings 4", rings)] {
        println!("{name}, {} faces", mesh.face_count());
        for (name, quadrature) in &ways {
            let [value, time] = energy(&mesh, *quadrature);
            println!("  {name:>14}: {value:.6}, {:.1} ms", 1e3 * time);
        }
    }
}

/// The energy and the seconds it took, the least of some runs.
fn energy(mesh: &TriangleMesh, quadrature: Quadrature) -> [f64; 2] {
    let pairs = if mesh.face_count() < 6000 { Pairs::All } else { Pairs::Hierarchical };
    let options = EnergyOptions::default().with_pairs(pairs).with_quadrature(quadrature);
    let runs = (0..3).map(|_| {
        let start = Instant::now();
        let TangentPointEnergy { value, .. } =
            tangent_point_energy(mesh, &options).expect("the energy is finite");
        [value, start.elapsed().as_secs_f64()]
    });
    runs.min_by(|a, b| a[1].total_cmp(&b[1])).expect("there is a run")
}

fn shifted(mesh: &TriangleMesh, x: f64) -> TriangleMesh {
    let positions = mesh.positions().iter().map(|p| [p[0] + x, p[1], p[2]]).collect();
    mesh.with_positions(positions).expect("the mesh stays valid")
}

fn together(first: &TriangleMesh, second: &TriangleMesh) -> TriangleMesh {
    let shift = first.vertex_count() as u32;
    let faces = second.triangles().iter().map(|t| t.map(|v| v + shift));
    let faces = first.triangles().iter().copied().chain(faces).collect();
    TriangleMesh::new([first.positions(), second.positions()].concat(), faces).expect("both are valid")
}

/// The energy of `p = 6` between two surfaces: faces that may be close are split `finest` times,
/// others up to three times.
fn between(first: &TriangleMesh, second: &TriangleMesh, finest: usize) -> f64 {
    let corners = |mesh: &TriangleMesh| mesh.faces().map(|f| mesh.face_positions(f)).collect::<Vec<_>>();
    let (first, second) = (corners(first), corners(second));
    let parts = |faces: &[[Vec3; 3]]| {
        faces.iter().map(|f| [0, 1, 3, finest].map(|level| centroids(*f, level))).collect::<Vec<_>>()
    };
    let (own, others) = (parts(&first), parts(&second));
    let mut sum = 0.0;
    for (s, s_parts) in first.iter().zip(&own) {
        for (t, t_parts) in second.iter().zip(&others) {
            let sizes = [(s, s_parts), (t, t_parts)]
                .map(|(corners, parts)| corners.map(|p| length(minus(p, parts[0][0]))));
            let size = sizes.map(|radii| radii[0].max(radii[1]).max(radii[2]));
            let gap = (length(minus(s_parts[0][0], t_parts[0][0])) - size[0] - size[1]) / size[0];
            let level = (gap < 0.2) as usize + (gap < 2.0) as usize + (gap < 6.0) as usize;
            let ([n, area], [m, other]) = (plane(*s), plane(*t));
            let share = area[0] * other[0] / (s_parts[level].len() * t_parts[level].len()) as f64;
            for x in &s_parts[level] {
                for y in &t_parts[level] {
                    let v = minus(*x, *y);
                    let planes = product(n, v).powi(6) + product(m, v).powi(6);
                    sum += share * planes / product(v, v).powi(6);
                }
            }
        }
    }
    sum
}

fn centroids([a, b, c]: [Vec3; 3], level: usize) -> Vec<Vec3> {
    if level == 0 {
        return vec![[0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0)];
    }
    let middle = |p: Vec3, q: Vec3| [0, 1, 2].map(|k| 0.5 * (p[k] + q[k]));
    let (x, y, z) = (middle(a, b), middle(b, c), middle(c, a));
    let parts = [[a, x, z], [x, b, y], [z, y, c], [x, y, z]];
    parts.into_iter().flat_map(|part| centroids(part, level - 1)).collect()
}

/// The unit normal, and the area.
fn plane([a, b, c]: [Vec3; 3]) -> [Vec3; 2] {
    let (u, v) = (minus(b, a), minus(c, a));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    [n.map(|x| x / length(n)), [0.5 * length(n); 3]]
}

fn minus(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn product(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn length(a: Vec3) -> f64 {
    product(a, a).sqrt()
}
