//! The mesh cut open along the completed boundary of the regions.

mod regions;

use eikona::contour::plane_cut;
use eikona::mesh::{Curve, Face, FaceField, SurfaceCurves, Topology, TriangleMesh, Vertex, shapes};
use eikona::winding::{Split, Winding, WindingOptions, surface_winding_number};
use regions::{boundary_of, centre};

fn solve(mesh: &TriangleMesh, curves: Vec<Curve>) -> Winding {
    let curves = SurfaceCurves { curves, points: Vec::new() };
    surface_winding_number(mesh, &curves, &WindingOptions::default()).unwrap()
}

/// Splits, and checks what holds for every split: places are kept, first copies keep their number,
/// every vertex has one label, and edges between equal labels are whole.
fn split(w: &Winding) -> Split {
    let split = w.split().unwrap();
    let (cut, whole) = (&split.mesh, &w.mesh);
    assert_eq!(cut.face_count(), whole.face_count());
    assert!(split.provenance.keeps_faces());
    for v in cut.vertices() {
        let parent = split.provenance.vertex_parent(v).unwrap();
        assert!(v == parent || v.index() >= whole.vertex_count());
        assert_eq!(cut.position(v), whole.position(parent));
        let corners = cut.vertex_corners(v);
        assert!(corners.iter().all(|c| w.labels[c.face()] == w.labels[corners[0].face()]));
    }
    for f in cut.faces() {
        assert_eq!(
            cut.face_vertices(f).map(|v| split.provenance.vertex_parent(v).unwrap()),
            whole.face_vertices(f)
        );
    }
    for e in whole.edges() {
        let at = whole.edge_halfedges(e);
        for pair in at.windows(2).filter(|p| w.labels[p[0].face()] == w.labels[p[1].face()]) {
            assert_eq!(cut.edge(pair[0]), cut.edge(pair[1]));
        }
    }
    split
}

/// Returns the Euler characteristics of the components, sorted.
fn characteristics(mesh: &TriangleMesh) -> Vec<i64> {
    let topology = Topology::of(mesh);
    assert!(topology.is_manifold());
    let mut found: Vec<i64> = topology.components.iter().map(|c| c.euler_characteristic).collect();
    found.sort_unstable();
    found
}

#[test]
fn a_cap_splits_a_sphere_into_two_disks() {
    let sphere = shapes::geodesic_sphere(10).unwrap();
    let rim = boundary_of(&sphere, |f| centre(&sphere, f)[2] > 0.4);
    let rim_length = rim.len();
    let w = solve(&sphere, rim);
    let cut = split(&w);
    assert_eq!(characteristics(&cut.mesh), [1, 1]);
    assert_eq!(cut.mesh.vertex_count(), sphere.vertex_count() + rim_length);
    assert!(w.provenance.is_identity());
}

#[test]
fn a_band_splits_a_torus_into_two_annuli() {
    let torus = shapes::torus(1.0, 0.4, 24, 12).unwrap();
    let band = |f: Face| (0.1..1.3).contains(&centre(&torus, f)[1].atan2(centre(&torus, f)[0]));
    let w = solve(&torus, boundary_of(&torus, band));
    assert!(torus.faces().all(|f| w.labels[f] == i32::from(band(f))));
    let cut = split(&w);
    assert_eq!(characteristics(&cut.mesh), [0, 0]);
    assert_eq!(Topology::of(&cut.mesh).boundary_loops.len(), 4);
}

#[test]
fn a_nonbounding_loop_does_not_split_the_mesh() {
    let torus = shapes::torus(1.0, 0.4, 24, 12).unwrap();
    let meridian = Curve::signed((0..=12).map(|j| Vertex(j % 12)));
    let w = solve(&torus, vec![meridian]);
    assert!((w.report.largest_nonbounding - 1.0).abs() < 1e-9);
    let cut = split(&w);
    assert_eq!(cut.mesh.triangles(), torus.triangles());
    assert!(cut.provenance.is_identity());
}

#[test]
fn a_crossing_of_two_loops_has_four_copies() {
    let sphere = shapes::octahedron().unwrap();
    let sides =
        |axis: usize| boundary_of(&sphere, move |f| centre(&shapes::octahedron().unwrap(), f)[axis] > 0.0);
    let w = solve(&sphere, [sides(0), sides(1)].concat());
    let cut = split(&w);
    // Four lunes of two faces each, which meet in the two points on the third axis.
    assert_eq!(characteristics(&cut.mesh), [1; 4]);
    for v in sphere.vertices() {
        let copies = cut.mesh.vertices().filter(|u| cut.provenance.vertex_parent(*u) == Some(v)).count();
        assert_eq!(copies, if sphere.position(v)[2] != 0.0 { 4 } else { 2 }, "{v:?}");
    }
}

#[test]
fn circles_and_rays_split_surfaces_with_boundary() {
    let annulus = shapes::annulus(1.0, 2.0, 6, 24).unwrap();
    let inner = |f: Face| centre(&annulus, f)[0].hypot(centre(&annulus, f)[1]) < 1.5;
    let cut = split(&solve(&annulus, boundary_of(&annulus, inner)));
    assert_eq!(characteristics(&cut.mesh), [0, 0]);
    // From boundary to boundary, twice: half of the annulus.
    let half = |f: Face| centre(&annulus, f)[1] > 0.0;
    let w = solve(&annulus, boundary_of(&annulus, half));
    assert!(w.endpoints.is_empty());
    assert_eq!(characteristics(&split(&w).mesh), [1, 1]);
}

