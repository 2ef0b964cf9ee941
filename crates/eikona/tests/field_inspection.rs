//! Inspection of fields of N vectors per face: indices, matchings, faults, and public files.

use eikona::mesh::{Face, SurfacePoint, TriangleMesh, Vertex, damage, shapes};
use eikona::polar_field::{
    AutomaticOptions, FaceVectors, FieldOptions, Match, Place, PolarField, PolarFieldError, Singularity,
    Solver, inspect_field,
};

fn at(vertex: u32, index: f64) -> Singularity {
    Singularity { place: Place::Point(SurfacePoint::Vertex { vertex }), index }
}

fn vectors(field: &PolarField) -> FaceVectors {
    FaceVectors { matching: Vec::new(), ..with_matching(field) }
}

fn with_matching(field: &PolarField) -> FaceVectors {
    field.per_face().unwrap().vectors
}

fn torus() -> TriangleMesh {
    damage::jitter(&shapes::torus(1.0, 0.4, 60, 24).unwrap(), 0.15, 3).unwrap()
}

#[test]
fn indices_of_solved_fields_are_found_with_and_without_the_matching() {
    let mesh = torus();
    let solver = Solver::new(&mesh, &Default::default()).unwrap();
    for degree in [1, 2, 3, 4, 6] {
        let n = f64::from(degree);
        let prescribed = [at(100, 1.0 / n), at(700, -1.0 / n), at(1200, 2.0 / n), at(40, -2.0 / n)];
        let options = FieldOptions::default().with_degree(degree);
        let field = solver.solve(&prescribed, &options).unwrap();
        for inspected in [vectors(&field), with_matching(&field)] {
            let seen = inspect_field(&mesh, &inspected).unwrap();
            let mut expected: Vec<(Vertex, f64)> = vec![
                (Vertex(100), 1.0 / n),
                (Vertex(700), -1.0 / n),
                (Vertex(1200), 2.0 / n),
                (Vertex(40), -2.0 / n),
            ];
            expected.sort_by_key(|(v, _)| *v);
            assert_eq!(seen.vertices.len(), 4, "N = {degree}: {:?}", seen.vertices);
            for ((v, index), (w, wanted)) in seen.vertices.iter().zip(&expected) {
                assert!(v == w && (index - wanted).abs() < 1e-12, "N = {degree}: {:?}", seen.vertices);
            }
            assert!(seen.index_sum.abs() < 1e-12 && seen.euler_characteristic == 0);
            assert!(seen.zero.is_empty() && seen.disordered.is_empty() && seen.asymmetric.is_empty());
            assert!(seen.out_of_plane.0 < 1e-7, "{:?}", seen.out_of_plane);
        }
    }
}

#[test]
fn the_matching_counts_rotations_of_more_than_half_a_turn() {
    // Six turns of the power around a vertex with six faces: more than half a turn from face to
    // face.
    let mesh = torus();
    let solver = Solver::new(&mesh, &Default::default()).unwrap();
    let prescribed = [at(100, -1.5), at(900, 1.0), at(1000, 0.5)];
    let field = solver.solve(&prescribed, &FieldOptions::default()).unwrap();
    assert!(!field.report.aliased.is_empty(), "the smallest rotation is another one");
    let expected = vec![(Vertex(100), -1.5), (Vertex(900), 1.0), (Vertex(1000), 0.5)];
    let matched = inspect_field(&mesh, &with_matching(&field)).unwrap();
    assert_eq!(matched.vertices, expected);
    let smallest = inspect_field(&mesh, &vectors(&field)).unwrap();
    assert_ne!(smallest.vertices, expected);
    assert!(smallest.index_sum.abs() < 1e-12 && !smallest.ambiguous.is_empty());
}

#[test]
fn each_edge_between_two_faces_has_its_own_match() {
    // Two triangles glued along all sides.
    let corners = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.3, 0.8, 0.0]];
    let mesh = TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 1]]).unwrap();
    let field = FaceVectors { degree: 1, vectors: vec![[1.0, 0.0, 0.0]; 2], ..FaceVectors::default() };
    let four = |shifts: [i64; 3]| {
        let turned = |k: usize| {
            let angle = std::f64::consts::FRAC_PI_2 * k as f64;
            [angle.cos(), angle.sin(), 0.0]
        };
        let vectors = (0..4).map(turned).chain([0, 3, 2, 1].map(turned)).collect();
        let edges = [[0, 1], [1, 2], [2, 0]];
        let matching = edges.iter().zip(shifts).map(|(edge, shift)| Match {
            faces: [Face(0), Face(1)],
            vertices: Some(edge.map(Vertex)),
            shift,
        });
        let field = FaceVectors { degree: 4, vectors, matching: matching.collect() };
        inspect_field(&mesh, &field).unwrap().vertices
    };
    assert_eq!(inspect_field(&mesh, &field).unwrap().index_sum, 2.0);
    assert_ne!(four([0, 0, 0]), four([1, 0, 0]));
    assert_ne!(four([1, 0, 0]), four([0, 1, 0]));
}

