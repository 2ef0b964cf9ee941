//! The flow: energies fall, quantities are kept, nothing collides, and it continues bit for bit.

mod tangent;

use eikona::mesh::{TriangleMesh, Vertex, damage, shapes};
use eikona::repulsive::{
    Barycentre, Exponents, Flow, FlowOptions, Growth, Pin, Potential, Quantity, RepulsiveError,
};
use eikona::spatial::{intersections_with, self_distance, self_intersections};
use tangent::{moved, together, two_spheres};

fn two_round_spheres(gap: f64) -> TriangleMesh {
    let sphere = shapes::icosphere(2).unwrap();
    let at = |x: f64| moved(&sphere, |p| [p[0] + x, p[1], p[2]]);
    together(&at(-1.0 - 0.5 * gap), &at(1.0 + 0.5 * gap))
}

fn barycentre(mesh: &TriangleMesh) -> [f64; 3] {
    let mut sum = [0.0; 4];
    for f in mesh.faces() {
        let [a, b, c] = mesh.face_positions(f);
        let area = Quantity::Area.of(&TriangleMesh::new(vec![a, b, c], vec![[0, 1, 2]]).unwrap());
        (0..3).for_each(|k| sum[k] += area * (a[k] + b[k] + c[k]) / 3.0);
        sum[3] += area;
    }
    [0, 1, 2].map(|k| sum[k] / sum[3])
}

#[test]
fn the_energy_falls_and_quantities_are_kept() {
    for (what, mesh, keep, steps, share) in [
        ("linked rings", shapes::linked_rings(2, 0.3, 28, 11).unwrap(), vec![Quantity::Area], 10, 0.92),
        ("two spheres", two_round_spheres(0.1), vec![Quantity::Area, Quantity::Volume], 5, 0.4),
        (
            "open",
            shapes::cylinder(1.0, 4.0, 30, 20, shapes::Ends::Open).unwrap(),
            vec![Quantity::Area],
            10,
            0.95,
        ),
        // Found by fuzzing: the cone over an open surface changes as the barycentre is held.
        (
            "open, with its volume",
            moved(&shapes::cylinder(1.0, 4.0, 30, 20, shapes::Ends::Open).unwrap(), |[x, y, z]| {
                [x + 1.0, y, z + 2.0]
            }),
            vec![Quantity::Area, Quantity::Volume],
            3,
            0.999,
        ),
    ] {
        let mut flow = Flow::new(&mesh, &FlowOptions::default().with_keep(keep.clone())).unwrap();
        let (first, mut before) = (flow.energy(), flow.energy());
        for _ in 0..steps {
            let step = flow.step().unwrap().unwrap();
            assert!(step.energy == flow.energy() && step.energy < 1.001 * before, "{what}");
            assert!(step.deviation <= 1e-9 && step.descent > 0.0, "{what}");
            before = step.energy;
        }
        assert!(before < share * first, "{what}: {before} of {first}");
        for quantity in keep {
            let [kept, given] = [flow.mesh(), &mesh].map(|mesh| quantity.of(mesh));
            assert!((kept / given - 1.0).abs() < 1e-8, "{what}: {kept} {given}");
        }
        let [kept, given] = [flow.mesh(), &mesh].map(barycentre);
        (0..3).for_each(|k| assert!((kept[k] - given[k]).abs() < 1e-9, "{what}"));
    }
}

#[test]
fn a_bumpy_sphere_becomes_round() {
    let sphere = shapes::icosphere(3).unwrap();
    let bumpy = moved(&sphere, |[x, y, z]| {
        let r = 1.0 + 0.3 * (3.0 * x).sin() * (2.0 * y + z).cos();
        [1.3 * r * x, r * y, 0.9 * r * z]
    });
    let mut flow = Flow::new(&bumpy, &FlowOptions::default()).unwrap();
    for _ in 0..40 {
        if flow.step().unwrap().is_none() {
            break;
        }
    }
    // Of area A, the sphere has the least energy: pi^2 / 4 for the unit sphere, of degree -2.
    let area = Quantity::Area.of(flow.mesh());
    let radius = (area / (4.0 * std::f64::consts::PI)).sqrt();
    let limit = 2.504 * radius.powi(-2);
    assert!((flow.energy() / limit - 1.0).abs() < 0.01, "{} {limit}", flow.energy());
    let centre = barycentre(flow.mesh());
    for p in flow.mesh().positions() {
        let away = [0, 1, 2].map(|k| p[k] - centre[k]).iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!((away / radius - 1.0).abs() < 0.05, "{away} {radius}");
    }
}

