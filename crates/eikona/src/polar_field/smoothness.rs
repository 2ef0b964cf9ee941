//! The smoothest rotation (PLPF appendix B.1): the energy as a function on corners, factored once.

use crate::polar_field::bevel::{BeveledMesh, Cycle, Rotation};
use crate::polar_field::options::Smoothness;
use crate::polar_field::powers::{face_graph, face_order};
use crate::polar_field::responses::{Condition, HalfSolutions, Responses};
use crate::polar_field::terms::{Row, Term};
use eikona_mesh::Face;
use eikona_numeric::{
    Cholesky, Graph, NumericError, Ordering, Resources, Symbolic, SymmetricMatrix, check_step, check_stopped,
};
use std::collections::HashMap;

/// The Hessian of the energy as a function on corners, factored. It serves every prescription, and
/// the scales too.
#[derive(Debug)]
pub(crate) struct CornerLaplacian {
    pub factor: Cholesky<f64>,
    pub halves: HalfSolutions,
    smoothness: Smoothness,
    resources: Resources,
}

impl CornerLaplacian {
    pub fn new(
        bevel: &BeveledMesh,
        smoothness: Smoothness,
        resources: Resources,
    ) -> Result<CornerLaplacian, NumericError> {
        let mut graph = Graph { unknowns: bevel.mesh.halfedge_count(), pairs: Vec::new() };
        for (i, term) in bevel.terms(smoothness).enumerate() {
            check_step(i)?;
            bevel.row(term).pairs().for_each(|pair| graph.pairs.push(pair.map(|c| c.0)));
        }
        let order = corner_order(bevel, resources.threads)?;
        let symbolic = Symbolic::new(&graph, Ordering::Given(&order))?;
        let factor =
            Cholesky::within(resources, symbolic.into(), &hessian(bevel, smoothness, |_| 0.0, |_| true)?)?;
        Ok(CornerLaplacian { factor, halves: HalfSolutions::default(), smoothness, resources })
    }

    /// Returns the responses between no corners.
    pub fn responses(&self) -> Responses<'_> {
        Responses::new(&self.factor, &self.halves)
    }
}

/// Assembles the Hessian, with more of some terms. On grounded components, the function is drawn to
/// zero at one corner.
fn hessian(
    bevel: &BeveledMesh,
    smoothness: Smoothness,
    more_of: impl Fn(Term) -> f64,
    is_grounded: impl Fn(usize) -> bool,
) -> Result<SymmetricMatrix<f64>, NumericError> {
    let mut matrix =
        SymmetricMatrix { diagonal: vec![0.0; bevel.mesh.halfedge_count()], off_diagonal: Vec::new() };
    for (i, term) in bevel.terms(smoothness).enumerate() {
        check_step(i)?;
        let row = bevel.row(term);
        let weight = (smoothness.factor(term) + more_of(term)) * row.weight;
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
fn corner_order(bevel: &BeveledMesh, threads: usize) -> Result<Vec<u32>, NumericError> {
    check_stopped()?;
    let faces = face_order(bevel, &face_graph(bevel)?, threads)?;
    check_stopped()?;
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
        check_stopped()?;
        let mut subtract = |row: &Row, weight: f64, values: [f64; 2]| {
            for (i, corner) in row.used() {
                let [a, b] = row.parts.map(|part| part[i]);
                rhs[corner.index()] -= weight * row.weight * (a * values[0] + b * values[1]);
            }
        };
        for (i, term) in bevel.terms(self.smoothness).enumerate() {
            check_step(i)?;
            subtract(&bevel.row(term), self.smoothness.factor(term), bevel.term(term, &theta));
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
            self.responses().solve(&conditions, &rhs)?
        };
        theta.add(1.0, &bevel.differences(&x));
        Ok(theta)
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
        let more_of = |term| TARGET_WEIGHT * times.get(&term).unwrap_or(&0.0);
        let mut matrix = hessian(bevel, self.smoothness, more_of, |component| is_grounded[component])?;
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
