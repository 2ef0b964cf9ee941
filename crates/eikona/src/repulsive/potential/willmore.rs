//! The Willmore energy `f^T A M^-1 A f` (RS section 7.3.5).
//!
//! `A f` at a vertex is the derivative of the total area by it, and `M` the lumped mass matrix. So
//! the energy is the sum over vertices of `|g|^2 / m` with area derivatives g and dual areas m, and
//! its derivative needs only first and second derivatives of the areas of faces.

use super::surface::{FaceShape, Vec3, add_faces, dual_areas, face_shapes};
use crate::geometry::vector::{dot, scale};
use crate::repulsive::error::RepulsiveError;
use eikona_mesh::TriangleMesh;

/// The derivative of the area by each vertex, zero at boundary vertices, and the dual areas.
struct Curvature {
    gradients: Vec<Vec3>,
    areas: Vec<f64>,
}

impl Curvature {
    fn of(mesh: &TriangleMesh, shapes: &[FaceShape]) -> Curvature {
        let mut gradients = vec![[0.0; 3]; mesh.vertex_count()];
        add_faces(mesh, shapes, &mut gradients, |_, _, shape| shape.area_gradient());
        // There, the derivative is the conormal of the boundary rather than a curvature.
        for edge in mesh.edges().filter(|&edge| mesh.is_boundary_edge(edge)) {
            mesh.edge_vertices(edge).into_iter().for_each(|v| gradients[v.0 as usize] = [0.0; 3]);
        }
        Curvature { gradients, areas: dual_areas(mesh, shapes) }
    }

    /// `g / m` at each vertex: twice the mean curvature times the normal, outwards on a sphere.
    /// Zero at vertices without faces.
    fn normals(&self) -> Vec<Vec3> {
        let normal = |(&gradient, &area): (&Vec3, &f64)| {
            if area > 0.0 { scale(gradient, 1.0 / area) } else { [0.0; 3] }
        };
        self.gradients.iter().zip(&self.areas).map(normal).collect()
    }
}

pub(super) fn value(mesh: &TriangleMesh) -> Result<f64, RepulsiveError> {
    let curvature = Curvature::of(mesh, &face_shapes(mesh)?);
    let normals = curvature.normals();
    Ok(curvature.gradients.iter().zip(&normals).map(|(&gradient, &normal)| dot(gradient, normal)).sum())
}

pub(super) fn differential(mesh: &TriangleMesh) -> Result<Vec<Vec3>, RepulsiveError> {
    let shapes = face_shapes(mesh)?;
    let normals = Curvature::of(mesh, &shapes).normals();
    let mut result = vec![[0.0; 3]; mesh.vertex_count()];
    add_faces(mesh, &shapes, &mut result, |_, corners, shape| {
        let at_corners = corners.map(|v| normals[v]);
        // d(|g|^2 / m) = 2 (g / m) . dg - |g / m|^2 dm, and second derivatives are symmetric.
        let by_gradient = shape.area_hessian_times(at_corners);
        let by_area = at_corners.iter().map(|&n| dot(n, n)).sum::<f64>() / 3.0;
        let area = shape.area_gradient();
        [0, 1, 2].map(|c| [0, 1, 2].map(|k| 2.0 * by_gradient[c][k] - by_area * area[c][k]))
    });
    Ok(result)
}
