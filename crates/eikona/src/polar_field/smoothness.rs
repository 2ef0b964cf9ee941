//! The smoothness of a rotation (PLPF appendix B.1), and its minimisation over functions on
//! corners.
//!
//! Deviation: the printed energy squares the sum of the gradients of two faces and their jump. The
//! three may cancel, so that a rough field costs nothing: on a sphere of 596 faces 60 eigenvalues
//! vanish where one should. Here gradients and jumps are squared apart.

use crate::geometry::Triangle;
use crate::polar_field::bevel::{BeveledMesh, Cycle, Rotation};
use crate::polar_field::powers::{face_graph, face_order};
use crate::polar_field::responses::{Condition, HalfSolutions, Responses};
use eikona_mesh::{Face, Halfedge};
use eikona_numeric::{
    Cholesky, Complex, Graph, NumericError, Ordering, Resources, Scalar, Symbolic, SymmetricMatrix,
    check_step,
};
use std::collections::HashMap;

/// Weight of squared jumps relative to squared gradients. Fields are almost the same from 1 to
/// 1000.
const JUMP_WEIGHT: f64 = 10.0;

/// Two terms of the energy: the gradient in a face, or mean and difference of the jumps at the ends
/// of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Term {
    Face(Face),
    /// The edge of this halfedge, which has a twin.
    Edge(Halfedge),
}

/// Coefficients of both parts of a term on up to four corners.
pub(crate) struct Row {
    pub corners: [Halfedge; 4],
    pub parts: [[f64; 4]; 2],
    pub weight: f64,
}

impl Row {
    /// The places in the row, with their corners. A row on a face has three.
    fn used(&self) -> impl Iterator<Item = (usize, Halfedge)> + '_ {
        let count = if self.corners[2] == self.corners[3] { 3 } else { 4 };
        (0..count).map(|i| (i, self.corners[i]))
    }

    /// Pairs of places in the row.
    fn places(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        self.used().flat_map(|(b, _)| (0..b).map(move |a| [a, b]))
    }

    fn pairs(&self) -> impl Iterator<Item = [Halfedge; 2]> + '_ {
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

impl BeveledMesh {
    /// Returns both parts of a term for a rotation.
    pub fn term(&self, term: Term, theta: &Rotation) -> [f64; 2] {
        match term {
            Term::Face(f) => {
                let gradients = side_gradients(&self.triangles[f.index()]);
                let sum =
                    (0..3).fold(Complex::ZERO, |sum, k| sum + gradients[k] * theta.split[f.halfedge(k)]);
                [sum.re, sum.im]
            }
            Term::Edge(h) => {
                let twin = self.twin[h].expect("terms are on interior edges");
                let (a, b) = (theta.jump[h], theta.jump[twin]);
                [0.5 * (a - b), (a + b) / 12f64.sqrt()]
            }
        }
    }

    /// Returns the weight of a term.
    pub fn weight(&self, term: Term) -> f64 {
        match term {
            Term::Face(f) => 3.0 * self.triangles[f.index()].area,
            Term::Edge(h) => {
                let twin = self.twin[h].expect("terms are on interior edges");
                let [t, other] = [h, twin].map(|h| &self.triangles[h.face().index()]);
                JUMP_WEIGHT * t.lengths[h.side()].powi(2) / (t.area + other.area)
            }
        }
    }

    /// Returns a term as a function of corner values.
    pub fn row(&self, term: Term) -> Row {
        let weight = self.weight(term);
        match term {
            Term::Face(f) => {
                let gradients = side_gradients(&self.triangles[f.index()]);
                let at = |k: usize| gradients[(k + 2) % 3] - gradients[k];
                let [a, b, c] = [0, 1, 2].map(at);
                let corners = [0, 1, 2, 2].map(|k| f.halfedge(k));
                Row { corners, parts: [[a.re, b.re, c.re, 0.0], [a.im, b.im, c.im, 0.0]], weight }
            }
            Term::Edge(h) => {
                let twin = self.twin[h].expect("terms are on interior edges");
                let third = 1.0 / 12f64.sqrt();
                Row {
                    corners: [h, h.next(), twin, twin.next()],
                    parts: [[0.5, 0.5, -0.5, -0.5], [third, -third, third, -third]],
                    weight,
                }
            }
        }
    }

