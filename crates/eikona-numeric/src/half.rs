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
    /// Pieces in elimination order. The values in between are zero.
    pieces: Vec<Piece>,
    /// The values of all pieces, one after the other.
    values: Vec<T>,
}

/// The columns of a supernode, and where their values begin.
#[derive(Clone, Debug, PartialEq)]
struct Piece {
    columns: Range<u32>,
    first: usize,
}

impl Piece {
    fn values(&self) -> Range<usize> {
        self.first..self.first + self.columns.len()
    }
}

impl<T: Scalar> HalfSolution<T> {
    /// Returns the product of the conjugate of this half solution with another one.
    pub fn dot(&self, other: &HalfSolution<T>) -> T {
        let mut sum = T::ZERO;
        for [own, theirs] in shared(&self.pieces, &other.pieces) {
            for (a, b) in self.values[own].iter().zip(&other.values[theirs]) {
                sum += a.conj() * *b;
            }
        }
        sum
    }

    /// Adds a multiple of another half solution, where this one has values: everywhere if its
    /// right-hand side was dense.
    pub fn add(&mut self, factor: T, other: &HalfSolution<T>) {
        for [own, theirs] in shared(&self.pieces, &other.pieces) {
            for (a, b) in self.values[own].iter_mut().zip(&other.values[theirs]) {
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
}

/// Iterates over the pieces that both have, with the places of their values. One may have many more
/// pieces than the other.
fn shared<'a>(a: &'a [Piece], b: &'a [Piece]) -> impl Iterator<Item = [Range<usize>; 2]> + 'a {
    let is_swapped = a.len() > b.len();
    let (few, mut many) = if is_swapped { (b, a) } else { (a, b) };
    few.iter().filter_map(move |piece| {
        let begin = piece.columns.start;
        many = &many[many.partition_point(|other| other.columns.start < begin)..];
        let found = many.first().filter(|other| other.columns.start == begin)?;
        let (few, many) = (piece.values(), found.values());
        Some(if is_swapped { [many, few] } else { [few, many] })
    })
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
        check_stopped()?;
        self.check(rhs)?;
        check_stopped()?;
        let symbolic = self.symbolic();
        let supernodes = symbolic.supernodes();
        let all: Vec<usize> = (0..supernodes.count()).collect();
        let mut values = [symbolic.order().iter().map(|&i| rhs[i as usize]).collect::<Vec<T>>()];
        check_stopped()?;
        dispatch(Forward { factor: self, columns: &mut values, supernodes: &all })?;
        let [values] = values;
        let piece = |s: &usize| {
            let columns = supernodes.columns(*s);
            Piece { columns: columns.start as u32..columns.end as u32, first: columns.start }
        };
        Ok(HalfSolution { pieces: all.iter().map(piece).collect(), values })
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
            while columns.len() < group.len() {
                columns.push(vec![T::ZERO; symbolic.unknowns()]);
                check_stopped()?;
            }
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
                check_stopped()?;
                let mut half = HalfSolution { pieces: Vec::new(), values: Vec::new() };
                for range in path.iter().map(|&s| supernodes.columns(s)) {
                    let values = &mut column[range.clone()];
                    if values.iter().any(|x| *x != T::ZERO) {
                        let columns = range.start as u32..range.end as u32;
                        half.pieces.push(Piece { columns, first: half.values.len() });
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
        for piece in &half.pieces {
            x[piece.columns.start as usize..piece.columns.end as usize]
                .copy_from_slice(&half.values[piece.values()]);
        }
        let mut x = [x];
        check_stopped()?;
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