#[test]
fn threads_do_not_matter() {
    // Large enough for all that threads share.
    let mesh = damage::jitter(&shapes::linked_rings(2, 0.3, 100, 40).unwrap(), 0.3, 1).unwrap();
    let room = moved(&shapes::icosphere(4).unwrap(), |p| p.map(|x| 4.0 * x));
    let options = FlowOptions::default()
        .with_keep(vec![Quantity::Area, Quantity::Volume])
        .with_potentials(vec![Potential::obstacle(1.0, &room, 6.0).unwrap()])
        .with_obstacle(Some(room));
    let state = |threads: usize| {
        let mut flow = Flow::new(&mesh, &options.clone().with_threads(threads)).unwrap();
        for _ in 0..2 {
            let step = flow.step().unwrap().unwrap();
            assert!(step.remeshing.is_some_and(|counts| counts.changed()));
        }
        flow.state()
    };
    let one = state(1);
    for threads in [2, 3] {
        assert!(state(threads) == one, "{threads} threads");
    }
}

#[test]
fn a_flow_continues_bit_for_bit() {
    let mesh = shapes::linked_rings(2, 0.3, 28, 11).unwrap();
    let options = FlowOptions::default();
    let mut whole = Flow::new(&mesh, &options).unwrap();
    let mut first = Flow::new(&mesh, &options.clone().with_threads(2)).unwrap();
    for _ in 0..3 {
        whole.step().unwrap();
        first.step().unwrap();
    }
    let mut second = Flow::resume(&mesh, first.state(), &options).unwrap();
    for _ in 0..3 {
        whole.step().unwrap();
        second.step().unwrap();
    }
    assert!(whole.state() == second.state());
    // A state of other options, or of a broken file.
    let keep = options.clone().with_keep(vec![Quantity::Area, Quantity::Volume]);
    let fault = Flow::resume(&mesh, whole.state(), &keep).err().unwrap();
    assert!(matches!(fault, RepulsiveError::State { .. }), "{fault}");
    let broken = |damage: fn(&mut serde_json::Value)| {
        let mut state = serde_json::to_value(whole.state()).unwrap();
        damage(&mut state);
        Flow::resume(&mesh, serde_json::from_value(state).unwrap(), &options).err().unwrap()
    };
    for fault in [
        broken(|state| state["triangles"][0][0] = 4_000_000_000u32.into()),
        broken(|state| state["memory"]["components"] = serde_json::json!([])),
        broken(|state| state["memory"]["places"][0][0] = 4_000_000_000u32.into()),
    ] {
        assert!(matches!(fault, RepulsiveError::State { .. }), "{fault}");
    }
}

#[test]
fn steps_never_pass_through_the_surface() {
    // Coarse, close and pushed on: without collision detection, faces slip between each other.
    let close = two_spheres(1, 0.02);
    let mut flow = Flow::new(&close, &FlowOptions::default()).unwrap();
    let mut least = self_distance(flow.mesh(), 1).unwrap();
    assert!(least > 0.0);
    for k in 0..10 {
        assert!(flow.step().unwrap().is_some() || k > 3, "no step {k}");
        assert!(self_intersections(flow.mesh(), 1).unwrap().is_empty());
        let distance = self_distance(flow.mesh(), 1).unwrap();
        assert!(distance >= 0.09 * least, "{distance} after {least}");
        least = distance;
    }
}

#[test]
fn exponents_below_4_and_faults() {
    let mesh = damage::jitter(&shapes::torus(1.0, 0.4, 24, 10).unwrap(), 0.2, 3).unwrap();
    let options = FlowOptions::default().with_exponents(Exponents::of_power(3.5).unwrap());
    let mut flow = Flow::new(&mesh, &options).unwrap();
    let before = flow.energy();
    for _ in 0..3 {
        flow.step().unwrap().unwrap();
    }
    assert!(flow.energy() < before);
    let empty = TriangleMesh::new(vec![], vec![]).unwrap();
    assert_eq!(Flow::new(&empty, &options).err().unwrap(), RepulsiveError::NoFaces);
    // A flipped face has no side, three faces at an edge have no surface.
    let flipped = TriangleMesh::new(
        mesh.positions().to_vec(),
        mesh.triangles()
            .iter()
            .enumerate()
            .map(|(f, &[a, b, c])| if f == 7 { [a, c, b] } else { [a, b, c] })
            .collect(),
    )
    .unwrap();
    assert!(Flow::new(&flipped, &options).is_ok());
    let keep = FlowOptions::default().with_keep(vec![Quantity::Volume]);
    let fault = Flow::new(&flipped, &keep).err().unwrap();
    assert!(matches!(fault, RepulsiveError::Inconsistent { .. }), "{fault}");
    let points = vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., -1., 0.], [0., 0., 1.]];
    let book = TriangleMesh::new(points, vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]]).unwrap();
    let fault = Flow::new(&book, &options).err().unwrap();
    assert!(matches!(fault, RepulsiveError::NonmanifoldEdge { .. }), "{fault}");
    // Overlapping spheres are refused with the pairs of faces, except for exponents below 4.
    let crossing = two_round_spheres(-0.3);
    let fault = Flow::new(&crossing, &FlowOptions::default()).err().unwrap();
    let RepulsiveError::Intersecting { pairs } = &fault else { panic!("{fault}") };
    assert!(pairs.len() > 10 && fault.to_string().contains("below 4"), "{fault}");
    assert!(Flow::new(&crossing, &options).is_ok());
    let fault = Flow::new(&mesh, &options.with_separation(3.0)).err().unwrap();
    assert!(fault.to_string().contains("0.2"), "{fault}");
}

