//! Fields with closed forms: constant fields on surfaces that unfold to the plane, harmonic angles
//! around one singularity on a disk, meridians of a sphere.

mod frames;
mod plane;

use eikona::mesh::random::Random;
use eikona::mesh::shapes::{self, Diagonal, Hole};
use eikona::mesh::{BoundaryLoop, Face, SurfacePoint, Topology, TriangleMesh, damage};
use eikona::polar_field::{FieldOptions, Place, PolarField, Singularity, Solver, SolverOptions};
use frames::{angle_in_face, dot, wrapped};
use plane::in_plane;

fn centroid(mesh: &TriangleMesh, f: Face) -> [f64; 3] {
    let corners = mesh.face_positions(f);
    [0, 1, 2].map(|k| corners.iter().map(|p| p[k]).sum::<f64>() / 3.0)
}

/// The angle of the N-th power at the centroid of a face, less N times the angle of a vector there.
fn angle_to(field: &PolarField, f: Face, v: [f64; 3]) -> f64 {
    let power = field.power_at(f, [1.0 / 3.0; 3]);
    power.arg() - f64::from(field.degree()) * angle_in_face(field.mesh(), f, v)
}

/// The deviations of angles from their mean, in radians.
fn deviations(angles: &[f64]) -> Vec<f64> {
    let off: Vec<f64> = angles.iter().map(|a| wrapped(a - angles[0])).collect();
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    off.iter().map(|a| a - mean).collect()
}

fn largest(deviations: &[f64]) -> f64 {
    deviations.iter().fold(0.0, |m, d| m.max(d.abs()))
}

fn solve(mesh: &TriangleMesh, singularities: &[Singularity], degree: u32) -> PolarField {
    let solver = Solver::new(mesh, &SolverOptions::default()).unwrap();
    solver.solve(singularities, &FieldOptions::default().with_degree(degree)).unwrap()
}

fn on_loops(indices: &[f64]) -> Vec<Singularity> {
    let loops = indices.iter().enumerate();
    loops.map(|(b, &index)| Singularity { place: Place::Boundary(b), index }).collect()
}

/// Relative to a boundary loop a constant field turns once, against the loop; relative to the loop
/// of a hole, once the other way.
#[test]
fn constant_fields_are_found_without_singularities() {
    let flat = |mesh: TriangleMesh, seed: u64| {
        let rough = damage::jitter(&mesh, 0.25, seed).unwrap();
        let positions = rough.positions().iter().map(|p| [p[0], p[1], 0.0]).collect();
        rough.with_positions(positions).unwrap()
    };
    let holes =
        [Hole::Disk { centre: [1.0, 1.1], radius: 0.3 }, Hole::Disk { centre: [2.1, 0.9], radius: 0.25 }];
    let plate = flat(shapes::grid_with_holes(20, 14, 3.0, 2.0, &holes).unwrap(), 2);
    let disk = flat(shapes::disk(8, 8, 1.0).unwrap(), 1);
    // A sheet that is rolled up: triangles keep their shape, because whole columns are turned.
    let sheet = shapes::grid(24, 8, 3.0, 1.0, Diagonal::Uniform).unwrap();
    let chord = 2.0 * f64::sin(0.1) / (3.0 / 24.0);
    let rolled = |p: &[f64; 3]| {
        let angle = 0.2 * p[0] / (3.0 / 24.0);
        [angle.cos() / chord, angle.sin() / chord, p[1]]
    };
    let roll = sheet.with_positions(sheet.positions().iter().map(rolled).collect()).unwrap();
    for (name, mesh, unfolded) in [("disk", &disk, &disk), ("plate", &plate, &plate), ("roll", &roll, &sheet)]
    {
        let loops = Topology::of(mesh).boundary_loops;
        let longest = loops.iter().map(|l| l.halfedges.len()).max().unwrap();
        let is_outer = |l: &BoundaryLoop| l.halfedges.len() == longest;
        let indices: Vec<f64> = loops.iter().map(|l| if is_outer(l) { 1.0 } else { -1.0 }).collect();
        for degree in [1, 2, 4, 7] {
            let field = solve(mesh, &on_loops(&indices), degree);
            let angles: Vec<f64> = mesh
                .faces()
                .map(|f| {
                    // The first axis of the plane, as seen in this face.
                    let first = angle_in_face(unfolded, f, [1.0, 0.0, 0.0]);
                    field.power_at(f, [0.2, 0.5, 0.3]).arg() - f64::from(degree) * first
                })
                .collect();
            let spread = largest(&deviations(&angles));
            assert!(spread < 1e-11 * f64::from(degree), "{name} N {degree}: {spread:e}");
            assert!(field.report.energy < 1e-20, "{name} N {degree}: {:e}", field.report.energy);
        }
    }
}

