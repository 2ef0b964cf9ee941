//! Random prescriptions: fields turn as often as prescribed, measured from their values around
//! every element of the mesh and on loops at a distance from the singularities.

mod frames;
mod turning;

use eikona::mesh::random::Random;
use eikona::mesh::shapes::{self, Hole};
use eikona::mesh::{Face, SurfacePoint, Topology, TriangleMesh, Vertex, damage};
use eikona::polar_field::{FieldOptions, Place, PolarField, Singularity, Solver, SolverOptions};
use std::collections::BTreeMap;
use turning::{Element, Loop, grown, turning_elements};

fn surfaces() -> Vec<(&'static str, TriangleMesh)> {
    let rough = |mesh: TriangleMesh, seed: u64| damage::jitter(&mesh, 0.2, seed).unwrap();
    let holes =
        [Hole::Disk { centre: [1.0, 1.1], radius: 0.3 }, Hole::Disk { centre: [2.1, 0.9], radius: 0.25 }];
    vec![
        ("sphere", rough(shapes::icosphere(3).unwrap(), 1)),
        ("torus", rough(shapes::torus(1.0, 0.4, 36, 18).unwrap(), 2)),
        ("double torus", rough(shapes::chain_of_genus(2, 2).unwrap(), 3)),
        ("two holes", rough(shapes::grid_with_holes(36, 24, 3.0, 2.0, &holes).unwrap(), 4)),
    ]
}

/// A prescribed element with its place and its index times N.
#[derive(Clone, Copy, Debug)]
struct Prescribed {
    element: Element,
    place: Place,
    turns: i64,
}

/// Elements that have no vertex in common; the first is away from the others by two edges.
struct Places<'a> {
    mesh: &'a TriangleMesh,
    used: Vec<bool>,
}

impl Places<'_> {
    fn next(&mut self, kind: usize, random: &mut Random) -> (Element, Place) {
        let mesh = self.mesh;
        loop {
            let f = Face(random.below(mesh.face_count()) as u32);
            let corners = mesh.face_vertices(f);
            let vertices = corners.map(|v| v.0);
            let is_bad = |v: &Vertex| mesh.is_boundary_vertex(*v) || self.used[v.index()];
            if grown(mesh, &corners).iter().any(|v| mesh.is_boundary_vertex(*v)) || corners.iter().any(is_bad)
            {
                continue;
            }
            let (element, point) = match kind {
                0 => (Element::Vertex(corners[0]), SurfacePoint::Vertex { vertex: vertices[0] }),
                1 => {
                    let edge = mesh.find_edge(corners[0], corners[1]).unwrap();
                    let t = random.range(0.15, 0.85);
                    (Element::Edge(edge), SurfacePoint::Edge { vertices: [vertices[0], vertices[1]], t })
                }
                _ => {
                    let weights = [0; 3].map(|_| random.range(0.2, 1.0));
                    let sum: f64 = weights.iter().sum();
                    (Element::Face(f), SurfacePoint::Face { vertices, bary: weights.map(|w| w / sum) })
                }
            };
            let mut taken = corners.to_vec();
            if self.used.iter().all(|used| !used) {
                taken = grown(mesh, &grown(mesh, &taken));
            }
            taken.iter().for_each(|v| self.used[v.index()] = true);
            return (element, Place::Point(point));
        }
    }
}

/// A prescription whose first singularity is given; others, or boundary loops, make up the sum.
fn prescription(
    mesh: &TriangleMesh,
    kind: usize,
    turns: i64,
    degree: u32,
    random: &mut Random,
) -> (Vec<Prescribed>, Vec<i64>) {
    let topology = Topology::of(mesh);
    let mut places = Places { mesh, used: vec![false; mesh.vertex_count()] };
    let mut missing = topology.euler_characteristic * i64::from(degree) - turns;
    let (element, place) = places.next(kind, random);
    let mut given = vec![Prescribed { element, place, turns }];
    let mut loops: Vec<i64> = topology.boundary_loops.iter().map(|_| random.below(5) as i64 - 2).collect();
    missing -= loops.iter().sum::<i64>();
    if let Some(first) = loops.first_mut() {
        *first += missing;
        missing = 0;
    }
    while missing != 0 {
        let (element, place) = places.next(random.below(3), random);
        given.push(Prescribed { element, place, turns: missing.signum() });
        missing -= missing.signum();
    }
    (given, loops)
}

