//! Terms of the smoothness of a rotation (PLPF appendix B.1).
//!
//! Deviation: the printed energy squares the sum of the gradients of two faces and their jump. The
//! three may cancel, so that a rough field costs nothing: on a sphere of 596 faces 60 eigenvalues
//! vanish where one should. By default gradients and jumps are squared apart; the printed form is
//! an option, with a share of the squared rotation added.

use crate::geometry::Triangle;
use crate::polar_field::bevel::{BeveledMesh, Rotation};
use crate::polar_field::options::Smoothness;
use eikona_mesh::{Face, Halfedge};
use eikona_numeric::{Complex, Scalar};

/// Weight of squared jumps relative to squared gradients.
///
/// A larger weight makes fields more accurate far from singularities, where jumps carry part of the
/// rotation: on a disk the angle of the power is off from the harmonic one by 0.016, 0.006, 0.001
/// radians (root mean square) for weights of 1, 10, 100, and by 0.12, 0.044, 0.006 on triangles
/// four times as long as wide; refinement does not help. A smaller one leaves room for singular
/// faces next to others: with 100 and 1000, 1 and 5 of 480 random prescriptions have one that
/// can not be placed, with 10 and 30 none.
const JUMP_WEIGHT: f64 = 10.0;
/// Factor of jumps in the printed energy.
const PRINTED_JUMP_FACTOR: f64 = 50.0;

/// A term of the energy, of one or two parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Term {
    /// The gradient in a face.
    Face(Face),
    /// Mean and difference of the jumps at the ends of an edge, that of this halfedge, which has a
    /// twin.
    Edge(Halfedge),
    /// The integral of the gradient over the faces at the edge of this halfedge, its jump included.
    Flap(Halfedge),
    /// The rotation along a side.
    Side(Halfedge),
    /// The rotation at the origin of a halfedge with a twin.
    Jump(Halfedge),
}

/// Coefficients of the parts of a term on up to six corners.
pub(crate) struct Row {
    corners: [Halfedge; 6],
    count: usize,
    pub parts: [[f64; 6]; 2],
    pub weight: f64,
}

impl Row {
    fn new<const N: usize>(corners: [Halfedge; N], parts: [[f64; N]; 2], weight: f64) -> Row {
        let mut row = Row { corners: [corners[0]; 6], count: N, parts: [[0.0; 6]; 2], weight };
        row.corners[..N].copy_from_slice(&corners);
        (0..2).for_each(|part| row.parts[part][..N].copy_from_slice(&parts[part]));
        row
    }

    /// The places in the row, with their corners.
    pub fn used(&self) -> impl Iterator<Item = (usize, Halfedge)> + '_ {
        self.corners[..self.count].iter().copied().enumerate()
    }

    /// Pairs of places in the row.
    pub fn places(&self) -> impl Iterator<Item = [usize; 2]> + use<> {
        (0..self.count).flat_map(|b| (0..b).map(move |a| [a, b]))
    }

    pub fn pairs(&self) -> impl Iterator<Item = [Halfedge; 2]> + '_ {
        self.places().map(|pair| pair.map(|i| self.corners[i]))
    }
}

/// The gradient of the hat function of each side: what a rotation of one along it contributes.
fn side_gradients(triangle: &Triangle) -> [Complex; 3] {
    let directions = triangle.directions();
    let sides = [0, 1, 2].map(|k| directions[k] * triangle.lengths[k]);
    let turned = |z: Complex| Complex { re: -z.im, im: z.re };
    [0, 1, 2].map(|k| turned(sides[(k + 2) % 3] - sides[(k + 1) % 3]) * (1.0 / (6.0 * triangle.area)))
}

/// The gradients of the hat functions of the corners.
fn corner_gradients(triangle: &Triangle) -> [Complex; 3] {
    let gradients = side_gradients(triangle);
    [0, 1, 2].map(|k| gradients[(k + 2) % 3] - gradients[k])
}

fn parts<const N: usize>(values: [Complex; N]) -> [[f64; N]; 2] {
    [values.map(|z| z.re), values.map(|z| z.im)]
}

impl BeveledMesh {
    fn gradient(&self, f: Face, theta: &Rotation) -> Complex {
        let gradients = side_gradients(&self.triangles[f.index()]);
        (0..3).fold(Complex::ZERO, |sum, k| sum + gradients[k] * theta.split[f.halfedge(k)])
    }

    /// Returns the twin of a halfedge that has one.
    fn twin_of(&self, h: Halfedge) -> Halfedge {
        self.twin[h].expect("the term is on an interior edge")
    }

    /// The rotation from the layout of the halfedge's face to a frame along the edge of a flap, and
    /// the face's area.
    fn to_flap(&self, h: Halfedge, is_twin: bool) -> (Complex, f64) {
        let triangle = &self.triangles[h.face().index()];
        let along = triangle.directions()[h.side()];
        ((if is_twin { -along } else { along }).conj(), triangle.area)
    }

