//! The tangent-point energy by all pairs, against the numbers of three independent programs, and
//! its identities.

use eikona::geometry::lay_out;
use eikona::mesh::{Face, TriangleMesh, damage, shapes};
use eikona::repulsive::{
    EnergyOptions, Exponents, Pairs, RepulsiveError, TangentPointEnergy, tangent_point_energy,
};
use std::collections::BTreeMap;

fn of(mesh: &TriangleMesh) -> TangentPointEnergy {
    tangent_point_energy(mesh, &EnergyOptions::default().with_pairs(Pairs::All)).unwrap()
}

fn moved(mesh: &TriangleMesh, map: impl Fn([f64; 3]) -> [f64; 3]) -> TriangleMesh {
    mesh.with_positions(mesh.positions().iter().map(|p| map(*p)).collect()).unwrap()
}

fn together(first: &TriangleMesh, second: &TriangleMesh) -> TriangleMesh {
    let shift = first.vertex_count() as u32;
    let faces = second.triangles().iter().map(|t| t.map(|v| v + shift));
    TriangleMesh::new(
        first.positions().iter().chain(second.positions()).copied().collect(),
        first.triangles().iter().copied().chain(faces).collect(),
    )
    .unwrap()
}

/// The sphere of the reference numbers: the icosahedron of the golden ratio, split in four.
fn golden_sphere(levels: usize) -> TriangleMesh {
    let golden = 0.5 * (1.0 + 5.0f64.sqrt());
    let on_sphere = |p: [f64; 3]| {
        let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        p.map(|x| x / length)
    };
    let mut points = Vec::new();
    for (s, t) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        points.extend([[0.0, s, t * golden], [s, t * golden, 0.0], [t * golden, 0.0, s]].map(on_sphere));
    }
    let distance = |a: u32, b: u32| {
        let [a, b] = [a, b].map(|v| points[v as usize]);
        (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum::<f64>().sqrt()
    };
    let mut faces = Vec::new();
    for a in 0..12u32 {
        for b in 0..a {
            // 1.05 is the length of a side, 1.7 the next distance.
            faces.extend(
                (0..b)
                    .filter(|&c| distance(a, b).max(distance(b, c)).max(distance(c, a)) < 1.2)
                    .map(|c| [a, b, c]),
            );
        }
    }
    assert_eq!(faces.len(), 20);
    for _ in 0..levels {
        let mut middles = BTreeMap::new();
        let mut split = Vec::new();
        for [a, b, c] in faces {
            let [x, y, z] = [[a, b], [b, c], [c, a]].map(|[a, b]: [u32; 2]| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let [p, q] = [a, b].map(|v| points[v as usize]);
                    points.push(on_sphere([0, 1, 2].map(|k| p[k] + q[k])));
                    points.len() as u32 - 1
                })
            });
            split.extend([[a, x, z], [x, b, y], [z, y, c], [x, y, z]]);
        }
        faces = split;
    }
    TriangleMesh::new(points, faces).unwrap()
}

fn two_spheres(levels: usize, gap: f64) -> TriangleMesh {
    let sphere = golden_sphere(levels);
    let at = |x: f64| moved(&sphere, |p| [p[0] + x, p[1], p[2]]);
    together(&at(-1.0 - 0.5 * gap), &at(1.0 + 0.5 * gap))
}

/// The torus of the reference numbers: quads split by the diagonal (i, j) - (i + 1, j + 1).
fn torus(nu: u32, nv: u32) -> TriangleMesh {
    let angle = |i: u32, n: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n);
    let point = |i: u32, j: u32| {
        let (u, v) = (angle(i, nu), angle(j, nv));
        let ring = 1.0 + v.cos() / 3.0;
        [ring * u.cos(), ring * u.sin(), v.sin() / 3.0]
    };
    let id = |i: u32, j: u32| (i % nu) * nv + j % nv;
    let cells = (0..nu).flat_map(|i| (0..nv).map(move |j| (i, j)));
    TriangleMesh::new(
        cells.clone().map(|(i, j)| point(i, j)).collect(),
        cells
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect(),
    )
    .unwrap()
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
        let on_threads = tangent_point_energy(&mesh, &options.with_threads(3)).unwrap();
        assert!(on_threads == given);
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
        assert!(found == tangent_point_energy(&mesh, &options.with_threads(3)).unwrap(), "{what}");
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
