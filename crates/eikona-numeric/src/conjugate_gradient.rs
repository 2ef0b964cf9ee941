//! Conjugate gradients.

/// Preconditioned conjugate gradients for `A x = b`, one step at a time, from `x = 0`.
///
/// `A` is symmetric positive semidefinite, with `b` in its range; the preconditioner is symmetric
/// positive definite. The caller decides when to stop, in the norm of its choice.
///
/// ```
/// use eikona_numeric::ConjugateGradient;
/// let mut iteration = ConjugateGradient::new(vec![3.0, 4.0], |r| Ok::<_, String>(r.to_vec()))?;
/// while iteration.residual().iter().any(|r| r.abs() > 1e-14) {
///     let step = iteration.step(|d| Ok(vec![2.0 * d[0] + d[1], d[0] + 3.0 * d[1]]))?;
///     if step.is_none() {
///         break;
///     }
/// }
/// assert!(iteration.iterations() <= 3);
/// let x = iteration.into_solution();
/// assert!((x[0] - 1.0).abs() < 1e-14 && (x[1] - 1.0).abs() < 1e-14);
/// # Ok::<(), String>(())
/// ```
///
/// # Cost
/// Five vectors of the length of `b`. Each step multiplies once by `A`, applies the preconditioner
/// once, and passes over the vectors five times.
///
/// # Reference
/// M. R. Hestenes and E. Stiefel, "Methods of conjugate gradients for solving linear systems",
/// Journal of Research of the National Bureau of Standards 49 (1952).
#[derive(Debug)]
pub struct ConjugateGradient<P> {
    precondition: P,
    solution: Vec<f64>,
    residual: Vec<f64>,
    direction: Vec<f64>,
    /// Inner product of the residual and the preconditioned residual.
    product: f64,
    iterations: usize,
}

impl<P> ConjugateGradient<P> {
    /// Starts at zero, where the residual is the right-hand side. The preconditioner approximates
    /// `A^-1`; a copy of its argument stands for none.
    ///
    /// # Errors
    /// Those of the preconditioner.
    pub fn new<E>(rhs: Vec<f64>, mut precondition: P) -> Result<Self, E>
    where
        P: FnMut(&[f64]) -> Result<Vec<f64>, E>,
    {
        let direction = precondition(&rhs)?;
        let product = dot(&rhs, &direction);
        Ok(ConjugateGradient {
            precondition,
            solution: vec![0.0; rhs.len()],
            residual: rhs,
            direction,
            product,
            iterations: 0,
        })
    }

    /// Takes one step. The operator multiplies the search direction by `A`.
    ///
    /// Returns the step length `s`: the solution has moved by `s` times the direction, and any
    /// linear image of the solution by `s` times that of the direction. Returns `None` if rounding
    /// leaves no step to take, and keeps the solution: the residual is zero, or `A` is singular and
    /// the rest of the residual is not in its range.
    ///
    /// # Errors
    /// Those of the operator and the preconditioner.
    pub fn step<E>(&mut self, operator: impl FnOnce(&[f64]) -> Result<Vec<f64>, E>) -> Result<Option<f64>, E>
    where
        P: FnMut(&[f64]) -> Result<Vec<f64>, E>,
    {
        self.iterations += 1;
        let image = operator(&self.direction)?;
        let step = self.product / dot(&self.direction, &image);
        if !step.is_finite() || step <= 0.0 {
            return Ok(None);
        }
        add_multiple(&mut self.solution, step, &self.direction);
        add_multiple(&mut self.residual, -step, &image);
        let scaled = (self.precondition)(&self.residual)?;
        let product = dot(&self.residual, &scaled);
        let growth = product / self.product;
        for (d, z) in self.direction.iter_mut().zip(scaled) {
            *d = z + growth * *d;
        }
        self.product = product;
        Ok(Some(step))
    }

    /// Returns `b - A x`, as updated from step to step.
    pub fn residual(&self) -> &[f64] {
        &self.residual
    }
    /// Returns the number of products with `A`.
    pub fn iterations(&self) -> usize {
        self.iterations
    }
    /// Returns `x`.
    pub fn into_solution(self) -> Vec<f64> {
        self.solution
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `a <- a + factor b`
fn add_multiple(a: &mut [f64], factor: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += factor * b);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    const N: usize = 12;

    /// A full matrix `B B^T + shift`, where `B` has one column less than rows.
    fn matrix(shift: f64) -> Vec<Vec<f64>> {
        let b = |i: usize, k: usize| ((3 * i + 7 * k * k + 1) as f64).sin();
        let entry = |i: usize, j: usize| {
            (0..N - 1).map(|k| b(i, k) * b(j, k)).sum::<f64>() + if i == j { shift } else { 0.0 }
        };
        (0..N).map(|i| (0..N).map(|j| entry(i, j)).collect()).collect()
    }

    fn times(matrix: &[Vec<f64>], x: &[f64]) -> Vec<f64> {
        matrix.iter().map(|row| dot(row, x)).collect()
    }

    /// Gaussian elimination without pivoting, for positive definite matrices.
    fn dense_solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
        for k in 0..N {
            for i in k + 1..N {
                let factor = a[i][k] / a[k][k];
                let pivot_row = a[k].clone();
                add_multiple(&mut a[i], -factor, &pivot_row);
                b[i] -= factor * b[k];
            }
        }
        for k in (0..N).rev() {
            b[k] = (b[k] - dot(&a[k][k + 1..], &b[k + 1..])) / a[k][k];
        }
        b
    }

