//! Polar fields on small meshes of any shape, with any singularities.

use crate::choices::Choices;
use crate::solve;
use eikona::polar_field::{
    FieldOptions, Place, PolarField, PolarFieldError, Singularity, Solver, SolverOptions,
};
use eikona_mesh::{Face, MeshError, SurfacePoint, Topology, TriangleMesh, Vertex, shapes};

/// Solves, and checks properties of every field.
///
/// # Panics
/// If a property is violated.
pub fn check(bytes: &[u8]) {
    let mut choices = Choices::new(bytes);
    let degree = choices.of([1, 2, 3, 4, 6, 1000, 0, 7]);
    let is_consistent = choices.of([true, false]);
    let Ok(mesh) = mesh(&mut choices) else { return };
    let mut given = singularities(&mut choices, &mesh, degree);
    let solver = match Solver::new(&mesh, &SolverOptions::default()) {
        Ok(solver) => solver,
        Err(fault) => return assert!(!fault.to_string().is_empty()),
    };
    if is_consistent {
        complete(&mut choices, solver.mesh(), degree, &mut given);
    }
    let mut along = Vec::new();
    for _ in 0..choices.of([solver.generator_count(), 0, 1, 2]) {
        along.push(index(&mut choices, degree));
    }
    let options = FieldOptions::default().with_degree(degree).with_generators(along);
    match solver.solve(&given, &options) {
        Ok(field) => {
            check_field(&field, &given);
            check_files(&field, &given);
        }
        Err(fault) => {
            assert!(!fault.to_string().is_empty());
            let numbers = matches!(fault, PolarFieldError::Numeric(_));
            assert!(
                !numbers || !is_ordinary(&mesh),
                "an ordinary mesh is not solved: {fault}\n{given:?} N {degree}\n{:?}",
                mesh.triangles()
            );
        }
    }
}

fn check_field(field: &PolarField, given: &[Singularity]) {
    let (mesh, report) = (field.mesh(), &field.report);
    let degree = f64::from(field.degree());
    let largest = given.iter().fold(1.0, |m: f64, s| m.max((s.index * degree).abs()));
    // Sums of angles, each as exact as its size.
    let exact = 1e-10 * (largest + degree);
    if is_ordinary(mesh) {
        assert!(report.residual < exact && report.closure < exact, "{report:?}");
        assert!(report.energy.is_finite() && report.energy >= 0.0, "{report:?}");
    }
    assert_eq!(report.measured.len(), given.len());
    for (i, s) in given.iter().enumerate() {
        let measured = report.measured[i];
        let turns = measured * degree;
        assert!((turns - turns.round()).abs() < 1e-6, "{report:?}");
        let wanted = (s.index * degree).round() / degree;
        let aliased = report.aliased.iter().any(|a| a.prescribed == wanted && a.measured == measured);
        assert!(measured == wanted || aliased, "singularity {i} of {given:?}: {report:?}");
    }
    // Some elements exchange turns; their sum stays.
    let missing: f64 = report.aliased.iter().map(|a| (a.measured - a.prescribed) * degree).sum();
    assert!(missing.abs() < 1e-6 * largest, "{missing}: {report:?}");
    for f in mesh.faces() {
        assert!(field.power_of_face(f) >= 1);
        for weights in [[1.0 / 3.0; 3], [1.0, 0.0, 0.0], [0.0, 0.5, 0.5]] {
            let power = field.power_at(f, weights);
            assert!(!power.re.is_nan() && !power.im.is_nan(), "{f}: {power:?} {report:?}");
        }
        let point = SurfacePoint::Face { vertices: mesh.triangles()[f.index()], bary: [0.25, 0.25, 0.5] };
        let vectors = field.vectors_at(point).expect("the point is in the face");
        assert_eq!(vectors.len(), field.degree() as usize);
        for v in vectors {
            let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
            assert!(length == 0.0 || (length - 1.0).abs() < 1e-9, "{f} {:?}: {v:?}", mesh.face_positions(f));
        }
    }
}

