//! Scalar types of the systems: real and complex.

use crate::complex::Complex;

/// Scalar type of a system: `f64` or [`Complex`]. Sealed: its other supertraits can not be named
/// outside of this crate.
pub trait Scalar:
    crate::kernels::Lanes
    + Backend
    + Copy
    + Send
    + Sync
    + Default
    + PartialEq
    + std::fmt::Debug
    + std::ops::Add<Output = Self>
    + std::ops::Sub<Output = Self>
    + std::ops::Mul<Output = Self>
    + std::ops::Neg<Output = Self>
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

/// The scalar types of the linear-algebra backend.
pub trait Backend: bytemuck::Pod {
    /// The type with the same bytes.
    type Raw: faer::traits::ComplexField + bytemuck::Pod;
    /// Minus one.
    const MINUS_ONE: Self::Raw;
}

impl Backend for f64 {
    type Raw = f64;
    const MINUS_ONE: f64 = -1.0;
}

impl Backend for Complex {
    type Raw = faer::c64;
    const MINUS_ONE: faer::c64 = faer::c64 { re: -1.0, im: 0.0 };
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
        Complex::conj(self)
    }
    #[inline(always)]
    fn scale(self, x: f64) -> Self {
        Complex::scale(self, x)
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
        self.norm_sq()
    }
    #[inline(always)]
    fn finite(self) -> bool {
        self.re.is_finite() && self.im.is_finite()
    }
}
