//! The descent methods: energies fall, areas are kept, nothing collides, directions solve what they
//! say, and flows continue bit for bit.

mod tangent;

use eikona::geometry::lay_out;
use eikona::mesh::{TriangleMesh, Vertex, shapes};
use eikona::operators::CotanLaplacian;
use eikona::repulsive::{
    Barycentre, EnergyOptions, Flow, FlowOptions, Growth, Method, Pin, Potential, Quantity, Remeshing,
    RepulsiveError, tangent_point_energy,
};
use eikona::spatial::{self_distance, self_intersections};
use std::f64::consts::PI;
use tangent::two_spheres;

type Vec3 = [f64; 3];

/// The methods that descend the tangent-point energy. The Willmore energy does not keep parts of a
/// surface apart: its steps end where collisions end them.
fn repulsive() -> impl Iterator<Item = Method> {
    Method::ALL.into_iter().filter(|method| *method != Method::Willmore)
}

fn flow_of(mesh: &TriangleMesh, method: Method) -> Flow {
    Flow::new(mesh, &FlowOptions::default().with_method(method)).unwrap()
}

#[test]
fn the_energy_falls_and_the_area_is_kept() {
    let rings = shapes::linked_rings(2, 0.3, 28, 11).unwrap();
    let bumpy = shapes::bumpy_sphere(8, 0.3, 4.0).unwrap();
    for method in repulsive() {
        for (what, mesh) in [("rings", &rings), ("bumpy", &bumpy)] {
            for remeshing in [Remeshing::Uniform { length: None }, Remeshing::Off] {
                let options = FlowOptions::default().with_method(method).with_remeshing(remeshing);
                let mut flow = Flow::new(mesh, &options).unwrap();
                let (first, mut before) = (flow.energy(), flow.energy());
                for k in 0..12 {
                    let step = flow.step().unwrap().unwrap_or_else(|| panic!("{method} {what} step {k}"));
                    assert!(step.energy < 1.02 * before && step.descent > 0.0, "{method} {what}");
                    before = step.energy;
                }
                let least = if method == Method::L2 { 0.995 } else { 0.93 };
                assert!(before < least * first, "{method} {what} {remeshing:?}: {before} of {first}");
                let [kept, given] = [flow.mesh(), mesh].map(|mesh| Quantity::Area.of(mesh));
                assert!((kept / given - 1.0).abs() < 1e-8, "{method} {what}: {kept} {given}");
                assert!(self_intersections(flow.mesh(), 1).unwrap().is_empty(), "{method} {what}");
            }
        }
    }
}

#[test]
fn the_willmore_method_makes_spheres_round_and_tori_those_of_clifford() {
    let sphere = shapes::bumpy_sphere(20, 0.2, 3.0).unwrap();
    let torus = shapes::torus(1.0, 0.45, 60, 28).unwrap();
    for (mesh, least) in [(sphere, 16.0 * PI), (torus, 8.0 * PI * PI)] {
        for remeshing in [Remeshing::Uniform { length: None }, Remeshing::Off] {
            let options = FlowOptions::default().with_method(Method::Willmore).with_remeshing(remeshing);
            let mut flow = Flow::new(&mesh, &options).unwrap();
            assert!(flow.energy() > 1.05 * least);
            for _ in 0..20 {
                flow.step().unwrap();
            }
            let willmore = Potential::willmore(1.0).value(flow.mesh()).unwrap();
            assert_eq!(flow.energy(), willmore);
            assert!((willmore / least - 1.0).abs() < 0.02, "{remeshing:?}: {willmore} of {least}");
            let [kept, given] = [flow.mesh(), &mesh].map(|mesh| Quantity::Area.of(mesh));
            assert!((kept / given - 1.0).abs() < 1e-8, "{kept} {given}");
        }
    }
}

#[test]
fn a_willmore_penalty_does_not_shorten_steps_on_finer_meshes() {
    let mean_step = |nu: usize, nv: usize| {
        let torus = shapes::torus(1.0, 0.3, nu, nv).unwrap();
        let options = FlowOptions::default()
            .with_potentials(vec![Potential::willmore(1000.0)])
            .with_remeshing(Remeshing::Off);
        let mut flow = Flow::new(&torus, &options).unwrap();
        (0..5).map(|_| flow.step().unwrap().unwrap().step_size).sum::<f64>() / 5.0
    };
    // Without the bi-Laplacian, steps are about 0.001.
    for (nu, nv) in [(40, 12), (80, 24)] {
        assert!(mean_step(nu, nv) > 0.05, "{nu}: {}", mean_step(nu, nv));
    }
}

#[test]
fn surfaces_that_cross_themselves_flow_by_the_willmore_method() {
    let crossing = two_spheres(1, -0.3);
    let options = FlowOptions::default().with_method(Method::Willmore);
    let fault = Flow::new(&crossing, &options).err().unwrap();
    assert!(matches!(fault, RepulsiveError::Intersecting { .. }), "{fault}");
    assert!(Flow::new(&crossing, &options.with_collisions(false)).is_ok());
}

