//! Topology and orientation of known surfaces.

use crate::shapes::{Seam, book, cube, glued_grid, grid, mesh, moebius, projective_plane, two_tetrahedra};
use eikona_mesh::{Edge, Face, NonmanifoldVertex, Orientation, Topology, TriangleMesh, Vertex};

/// Returns chi, loops, genus and nonorientable genus of a connected manifold.
fn surface(mesh: &TriangleMesh) -> (i64, usize, Option<u32>, Option<u32>) {
    let topology = Topology::of(mesh);
    assert!(topology.is_manifold());
    assert_eq!((topology.sheet_count, topology.components.len()), (1, 1));
    let c = &topology.components[0];
    assert_eq!(c.euler_characteristic, topology.euler_characteristic);
    assert_eq!(c.boundary_loop_count, topology.boundary_loops.len());
    assert!(topology.boundary_loops.iter().all(|l| l.is_closed()));
    assert_eq!(c.orientable, Orientation::of(mesh).is_orientable());
    (c.euler_characteristic, c.boundary_loop_count, c.genus, c.nonorientable_genus)
}

#[test]
fn closed_and_open_surfaces() {
    use Seam::{Joined, Open, Reflected};
    assert_eq!(surface(&grid(4, 3)), (1, 1, Some(0), None));
    assert_eq!(surface(&glued_grid(5, 3, [Joined, Open])), (0, 2, Some(0), None));
    assert_eq!(surface(&glued_grid(5, 4, [Joined, Joined])), (0, 0, Some(1), None));
    assert_eq!(surface(&glued_grid(5, 3, [Reflected, Open])), (0, 1, None, Some(1)));
    assert_eq!(surface(&glued_grid(5, 4, [Reflected, Joined])), (0, 0, None, Some(2)));
    assert_eq!(surface(&moebius(12, 2)), (0, 1, None, Some(1)));
    assert_eq!(surface(&projective_plane()), (1, 0, None, Some(1)));
    assert_eq!(surface(&cube()), (2, 0, Some(0), None));
}

#[test]
fn punctured_torus_of_genus_one_with_two_loops() {
    let torus = glued_grid(6, 6, [Seam::Joined, Seam::Joined]);
    let faces =
        torus.triangles().iter().enumerate().filter(|(f, _)| *f != 0 && *f != 40).map(|(_, f)| *f).collect();
    assert_eq!(surface(&mesh(torus.positions().to_vec(), faces)), (-2, 2, Some(1), None));
}

#[test]
fn empty_mesh_and_unreferenced_vertices() {
    let topology = Topology::of(&mesh(vec![[0., 0., 0.]; 3], vec![]));
    assert_eq!((topology.euler_characteristic, topology.components.len(), topology.sheet_count), (0, 0, 0));
    assert_eq!(topology.unreferenced_vertices, [Vertex(0), Vertex(1), Vertex(2)]);
    assert_eq!(topology.component_of_vertex[Vertex(1)], None);
}

#[test]
fn boundary_loop_has_the_surface_on_its_left() {
    let topology = Topology::of(&grid(2, 2));
    let rim = &topology.boundary_loops[0];
    // The flat grid has its vertices at (k / 3, k % 3); counter-clockwise from edge (0, 3).
    assert_eq!(rim.vertices.iter().map(|v| v.0).collect::<Vec<_>>(), [0, 3, 6, 7, 8, 5, 2, 1]);
}

#[test]
fn loops_that_touch_at_a_vertex_stay_apart() {
    // Remove from a 4 by 2 grid two squares that touch only in a corner, at the inner vertex (2,
    // 1).
    let full = grid(4, 2);
    let square_of = |f: usize| (f / 4, f / 2 % 2);
    let faces = full
        .triangles()
        .iter()
        .enumerate()
        .filter(|(f, _)| square_of(*f) != (1, 0) && square_of(*f) != (2, 1))
        .map(|(_, f)| *f)
        .collect();
    let topology = Topology::of(&mesh(full.positions().to_vec(), faces));
    assert_eq!(topology.nonmanifold_vertices.len(), 1);
    // The holes open to the rim, so one outline visits the vertex twice, and each visit stays in
    // its own fan.
    assert!(topology.boundary_loops.iter().all(|l| l.is_closed()));
    let edges: usize = topology.boundary_loops.iter().map(|l| l.halfedges.len()).sum();
    assert_eq!(edges, 16);

    // Two triangles that touch in a vertex: two loops of three edges, one boundary component.
    let bow_tie = mesh(
        vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [-1., 0., 0.], [-1., -1., 0.]],
        vec![[0, 1, 2], [0, 3, 4]],
    );
    let topology = Topology::of(&bow_tie);
    assert_eq!(topology.boundary_loops.iter().map(|l| l.halfedges.len()).collect::<Vec<_>>(), [3, 3]);
    assert_eq!(topology.boundary_component_count, 1);
    assert_eq!(topology.nonmanifold_vertices, [NonmanifoldVertex { vertex: Vertex(0), fans: 2 }]);
    assert_eq!((topology.sheet_count, topology.components.len()), (2, 1));
}