    /// Returns the parts of a term for a rotation.
    pub fn term(&self, term: Term, theta: &Rotation) -> [f64; 2] {
        match term {
            Term::Face(f) => {
                let gradient = self.gradient(f, theta);
                [gradient.re, gradient.im]
            }
            Term::Edge(h) => {
                let (a, b) = (theta.jump[h], theta.jump[self.twin_of(h)]);
                [0.5 * (a - b), (a + b) / 12f64.sqrt()]
            }
            Term::Flap(h) => self.flap(h, PRINTED_JUMP_FACTOR, theta),
            Term::Side(h) => [theta.split[h], 0.0],
            Term::Jump(h) => [theta.jump[h], 0.0],
        }
    }

    /// Returns the term of a flap with this factor of jumps. The flap of a boundary edge is a face.
    fn flap(&self, h: Halfedge, factor: f64, theta: &Rotation) -> [f64; 2] {
        let (gradients, jump) = self.flap_parts(h, theta);
        [gradients.re, gradients.im + factor * jump]
    }

    /// Returns the integral of the gradients of a flap, and that of its jump, which is across the
    /// edge.
    fn flap_parts(&self, h: Halfedge, theta: &Rotation) -> (Complex, f64) {
        let of_face = |h: Halfedge, is_twin: bool| {
            let (turn, area) = self.to_flap(h, is_twin);
            self.gradient(h.face(), theta) * turn * area
        };
        let own = of_face(h, false);
        let Some(twin) = self.twin[h] else { return (own, 0.0) };
        let length = self.triangles[h.face().index()].lengths[h.side()];
        (own + of_face(twin, true), 0.5 * length * (theta.jump[h] - theta.jump[twin]))
    }

    /// Returns the weight of a term.
    pub fn weight(&self, term: Term) -> f64 {
        let area = |h: Halfedge| self.triangles[h.face().index()].area;
        match term {
            Term::Face(f) => 3.0 * self.triangles[f.index()].area,
            Term::Edge(h) => {
                let length = self.triangles[h.face().index()].lengths[h.side()];
                JUMP_WEIGHT * length.powi(2) / (area(h) + area(self.twin_of(h)))
            }
            Term::Flap(h) => 1.0 / (area(h) + self.twin[h].map_or(0.0, area)),
            Term::Side(_) | Term::Jump(_) => 1.0,
        }
    }

    /// Returns a term as a function of corner values.
    pub fn row(&self, term: Term) -> Row {
        let weight = self.weight(term);
        match term {
            Term::Face(f) => {
                let corners = [0, 1, 2].map(|k| f.halfedge(k));
                Row::new(corners, parts(corner_gradients(&self.triangles[f.index()])), weight)
            }
            Term::Edge(h) => {
                let twin = self.twin_of(h);
                let third = 1.0 / 12f64.sqrt();
                let parts = [[0.5, 0.5, -0.5, -0.5], [third, -third, third, -third]];
                Row::new([h, h.next(), twin, twin.next()], parts, weight)
            }
            Term::Flap(h) => {
                let of_face = |h: Halfedge, is_twin: bool| {
                    let (turn, area) = self.to_flap(h, is_twin);
                    let gradients = corner_gradients(&self.triangles[h.face().index()]);
                    [h, h.next(), h.previous()].map(|c| gradients[c.side()] * turn * area)
                };
                let [a, b, c] = of_face(h, false);
                let Some(twin) = self.twin[h] else {
                    return Row::new([h, h.next(), h.previous()], parts([a, b, c]), weight);
                };
                let [p, q, r] = of_face(twin, true);
                let half = 0.5 * PRINTED_JUMP_FACTOR * self.triangles[h.face().index()].lengths[h.side()];
                let jump = Complex { re: 0.0, im: half };
                let corners = [h, h.next(), h.previous(), twin, twin.next(), twin.previous()];
                Row::new(corners, parts([a + jump, b + jump, c, p - jump, q - jump, r]), weight)
            }
            Term::Side(h) => Row::new([h, h.next()], [[-1.0, 1.0], [0.0; 2]], weight),
            Term::Jump(h) => {
                Row::new(BeveledMesh::jump_corners(h, self.twin_of(h)), [[-1.0, 1.0], [0.0; 2]], weight)
            }
        }
    }