#[test]
fn what_is_remembered_helps() {
    // Without remeshing, which makes methods forget.
    let rings = shapes::linked_rings(2, 0.3, 28, 11).unwrap();
    let after = |method: Method| {
        let options = FlowOptions::default().with_method(method).with_remeshing(Remeshing::Off);
        let mut flow = Flow::new(&rings, &options).unwrap();
        for _ in 0..30 {
            flow.step().unwrap();
        }
        flow.energy()
    };
    let plain = after(Method::H1);
    for method in [Method::Aqp, Method::H1Lbfgs, Method::Bqn] {
        assert!(after(method) < plain, "{method}: {} {plain}", after(method));
    }
}

#[test]
fn flows_continue_bit_for_bit() {
    let mesh = shapes::linked_rings(2, 0.3, 28, 11).unwrap();
    for method in Method::ALL {
        for remeshing in [Remeshing::Uniform { length: None }, Remeshing::Off] {
            let options = FlowOptions::default().with_method(method).with_remeshing(remeshing);
            let mut whole = Flow::new(&mesh, &options).unwrap();
            let mut first = Flow::new(&mesh, &options.clone().with_threads(2)).unwrap();
            for _ in 0..4 {
                whole.step().unwrap();
                first.step().unwrap();
            }
            let text = serde_json::to_string(&first.state()).unwrap();
            let state = serde_json::from_str(&text).unwrap();
            let mut second = Flow::resume(&mesh, state, &options).unwrap();
            for _ in 0..3 {
                whole.step().unwrap();
                second.step().unwrap();
            }
            assert!(whole.state() == second.state(), "{method} {remeshing:?}");
        }
    }
}

#[test]
fn states_of_other_methods_are_refused() {
    let mesh = shapes::linked_rings(2, 0.3, 28, 11).unwrap();
    let options = FlowOptions::default().with_remeshing(Remeshing::Off);
    let state = |method: Method| {
        let mut flow = Flow::new(&mesh, &options.clone().with_method(method)).unwrap();
        flow.step().unwrap();
        flow.step().unwrap();
        flow.state()
    };
    let refused = |method: Method, state| {
        let fault = Flow::resume(&mesh, state, &options.clone().with_method(method)).err().unwrap();
        assert!(matches!(fault, RepulsiveError::State { .. }), "{fault}");
        assert!(fault.to_string().contains(&format!("the method {method}")), "{fault}");
    };
    refused(Method::Fractional, state(Method::H1Lbfgs));
    refused(Method::Aqp, state(Method::Bqn));
    refused(Method::H1Lbfgs, state(Method::Aqp));
    let mut broken = serde_json::to_value(state(Method::Bqn)).unwrap();
    broken["memory"]["history"]["steps"][0]["motion"] = serde_json::json!([]);
    refused(Method::Bqn, serde_json::from_value(broken).unwrap());
    // States of before there were methods.
    let mut old = serde_json::to_value(state(Method::Fractional)).unwrap();
    old["memory"].as_object_mut().unwrap().remove("history");
    assert!(Flow::resume(&mesh, serde_json::from_value(old).unwrap(), &options).is_ok());
}

