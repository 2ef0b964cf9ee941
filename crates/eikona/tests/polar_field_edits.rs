//! Edited prescriptions: the field is that of a new solve.

use eikona::mesh::{SurfacePoint, TriangleMesh, damage, shapes};
use eikona::polar_field::{FieldOptions, Place, PolarField, Singularity, Solver, SolverOptions};

fn torus() -> TriangleMesh {
    damage::jitter(&shapes::torus(1.0, 0.4, 40, 14).unwrap(), 0.2, 1).unwrap()
}

/// A point of each kind next to a face.
fn point(mesh: &TriangleMesh, kind: usize, face: usize) -> Place {
    let [a, b, c] = mesh.triangles()[face];
    Place::Point(match kind {
        0 => SurfacePoint::Vertex { vertex: a },
        1 => SurfacePoint::Edge { vertices: [a, b], t: 0.3 },
        _ => SurfacePoint::Face { vertices: [a, b, c], bary: [0.2, 0.5, 0.3] },
    })
}

/// Largest distance between the vectors of two fields at the centroids.
fn distance(a: &PolarField, b: &PolarField) -> f64 {
    let mut largest = 0.0f64;
    for &vertices in a.mesh().triangles() {
        let point = SurfacePoint::Face { vertices, bary: [0.4, 0.3, 0.3] };
        let [v, w] = [a, b].map(|field| field.vectors_at(point).unwrap());
        for (v, w) in v.iter().flatten().zip(w.iter().flatten()) {
            largest = largest.max((v - w).abs());
        }
    }
    largest
}

#[test]
fn an_edited_field_is_that_of_a_new_solve() {
    let mesh = torus();
    let solver = Solver::new(&mesh, &SolverOptions::default()).unwrap();
    let options = FieldOptions::default();
    let at = |kind: usize, face: usize, index: f64| Singularity { place: point(&mesh, kind, face), index };
    let start = vec![at(0, 10, 0.5), at(1, 300, -0.5), at(2, 600, 0.25), at(2, 900, -0.25)];
    let mut field = solver.solve(&start, &options).unwrap();
    let mut edits = vec![start.clone()];
    // Moved, each kind to each kind; another index; added; removed.
    for (kind, face) in [(0, 33), (1, 35), (2, 37)] {
        let mut moved = start.clone();
        moved[0] = at(kind, face, 0.5);
        moved[2] = at(kind, face + 500, 0.25);
        edits.push(moved);
    }
    let mut other = start.clone();
    (other[0].index, other[1].index) = (0.25, -0.25);
    edits.push(other);
    let mut more = start.clone();
    more.extend([at(1, 700, 0.25), at(2, 100, -0.25)]);
    edits.push(more);
    edits.push(start[2..].to_vec());
    edits.push(Vec::new());
    for (i, edit) in edits.iter().enumerate() {
        let edited = solver.edit(&field, edit, &options).unwrap();
        // A new solver keeps nothing from earlier prescriptions.
        let fresh = Solver::new(&mesh, &SolverOptions::default()).unwrap().solve(edit, &options).unwrap();
        let difference = distance(&edited, &fresh);
        assert!(difference < 1e-8, "edit {i}: {difference:e}");
        assert_eq!(edited.report.measured, edit.iter().map(|s| s.index).collect::<Vec<f64>>());
        field = edited;
    }
    let unchanged = solver.edit(&field, edits.last().unwrap(), &options).unwrap();
    assert_eq!(distance(&unchanged, &field), 0.0);
    // Nothing is to be searched where the corners with the lowest scales are known.
    let first = solver.solve(&start, &options).unwrap();
    let again = solver.edit(&first, &start, &options).unwrap();
    assert!(first.report.scale_rounds > 1 && again.report.scale_rounds == 1, "{:?}", again.report);
}

#[test]
fn any_number_of_singularities_is_measured_as_prescribed() {
    // The targets of up to 16 singular vertices are met by a dense system, those of more of them by
    // a factorisation.
    let mesh = torus();
    let solver = Solver::new(&mesh, &SolverOptions::default()).unwrap();
    let options = FieldOptions::default().with_degree(1);
    let pairs = |count: usize| -> Vec<Singularity> {
        let index = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        (0..count).map(|i| Singularity { place: point(&mesh, 0, 11 * i), index: index(i) }).collect()
    };
    for count in [2, 14, 16, 18, 100] {
        let field = solver.solve(&pairs(count), &options).unwrap();
        assert!(field.report.residual < 1e-10 && field.report.closure < 1e-10);
        let wanted: Vec<f64> = pairs(count).iter().map(|s| s.index).collect();
        assert_eq!(field.report.measured, wanted, "{count}");
    }
}
