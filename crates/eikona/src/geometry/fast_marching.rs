//! Fast marching: unsigned distance along a surface from seed vertices.

use super::Triangle;
use super::triangle::power_of_two_near;
use eikona_mesh::{TriangleMesh, Vertex};
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// Computes the first-order distance at every vertex from seeds with given starting values;
/// infinite where no seed reaches.
///
/// Each vertex is settled once, in order of distance. Its value comes from the front edges of its
/// faces (Kimmel and Sethian 1998), or from a mesh edge where the front comes from outside the
/// face.
///
/// # Cost
/// O(V log V).
pub fn fast_marching(mesh: &TriangleMesh, triangles: &[Triangle], seeds: &[(Vertex, f64)]) -> Vec<f64> {
    let mut distance = vec![f64::INFINITY; mesh.vertex_count()];
    let mut settled = vec![false; mesh.vertex_count()];
    let mut heap = BinaryHeap::new();
    for &(v, d) in seeds {
        if d < distance[v.index()] {
            distance[v.index()] = d;
            heap.push(Reverse(Front { distance: d, vertex: v.0 }));
        }
    }
    while let Some(Reverse(Front { distance: d, vertex })) = heap.pop() {
        let v = vertex as usize;
        if settled[v] || d > distance[v] {
            continue;
        }
        settled[v] = true;
        for &corner in mesh.vertex_corners(Vertex(vertex)) {
            let (face, k) = (corner.face(), corner.halfedge().side());
            let t = &triangles[face.index()];
            let corners = mesh.triangles()[face.index()];
            for (i, other) in [((k + 1) % 3, (k + 2) % 3), ((k + 2) % 3, (k + 1) % 3)] {
                // Corner i is updated from the settled vertex and from the other corner, if that is
                // settled.
                let u = corners[i] as usize;
                if settled[u] {
                    continue;
                }
                let side = |a: usize, b: usize| if (a + 1) % 3 == b { t.lengths[a] } else { t.lengths[b] };
                let mut candidate = d + side(k, i);
                let w = corners[other] as usize;
                if settled[w]
                    && let Some(plane) =
                        plane_front(d, distance[w], side(i, k), side(i, other), t.angles[i].re)
                {
                    candidate = candidate.min(plane);
                }
                if candidate < distance[u] {
                    distance[u] = candidate;
                    heap.push(Reverse(Front { distance: candidate, vertex: u as u32 }));
                }
            }
        }
    }
    distance
}

/// Returns the arrival time, at the corner between sides `a` and `b` (with angle cosine `cos`), of
/// the planar front that reaches their other ends at `da` and `db`; `None` if the front does not
/// come through the triangle.
fn plane_front(da: f64, db: f64, a: f64, b: f64, cos: f64) -> Option<f64> {
    // Scaled, since products of four lengths follow.
    let unit = power_of_two_near(a.max(b));
    let [da, db, a, b] = [da, db, a, b].map(|x| x / unit);
    // Gradient g with |g| = 1, g.A = d - da, g.B = d - db for the vectors A, B from the ends to the
    // corner.
    let gram = [a * a, a * b * cos, b * b];
    let det = gram[0] * gram[2] - gram[1] * gram[1];
    if det <= 0.0 {
        return None;
    }
    let inverse = [gram[2] / det, -gram[1] / det, gram[0] / det];
    let quad = |x: [f64; 2], y: [f64; 2]| {
        x[0] * (inverse[0] * y[0] + inverse[1] * y[1]) + x[1] * (inverse[1] * y[0] + inverse[2] * y[1])
    };
    let (ones, values) = ([1.0, 1.0], [da, db]);
    let (p, q, r) = (quad(ones, ones), quad(ones, values), quad(values, values) - 1.0);
    let discriminant = q * q - p * r;
    if discriminant < 0.0 {
        return None;
    }
    let d = (q + discriminant.sqrt()) / p;
    let rise = [d - da, d - db];
    // g is a combination of A and B with these coefficients; it must point out of the cone between
    // them.
    let coefficients =
        [inverse[0] * rise[0] + inverse[1] * rise[1], inverse[1] * rise[0] + inverse[2] * rise[1]];
    (coefficients[0] >= 0.0 && coefficients[1] >= 0.0).then_some(d * unit)
}

/// Queued vertex; ties go to the smaller index.
struct Front {
    distance: f64,
    vertex: u32,
}

impl Ord for Front {
    fn cmp(&self, other: &Self) -> Ordering {
        self.distance.total_cmp(&other.distance).then(self.vertex.cmp(&other.vertex))
    }
}
impl PartialOrd for Front {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Front {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Front {}
