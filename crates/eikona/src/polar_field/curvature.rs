//! Principal directions of faces, from the bends at edges (Cohen-Steiner and Morvan 2003).

use crate::geometry::vector::{Vec3, cross, dot, normalize, scale, sub};
use crate::polar_field::bevel::BeveledMesh;
use crate::polar_field::face_field::FaceTarget;
use crate::polar_field::guides::{bend, power};
use eikona_mesh::VertexField;
use eikona_numeric::Complex;

/// Returns the direction of largest curvature in each face, raised to the N-th power for even N,
/// weighted by the area times the squared difference of the principal curvatures.
///
/// The weights have no unit, like the smoothness they compete with: the field follows the curvature
/// where the radii of curvature differ by more than the field has room to turn.
pub(crate) fn principal_directions(bevel: &BeveledMesh, degree: u32) -> Vec<FaceTarget> {
    let mesh = &bevel.mesh;
    // Per vertex: the sum of bend times length times the square of the edge's direction, and a
    // third of the area around it.
    let mut tensors: VertexField<[[f64; 3]; 3]> = VertexField::constant(mesh.vertex_count(), [[0.0; 3]; 3]);
    let mut areas = VertexField::constant(mesh.vertex_count(), 0.0);
    for (h, twin) in bevel.edges() {
        let ends = [mesh.origin(h), mesh.tip(h)];
        let Some(along) = normalize(sub(mesh.position(ends[1]), mesh.position(ends[0]))) else { continue };
        let length = bevel.triangles[h.face().index()].lengths[h.side()];
        let weight = 0.5 * bend(bevel, h, twin) * length;
        for v in ends {
            (0..3).for_each(|i| (0..3).for_each(|j| tensors[v][i][j] += weight * along[i] * along[j]));
        }
    }
    for face in mesh.faces() {
        let third = bevel.triangles[face.index()].area / 3.0;
        mesh.face_vertices(face).into_iter().for_each(|v| areas[v] += third);
    }
    let mut targets = Vec::with_capacity(mesh.face_count());
    for face in mesh.faces() {
        let [a, b, c] = mesh.face_positions(face);
        let (Some(along), Some(other)) = (normalize(sub(b, a)), normalize(sub(c, a))) else { continue };
        let Some(normal) = normalize(cross(along, other)) else { continue };
        let across = cross(normal, along);
        let mean = |p: Vec3, q: Vec3| -> f64 {
            let of_vertex = |v| {
                let rows: [f64; 3] = tensors[v].map(|row| dot(row, q));
                dot(scale(p, 1.0 / areas[v]), rows)
            };
            mesh.face_vertices(face).into_iter().map(of_vertex).sum::<f64>() / 3.0
        };
        let (xx, xy, yy) = (mean(along, along), mean(along, across), mean(across, across));
        // An edge bends across itself: the tensor has its large value along the direction of small
        // curvature.
        let squared = Complex { re: yy - xx, im: -2.0 * xy };
        let size = squared.norm();
        let area = bevel.triangles[face.index()].area;
        let direction = 0.5 * squared.arg();
        let direction = Complex { re: direction.cos(), im: direction.sin() };
        targets.push(FaceTarget { face, value: power(direction, degree), weight: area * size * size });
    }
    targets
}
