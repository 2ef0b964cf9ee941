//! Where the vertices of a remeshed surface lie on the original one, and how data follows them.

use super::changing::Vec3;
use crate::geometry::vector::{add, dot, scale};
use crate::spatial::{ClosestPoint, closest_point_of_triangle};
use eikona_mesh::{Face, SurfacePoint, TriangleMesh};
use eikona_numeric::{NumericError, mapped};

/// The place of each vertex of a remeshed surface on the original one: a face, and barycentric
/// coordinates in it.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Places(pub(super) Vec<(u32, [f64; 3])>);

/// Corner values of two faces agree at a common vertex if they differ by less than this share of
/// how much they differ within a face.
const SEAM: f64 = 1e-3;

impl Places {
    /// The places of the vertices of a surface on itself.
    pub(crate) fn identity(mesh: &TriangleMesh) -> Places {
        let of = |v| {
            let mut weights = [0.0; 3];
            let corner = mesh.vertex_corners(v).first()?;
            weights[corner.0 as usize % 3] = 1.0;
            Some((corner.face().0, weights))
        };
        Places(mesh.vertices().map(|v| of(v).unwrap_or((0, [1.0, 0.0, 0.0]))).collect())
    }

    /// Returns the number of vertices.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns whether there are no vertices.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the place of a vertex as a point of the original surface.
    pub fn point(&self, original: &TriangleMesh, vertex: usize) -> SurfacePoint {
        let (face, bary) = self.0[vertex];
        SurfacePoint::Face { vertices: original.triangles()[face as usize], bary }
    }

    /// Returns values at the new vertices, interpolated linearly from those at the original ones.
    pub fn pull_vertices<const N: usize>(
        &self,
        original: &TriangleMesh,
        values: &[[f64; N]],
    ) -> Vec<[f64; N]> {
        let corners = |face: u32| original.triangles()[face as usize].map(|v| values[v as usize]);
        self.0.iter().map(|&(face, weights)| blend(corners(face), weights)).collect()
    }

    /// Returns the original face at the middle of each new face, from which it takes its values.
    pub fn parents(&self, original: &TriangleMesh, faces: &[[u32; 3]]) -> Vec<Face> {
        let parent = |corners: &[u32; 3]| Face(self.middle(original, corners).face.0);
        faces.iter().map(parent).collect()
    }

    /// Returns values at the corners of the new faces, interpolated from those at the corners of
    /// the original ones. Where these differ between faces, as texture coordinates do at a seam,
    /// so do the new ones: a face takes all its values from the side on which its middle lies. Its
    /// corners beyond the seam take those of the nearest point on that side.
    pub fn pull_corners<const N: usize>(
        &self,
        original: &TriangleMesh,
        faces: &[[u32; 3]],
        values: &[[[f64; N]; 3]],
    ) -> Vec<[[f64; N]; 3]> {
        let of_face = |corners: &[u32; 3]| {
            let middle = self.middle(original, corners).face;
            corners.map(|v| {
                let position = self.position(original, v);
                let same_side = |from, to| agree(original, values, from, to);
                let place = nearest_among(original, middle, position, same_side);
                blend(values[place.face.0 as usize], place.weights)
            })
        };
        faces.iter().map(of_face).collect()
    }

    /// The corner of the original surface that is nearest, by weight.
    pub(crate) fn near_vertex(&self, original: &TriangleMesh, vertex: usize) -> u32 {
        let (face, weights) = self.0[vertex];
        original.triangles()[face as usize][heaviest(weights)]
    }

    /// Whether all are faces of a surface.
    pub(crate) fn fit(&self, original: &TriangleMesh) -> bool {
        self.0.iter().all(|(face, _)| (*face as usize) < original.face_count())
    }

