//! Triangles with their weights: those of the mesh, or Delaunay triangles on the same surface.

use crate::geometry::Triangle;
use eikona_mesh::TriangleMesh;
use std::collections::VecDeque;

/// No halfedge: a side where the surface ends, or where three or more faces meet (it is cut open
/// there).
const NONE: u32 = u32::MAX;

/// Half the cotangent opposite each halfedge, kept between these bounds. The Hodge step divides by
/// sums of them, and a Laplacian with negative sums need not be definite. Both operators must have
/// the same weights: otherwise the derivative of the first solve is not co-closed in the second.
const BOUNDS: (f64, f64) = (1e-3, 1e3);
/// The same for the sum of a side's two halfedges on Delaunay triangles, where it is negative on
/// the boundary at most: less is changed. Deviation: the public program bounds each by itself
/// there, too.
const BOUNDS_OF_SUM: (f64, f64) = (1e-5, 2e3);

/// Triangles glued along their sides. Halfedge `3 f + k` runs from corner `k` of triangle `f` to
/// the next.
#[derive(Clone, Debug)]
pub(crate) struct Triangulation {
    /// The vertices of each triangle.
    pub corners: Vec<[u32; 3]>,
    /// The halfedge of the other triangle at the same side.
    glued: Vec<u32>,
    /// Weight of each halfedge.
    pub weight: Vec<f64>,
    /// What turned the triangles of the mesh into these, in order: pairs of glued halfedges.
    flips: Vec<[u32; 2]>,
}

impl Triangulation {
    /// The faces of a mesh.
    pub fn of(mesh: &TriangleMesh, triangles: &[Triangle]) -> Triangulation {
        let mut glued = vec![NONE; mesh.halfedge_count()];
        for e in mesh.edges() {
            if let &[a, b] = mesh.edge_halfedges(e) {
                glued[a.index()] = b.index() as u32;
                glued[b.index()] = a.index() as u32;
            }
        }
        let weights = |t: &Triangle| [0, 1, 2].map(|k| bounded(0.5 * t.cotangent((k + 2) % 3), BOUNDS));
        let weight = triangles.iter().flat_map(weights).collect();
        Triangulation { corners: mesh.triangles().to_vec(), glued, weight, flips: Vec::new() }
    }

    /// The intrinsic Delaunay triangulation of the surface with the same vertices: sides are
    /// flipped, in the plane into which both their triangles unfold, until no opposite angles add
    /// up to more than 180 degrees. Triangles at the vertices to be kept stay, sides across which
    /// the winding turns over, and those whose flip would join a vertex to itself.
    ///
    /// # Cost
    /// O(1) a flip, and as a rule few flips.
    pub fn delaunay(mesh: &TriangleMesh, triangles: &[Triangle], keep: &[bool]) -> Triangulation {
        let mut this = Triangulation::of(mesh, triangles);
        let mut triangles = triangles.to_vec();
        let mut waiting: VecDeque<u32> = (0..this.glued.len() as u32).collect();
        // Flips end by themselves, but for rounding.
        let mut left = 64 * this.glued.len();
        while let Some(h) = waiting.pop_front() {
            if left == 0 {
                break;
            }
            let Some(quad) = this.quad_to_flip(&triangles, h as usize, keep) else { continue };
            left -= 1;
            let [a, b] = [quad.a, quad.b];
            // Lengths around the side, in the order in which the flip moves them.
            let length = |h: usize| triangles[h / 3].lengths[h % 3];
            let sides = [next(a), previous(a), next(b), previous(b)].map(length);
            this.flip(a, b);
            for (first, lengths) in
                [(a, [quad.diagonal, sides[1], sides[2]]), (b, [quad.diagonal, sides[3], sides[0]])]
            {
                let mut of_face = [0.0; 3];
                (0..3).for_each(|i| of_face[(first + i) % 3] = lengths[i]);
                triangles[first / 3] = Triangle::from_lengths(of_face);
            }
            this.flips.push([a as u32, b as u32]);
            waiting.extend([next(a), previous(a), next(b), previous(b)].map(|h| h as u32));
        }
        let half_cotangent = |h: usize| 0.5 * triangles[h / 3].cotangent((h + 2) % 3);
        this.weight = (0..this.glued.len())
            .map(|h| match this.other(h) {
                Some((other, _)) => 0.5 * bounded(half_cotangent(h) + half_cotangent(other), BOUNDS_OF_SUM),
                None => bounded(half_cotangent(h), BOUNDS_OF_SUM),
            })
            .collect();
        this
    }

