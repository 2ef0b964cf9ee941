//! Intrinsic triangulations of a surface with cotangent weights: its faces, or the Delaunay
//! triangulation with the same vertices (Bobenko and Springborn 2007).

use crate::geometry::Triangle;
use eikona_mesh::{Face, Halfedge, HalfedgeField, TriangleMesh, Vertex};
use std::collections::VecDeque;

/// Bounds on half the cotangent opposite each halfedge. The Hodge star divides by sums of these
/// weights, and a Laplacian with negative sums may be indefinite. Both operators must use the same
/// weights; otherwise the derivative of a solution is not co-closed for the Hodge star.
const BOUNDS: (f64, f64) = (1e-3, 1e3);
/// Bounds on the sum of both weights of a side in a Delaunay triangulation, where it is negative at
/// most on the boundary. Deviation: there, too, the authors' program bounds each weight separately.
const BOUNDS_OF_SUM: (f64, f64) = (1e-5, 2e3);

/// Triangles glued along their sides. Halfedge `3 f + k` runs from corner `k` of triangle `f` to
/// the next. The surface is cut along edges of three or more faces.
#[derive(Clone, Debug)]
pub(crate) struct IntrinsicTriangulation {
    /// Vertices of each triangle.
    pub corners: Vec<[Vertex; 3]>,
    /// Half the cotangent opposite each halfedge, within bounds.
    pub weight: HalfedgeField<f64>,
    /// The halfedge of the other triangle at the same side; `None` at the boundary.
    glued: HalfedgeField<Option<Halfedge>>,
    /// Flips that turn the faces of the mesh into these triangles, in order, as pairs of glued
    /// halfedges.
    flips: Vec<[Halfedge; 2]>,
}

impl IntrinsicTriangulation {
    /// Returns the faces of a mesh as a triangulation.
    pub fn of_faces(mesh: &TriangleMesh, triangles: &[Triangle]) -> IntrinsicTriangulation {
        let mut glued = HalfedgeField::constant(mesh.halfedge_count(), None);
        for e in mesh.edges() {
            if let &[a, b] = mesh.edge_halfedges(e) {
                glued[a] = Some(b);
                glued[b] = Some(a);
            }
        }
        let weights = |t: &Triangle| [0, 1, 2].map(|k| bounded(0.5 * t.cotangent((k + 2) % 3), BOUNDS));
        let weight: Vec<f64> = triangles.iter().flat_map(weights).collect();
        let corners = mesh.triangles().iter().map(|face| face.map(Vertex)).collect();
        IntrinsicTriangulation { corners, weight: weight.into(), glued, flips: Vec::new() }
    }

    /// Returns the intrinsic Delaunay triangulation of the surface with the same vertices.
    ///
    /// Sides are flipped in the plane of their two unfolded triangles, until opposite angles sum to
    /// at most 180 degrees. Triangles at the vertices in `keep` are kept, as are sides across which
    /// the orientation changes and sides whose flip would connect a vertex to itself.
    ///
    /// # Cost
    /// O(1) per flip; few flips on most meshes.
    pub fn delaunay(mesh: &TriangleMesh, triangles: &[Triangle], keep: &[bool]) -> IntrinsicTriangulation {
        let mut this = IntrinsicTriangulation::of_faces(mesh, triangles);
        let mut triangles = triangles.to_vec();
        let mut waiting: VecDeque<Halfedge> = this.halfedges().collect();
        // A guard against rounding: in exact arithmetic the flips terminate.
        let mut left = 64 * this.glued.len();
        while let Some(h) = waiting.pop_front() {
            if left == 0 {
                break;
            }
            let Some(quad) = this.quad_to_flip(&triangles, h, keep) else { continue };
            left -= 1;
            let Quad { a, b, diagonal } = quad;
            // Lengths around the side, in the order in which the flip moves them.
            let length = |h: Halfedge| triangles[h.face().index()].lengths[h.side()];
            let sides = [a.next(), a.previous(), b.next(), b.previous()].map(length);
            this.flip(a, b);
            for (first, lengths) in [(a, [diagonal, sides[1], sides[2]]), (b, [diagonal, sides[3], sides[0]])]
            {
                let mut of_face = [0.0; 3];
                (0..3).for_each(|i| of_face[(first.side() + i) % 3] = lengths[i]);
                triangles[first.face().index()] = Triangle::from_lengths(of_face);
            }
            this.flips.push([a, b]);
            waiting.extend([a.next(), a.previous(), b.next(), b.previous()]);
        }
        let half_cotangent = |h: Halfedge| 0.5 * triangles[h.face().index()].cotangent((h.side() + 2) % 3);
        let weight = |h: Halfedge| match this.other(h) {
            Some((other, _)) => 0.5 * bounded(half_cotangent(h) + half_cotangent(other), BOUNDS_OF_SUM),
            None => bounded(half_cotangent(h), BOUNDS_OF_SUM),
        };
        let weight: Vec<f64> = this.halfedges().map(weight).collect();
        IntrinsicTriangulation { weight: weight.into(), ..this }
    }

