//! Kernels that process several doubles at once, for methods above this crate.

use crate::kernels;
use pulp::Simd;
use std::ops::{Add, Mul, Sub};

/// A set of instructions with vectors of doubles: those that [`vectorized`] chooses from.
pub trait Instructions: Simd {}

impl<S: Simd> Instructions for S {}

/// Work that is compiled once per instruction set. [`vectorized`] chooses the widest one that the
/// processor supports.
pub trait Vectorized {
    /// What it returns.
    type Output;
    /// Does the work. Implementations are `#[inline(always)]`, and so is what they call.
    fn run<S: Instructions>(self, simd: S) -> Self::Output;
}

/// Runs work with the widest vectors that the processor supports.
///
/// Sums in another order have other last digits, so results agree between instruction sets only up
/// to rounding. On one machine they are always the same.
///
/// ```
/// use eikona_numeric::{Instructions, Pack, Vectorized, vectorized};
/// struct Norm<'a>(&'a [f64]);
/// impl Vectorized for Norm<'_> {
///     type Output = f64;
///     #[inline(always)]
///     fn run<S: Instructions>(self, simd: S) -> f64 {
///         let zero = Pack::splat(simd, 0.0);
///         Pack::over(simd, self.0).fold(zero, |sum, x| x.mul_add(x, sum)).sum().sqrt()
///     }
/// }
/// // Any number of lanes divides a multiple of eight.
/// assert_eq!(vectorized(Norm(&[2.0, 4.0, 5.0, 6.0, 0.0, 0.0, 0.0, 0.0])), 9.0);
/// ```
pub fn vectorized<W: Vectorized>(work: W) -> W::Output {
    struct Adapter<W>(W);
    impl<W: Vectorized> kernels::Vectorized for Adapter<W> {
        type Output = W::Output;
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> W::Output {
            self.0.run(simd)
        }
    }
    kernels::dispatch_widest(Adapter(work))
}

/// The largest number of lanes of a [`Pack`].
const MOST_LANES: usize = 8;

/// Several doubles that are processed together: 2, 4 or 8, depending on the processor. Arrays have
/// a length that is a multiple of 8.
#[derive(Clone, Copy, Debug)]
pub struct Pack<S: Instructions> {
    simd: S,
    lanes: S::f64s,
}

impl<S: Instructions> Pack<S> {
    /// The number of doubles.
    pub const LANES: usize = S::F64_LANES;

    /// Returns the same number in all lanes.
    #[inline(always)]
    pub fn splat(simd: S, x: f64) -> Self {
        Pack { simd, lanes: simd.splat_f64s(x) }
    }

    /// Iterates over an array, from which a last incomplete pack is left out.
    #[inline(always)]
    pub fn over(simd: S, array: &[f64]) -> impl Iterator<Item = Self> {
        S::as_simd_f64s(array).0.iter().map(move |&lanes| Pack { simd, lanes })
    }

    /// Returns the pack at an index, in packs.
    #[inline(always)]
    pub fn load(simd: S, array: &[f64], index: usize) -> Self {
        Pack { simd, lanes: S::as_simd_f64s(array).0[index] }
    }

    /// Returns the pack at an index, in packs, of an array of single precision.
    #[inline(always)]
    pub fn load_single(simd: S, array: &[f32], index: usize) -> Self {
        let mut lanes = simd.splat_f64s(0.0);
        let numbers: &mut [f64] = bytemuck::cast_slice_mut(std::slice::from_mut(&mut lanes));
        let singles = &array[index * Self::LANES..][..Self::LANES];
        numbers.iter_mut().zip(singles).for_each(|(x, single)| *x = f64::from(*single));
        Pack { simd, lanes }
    }

    /// Writes the pack to the start of an array of single precision.
    #[inline(always)]
    pub fn store_single(self, array: &mut [f32]) {
        let numbers: &[f64] = bytemuck::cast_slice(std::slice::from_ref(&self.lanes));
        array[..Self::LANES].iter_mut().zip(numbers).for_each(|(single, x)| *single = *x as f32);
    }

    /// Adds to the pack at an index, in packs.
    #[inline(always)]
    pub fn add_to(self, array: &mut [f64], index: usize) {
        let place = &mut S::as_mut_simd_f64s(array).0[index];
        *place = self.simd.add_f64s(*place, self.lanes);
    }

    /// Returns `self * factor + summand`, in one rounding where the processor can.
    #[inline(always)]
    pub fn mul_add(self, factor: Self, summand: Self) -> Self {
        Pack { lanes: self.simd.mul_add_e_f64s(self.lanes, factor.lanes, summand.lanes), ..self }
    }

