//! Points on a surface, identified by vertices only.

use crate::error::CurveError;
use crate::id::{Edge, Face, Vertex};
use crate::mesh::TriangleMesh;
use serde::{Deserialize, Serialize};

/// A point on a triangle mesh: at a vertex, on an edge, or in a face. Elements are identified by
/// their vertices, so callers need no edge or face numbering.
///
/// ```
/// use eikona_mesh::SurfacePoint;
/// let middle = SurfacePoint::Edge { vertices: [3, 7], t: 0.5 };
/// assert_eq!(serde_json::to_string(&middle).unwrap(), r#"{"edge":[3,7],"t":0.5}"#);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
pub enum SurfacePoint {
    /// At a vertex.
    Vertex {
        /// Its 0-based index.
        vertex: u32,
    },
    /// On an edge, at `(1 - t) first + t second`.
    Edge {
        /// The endpoints of the edge.
        #[serde(rename = "edge")]
        vertices: [u32; 2],
        /// 0 at the first endpoint, 1 at the second.
        t: f64,
    },
    /// In a face, at the barycentric combination of the three vertices in the order given here.
    Face {
        /// The corners of the face, in any order.
        #[serde(rename = "face")]
        vertices: [u32; 3],
        /// Their weights, which sum to 1.
        bary: [f64; 3],
    },
}

impl From<Vertex> for SurfacePoint {
    fn from(v: Vertex) -> Self {
        SurfacePoint::Vertex { vertex: v.0 }
    }
}

/// Weights this far outside [0, 1], or sums this far from 1, are treated as rounding and clamped;
/// beyond it they are an error.
pub const BARYCENTRIC_TOLERANCE: f64 = 1e-6;

/// Weights (and parameters t) this close to 0 put a point *on* the vertex or edge: it moves by at
/// most this share of an edge.
pub const SNAP_TOLERANCE: f64 = 1e-9;

/// A surface point located in a mesh, with checked weights: at a vertex exactly if one weight is 1,
/// on an edge exactly if one weight is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Located {
    /// At a vertex.
    Vertex(Vertex),
    /// On an edge, `(1 - t) first + t second` in the edge's own direction, 0 < t < 1.
    Edge(Edge, f64),
    /// In a face, with positive weights of its corners in the face's own order.
    Face(Face, [f64; 3]),
}

impl SurfacePoint {
    /// Locates the point and checks its weights; a point on the boundary of its element becomes a
    /// point of the smaller element.
    ///
    /// # Errors
    /// [`CurveError`] without a place (add it with [`CurveError::at`]): no such vertex, edge or
    /// face; weights that are not finite, outside [0, 1] or with a sum that differs from 1 by more
    /// than [`BARYCENTRIC_TOLERANCE`].
    pub fn locate(&self, mesh: &TriangleMesh) -> Result<Located, CurveError> {
        let check = |v: u32| {
            if (v as usize) < mesh.vertex_count() {
                Ok(Vertex(v))
            } else {
                Err(CurveError::VertexOutOfRange { vertex: v as i64, vertices: mesh.vertex_count() })
            }
        };
        match *self {
            SurfacePoint::Vertex { vertex } => Ok(Located::Vertex(check(vertex)?)),
            SurfacePoint::Edge { vertices: [a, b], t } => {
                let (va, vb) = (check(a)?, check(b)?);
                let edge = mesh.find_edge(va, vb).ok_or(CurveError::NoSuchEdge { vertices: [a, b] })?;
                if !(-BARYCENTRIC_TOLERANCE..=1.0 + BARYCENTRIC_TOLERANCE).contains(&t) {
                    return Err(CurveError::ParameterOutOfRange { t });
                }
                if t <= SNAP_TOLERANCE {
                    Ok(Located::Vertex(va))
                } else if t >= 1.0 - SNAP_TOLERANCE {
                    Ok(Located::Vertex(vb))
                } else if mesh.edge_vertices(edge)[0] == va {
                    Ok(Located::Edge(edge, t))
                } else {
                    Ok(Located::Edge(edge, 1.0 - t))
                }
            }
            SurfacePoint::Face { vertices, bary } => {
                let [a, b, c] = [check(vertices[0])?, check(vertices[1])?, check(vertices[2])?];
                let face = mesh.find_face([a, b, c]).ok_or(CurveError::NoSuchFace { vertices })?;
                let sum: f64 = bary.iter().sum();
                let fine =
                    bary.iter().all(|w| (-BARYCENTRIC_TOLERANCE..=1.0 + BARYCENTRIC_TOLERANCE).contains(w))
                        && (sum - 1.0).abs() <= 3.0 * BARYCENTRIC_TOLERANCE;
                if !fine {
                    return Err(CurveError::WeightsOutOfRange { bary });
                }
                let weight_of =
                    |v: Vertex| vertices.iter().zip(bary).find(|(u, _)| **u == v.0).map_or(0.0, |(_, w)| w);
                Ok(Located::in_face(mesh, face, mesh.face_vertices(face).map(weight_of)))
            }
        }
    }
}

