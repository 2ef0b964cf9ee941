//! Total area and volume, and their derivatives by the vertices.

use crate::geometry::vector::{cross, dot, norm, scale, sub};
use crate::repulsive::error::RepulsiveError;
use eikona_mesh::{Edge, TriangleMesh};

type Vec3 = [f64; 3];

/// A quantity that the flow can keep or let grow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Quantity {
    /// The total area.
    Area,
    /// The signed volume that the surface encloses: positive if it is oriented outwards. For a
    /// surface with boundary, that of the cone over it from the origin.
    Volume,
}

impl std::fmt::Display for Quantity {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str(match self {
            Quantity::Area => "area",
            Quantity::Volume => "volume",
        })
    }
}

impl Quantity {
    /// Returns the quantity of a mesh.
    pub fn of(self, mesh: &TriangleMesh) -> f64 {
        let of_face = |[a, b, c]: [Vec3; 3]| match self {
            Quantity::Area => 0.5 * norm(cross(sub(b, a), sub(c, a))),
            Quantity::Volume => dot(a, cross(b, c)) / 6.0,
        };
        mesh.faces().map(|f| of_face(mesh.face_positions(f))).sum()
    }

    /// Returns the derivative by each vertex.
    pub(super) fn differential(self, mesh: &TriangleMesh) -> Vec<Vec3> {
        let mut result = vec![[0.0; 3]; mesh.vertex_count()];
        for (f, corners) in mesh.faces().zip(mesh.triangles()) {
            let [a, b, c] = mesh.face_positions(f);
            let own = match self {
                Quantity::Area => {
                    let doubled = cross(sub(b, a), sub(c, a));
                    let half = scale(doubled, 0.5 / norm(doubled));
                    [sub(c, b), sub(a, c), sub(b, a)].map(|side| cross(half, side))
                }
                Quantity::Volume => [cross(b, c), cross(c, a), cross(a, b)].map(|x| scale(x, 1.0 / 6.0)),
            };
            for (&v, own) in corners.iter().zip(own) {
                (0..3).for_each(|k| result[v as usize][k] += own[k]);
            }
        }
        result
    }
}

/// # Errors
/// [`RepulsiveError::Inconsistent`] if the faces at an edge are not oriented consistently.
pub(super) fn check_oriented(mesh: &TriangleMesh) -> Result<(), RepulsiveError> {
    let is_consistent = |edge: &Edge| match mesh.edge_halfedges(*edge) {
        [_] => true,
        &[g, h] => mesh.follows_edge(g) != mesh.follows_edge(h),
        _ => false,
    };
    let fault = mesh.edges().find(|edge| !is_consistent(edge));
    fault.map_or(Ok(()), |edge| Err(RepulsiveError::Inconsistent { edge }))
}