    fn unconditioned(r: &[f64]) -> Result<Vec<f64>, Infallible> {
        Ok(r.to_vec())
    }

    /// Iterates until the residual is below a bound, or no step is left.
    fn solve<P>(a: &[Vec<f64>], b: &[f64], bound: f64, precondition: P) -> ConjugateGradient<P>
    where
        P: FnMut(&[f64]) -> Result<Vec<f64>, Infallible>,
    {
        let Ok(mut iteration) = ConjugateGradient::new(b.to_vec(), precondition);
        while iteration.iterations() < 100 && dot(iteration.residual(), iteration.residual()).sqrt() > bound {
            let Ok(step) = iteration.step(|d| Ok::<_, Infallible>(times(a, d)));
            if step.is_none() {
                break;
            }
        }
        iteration
    }

    fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn solution_is_that_of_a_dense_solve() {
        let a = matrix(0.5);
        let b: Vec<f64> = (0..N).map(|i| (i as f64).cos()).collect();
        let expected = dense_solve(a.clone(), b.clone());
        let scaled = |r: &[f64]| Ok((0..N).map(|i| r[i] / a[i][i]).collect());
        for iteration in [
            solve(&a, &b, 1e-13, unconditioned).into_solution(),
            solve(&a, &b, 1e-13, scaled).into_solution(),
        ] {
            assert!(largest_difference(&iteration, &expected) < 1e-12);
        }
    }

    #[test]
    fn the_inverse_as_preconditioner_takes_one_step() {
        let a = matrix(0.5);
        let b: Vec<f64> = (0..N).map(|i| (i as f64).cos()).collect();
        let iteration = solve(&a, &b, 1e-13, |r| Ok(dense_solve(a.clone(), r.to_vec())));
        assert_eq!(iteration.iterations(), 1);
    }

    #[test]
    fn singular_consistent_systems_are_solved() {
        let a = matrix(0.0);
        let b = times(&a, &(0..N).map(|i| (i as f64).cos()).collect::<Vec<f64>>());
        let iteration = solve(&a, &b, 1e-11, unconditioned);
        assert!(iteration.iterations() < 40, "{}", iteration.iterations());
        assert!(largest_difference(&times(&a, &iteration.into_solution()), &b) < 1e-10);
    }

    #[test]
    fn linear_images_of_the_solution_follow_the_steps() {
        let a = matrix(0.5);
        let Ok(mut iteration) = ConjugateGradient::new(vec![1.0; N], unconditioned);
        let mut product = vec![0.0; N];
        for _ in 0..5 {
            let mut image = Vec::new();
            let Ok(step) = iteration.step(|d| {
                image = times(&a, d);
                Ok::<_, Infallible>(image.clone())
            });
            add_multiple(&mut product, step.unwrap(), &image);
        }
        assert!(largest_difference(&times(&a, &iteration.into_solution()), &product) < 1e-12);
    }

    #[test]
    fn without_a_step_to_take_the_solution_stays() {
        let Ok(mut solved) = ConjugateGradient::new(vec![0.0; 2], unconditioned);
        assert_eq!(solved.step(|d| Ok(d.to_vec())), Ok(None));
        assert_eq!(solved.into_solution(), [0.0, 0.0]);
        // The second component of the right-hand side is not in the range of the matrix.
        let Ok(mut inconsistent) = ConjugateGradient::new(vec![1.0, 1.0], unconditioned);
        let mut step = || inconsistent.step(|d| Ok(vec![d[0], 0.0])).map(|step| step.is_some());
        assert_eq!([step(), step()], [Ok(true), Ok(false)]);
        assert_eq!(inconsistent.into_solution(), [2.0, 2.0]);
    }

    #[test]
    fn errors_pass_through() {
        let mut iteration = ConjugateGradient::new(vec![1.0], |r| Ok(r.to_vec())).unwrap();
        assert_eq!(iteration.step(|_| Err("operator")), Err("operator"));
        assert_eq!(ConjugateGradient::new(vec![1.0], |_: &[f64]| Err("start")).err(), Some("start"));
        let refuse_zero = |r: &[f64]| if r[0] == 0.0 { Err("preconditioner") } else { Ok(r.to_vec()) };
        let mut iteration = ConjugateGradient::new(vec![1.0], refuse_zero).unwrap();
        assert_eq!(iteration.step(|d| Ok(d.to_vec())), Err("preconditioner"));
    }
}