#[test]
fn flipped_faces_do_not_change_the_indices() {
    let mesh = shapes::icosphere(3).unwrap();
    let solver = Solver::new(&mesh, &Default::default()).unwrap();
    let found = solver.automatic(&AutomaticOptions::default()).unwrap();
    let field = solver.solve(&found.singularities, &FieldOptions::default()).unwrap();
    let plain = with_matching(&field);
    let mut triangles = mesh.triangles().to_vec();
    for triangle in triangles.iter_mut().skip(1).step_by(3) {
        triangle.swap(1, 2);
    }
    let flipped = TriangleMesh::new(mesh.positions().to_vec(), triangles).unwrap();
    let seen = inspect_field(&mesh, &plain).unwrap();
    assert_eq!(seen.index_sum, 2.0);
    let same = inspect_field(&flipped, &plain).unwrap();
    assert_eq!(same.vertices, seen.vertices);
    // In another order, the vectors are the same directions.
    let mut reversed = FaceVectors { matching: Vec::new(), ..plain };
    for face in (1..mesh.face_count()).step_by(3) {
        reversed.vectors[4 * face + 1..4 * face + 4].reverse();
    }
    let reversed = inspect_field(&flipped, &reversed).unwrap();
    assert_eq!(reversed.vertices, seen.vertices);
    assert_eq!(reversed.disordered.len(), mesh.face_count().div_ceil(3));
    for other in [same, reversed] {
        assert!((other.smoothness - seen.smoothness).abs() < 1e-9 * seen.smoothness);
        assert!((other.mean_curl - seen.mean_curl).abs() < 1e-9);
    }
}

#[test]
fn parallel_vectors_are_matched_with_themselves() {
    // Opposite vectors turn by half a turn, some to the left and some to the right: in the sum, by
    // nothing.
    let disk = shapes::disk(6, 24, 1.0).unwrap();
    for degree in [1u32, 2, 3, 4, 6, 12] {
        let turned = |k: u32| {
            let angle = 0.3 + std::f64::consts::TAU * f64::from(k) / f64::from(degree);
            [angle.cos(), angle.sin(), 0.0]
        };
        let vectors = (0..disk.face_count()).flat_map(|_| (0..degree).map(turned)).collect();
        let seen = inspect_field(&disk, &FaceVectors { degree, vectors, ..FaceVectors::default() }).unwrap();
        assert!(seen.largest_curl.0 < 1e-12, "N = {degree}: {:?}", seen.largest_curl);
        assert!(seen.largest_rotation.0 < 1e-12 && seen.vertices.is_empty());
        assert_eq!(seen.boundaries, [1.0]);
    }
}

#[test]
fn sizes_and_zero_fields_have_their_indices() {
    let unit = shapes::icosphere(2).unwrap();
    for scale in [1e-200, 1.0, 1e200] {
        let positions = unit.positions().iter().map(|p| p.map(|x| x * scale)).collect();
        let mesh = TriangleMesh::new(positions, unit.triangles().to_vec()).unwrap();
        let solver = Solver::new(&mesh, &Default::default()).unwrap();
        let found = solver.automatic(&AutomaticOptions::default()).unwrap();
        let field = solver.solve(&found.singularities, &FieldOptions::default()).unwrap();
        let seen = inspect_field(&mesh, &vectors(&field)).unwrap();
        assert_eq!((seen.index_sum, seen.vertices.len()), (2.0, found.singularities.len()), "{scale:e}");
        assert!(seen.mean_curl.is_finite() && seen.disordered.is_empty());
    }
    let nothing =
        FaceVectors { degree: 4, vectors: vec![[0.0; 3]; 4 * unit.face_count()], ..Default::default() };
    let seen = inspect_field(&unit, &nothing).unwrap();
    assert_eq!((seen.zero.len(), seen.index_sum, seen.mean_curl), (unit.face_count(), 2.0, 0.0));
}

#[test]
fn faults_of_fields_are_named() {
    let mesh = shapes::icosphere(1).unwrap();
    let solver = Solver::new(&mesh, &Default::default()).unwrap();
    let found = solver.automatic(&AutomaticOptions::default()).unwrap();
    let good = vectors(&solver.solve(&found.singularities, &FieldOptions::default()).unwrap());
    let refused = |field: &FaceVectors| inspect_field(&mesh, field).map(drop).unwrap_err();
    let mut bad = good.clone();
    bad.vectors.pop();
    assert!(matches!(refused(&bad), PolarFieldError::FieldSize { found: 319, degree: 4, faces: 80 }));
    let mut bad = good.clone();
    bad.vectors[4 * 7 + 2][1] = f64::NAN;
    assert!(matches!(refused(&bad), PolarFieldError::NonFiniteVector { face: Face(7), vector: 2 }));
    let apart = Match { faces: [Face(0), Face(50)], vertices: None, shift: 1 };
    let bad = FaceVectors { matching: vec![apart], ..good.clone() };
    assert!(matches!(refused(&bad), PolarFieldError::Matching { row: 0, .. }));
    let bad = FaceVectors { degree: 0, ..good.clone() };
    assert!(matches!(refused(&bad), PolarFieldError::Degree { degree: 0 }));
    // Not refused, but listed.
    let mut odd = good;
    odd.vectors[4 * 3] = [0.0; 3];
    odd.vectors[4 * 5..4 * 6].swap(1, 2);
    odd.vectors[4 * 9] = odd.vectors[4 * 9].map(|x| 2.0 * x);
    let seen = inspect_field(&mesh, &odd).unwrap();
    assert_eq!((seen.zero, seen.disordered), (vec![Face(3)], vec![Face(5)]));
    assert_eq!(seen.asymmetric, [Face(9)]);
}
