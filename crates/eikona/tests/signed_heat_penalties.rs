//! The penalties that `examples/penalties` compares with the default: the quadratic one against the
//! library's, the others against closed forms.

mod exact;
#[path = "../examples/penalties/gaps.rs"]
mod gaps;
#[path = "../examples/penalties/penalty.rs"]
mod penalty;

use eikona::geometry::lay_out;
use eikona::operators::CotanLaplacian;
use eikona::signed_heat::{LevelSets, Solution};
use eikona_mesh::shapes::{self, Diagonal};
use eikona_mesh::{Curve, SurfaceCurves, TriangleMesh, damage};
use exact::{PAPER_TIME, broken, largest_difference, rough_plate, solve, through_vertices, zero_level};
use penalty::{Fits, Nodes, Penalty};

fn free(mesh: &TriangleMesh, source: &SurfaceCurves) -> Solution {
    solve(mesh, source, PAPER_TIME, LevelSets::Free)
}

fn together(sources: impl IntoIterator<Item = SurfaceCurves>) -> SurfaceCurves {
    let curves = sources.into_iter().flat_map(|s| s.curves).collect();
    SurfaceCurves { curves, points: Vec::new() }
}

/// Rings of pieces, of different lengths and displaced from each other.
fn displaced_rings(mesh: &TriangleMesh) -> SurfaceCurves {
    let ring = |r: f64| zero_level(mesh, |p| (p[0] - 1.0).hypot(p[1] - 1.0) - r);
    together([broken(mesh, &ring(0.47), 0.15, 0.1), broken(mesh, &ring(0.53), 0.05, 0.2)])
}

#[test]
fn quadratic_penalty_is_that_of_the_library() {
    let plate = rough_plate(30);
    let rings = displaced_rings(&plate);
    let sphere = damage::jitter(&shapes::geodesic_sphere(12).unwrap(), 0.2, 3).unwrap();
    let wave = zero_level(&sphere, |p| p[2] - 0.3 + 0.4 * p[0] * p[1]);
    let mut doubled = broken(&sphere, &wave, 0.1, 0.05);
    doubled.curves.extend(doubled.curves.clone());
    for (name, mesh, source) in [("plate", &plate, &rings), ("sphere, doubled", &sphere, &doubled)] {
        let fits = Fits::new(mesh);
        let nodes = Nodes::of(mesh, source);
        let size = lay_out(mesh).iter().map(|t| t.area).sum::<f64>().sqrt();
        for weight in [1.0, 10.0, 1000.0] {
            let library = solve(mesh, source, PAPER_TIME, LevelSets::Soft(weight));
            let rhs = fits.right_hand_side(library.gradient.as_slice());
            let ours = fits.by_length(&rhs, &nodes, weight / size, 0.0);
            let difference = largest_difference(&ours, library.distance.as_slice());
            assert!(difference < 1e-11, "{name}, weight {weight}: {difference}");
        }
    }
}

/// A plate of 10 by 2, and the lines x = 4 and x = 6 in the same direction. Its unit field is
/// constant, and distances depend on x only.
fn two_lines() -> (TriangleMesh, SurfaceCurves) {
    let mesh = shapes::grid(20, 4, 10.0, 2.0, Diagonal::Alternating).unwrap();
    let line = |x: f64| through_vertices(&mesh, |p| p[0] == x, |p| p[1]);
    let curves = vec![line(4.0), line(6.0)];
    (mesh, SurfaceCurves { curves, points: Vec::new() })
}

/// Returns the slope between the lines after so many reweighted solves.
fn slope_between_lines(penalty: Penalty, solves: usize) -> f64 {
    let (mesh, source) = two_lines();
    let start = free(&mesh, &source);
    let fits = Fits::new(&mesh);
    let nodes = Nodes::of(&mesh, &source);
    let rhs = fits.right_hand_side(start.gradient.as_slice());
    let mut phi = start.distance.into_vec();
    for _ in 0..solves {
        phi = fits.reweighted(&rhs, &nodes, penalty, &phi);
    }
    let at = |x: f64| phi[mesh.positions().iter().position(|p| p[0] == x && p[1] == 1.0).unwrap()];
    assert!((at(8.0) - at(6.0)).abs() > 1.999, "the slope outside is 1");
    ((at(6.0) - at(4.0)) / 2.0).abs()
}

/// Lines a distance `d` apart get values -v and v, where `2 v = d (1 - P'(v))`.
#[test]
fn penalties_change_the_slope_by_their_force() {
    let threshold = 0.01;
    for force in [0.15, 0.3, 0.6] {
        for penalty in [Penalty::Huber { force, threshold }, Penalty::HuberOfCurves { force, threshold }] {
            let slope = slope_between_lines(penalty, 60);
            assert!((slope - (1.0 - force)).abs() < 1e-9, "{penalty:?}: {slope}");
        }
    }
    // Below the threshold, Huber's function is a quadratic penalty of weight force / threshold.
    let edge = Fits::new(&two_lines().0).edge;
    let wide = Penalty::Huber { force: 0.3, threshold: 3.0 };
    let slope = slope_between_lines(wide, 1);
    let expected = 1.0 / (1.0 + 0.3 / (3.0 * edge));
    assert!((slope - expected).abs() < 1e-9, "{slope} and {expected}");
    assert!(2.0 * 0.5 * slope < 3.0 * edge, "the values are below the threshold");
    // A force above 1 leaves no slope.
    let flat = slope_between_lines(Penalty::Huber { force: 1.5, threshold }, 60);
    assert!(flat < 2.0 * threshold, "{flat}");
}

