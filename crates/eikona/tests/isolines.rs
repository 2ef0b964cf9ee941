//! Isolines and plane cuts: known shapes, closedness, orientation, and cases that often tear
//! curves.

mod shapes;
use eikona::contour::{isolines, plane_cut, polylines};
use eikona_mesh::{Curve, Face, Located, SurfaceCurves, TriangleMesh, VertexField};
use shapes::{DATA, Random, cube, flat_grid, moebius, read_mesh, rough_grid, sphere, torus};
use std::f64::consts::TAU;

fn length(mesh: &TriangleMesh, curve: &Curve) -> f64 {
    let points = polylines(mesh, [curve]).unwrap().remove(0);
    points.windows(2).map(|p| (0..3).map(|k| (p[0][k] - p[1][k]).powi(2)).sum::<f64>().sqrt()).sum()
}

fn check(mesh: &TriangleMesh, curves: &[Curve]) {
    let curves = SurfaceCurves { curves: curves.to_vec(), points: Vec::new() };
    assert_eq!(curves.segments(mesh).unwrap().len(), curves.segment_count());
}

fn field(mesh: &TriangleMesh, f: impl Fn([f64; 3]) -> f64) -> VertexField<f64> {
    mesh.positions().iter().map(|&p| f(p)).collect::<Vec<f64>>().into()
}

