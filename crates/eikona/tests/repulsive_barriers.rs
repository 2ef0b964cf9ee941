//! Implicit surfaces that repel are never passed, however long the step and however weak they are.

use eikona::mesh::{TriangleMesh, shapes};
use eikona::repulsive::{
    Barycentre, Flow, FlowOptions, ImplicitSurface, Method, Potential, Remeshing, RepulsiveError,
};

/// A sphere that is drawn to a plane behind a barrier, which hardly repels.
fn drawn(mesh: &TriangleMesh, barrier: ImplicitSurface, collisions: bool) -> Flow {
    let goal = ImplicitSurface::Plane { point: [6.0, 0.0, 0.0], normal: [1.0, 0.0, 0.0] };
    let potentials = vec![Potential::attract_to(50.0, goal, 2.0), Potential::repel_from(1e-9, barrier, 1.0)];
    let options = FlowOptions::default()
        .with_potentials(potentials)
        .with_barycentre(Barycentre::Free)
        .with_collisions(collisions)
        .with_remeshing(Remeshing::Off);
    Flow::new(mesh, &options).unwrap()
}

fn sphere() -> TriangleMesh {
    shapes::icosphere(2).unwrap()
}

#[test]
fn a_long_step_stops_before_a_plane() {
    let wall = ImplicitSurface::Plane { point: [1.5, 0.0, 0.0], normal: [1.0, 0.0, 0.0] };
    let farthest = |flow: &Flow| flow.mesh().positions().iter().map(|p| p[0]).fold(f64::MIN, f64::max);
    let mut free = drawn(&sphere(), wall.clone(), false);
    let mut held = drawn(&sphere(), wall, true);
    let mut limited = 0;
    for _ in 0..8 {
        free.step().unwrap();
        limited += held.step().unwrap().map_or(0, |step| usize::from(step.limited_by_collision));
        assert!(farthest(&held) < 1.5, "{}", farthest(&held));
    }
    assert!(farthest(&free) > 1.5 && limited > 0, "{} {limited}", farthest(&free));
}

/// Whether a face meets the line through (x, 0) along z.
fn is_pierced(mesh: &TriangleMesh, x: f64) -> bool {
    mesh.faces().any(|f| {
        let corners = mesh.face_positions(f).map(|p| [p[0] - x, p[1]]);
        let side = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
        let sides = [0, 1, 2].map(|k| side(corners[k], corners[(k + 1) % 3]));
        sides.iter().all(|s| *s > 0.0) || sides.iter().all(|s| *s < 0.0)
    })
}

#[test]
fn no_face_passes_a_pole_that_is_thinner_than_it() {
    let pole = ImplicitSurface::Cylinder { point: [1.5, 0.0, 0.0], axis: [0.0, 0.0, 1.0], radius: 0.01 };
    let mut free = drawn(&sphere(), pole.clone(), false);
    let mut held = drawn(&sphere(), pole, true);
    let (mut pierced, mut limited) = (false, 0);
    for _ in 0..8 {
        free.step().unwrap();
        pierced |= is_pierced(free.mesh(), 1.5);
        limited += held.step().unwrap().map_or(0, |step| usize::from(step.limited_by_collision));
        assert!(!is_pierced(held.mesh(), 1.5));
    }
    let centre =
        |mesh: &TriangleMesh| mesh.positions().iter().map(|p| p[0]).sum::<f64>() / mesh.vertex_count() as f64;
    assert!(pierced || centre(free.mesh()) > 2.5, "{}", centre(free.mesh()));
    assert!(limited > 0 && centre(held.mesh()) < 1.5);
}