    /// The halfedge of the other triangle at the same side, and whether it runs the same way.
    #[inline]
    pub fn other(&self, h: usize) -> Option<(usize, bool)> {
        let other = self.glued[h];
        (other != NONE).then(|| (other as usize, self.origin(h) == self.origin(other as usize)))
    }

    #[inline]
    pub fn origin(&self, h: usize) -> u32 {
        self.corners[h / 3][h % 3]
    }

    #[inline]
    pub fn tip(&self, h: usize) -> u32 {
        self.origin(next(h))
    }

    /// The Hodge star of a side: the sum of the weights of its halfedges.
    pub fn star(&self, h: usize) -> f64 {
        self.weight[h] + self.other(h).map_or(0.0, |(other, _)| self.weight[other])
    }

    /// A form along halfedges, from its values at one halfedge of each side, so that both triangles
    /// get the same digits.
    pub fn form(&self, value: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut form = vec![0.0; self.weight.len()];
        for h in 0..form.len() {
            form[h] = match self.other(h) {
                Some((other, true)) if other < h => form[other],
                Some((other, false)) if other < h => -form[other],
                _ => value(h),
            };
        }
        form
    }

    /// Carries a form along halfedges, closed in all triangles that were flipped, from the mesh to
    /// these triangles.
    pub fn form_from_mesh(&self, form: &mut [f64]) {
        for &[a, b] in &self.flips {
            let (a, b) = (a as usize, b as usize);
            let across = form[previous(b)] + form[next(a)];
            turn_quad(form, a, b);
            form[a] = across;
            form[b] = -across;
        }
    }

    /// The way back of [`form_from_mesh`](Self::form_from_mesh).
    pub fn form_to_mesh(&self, form: &mut [f64]) {
        for &[a, b] in self.flips.iter().rev() {
            let (a, b) = (a as usize, b as usize);
            turn_quad_back(form, a, b);
            let across = -(form[next(a)] + form[previous(a)]);
            form[a] = across;
            form[b] = -across;
        }
    }

    /// The quad around a side that is to be flipped.
    fn quad_to_flip(&self, triangles: &[Triangle], a: usize, keep: &[bool]) -> Option<Quad> {
        let (b, same_way) = self.other(a)?;
        let [i, j, k, l] = [self.origin(a), self.tip(a), self.origin(previous(a)), self.origin(previous(b))];
        if same_way || a / 3 == b / 3 || k == l || [i, j, k, l].iter().any(|&v| keep[v as usize]) {
            return None;
        }
        let cotangent = |h: usize| triangles[h / 3].cotangent((h + 2) % 3);
        let (at_k, at_l) = (cotangent(a), cotangent(b));
        let is_delaunay = at_k + at_l >= -1e-9 * (1.0 + at_k.abs() + at_l.abs());
        if is_delaunay || at_k.is_nan() || at_l.is_nan() {
            return None;
        }
        // Both triangles unfolded around their common corner i.
        let angle = |h: usize| triangles[h / 3].angles[h % 3];
        let at_i = angle(a) * angle(next(b));
        if at_i.im <= 0.0 {
            return None;
        }
        let (to_k, to_l) = (triangles[a / 3].lengths[previous(a) % 3], triangles[b / 3].lengths[next(b) % 3]);
        let square = (to_k - to_l).powi(2) + 2.0 * to_k * to_l * (1.0 - at_i.re);
        let diagonal = square.sqrt();
        (diagonal > 0.0 && diagonal.is_finite()).then_some(Quad { a, b, diagonal })
    }

    /// Flips the side of two halfedges: triangles `i j k` and `j i l` become `l k i` and `k l j`.
    fn flip(&mut self, a: usize, b: usize) {
        let [k, l] = [previous(a), previous(b)].map(|h| self.origin(h));
        let [i, j] = [a, b].map(|h| self.origin(h));
        for (first, corners) in [(a, [l, k, i]), (b, [k, l, j])] {
            (0..3).for_each(|n| self.corners[first / 3][(first + n) % 3] = corners[n]);
        }
        turn_quad(&mut self.glued, a, b);
        let moved =
            [(previous(a), next(a)), (next(b), previous(a)), (previous(b), next(b)), (next(a), previous(b))];
        let now = |h: u32| moved.iter().find(|m| m.0 == h as usize).map_or(h, |m| m.1 as u32);
        // Sides of the quad may be glued to each other: all are told first where the others went.
        for (_, place) in moved {
            self.glued[place] = now(self.glued[place]);
        }
        for (_, place) in moved {
            let other = self.glued[place];
            if other != NONE {
                self.glued[other as usize] = place as u32;
            }
        }
    }
}

/// A side with its halfedges, and the length of the other diagonal of its quad.
struct Quad {
    a: usize,
    b: usize,
    diagonal: f64,
}

