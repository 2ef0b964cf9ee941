//! The fractional inner product, against the numbers of three independent programs, and its
//! identities.

mod tangent;

use eikona::mesh::random::Random;
use eikona::mesh::{TriangleMesh, VertexField, damage, shapes};
use eikona::repulsive::{Exponents, Metric, MetricOptions, Pairs, RepulsiveError};
use tangent::{moved, torus, two_spheres};

type Field = VertexField<[f64; 3]>;

fn metric(mesh: &TriangleMesh, options: &MetricOptions) -> Metric {
    Metric::new(mesh, options).unwrap()
}

fn positions(mesh: &TriangleMesh) -> Field {
    mesh.positions().to_vec().into()
}

fn dot(a: &Field, b: &Field) -> f64 {
    a.as_slice().iter().flatten().zip(b.as_slice().iter().flatten()).map(|(a, b)| a * b).sum()
}

fn noise(mesh: &TriangleMesh, seed: u64) -> Field {
    let mut random = Random::from_seed(seed);
    (0..mesh.vertex_count())
        .map(|_| [(); 3].map(|()| 2.0 * random.uniform() - 1.0))
        .collect::<Vec<_>>()
        .into()
}

#[test]
fn all_pairs_have_the_digits_of_independent_programs() {
    for (what, mesh, high, low, fractional) in [
        ("icosphere", shapes::icosphere(1).unwrap(), 200.5043839668927, 37.4695175408819, 126.181397678655),
        ("torus", torus(24, 8), 694.2401113270846, 122.6478318520344, 150.9875200277459),
    ] {
        let options = MetricOptions::default().with_pairs(Pairs::All);
        let x = positions(&mesh);
        let whole = metric(&mesh, &options);
        let both = dot(&x, &whole.product(&x).unwrap());
        let found_high = dot(&x, &metric(&mesh, &options.with_low_order(false)).product(&x).unwrap());
        let found_fractional = dot(&x, &whole.fractional_product(&x).unwrap());
        for (found, expected) in [(both, high + low), (found_high, high), (found_fractional, fractional)] {
            assert!((found / expected - 1.0).abs() < 1e-12, "{what}: {found} instead of {expected}");
        }
        // Lengths enter as a power of a power of two.
        let large = moved(&mesh, |p| p.map(|x| 1e5 * x));
        let image = metric(&large, &options).product(&x).unwrap();
        let expected = both * 1e5f64.powf(-4.0 / 3.0);
        assert!((dot(&x, &image) / expected - 1.0).abs() < 1e-12, "{what}");
    }
}

#[test]
fn the_product_is_symmetric_semidefinite_and_vanishes_for_translations() {
    for (what, mesh) in [
        ("sphere", shapes::icosphere(3).unwrap()),
        ("torus", damage::jitter(&shapes::torus(1.0, 0.4, 40, 17).unwrap(), 0.3, 7).unwrap()),
        ("two spheres", two_spheres(3, 0.1)),
        ("open", shapes::cylinder(1.0, 2.0, 30, 12, shapes::Ends::Open).unwrap()),
    ] {
        let options = MetricOptions::default();
        let metric = Metric::new(&mesh, &options).unwrap();
        let (x, y) = (noise(&mesh, 1), noise(&mesh, 2));
        let [ax, ay] = [&x, &y].map(|x| metric.product(x).unwrap());
        assert!((dot(&y, &ax) - dot(&x, &ay)).abs() < 1e-12 * dot(&x, &ax), "{what}");
        for seed in 3..8 {
            let z = noise(&mesh, seed);
            assert!(dot(&z, &metric.product(&z).unwrap()) > 0.0, "{what}");
        }
        let shift: Field = vec![[1.0, -2.0, 3.0]; mesh.vertex_count()].into();
        let image = metric.product(&shift).unwrap();
        let largest = image.as_slice().iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
        assert!(largest < 1e-12 * dot(&x, &ax).sqrt(), "{what}: {largest}");
        let solution = metric.solve(&[ax.clone(), ay]).unwrap();
        for threads in [2, 3] {
            let other = Metric::new(&mesh, &options.with_threads(threads)).unwrap();
            assert!(ax == other.product(&x).unwrap(), "{what}");
            let again = other.solve(&[ax.clone(), other.product(&y).unwrap()]).unwrap();
            assert!(solution.displacements == again.displacements, "{what}");
        }
    }
}