    /// Iterates over all halfedges.
    pub fn halfedges(&self) -> impl Iterator<Item = Halfedge> + use<> {
        (0..self.glued.len() as u32).map(Halfedge)
    }

    /// Returns the halfedge of the other triangle at the same side, and whether it runs in the same
    /// direction.
    #[inline]
    pub fn other(&self, h: Halfedge) -> Option<(Halfedge, bool)> {
        self.glued[h].map(|other| (other, self.origin(h) == self.origin(other)))
    }

    /// Returns the vertex at which a halfedge starts.
    #[inline]
    pub fn origin(&self, h: Halfedge) -> Vertex {
        self.corners[h.face().index()][h.side()]
    }

    /// Returns the vertex at which a halfedge ends.
    #[inline]
    pub fn tip(&self, h: Halfedge) -> Vertex {
        self.origin(h.next())
    }

    /// Returns the Hodge star of a side: the sum of the weights of its halfedges.
    pub fn star(&self, h: Halfedge) -> f64 {
        self.weight[h] + self.other(h).map_or(0.0, |(other, _)| self.weight[other])
    }

    /// Returns the 1-form with this value at the first halfedge of each side. Both halfedges of a
    /// side get exactly the same magnitude.
    pub fn form(&self, value: impl Fn(Halfedge) -> f64) -> Vec<f64> {
        let mut form = vec![0.0; self.glued.len()];
        for h in self.halfedges() {
            form[h.index()] = match self.other(h) {
                Some((other, true)) if other < h => form[other.index()],
                Some((other, false)) if other < h => -form[other.index()],
                _ => value(h),
            };
        }
        form
    }

    /// Transfers a 1-form from the faces of the mesh to these triangles. The form must be closed in
    /// all flipped triangles.
    pub fn form_from_mesh(&self, form: &mut [f64]) {
        for &[a, b] in &self.flips {
            let across = form[b.previous().index()] + form[a.next().index()];
            turn_quad(form, a, b);
            form[a.index()] = across;
            form[b.index()] = -across;
        }
    }

    /// Inverts [`form_from_mesh`](Self::form_from_mesh).
    pub fn form_to_mesh(&self, form: &mut [f64]) {
        for &[a, b] in self.flips.iter().rev() {
            turn_quad_back(form, a, b);
            let across = -(form[a.next().index()] + form[a.previous().index()]);
            form[a.index()] = across;
            form[b.index()] = -across;
        }
    }

