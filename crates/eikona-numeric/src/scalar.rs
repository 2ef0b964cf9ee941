//! Scalar types of the systems: real and complex.

/// Complex number with two `f64` parts.
pub type Complex = faer::c64;

/// Scalar type of a system: `f64` or [`Complex`]. Not meant to be implemented elsewhere.
pub trait Scalar:
    faer::traits::ComplexField<Real = f64>
    + crate::kernels::Lanes
    + Copy
    + Default
    + PartialEq
    + std::fmt::Debug
    + std::ops::Add<Output = Self>
    + std::ops::Sub<Output = Self>
    + std::ops::Mul<Output = Self>
    + std::ops::AddAssign
    + std::ops::SubAssign
{
    /// Zero.
    const ZERO: Self;
    /// Converts a real number.
    fn real(x: f64) -> Self;
    /// Returns the complex conjugate.
    fn conj(self) -> Self;
    /// Multiplies by a real number.
    fn scale(self, x: f64) -> Self;
    /// Returns the real part.
    fn real_part(self) -> f64;
    /// Returns the larger absolute value of the real and imaginary parts.
    fn max_part(self) -> f64;
    /// Returns the squared absolute value.
    fn abs_sq(self) -> f64;
    /// Returns whether every part is finite.
    fn finite(self) -> bool;
}

impl Scalar for f64 {
    const ZERO: Self = 0.0;
    #[inline(always)]
    fn real(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn conj(self) -> Self {
        self
    }
    #[inline(always)]
    fn scale(self, x: f64) -> Self {
        self * x
    }
    #[inline(always)]
    fn real_part(self) -> f64 {
        self
    }
    #[inline(always)]
    fn max_part(self) -> f64 {
        self.abs()
    }
    #[inline(always)]
    fn abs_sq(self) -> f64 {
        self * self
    }
    #[inline(always)]
    fn finite(self) -> bool {
        self.is_finite()
    }
}

impl Scalar for Complex {
    const ZERO: Self = Complex { re: 0.0, im: 0.0 };
    #[inline(always)]
    fn real(x: f64) -> Self {
        Complex { re: x, im: 0.0 }
    }
    #[inline(always)]
    fn conj(self) -> Self {
        Complex { re: self.re, im: -self.im }
    }
    #[inline(always)]
    fn scale(self, x: f64) -> Self {
        Complex { re: self.re * x, im: self.im * x }
    }
    #[inline(always)]
    fn real_part(self) -> f64 {
        self.re
    }
    #[inline(always)]
    fn max_part(self) -> f64 {
        self.re.abs().max(self.im.abs())
    }
    #[inline(always)]
    fn abs_sq(self) -> f64 {
        self.re * self.re + self.im * self.im
    }
    #[inline(always)]
    fn finite(self) -> bool {
        self.re.is_finite() && self.im.is_finite()
    }
}
