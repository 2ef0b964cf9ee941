//! Half solutions: what the forward sweep makes of a right-hand side.
//!
//! With `A = L L^H`, the half solution of `b` is `h(b) = L^-1 b`. Entries of the inverse follow
//! from products, `c^H A^-1 b = h(c)^H h(b)`, and the solution itself from a backward sweep. The
//! half solution of a sparse right-hand side is as short as its way to the root of the elimination
//! tree, so that many of them can be kept. They are what a low-rank change of `A`, or a few
//! constraints on
//! `x`, need.

use crate::cholesky::Cholesky;
use crate::error::NumericError;
use crate::kernels::{Vectorized, dispatch};
use crate::observer::check_stopped;
use crate::scalar::Scalar;
use std::ops::Range;

/// The half solution of a right-hand side.
///
/// ```
/// use eikona_numeric::{Cholesky, Graph, Ordering, Symbolic, SymmetricMatrix};
/// // 2 1
/// // 1 3
/// let graph = Graph { unknowns: 2, pairs: vec![[0, 1]] };
/// let symbolic = Symbolic::new(&graph, Ordering::MinimumDegree)?;
/// let matrix = SymmetricMatrix { diagonal: vec![2.0, 3.0], off_diagonal: vec![1.0] };
/// let factor = Cholesky::new(symbolic.into(), &matrix)?;
/// let unit = factor.half_solve_sparse(&[&[(0, 1.0)], &[(1, 1.0)]])?;
/// // An entry of the inverse, and a column of it.
/// assert!((unit[0].dot(&unit[1]) + 0.2).abs() < 1e-15);
/// assert!((factor.complete(&unit[0])?[0] - 0.6).abs() < 1e-15);
/// # Ok::<(), eikona_numeric::NumericError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HalfSolution<T> {
    /// Ranges of the elimination order, ascending: columns of whole supernodes.
    ranges: Vec<Range<u32>>,
    /// The values in these ranges, one after the other. Those in between are zero.
    values: Vec<T>,
}

impl<T: Scalar> HalfSolution<T> {
    /// Returns the product of the conjugate of this half solution with another one.
    pub fn dot(&self, other: &HalfSolution<T>) -> T {
        let mut sum = T::ZERO;
        self.for_shared(other, |a, b| {
            for (a, b) in self.values[a].iter().zip(&other.values[b]) {
                sum += a.conj() * *b;
            }
        });
        sum
    }

    /// Adds a multiple of another half solution, where this one has values: everywhere if its
    /// right-hand side was dense.
    pub fn add(&mut self, factor: T, other: &HalfSolution<T>) {
        let mut shared = Vec::new();
        self.for_shared(other, |a, b| shared.push((a, b)));
        for (a, b) in shared {
            for (a, b) in self.values[a].iter_mut().zip(&other.values[b]) {
                *a += factor * *b;
            }
        }
    }

    /// Returns the number of values kept.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Returns whether all values are zero because the right-hand side was.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Visits the values of the ranges that both have.
    fn for_shared(&self, other: &HalfSolution<T>, mut visit: impl FnMut(Range<usize>, Range<usize>)) {
        let (mut a, mut b) = (self.ranges.iter().peekable(), other.ranges.iter().peekable());
        let (mut at_a, mut at_b) = (0, 0);
        while let (Some(&p), Some(&q)) = (a.peek(), b.peek()) {
            let (len_a, len_b) = (p.len(), q.len());
            if p.start == q.start {
                visit(at_a..at_a + len_a, at_b..at_b + len_b);
            }
            if p.start <= q.start {
                at_a += len_a;
                a.next();
            }
            if q.start <= p.start {
                at_b += len_b;
                b.next();
            }
        }
    }
}

/// Right-hand sides that share a pass over the factor.
const TOGETHER: usize = 8;

impl<T: Scalar> Cholesky<T> {
    /// Returns the half solution of a right-hand side.
    ///
    /// # Errors
    /// As for [`solve`](Self::solve).
    ///
    /// # Cost
    /// One sweep over the factor.
    pub fn half_solve(&self, rhs: &[T]) -> Result<HalfSolution<T>, NumericError> {
        self.check(rhs)?;
        let symbolic = self.symbolic();
        let supernodes = symbolic.supernodes();
        let all: Vec<usize> = (0..supernodes.count()).collect();
        let mut values = [symbolic.order().iter().map(|&i| rhs[i as usize]).collect::<Vec<T>>()];
        dispatch(Forward { factor: self, columns: &mut values, supernodes: &all })?;
        let [values] = values;
        let range = |s: &usize| supernodes.columns(*s).start as u32..supernodes.columns(*s).end as u32;
        Ok(HalfSolution { ranges: all.iter().map(range).collect(), values })
    }