    /// Returns the quad around a side if the side must be flipped.
    fn quad_to_flip(&self, triangles: &[Triangle], a: Halfedge, keep: &[bool]) -> Option<Quad> {
        let (b, same_direction) = self.other(a)?;
        let [i, j, k, l] =
            [self.origin(a), self.tip(a), self.origin(a.previous()), self.origin(b.previous())];
        let kept = [i, j, k, l].iter().any(|v| keep[v.index()]);
        if same_direction || a.face() == b.face() || k == l || kept {
            return None;
        }
        let triangle = |h: Halfedge| &triangles[h.face().index()];
        let cotangent = |h: Halfedge| triangle(h).cotangent((h.side() + 2) % 3);
        let (at_k, at_l) = (cotangent(a), cotangent(b));
        let is_delaunay = at_k + at_l >= -1e-9 * (1.0 + at_k.abs() + at_l.abs());
        if is_delaunay || at_k.is_nan() || at_l.is_nan() {
            return None;
        }
        // Both triangles unfolded around their common corner i.
        let angle = |h: Halfedge| triangle(h).angles[h.side()];
        let at_i = angle(a) * angle(b.next());
        if at_i.im <= 0.0 {
            return None;
        }
        let length = |h: Halfedge| triangle(h).lengths[h.side()];
        let (to_k, to_l) = (length(a.previous()), length(b.next()));
        let square = (to_k - to_l).powi(2) + 2.0 * to_k * to_l * (1.0 - at_i.re);
        let diagonal = square.sqrt();
        (diagonal > 0.0 && diagonal.is_finite()).then_some(Quad { a, b, diagonal })
    }

    /// Flips the side of two halfedges: triangles `i j k` and `j i l` become `l k i` and `k l j`.
    fn flip(&mut self, a: Halfedge, b: Halfedge) {
        let [k, l] = [a.previous(), b.previous()].map(|h| self.origin(h));
        let [i, j] = [a, b].map(|h| self.origin(h));
        for (first, corners) in [(a, [l, k, i]), (b, [k, l, j])] {
            let face: Face = first.face();
            (0..3).for_each(|n| self.corners[face.index()][(first.side() + n) % 3] = corners[n]);
        }
        turn_quad(self.glued.as_mut_slice(), a, b);
        let moved = [
            (a.previous(), a.next()),
            (b.next(), a.previous()),
            (b.previous(), b.next()),
            (a.next(), b.previous()),
        ];
        let now = |h: Halfedge| moved.iter().find(|m| m.0 == h).map_or(h, |m| m.1);
        // Sides of the quad may be glued to each other, so all are renamed before any is linked.
        for (_, place) in moved {
            self.glued[place] = self.glued[place].map(now);
        }
        for (_, place) in moved {
            if let Some(other) = self.glued[place] {
                self.glued[other] = Some(place);
            }
        }
    }
}

/// The two halfedges of a side, and the length of the other diagonal of its quad.
struct Quad {
    a: Halfedge,
    b: Halfedge,
    diagonal: f64,
}

fn bounded(weight: f64, (low, high): (f64, f64)) -> f64 {
    if weight.is_nan() { 1.0 } else { weight.clamp(low, high) }
}

/// Permutes the values at the four outer sides when the diagonal flips.
fn turn_quad<T: Copy>(values: &mut [T], a: Halfedge, b: Halfedge) {
    let [a1, a2, b1, b2] = [a.next(), a.previous(), b.next(), b.previous()].map(|h| h.index());
    let first = values[a1];
    values[a1] = values[a2];
    values[a2] = values[b1];
    values[b1] = values[b2];
    values[b2] = first;
}