    /// Iterates over the terms of an energy: those on faces, on edges, and others. Terms on faces
    /// and edges are listed for targets even where the energy does not contain them.
    pub fn terms(&self, smoothness: Smoothness) -> impl Iterator<Item = Term> + '_ {
        let edges = self.edges().map(|(h, _)| Term::Edge(h));
        let is_printed = matches!(smoothness, Smoothness::Printed { .. });
        self.mesh.faces().map(Term::Face).chain(edges).chain(self.printed_terms().filter(move |_| is_printed))
    }

    /// Flaps, and all edges of the beveled mesh.
    fn printed_terms(&self) -> impl Iterator<Item = Term> + '_ {
        let flaps = self.flaps().map(Term::Flap);
        let sides = self.halfedges().map(Term::Side);
        flaps.chain(sides).chain(self.interior().map(|(h, _)| Term::Jump(h)))
    }

    fn flaps(&self) -> impl Iterator<Item = Halfedge> + '_ {
        self.halfedges().filter(|&h| self.twin[h].is_none_or(|twin| h < twin))
    }

    /// Returns the term as [`terms`](Self::terms) lists it: by the first halfedge of its edge.
    pub fn as_listed(&self, term: Term) -> Term {
        match term {
            Term::Edge(h) => Term::Edge(self.twin[h].map_or(h, |twin| h.min(twin))),
            _ => term,
        }
    }

    /// Returns the energy of a rotation with gradients and jumps squared apart.
    pub fn energy(&self, theta: &Rotation) -> f64 {
        let of_term = |term: Term| {
            let [a, b] = self.term(term, theta);
            self.weight(term) * (a * a + b * b)
        };
        self.terms(Smoothness::Split).map(of_term).sum()
    }

    /// Returns the printed energy of a rotation, for several factors of jumps.
    pub fn printed_energies<const N: usize>(&self, theta: &Rotation, factors: [f64; N]) -> [f64; N] {
        let mut sums = [0.0; N];
        for h in self.flaps() {
            let (gradients, jump) = self.flap_parts(h, theta);
            let weight = self.weight(Term::Flap(h));
            for (sum, factor) in sums.iter_mut().zip(factors) {
                *sum += weight * (gradients.re.powi(2) + (gradients.im + factor * jump).powi(2));
            }
        }
        sums
    }
}

impl Smoothness {
    /// Returns by how much a term counts in the energy.
    pub(super) fn factor(self, term: Term) -> f64 {
        match (self, term) {
            (Smoothness::Split, Term::Face(_) | Term::Edge(_)) => 1.0,
            (Smoothness::Printed { .. }, Term::Flap(_)) => 1.0,
            (Smoothness::Printed { regularizer }, Term::Side(_) | Term::Jump(_)) => regularizer,
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::lay_out;
    use eikona_mesh::shapes::{Diagonal, grid};
    use eikona_mesh::{Topology, TriangleMesh};

    fn flat() -> (TriangleMesh, BeveledMesh) {
        let mesh = grid(6, 5, 1.2, 1.0, Diagonal::Alternating).unwrap();
        let bevel = BeveledMesh::new(&mesh, Topology::of(&mesh), lay_out(&mesh));
        (mesh, bevel)
    }

    #[test]
    fn both_energies_of_a_linear_function_are_three_times_its_dirichlet_energy() {
        let (mesh, bevel) = flat();
        let value = |h: Halfedge| {
            let [x, y, _] = mesh.position(mesh.origin(h));
            2.0 * x - 3.0 * y
        };
        let theta = bevel.differences(&bevel.halfedges().map(value).collect::<Vec<f64>>());
        let expected = 3.0 * 1.2 * 13.0;
        for found in [bevel.energy(&theta), bevel.printed_energies(&theta, [50.0])[0]] {
            assert!((found - expected).abs() < 1e-10, "{found} instead of {expected}");
        }
    }

    #[test]
    fn a_gradient_and_a_jump_cancel_in_the_printed_energy_only() {
        // A function that falls across a face by what it jumps at the edge: the integral over the
        // flap vanishes, although the function is rough.
        let (_, bevel) = flat();
        let h = bevel.edges().next().unwrap().0;
        let triangle = &bevel.triangles[h.face().index()];
        let mut x = vec![0.0; 3 * bevel.triangles.len()];
        let height = 2.0 * triangle.area / triangle.lengths[h.side()];
        // Zero at the far corner, s at the edge: gradient s / height away from the edge, times the
        // area s length / 2; the jump from 0 to s times the length is twice that.
        (x[h.index()], x[h.next().index()]) = (1.0, 1.0);
        let theta = bevel.differences(&x);
        let [re, im] = bevel.flap(h, 0.5, &theta);
        assert!(re.abs() < 1e-14 && im.abs() < 1e-14, "{re} {im}, height {height}");
        assert!(bevel.energy(&theta) > 1.0);
    }

    #[test]
    fn rows_are_the_terms_of_differences() {
        let (_, bevel) = flat();
        let x: Vec<f64> = (0..3 * bevel.triangles.len()).map(|i| (i as f64).sin()).collect();
        let theta = bevel.differences(&x);
        for term in bevel.terms(Smoothness::Printed { regularizer: 1.0 }) {
            let row = bevel.row(term);
            let expected = bevel.term(term, &theta);
            for part in 0..2 {
                let found: f64 = row.used().map(|(i, c)| row.parts[part][i] * x[c.index()]).sum();
                assert!((found - expected[part]).abs() < 1e-12, "{term:?}: {found}, {expected:?}");
            }
        }
    }
}