    /// Returns the half solutions of sparse right-hand sides, given as pairs of unknown and value.
    ///
    /// # Errors
    /// As for [`solve`](Self::solve); [`NumericError::WrongLength`] if an unknown does not exist.
    ///
    /// # Cost
    /// The parts of the factor between the non-zeros and the root of the elimination tree.
    pub fn half_solve_sparse(&self, rhs: &[&[(usize, T)]]) -> Result<Vec<HalfSolution<T>>, NumericError> {
        let symbolic = self.symbolic();
        let (supernodes, position) = (symbolic.supernodes(), symbolic.position());
        let mut result = Vec::with_capacity(rhs.len());
        let mut columns: Vec<Vec<T>> = Vec::new();
        let mut marked = vec![false; supernodes.count()];
        for group in rhs.chunks(TOGETHER) {
            check_stopped()?;
            columns.resize(columns.len().max(group.len()), vec![T::ZERO; symbolic.unknowns()]);
            let mut path = Vec::new();
            for (column, entries) in columns.iter_mut().zip(group) {
                for &(unknown, value) in *entries {
                    let Some(&place) = position.get(unknown) else {
                        let expected = symbolic.unknowns();
                        return Err(NumericError::WrongLength { found: unknown + 1, expected });
                    };
                    if !value.finite() {
                        return Err(NumericError::NonFinite { what: "the right-hand side", unknown });
                    }
                    column[place as usize] += value;
                    let mut next = Some(supernodes.of_column(place as usize));
                    while let Some(s) = next.filter(|&s| !std::mem::replace(&mut marked[s], true)) {
                        path.push(s);
                        next = supernodes.parent(s);
                    }
                }
            }
            path.sort_unstable();
            dispatch(Forward { factor: self, columns: &mut columns[..group.len()], supernodes: &path })?;
            for column in &mut columns[..group.len()] {
                let mut half = HalfSolution { ranges: Vec::new(), values: Vec::new() };
                for range in path.iter().map(|&s| supernodes.columns(s)) {
                    let values = &mut column[range.clone()];
                    if values.iter().any(|x| *x != T::ZERO) {
                        half.ranges.push(range.start as u32..range.end as u32);
                        half.values.extend_from_slice(values);
                        values.fill(T::ZERO);
                    }
                }
                result.push(half);
            }
            path.into_iter().for_each(|s| marked[s] = false);
        }
        Ok(result)
    }

    /// Returns the solution that belongs to a half solution.
    ///
    /// # Errors
    /// [`NumericError::NonFinite`] if the solution is not finite.
    ///
    /// # Cost
    /// One sweep over the factor.
    pub fn complete(&self, half: &HalfSolution<T>) -> Result<Vec<T>, NumericError> {
        let symbolic = self.symbolic();
        let mut x = vec![T::ZERO; symbolic.unknowns()];
        let mut values = half.values.iter();
        for range in &half.ranges {
            let target = &mut x[range.start as usize..range.end as usize];
            target.iter_mut().zip(&mut values).for_each(|(x, value)| *x = *value);
        }
        let mut x = [x];
        dispatch(Backward { factor: self, columns: &mut x })?;
        let x: Vec<T> = symbolic.position().iter().map(|&p| x[0][p as usize]).collect();
        match x.iter().position(|x| !x.finite()) {
            Some(unknown) => Err(NumericError::NonFinite { what: "the solution", unknown }),
            None => Ok(x),
        }
    }
}

/// The forward sweep over some supernodes, in ascending order.
struct Forward<'a, T> {
    factor: &'a Cholesky<T>,
    columns: &'a mut [Vec<T>],
    supernodes: &'a [usize],
}

impl<T: Scalar> Vectorized for Forward<'_, T> {
    type Output = Result<(), NumericError>;
    #[inline(always)]
    fn run<S: pulp::Simd>(self, simd: S) -> Self::Output {
        let mut gathered = self.factor.gathering_space();
        self.factor.forward(simd, self.columns, &mut gathered, self.supernodes.iter().copied())
    }
}

/// The whole backward sweep.
struct Backward<'a, T> {
    factor: &'a Cholesky<T>,
    columns: &'a mut [Vec<T>],
}

impl<T: Scalar> Vectorized for Backward<'_, T> {
    type Output = Result<(), NumericError>;
    #[inline(always)]
    fn run<S: pulp::Simd>(self, simd: S) -> Self::Output {
        let mut gathered = self.factor.gathering_space();
        self.factor.backward(simd, self.columns, &mut gathered, None)
    }
}
