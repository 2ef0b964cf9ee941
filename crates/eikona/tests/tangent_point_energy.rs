//! The tangent-point energy by all pairs, against the numbers of three independent programs, and
//! its identities.

mod tangent;

use eikona::geometry::lay_out;
use eikona::mesh::{Face, TriangleMesh, damage, shapes};
use eikona::repulsive::{
    EnergyOptions, Exponents, Pairs, RepulsiveError, TangentPointEnergy, tangent_point_energy,
};
use tangent::{moved, together, torus, two_spheres};

fn of(mesh: &TriangleMesh) -> TangentPointEnergy {
    tangent_point_energy(mesh, &EnergyOptions::default().with_pairs(Pairs::All)).unwrap()
}

fn assert_near(found: f64, expected: f64, what: &str) {
    let off = (found / expected - 1.0).abs();
    assert!(off < 1e-11, "{what}: {found} instead of {expected}, off by {off:e}");
}

#[test]
fn energy_and_differential_have_the_digits_of_independent_programs() {
    let sphere = |levels| shapes::icosphere(levels).unwrap();
    for (what, mesh, energy, gradient) in [
        ("icosphere 1", sphere(1), 3.076567008286071, 2.604629810439119),
        ("icosphere 2", sphere(2), 2.613055512197463, 0.9351059395292458),
        ("icosphere 3", sphere(3), 2.504071120297146, 0.3305973985151843),
        ("torus", torus(24, 8), 192.8281602842196, 128.5359332995739),
        ("two spheres, 0.1", two_spheres(2, 0.1), 1096.329144578159, 21730.27845358045),
        ("two spheres, 0.01", two_spheres(3, 0.01), 4501529.47658276, 638481761.076104),
    ] {
        let found = of(&mesh);
        assert_near(found.value, energy, what);
        assert_near(found.gradient_norm(), gradient, what);
    }
}

#[test]
fn energy_scales_and_does_not_depend_on_place_or_orientation() {
    let mesh = damage::jitter(&torus(12, 7), 0.2, 5).unwrap();
    for (alpha, beta) in [(6.0, 12.0), (3.0, 6.0), (4.0, 9.0), (5.5, 10.3), (2.1, 4.2)] {
        let exponents = Exponents::new(alpha, beta).unwrap();
        let options = EnergyOptions::default().with_exponents(exponents).with_pairs(Pairs::All);
        let energy = |mesh: &TriangleMesh| tangent_point_energy(mesh, &options).unwrap();
        let given = energy(&mesh);
        // Euler's identity: the derivative along the position is the degree times the energy.
        let along: f64 = mesh
            .positions()
            .iter()
            .zip(given.differential.as_slice())
            .map(|(p, d)| (0..3).map(|k| p[k] * d[k]).sum::<f64>())
            .sum();
        let expected = exponents.degree() * given.value;
        assert!((along - expected).abs() < 1e-10 * given.value, "{along} {expected}");
        // Forces add up to zero.
        for k in 0..3 {
            let sum: f64 = given.differential.as_slice().iter().map(|d| d[k]).sum();
            assert!(sum.abs() < 1e-11 * given.gradient_norm(), "{sum}");
        }
        let turned = moved(&mesh, |[x, y, z]| [3.0 + 0.6 * x - 0.8 * z, y - 2.0, 0.8 * x + 0.6 * z]);
        assert!((energy(&turned).value / given.value - 1.0).abs() < 1e-11);
        for scale in [1e-8f64, 1e8, 1e-25, 1e25] {
            let found = energy(&moved(&mesh, |p| p.map(|x| x * scale))).value;
            let expected = given.value * scale.powf(exponents.degree());
            assert!((found / expected - 1.0).abs() < 1e-11, "{found} {expected} {scale}");
        }
        let flipped = mesh.triangles().iter().enumerate().map(
            |(f, &[a, b, c])| {
                if f % 3 == 0 { [a, c, b] } else { [a, b, c] }
            },
        );
        let flipped = TriangleMesh::new(mesh.positions().to_vec(), flipped.collect()).unwrap();
        assert!((energy(&flipped).value / given.value - 1.0).abs() < 1e-13);
        let triangles = lay_out(&mesh);
        let sum: f64 = mesh.faces().map(|f| given.density[f] * triangles[f.index()].area).sum();
        assert!((sum / given.value - 1.0).abs() < 1e-13);
        for threads in [2, 3] {
            assert!(tangent_point_energy(&mesh, &options.with_threads(threads)).unwrap() == given);
        }
    }
}

