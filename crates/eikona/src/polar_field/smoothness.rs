//! The smoothness of a rotation (PLPF appendix B.1), and its minimisation over functions on
//! corners.
//!
//! Deviation: the printed energy squares the sum of the gradients of two faces and their jump. The
//! three may cancel, so that a rough field costs nothing: on a sphere of 596 faces 60 eigenvalues
//! vanish where one should. Here gradients and jumps are squared apart.

use crate::geometry::Triangle;
use crate::polar_field::bevel::{BeveledMesh, Rotation};
use eikona_mesh::{Face, Halfedge};
use eikona_numeric::{
    Cholesky, Complex, Graph, NumericError, Ordering, Resources, Scalar, Symbolic, SymmetricMatrix,
    check_step, nested_dissection_order,
};

/// Weight of squared jumps relative to squared gradients.
///
/// A larger weight makes fields more accurate far from singularities, where jumps carry part of the
/// rotation: on a disk the angle of the power is off from the harmonic one by 0.016, 0.006, 0.001
/// radians (root mean square) for weights of 1, 10, 100, and by 0.12, 0.044, 0.006 on triangles
/// four times as long as wide; refinement does not help. A smaller one leaves room for singular
/// faces next to others: with 100 and 1000, 1 and 5 of 480 random prescriptions have one that
/// can not be placed, with 10 and 30 none.
const JUMP_WEIGHT: f64 = 10.0;

/// Two terms of the energy: the gradient in a face, or mean and difference of the jumps at the ends
/// of an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
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
    fn used(&self) -> impl Iterator<Item = (usize, [f64; 2])> + '_ {
        (0..4).map(|i| (self.corners[i].index(), self.parts.map(|part| part[i])))
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
        let edges = self.interior().filter(|(h, twin)| h < twin).map(|(h, _)| Term::Edge(h));
        self.mesh.faces().map(Term::Face).chain(edges)
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
}

impl CornerLaplacian {
    pub fn new(bevel: &BeveledMesh, resources: Resources) -> Result<CornerLaplacian, NumericError> {
        let unknowns = bevel.mesh.halfedge_count();
        let mut graph = Graph { unknowns, pairs: Vec::new() };
        let mut matrix = SymmetricMatrix { diagonal: vec![0.0; unknowns], off_diagonal: Vec::new() };
        for (i, term) in bevel.terms().enumerate() {
            check_step(i)?;
            let row = bevel.row(term);
            let count = if matches!(term, Term::Face(_)) { 3 } else { 4 };
            for a in 0..count {
                for b in a..count {
                    let value = row.weight * row.parts.iter().map(|part| part[a] * part[b]).sum::<f64>();
                    if a == b {
                        matrix.diagonal[row.corners[a].index()] += value;
                    } else {
                        graph.pairs.push([row.corners[a], row.corners[b]].map(|c| c.0));
                        matrix.off_diagonal.push(value);
                    }
                }
            }
        }
        // The function is zero at one corner per component.
        for component in &bevel.topology.components {
            matrix.diagonal[component.first_face.halfedge(0).index()] *= 2.0;
        }
        let order = corner_order(bevel)?;
        let symbolic = Symbolic::new(&graph, Ordering::Given(&order))?;
        Ok(CornerLaplacian { factor: Cholesky::within(resources, symbolic.into(), &matrix)? })
    }
}