/// Energy of a fit with Huber's function, up to a constant.
fn energy(mesh: &TriangleMesh, nodes: &Nodes, rhs: &[f64], phi: &[f64], force: f64, width: f64) -> f64 {
    let laplacian = CotanLaplacian::new(mesh, &lay_out(mesh));
    let mut energy: f64 = rhs.iter().zip(phi).map(|(b, x)| -b * x).sum();
    for (&[i, j], entry) in laplacian.graph.pairs.iter().zip(&laplacian.matrix.off_diagonal) {
        energy -= 0.5 * entry * (phi[i as usize] - phi[j as usize]).powi(2);
    }
    let huber = |x: &f64| match x.abs() {
        small if small < width => 0.5 * small * small / width,
        large => large - 0.5 * width,
    };
    let penalty: Vec<f64> = nodes.values(mesh, phi).iter().map(huber).collect();
    energy + force * nodes.integral(&penalty)
}

/// The quadratic penalty of each solve lies above Huber's function, and meets it at the fit before.
#[test]
fn reweighted_solves_never_raise_the_energy() {
    let mesh = rough_plate(24);
    let source = displaced_rings(&mesh);
    let start = free(&mesh, &source);
    let fits = Fits::new(&mesh);
    let nodes = Nodes::of(&mesh, &source);
    let rhs = fits.right_hand_side(start.gradient.as_slice());
    let (force, threshold) = (0.3, 0.1);
    let mut phi = start.distance.into_vec();
    let mut energies = Vec::new();
    for _ in 0..12 {
        energies.push(energy(&mesh, &nodes, &rhs, &phi, force, threshold * fits.edge));
        phi = fits.reweighted(&rhs, &nodes, Penalty::Huber { force, threshold }, &phi);
    }
    assert!(energies.windows(2).all(|w| w[1] <= w[0] + 1e-12 * w[0].abs()), "{energies:?}");
    assert!(energies[11] < energies[0] - 1e-4, "{energies:?}");
}

#[test]
fn weights_by_length_change_nothing_for_equal_curves() {
    let (mesh, source) = two_lines();
    let fits = Fits::new(&mesh);
    let nodes = Nodes::of(&mesh, &source);
    let rhs = fits.right_hand_side(free(&mesh, &source).gradient.as_slice());
    let equal = fits.by_length(&rhs, &nodes, 3.0, 0.0);
    for power in [1.0, -1.0] {
        let found = fits.by_length(&rhs, &nodes, 3.0, power);
        assert!(largest_difference(&found, &equal) < 1e-11, "{power}");
    }
}

/// Of two lines, the upper half of one is missing. With equal total weights, the short line is held
/// as firmly as the long one, so the mean values along them are opposite; with weights that grow
/// with the length, the long one is nearer to zero.
#[test]
fn weights_by_length_share_the_total() {
    let (mesh, mut source) = two_lines();
    source.curves[1].nodes.truncate(3);
    let fits = Fits::new(&mesh);
    let nodes = Nodes::of(&mesh, &source);
    let (_, whole) = two_lines();
    let rhs = fits.right_hand_side(free(&mesh, &whole).gradient.as_slice());
    let means = |power: f64| {
        let phi = fits.by_length(&rhs, &nodes, 3.0, power);
        let mean = |x: f64, top: f64| {
            let on: Vec<usize> = (0..phi.len())
                .filter(|&v| mesh.positions()[v][0] == x && mesh.positions()[v][1] <= top)
                .collect();
            // The trapezoidal rule.
            let ends = 0.5 * (phi[on[0]] + phi[*on.last().unwrap()]);
            (on.iter().map(|&v| phi[v]).sum::<f64>() - ends) / (on.len() - 1) as f64
        };
        [mean(4.0, 2.0), mean(6.0, 1.0)]
    };
    let [long, short] = means(-1.0);
    assert!((long + short).abs() < 1e-9, "{long} and {short}");
    let [long, short] = means(1.0);
    assert!((short / long + 4.0).abs() < 1e-9, "{long} and {short}");
}

#[test]
fn gaps_are_measured_between_open_ends() {
    let (mesh, mut source) = two_lines();
    assert!(gaps::gaps(&mesh, &source).is_empty(), "lines from rim to rim have no open ends");
    // A gap of 1 in the middle of the first line, and the second line cut off at its middle.
    let [first, second] = [source.curves[0].clone(), source.curves[1].clone()];
    let part = |curve: &Curve, from: usize, to: usize| Curve::signed(curve.nodes[from..to].iter().copied());
    source.curves = vec![part(&first, 0, 2), part(&first, 3, 5), part(&second, 0, 3)];
    let found = gaps::gaps(&mesh, &source);
    let expected = [1.0, 1.0, 0.5f64.hypot(2.0)];
    assert!(largest_difference(&found, &expected) < 1e-12, "{found:?}");
}