#[test]
fn clusters_cost_less_than_half_a_percent() {
    let tori = |n: usize| {
        let one = shapes::torus(1.0, 0.3, 28 * n, 11 * n).unwrap();
        let other = moved(&one, |[x, y, z]| [x + 1.0, z, -y]);
        together(&one, &other)
    };
    let sphere = |levels| shapes::icosphere(levels).unwrap();
    for (what, mesh) in [
        ("sphere 2", sphere(2)),
        ("sphere 3", sphere(3)),
        ("sphere 4", sphere(4)),
        ("tori 1", tori(1)),
        ("tori 2", tori(2)),
        ("two spheres", two_spheres(3, 0.1)),
    ] {
        let given = of(&mesh);
        let options = EnergyOptions::default();
        let found = tangent_point_energy(&mesh, &options).unwrap();
        let off = |found: f64, given: f64| (found / given - 1.0).abs();
        assert!(off(found.value, given.value) < 1e-3, "{what}: {} {}", found.value, given.value);
        let norms = [&found, &given].map(TangentPointEnergy::gradient_norm);
        assert!(off(norms[0], norms[1]) < 5e-3, "{what}: {norms:?}");
        // Forces add up to zero, and each changes little.
        for k in 0..3 {
            let sum: f64 = found.differential.as_slice().iter().map(|d| d[k]).sum();
            assert!(sum.abs() < 1e-11 * norms[0], "{what}: {sum}");
        }
        for threads in [2, 3] {
            let other = tangent_point_energy(&mesh, &options.with_threads(threads)).unwrap();
            assert!(found == other, "{what}");
        }
    }
    // Exponents below 3, where the kernel is not smooth across the tangent plane.
    let options = EnergyOptions::default().with_exponents(Exponents::of_power(2.5).unwrap());
    let [found, given] = [Pairs::Hierarchical, Pairs::All]
        .map(|pairs| tangent_point_energy(&tori(2), &options.with_pairs(pairs)).unwrap());
    assert!((found.value / given.value - 1.0).abs() < 0.02, "{} {}", found.value, given.value);
}

#[test]
fn differential_is_that_of_the_value() {
    let mesh = damage::jitter(&torus(10, 6), 0.2, 2).unwrap();
    for power in [6.0, 3.5] {
        let options = EnergyOptions::default().with_exponents(Exponents::of_power(power).unwrap());
        let energy = |mesh: &TriangleMesh| tangent_point_energy(mesh, &options).unwrap();
        let given = energy(&mesh);
        let direction: Vec<[f64; 3]> = (0..mesh.vertex_count())
            .map(|i| [1.0, 2.0, 3.0].map(|k| (k * 1.7 + 0.9 * k * i as f64).sin()))
            .collect();
        let along: f64 = direction
            .iter()
            .zip(given.differential.as_slice())
            .map(|(d, g)| (0..3).map(|k| d[k] * g[k]).sum::<f64>())
            .sum();
        // The remainder falls with the square of the step.
        let remainder = |step: f64| {
            let positions = mesh.positions().iter().zip(&direction);
            let positions = positions.map(|(p, d)| [0, 1, 2].map(|k| p[k] + step * d[k])).collect();
            (energy(&mesh.with_positions(positions).unwrap()).value - given.value - step * along).abs()
        };
        for step in [1e-3, 1e-4] {
            let order = (remainder(step) / remainder(0.1 * step)).log10();
            assert!((order - 2.0).abs() < 0.1, "{order}");
        }
    }
}

#[test]
fn faults_name_the_elements() {
    for (alpha, beta) in
        [(2.0, 4.0), (1.0, 2.0), (6.0, 14.0), (6.0, 8.0), (f64::NAN, 12.0), (6.0, f64::INFINITY)]
    {
        let fault = Exponents::new(alpha, beta).unwrap_err();
        assert!(fault.to_string().contains("choose p = 6"), "{fault}");
    }
    let energy = |mesh: &TriangleMesh| tangent_point_energy(mesh, &EnergyOptions::default());
    let points = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0]];
    let mesh = |faces: Vec<[u32; 3]>| TriangleMesh::new(points.clone(), faces).unwrap();
    assert_eq!(energy(&mesh(vec![])).unwrap_err(), RepulsiveError::NoFaces);
    let flat = energy(&mesh(vec![[0, 1, 2], [0, 1, 3]])).unwrap_err();
    assert_eq!(flat, RepulsiveError::FlatFace { face: Face(1) });
    let twice = energy(&mesh(vec![[0, 1, 2], [1, 3, 2], [2, 0, 1]])).unwrap_err();
    assert_eq!(twice, RepulsiveError::Coincident { faces: [Face(0), Face(2)] });
    // One triangle has no other face, and a plane no tangent spheres.
    assert_eq!(energy(&mesh(vec![[0, 1, 2]])).unwrap().value, 0.0);
    assert_eq!(energy(&mesh(vec![[0, 1, 2], [1, 3, 2]])).unwrap().value, 0.0);
}