    /// Iterates over all terms.
    pub fn terms(&self) -> impl Iterator<Item = Term> + '_ {
        let edges = self.edges().map(|(h, _)| Term::Edge(h));
        self.mesh.faces().map(Term::Face).chain(edges)
    }

    /// Returns the term as [`terms`](Self::terms) lists it: by the first halfedge of its edge.
    fn as_listed(&self, term: Term) -> Term {
        match term {
            Term::Face(_) => term,
            Term::Edge(h) => Term::Edge(self.twin[h].map_or(h, |twin| h.min(twin))),
        }
    }

    /// Returns the energy of a rotation.
    pub fn energy(&self, theta: &Rotation) -> f64 {
        let of_term = |term: Term| {
            let [a, b] = self.term(term, theta);
            self.weight(term) * (a * a + b * b)
        };
        self.terms().map(of_term).sum()
    }
}

/// The Hessian of the energy as a function on corners, factored. It serves every prescription, and
/// the scales too.
#[derive(Debug)]
pub(crate) struct CornerLaplacian {
    pub factor: Cholesky<f64>,
    pub halves: HalfSolutions,
    resources: Resources,
}

impl CornerLaplacian {
    pub fn new(bevel: &BeveledMesh, resources: Resources) -> Result<CornerLaplacian, NumericError> {
        let mut graph = Graph { unknowns: bevel.mesh.halfedge_count(), pairs: Vec::new() };
        for (i, term) in bevel.terms().enumerate() {
            check_step(i)?;
            bevel.row(term).pairs().for_each(|pair| graph.pairs.push(pair.map(|c| c.0)));
        }
        let order = corner_order(bevel)?;
        let symbolic = Symbolic::new(&graph, Ordering::Given(&order))?;
        let factor = Cholesky::within(resources, symbolic.into(), &hessian(bevel, |_| 1.0, |_| true)?)?;
        Ok(CornerLaplacian { factor, halves: HalfSolutions::default(), resources })
    }

    /// Returns the responses between no corners.
    pub fn responses(&self) -> Responses<'_> {
        Responses::new(&self.factor, &self.halves)
    }
}

/// Assembles the Hessian, with each term weighted by a factor. On grounded components, the function
/// is drawn to zero at one corner.
fn hessian(
    bevel: &BeveledMesh,
    factor_of: impl Fn(Term) -> f64,
    is_grounded: impl Fn(usize) -> bool,
) -> Result<SymmetricMatrix<f64>, NumericError> {
    let mut matrix =
        SymmetricMatrix { diagonal: vec![0.0; bevel.mesh.halfedge_count()], off_diagonal: Vec::new() };
    for (i, term) in bevel.terms().enumerate() {
        check_step(i)?;
        let row = bevel.row(term);
        let weight = factor_of(term) * row.weight;
        let product =
            |a: usize, b: usize| weight * row.parts.iter().map(|part| part[a] * part[b]).sum::<f64>();
        for (a, corner) in row.used() {
            matrix.diagonal[corner.index()] += product(a, a);
        }
        row.places().for_each(|[a, b]| matrix.off_diagonal.push(product(a, b)));
    }
    for (_, component) in bevel.topology.components.iter().enumerate().filter(|(c, _)| is_grounded(*c)) {
        matrix.diagonal[component.first_face.halfedge(0).index()] *= 2.0;
    }
    Ok(matrix)
}

/// Orders the corners face by face, the faces by nested dissection.
fn corner_order(bevel: &BeveledMesh) -> Result<Vec<u32>, NumericError> {
    let faces = face_order(bevel, &face_graph(bevel))?;
    Ok(faces.into_iter().flat_map(|f| [0, 1, 2].map(|k| 3 * f + k)).collect())
}

/// A term that should take given values near a singularity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Target {
    pub term: Term,
    pub values: [f64; 2],
}

/// Weight of targets relative to the energy.
const TARGET_WEIGHT: f64 = 50.0;
/// Most parts of targets that are met by a dense system. More of them take a factorisation of their
/// own.
const MOST_PARTS: usize = 400;