/// Inverts [`turn_quad`].
fn turn_quad_back<T: Copy>(values: &mut [T], a: Halfedge, b: Halfedge) {
    let [a1, a2, b1, b2] = [a.next(), a.previous(), b.next(), b.previous()].map(|h| h.index());
    let last = values[b2];
    values[b2] = values[b1];
    values[b1] = values[a2];
    values[a2] = values[a1];
    values[a1] = last;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::lay_out;
    use eikona_mesh::{damage, shapes};

    fn jittered_torus() -> TriangleMesh {
        damage::jitter(&shapes::torus(1.0, 0.4, 24, 12).unwrap(), 0.45, 7).unwrap()
    }

    #[test]
    fn flips_give_delaunay_triangles() {
        let mesh = jittered_torus();
        let triangles = lay_out(&mesh);
        let keep = vec![false; mesh.vertex_count()];
        let delaunay = IntrinsicTriangulation::delaunay(&mesh, &triangles, &keep);
        assert!(delaunay.flips.len() > 50, "{}", delaunay.flips.len());
        for h in delaunay.halfedges() {
            let (other, same_way) = delaunay.other(h).unwrap();
            assert!(!same_way && delaunay.other(other).unwrap().0 == h);
            assert_eq!(delaunay.tip(h), delaunay.origin(other));
        }
        let lowest = delaunay.halfedges().map(|h| delaunay.star(h)).fold(f64::INFINITY, f64::min);
        assert!(lowest >= BOUNDS_OF_SUM.0);
    }

    #[test]
    fn weights_on_delaunay_triangles_are_cotangents() {
        // A flat disk of long, thin faces that spiral outwards. If no weight is clamped, the energy
        // of a coordinate is the area.
        let (rings, around, twist) = (12u32, 72u32, 3u32);
        let number = |k: u32, j: u32| 1 + (k - 1) * around + j % around;
        let mut positions = vec![[0.0; 3]];
        for (k, j) in (1..=rings).flat_map(|k| (0..around).map(move |j| (k, j))) {
            let (r, a) =
                (f64::from(k) / f64::from(rings), std::f64::consts::TAU * f64::from(j) / f64::from(around));
            positions.push([r * a.cos(), r * a.sin(), 0.0]);
        }
        let mut faces = Vec::new();
        for j in 0..around {
            faces.push([0, number(1, j), number(1, j + 1)]);
            for k in 1..rings {
                let (c, d) = (number(k + 1, j + twist), number(k + 1, j + twist + 1));
                faces.extend([[number(k, j), c, d], [number(k, j), d, number(k, j + 1)]]);
            }
        }
        let disk = TriangleMesh::new(positions, faces).unwrap();
        let triangles = lay_out(&disk);
        let area: f64 = triangles.iter().map(|t| t.area).sum();
        let energy = |t: &IntrinsicTriangulation, axis: usize| -> f64 {
            let x = |v: Vertex| disk.position(v)[axis];
            let once = t.halfedges().filter(|&h| t.other(h).is_none_or(|(other, _)| h < other));
            once.map(|h| t.star(h) * (x(t.tip(h)) - x(t.origin(h))).powi(2)).sum()
        };
        let delaunay = IntrinsicTriangulation::delaunay(&disk, &triangles, &vec![false; disk.vertex_count()]);
        for axis in 0..2 {
            // Quads with concyclic corners have a diagonal of weight 0, which is raised to the
            // lower bound.
            let star = |h: Halfedge| delaunay.star(h);
            let diagonals = delaunay.halfedges().filter(|&h| star(h) <= BOUNDS_OF_SUM.0).count();
            let raised = 0.5 * diagonals as f64 * BOUNDS_OF_SUM.0 * 0.2f64.powi(2);
            let off = energy(&delaunay, axis) - area;
            assert!(off.abs() <= 1e-9 + raised && raised < 1e-3 * area, "{off} {raised}");
            assert!(
                energy(&IntrinsicTriangulation::of_faces(&disk, &triangles), axis) > 1.1 * area,
                "weights are clamped on the faces"
            );
        }
    }

    #[test]
    fn closed_forms_survive_the_round_trip() {
        let mesh = jittered_torus();
        let triangles = lay_out(&mesh);
        let mut keep = vec![false; mesh.vertex_count()];
        keep[5] = true;
        let delaunay = IntrinsicTriangulation::delaunay(&mesh, &triangles, &keep);
        assert!(
            delaunay
                .corners
                .iter()
                .zip(mesh.triangles())
                .all(|(now, then)| !then.contains(&5) || now.map(|v| v.0) == *then)
        );
        // The derivative of a function; its values at new sides are known.
        let height = |v: Vertex| mesh.position(v)[2];
        let plain = IntrinsicTriangulation::of_faces(&mesh, &triangles);
        let derivative = |t: &IntrinsicTriangulation| -> Vec<f64> {
            t.halfedges().map(|h| height(t.tip(h)) - height(t.origin(h))).collect()
        };
        let (form, expected) = (derivative(&plain), derivative(&delaunay));
        let mut carried = form.clone();
        delaunay.form_from_mesh(&mut carried);
        assert!(carried.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-12));
        delaunay.form_to_mesh(&mut carried);
        assert!(carried.iter().zip(&form).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}
