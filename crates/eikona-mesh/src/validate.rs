//! Validation: all faults of a mesh, element by element.

use crate::duplicates::{first_at_position, first_with_same_vertices};
use crate::error::Fault;
use crate::id::Vertex;
use crate::mesh::TriangleMesh;
use crate::orientation::inconsistent_edges;
use crate::quality::TriangleShape;
use crate::topology::Topology;

/// Returns all faults of a mesh: unreferenced vertices, coincident vertices, zero-area faces,
/// duplicate faces, nonmanifold edges, nonmanifold vertices, and inconsistently oriented edges; in
/// this order of kinds, and each kind in the order of its elements. An empty list means that the
/// mesh is an oriented manifold, with or without boundary, without degenerate triangles.
///
/// A face has zero area if its area is below [`ZERO_AREA`](crate::ZERO_AREA) times the square of
/// its longest edge. Faces are duplicates if they have the same three vertices in any order;
/// vertices coincide if their coordinates are equal. A nonorientable surface has inconsistent edges
/// in every orientation of its faces.
///
/// # Cost
/// O(V + F log F); about 0.7 s per million faces.
///
/// ```
/// use eikona_mesh::{Face, Fault, TriangleMesh, Vertex, validate};
/// let positions = vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [5., 5., 5.]];
/// let mesh = TriangleMesh::new(positions, vec![[0, 1, 2], [1, 2, 0]])?;
/// let faults = validate(&mesh);
/// assert_eq!(faults[0], Fault::UnreferencedVertex { vertex: Vertex(3) });
/// assert_eq!(faults[1], Fault::DuplicateFace { face: Face(1), first: Face(0) });
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn validate(mesh: &TriangleMesh) -> Vec<Fault> {
    let topology = Topology::of(mesh);
    let mut faults: Vec<Fault> =
        topology.unreferenced_vertices.iter().map(|&vertex| Fault::UnreferencedVertex { vertex }).collect();
    let first_vertex = first_at_position(mesh.positions());
    faults.extend(
        mesh.vertices()
            .zip(&first_vertex)
            .filter(|(vertex, first)| vertex.0 != **first)
            .map(|(vertex, &first)| Fault::CoincidentVertices { vertex, first: Vertex(first) }),
    );
    faults.extend(mesh.faces().filter_map(|face| {
        let shape = TriangleShape::of(mesh.face_positions(face));
        shape.is_zero_area().then(|| Fault::ZeroArea { face, area: shape.area_in(1.0) })
    }));
    faults.extend(
        mesh.faces()
            .zip(first_with_same_vertices(mesh))
            .filter(|(face, first)| face != first)
            .map(|(face, first)| Fault::DuplicateFace { face, first }),
    );
    faults.extend(topology.nonmanifold_edges.iter().map(|&edge| Fault::NonmanifoldEdge {
        edge,
        vertices: mesh.edge_vertices(edge),
        faces: mesh.edge_halfedges(edge).len(),
    }));
    faults.extend(
        topology
            .nonmanifold_vertices
            .iter()
            .map(|at| Fault::NonmanifoldVertex { vertex: at.vertex, fans: at.fans }),
    );
    faults.extend(
        inconsistent_edges(mesh)
            .into_iter()
            .map(|edge| Fault::InconsistentOrientation { edge, vertices: mesh.edge_vertices(edge) }),
    );
    faults
}