/// The direction in which points about the origin are spread least.
fn narrowest_axis(points: &[[f64; 3]]) -> [f64; 3] {
    let entry = |i: usize, j: usize| points.iter().map(|p| p[i] * p[j]).sum::<f64>();
    let trace: f64 = (0..3).map(|k| entry(k, k)).sum();
    let matrix = [0, 1, 2].map(|i| [0, 1, 2].map(|j| if i == j { trace } else { 0.0 } - entry(i, j)));
    let mut axis = [0.1, 0.2, 0.97];
    for _ in 0..2000 {
        let image = matrix.map(|row| (0..3).map(|k| row[k] * axis[k]).sum::<f64>());
        let length = image.iter().map(|x| x * x).sum::<f64>().sqrt();
        axis = image.map(|x| x / length);
    }
    axis
}

/// The radii of the torus of revolution that fits points about the origin best, and its largest
/// distance from them as a share of the smaller radius.
fn fitted_torus(points: &[[f64; 3]]) -> (f64, f64, f64) {
    let axis = narrowest_axis(points);
    // Distance from the axis, and along it.
    let turned: Vec<[f64; 3]> = points
        .iter()
        .map(|p| {
            let along: f64 = (0..3).map(|k| p[k] * axis[k]).sum();
            let squared: f64 = p.iter().map(|x| x * x).sum();
            [(squared - along * along).max(0.0).sqrt(), 0.0, along]
        })
        .collect();
    let points = turned.as_slice();
    // rho^2 + z^2 = 2 R rho + (r^2 - R^2) is linear in both coefficients.
    let rows = points.iter().map(|[x, y, z]| (x.hypot(*y), x * x + y * y + z * z));
    let (mut n, mut s, mut ss, mut t, mut st) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (rho, squared) in rows {
        (n, s, ss, t, st) = (n + 1.0, s + rho, ss + rho * rho, t + squared, st + rho * squared);
    }
    let slope = (n * st - s * t) / (n * ss - s * s);
    let major = 0.5 * slope;
    let minor = ((t - slope * s) / n + major * major).sqrt();
    let off = |[x, y, z]: &[f64; 3]| ((x.hypot(*y) - major).hypot(*z) / minor - 1.0).abs();
    (major, minor, points.iter().map(off).fold(0.0, f64::max))
}

#[test]
fn a_bumpy_torus_becomes_one_of_revolution() {
    let torus = shapes::torus(1.0, 0.3, 60, 20).unwrap();
    let bumpy = moved(&torus, |[x, y, z]| {
        [1.2 * x + 0.05 * (4.0 * y).sin(), y, z + 0.1 * (2.0 * x).cos() + 0.05 * (3.0 * y).sin()]
    });
    let mut flow = Flow::new(&bumpy, &FlowOptions::default()).unwrap();
    for _ in 0..150 {
        if flow.step().unwrap().is_none() {
            break;
        }
    }
    let centre = barycentre(flow.mesh());
    let points: Vec<[f64; 3]> =
        flow.mesh().positions().iter().map(|p| [0, 1, 2].map(|k| p[k] - centre[k])).collect();
    let (major, minor, off) = fitted_torus(&points);
    println!("ratio of the radii {}, off by {off}", major / minor);
    // Its section is close to a circle, not quite one.
    assert!(off < 0.08, "{major} {minor} {off}");
    assert!((1.3..1.7).contains(&(major / minor)), "{}", major / minor);
}