#[derive(Debug, Default)]
struct Count {
    runs: usize,
    elements: usize,
    /// Runs with aliased elements, by kind of the first singularity and its index times N.
    aliased: BTreeMap<(usize, i64), usize>,
    /// Loops beside singularities, at a distance from the first one, and around holes.
    loops: [usize; 3],
    /// Loops closer to singularities that see another index: with aliased elements, and without.
    close: [usize; 2],
    worst: f64,
}

/// Solves for all configurations, and measures.
fn measure() -> Count {
    let mut count = Count::default();
    let mut random = Random::from_seed(11);
    for (name, mesh) in surfaces() {
        let solver = Solver::new(&mesh, &SolverOptions::default()).unwrap();
        for degree in [1u32, 2, 3, 4, 6] {
            for turns in [-4i64, -3, -2, -1, 1, 2, 3, 4] {
                for kind in 0..3 {
                    let (given, loops) = prescription(&mesh, kind, turns, degree, &mut random);
                    let index = |turns: i64| turns as f64 / f64::from(degree);
                    let holes = loops.iter().enumerate();
                    let holes =
                        holes.map(|(b, t)| Singularity { place: Place::Boundary(b), index: index(*t) });
                    let singularities: Vec<Singularity> = given
                        .iter()
                        .map(|p| Singularity { place: p.place, index: index(p.turns) })
                        .chain(holes)
                        .collect();
                    let generators =
                        (0..solver.generator_count()).map(|_| index(random.below(3) as i64 - 1)).collect();
                    let options = FieldOptions::default().with_degree(degree).with_generators(generators);
                    let field = solver.solve(&singularities, &options).unwrap();
                    let name = format!("{name} N {degree} turns {turns} kind {kind}");
                    let report = &field.report;
                    count.worst = count.worst.max(report.residual).max(report.closure);
                    assert!(!report.scales_gave_up && report.unplaced.is_empty(), "{name} {report:?}");
                    count.runs += 1;
                    if !report.aliased.is_empty() {
                        *count.aliased.entry((kind, turns)).or_default() += 1;
                    }
                    around_elements(&name, &field, &given, &mut count);
                    on_loops(&name, &field, &given, &loops, &mut count);
                }
            }
        }
    }
    assert!(count.worst < 1e-10, "{count:?}");
    count
}

/// Exactly the prescribed elements turn, or those reported as aliased, as often as reported.
fn around_elements(name: &str, field: &PolarField, given: &[Prescribed], count: &mut Count) {
    let degree = f64::from(field.degree());
    let mut expected: BTreeMap<String, i64> =
        given.iter().map(|p| (p.element.to_string(), p.turns)).collect();
    for aliased in field.report.aliased.iter().filter(|a| !a.element.starts_with("boundary")) {
        let prescribed = (aliased.prescribed * degree).round() as i64;
        assert_eq!(expected.get(&aliased.element).copied().unwrap_or(0), prescribed, "{name}");
        expected.insert(aliased.element.clone(), (aliased.measured * degree).round() as i64);
    }
    expected.retain(|_, turns| *turns != 0);
    let measured: BTreeMap<String, i64> =
        turning_elements(field).into_iter().map(|(element, turns)| (element.to_string(), turns)).collect();
    assert_eq!(measured, expected, "{name}");
    for (i, p) in given.iter().enumerate() {
        let measured = measured.get(&p.element.to_string()).copied().unwrap_or(0);
        assert_eq!((field.report.measured[i] * degree).round() as i64, measured, "{name}");
        at_their_points(field, p);
    }
    count.elements += field.mesh().face_count() + field.mesh().edge_count() + field.mesh().vertex_count();
}