/// Checks samples per face, the split mesh, and the way through stored values.
fn check_files(field: &PolarField, given: &[Singularity]) {
    let mesh = field.mesh();
    let sampled = field.per_face().expect("it is on its own mesh");
    assert_eq!(sampled.vectors.vectors.len(), mesh.face_count() * field.degree() as usize);
    // Points in one face can be too close together to be separated.
    if let Ok(split) = field.split() {
        assert_eq!(split.left_out, 0);
        let points = given.iter().filter(|s| matches!(s.place, Place::Point(_)));
        let turning = points.filter(|s| (s.index * f64::from(field.degree())).round() != 0.0).count();
        assert_eq!(split.singular_vertices.len(), turning);
        assert_eq!(split.vectors.vectors.len(), split.mesh.face_count() * field.degree() as usize);
        assert!(split.mesh.face_count() <= 40_000 + 100 * mesh.face_count(), "{}", split.mesh.face_count());
    }
    let data = field.data();
    match PolarField::from_data(mesh, &data) {
        Ok(restored) => assert!(restored.data() == data, "{given:?}"),
        // Values beyond the range of numbers are refused.
        Err(fault) => assert!(!is_ordinary(mesh), "{fault} {given:?} {:?}", mesh.triangles()),
    }
}

/// Whether no face is much thinner than it is long, and coordinates are of ordinary size.
fn is_ordinary(mesh: &TriangleMesh) -> bool {
    let size = mesh.positions().iter().flatten().fold(0.0f64, |m, x| m.max(x.abs()));
    (1e-6..1e6).contains(&size)
        && mesh.faces().all(|f| {
            let [a, b, c] = mesh.face_positions(f);
            let sides = [[a, b], [b, c], [c, a]]
                .map(|[p, q]| ((p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2) + (p[2] - q[2]).powi(2)).sqrt());
            let longest = sides.into_iter().fold(0.0, f64::max);
            let half = 0.5 * (sides[0] + sides[1] + sides[2]);
            let area_sq = half * (half - sides[0]) * (half - sides[1]) * (half - sides[2]);
            longest > 1e-3 * size && area_sq.max(0.0).sqrt() > 1e-2 * longest * longest
        })
}

pub(crate) fn mesh(choices: &mut Choices) -> Result<TriangleMesh, MeshError> {
    match choices.below(4) {
        0 => closed(choices),
        1 => {
            let (first, second) = (closed(choices)?, solve::mesh(choices)?);
            together(&first, &second)
        }
        2 => {
            let first = closed(choices)?;
            let (mut positions, mut faces) = (first.positions().to_vec(), first.triangles().to_vec());
            for _ in 0..1 + choices.below(4) {
                solve::spoil(choices, &mut positions, &mut faces);
            }
            TriangleMesh::new(positions, faces)
        }
        _ => solve::mesh(choices),
    }
}

fn closed(choices: &mut Choices) -> Result<TriangleMesh, MeshError> {
    match choices.below(8) {
        0 => shapes::icosphere(1),
        1 => shapes::tetrahedron(),
        2 => shapes::octahedron(),
        3 => shapes::torus(1.0, 0.4, 3 + choices.below(5), 3 + choices.below(3)),
        4 => shapes::annulus(1.0, 2.0, 1 + choices.below(3), 3 + choices.below(6)),
        5 => shapes::disk(1 + choices.below(3), 3 + choices.below(5), 1.0),
        6 => shapes::chain_of_genus(2, 1),
        _ => shapes::cylinder(1.0, 1.0, 3 + choices.below(4), 1 + choices.below(3), shapes::Ends::Open),
    }
}

fn together(first: &TriangleMesh, second: &TriangleMesh) -> Result<TriangleMesh, MeshError> {
    let shift = first.vertex_count() as u32;
    let mut positions = first.positions().to_vec();
    positions.extend_from_slice(second.positions());
    let mut faces = first.triangles().to_vec();
    faces.extend(second.triangles().iter().map(|f| f.map(|v| v + shift)));
    TriangleMesh::new(positions, faces)
}

