//! Fields that follow boundaries, creases and curves, and automatic prescriptions.

use eikona::contour::plane_cut;
use eikona::curves::trace_polyline;
use eikona::mesh::random::Random;
use eikona::mesh::shapes::{Diagonal, Ends};
use eikona::mesh::{CurveKind, SurfaceCurves, SurfacePoint, Topology, TriangleMesh, damage, shapes};
use eikona::polar_field::{
    AutomaticOptions, FieldOptions, Guide, Place, PolarField, PolarFieldError, Singularity, Solver,
};
use eikona::spatial::Bvh;

fn solver(mesh: &TriangleMesh) -> Solver {
    Solver::new(mesh, &Default::default()).unwrap()
}

/// A unit square whose inner vertices are displaced in its plane.
fn flat(cells: usize, seed: u64) -> TriangleMesh {
    let square = shapes::grid(cells, cells, 1.0, 1.0, Diagonal::Alternating).unwrap();
    let mut random = Random::from_seed(seed);
    let mut moved = |x: f64| x + 0.4 * (random.uniform() - 0.5) / cells as f64;
    let inside = |x: f64| x > 1e-9 && x < 1.0 - 1e-9;
    let position =
        |&[x, y, z]: &[f64; 3]| if inside(x) && inside(y) { [moved(x), moved(y), z] } else { [x, y, z] };
    let positions = square.positions().iter().map(position).collect();
    TriangleMesh::new(positions, square.triangles().to_vec()).unwrap()
}

fn traced(mesh: &TriangleMesh, points: &[[f64; 3]], closed: bool) -> Guide {
    let traced = trace_polyline(mesh, &Bvh::new(mesh), points, closed, CurveKind::Signed, 1e-6).unwrap();
    Guide::Curves(SurfaceCurves::from_curve(traced.curve))
}

/// The automatic prescription, and the field that follows the guides exactly.
fn automatic(mesh: &TriangleMesh, degree: u32, guides: &[Guide]) -> (Vec<Singularity>, PolarField) {
    let solver = solver(mesh);
    let options = AutomaticOptions::default().with_degree(degree).with_guides(guides.to_vec());
    let found = solver.automatic(&options).unwrap();
    let options = FieldOptions::default()
        .with_degree(degree)
        .with_generators(found.generators)
        .with_guides(guides.to_vec());
    let field = solver.solve(&found.singularities, &options).unwrap();
    (found.singularities, field)
}

fn worst(field: &PolarField) -> f64 {
    field.report.followed.iter().fold(0.0, |m, followed| m.max(followed.largest_error))
}

fn at_vertex(mesh: &TriangleMesh, position: [f64; 3], index: f64) -> Singularity {
    let distance = |p: &[f64; 3]| (0..3).map(|k| (p[k] - position[k]).powi(2)).sum::<f64>();
    let nearest =
        |a: &usize, b: &usize| distance(&mesh.positions()[*a]).total_cmp(&distance(&mesh.positions()[*b]));
    let vertex = (0..mesh.vertex_count()).min_by(nearest).unwrap() as u32;
    Singularity { place: Place::Point(SurfacePoint::Vertex { vertex }), index }
}

fn in_face(mesh: &TriangleMesh, face: usize, index: f64) -> Singularity {
    let vertices = mesh.triangles()[face];
    Singularity { place: Place::Point(SurfacePoint::Face { vertices, bary: [0.3, 0.4, 0.3] }), index }
}