#[test]
fn an_isoline_of_x_is_a_straight_line_upwards() {
    let mesh = rough_grid(20, 1);
    let mesh = mesh.with_positions(mesh.positions().iter().map(|p| [p[0], p[1], 0.0]).collect()).unwrap();
    let sets = isolines(&mesh, &field(&mesh, |p| p[0]), &[0.1, 0.37, 0.9]).unwrap();
    for set in &sets {
        assert_eq!(set.curves.len(), 1);
        check(&mesh, &set.curves);
        let points = &polylines(&mesh, &set.curves).unwrap()[0];
        assert!(points.iter().all(|p| (p[0] - set.level).abs() < 1e-14));
        assert!(points.windows(2).all(|p| p[1][1] > p[0][1]), "the smaller x is on the left");
        assert!((length(&mesh, &set.curves[0]) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn a_level_through_vertices_gives_one_line() {
    let mesh = flat_grid(8);
    let sets = isolines(&mesh, &field(&mesh, |p| p[0]), &[0.0, 0.5, 1.0]).unwrap();
    assert_eq!(sets.iter().map(|s| s.curves.len()).collect::<Vec<_>>(), [0, 1, 1]);
    for set in &sets[1..] {
        check(&mesh, &set.curves);
        assert_eq!(set.curves[0].nodes.len(), 9);
    }
}

#[test]
fn a_counterclockwise_loop_surrounds_the_smaller_values() {
    let mesh = flat_grid(24);
    let distance = field(&mesh, |p| (p[0] - 0.5).hypot(p[1] - 0.5) - 0.3);
    let curve = isolines(&mesh, &distance, &[0.0]).unwrap().remove(0).curves.remove(0);
    assert!(curve.is_closed());
    let p = polylines(&mesh, [&curve]).unwrap().remove(0);
    let area: f64 = p.windows(2).map(|p| 0.5 * (p[0][0] * p[1][1] - p[1][0] * p[0][1])).sum();
    assert!((area - 0.09 * TAU / 2.0).abs() < 0.003, "{area}");
}

#[test]
fn plane_cuts_of_sphere_and_torus() {
    let mesh = sphere(4);
    let equator = plane_cut(&mesh, [0.0; 3], [0.3, 0.2, 1.0]).unwrap();
    assert_eq!(equator.len(), 1);
    assert!(equator[0].is_closed());
    check(&mesh, &equator);
    assert!((length(&mesh, &equator[0]) - TAU).abs() < 0.01);
    // Through vertices and along edges: the coordinate planes are mirror planes of the icosahedron.
    for normal in [[1., 0., 0.], [0., 1., 0.], [0., 0., -1.]] {
        let cut = plane_cut(&mesh, [0.0; 3], normal).unwrap();
        assert_eq!((cut.len(), cut[0].is_closed()), (1, true));
        check(&mesh, &cut);
        assert!((length(&mesh, &cut[0]) - TAU).abs() < 0.01);
    }
    let mesh = torus(48, 24, 0.4);
    for (point, normal, loops) in [
        ([0.0; 3], [1.0, 0.0, 0.0], 2),
        ([0.0; 3], [0.0, 0.0, 1.0], 2),
        ([0.0, 0.0, 0.1], [0.0, 0.0, 1.0], 2),
        ([1.2, 0.0, 0.0], [1.0, 0.0, 0.0], 1),
        ([5.0, 0.0, 0.0], [1.0, 0.0, 0.0], 0),
    ] {
        let cut = plane_cut(&mesh, point, normal).unwrap();
        assert_eq!(cut.len(), loops, "{point:?} {normal:?}");
        assert!(cut.iter().all(Curve::is_closed));
        check(&mesh, &cut);
    }
    assert!(plane_cut(&mesh, [0.0; 3], [0.0; 3]).is_err());
    assert!(plane_cut(&mesh, [f64::NAN; 3], [1.0; 3]).is_err());
}

#[test]
fn faces_in_the_plane_are_cut_along_their_boundary_on_one_side_only() {
    let mesh = cube(4);
    // The top lies on the normal's side of its own plane and all else below: the cut is the
    // boundary of the top.
    let top = plane_cut(&mesh, [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]).unwrap();
    assert_eq!((top.len(), top[0].is_closed()), (1, true));
    assert!((length(&mesh, &top[0]) - 4.0).abs() < 1e-12);
    // With the normal reversed, nothing is below it.
    assert!(plane_cut(&mesh, [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]).unwrap().is_empty());
    // An isolated vertex on the level, all others below: touched, not crossed.
    let mesh = flat_grid(4);
    let peak = field(&mesh, |p| -((p[0] - 0.5).abs() + (p[1] - 0.5).abs()));
    assert!(isolines(&mesh, &peak, &[0.0]).unwrap()[0].curves.is_empty());
    // A ridge on the level from boundary to boundary: the line once up and once down, which cancel
    // as sources.
    let ridge = field(&mesh, |p| -(p[0] - 0.5).abs());
    let set = isolines(&mesh, &ridge, &[0.0]).unwrap().remove(0);
    assert_eq!(set.curves.len(), 2);
    assert_eq!(set.curves[0], set.curves[1].clone().reversed());
}

#[test]
fn curves_end_at_missing_values() {
    let mesh = flat_grid(10);
    let holed = field(&mesh, |p| {
        let hole = (p[0] - 0.5).abs() < 0.01 && (p[1] - 0.5).abs() < 0.01;
        if hole { f64::NAN } else { p[1] }
    });
    let set = isolines(&mesh, &holed, &[0.45]).unwrap().remove(0);
    assert_eq!((set.curves.len(), set.undefined_faces), (2, 6));
    check(&mesh, &set.curves);
    assert!(isolines(&mesh, &holed, &[f64::NAN]).is_err());
    assert!(isolines(&mesh, &vec![0.0; 3].into(), &[0.0]).is_err());
    let huge = field(&mesh, |p| if p[0] < 0.5 { -1.7e308 } else { 1.7e308 });
    check(&mesh, &isolines(&mesh, &huge, &[0.0, 1e308]).unwrap()[1].curves);
}

#[test]
fn curves_end_at_nonmanifold_edges() {
    // Three sheets that meet in the edge 01.
    let positions = vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., -1., 0.], [0., 0., 1.]];
    let mesh = TriangleMesh::new(positions, vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]]).unwrap();
    let set = isolines(&mesh, &field(&mesh, |p| p[0]), &[0.5]).unwrap().remove(0);
    assert_eq!(set.curves.len(), 3);
    check(&mesh, &set.curves);
}