    /// Composes places on a surface with those of its vertices on an original one.
    ///
    /// # Errors
    /// [`NumericError::Stopped`].
    pub(crate) fn then(
        &self,
        faces: &[[u32; 3]],
        earlier: &Places,
        original: &TriangleMesh,
        threads: usize,
    ) -> Result<Places, NumericError> {
        let of = |vertex: usize| {
            let (face, weights) = self.0[vertex];
            let corners = faces[face as usize];
            let heaviest = heaviest(weights);
            let start = earlier.0[corners[heaviest] as usize];
            if weights[heaviest] == 1.0 {
                return start;
            }
            let p = blend(corners.map(|v| earlier.position(original, v)), weights);
            let place = nearest_from(original, Face(start.0), p);
            (place.face.0, place.weights)
        };
        Ok(Places(mapped(threads, self.len(), of)?))
    }

    fn position(&self, original: &TriangleMesh, vertex: u32) -> Vec3 {
        let (face, weights) = self.0[vertex as usize];
        blend(original.face_positions(Face(face)), weights)
    }

    /// The original point at the middle of a new face.
    fn middle(&self, original: &TriangleMesh, corners: &[u32; 3]) -> ClosestPoint {
        let sum = corners.iter().fold([0.0; 3], |sum, v| add(sum, self.position(original, *v)));
        nearest_from(original, Face(self.0[corners[0] as usize].0), scale(sum, 1.0 / 3.0))
    }
}

fn heaviest(weights: [f64; 3]) -> usize {
    (0..3).fold(0, |k, i| if weights[i] > weights[k] { i } else { k })
}

/// The weighted mean. Corners without weight may have any value, also NaN.
fn blend<const N: usize>(corners: [[f64; N]; 3], weights: [f64; 3]) -> [f64; N] {
    let weighty = (0..3).filter(|i| weights[*i] != 0.0);
    std::array::from_fn(|k| weighty.clone().map(|i| weights[i] * corners[i][k]).sum())
}

/// The squared distance of a point from the box of a triangle.
fn squared_distance_of_box(p: Vec3, [a, b, c]: [Vec3; 3]) -> f64 {
    let away = [0, 1, 2].map(|k| {
        let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
        (low - p[k]).max(p[k] - high).max(0.0)
    });
    dot(away, away)
}

/// Whether the corner values of two faces agree at a vertex that both have.
fn agree<const N: usize>(mesh: &TriangleMesh, values: &[[[f64; N]; 3]], from: Face, to: Face) -> bool {
    let [own, other] = [from, to].map(|face| &values[face.index()]);
    let far = |a: &[f64; N], b: &[f64; N]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let extent = far(&own[0], &own[1]).max(far(&own[1], &own[2])).max(far(&own[2], &own[0]));
    let [corners, others] = [from, to].map(|face| mesh.face_vertices(face));
    (0..3).any(|i| (0..3).any(|k| corners[i] == others[k] && far(&own[i], &other[k]) <= SEAM * extent))
}

/// Goes from a face to neighbours that are closer to a point, as long as there are any. Unlike the
/// closest point of the whole surface, this does not leap to a sheet that happens to be near.
pub(super) fn nearest_from(mesh: &TriangleMesh, start: Face, p: Vec3) -> ClosestPoint {
    nearest_among(mesh, start, p, |_, _| true)
}

/// As [`nearest_from`], by steps from a face to another that are allowed.
fn nearest_among(
    mesh: &TriangleMesh,
    start: Face,
    p: Vec3,
    allowed: impl Fn(Face, Face) -> bool,
) -> ClosestPoint {
    let mut face = start;
    let (mut weights, mut position, mut squared) = closest_point_of_triangle(p, mesh.face_positions(face));
    loop {
        let here = face;
        for corner in mesh.face_vertices(here).into_iter().flat_map(|v| mesh.vertex_corners(v)) {
            let other = corner.face();
            let corners = mesh.face_positions(other);
            // Most faces around are not close enough.
            if other == face || squared_distance_of_box(p, corners) > squared || !allowed(here, other) {
                continue;
            }
            let found = closest_point_of_triangle(p, corners);
            if found.2 < squared {
                (face, (weights, position, squared)) = (other, found);
            }
        }
        if face == here {
            return ClosestPoint { face, weights, position, distance: squared.sqrt() };
        }
    }
}
