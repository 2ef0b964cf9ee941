//! Random triangles on a few vertices: highly nonmanifold meshes. Results are checked against slow,
//! obvious implementations.

use crate::shapes::{Random, mesh, projective_plane};
use eikona_mesh::{
    Face, Orientation, Topology, TriangleMesh, Vertex, orient, split_nonmanifold_vertices, validate,
};

fn random_complex(random: &mut Random) -> TriangleMesh {
    let vertices = 4 + random.below(6) as u32;
    let count = 1 + random.below(10);
    let faces = (0..count).map(|_| {
        let order = random.permutation(vertices as usize);
        [order[0], order[1], order[2]]
    });
    let faces = faces.collect();
    mesh((0..vertices).map(|k| [k as f64, (k * k) as f64, (k * k * k % 11) as f64]).collect(), faces)
}

/// Returns the smallest face number in each face's equivalence class, where `linked` faces are
/// equivalent: iterated until nothing changes.
fn classes(faces: &[Face], linked: impl Fn(Face, Face) -> bool) -> Vec<u32> {
    let mut class: Vec<u32> = faces.iter().map(|f| f.0).collect();
    loop {
        let before = class.clone();
        for &f in faces {
            for &g in faces {
                if linked(f, g) {
                    class[f.index()] = class[f.index()].min(class[g.index()]);
                }
            }
        }
        if class == before {
            return class;
        }
    }
}

fn number_of_classes(class: &[u32]) -> usize {
    class.iter().enumerate().filter(|(f, c)| *f == **c as usize).count()
}

fn shared(mesh: &TriangleMesh, f: Face, g: Face) -> usize {
    mesh.face_vertices(f).iter().filter(|v| mesh.face_vertices(g).contains(v)).count()
}

#[test]
fn components_sheets_fans_and_boundary() {
    let mut random = Random(17);
    for _ in 0..500 {
        let sample = random_complex(&mut random);
        let topology = Topology::of(&sample);
        let faces: Vec<Face> = sample.faces().collect();
        let sheets = classes(&faces, |f, g| shared(&sample, f, g) >= 2);
        let components = classes(&faces, |f, g| shared(&sample, f, g) >= 1);
        assert_eq!(topology.sheet_count, number_of_classes(&sheets));
        assert_eq!(topology.components.len(), number_of_classes(&components));
        for f in sample.faces() {
            let component = topology.component_of_face[f];
            assert_eq!(topology.components[component as usize].first_face.0, components[f.index()]);
            assert!(
                sample.face_vertices(f).iter().all(|&v| topology.component_of_vertex[v] == Some(component))
            );
        }
        let sum: i64 = topology.components.iter().map(|c| c.euler_characteristic).sum();
        assert_eq!(sum, topology.euler_characteristic);
        for v in sample.vertices() {
            let around: Vec<Face> = sample.vertex_corners(v).iter().map(|c| c.face()).collect();
            let fans = number_of_classes(&classes(&sample.faces().collect::<Vec<_>>(), |f, g| {
                around.contains(&f) && around.contains(&g) && share_edge_at(&sample, v, f, g)
            })) - (sample.face_count() - around.len());
            let found =
                topology.nonmanifold_vertices.iter().find(|at| at.vertex == v).map_or(1, |at| at.fans);
            assert!(around.is_empty() || fans == found, "{v}: {found}, slowly {fans}");
        }
        let mut passed: Vec<_> =
            topology.boundary_loops.iter().flat_map(|l| &l.halfedges).map(|&h| sample.edge(h)).collect();
        passed.sort_unstable();
        assert!(passed.iter().copied().eq(sample.edges().filter(|&e| sample.is_boundary_edge(e))));

        let split = split_nonmanifold_vertices(&sample).expect("small");
        assert!(Topology::of(&split.mesh).nonmanifold_vertices.is_empty());
        for f in sample.faces() {
            let places = split.mesh.face_vertices(f).map(|v| split.provenance.vertex_place(v));
            assert_eq!(places, sample.face_vertices(f).map(|v| Some(v.into())));
        }
        validate(&sample);
    }
}

fn share_edge_at(mesh: &TriangleMesh, v: Vertex, f: Face, g: Face) -> bool {
    let others = |f: Face| mesh.face_vertices(f).into_iter().filter(move |u| *u != v);
    others(f).any(|u| others(g).any(|w| u == w))
}

/// Returns whether any choice of orientations makes the faces consistent across all edges with two
/// faces, by trying all choices.
fn orientable_slowly(sample: &TriangleMesh) -> bool {
    (0..1u32 << sample.face_count()).any(|choice| {
        let turned = sample.with_flipped_faces(|f| choice >> f.0 & 1 == 1);
        turned.edges().all(|e| match turned.edge_halfedges(e) {
            &[g, h] => turned.origin(g) == turned.tip(h),
            _ => true,
        })
    })
}

/// Returns some faces of a projective plane, in any orientation: bands with and without a twist.
fn holed_projective_plane(random: &mut Random) -> TriangleMesh {
    let whole = projective_plane();
    let keep: Vec<_> = whole.triangles().iter().copied().filter(|_| random.below(4) > 0).collect();
    mesh(whole.positions().to_vec(), keep).with_flipped_faces(|_| random.below(2) == 0)
}

#[test]
fn orientability() {
    let mut random = Random(23);
    let mut nonorientable = 0;
    for round in 0..200 {
        let sample =
            if round % 2 == 0 { random_complex(&mut random) } else { holed_projective_plane(&mut random) };
        let orientation = Orientation::of(&sample);
        let expected = orientable_slowly(&sample);
        assert_eq!(orientation.is_orientable(), expected);
        assert_eq!(Topology::of(&sample).is_orientable(), expected);
        assert_eq!(Orientation::of(&orient(&sample).mesh).is_consistent(), expected);
        nonorientable += usize::from(!expected);
    }
    assert!((10..190).contains(&nonorientable), "the samples must contain both kinds");
}
