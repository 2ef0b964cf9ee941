//! Results do not depend on the numbering, orientation, scale and position of a mesh.

use crate::shapes::{
    Random, Seam, book, cube, glued_grid, grid, mesh, moebius, projective_plane, two_tetrahedra,
};
use eikona_mesh::{Face, Orientation, Quality, Topology, TriangleMesh, validate};

fn samples() -> Vec<TriangleMesh> {
    let mut samples = vec![
        grid(5, 4),
        glued_grid(5, 4, [Seam::Joined, Seam::Joined]),
        glued_grid(5, 4, [Seam::Reflected, Seam::Joined]),
        moebius(11, 2),
        projective_plane(),
        cube(),
        book(3),
        book(4),
    ];
    samples.extend((0..4).map(two_tetrahedra));
    samples
}

/// Permutes vertices and faces, and rotates the corners of each face.
fn renumbered(mesh_in: &TriangleMesh, random: &mut Random) -> TriangleMesh {
    let vertex = random.permutation(mesh_in.vertex_count());
    let face_order = random.permutation(mesh_in.face_count());
    let mut positions = vec![[0.0; 3]; mesh_in.vertex_count()];
    for (v, p) in mesh_in.positions().iter().enumerate() {
        positions[vertex[v] as usize] = *p;
    }
    let faces = face_order
        .iter()
        .map(|&f| {
            let mut face = mesh_in.triangles()[f as usize].map(|v| vertex[v as usize]);
            face.rotate_left(random.below(3) as usize);
            face
        })
        .collect();
    mesh(positions, faces)
}

/// Formats everything that is independent of numbering and orientation, in one line.
fn invariants(mesh: &TriangleMesh) -> String {
    let t = Topology::of(mesh);
    let mut components: Vec<String> = t
        .components
        .iter()
        .map(|c| {
            format!(
                "{:?}",
                (
                    c.vertex_count,
                    c.edge_count,
                    c.face_count,
                    c.euler_characteristic,
                    c.manifold,
                    c.orientable,
                    c.genus,
                    c.nonorientable_genus
                )
            )
        })
        .collect();
    components.sort();
    let mut fans: Vec<usize> = t.nonmanifold_vertices.iter().map(|v| v.fans).collect();
    fans.sort_unstable();
    let boundary_edges: usize = t.boundary_loops.iter().map(|l| l.halfedges.len()).sum();
    let counts = (
        t.sheet_count,
        t.boundary_loops.len(),
        boundary_edges,
        t.boundary_component_count,
        t.nonmanifold_edges.len(),
    );
    format!("{counts:?} {fans:?} {components:?}")
}

#[test]
fn topology_does_not_depend_on_numbering_or_orientation() {
    let mut random = Random(1);
    for sample in samples() {
        for _ in 0..5 {
            let other = renumbered(&sample, &mut random);
            assert_eq!(invariants(&other), invariants(&sample));
            let flipped = other.with_flipped_faces(|f| f.0 % 3 == 1);
            assert_eq!(invariants(&flipped), invariants(&sample));
            assert_eq!(Orientation::of(&flipped).is_orientable(), Orientation::of(&sample).is_orientable());
        }
    }
}

/// Each halfedge of a loop joins the vertices before and after it, and all boundary edges occur
/// exactly once.
#[test]
fn boundary_loops_are_walks_over_all_boundary_edges() {
    let mut random = Random(7);
    for sample in samples() {
        let other = renumbered(&sample, &mut random);
        let other = other.with_flipped_faces(|f| f.0 % 2 == 1);
        let topology = Topology::of(&other);
        let mut passed = Vec::new();
        for chain in &topology.boundary_loops {
            for (i, &h) in chain.halfedges.iter().enumerate() {
                let ends = [chain.vertices[i], chain.vertices[(i + 1) % chain.vertices.len()]];
                let own = [other.origin(h), other.tip(h)];
                assert!(ends == own || ends == [own[1], own[0]]);
                passed.push(other.edge(h));
            }
        }
        passed.sort_unstable();
        let boundary: Vec<_> = other.edges().filter(|&e| other.is_boundary_edge(e)).collect();
        assert_eq!(passed, boundary);
    }
}

#[test]
fn flipping_a_minority_changes_nothing() {
    let mut random = Random(3);
    let torus = glued_grid(8, 7, [Seam::Joined, Seam::Joined]);
    let whole = Quality::of(&torus).area;
    for _ in 0..10 {
        let other = renumbered(&torus, &mut random);
        let mut flip = vec![false; other.face_count()];
        let mut area = 0.0;
        for f in random.permutation(other.face_count()) {
            area += Quality::of(&mesh(other.positions().to_vec(), vec![other.triangles()[f as usize]])).area;
            if area > 0.49 * whole {
                break;
            }
            flip[f as usize] = true;
        }
        let damaged = other.with_flipped_faces(|f| flip[f.index()]);
        let orientation = Orientation::of(&damaged);
        let expected: Vec<Face> = other.faces().filter(|f| flip[f.index()]).collect();
        assert_eq!(orientation.flipped_faces(), expected);
        assert!(!orientation.is_consistent());
        assert!(Orientation::of(&eikona_mesh::orient(&damaged).mesh).is_consistent());
    }
}

#[test]
fn scale_and_position_change_neither_faults_nor_ratios() {
    let sample = moebius(14, 3);
    let quality = Quality::of(&sample);
    for scale in [1e-200, 1e-8, 1e8, 1e200] {
        let scaled = sample.positions().iter().map(|p| p.map(|x| x * scale)).collect();
        let scaled = sample.with_positions(scaled).expect("finite");
        let other = Quality::of(&scaled);
        let pairs = [
            (other.min_angle_deg, quality.min_angle_deg),
            (other.max_angle_deg, quality.max_angle_deg),
            (other.aspect_ratio.map(|r| r.max), quality.aspect_ratio.map(|r| r.max)),
            (other.edge_length.map(|r| r.mean / scale), quality.edge_length.map(|r| r.mean)),
        ];
        for (a, b) in pairs {
            let (a, b) = (a.expect("faces"), b.expect("faces"));
            assert!((a - b).abs() < 1e-12 * b.abs(), "{a} and {b} at scale {scale}");
        }
        assert_eq!((other.non_delaunay_edges, other.zero_area_faces), (quality.non_delaunay_edges, 0));
        assert_eq!(validate(&scaled), validate(&sample));
        let damaged = grid(3, 3).with_flipped_faces(|f| f.0 > 9);
        let large = damaged.positions().iter().map(|p| p.map(|x| x * scale)).collect();
        let large = damaged.with_positions(large).expect("finite");
        assert_eq!(Orientation::of(&large).sign_of_face, Orientation::of(&damaged).sign_of_face);
    }
}