impl Located {
    /// Creates the point of a face with these weights (in the face's corner order), moved to its
    /// vertex or edge if it lies on one. Slightly negative weights are set to zero, and the sum is
    /// normalised to 1.
    pub fn in_face(mesh: &TriangleMesh, face: Face, weights: [f64; 3]) -> Located {
        let mut w = weights.map(|x| if x <= SNAP_TOLERANCE { 0.0 } else { x });
        let sum: f64 = w.iter().sum();
        w = w.map(|x| x / sum);
        let vertices = mesh.face_vertices(face);
        let zeros = w.iter().filter(|x| **x == 0.0).count();
        match zeros {
            0 => Located::Face(face, w),
            1 => {
                // The edge opposite the corner with weight 0: side k + 1.
                let k = w.iter().position(|x| *x == 0.0).unwrap_or(0);
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                let edge = mesh.face_edges(face)[i];
                let t = if mesh.edge_vertices(edge)[0] == vertices[i] { w[j] } else { w[i] };
                Located::Edge(edge, t)
            }
            _ => {
                let k = (0..3).max_by(|&a, &b| w[a].total_cmp(&w[b])).unwrap_or(0);
                Located::Vertex(vertices[k])
            }
        }
    }

    /// Returns a sort key that is equal for equal points: kind of element, its index, and the bits
    /// of the weights.
    pub fn key(&self) -> (u8, u32, [u64; 3]) {
        match *self {
            Located::Vertex(v) => (0, v.0, [0; 3]),
            Located::Edge(e, t) => (1, e.0, [t.to_bits(), 0, 0]),
            Located::Face(f, w) => (2, f.0, w.map(f64::to_bits)),
        }
    }

    /// Returns the position in space.
    pub fn position(&self, mesh: &TriangleMesh) -> [f64; 3] {
        match *self {
            Located::Vertex(v) => mesh.position(v),
            Located::Edge(e, t) => {
                let [a, b] = mesh.edge_vertices(e).map(|v| mesh.position(v));
                [0, 1, 2].map(|k| (1.0 - t) * a[k] + t * b[k])
            }
            Located::Face(f, w) => {
                let p = mesh.face_positions(f);
                [0, 1, 2].map(|k| w[0] * p[0][k] + w[1] * p[1][k] + w[2] * p[2][k])
            }
        }
    }

    /// Iterates over the one, two or three vertices that span the point, with their weights.
    pub fn weights(&self, mesh: &TriangleMesh) -> impl Iterator<Item = (Vertex, f64)> + use<> {
        let (vertices, weights, count) = match *self {
            Located::Vertex(v) => ([v, v, v], [1.0, 0.0, 0.0], 1),
            Located::Edge(e, t) => {
                let [a, b] = mesh.edge_vertices(e);
                ([a, b, b], [1.0 - t, t, 0.0], 2)
            }
            Located::Face(f, w) => (mesh.face_vertices(f), w, 3),
        };
        vertices.into_iter().zip(weights).take(count)
    }

    /// Interpolates a piecewise linear function at this point.
    pub fn interpolate(&self, mesh: &TriangleMesh, values: &[f64]) -> f64 {
        self.weights(mesh).map(|(v, w)| w * values[v.index()]).sum()
    }

    /// Returns the weights of the corners of `face`, in its corner order, if the point lies in that
    /// (closed) face.
    pub fn weights_in_face(&self, mesh: &TriangleMesh, face: Face) -> Option<[f64; 3]> {
        let corners = mesh.face_vertices(face);
        let mut weights = [0.0; 3];
        for (v, w) in self.weights(mesh) {
            weights[corners.iter().position(|&c| c == v)?] += w;
        }
        if let Located::Face(own, _) = self
            && *own != face
        {
            return None; // a doubled face has the same corners, but the point lies in its own
        }
        Some(weights)
    }

    /// Returns the (closed) faces that contain the point.
    pub fn faces(&self, mesh: &TriangleMesh) -> Vec<Face> {
        match *self {
            Located::Vertex(v) => mesh.vertex_corners(v).iter().map(|c| c.face()).collect(),
            Located::Edge(e, _) => mesh.edge_halfedges(e).iter().map(|h| h.face()).collect(),
            Located::Face(f, _) => vec![f],
        }
    }

    /// Converts the point to one identified by vertices.
    pub fn to_surface_point(&self, mesh: &TriangleMesh) -> SurfacePoint {
        match *self {
            Located::Vertex(v) => v.into(),
            Located::Edge(e, t) => SurfacePoint::Edge { vertices: mesh.edge_vertices(e).map(|v| v.0), t },
            Located::Face(f, bary) => {
                SurfacePoint::Face { vertices: mesh.face_vertices(f).map(|v| v.0), bary }
            }
        }
    }
}