impl CornerLaplacian {
    /// Returns the smoothest rotation that differs from `theta` by differences of a function on
    /// corners, and that takes the targets as far as their weight allows.
    ///
    /// # Cost
    /// Two sweeps over the factor, and half solutions at the corners near new targets; a
    /// factorisation if there are many targets.
    pub fn smoothest(
        &self,
        bevel: &BeveledMesh,
        mut theta: Rotation,
        targets: &[Target],
    ) -> Result<Rotation, NumericError> {
        let mut rhs = vec![0.0; bevel.mesh.halfedge_count()];
        let mut subtract = |row: &Row, weight: f64, values: [f64; 2]| {
            for (i, corner) in row.used() {
                let [a, b] = row.parts.map(|part| part[i]);
                rhs[corner.index()] -= weight * row.weight * (a * values[0] + b * values[1]);
            }
        };
        for (i, term) in bevel.terms().enumerate() {
            check_step(i)?;
            subtract(&bevel.row(term), 1.0, bevel.term(term, &theta));
        }
        let mut conditions = Vec::with_capacity(2 * targets.len());
        let many = 2 * targets.len() > MOST_PARTS;
        for target in targets {
            let row = bevel.row(target.term);
            let values = bevel.term(target.term, &theta);
            let missing = [0, 1].map(|part| target.values[part] - values[part]);
            if many {
                subtract(&row, TARGET_WEIGHT, missing.map(|x| -x));
                continue;
            }
            for part in 0..2 {
                conditions.push(Condition {
                    row: row.used().map(|(i, c)| (c.0, row.parts[part][i])).collect(),
                    wanted: missing[part],
                    compliance: 1.0 / (TARGET_WEIGHT * row.weight),
                });
            }
        }
        let x = if many {
            self.solve_weighted(bevel, targets, &rhs)?
        } else {
            self.solve_with(&conditions, &rhs)?
        };
        theta.add(1.0, &bevel.differences(&x));
        Ok(theta)
    }

    /// Minimises the energy under conditions: a dense system in their multipliers.
    fn solve_with(&self, conditions: &[Condition], rhs: &[f64]) -> Result<Vec<f64>, NumericError> {
        if conditions.is_empty() {
            return self.factor.solve(rhs);
        }
        let mut responses = self.responses();
        responses.include(conditions.iter().flat_map(|condition| &condition.row).map(|&(c, _)| c))?;
        let mut half = self.factor.half_solve(rhs)?;
        let missing: Vec<f64> = conditions.iter().map(|c| c.wanted - responses.value(c, &half)).collect();
        let multipliers = responses.matrix(conditions)?.factor()?.solve(&missing)?;
        responses.push(conditions, multipliers.into_iter(), &mut half);
        self.factor.complete(&half)
    }

    /// Solves with the terms of the targets weighted in the matrix.
    fn solve_weighted(
        &self,
        bevel: &BeveledMesh,
        targets: &[Target],
        rhs: &[f64],
    ) -> Result<Vec<f64>, NumericError> {
        self.pulled(bevel, targets, &[])?.solve(rhs)
    }

    /// Factors the Hessian with the terms of the targets weighted, and with pulls added.
    pub fn pulled(
        &self,
        bevel: &BeveledMesh,
        targets: &[Target],
        pulls: &[Pull],
    ) -> Result<Cholesky<f64>, NumericError> {
        let mut times: HashMap<Term, f64> = HashMap::new();
        for target in targets {
            *times.entry(bevel.as_listed(target.term)).or_default() += 1.0;
        }
        let mut is_grounded = vec![true; bevel.topology.components.len()];
        for pull in pulls {
            is_grounded[bevel.component_of(Cycle::Face(pull.face))] = false;
        }
        let factor_of = |term| 1.0 + TARGET_WEIGHT * times.get(&term).unwrap_or(&0.0);
        let mut matrix = hessian(bevel, factor_of, |component| is_grounded[component])?;
        for pull in pulls {
            let w = pull.weights;
            let first = 3 * pull.face.index();
            (0..3).for_each(|k| matrix.diagonal[first + k] += pull.strength * w[k] * w[k]);
            // The terms of the faces come first, each with its three pairs of corners.
            for (pair, [a, b]) in [[0, 1], [0, 2], [1, 2]].into_iter().enumerate() {
                matrix.off_diagonal[first + pair] += pull.strength * w[a] * w[b];
            }
        }
        Cholesky::within(self.resources, self.factor.symbolic().clone(), &matrix)
    }
}

/// A spring at a point of a face: the squared value there, times its strength, joins the energy.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pull {
    pub face: Face,
    pub weights: [f64; 3],
    pub strength: f64,
}

impl Pull {
    /// Returns the value of a function on corners at the point.
    pub fn value(&self, x: &[f64]) -> f64 {
        (0..3).map(|k| self.weights[k] * x[self.face.halfedge(k).index()]).sum()
    }

    /// Adds a force at the point.
    pub fn push(&self, force: f64, rhs: &mut [f64]) {
        (0..3).for_each(|k| rhs[self.face.halfedge(k).index()] += force * self.weights[k]);
    }
}