#[test]
fn far_clusters_cost_less_the_smaller_the_separation() {
    for (what, mesh) in [("sphere", shapes::icosphere(4).unwrap()), ("two spheres", two_spheres(3, 0.1))] {
        let x = positions(&mesh);
        let square = |options: &MetricOptions| dot(&x, &metric(&mesh, options).product(&x).unwrap());
        let exact = square(&MetricOptions::default().with_pairs(Pairs::All));
        let off = [0.8, 0.4, 0.2].map(|separation| {
            let options = MetricOptions::default().with_separation(separation);
            (square(&options) / exact - 1.0).abs()
        });
        // Squares of the radius over the distance: terms of first order cancel.
        assert!(off[0] < 0.05 && off[1] < 0.5 * off[0] && off[2] < 0.5 * off[1], "{what}: {off:?}");
        // Other exponents, whose powers are computed one by one.
        let options = MetricOptions::default().with_exponents(Exponents::of_power(4.5).unwrap());
        let exact = square(&options.with_pairs(Pairs::All));
        let off = (square(&options.with_separation(0.3)) / exact - 1.0).abs();
        assert!(off < 0.01, "{what}: {off}");
    }
}

#[test]
fn near_blocks_alone_are_all_pairs_to_single_precision() {
    for exponents in [Exponents::default(), Exponents::of_power(4.5).unwrap()] {
        for mesh in [torus(24, 8), moved(&torus(24, 8), |p| p.map(|x| 1e-7 * x))] {
            let options = MetricOptions::default().with_exponents(exponents).with_separation(1e-9);
            let metrics =
                [Pairs::All, Pairs::Hierarchical].map(|pairs| metric(&mesh, &options.with_pairs(pairs)));
            let x = noise(&mesh, 3);
            for product in [Metric::product, Metric::fractional_product] {
                let [all, near] = metrics.each_ref().map(|metric| dot(&x, &product(metric, &x).unwrap()));
                assert!((near / all - 1.0).abs() < 1e-7, "{near} {all}");
            }
        }
    }
}

#[test]
fn solutions_have_the_forces_as_products() {
    for (what, mesh) in [
        ("torus", shapes::torus(1.0, 0.4, 40, 17).unwrap()),
        ("two spheres", two_spheres(3, 0.1)),
        ("open", shapes::cylinder(1.0, 2.0, 30, 12, shapes::Ends::Open).unwrap()),
    ] {
        let options = MetricOptions::default().with_tolerance(1e-6);
        let metric = Metric::new(&mesh, &options).unwrap();
        let fields = [positions(&mesh), noise(&mesh, 5)];
        let forces = fields.clone().map(|x| metric.product(&x).unwrap());
        let solution = metric.solve(&forces).unwrap();
        assert!(solution.change <= 1e-6 && solution.iterations < 200, "{what}: {}", solution.iterations);
        for (found, given) in solution.displacements.iter().zip(&fields) {
            let count = mesh.vertex_count() as f64;
            let mean = [0, 1, 2].map(|k| given.as_slice().iter().map(|x| x[k]).sum::<f64>() / count);
            let centred: Field =
                given.as_slice().iter().map(|x| [0, 1, 2].map(|k| x[k] - mean[k])).collect::<Vec<_>>().into();
            let rest: Field =
                found.iter().map(|(v, x)| [0, 1, 2].map(|k| x[k] - centred[v][k])).collect::<Vec<_>>().into();
            let square = |x: &Field| dot(x, &metric.product(x).unwrap());
            assert!(square(&rest) < 1e-8 * square(&centred), "{what}: {}", square(&rest) / square(&centred));
        }
    }
}

#[test]
fn faults_are_refused() {
    let mesh = shapes::icosphere(1).unwrap();
    for separation in [0.0, -1.0, 2.0, f64::NAN] {
        let fault = Metric::new(&mesh, &MetricOptions::default().with_separation(separation)).err().unwrap();
        assert!(matches!(fault, RepulsiveError::Separation { .. }), "{fault}");
    }
    let empty = TriangleMesh::new(vec![], vec![]).unwrap();
    let fault = Metric::new(&empty, &MetricOptions::default()).err().unwrap();
    assert_eq!(fault, RepulsiveError::NoFaces);
}