#[test]
fn a_disk_is_followed_along_its_boundary() {
    let disk = shapes::disk(12, 36, 1.0).unwrap();
    for degree in [1, 2, 3, 4, 6] {
        let (found, field) = automatic(&disk, degree, &[Guide::Boundary]);
        // The boundary turns once, and the field with it.
        assert!((found.iter().map(|s| s.index).sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(worst(&field) < 1e-9, "N = {degree}: {:e}", worst(&field));
        assert!(field.report.residual < 1e-10 && field.report.closure < 1e-9);
        // As many singularities as possible, of the smallest index.
        assert_eq!(found.len(), degree as usize, "N = {degree}: {found:?}");
    }
}

#[test]
fn a_square_has_a_constant_cross_field_or_one_that_turns_at_its_corners() {
    let square = flat(14, 3);
    let (found, field) = automatic(&square, 4, &[Guide::Boundary]);
    assert_eq!(found, [Singularity { place: Place::Boundary(0), index: 1.0 }]);
    assert!(worst(&field) < 1e-9);
    for &vertices in square.triangles() {
        let point = SurfacePoint::Face { vertices, bary: [0.2, 0.3, 0.5] };
        let v = field.vectors_at(point).unwrap();
        let along = v.iter().fold(0.0f64, |m, v| m.max(v[0]));
        assert!(1.0 - along < 1e-12, "parallel to the sides everywhere: {v:?}");
    }
    // Four singularities of 1/4 near the corners, as on a disk: the field turns at each corner.
    let near = [[0.2, 0.2], [0.8, 0.2], [0.2, 0.8], [0.8, 0.8]];
    let four: Vec<Singularity> = near.iter().map(|&[x, y]| at_vertex(&square, [x, y, 0.0], 0.25)).collect();
    let options = FieldOptions::default().with_guides(vec![Guide::Boundary]);
    let field = solver(&square).solve(&four, &options).unwrap();
    assert!(worst(&field) < 1e-9, "{:?}", field.report.followed);
    assert_eq!(field.report.measured, [0.25; 4]);
}

#[test]
fn a_box_is_followed_along_its_creases() {
    let cube = shapes::cuboid([1.0, 2.0, 1.5], [6, 12, 9]).unwrap();
    let (found, field) = automatic(&cube, 4, &[Guide::Creases { degrees: 30.0 }]);
    assert_eq!(found.len(), 8, "one singularity at each corner: {found:?}");
    assert!(found.iter().all(|s| s.index == 0.25));
    assert_eq!(field.report.followed.len(), 12, "{:?}", field.report.followed);
    assert!(worst(&field) < 1e-9, "{:e}", worst(&field));
}

#[test]
fn geodesics_are_followed_to_rounding_past_singularities_of_all_kinds() {
    let square = flat(20, 5);
    let line = traced(&square, &[[0.05, 0.11, 0.0], [0.93, 0.52, 0.0]], false);
    let other = traced(&square, &[[0.1, 0.9, 0.0], [0.6, 0.7, 0.0]], false);
    let boundary = Singularity { place: Place::Boundary(0), index: 1.0 };
    let mut singularities = vec![boundary, in_face(&square, 200, 0.25), in_face(&square, 420, -0.25)];
    let [a, b, _] = square.triangles()[500];
    let edge = Place::Point(SurfacePoint::Edge { vertices: [a, b], t: 0.4 });
    singularities.push(Singularity { place: edge, index: 0.25 });
    singularities.push(at_vertex(&square, [0.3, 0.7, 0.0], -0.25));
    let guides = vec![line, other];
    let options = FieldOptions::default().with_guides(guides.clone());
    let field = solver(&square).solve(&singularities, &options).unwrap();
    assert!(worst(&field) < 1e-6, "{:?}", field.report.followed);
    assert_eq!(field.report.measured, [1.0, 0.25, -0.25, 0.25, -0.25]);
    // Through a singular face, where the scales change the phase along its sides.
    singularities[2] = in_face(&square, 330, -0.25);
    let field = solver(&square).solve(&singularities, &options).unwrap();
    assert!(worst(&field) < 1e-5, "{:?}", field.report.followed);
}

#[test]
fn curves_on_a_sphere_are_followed() {
    let sphere = damage::jitter(&shapes::icosphere(4).unwrap(), 0.15, 2).unwrap();
    let latitude = |height: f64, nodes: usize| -> Vec<[f64; 3]> {
        let r = (1.0 - height * height).sqrt();
        let angles = (0..nodes).map(|i| i as f64 / nodes as f64 * std::f64::consts::TAU);
        angles.map(|t| [r * t.cos(), r * t.sin(), height]).collect()
    };
    let poles: Vec<Singularity> =
        [1.0, -1.0].into_iter().map(|z| at_vertex(&sphere, [0.0, 0.0, z], 1.0)).collect();
    // A plane section is straight in each face. A curve of 200 nodes is bent inside of faces, by up
    // to a tenth of a radian on this rough surface; the field follows it at both ends of each face.
    let section = |height: f64| {
        let curves = plane_cut(&sphere, [0.0, 0.0, height], [0.1, 0.2, 1.0]).unwrap();
        Guide::Curves(SurfaceCurves { curves, points: Vec::new() })
    };
    for (guide, height, largest, mean) in [
        (section(0.0), 0.0, 1e-9, 1e-9),
        (section(0.5), 0.5, 1e-9, 1e-9),
        (traced(&sphere, &latitude(0.0, 200), true), 0.0, 0.15, 0.02),
        (traced(&sphere, &latitude(0.5, 200), true), 0.5, 0.15, 0.02),
    ] {
        let options = FieldOptions::default().with_guides(vec![guide]);
        let field = solver(&sphere).solve(&poles, &options).unwrap();
        let followed = &field.report.followed[0];
        let (found, found_mean) = (followed.largest_error, followed.mean_error);
        println!("latitude {height}: largest {found:.1e}, mean {found_mean:.1e}");
        assert!(found < largest && found_mean < mean, "{followed:?}");
    }
}

#[test]
fn curves_are_followed_in_their_direction_by_vectors() {
    let square = shapes::grid(16, 16, 1.0, 1.0, Diagonal::Alternating).unwrap();
    let up = traced(&square, &[[0.2, 0.1, 0.0], [0.2, 0.9, 0.0]], false);
    let down = traced(&square, &[[0.8, 0.9, 0.0], [0.8, 0.1, 0.0]], false);
    let boundary = Singularity { place: Place::Boundary(0), index: 1.0 };
    let options = FieldOptions::default().with_degree(1).with_guides(vec![up, down]);
    let field = solver(&square).solve(&[boundary], &options).unwrap();
    assert!(worst(&field) < 1e-9);
    for (x, sign) in [(0.2, 1.0), (0.8, -1.0)] {
        let Singularity { place: Place::Point(point), .. } = at_vertex(&square, [x, 0.5, 0.0], 0.0) else {
            unreachable!("it is a point")
        };
        let v = field.vectors_at(point).unwrap()[0];
        assert!((v[1] - sign).abs() < 0.2, "{v:?}");
    }
}

#[test]
fn a_weight_means_the_same_at_every_resolution() {
    // The outer ends of a line across a field that wants to be elsewhere.
    let angles: Vec<f64> = [12, 24, 48]
        .into_iter()
        .map(|n| {
            let square = shapes::grid(n, n, 1.0, 1.0, Diagonal::Alternating).unwrap();
            let line = traced(&square, &[[0.1, 0.3, 0.0], [0.9, 0.52, 0.0]], false);
            let other = traced(&square, &[[0.1, 0.6, 0.0], [0.9, 0.6, 0.0]], false);
            let boundary = Singularity { place: Place::Boundary(0), index: 1.0 };
            let options = FieldOptions::default().with_guides(vec![line, other]).with_guide_weight(Some(3.0));
            let field = solver(&square).solve(&[boundary], &options).unwrap();
            field.report.followed[0].mean_error
        })
        .collect();
    assert!(angles.iter().all(|a| (0.9..1.1).contains(&(a / angles[2]))), "{angles:?}");
    assert!(angles[2] > 1e-3, "the weight is not infinite: {angles:?}");
}

#[test]
fn guides_that_can_not_be_followed_are_refused() {
    let sphere = shapes::icosphere(3).unwrap();
    let on_sphere = solver(&sphere);
    let two = [at_vertex(&sphere, [0.0, 0.0, 1.0], 1.0), at_vertex(&sphere, [0.0, 0.0, -1.0], 1.0)];
    let refused = |guide: Guide, degree: u32, weight: Option<f64>| {
        let options =
            FieldOptions::default().with_degree(degree).with_guides(vec![guide]).with_guide_weight(weight);
        on_sphere.solve(&two, &options).map(drop).unwrap_err()
    };
    assert!(matches!(refused(Guide::Boundary, 4, None), PolarFieldError::NoBoundary));
    let none = Guide::Curves(SurfaceCurves::default());
    assert!(matches!(refused(none, 4, None), PolarFieldError::NoCurve));
    let sharp = |degrees| Guide::Creases { degrees };
    assert!(matches!(refused(sharp(30.0), 3, None), PolarFieldError::CreasesWithOddDegree { degree: 3 }));
    assert!(matches!(refused(sharp(f64::NAN), 4, None), PolarFieldError::CreaseAngle { .. }));
    let weight = refused(sharp(30.0), 4, Some(-1.0));
    assert!(matches!(weight, PolarFieldError::GuideWeight { .. }));
    let curvature = AutomaticOptions::default().with_degree(3).with_curvature(true);
    let curvature = on_sphere.automatic(&curvature).unwrap_err();
    assert!(matches!(curvature, PolarFieldError::CurvatureWithOddDegree { degree: 3 }));
    // Both singularities on one side of a circle: the field turns relative to it.
    let equator: Vec<[f64; 3]> = (0..60)
        .map(|i| i as f64 / 60.0 * std::f64::consts::TAU)
        .map(|t| [0.3 * t.cos(), 0.3 * t.sin(), (1.0f64 - 0.09).sqrt()])
        .collect();
    let guide = traced(&sphere, &equator, true);
    let both = [at_vertex(&sphere, [0.0, 0.0, -1.0], 1.0), at_vertex(&sphere, [1.0, 0.0, 0.0], 1.0)];
    let options = FieldOptions::default().with_guides(vec![guide]);
    let fault = on_sphere.solve(&both, &options).map(drop).unwrap_err();
    assert!(matches!(fault, PolarFieldError::Unfollowable { turns, .. } if turns.abs() == 1.0), "{fault}");
}

#[test]
fn automatic_indices_add_up_to_the_euler_characteristic() {
    let torus = damage::jitter(&shapes::torus(1.0, 0.4, 40, 16).unwrap(), 0.2, 1).unwrap();
    let surfaces = [
        ("sphere", shapes::icosphere(3).unwrap()),
        ("torus", torus),
        ("genus 2", shapes::chain_of_genus(2, 1).unwrap()),
        ("annulus", shapes::annulus(0.4, 1.0, 6, 30).unwrap()),
        ("rings", shapes::linked_rings(2, 0.2, 20, 10).unwrap()),
    ];
    for (name, mesh) in surfaces {
        let chi = Topology::of(&mesh).euler_characteristic as f64;
        for degree in [1, 2, 3, 4, 6] {
            let (found, field) = automatic(&mesh, degree, &[]);
            let sum: f64 = found.iter().map(|s| s.index).sum();
            assert!((sum - chi).abs() < 1e-9, "{name}, N = {degree}: {sum} instead of {chi}");
            let wanted: Vec<f64> = found.iter().map(|s| s.index).collect();
            assert_eq!(field.report.measured, wanted, "{name}, N = {degree}");
        }
    }
}

#[test]
fn curvature_directions_of_a_cylinder_are_straight_and_round() {
    let cylinder = shapes::cylinder(0.5, 3.0, 40, 20, Ends::Open).unwrap();
    let solver = solver(&cylinder);
    let options = AutomaticOptions::default().with_curvature(true);
    assert_eq!(solver.automatic(&options).unwrap().singularities, []);
}
