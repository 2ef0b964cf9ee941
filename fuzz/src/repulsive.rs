//! Energies, motions and flows of small meshes of any shape.

use crate::choices::Choices;
use crate::polar_field::mesh;
use eikona::repulsive::{
    EnergyOptions, Exponents, Flow, FlowOptions, Metric, MetricOptions, Pairs, Quantity, tangent_point_energy,
};
use eikona::spatial::{safe_motion, self_distance, self_intersections};
use eikona_mesh::{TriangleMesh, VertexField};

/// Computes everything, and checks properties of what is finite.
///
/// # Panics
/// If a property is violated.
pub fn check(bytes: &[u8]) {
    let mut choices = Choices::new(bytes);
    let [alpha, beta] = match choices.below(8) {
        0..=2 => [6.0, 12.0],
        3 => [4.0, 8.0],
        4 => [3.5, 7.0],
        5 => [2.5, 5.0],
        6 => [7.0, 11.5],
        _ => [choices.wild_float(), choices.wild_float()],
    };
    let Ok(mesh) = mesh(&mut choices) else { return };
    let crossing = self_intersections(&mesh, 1).expect("nothing stops it");
    assert!(crossing.windows(2).all(|pair| pair[0] < pair[1]) && crossing.iter().all(|[f, g]| f < g));
    let distance = self_distance(&mesh, 1).expect("nothing stops it");
    assert!(distance >= 0.0, "{distance}");
    check_motion(&mut choices, &mesh);
    let exponents = match Exponents::new(alpha, beta) {
        Ok(exponents) => exponents,
        Err(fault) => return assert!(!fault.to_string().is_empty()),
    };
    check_energy(&mesh, exponents);
    let keep = [vec![Quantity::Area], vec![], vec![Quantity::Volume], vec![Quantity::Area, Quantity::Volume]];
    let keep = keep[choices.below(4)].clone();
    let options = FlowOptions::default().with_exponents(exponents).with_keep(keep);
    check_flow(&mesh, &options);
}

fn is_ordinary(mesh: &TriangleMesh) -> bool {
    let moderate = |x: &f64| *x == 0.0 || (1e-6..1e6).contains(&x.abs());
    mesh.positions().iter().flatten().all(moderate)
}

fn check_motion(choices: &mut Choices, mesh: &TriangleMesh) {
    let size = choices.of([0.1, 1.0, 100.0, 0.0]);
    let motion: Vec<[f64; 3]> =
        (0..mesh.vertex_count()).map(|_| [(); 3].map(|()| size * (choices.share() - 0.5))).collect();
    let safe = safe_motion(mesh, &motion, 1).expect("nothing stops it");
    assert!((0.0..=1.0).contains(&safe.share), "{safe:?}");
    assert!(safe.share < 1.0 || safe.contact.is_none(), "{safe:?}");
}

fn check_energy(mesh: &TriangleMesh, exponents: Exponents) {
    let options = EnergyOptions::default().with_exponents(exponents);
    let energies =
        [Pairs::All, Pairs::Hierarchical].map(|pairs| tangent_point_energy(mesh, &options.with_pairs(pairs)));
    let [all, near] = match energies {
        [Ok(all), Ok(near)] => [all, near],
        [Err(fault), Err(_)] => return assert!(!fault.to_string().is_empty()),
        [all, near] => {
            let [all, near] = [all, near].map(|energy| energy.map(|energy| energy.value));
            return assert!(!is_ordinary(mesh), "only one is computed: {all:?} {near:?}");
        }
    };
    assert!(all.value >= 0.0 && all.value.is_finite(), "{}", all.value);
    if is_ordinary(mesh) {
        let off = (all.value - near.value).abs();
        assert!(off <= 0.05 * all.value + 1e-200, "{} {}", all.value, near.value);
    }
    if let Ok(metric) = Metric::new(mesh, &MetricOptions::default().with_exponents(exponents)) {
        let square = |field: Vec<[f64; 3]>| -> f64 {
            let field = VertexField::from(field);
            let image = metric.product(&field).expect("nothing stops it");
            image.iter().flat_map(|(v, y)| [0, 1, 2].map(|k| y[k] * field[v][k])).sum()
        };
        // That of the positions may be zero up to rounding, that of a rough field not.
        let largest = mesh.positions().iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
        let rough = |v: usize| [0, 1, 2].map(|k| largest * (7.0 * v as f64 + 3.0 * k as f64).sin());
        let found = square(mesh.positions().to_vec());
        let size = square((0..mesh.vertex_count()).map(rough).collect());
        assert!(!is_ordinary(mesh) || found.is_nan() || found >= -1e-9 * size, "{found} {size}");
    }
}

fn check_flow(mesh: &TriangleMesh, options: &FlowOptions) {
    let mut flow = match Flow::new(mesh, options) {
        Ok(flow) => flow,
        Err(fault) => return assert!(!fault.to_string().is_empty()),
    };
    let crossing = self_intersections(mesh, 1).expect("nothing stops it").len();
    let given: Vec<f64> = options.keep.iter().map(|quantity| quantity.of(mesh)).collect();
    for _ in 0..2 {
        match flow.step() {
            Ok(Some(step)) => assert!(step.energy.is_finite() && step.deviation <= 1e-9, "{step:?}"),
            Ok(None) => return,
            Err(fault) => return assert!(!fault.to_string().is_empty()),
        }
        if !is_ordinary(mesh) {
            return;
        }
        let now = self_intersections(flow.mesh(), 1).expect("nothing stops it").len();
        assert!(now == 0 || crossing > 0, "{now} new intersections");
        for (quantity, given) in options.keep.iter().zip(&given) {
            let size = Quantity::Area.of(mesh).powf(if *quantity == Quantity::Area { 1.0 } else { 1.5 });
            assert!((quantity.of(flow.mesh()) - given).abs() <= 1e-8 * size, "{quantity:?}");
        }
    }
}