/// The field vanishes at singular points of faces.
fn at_their_points(field: &PolarField, p: &Prescribed) {
    if let (Element::Face(f), Place::Point(SurfacePoint::Face { vertices, bary })) = (p.element, p.place) {
        let own = field.mesh().face_vertices(f);
        let weights = own.map(|v| bary[vertices.iter().position(|w| *w == v.0).unwrap()]);
        let power = f64::from(field.power_of_face(f));
        let here = field.power_at(f, weights).norm().powf(1.0 / power);
        let corner = field.power_at(f, [1.0, 0.0, 0.0]).norm().powf(1.0 / power);
        assert!(here < 1e-8 * corner, "{here:e} {corner:e}");
    }
}

/// The field turns around each singularity on loops at a distance, whatever it does near it, and
/// around each hole.
fn on_loops(name: &str, field: &PolarField, given: &[Prescribed], holes: &[i64], count: &mut Count) {
    let mesh = field.mesh();
    for (i, p) in given.iter().enumerate() {
        let own: Vec<Vertex> = match p.element {
            Element::Face(f) => mesh.face_vertices(f).to_vec(),
            Element::Edge(e) => mesh.edge_vertices(e).to_vec(),
            Element::Vertex(v) => vec![v],
        };
        let beside = Loop::around(mesh, &own).unwrap();
        let measured = beside.turns(field, 0.999);
        assert!((measured - p.turns as f64).abs() < 1e-6, "{name}: {measured} {p:?}");
        count.loops[0] += 1;
        if (beside.turns(field, 0.5) - measured).abs() > 0.5 {
            count.close[usize::from(field.report.aliased.is_empty())] += 1;
        }
        // The others are not as far from each other.
        if i == 0
            && let Some(far) = Loop::around(mesh, &grown(mesh, &own))
        {
            let far = far.turns(field, 0.5);
            assert!((far - p.turns as f64).abs() < 1e-6, "{name}: {far} {p:?}");
            count.loops[1] += 1;
        }
    }
    for (boundary, &turns) in Topology::of(mesh).boundary_loops.iter().zip(holes) {
        if let Some(around) = Loop::around(mesh, &boundary.vertices) {
            let measured = around.turns(field, 0.5);
            assert!((measured - turns as f64).abs() < 1e-6, "{name}: {measured} {turns}");
            count.loops[2] += 1;
        }
    }
}

#[test]
fn fields_turn_as_prescribed_in_all_configurations() {
    let count = measure();
    println!("{count:?}");
    assert_eq!(count.runs, 480);
    assert!(count.loops.iter().all(|loops| *loops >= 100), "{count:?}");
    // Of the prescribed elements only vertices are aliased, and all of those with three turns.
    assert!(count.aliased.keys().all(|(kind, turns)| *kind == 0 && turns.abs() > 1), "{count:?}");
    assert!([-4, -3, 3, 4].iter().all(|turns| count.aliased[&(0, *turns)] == 20), "{count:?}");
    assert!(count.close[1] <= 4, "{count:?}");
}

/// From face to face around a vertex, the field turns by the prescribed angle over the number of
/// faces. More than half a turn is aliased, however fine the mesh is.
#[test]
fn large_indices_of_vertices_need_many_faces() {
    let mut aliased = 0;
    for (sectors, rings) in [(5, 3), (5, 12), (7, 3), (7, 12), (12, 8), (24, 8)] {
        let disk = shapes::disk(rings, sectors, 1.0).unwrap();
        let solver = Solver::new(&disk, &SolverOptions::default()).unwrap();
        let centre = disk.vertices().find(|v| disk.position(*v) == [0.0; 3]).unwrap();
        assert_eq!(disk.vertex_corners(centre).len(), sectors);
        for turns in [-4.0, -3.0, 3.0, 4.0] {
            let given = [
                Singularity { place: Place::Point(centre.into()), index: turns },
                Singularity { place: Place::Boundary(0), index: 1.0 - turns },
            ];
            let field = solver.solve(&given, &FieldOptions::default().with_degree(1)).unwrap();
            let expected = 2.0 * f64::abs(turns) > sectors as f64;
            assert_eq!(!field.report.aliased.is_empty(), expected, "{turns} {sectors} {rings}");
            aliased += usize::from(expected);
        }
    }
    assert_eq!(aliased, 12);
}
