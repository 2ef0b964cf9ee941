//! Adaptive quadrature of the tangent-point energy near contact: against uniform subdivision, and
//! the identities of the energy.

mod tangent;

use eikona::geometry::lay_out;
use eikona::mesh::{Face, TriangleMesh, damage, shapes};
use eikona::repulsive::{
    EnergyOptions, Exponents, Flow, FlowOptions, Pairs, Quadrature, RepulsiveError, TangentPointEnergy,
    tangent_point_energy,
};
use eikona::spatial::self_distance;
use tangent::{moved, together, two_spheres};

type Vec3 = [f64; 3];

fn adaptive() -> EnergyOptions {
    EnergyOptions::default().with_quadrature(Quadrature::Adaptive { separation: 0.35 })
}

fn value(mesh: &TriangleMesh, options: &EnergyOptions) -> f64 {
    tangent_point_energy(mesh, options).unwrap().value
}

/// Two triangulated unit squares that face each other.
fn squares(gap: f64) -> TriangleMesh {
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let at = |z: f64| square.map(|[x, y]| [x, y, z]);
    let faces = vec![[0, 1, 2], [0, 2, 3], [4, 5, 7], [5, 6, 7]];
    TriangleMesh::new([at(0.0), at(gap)].concat(), faces).unwrap()
}

/// Two pyramids without base whose tips face each other.
fn tips(gap: f64) -> TriangleMesh {
    let one = TriangleMesh::new(
        vec![[0.0, 0.0, 0.5 * gap], [1.0, 0.1, 0.9], [-0.5, 0.8, 1.0], [-0.4, -0.9, 1.1]],
        vec![[0, 1, 2], [0, 2, 3], [0, 3, 1]],
    );
    let one = one.unwrap();
    together(&one, &moved(&one, |[x, y, z]| [0.6 * x - 0.8 * y, 0.8 * x + 0.6 * y, -z]))
}

/// The energy with each face split `level` times, between faces that share no vertex.
fn uniform(mesh: &TriangleMesh, level: usize) -> f64 {
    let triangles = lay_out(mesh);
    let parts: Vec<Vec<Vec3>> = mesh.faces().map(|f| centroids(mesh.face_positions(f), level)).collect();
    let mut sum = 0.0;
    for s in mesh.faces() {
        let normal = normal(mesh.face_positions(s));
        for t in mesh.faces().filter(|&t| !touch(mesh, s, t)) {
            for x in &parts[s.index()] {
                for y in &parts[t.index()] {
                    let v = [0, 1, 2].map(|k| x[k] - y[k]);
                    let share = triangles[s.index()].area * triangles[t.index()].area;
                    sum += share * (dot(normal, v) / dot(v, v)).powi(6);
                }
            }
        }
    }
    sum / 16f64.powi(level as i32)
}