#[test]
fn pins_hold_and_barycentres_of_components_stay() {
    let two = two_round_spheres(0.5);
    let options = FlowOptions::default().with_barycentre(Barycentre::PerComponent);
    let mut flow = Flow::new(&two, &options).unwrap();
    let centres = |mesh: &TriangleMesh| -> Vec<f64> {
        let topology = eikona::mesh::Topology::of(mesh);
        (0..2)
            .flat_map(|c| {
                let part = mesh.faces().filter(|f| topology.component_of_face[*f] == c);
                let faces = part.map(|f| mesh.triangles()[f.0 as usize]).collect();
                barycentre(&TriangleMesh::new(mesh.positions().to_vec(), faces).unwrap())
            })
            .collect()
    };
    let before = centres(flow.mesh());
    for _ in 0..4 {
        flow.step().unwrap().unwrap();
    }
    for (before, after) in before.iter().zip(centres(flow.mesh())) {
        assert!((before - after).abs() < 1e-7, "{before} {after}");
    }
    // Pins are exact, also where remeshing changes the numbers.
    let pins = [0, 5, 9].map(|v| Pin::still(Vertex(v)));
    let options = FlowOptions::default()
        .with_pins(pins.to_vec())
        .with_growth(vec![Growth { quantity: Quantity::Area, times: 2.0, plus: 0.0, steps: 4 }])
        .with_keep(vec![]);
    let sphere = shapes::icosphere(2).unwrap();
    let mut flow = Flow::new(&sphere, &options).unwrap();
    assert!(flow.is_growing());
    for _ in 0..6 {
        flow.step().unwrap();
    }
    assert!(!flow.is_growing());
    let [grown, first] = [flow.mesh(), &sphere].map(|mesh| Quantity::Area.of(mesh));
    assert!((grown / first - 2.0).abs() < 1e-8, "{grown} {first}");
    for pin in pins {
        assert!(flow.mesh().positions().contains(&sphere.position(pin.vertex)));
    }
    let fault = |options: FlowOptions| Flow::new(&sphere, &options).err().unwrap().to_string();
    assert!(fault(options.clone().with_pins(vec![Pin::still(Vertex(999))])).contains("162 vertices"));
    assert!(fault(options.clone().with_pins(vec![pins[0], pins[0]])).contains("pinned twice"));
    let growth = Growth { quantity: Quantity::Area, times: f64::NAN, plus: 0.0, steps: 4 };
    assert!(fault(options.with_growth(vec![growth])).contains("area grows to NaN"));
}

#[test]
fn a_surface_never_passes_an_obstacle() {
    // A sphere grows between two walls that do not repel it, finely meshed and coarsely.
    for levels in [1, 3] {
        let sphere = shapes::icosphere(levels).unwrap();
        let wall = |x: f64| {
            let square = shapes::grid(4, 4, 8.0, 8.0, shapes::Diagonal::Alternating).unwrap();
            moved(&square, |[y, z, _]| [x, y - 4.0, z - 4.0])
        };
        let walls = together(&wall(-1.2), &wall(1.2));
        let options = FlowOptions::default()
            .with_obstacle(Some(walls.clone()))
            .with_keep(vec![])
            .with_growth(vec![Growth { quantity: Quantity::Volume, times: 2.0, plus: 0.0, steps: 10 }]);
        let mut flow = Flow::new(&sphere, &options).unwrap();
        for _ in 0..15 {
            if flow.step().unwrap().is_none() {
                break;
            }
            assert!(intersections_with(flow.mesh(), &walls, 1).unwrap().is_empty());
        }
        assert!(flow.mesh().positions().iter().all(|p| p[0].abs() < 1.2));
        let inside = FlowOptions::default().with_obstacle(Some(wall(0.1)));
        let fault = Flow::new(&sphere, &inside).err().unwrap();
        assert!(matches!(fault, RepulsiveError::IntersectsObstacle { .. }), "{fault}");
    }
}

/// The volume of a surface with boundary changes with a translation, also with the one that holds
/// its barycentre (RS figure 20).
#[test]
fn surfaces_with_boundary_are_remeshed_while_their_volume_falls() {
    let mesh = shapes::punctured_torus(1.0, 0.45, 0.8, 48, 22).unwrap();
    let falls = Growth { quantity: Quantity::Volume, times: 1.0, plus: -7.3, steps: 300 };
    let potentials = vec![Potential::boundary_length(3.0, 2.5), Potential::boundary_curvature(0.02)];
    let options = FlowOptions::default().with_growth(vec![falls]).with_potentials(potentials);
    let mut flow = Flow::new(&mesh, &options).unwrap();
    let before = Quantity::Volume.of(&mesh);
    let mut remeshed = 0;
    for _ in 0..45 {
        let step = flow.step().unwrap().unwrap();
        remeshed += usize::from(step.remeshing.is_some());
        assert!(step.deviation < 1e-8, "{}", step.deviation);
    }
    assert!(remeshed >= 40, "{remeshed}");
    let fallen = before - Quantity::Volume.of(flow.mesh());
    assert!((fallen - 7.3 * 45.0 / 300.0).abs() < 1e-6, "{fallen}");
}
