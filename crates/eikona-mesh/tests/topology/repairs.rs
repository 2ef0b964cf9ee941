//! Repairs do what they document, and their provenance relates old and new elements.

use crate::shapes::{Random, cube, grid, mesh, moebius, two_tetrahedra};
use eikona_mesh::{
    Face, MeshError, Orientation, PolygonMesh, Repaired, Topology, TriangleMesh, Vertex,
    drop_degenerate_faces, drop_duplicate_faces, drop_unreferenced_vertices, orient,
    split_nonmanifold_vertices, validate, weld, weld_polygons,
};

/// Gives each face its own corners, as in STL files.
fn soup(mesh_in: &TriangleMesh) -> TriangleMesh {
    let positions = mesh_in.faces().flat_map(|f| mesh_in.face_positions(f)).collect();
    mesh(positions, (0..mesh_in.face_count() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect())
}

/// Checks that every face has the corners of its parent, by the vertex map, and that each kept face
/// has one part.
fn check_provenance(old: &TriangleMesh, Repaired { mesh: new, provenance }: &Repaired) {
    for face in new.faces() {
        let parent = provenance.face_parent(face);
        assert!(provenance.face_parts(parent).eq([face]));
        let mut expected = old.face_vertices(parent).map(|v| provenance.new_vertex(v));
        if provenance.is_flipped(face) {
            expected.swap(1, 2);
        }
        assert_eq!(expected, new.face_vertices(face).map(Some));
    }
    assert_eq!(provenance.dropped_faces().len(), old.face_count() - new.face_count());
}

#[test]
fn welding_a_soup_restores_the_surface() {
    for surface in [cube(), grid(4, 5), moebius(13, 3)] {
        for tolerance in [0.0, 1e-9] {
            let soup = soup(&surface);
            let welded = weld(&soup, tolerance).expect("tolerance");
            check_provenance(&soup, &welded);
            assert_eq!(welded.mesh.vertex_count(), surface.vertex_count());
            assert_eq!(Topology::of(&welded.mesh).components.len(), 1);
            for v in soup.vertices() {
                let to = welded.provenance.new_vertex(v).expect("vertices are merged, not dropped");
                assert_eq!(welded.mesh.position(to), soup.position(v));
            }
        }
    }
}

/// Applies the welding rule to all pairs.
fn weld_slowly(positions: &[[f64; 3]], tolerance: f64) -> Vec<[f64; 3]> {
    let mut kept: Vec<[f64; 3]> = Vec::new();
    let mut result = Vec::new();
    for p in positions {
        let apart = |q: &[f64; 3]| (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt();
        let nearest = kept.iter().copied().min_by(|a, b| apart(a).total_cmp(&apart(b)));
        match nearest.filter(|q| apart(q) <= tolerance) {
            Some(q) => result.push(q),
            None => {
                kept.push(*p);
                result.push(*p);
            }
        }
    }
    result
}

#[test]
fn welding_with_a_tolerance_follows_its_definition() {
    let mut random = Random(11);
    let mut coordinate = || random.below(1000) as f64 / 500.0 - 1.0;
    for tolerance in [0.01, 0.1, 0.3, 5.0] {
        let positions: Vec<[f64; 3]> = (0..400).map(|_| [coordinate(), coordinate(), coordinate()]).collect();
        let cloud = mesh(positions.clone(), vec![]);
        let welded = weld(&cloud, tolerance).expect("tolerance");
        let merged = cloud.vertices().map(|v| welded.provenance.new_vertex(v).expect("merged"));
        let ours: Vec<[f64; 3]> = merged.map(|v| welded.mesh.position(v)).collect();
        assert_eq!(ours, weld_slowly(&positions, tolerance), "tolerance {tolerance}");
    }
}

#[test]
fn welding_drops_faces_that_collapse_and_keeps_minus_zero() {
    let positions = vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [-0., 0., -0.], [0., 1., 0.]];
    let input = mesh(positions, vec![[0, 1, 2], [0, 1, 3], [3, 4, 1]]);
    let welded = weld(&input, 0.0).expect("tolerance");
    check_provenance(&input, &welded);
    assert_eq!(welded.provenance.dropped_faces(), [Face(1)]);
    assert_eq!(welded.mesh.vertex_count(), 3);
    assert!(weld(&input, 10.0).is_ok_and(|w| w.mesh.face_count() == 0 && w.mesh.vertex_count() == 1));
}

#[test]
fn invalid_tolerances_are_errors() {
    for tolerance in [-1.0, f64::NAN, f64::INFINITY, 1e-30] {
        let refused = weld(&cube(), tolerance);
        assert!(matches!(refused, Err(MeshError::Parameter { name: "tolerance", .. })), "{tolerance}");
    }
}

#[test]
fn polygons_lose_repeated_corners() {
    let mut input = PolygonMesh::new(vec![
        [0., 0., 0.],
        [1., 0., 0.],
        [1., 1., 0.],
        [0., 1., 0.],
        [0., 1., 0.],
        [0., 0., 0.],
    ]);
    input.push_face([0, 1, 2, 3, 4]);
    input.push_face([0, 3, 4, 5]);
    input.push_face([5, 2, 3]);
    let welded = weld_polygons(&input, 0.0).expect("tolerance");
    assert_eq!(welded.mesh.faces().collect::<Vec<_>>(), [&[0, 1, 2, 3][..], &[0, 2, 3][..]]);
    assert_eq!(welded.provenance.dropped_faces(), [Face(1)]);
    assert_eq!(welded.provenance.face_parent(Face(1)), Face(2));
    input.push_face([0, 1, 99]);
    assert!(matches!(weld_polygons(&input, 0.0), Err(MeshError::Invalid(faults)) if faults.len() == 1));
}

#[test]
fn composed_drops_and_their_maps() {
    let mut positions = vec![[9., 9., 9.]];
    positions.extend(soup(&grid(2, 2)).positions());
    positions.push([5., 0., 0.]);
    let mut faces: Vec<[u32; 3]> = (0..8).map(|f| [3 * f + 1, 3 * f + 2, 3 * f + 3]).collect();
    faces.insert(3, [3, 2, 1]); // the first face again, flipped
    faces.push([1, 2, 25]); // zero area
    let input = mesh(positions, faces);

    let welded = weld(&input, 0.0).expect("tolerance");
    let unique = drop_duplicate_faces(&welded.mesh);
    let proper = drop_degenerate_faces(&unique.mesh);
    let trimmed = drop_unreferenced_vertices(&proper.mesh);
    check_provenance(&input, &welded);
    check_provenance(&welded.mesh, &unique);
    check_provenance(&unique.mesh, &proper);
    check_provenance(&proper.mesh, &trimmed);
    assert_eq!(unique.provenance.dropped_faces(), [Face(3)]);
    assert_eq!(validate(&trimmed.mesh), []);

    let steps = [welded.provenance, unique.provenance, proper.provenance, trimmed.provenance];
    let provenance = steps.into_iter().reduce(|all, step| all.then(&step)).expect("four steps");
    assert_eq!(provenance.dropped_faces(), [Face(3), Face(9)]);
    assert_eq!(provenance.dropped_vertices(), [Vertex(0), Vertex(25)]);
    check_provenance(&input, &Repaired { mesh: trimmed.mesh, provenance });
}

#[test]
fn orient_lists_the_faces_it_flips() {
    let damaged = cube().with_flipped_faces(|f| f.0 == 2 || f.0 == 7);
    let oriented = orient(&damaged);
    check_provenance(&damaged, &oriented);
    assert_eq!(oriented.provenance.flipped_faces(), [Face(2), Face(7)]);
    assert_eq!(oriented.mesh.triangles(), cube().triangles());
    assert!(Orientation::of(&oriented.mesh).is_consistent());
    // Two flips cancel.
    assert!(oriented.provenance.then(&oriented.provenance).is_identity());
}

#[test]
fn splitting_fans_gives_manifold_vertices() {
    let pair = two_tetrahedra(1);
    let split = split_nonmanifold_vertices(&pair).expect("small enough");
    assert_eq!(split.mesh.vertex_count(), 8);
    assert_eq!(split.provenance.vertex_place(Vertex(7)), Some(Vertex(0).into()));
    assert_eq!(split.provenance.new_vertex(Vertex(0)), Some(Vertex(0)));
    let topology = Topology::of(&split.mesh);
    assert!(topology.is_manifold());
    assert_eq!((topology.components.len(), topology.euler_characteristic), (2, 4));
    let same = split_nonmanifold_vertices(&cube()).expect("small enough");
    assert_eq!(same.mesh.triangles(), cube().triangles());
    assert!(same.provenance.is_identity());
}
