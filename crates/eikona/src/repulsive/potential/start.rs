//! Distance from the positions and face areas at the start.

use super::surface::{FaceShape, Vec3, add_faces, dual_areas, face_shapes};
use crate::geometry::vector::{dot, scale, sub};
use crate::repulsive::error::RepulsiveError;
use eikona_mesh::{ElementId, Face, FaceField, TriangleMesh, VertexField};

/// Positions from which a surface is held back, with weights.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StartPositions {
    /// The position of each vertex at the start.
    pub positions: VertexField<[f64; 3]>,
    /// The weight of each vertex: a third of the area of its faces at the start.
    pub areas: VertexField<f64>,
}

impl StartPositions {
    /// Takes positions and areas of a mesh.
    ///
    /// # Errors
    /// [`RepulsiveError::FlatFace`].
    ///
    /// ```
    /// use eikona::mesh::{TriangleMesh, Vertex};
    /// use eikona::repulsive::StartPositions;
    /// let corners = vec![[0., 0., 0.], [3., 0., 0.], [0., 2., 0.]];
    /// let triangle = TriangleMesh::new(corners, vec![[0, 1, 2]])?;
    /// assert_eq!(StartPositions::of(&triangle)?.areas[Vertex(1)], 1.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn of(mesh: &TriangleMesh) -> Result<StartPositions, RepulsiveError> {
        let areas = dual_areas(mesh, &face_shapes(mesh)?);
        Ok(StartPositions { positions: mesh.positions().to_vec().into(), areas: areas.into() })
    }

    /// # Errors
    /// [`RepulsiveError::WrongCount`], [`RepulsiveError::Target`].
    fn check(&self, mesh: &TriangleMesh) -> Result<(), RepulsiveError> {
        check_count("start positions", self.positions.len(), mesh.vertex_count(), "vertices")?;
        check_count("start areas", self.areas.len(), mesh.vertex_count(), "vertices")?;
        let coordinates = self.positions.as_slice().iter().flatten();
        match coordinates.chain(self.areas.as_slice()).find(|x| !x.is_finite()) {
            Some(&value) => Err(RepulsiveError::Target { what: "a start position or area", value }),
            None => Ok(()),
        }
    }

    /// How far each vertex is from its start, with its weight.
    fn moves<'a>(&'a self, mesh: &'a TriangleMesh) -> impl Iterator<Item = (Vec3, f64)> + 'a {
        let starts = self.positions.as_slice().iter().zip(self.areas.as_slice());
        mesh.positions().iter().zip(starts).map(|(&x, (&start, &area))| (sub(x, start), area))
    }

    pub(super) fn value(&self, mesh: &TriangleMesh) -> Result<f64, RepulsiveError> {
        self.check(mesh)?;
        Ok(self.moves(mesh).map(|(moved, area)| area * dot(moved, moved)).sum())
    }

    pub(super) fn differential(&self, mesh: &TriangleMesh) -> Result<Vec<Vec3>, RepulsiveError> {
        self.check(mesh)?;
        Ok(self.moves(mesh).map(|(moved, area)| scale(moved, 2.0 * area)).collect())
    }
}

fn check_count(
    what: &'static str,
    found: usize,
    expected: usize,
    elements: &'static str,
) -> Result<(), RepulsiveError> {
    let fault = RepulsiveError::WrongCount { what, found, expected, elements };
    if found == expected { Ok(()) } else { Err(fault) }
}

/// Returns the areas of the faces of a mesh.
pub(super) fn areas_of(mesh: &TriangleMesh) -> Result<FaceField<f64>, RepulsiveError> {
    Ok(face_shapes(mesh)?.iter().map(|shape| shape.area).collect::<Vec<_>>().into())
}

/// # Errors
/// [`RepulsiveError::WrongCount`], [`RepulsiveError::TargetArea`].
fn check_areas(mesh: &TriangleMesh, targets: &FaceField<f64>) -> Result<(), RepulsiveError> {
    check_count("face areas", targets.len(), mesh.face_count(), "faces")?;
    let bad = targets.as_slice().iter().position(|&area| !(area > 0.0 && area.is_finite()));
    bad.map_or(Ok(()), |f| {
        Err(RepulsiveError::TargetArea { face: Face::from_index(f), area: targets.as_slice()[f] })
    })
}

/// Returns the sum over faces of `(a - a0)^2 / a0`.
pub(super) fn area_value(mesh: &TriangleMesh, targets: &FaceField<f64>) -> Result<f64, RepulsiveError> {
    check_areas(mesh, targets)?;
    let own = |(shape, &target): (&FaceShape, &f64)| (shape.area - target) * (shape.area / target - 1.0);
    Ok(face_shapes(mesh)?.iter().zip(targets.as_slice()).map(own).sum())
}

pub(super) fn area_differential(
    mesh: &TriangleMesh,
    targets: &FaceField<f64>,
) -> Result<Vec<Vec3>, RepulsiveError> {
    check_areas(mesh, targets)?;
    let mut result = vec![[0.0; 3]; mesh.vertex_count()];
    add_faces(mesh, &face_shapes(mesh)?, &mut result, |f, _, shape| {
        let slope = 2.0 * (shape.area / targets.as_slice()[f] - 1.0);
        shape.area_gradient().map(|by_area| scale(by_area, slope))
    });
    Ok(result)
}