#[test]
fn surfaces_on_both_sides_of_a_barrier_are_refused() {
    let with = |surface: ImplicitSurface, weight: f64, collisions: bool| {
        let potentials = vec![Potential::repel_from(weight, surface, 2.0)];
        let options = FlowOptions::default().with_potentials(potentials).with_collisions(collisions);
        Flow::new(&sphere(), &options).err()
    };
    let plane = ImplicitSurface::Plane { point: [0.0, 0.0, 0.2345], normal: [0.0, 0.0, 1.0] };
    let fault = with(plane.clone(), 1.0, true).unwrap();
    let RepulsiveError::EdgeThroughBarrier { vertices, distances } = &fault else { panic!("{fault}") };
    assert!(distances[0] * distances[1] < 0.0);
    let text = fault.to_string();
    for word in [vertices[0].to_string(), distances[1].to_string(), "one side".into()] {
        assert!(text.contains(&word), "{text}");
    }
    assert_eq!(with(plane, 1.0, false), None);
    // Through the middle of a face: no corner knows of it.
    let mesh = sphere();
    let centre = mesh.faces().map(|f| mesh.face_positions(f)).next().unwrap();
    let centre = [0, 1, 2].map(|k| centre.iter().map(|p| p[k]).sum::<f64>() / 3.0);
    let needle = ImplicitSurface::Cylinder { point: centre, axis: centre, radius: 1e-3 };
    let fault = with(needle.clone(), 1.0, true).unwrap();
    assert!(matches!(fault, RepulsiveError::FaceAtBarrier { .. }), "{fault}");
    // What attracts, or does not act, is no barrier.
    assert_eq!(with(needle, 0.0, true), None);
    // A room around the surface is none that it passes through.
    assert_eq!(with(ImplicitSurface::Sphere { centre: [0.0; 3], radius: 1.01 }, 1e-6, true), None);
}

#[test]
fn the_willmore_method_stops_at_a_barrier_too() {
    let wall = ImplicitSurface::Plane { point: [0.0, 0.0, 1.05], normal: [0.0, 0.0, 1.0] };
    let flat: Vec<[f64; 3]> = sphere().positions().iter().map(|p| [1.5 * p[0], 1.5 * p[1], p[2]]).collect();
    let flat = sphere().with_positions(flat).unwrap();
    let options = FlowOptions::default().with_method(Method::Willmore);
    let highest = |flow: &Flow| flow.mesh().positions().iter().map(|p| p[2]).fold(f64::MIN, f64::max);
    let run = |options: &FlowOptions| {
        let mut flow = Flow::new(&flat, options).unwrap();
        for _ in 0..10 {
            flow.step().unwrap();
        }
        highest(&flow)
    };
    assert!(run(&options) > 1.05);
    let barred = options.with_potentials(vec![Potential::repel_from(1e-9, wall, 1.0)]);
    assert!(run(&barred) < 1.05);
}

/// RS figure 18. At the start, the pole passes through both rings.
#[test]
fn one_handle_of_a_double_torus_comes_off_a_pole() {
    let rings = shapes::joined_rings(1).unwrap();
    let pole = ImplicitSurface::Cylinder { point: [0.0; 3], axis: [0.0, 0.0, 1.0], radius: 0.3 };
    let ground = ImplicitSurface::Plane { point: [0.0; 3], normal: [0.0, 0.0, 1.0] };
    let potentials = vec![Potential::repel_from(0.1, pole, 2.0), Potential::attract_to(0.1, ground, 2.0)];
    let options = FlowOptions::default().with_potentials(potentials).with_barycentre(Barycentre::Free);
    let mut flow = Flow::new(&rings, &options).unwrap();
    let mut remeshed = 0;
    let steps = 200;
    for _ in 0..steps {
        let step = flow.step().unwrap().unwrap();
        remeshed += usize::from(step.remeshing.is_some());
    }
    // Next to the pole, remeshing puts no vertex where the potential is much higher.
    assert!(remeshed > steps * 9 / 10, "{remeshed}");
    let positions = flow.mesh().positions();
    let away = positions.iter().map(|p| p[0].hypot(p[1])).fold(f64::MAX, f64::min);
    assert!(away > 0.5, "{away}");
    // The pole is in one hole: the directions to all vertices surround it. The other hole lies
    // beside. At the start, the rings lay above each other and around the pole, 2 from the ground.
    let thick = positions.iter().map(|p| p[2].abs()).fold(0.0, f64::max);
    let centre = positions.iter().map(|p| p[0]).sum::<f64>() / positions.len() as f64;
    assert!(thick < 1.6 && centre.abs() > 1.0, "{thick} {centre}");
    let mut directions: Vec<f64> = positions.iter().map(|p| p[1].atan2(p[0])).collect();
    directions.sort_unstable_by(f64::total_cmp);
    let gap = directions.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    assert!(gap < 0.3, "{gap}");
}