/// Orders the corners face by face, the faces by nested dissection.
fn corner_order(bevel: &BeveledMesh) -> Result<Vec<u32>, NumericError> {
    let mesh = &bevel.mesh;
    let pairs = bevel.interior().filter(|(h, twin)| h < twin).map(|(h, twin)| [h.face().0, twin.face().0]);
    let graph = Graph { unknowns: mesh.face_count(), pairs: pairs.collect() };
    let centre = |f: Face| {
        let [a, b, c] = mesh.face_positions(f);
        [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0)
    };
    let centres: Vec<[f64; 3]> = mesh.faces().map(centre).collect();
    let faces = nested_dissection_order(&graph, &centres)?;
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

impl CornerLaplacian {
    /// Returns the smoothest rotation that differs from `theta` by differences of a function on
    /// corners, and that takes the targets as far as their weight allows.
    ///
    /// # Cost
    /// Two back-substitutions, and one restricted to the neighbourhood of the targets for each of
    /// their parts.
    pub fn smoothest(
        &self,
        bevel: &BeveledMesh,
        mut theta: Rotation,
        targets: &[Target],
    ) -> Result<Rotation, NumericError> {
        let mut rhs = vec![0.0; bevel.mesh.halfedge_count()];
        let mut subtract = |row: &Row, weight: f64, values: [f64; 2]| {
            for (corner, [a, b]) in row.used() {
                rhs[corner] -= weight * row.weight * (a * values[0] + b * values[1]);
            }
        };
        for (i, term) in bevel.terms().enumerate() {
            check_step(i)?;
            subtract(&bevel.row(term), 1.0, bevel.term(term, &theta));
        }
        let mut rows = Vec::with_capacity(targets.len());
        for target in targets {
            let row = bevel.row(target.term);
            let [a, b] = bevel.term(target.term, &theta);
            subtract(&row, TARGET_WEIGHT, [a - target.values[0], b - target.values[1]]);
            rows.push(row);
        }
        let x = self.solve_with(&rows, &rhs)?;
        theta.add(1.0, &bevel.differences(&x));
        Ok(theta)
    }

    /// Solves `(L + B' W B) x = rhs` for the rows `B` of the targets, by the formula of Woodbury.
    fn solve_with(&self, rows: &[Row], rhs: &[f64]) -> Result<Vec<f64>, NumericError> {
        let before = self.factor.solve(rhs)?;
        if rows.is_empty() {
            return Ok(before);
        }
        let parts: Vec<(&Row, usize)> = rows.iter().flat_map(|row| [(row, 0), (row, 1)]).collect();
        let value = |&(row, part): &(&Row, usize), x: &[f64]| -> f64 {
            (0..4).map(|i| row.parts[part][i] * x[row.corners[i].index()]).sum()
        };
        let mut needed = vec![false; rhs.len()];
        rows.iter().flat_map(|row| row.corners).for_each(|c| needed[c.index()] = true);
        let mut small = Dense::zeros(parts.len());
        let mut column = vec![0.0; rhs.len()];
        for (j, (row, part)) in parts.iter().enumerate() {
            for i in 0..4 {
                column[row.corners[i].index()] += row.parts[*part][i];
            }
            let response = self.factor.solve_where(&column, |corner| needed[corner])?;
            row.corners.iter().for_each(|c| column[c.index()] = 0.0);
            for i in 0..=j {
                small.set(i, j, value(&parts[i], &response));
            }
            small.set(j, j, value(&parts[j], &response) + 1.0 / (TARGET_WEIGHT * row.weight));
        }
        let forces = small.solve(parts.iter().map(|part| value(part, &before)).collect())?;
        let mut corrected = rhs.to_vec();
        for ((row, part), force) in parts.iter().zip(&forces) {
            for i in 0..4 {
                corrected[row.corners[i].index()] -= row.parts[*part][i] * force;
            }
        }
        self.factor.solve(&corrected)
    }
}

/// A dense symmetric positive definite matrix.
pub(crate) struct Dense {
    size: usize,
    matrix: SymmetricMatrix<f64>,
}

impl Dense {
    pub fn zeros(size: usize) -> Dense {
        let off_diagonal = vec![0.0; size * size.saturating_sub(1) / 2];
        Dense { size, matrix: SymmetricMatrix { diagonal: vec![0.0; size], off_diagonal } }
    }

    /// Sets the entry at `(i, j)`, `i <= j`, and its mirror image.
    pub fn set(&mut self, i: usize, j: usize, value: f64) {
        if i == j {
            self.matrix.diagonal[j] = value;
        } else {
            self.matrix.off_diagonal[j * (j - 1) / 2 + i] = value;
        }
    }

    pub fn solve(&self, rhs: Vec<f64>) -> Result<Vec<f64>, NumericError> {
        let pairs = (0..self.size as u32).flat_map(|j| (0..j).map(move |i| [i, j])).collect();
        let graph = Graph { unknowns: self.size, pairs };
        let order: Vec<u32> = (0..self.size as u32).collect();
        let symbolic = Symbolic::new(&graph, Ordering::Given(&order))?;
        Cholesky::new(symbolic.into(), &self.matrix)?.solve(&rhs)
    }
}