#[test]
fn pins_and_barycentres_stay() {
    let mesh = shapes::linked_rings(2, 0.3, 28, 11).unwrap();
    let pins = [0, 100, 400].map(Vertex);
    for method in repulsive() {
        let options = FlowOptions::default().with_method(method).with_remeshing(Remeshing::Off);
        let pinned = options.clone().with_pins(pins.map(Pin::still).to_vec());
        let mut flow = Flow::new(&mesh, &pinned).unwrap();
        let first = flow.energy();
        for _ in 0..5 {
            flow.step().unwrap().unwrap();
        }
        assert!(flow.energy() < first, "{method}");
        for v in pins {
            assert_eq!(flow.mesh().position(v), mesh.position(v), "{method}");
        }
        // One that moves.
        let moving = Pin { vertex: Vertex(0), motion: [0.05, 0.0, 0.02], steps: 4 };
        let mut flow =
            Flow::new(&mesh, &options.clone().with_pins(vec![moving, Pin::still(Vertex(200))])).unwrap();
        for _ in 0..40 {
            if !flow.is_growing() {
                break;
            }
            flow.step().unwrap();
        }
        let [there, start] = [flow.mesh(), &mesh].map(|mesh| mesh.position(Vertex(0)));
        let off = (0..3).map(|k| (there[k] - start[k] - moving.motion[k]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-12, "{method}: {off}");
        // Barycentres of components, where L-BFGS mixes coordinates.
        let mut flow = Flow::new(&mesh, &options.with_barycentre(Barycentre::PerComponent)).unwrap();
        for _ in 0..5 {
            let step = flow.step().unwrap().unwrap();
            assert!(step.deviation <= 1e-9, "{method}");
        }
        assert!(flow.energy() < first, "{method}");
    }
}

#[test]
fn surfaces_grow_by_any_method() {
    let mesh = shapes::bumpy_sphere(6, 0.2, 3.0).unwrap();
    let growth = Growth { quantity: Quantity::Area, times: 1.3, plus: 0.0, steps: 5 };
    for method in Method::ALL {
        let options = FlowOptions::default().with_method(method).with_growth(vec![growth]);
        let mut flow = Flow::new(&mesh, &options).unwrap();
        for _ in 0..8 {
            flow.step().unwrap();
        }
        let [grown, given] = [flow.mesh(), &mesh].map(|mesh| Quantity::Area.of(mesh));
        assert!((grown / given / 1.3 - 1.0).abs() < 1e-8, "{method}: {}", grown / given);
    }
}

#[test]
fn no_method_passes_through_the_surface() {
    let close = two_spheres(1, 0.02);
    for method in Method::ALL {
        let mut flow = flow_of(&close, method);
        let mut least = self_distance(flow.mesh(), 1).unwrap();
        for k in 0..8 {
            assert!(flow.step().unwrap().is_some() || k > 3, "{method}: no step {k}");
            assert!(self_intersections(flow.mesh(), 1).unwrap().is_empty(), "{method}");
            let distance = self_distance(flow.mesh(), 1).unwrap();
            // AQP may come closer twice in a step.
            assert!(distance >= 0.008 * least, "{method}: {distance} after {least}");
            least = distance;
        }
    }
}

/// The Laplacian with the small mass, and the masses.
struct Laplacian {
    cotan: CotanLaplacian,
    masses: Vec<f64>,
}

impl Laplacian {
    fn new(mesh: &TriangleMesh) -> Laplacian {
        let triangles = lay_out(mesh);
        let mut masses = vec![0.0; mesh.vertex_count()];
        for (corners, triangle) in mesh.triangles().iter().zip(&triangles) {
            corners.iter().for_each(|v| masses[*v as usize] += triangle.area / 3.0);
        }
        Laplacian { cotan: CotanLaplacian::new(mesh, &triangles), masses }
    }

    fn product(&self, x: &[Vec3]) -> Vec<Vec3> {
        let area: f64 = self.masses.iter().sum();
        let CotanLaplacian { graph, matrix } = &self.cotan;
        let mut image: Vec<Vec3> =
            (0..x.len()).map(|v| x[v].map(|x| (matrix.diagonal[v] + self.masses[v] / area) * x)).collect();
        for (pair, entry) in graph.pairs.iter().zip(&matrix.off_diagonal) {
            let [i, j] = pair.map(|v| v as usize);
            for k in 0..3 {
                image[i][k] += entry * x[j][k];
                image[j][k] += entry * x[i][k];
            }
        }
        image
    }
}

#[test]
fn directions_solve_what_they_say() {
    // A single pin, and nothing else: the displacement is the step size times the direction.
    let mesh = shapes::bumpy_sphere(8, 0.2, 3.0).unwrap();
    let laplacian = Laplacian::new(&mesh);
    let gradient = tangent_point_energy(&mesh, &EnergyOptions::default().with_separation(0.3)).unwrap();
    let gradient = gradient.differential.as_slice();
    let by_mass = |x: &[Vec3], power: i32| -> Vec<Vec3> {
        x.iter().zip(&laplacian.masses).map(|(x, mass)| x.map(|x| x * mass.powi(power))).collect()
    };
    for method in [Method::L2, Method::H1, Method::H2, Method::Aqp, Method::H1Lbfgs, Method::Bqn] {
        let options = FlowOptions::default()
            .with_method(method)
            .with_keep(vec![])
            .with_pins(vec![Pin::still(Vertex(5))])
            .with_remeshing(Remeshing::Off);
        let mut flow = Flow::new(&mesh, &options).unwrap();
        let step = flow.step().unwrap().unwrap();
        let moved = flow.mesh().positions().iter().zip(mesh.positions());
        let motion: Vec<Vec3> =
            moved.map(|(to, from)| [0, 1, 2].map(|k| (to[k] - from[k]) / step.step_size)).collect();
        let image = match method {
            Method::L2 => by_mass(&motion, 1),
            Method::H2 => {
                let mut inner = by_mass(&laplacian.product(&motion), -1);
                // The Laplacian is measured where vertices move.
                inner[5] = [0.0; 3];
                laplacian.product(&inner)
            }
            _ => laplacian.product(&motion),
        };
        let free = || (0..mesh.vertex_count()).filter(|v| *v != 5).flat_map(|v| (0..3).map(move |k| (v, k)));
        let residual = free().map(|(v, k)| (image[v][k] + gradient[v][k]).powi(2)).sum::<f64>().sqrt();
        let size = free().map(|(v, k)| gradient[v][k].powi(2)).sum::<f64>().sqrt();
        assert!(residual < 1e-6 * size, "{method}: {residual} of {size}");
    }
}