#[test]
fn three_triangles_at_one_edge() {
    let topology = Topology::of(&book(3));
    assert_eq!(topology.nonmanifold_edges, [Edge(0)]);
    assert_eq!(topology.nonmanifold_vertices, []);
    assert_eq!((topology.sheet_count, topology.components.len(), topology.euler_characteristic), (1, 1, 1));
    assert_eq!(topology.components[0].genus, None);
    // Six boundary edges: two blades form a loop of four, the third an open chain of two.
    let shape: Vec<_> = topology.boundary_loops.iter().map(|l| (l.halfedges.len(), l.is_closed())).collect();
    assert_eq!(shape, [(4, true), (2, false)]);
    let chain = &topology.boundary_loops[1];
    assert_eq!(chain.vertices.len(), 3);
    assert_eq!(topology.boundary_component_count, 1);
    // Orientation is not transported across the edge: each blade is its own patch.
    let orientation = Orientation::of(&book(3));
    assert_eq!(orientation.patches.len(), 3);
    assert!(orientation.is_orientable() && orientation.is_consistent());
}

#[test]
fn tetrahedra_that_share_a_vertex_an_edge_or_nothing() {
    let apart = Topology::of(&two_tetrahedra(0));
    assert_eq!((apart.sheet_count, apart.components.len(), apart.euler_characteristic), (2, 2, 4));
    assert!(apart.components.iter().all(|c| c.genus == Some(0) && c.euler_characteristic == 2));

    let at_vertex = Topology::of(&two_tetrahedra(1));
    assert_eq!(
        (at_vertex.sheet_count, at_vertex.components.len(), at_vertex.euler_characteristic),
        (2, 1, 3)
    );
    assert_eq!(at_vertex.nonmanifold_vertices, [NonmanifoldVertex { vertex: Vertex(0), fans: 2 }]);
    assert_eq!(at_vertex.components[0].genus, None);

    let at_edge = Topology::of(&two_tetrahedra(2));
    // The shared edge and its endpoints count once: 2 + 2 - (2 - 1).
    assert_eq!((at_edge.sheet_count, at_edge.components.len(), at_edge.euler_characteristic), (1, 1, 3));
    assert_eq!((at_edge.nonmanifold_edges.len(), at_edge.nonmanifold_vertices.len()), (1, 0));
    assert!(!at_edge.is_manifold() && at_edge.is_closed());
    let orientation = Orientation::of(&two_tetrahedra(2));
    assert_eq!(orientation.patches.len(), 2);
}

#[test]
fn minority_of_area_is_flipped() {
    // The areas of the strip's squares increase: the last two outweigh the first three.
    let strip = grid(5, 1);
    let widths = [0.0, 1.0, 2.0, 3.0, 10.0, 20.0];
    let positions = (0..12).map(|k| [widths[k / 2], (k % 2) as f64, 0.0]).collect();
    let strip = strip.with_positions(positions).expect("finite").with_flipped_faces(|f| f.0 < 6);
    let orientation = Orientation::of(&strip);
    assert_eq!(orientation.flipped_faces(), (0..6).map(Face).collect::<Vec<_>>());
    assert_eq!((orientation.inconsistent_edges.len(), orientation.patches[0].flipped_face_count), (1, 6));
    // On a tie the first face keeps its orientation.
    let halves = grid(2, 1).with_flipped_faces(|f| f.0 < 2);
    assert_eq!(Orientation::of(&halves).flipped_faces(), [Face(2), Face(3)]);
}

#[test]
fn nonorientable_patch_has_a_witness_and_keeps_its_orientation() {
    let band = moebius(10, 2).with_flipped_faces(|f| f.0 % 3 == 0);
    let orientation = Orientation::of(&band);
    assert!(!orientation.is_orientable());
    let witness = orientation.patches[0].witness.expect("a witness");
    assert_eq!(band.edge_halfedges(witness).len(), 2);
    assert!(orientation.flipped_faces().is_empty());
    // A second, orientable patch next to it is oriented all the same.
    let mut positions = band.positions().to_vec();
    let start = positions.len() as u32;
    positions.extend([[9., 0., 0.], [8., 0., 0.], [8., 1., 0.], [9., 5., 0.]]);
    let mut faces = band.triangles().to_vec();
    faces.extend([[start, start + 1, start + 2], [start, start + 3, start + 2]]);
    let both = mesh(positions, faces);
    let orientation = Orientation::of(&both);
    assert_eq!(orientation.patches.iter().map(|p| p.is_orientable()).collect::<Vec<_>>(), [false, true]);
    let topology = Topology::of(&both);
    assert_eq!(topology.components[0].nonorientable_genus, Some(1));
    assert_eq!(topology.components[1].genus, Some(0));
}
