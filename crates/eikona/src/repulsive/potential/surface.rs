//! Areas of the faces of a surface, with first and second derivatives by the vertices.

use crate::geometry::power_of_two_near;
use crate::geometry::vector::{add, cross, dot, norm, scale, sub};
use crate::repulsive::error::RepulsiveError;
use eikona_mesh::TriangleMesh;

pub(super) type Vec3 = [f64; 3];

/// One face with its unit normal and area.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceShape {
    corners: [Vec3; 3],
    normal: Vec3,
    pub area: f64,
}

impl FaceShape {
    pub fn centroid(&self) -> Vec3 {
        let [a, b, c] = self.corners;
        scale(add(add(a, b), c), 1.0 / 3.0)
    }

    /// The side across from each corner, in the direction of the face.
    fn sides(&self) -> [Vec3; 3] {
        let [a, b, c] = self.corners;
        [sub(c, b), sub(a, c), sub(b, a)]
    }

    /// Returns the derivative of the area by each corner.
    pub fn area_gradient(&self) -> [Vec3; 3] {
        self.sides().map(|side| scale(cross(self.normal, side), 0.5))
    }

    /// Returns the product of the second derivative of the area with a motion of the corners: how
    /// fast [`area_gradient`](Self::area_gradient) changes along it.
    pub fn area_hessian_times(&self, motion: [Vec3; 3]) -> [Vec3; 3] {
        let sides = self.sides();
        let [a, b, c] = motion;
        let moved = [sub(c, b), sub(a, c), sub(b, a)];
        // The product of the sides at corner a is twice the area times the normal; this is how it
        // changes, and the normal with it.
        let doubled = sub(cross(sides[1], moved[2]), cross(sides[2], moved[1]));
        let turning = sub(doubled, scale(self.normal, dot(self.normal, doubled)));
        let normal = scale(turning, 0.5 / self.area);
        [0, 1, 2].map(|k| scale(add(cross(normal, sides[k]), cross(self.normal, moved[k])), 0.5))
    }
}

/// Returns all faces.
///
/// # Errors
/// [`RepulsiveError::FlatFace`]: where the area is zero, it has no derivative.
pub(super) fn face_shapes(mesh: &TriangleMesh) -> Result<Vec<FaceShape>, RepulsiveError> {
    let shape = |face| {
        let corners @ [a, b, c] = mesh.face_positions(face);
        let doubled = cross(sub(b, a), sub(c, a));
        // The square of an area leaves the range of numbers long before the area does.
        let unit = power_of_two_near(doubled.iter().fold(0.0f64, |m, x| m.max(x.abs())));
        let doubled = doubled.map(|x| x / unit);
        let size = norm(doubled);
        let area = 0.5 * size * unit;
        let flat = !(area > 0.0 && area.is_finite());
        let shape = FaceShape { corners, normal: scale(doubled, 1.0 / size), area };
        if flat { Err(RepulsiveError::FlatFace { face }) } else { Ok(shape) }
    };
    mesh.faces().map(shape).collect()
}

/// Returns a third of the area of the faces at each vertex: the lumped mass matrix.
pub(super) fn dual_areas(mesh: &TriangleMesh, shapes: &[FaceShape]) -> Vec<f64> {
    let mut result = vec![0.0; mesh.vertex_count()];
    for (corners, shape) in mesh.triangles().iter().zip(shapes) {
        corners.iter().for_each(|&v| result[v as usize] += shape.area / 3.0);
    }
    result
}

/// Adds what each face contributes at its corners.
pub(super) fn add_faces(
    mesh: &TriangleMesh,
    shapes: &[FaceShape],
    result: &mut [Vec3],
    of_face: impl Fn(usize, [usize; 3], &FaceShape) -> [Vec3; 3],
) {
    for (f, (corners, shape)) in mesh.triangles().iter().zip(shapes).enumerate() {
        let corners = corners.map(|v| v as usize);
        for (v, own) in corners.into_iter().zip(of_face(f, corners, shape)) {
            result[v] = add(result[v], own);
        }
    }
}
