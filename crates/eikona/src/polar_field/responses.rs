//! Conditions on a few corners, solved with the kept factor of the energy: a dense system in their
//! multipliers.
//!
//! The entries of the inverse between corners are products of half solutions, one per corner. They
//! do not depend on the prescription, so they are kept: an edit computes those of new elements
//! only.

use eikona_numeric::{
    Cholesky, Graph, HalfSolution, NumericError, Ordering, Symbolic, SymmetricMatrix, check_step,
};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

type Half = Arc<HalfSolution<f64>>;

/// Half solutions of unit forces at corners.
#[derive(Debug, Default)]
pub(crate) struct HalfSolutions(Mutex<HashMap<u32, Half>>);

/// Most values kept: 256 MB.
const MOST_VALUES: usize = 1 << 25;

impl HalfSolutions {
    /// Returns the half solutions of these corners, from the last time or new.
    fn of(&self, factor: &Cholesky<f64>, corners: &[u32]) -> Result<Vec<Half>, NumericError> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut new: Vec<u32> = corners.iter().copied().filter(|c| !kept.contains_key(c)).collect();
        new.sort_unstable();
        new.dedup();
        let forces: Vec<[(usize, f64); 1]> = new.iter().map(|&c| [(c as usize, 1.0)]).collect();
        let forces: Vec<&[(usize, f64)]> = forces.iter().map(|force| force.as_slice()).collect();
        let halves = factor.half_solve_sparse(&forces)?.into_iter().map(Arc::new);
        let halves: HashMap<u32, Half> = new.into_iter().zip(halves).collect();
        let result = corners.iter().map(|c| kept.get(c).or_else(|| halves.get(c)).cloned());
        let result = result.map(|half| half.expect("it is kept or new")).collect();
        let values = |halves: &HashMap<u32, Half>| halves.values().map(|half| half.len()).sum::<usize>();
        if values(&kept) + values(&halves) > MOST_VALUES {
            kept.clear();
        }
        if values(&halves) <= MOST_VALUES {
            kept.extend(halves);
        }
        Ok(result)
    }
}

/// The entries of the inverse between some corners.
pub(crate) struct Responses<'a> {
    factor: &'a Cholesky<f64>,
    kept: &'a HalfSolutions,
    place: HashMap<u32, usize>,
    halves: Vec<Half>,
    /// Lower triangle, row by row.
    products: Vec<Vec<f64>>,
}

impl<'a> Responses<'a> {
    pub fn new(factor: &'a Cholesky<f64>, kept: &'a HalfSolutions) -> Responses<'a> {
        Responses { factor, kept, place: HashMap::new(), halves: Vec::new(), products: Vec::new() }
    }

    /// Solves with a right-hand side under conditions.
    pub fn solve(mut self, conditions: &[Condition], rhs: &[f64]) -> Result<Vec<f64>, NumericError> {
        if conditions.is_empty() {
            return self.factor.solve(rhs);
        }
        self.include(conditions.iter().flat_map(|condition| &condition.row).map(|&(c, _)| c))?;
        let mut half = self.factor.half_solve(rhs)?;
        let missing: Vec<f64> = conditions.iter().map(|c| c.wanted - self.value(c, &half)).collect();
        let multipliers = self.matrix(conditions)?.factor()?.solve(&missing)?;
        self.push(conditions, multipliers.into_iter(), &mut half);
        self.factor.complete(&half)
    }

    /// Adds corners, unless they are there.
    pub fn include(&mut self, corners: impl Iterator<Item = u32>) -> Result<(), NumericError> {
        let mut new: Vec<u32> = corners.filter(|c| !self.place.contains_key(c)).collect();
        new.sort_unstable();
        new.dedup();
        let halves = self.kept.of(self.factor, &new)?;
        for (corner, half) in new.into_iter().zip(halves) {
            check_step(self.halves.len())?;
            self.place.insert(corner, self.halves.len());
            self.halves.push(half.clone());
            self.products.push(self.halves.iter().map(|other| half.dot(other)).collect());
        }
        Ok(())
    }

    /// Returns the value at one row of conditions of a unit multiplier at another.
    fn between(&self, a: &Condition, b: &Condition) -> f64 {
        let mut sum = 0.0;
        for &(corner, x) in &a.row {
            let i = self.place[&corner];
            for &(corner, y) in &b.row {
                let j = self.place[&corner];
                sum += x * y * self.products[i.max(j)][i.min(j)];
            }
        }
        sum
    }

    /// Returns the matrix of the multipliers.
    pub fn matrix(&self, conditions: &[Condition]) -> Result<Dense, NumericError> {
        let mut matrix = Dense::zeros(conditions.len());
        for (j, b) in conditions.iter().enumerate() {
            check_step(j)?;
            for (i, a) in conditions[..=j].iter().enumerate() {
                let compliance = if i == j { b.compliance } else { 0.0 };
                matrix.set(i, j, self.between(a, b) + compliance);
            }
        }
        Ok(matrix)
    }

    /// Returns the value of a condition at a solution, of which the first half is given.
    pub fn value(&self, condition: &Condition, half: &HalfSolution<f64>) -> f64 {
        condition.row.iter().map(|&(c, x)| x * self.halves[self.place[&c]].dot(half)).sum()
    }

    /// Adds the forces of multipliers to a dense half solution.
    pub fn push(
        &self,
        conditions: &[Condition],
        multipliers: impl Iterator<Item = f64>,
        half: &mut HalfSolution<f64>,
    ) {
        let mut forces = vec![0.0; self.halves.len()];
        for (condition, multiplier) in conditions.iter().zip(multipliers) {
            condition.row.iter().for_each(|&(c, x)| forces[self.place[&c]] += x * multiplier);
        }
        for (unit, force) in self.halves.iter().zip(forces).filter(|(_, force)| *force != 0.0) {
            half.add(force, unit);
        }
    }
}

/// A linear condition on corner values.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Condition {
    /// Coefficients of the corners.
    pub row: Vec<(u32, f64)>,
    /// What they should add up to.
    pub wanted: f64,
    /// One over its weight in the energy; zero if it must hold.
    pub compliance: f64,
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

    /// Factors the matrix. Conditions that are the same up to rounding, such as those of corners
    /// whose scales differ by many orders of magnitude, make it singular: its diagonal is then
    /// raised by the least share that helps, which splits their multiplier between them.
    ///
    /// # Errors
    /// [`NumericError::NonPositivePivot`] if no share up to 1e-8 helps.
    pub fn factor(&self) -> Result<Cholesky<f64>, NumericError> {
        let pairs = (0..self.size as u32).flat_map(|j| (0..j).map(move |i| [i, j])).collect();
        let graph = Graph { unknowns: self.size, pairs };
        let order: Vec<u32> = (0..self.size as u32).collect();
        let symbolic = Symbolic::new(&graph, Ordering::Given(&order))?;
        let symbolic: Arc<Symbolic> = symbolic.into();
        let mut factor = Cholesky::new(symbolic.clone(), &self.matrix);
        for share in [1e-14, 1e-12, 1e-10, 1e-8] {
            if !matches!(factor, Err(NumericError::NonPositivePivot { .. })) {
                break;
            }
            let mut matrix = self.matrix.clone();
            matrix.diagonal.iter_mut().for_each(|x| *x *= 1.0 + share);
            factor = Cholesky::new(symbolic.clone(), &matrix);
        }
        factor
    }
}