fn singularities(choices: &mut Choices, mesh: &TriangleMesh, degree: u32) -> Vec<Singularity> {
    let count = choices.of([0, 1, 2, 3, 4, 6, 8, 12]);
    (0..count)
        .map(|_| {
            let place = match choices.below(12) {
                11 => Place::Boundary(choices.below(4)),
                _ => Place::Point(point(choices, mesh)),
            };
            Singularity { place, index: index(choices, degree) }
        })
        .collect()
}

fn index(choices: &mut Choices, degree: u32) -> f64 {
    let turns = match choices.below(10) {
        0..=6 => choices.of([1, -1, 2, -2, 0, 3, -4, 5]),
        7 => choices.below(41) as i32 - 20,
        8 => choices.below(4001) as i32 - 2000,
        _ => return choices.wild_float(),
    };
    f64::from(turns) / f64::from(degree.max(1))
}

fn point(choices: &mut Choices, mesh: &TriangleMesh) -> SurfacePoint {
    let Some(&face) = mesh.triangles().get(choices.below(mesh.face_count())) else {
        return SurfacePoint::Vertex { vertex: choices.below(50) as u32 };
    };
    let mut vertices = face;
    vertices.rotate_left(choices.below(3));
    let near = |choices: &mut Choices| match choices.below(4) {
        0 => choices.of([1e-9, 2e-9, 1e-6, 1e-3, 0.5, 0.999, 1.0 - 1e-8, 1.0]),
        _ => choices.share(),
    };
    match choices.below(8) {
        0..=1 => SurfacePoint::Vertex { vertex: vertices[0] },
        2..=3 => SurfacePoint::Edge { vertices: [vertices[0], vertices[1]], t: near(choices) },
        4..=6 => {
            let a = near(choices);
            let b = (1.0 - a) * near(choices);
            SurfacePoint::Face { vertices, bary: [a, b, 1.0 - a - b] }
        }
        _ => {
            SurfacePoint::Edge { vertices: [vertices[0], choices.below(50) as u32], t: choices.wild_float() }
        }
    }
}

/// Replaces singularities that are not allowed, and adds what is missing to the Euler
/// characteristic of each component, in a face or at a boundary loop.
fn complete(choices: &mut Choices, mesh: &TriangleMesh, degree: u32, given: &mut Vec<Singularity>) {
    let topology = Topology::of(mesh);
    let n = f64::from(degree.max(1));
    let mut seen = Vec::new();
    let mut sums = vec![0i64; topology.components.len()];
    let inner = |v: Vertex| !mesh.is_boundary_vertex(v) && !mesh.vertex_corners(v).is_empty();
    given.retain(|s| {
        let turns = s.index * n;
        let element = match s.place {
            Place::Boundary(b) => topology.boundary_loops.get(b).map(|l| (format!("loop {b}"), l.component)),
            Place::Point(point) => point.locate(mesh).ok().and_then(|place| {
                use eikona_mesh::Located::{Edge, Face, Vertex};
                let face = *place.faces(mesh).first()?;
                let component = topology.component_of_face[face];
                match place {
                    Vertex(v) => inner(v).then(|| (v.to_string(), component)),
                    Edge(e, _) => (!mesh.is_boundary_edge(e)).then(|| (e.to_string(), component)),
                    Face(f, _) => Some((f.to_string(), component)),
                }
            }),
        };
        let Some((name, component)) = element else { return false };
        if seen.contains(&name) || turns.abs() > 1e5 || (turns - turns.round()).abs() > 1e-6 {
            return false;
        }
        seen.push(name);
        sums[component as usize] += turns.round() as i64;
        true
    });
    for (c, component) in topology.components.iter().enumerate() {
        let missing = component.euler_characteristic * i64::from(degree) - sums[c];
        let of_component = |f: &Face| topology.component_of_face[*f] as usize == c;
        let faces: Vec<Face> = mesh.faces().filter(of_component).collect();
        let skip = choices.below(faces.len());
        let free = faces.iter().cycle().skip(skip).take(faces.len()).find(|f| !seen.contains(&f.to_string()));
        if let (Some(f), true) = (free, missing != 0) {
            let point = SurfacePoint::Face { vertices: mesh.triangles()[f.index()], bary: [0.2, 0.3, 0.5] };
            given.push(Singularity { place: Place::Point(point), index: missing as f64 / n });
        }
    }
}