    /// Returns the inverse of each number: infinity for 0.
    #[inline(always)]
    pub fn inverse(self) -> Self {
        let lanes = self.simd.div_f64s(self.simd.splat_f64s(1.0), self.lanes);
        Pack { lanes, ..self }
    }

    /// Returns the smaller number of each lane.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Pack { lanes: self.simd.min_f64s(self.lanes, other.lanes), ..self }
    }

    /// Returns the larger number of each lane.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Pack { lanes: self.simd.max_f64s(self.lanes, other.lanes), ..self }
    }

    /// Returns the inverse of each number, and 0 for 0.
    #[inline(always)]
    pub fn inverse_or_zero(self) -> Self {
        let (simd, zero) = (self.simd, self.simd.splat_f64s(0.0));
        let inverse = simd.div_f64s(simd.splat_f64s(1.0), self.lanes);
        Pack { simd, lanes: simd.select_f64s(simd.equal_f64s(self.lanes, zero), zero, inverse) }
    }

    /// Returns `x^(-1/3)` of positive numbers of single range, to about 1e-9.
    #[inline(always)]
    pub fn inverse_cube_root(self, simd: S) -> Self {
        // A third of the exponent, and of the mantissa as an approximation of its logarithm.
        let guess = self.map(|x| f64::from(f32::from_bits(0x54a2_2000 - (x as f32).to_bits() / 3)));
        let (third, four) = (Pack::splat(simd, 1.0 / 3.0), Pack::splat(simd, 4.0));
        let scaled = self * third;
        let four_thirds = four * third;
        // Newton's method: each step squares the relative error, 0.035 at first, and doubles it.
        (0..3).fold(guess, |y, _| y * (four_thirds - scaled * (y * y * y)))
    }

    /// Returns 1 for each 0, and 0 for other numbers.
    #[inline(always)]
    pub fn is_zero(self) -> Self {
        let (simd, zero) = (self.simd, self.simd.splat_f64s(0.0));
        let lanes = simd.select_f64s(simd.equal_f64s(self.lanes, zero), simd.splat_f64s(1.0), zero);
        Pack { simd, lanes }
    }

    /// Returns a power of each number.
    #[inline(always)]
    pub fn power(self, mut exponent: u32) -> Self {
        let (mut square, mut result) = (self, Pack::splat(self.simd, 1.0));
        while exponent > 0 {
            if exponent & 1 == 1 {
                result = result * square;
            }
            square = square * square;
            exponent >>= 1;
        }
        result
    }

    /// Applies a function to each number.
    #[inline(always)]
    pub fn map(mut self, function: impl Fn(f64) -> f64) -> Self {
        let numbers: &mut [f64] = bytemuck::cast_slice_mut(std::slice::from_mut(&mut self.lanes));
        numbers.iter_mut().for_each(|x| *x = function(*x));
        self
    }

    /// Returns the sum of the lanes.
    #[inline(always)]
    pub fn sum(self) -> f64 {
        // Inlined, unlike the reduction of the library.
        let lanes: &[f64] = bytemuck::cast_slice(std::slice::from_ref(&self.lanes));
        let mut pairs = [0.0; MOST_LANES];
        pairs[..lanes.len()].copy_from_slice(lanes);
        let fours: [f64; 4] = std::array::from_fn(|k| pairs[k] + pairs[k + 4]);
        (fours[0] + fours[2]) + (fours[1] + fours[3])
    }
}

impl<S: Instructions> Add for Pack<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Pack { lanes: self.simd.add_f64s(self.lanes, other.lanes), ..self }
    }
}
impl<S: Instructions> Sub for Pack<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Pack { lanes: self.simd.sub_f64s(self.lanes, other.lanes), ..self }
    }
}
impl<S: Instructions> Mul for Pack<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Pack { lanes: self.simd.mul_f64s(self.lanes, other.lanes), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest relative error of the inverse cube root.
    struct CubeRoots<'a>(&'a [f64]);

    impl Vectorized for CubeRoots<'_> {
        type Output = f64;
        #[inline(always)]
        fn run<S: Instructions>(self, simd: S) -> f64 {
            let mut worst = 0.0f64;
            for x in self.0 {
                let root = Pack::splat(simd, *x).inverse_cube_root(simd).sum() / Pack::<S>::LANES as f64;
                worst = worst.max((root * x.cbrt() - 1.0).abs());
            }
            worst
        }
    }

    #[test]
    fn inverse_cube_roots_are_as_exact_as_they_say() {
        let numbers: Vec<f64> = (-120..120)
            .flat_map(|e| (0..50).map(move |k| 2f64.powf(f64::from(e) + f64::from(k) / 50.0)))
            .collect();
        let worst = vectorized(CubeRoots(&numbers));
        assert!(worst < 1e-9, "{worst:e}");
    }
}