fn touch(mesh: &TriangleMesh, s: Face, t: Face) -> bool {
    mesh.face_vertices(s).iter().any(|v| mesh.face_vertices(t).contains(v))
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

fn dot(a: Vec3, b: Vec3) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn normal([a, b, c]: [Vec3; 3]) -> Vec3 {
    let [u, v] = [b, c].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    n.map(|x| x / dot(n, n).sqrt())
}

#[test]
fn facing_squares_have_the_energy_of_a_uniform_subdivision() {
    for gap in [0.5, 0.2] {
        let mesh = squares(gap);
        // Errors fall by four with each level.
        let [coarse, fine] = [4, 5].map(|level| uniform(&mesh, level));
        let limit = fine + (fine - coarse) / 3.0;
        let off = |separation| {
            let options = EnergyOptions::default().with_quadrature(Quadrature::Adaptive { separation });
            (value(&mesh, &options) / limit - 1.0).abs()
        };
        let errors = [0.7, 0.35, 0.18].map(off);
        assert!(errors[1] < 0.01 && errors[2] < 0.001, "{gap}: {errors:?}");
        assert!(errors[0] > errors[1] && errors[1] > errors[2], "{gap}: {errors:?}");
        let midpoint = value(&mesh, &EnergyOptions::default());
        assert!((midpoint / limit - 1.0).abs() > 0.05, "{gap}: {midpoint} {limit}");
    }
}

#[test]
fn what_spheres_add_to_each_other_is_within_one_percent() {
    // Uniform subdivisions extrapolated, see the example near_contact.
    for (levels, gap, expected) in [
        (2, 0.1, 580.39),
        (3, 0.1, 937.467),
        (2, 0.03, 10146.4),
        (3, 0.03, 26991.5),
        (2, 0.01, 100922.8),
        (3, 0.01, 376778.6),
    ] {
        let sphere = shapes::icosphere(levels).unwrap();
        let at = |x: f64| moved(&sphere, |p| [p[0] + x, p[1], p[2]]);
        let both = together(&at(-1.0 - 0.5 * gap), &at(1.0 + 0.5 * gap));
        for pairs in [Pairs::All, Pairs::Hierarchical] {
            let options = adaptive().with_pairs(pairs);
            let found = value(&both, &options) - 2.0 * value(&sphere, &options);
            assert!((found / expected - 1.0).abs() < 0.01, "{levels}, {gap}: {found} {expected}");
        }
    }
}

#[test]
fn the_energy_grows_without_bound_as_a_gap_closes() {
    // Sheets of area A at distance d have about A d^-4, tips d^-2.
    for gap in [0.1, 0.05] {
        let ratio = value(&squares(0.5 * gap), &adaptive()) / value(&squares(gap), &adaptive());
        assert!(ratio > 15.0 && ratio < 18.0, "{gap}: {ratio}");
    }
    for gap in [1e-3, 1e-4, 1e-5] {
        let ratio = value(&tips(0.1 * gap), &adaptive()) / value(&tips(gap), &adaptive());
        assert!((ratio / 100.0 - 1.0).abs() < 0.05, "{gap}: {ratio}");
    }
    // The midpoint rule sees nothing of that.
    let midpoint = |gap: f64| value(&tips(gap), &EnergyOptions::default());
    assert!(midpoint(1e-6) < 1.1 * midpoint(1e-3));
}

#[test]
fn energies_keep_their_identities() {
    let sphere = damage::jitter(&shapes::icosphere(2).unwrap(), 0.15, 3).unwrap();
    let mesh = together(&sphere, &moved(&sphere, |[x, y, z]| [x + 2.03, y + 0.1, z - 0.05]));
    for (alpha, beta) in [(6.0, 12.0), (4.0, 9.0), (3.5, 7.0)] {
        let exponents = Exponents::new(alpha, beta).unwrap();
        for pairs in [Pairs::All, Pairs::Hierarchical] {
            let options = adaptive().with_exponents(exponents).with_pairs(pairs);
            let energy = |mesh: &TriangleMesh| tangent_point_energy(mesh, &options).unwrap();
            let given = energy(&mesh);
            let midpoint = value(&mesh, &options.with_quadrature(Quadrature::Midpoint));
            assert!((given.value / midpoint - 1.0).abs() > 0.05, "there is near contact");
            // Euler's identity: the derivative along the position is the degree times the energy.
            let forces = given.differential.as_slice();
            let along: f64 = mesh.positions().iter().zip(forces).map(|(p, d)| dot(*p, *d)).sum();
            let expected = exponents.degree() * given.value;
            assert!((along - expected).abs() < 1e-10 * given.value, "{along} {expected}");
            for k in 0..3 {
                let sum: f64 = forces.iter().map(|d| d[k]).sum();
                assert!(sum.abs() < 1e-10 * given.gradient_norm(), "{sum}");
            }
            for scale in [1e-8f64, 3.0, 1e25] {
                let found = energy(&moved(&mesh, |p| p.map(|x| x * scale))).value;
                let expected = given.value * scale.powf(exponents.degree());
                assert!((found / expected - 1.0).abs() < 1e-10, "{found} {expected} {scale}");
            }
            let triangles = lay_out(&mesh);
            let sum: f64 = mesh.faces().map(|f| given.density[f] * triangles[f.index()].area).sum();
            assert!((sum / given.value - 1.0).abs() < 1e-13);
            for threads in [2, 3] {
                assert!(tangent_point_energy(&mesh, &options.with_threads(threads)).unwrap() == given);
            }
        }
        // Clusters are others after a turn, and so is their error.
        let options = adaptive().with_exponents(exponents).with_pairs(Pairs::All);
        let turned = moved(&mesh, |[x, y, z]| [3.0 + 0.6 * x - 0.8 * z, y - 2.0, 0.8 * x + 0.6 * z]);
        assert!((value(&turned, &options) / value(&mesh, &options) - 1.0).abs() < 1e-10);
    }
}

#[test]
fn the_differential_is_that_of_the_value() {
    let mesh = two_spheres(2, 0.013);
    let mesh = damage::jitter(&mesh, 0.05, 3).unwrap();
    let options = adaptive();
    let given = tangent_point_energy(&mesh, &options).unwrap();
    let wave = |v: usize| [1.0, 2.0, 3.0].map(|k: f64| (1.7 * k + 0.9 * k * v as f64).sin());
    let at = |step: f64| {
        let positions = mesh.positions().iter().enumerate();
        let positions = positions.map(|(v, p)| [0, 1, 2].map(|k| p[k] + step * wave(v)[k])).collect();
        value(&mesh.with_positions(positions).unwrap(), &options)
    };
    let forces = given.differential.as_slice().iter().enumerate();
    let slope: f64 = forces.map(|(v, d)| dot(*d, wave(v))).sum();
    // So short a step changes no subdivision.
    let h = 1e-7;
    let quotient = (at(h) - at(-h)) / (2.0 * h);
    assert!((quotient / slope - 1.0).abs() < 1e-6, "{quotient} {slope}");
}

#[test]
fn surfaces_without_near_contact_keep_their_digits() {
    for mesh in [shapes::icosphere(3).unwrap(), shapes::torus(1.0, 0.4, 72, 32).unwrap()] {
        for pairs in [Pairs::All, Pairs::Hierarchical] {
            let options = EnergyOptions::default().with_pairs(pairs);
            let [midpoint, other] = [Quadrature::Midpoint, Quadrature::adaptive()]
                .map(|q| tangent_point_energy(&mesh, &options.with_quadrature(q)).unwrap());
            assert!(midpoint == other);
        }
    }
}

#[test]
fn faces_that_touch_or_cross_have_an_end() {
    // A tip on a tip, and one through the other.
    let touching = [0.0, -0.1].map(|gap| value(&tips(gap), &adaptive()));
    assert!(touching.iter().all(|e| e.is_finite() && *e > value(&tips(1e-6), &adaptive())), "{touching:?}");
    // Sheets that would need too many parts.
    assert!(value(&squares(1e-9), &adaptive()).is_finite());
    // Triangles that cross at their centroids.
    let cross = |p: [Vec3; 3], q: [Vec3; 3]| {
        let mesh = TriangleMesh::new([p, q].concat(), vec![[0, 1, 2], [3, 4, 5]]).unwrap();
        tangent_point_energy(&mesh, &adaptive())
    };
    let flat = [[-1.0, -1.0, 0.0], [2.0, -1.0, 0.0], [-1.0, 2.0, 0.0]];
    let upright = flat.map(|[x, y, _]| [0.0, x, y]);
    match cross(flat, upright) {
        Ok(TangentPointEnergy { value, .. }) => assert!(value > 1e6, "{value}"),
        Err(fault) => assert_eq!(fault, RepulsiveError::Touching { faces: [Face(0), Face(1)] }),
    }
    for separation in [0.0, -1.0, 1.5, f64::NAN] {
        let options = EnergyOptions::default().with_quadrature(Quadrature::Adaptive { separation });
        let fault = tangent_point_energy(&squares(0.1), &options).unwrap_err();
        assert!(matches!(fault, RepulsiveError::Separation { .. }), "{fault}");
        let options = FlowOptions::default().with_quadrature(Some(Quadrature::Adaptive { separation }));
        let fault = Flow::new(&squares(0.1), &options).err().unwrap();
        assert!(matches!(fault, RepulsiveError::Separation { .. }), "{fault}");
    }
}

#[test]
fn too_many_faces_in_near_contact_are_refused() {
    let spin = |i: u32, k: u32| (f64::from(i) * (0.7 + f64::from(k)) + f64::from(k)).sin();
    let points = (0..1600).flat_map(|i| (0..3).map(move |c| [0, 1, 2].map(|k| spin(i, 3 * c + k))));
    let faces = (0..1600).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = TriangleMesh::new(points.collect(), faces).unwrap();
    let fault = tangent_point_energy(&mesh, &adaptive()).unwrap_err();
    assert!(matches!(fault, RepulsiveError::NearContact { .. }), "{fault}");
}

#[test]
fn the_flow_keeps_coarse_spheres_apart() {
    let mesh = two_spheres(1, 0.02);
    let mut flow = Flow::new(&mesh, &FlowOptions::default()).unwrap();
    let (mut energy, mut distance) = (flow.energy(), self_distance(&mesh, 1).unwrap());
    assert!(energy > 1e3, "{energy}");
    for _ in 0..25 {
        flow.step().unwrap().unwrap();
        let now = self_distance(flow.mesh(), 1).unwrap();
        assert!(flow.energy() < 1.03 * energy, "{} {energy}", flow.energy());
        (energy, distance) = (flow.energy(), distance.min(now));
    }
    assert!(energy < 40.0, "{energy}");
    assert!(distance > 0.019 && self_distance(flow.mesh(), 1).unwrap() > 0.1, "{distance}");
}