/// On the unit disk the smoothest angle around `s` is `arg(z - s) - arg(1 - conj(s) z)`: its normal
/// derivative vanishes at the boundary. Returns the mean square deviation from it at distances
/// above 0.25 from `s`, per turn.
fn off_the_harmonic_angle(disk: &TriangleMesh, field: &PolarField, turns: f64, [x, y]: [f64; 2]) -> f64 {
    let exact = |[u, v, _]: [f64; 3]| {
        // 1 - conj(s) z for z = u + i v.
        let (re, im) = (1.0 - x * u - y * v, y * u - x * v);
        (v - y).atan2(u - x) - im.atan2(re)
    };
    let far = |f: &Face| {
        let [u, v, _] = centroid(disk, *f);
        (u - x).hypot(v - y) > 0.25
    };
    let angles: Vec<f64> = disk
        .faces()
        .filter(far)
        .map(|f| angle_to(field, f, [1.0, 0.0, 0.0]) - turns * exact(centroid(disk, f)))
        .collect();
    let deviations = deviations(&angles);
    deviations.iter().map(|d| d * d).sum::<f64>() / deviations.len() as f64 / (turns * turns)
}

/// The error decreases in proportion with the edge length, down to what the jumps carry whatever
/// the size of the mesh.
#[test]
fn angles_on_a_disk_approach_the_harmonic_one() {
    let mut random = Random::from_seed(5);
    let places: Vec<[f64; 2]> = (0..6).map(|_| [random.range(-0.4, 0.4), random.range(-0.4, 0.4)]).collect();
    for (degree, turns, at_vertex) in [(1, 1.0, false), (4, -1.0, false), (1, 2.0, false), (2, 1.0, true)] {
        let mut errors = Vec::new();
        for rings in [6, 12, 24] {
            let disk = shapes::disk(rings, 6, 1.0).unwrap();
            let solver = Solver::new(&disk, &SolverOptions::default()).unwrap();
            let index = turns / f64::from(degree);
            let mut sum = 0.0;
            for &place in &places {
                let mut point = in_plane(&disk, place);
                if let (SurfacePoint::Face { vertices, .. }, true) = (point, at_vertex) {
                    point = SurfacePoint::Vertex { vertex: vertices[0] };
                }
                let mut given = on_loops(&[1.0 - index]);
                given.push(Singularity { place: Place::Point(point), index });
                let field = solver.solve(&given, &FieldOptions::default().with_degree(degree)).unwrap();
                let [x, y, _] = point.locate(&disk).unwrap().position(&disk);
                sum += off_the_harmonic_angle(&disk, &field, turns, [x, y]);
            }
            errors.push((sum / places.len() as f64).sqrt());
        }
        println!("N {degree}, {turns} turns, at a vertex {at_vertex}: {errors:.5?}");
        let limits = if at_vertex { [0.015, 0.01, 0.008] } else { [0.08, 0.04, 0.025] };
        assert!(errors.iter().zip(limits).all(|(e, limit)| *e < limit), "{errors:?}");
    }
}

/// Two singularities of index 1 at opposite points of a sphere: the field keeps its angle to the
/// meridians.
#[test]
fn angles_on_a_sphere_approach_those_of_meridians() {
    for degree in [1u32, 2, 4] {
        let mut errors = Vec::new();
        for levels in [2, 3, 4] {
            let sphere = shapes::icosphere(levels).unwrap();
            let pole = centroid(&sphere, Face(0));
            let height = |f: Face| dot(centroid(&sphere, f), pole) / dot(pole, pole).sqrt();
            let opposite = sphere.faces().min_by(|f, g| height(*f).total_cmp(&height(*g))).unwrap();
            let at = |f: Face| {
                let vertices = sphere.triangles()[f.index()];
                let point = SurfacePoint::Face { vertices, bary: [1.0 / 3.0; 3] };
                Singularity { place: Place::Point(point), index: 1.0 }
            };
            let field = solve(&sphere, &[at(Face(0)), at(opposite)], degree);
            let far = sphere.faces().filter(|f| height(*f).abs() < 0.9);
            let angles: Vec<f64> = far.map(|f| angle_to(&field, f, pole)).collect();
            errors.push(largest(&deviations(&angles)) / f64::from(degree));
        }
        println!("N {degree}: {errors:.5?}");
        assert!(errors.iter().zip([0.03, 0.01, 0.007]).all(|(e, limit)| *e < limit), "{errors:?}");
    }
}