#[test]
fn cut_faces_have_parents_and_pass_labels_to_them() {
    let sphere = shapes::geodesic_sphere(8).unwrap();
    let mut circle = plane_cut(&sphere, [0.0, 0.0, 0.31], [0.0, 0.0, 1.0]).unwrap();
    assert_eq!(circle.len(), 1);
    let w = solve(&sphere, vec![circle.remove(0)]);
    let cut = split(&w);
    assert_eq!(characteristics(&cut.mesh), [1, 1]);
    assert!(cut.mesh.face_count() > sphere.face_count());
    // All pieces lie in the planes of their parents, within their extents.
    for f in cut.mesh.faces() {
        let (piece, parent) = (centre(&cut.mesh, f), sphere.face_positions(w.provenance.face_parent(f)));
        for axis in 0..3 {
            let [low, high] =
                [f64::min, f64::max].map(|pick| parent.iter().map(|p| p[axis]).reduce(pick).unwrap());
            assert!((low - 1e-9..=high + 1e-9).contains(&piece[axis]));
        }
    }
    // One side is 0, the other is 1 or -1, depending on the direction of the circle.
    let labels = w.input_labels();
    assert_eq!(labels.len(), sphere.face_count());
    let top = labels[sphere.faces().find(|&f| centre(&sphere, f)[2] > 0.8).unwrap()];
    assert_eq!(top.abs(), 1);
    for f in sphere.faces() {
        let heights = sphere.face_positions(f).map(|p| p[2]);
        if heights.iter().all(|z| *z > 0.31) || heights.iter().all(|z| *z < 0.31) {
            assert_eq!(labels[f], if heights[0] > 0.31 { top } else { 0 });
        }
    }
    // Where the circle cuts a face, the larger part of its area decides.
    let area = |mesh: &TriangleMesh, f: Face| {
        let [a, b, c] = mesh.face_positions(f);
        let (u, v) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
        let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        0.5 * normal.iter().map(|x| x * x).sum::<f64>().sqrt()
    };
    let mut above = vec![0.0; sphere.face_count()];
    for f in w.mesh.faces().filter(|&f| w.labels[f] == top) {
        above[w.provenance.face_parent(f).index()] += area(&w.mesh, f);
    }
    let shares: Vec<f64> = sphere.faces().map(|f| above[f.index()] / area(&sphere, f)).collect();
    assert!(shares.iter().any(|s| (0.01..0.99).contains(s)));
    for f in sphere.faces().filter(|f| (shares[f.index()] - 0.5).abs() > 1e-6) {
        assert_eq!(labels[f] == top, shares[f.index()] > 0.5);
    }
}

/// A hand-made result with these labels.
fn labelled(positions: Vec<[f64; 3]>, faces: Vec<[u32; 3]>, labels: Vec<i32>) -> Winding {
    let disk = shapes::disk(3, 6, 1.0).unwrap();
    let ring = Curve::signed([1, 2, 3, 4, 5, 6, 1].map(Vertex));
    let mut w = solve(&disk, vec![ring]);
    w.mesh = TriangleMesh::new(positions, faces).unwrap();
    w.labels = FaceField::from(labels);
    w
}

#[test]
fn pages_of_equal_label_stay_joined_at_a_nonmanifold_edge() {
    // A book of four pages.
    let positions =
        vec![[0., 0., 0.], [0., 0., 1.], [1., 0., 0.], [0., 1., 0.], [-1., 0., 0.], [0., -1., 0.]];
    let pages = vec![[0, 1, 2], [1, 0, 3], [0, 1, 4], [1, 0, 5]];
    let cut = split(&labelled(positions.clone(), pages.clone(), vec![1, 0, 1, 0]));
    assert_eq!(cut.mesh.triangles(), [[0, 1, 2], [7, 6, 3], [0, 1, 4], [7, 6, 5]]);
    assert_eq!([6, 7].map(|v| cut.provenance.vertex_parent(Vertex(v))), [Some(Vertex(0)), Some(Vertex(1))]);
    let whole = split(&labelled(positions, pages.clone(), vec![3; 4]));
    assert_eq!(whole.mesh.triangles(), pages);
}

#[test]
fn touching_fans_are_split_only_if_labels_differ() {
    let positions =
        vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [-1., 0., 0.], [-1., -1., 0.], [9., 9., 9.]];
    let faces = vec![[0, 1, 2], [0, 3, 4]];
    let same = split(&labelled(positions.clone(), faces.clone(), vec![2, 2]));
    assert_eq!((same.mesh.triangles(), same.mesh.vertex_count()), (faces.as_slice(), 6));
    let apart = split(&labelled(positions, faces, vec![2, 1]));
    assert_eq!(apart.mesh.triangles(), [[0, 1, 2], [6, 3, 4]]);
}
