//! Inspection of fields of N vectors per face: indices, matchings, faults, and public files.

use eikona::mesh::{Face, SurfacePoint, TriangleMesh, Vertex, damage, shapes};
use eikona::polar_field::{
    AutomaticOptions, FaceVectors, FieldOptions, Place, PolarField, PolarFieldError, Singularity, Solver,
    inspect_field,
};

fn at(vertex: u32, index: f64) -> Singularity {
    Singularity { place: Place::Point(SurfacePoint::Vertex { vertex }), index }
}

fn vectors(field: &PolarField) -> FaceVectors {
    let mesh = field.mesh();
    let centroid = |vertices: &[u32; 3]| SurfacePoint::Face { vertices: *vertices, bary: [1.0 / 3.0; 3] };
    let vectors = mesh.triangles().iter().flat_map(|t| field.vectors_at(centroid(t)).unwrap()).collect();
    FaceVectors { degree: field.degree(), vectors, ..FaceVectors::default() }
}

fn with_matching(field: &PolarField) -> FaceVectors {
    let matching = field.matching().into_iter().map(|(faces, _, k)| (faces, i64::from(k))).collect();
    FaceVectors { matching, ..vectors(field) }
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
fn the_matching_follows_large_rotations_inside_faces() {
    // A vertex of large index: the field turns by more than the smallest rotation shows.
    let mesh = torus();
    let solver = Solver::new(&mesh, &Default::default()).unwrap();
    let prescribed = [at(100, 2.0), at(900, -2.0)];
    let field = solver.solve(&prescribed, &FieldOptions::default().with_degree(1)).unwrap();
    let seen = inspect_field(&mesh, &with_matching(&field)).unwrap();
    assert!(seen.index_sum.abs() < 1e-12);
    assert!(seen.vertices.contains(&(Vertex(100), 2.0)), "{:?}", seen.vertices);
}

#[test]
fn orders_of_vertices_and_flipped_faces_do_not_change_the_indices() {
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
    // The order of the vectors is counter-clockwise in each face's own orientation.
    let mut reversed = FaceVectors { matching: Vec::new(), ..plain.clone() };
    for face in (1..mesh.face_count()).step_by(3) {
        reversed.vectors[4 * face + 1..4 * face + 4].reverse();
    }
    let [a, b] = [inspect_field(&mesh, &plain).unwrap(), inspect_field(&flipped, &reversed).unwrap()];
    assert_eq!(a.vertices, b.vertices);
    assert!((a.smoothness - b.smoothness).abs() < 1e-9 * a.smoothness);
    assert_eq!(a.index_sum, 2.0);
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
    let bad = FaceVectors { matching: vec![([Face(0), Face(50)], 1)], ..good.clone() };
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
    assert!(seen.asymmetric.contains(&Face(9)) && seen.asymmetric.contains(&Face(5)));
}