fn bounded(weight: f64, (low, high): (f64, f64)) -> f64 {
    if weight.is_nan() { 1.0 } else { weight.clamp(low, high) }
}

#[inline]
pub(crate) fn next(h: usize) -> usize {
    if h % 3 == 2 { h - 2 } else { h + 1 }
}

#[inline]
fn previous(h: usize) -> usize {
    if h.is_multiple_of(3) { h + 2 } else { h - 1 }
}

/// Values at the four outer sides move on as the diagonal turns.
fn turn_quad<T: Copy>(values: &mut [T], a: usize, b: usize) {
    let [a1, a2, b1, b2] = [next(a), previous(a), next(b), previous(b)];
    let first = values[a1];
    values[a1] = values[a2];
    values[a2] = values[b1];
    values[b1] = values[b2];
    values[b2] = first;
}

fn turn_quad_back<T: Copy>(values: &mut [T], a: usize, b: usize) {
    let [a1, a2, b1, b2] = [next(a), previous(a), next(b), previous(b)];
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

    fn disturbed() -> TriangleMesh {
        damage::jitter(&shapes::torus(1.0, 0.4, 24, 12).unwrap(), 0.45, 7).unwrap()
    }

    #[test]
    fn flips_end_with_delaunay_triangles() {
        let mesh = disturbed();
        let triangles = lay_out(&mesh);
        let keep = vec![false; mesh.vertex_count()];
        let delaunay = Triangulation::delaunay(&mesh, &triangles, &keep);
        assert!(delaunay.flips.len() > 50, "{}", delaunay.flips.len());
        for h in 0..delaunay.glued.len() {
            let (other, same_way) = delaunay.other(h).unwrap();
            assert!(!same_way && delaunay.other(other).unwrap().0 == h);
            assert_eq!(delaunay.tip(h), delaunay.origin(other));
        }
        let lowest = (0..delaunay.glued.len()).map(|h| delaunay.star(h)).fold(f64::INFINITY, f64::min);
        assert!(lowest >= BOUNDS_OF_SUM.0);
    }

    #[test]
    fn weights_on_delaunay_triangles_are_cotangents() {
        // A flat disk of long, thin faces that wind outwards. The energy of a coordinate is the
        // area, if no weight is bounded.
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
        let energy = |t: &Triangulation, axis: usize| -> f64 {
            let x = |v: u32| disk.positions()[v as usize][axis];
            let once = (0..t.glued.len()).filter(|&h| t.other(h).is_none_or(|(other, _)| h < other));
            once.map(|h| t.star(h) * (x(t.tip(h)) - x(t.origin(h))).powi(2)).sum()
        };
        let delaunay = Triangulation::delaunay(&disk, &triangles, &vec![false; disk.vertex_count()]);
        for axis in 0..2 {
            // Quads with all corners on a circle have a diagonal of weight 0, which is raised to
            // the lowest.
            let star = |h: usize| delaunay.star(h);
            let diagonals = (0..delaunay.glued.len()).filter(|&h| star(h) <= BOUNDS_OF_SUM.0).count();
            let raised = 0.5 * diagonals as f64 * BOUNDS_OF_SUM.0 * 0.2f64.powi(2);
            let off = energy(&delaunay, axis) - area;
            assert!(off.abs() <= 1e-9 + raised && raised < 1e-3 * area, "{off} {raised}");
            assert!(energy(&Triangulation::of(&disk, &triangles), axis) > 1.1 * area, "bounded on the faces");
        }
    }

    #[test]
    fn closed_forms_survive_the_way_there_and_back() {
        let mesh = disturbed();
        let triangles = lay_out(&mesh);
        let mut keep = vec![false; mesh.vertex_count()];
        keep[5] = true;
        let delaunay = Triangulation::delaunay(&mesh, &triangles, &keep);
        assert!(
            delaunay
                .corners
                .iter()
                .zip(mesh.triangles())
                .all(|(now, then)| !then.contains(&5) || now == then)
        );
        // The derivative of a function, whose values at new sides are known.
        let height = |v: u32| mesh.positions()[v as usize][2];
        let plain = Triangulation::of(&mesh, &triangles);
        let derivative = |t: &Triangulation| -> Vec<f64> {
            (0..t.glued.len()).map(|h| height(t.tip(h)) - height(t.origin(h))).collect()
        };
        let (form, expected) = (derivative(&plain), derivative(&delaunay));
        let mut carried = form.clone();
        delaunay.form_from_mesh(&mut carried);
        assert!(carried.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-12));
        delaunay.form_to_mesh(&mut carried);
        assert!(carried.iter().zip(&form).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}
