//! Centroids, normals and areas of faces, and derivatives by them pulled back to vertices.

use crate::geometry::vector::{add, cross, dot, norm, scale, sub};
use crate::repulsive::error::RepulsiveError;
use eikona_mesh::{ElementId, Face, TriangleMesh, VertexField};
use eikona_numeric::mapped;

/// One face as the energy sees it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FaceDatum {
    pub centroid: [f64; 3],
    pub normal: [f64; 3],
    pub area: f64,
}

/// Derivatives of a function by centroid, normal and area of a face.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FaceForce {
    pub centroid: [f64; 3],
    pub normal: [f64; 3],
    pub area: f64,
}

impl FaceForce {
    pub fn add(&mut self, other: &FaceForce) {
        for k in 0..3 {
            self.centroid[k] += other.centroid[k];
            self.normal[k] += other.normal[k];
        }
        self.area += other.area;
    }
}

/// Returns all faces, with lengths divided by `unit`.
///
/// # Errors
/// [`RepulsiveError::FlatFace`] with the first such face, [`RepulsiveError::Numeric`].
pub(crate) fn face_data(
    mesh: &TriangleMesh,
    unit: f64,
    threads: usize,
) -> Result<Vec<FaceDatum>, RepulsiveError> {
    let data = mapped(threads, mesh.face_count(), |f| {
        let [a, b, c] = mesh.face_positions(Face::from_index(f)).map(|p| p.map(|x| x / unit));
        let doubled = cross(sub(b, a), sub(c, a));
        let size = norm(doubled);
        let centroid = scale(add(add(a, b), c), 1.0 / 3.0);
        FaceDatum { centroid, normal: scale(doubled, 1.0 / size), area: 0.5 * size }
    })?;
    match data.iter().position(|datum| !(datum.area > 0.0 && datum.area.is_finite())) {
        Some(f) => Err(RepulsiveError::FlatFace { face: Face::from_index(f) }),
        None => Ok(data),
    }
}

/// Returns the derivatives by the vertices, in the units of [`face_data`].
pub(crate) fn pulled_back(
    mesh: &TriangleMesh,
    unit: f64,
    data: &[FaceDatum],
    forces: &[FaceForce],
) -> VertexField<[f64; 3]> {
    let mut result = VertexField::constant(mesh.vertex_count(), [0.0; 3]);
    for (face, (datum, force)) in mesh.faces().zip(data.iter().zip(forces)) {
        let [a, b, c] = mesh.face_positions(face).map(|p| p.map(|x| x / unit));
        // By the cross product of two sides, whose length is twice the area.
        let along = dot(force.normal, datum.normal);
        let tangent = sub(force.normal, scale(datum.normal, along));
        let by_cross = add(scale(datum.normal, 0.5 * force.area), scale(tangent, 0.5 / datum.area));
        let at_b = cross(sub(c, a), by_cross);
        let at_c = cross(by_cross, sub(b, a));
        let at_a = scale(add(at_b, at_c), -1.0);
        let third = scale(force.centroid, 1.0 / 3.0);
        for (v, own) in mesh.face_vertices(face).into_iter().zip([at_a, at_b, at_c]) {
            result[v] = add(result[v], add(own, third));
        }
    }
    result
}

/// What one face contributes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Row {
    /// The sum over all other faces T of `K(S, T) a_T`.
    pub density: f64,
    /// The derivatives of the whole energy by this face.
    pub force: FaceForce,
}

impl Row {
    pub fn add(&mut self, other: &Row) {
        self.density += other.density;
        self.force.add(&other.force);
    }
}