#[test]
fn cuts_of_a_moebius_strip_transport_their_side() {
    let mesh = moebius(40, 6);
    let cut = plane_cut(&mesh, [0.0, 0.013, 0.0], [0.0, 1.0, 0.0]).unwrap();
    check(&mesh, &cut);
    assert_eq!(cut.len(), 2, "once across the strip on each side of the axis");
    // Flipping faces of a flat grid changes no curve; it only requires `up`.
    let mesh = flat_grid(9);
    let mixed = mesh.with_flipped_faces(|f| f.0 % 5 < 2);
    let of =
        |mesh: &TriangleMesh| isolines(mesh, &field(mesh, |p| p[0] + 0.1 * p[1]), &[0.45]).unwrap().remove(0);
    let (plain, turned) = (of(&mesh), of(&mixed));
    assert_eq!(turned.curves.len(), 1);
    let up = turned.curves[0].up.unwrap();
    assert!(plain.curves[0].up.is_none() && up[2].abs() == 1.0);
    // Seen from `up`, the smaller x must be on the left: upwards where `up` is +z, downwards where
    // it is -z.
    let p = polylines(&mixed, &turned.curves).unwrap().remove(0);
    assert!(p.windows(2).all(|p| (p[1][1] - p[0][1]) * up[2] > 0.0));
}

/// No curve is torn: on a closed mesh every curve is closed, also for fields with many exact ties.
#[test]
fn all_curves_are_closed_on_closed_meshes() {
    for seed in 0..60 {
        let mut random = Random(seed);
        let mesh = if seed % 2 == 0 { sphere(2) } else { torus(12, 8, 0.5) };
        let values: Vec<f64> =
            (0..mesh.vertex_count()).map(|_| (random.next() % (2 + seed % 4)) as f64).collect();
        for set in isolines(&mesh, &values.into(), &[0.0, 0.5, 1.0, 2.0]).unwrap() {
            check(&mesh, &set.curves);
            assert!(set.curves.iter().all(Curve::is_closed));
        }
    }
}

/// The smaller values are on the left of every segment inside a face.
#[test]
fn smaller_values_are_always_on_the_left() {
    let mesh = sphere(3);
    let value = |p: [f64; 3]| (3.0 * p[0]).sin() + p[1] * p[2];
    let values = field(&mesh, value);
    for set in isolines(&mesh, &values, &[-0.3, 0.0, 0.4]).unwrap() {
        let curves = SurfaceCurves { curves: set.curves, points: Vec::new() };
        for segment in curves.segments(&mesh).unwrap() {
            let eikona_mesh::SegmentHost::Face(face, _) = segment.host else { continue };
            let [p, q] = segment.ends.map(|e: Located| e.position(&mesh));
            let v = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|k| b[k] - a[k]);
            let cross = |a: [f64; 3], b: [f64; 3]| {
                [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
            };
            let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            let [a, b, c] = mesh.face_positions(face);
            let left = cross(cross(v(a, b), v(a, c)), v(p, q));
            for (vertex, corner) in mesh.face_vertices(face).into_iter().zip([a, b, c]) {
                let side = dot(left, v(p, corner));
                assert!((values[vertex] - set.level) * side <= 1e-12, "{face:?}");
            }
        }
    }
}

#[test]
#[cfg_attr(not(data_folder), ignore = "needs the data folder")]
fn plane_cuts_of_the_data_folder_are_closed() {
    let mut run = 0;
    for (name, closed) in [
        ("closed/bunny.obj", true),
        ("closed/fertility.off", true),
        ("closed/rocker-arm.obj", true),
        ("badquality/Havocglass8_left.obj", true),
        ("badquality/block.obj", true),
        ("nonorientable/klein_bottle_2.obj", true),
        ("boundary/plane_holes.obj", false),
        ("nonmanifold/cow.obj", false),
        ("nonmanifold/screwdriver.obj", false),
    ] {
        let mesh = read_mesh(format!("{DATA}/{name}")).expect(name);
        run += 1;
        let p = mesh.position(mesh.face_vertices(Face(0))[0]);
        for normal in [[1., 0., 0.], [0., 1., 0.], [0., 0., 1.], [1., 2., 3.]] {
            let cut = plane_cut(&mesh, p, normal).unwrap();
            check(&mesh, &cut);
            assert!(!closed || cut.iter().all(Curve::is_closed), "{name} {normal:?}");
        }
    }
    println!("plane cuts of {run} files");
}
