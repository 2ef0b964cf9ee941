//! Complex numbers.

use std::fmt;
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};

/// Complex number with two `f64` parts.
///
/// ```
/// use eikona_numeric::Complex;
/// let i = Complex { re: 0.0, im: 1.0 };
/// assert_eq!(i * i, Complex { re: -1.0, im: 0.0 });
/// assert_eq!(Complex { re: 3.0, im: 4.0 }.norm(), 5.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Complex {
    /// The real part.
    pub re: f64,
    /// The imaginary part.
    pub im: f64,
}

impl Complex {
    /// Returns the complex conjugate.
    #[inline(always)]
    pub const fn conj(self) -> Complex {
        Complex { re: self.re, im: -self.im }
    }
    /// Multiplies by a real number.
    #[inline(always)]
    pub const fn scale(self, x: f64) -> Complex {
        Complex { re: self.re * x, im: self.im * x }
    }
    /// Returns the absolute value, without overflow of its square.
    #[inline]
    pub fn norm(self) -> f64 {
        self.re.hypot(self.im)
    }
    /// Returns the square of the absolute value.
    #[inline(always)]
    pub const fn norm_sq(self) -> f64 {
        self.re * self.re + self.im * self.im
    }
    /// Returns the argument, in (-pi, pi].
    #[inline]
    pub fn arg(self) -> f64 {
        self.im.atan2(self.re)
    }
}

impl From<f64> for Complex {
    fn from(re: f64) -> Complex {
        Complex { re, im: 0.0 }
    }
}

impl Add for Complex {
    type Output = Complex;
    #[inline(always)]
    fn add(self, other: Complex) -> Complex {
        Complex { re: self.re + other.re, im: self.im + other.im }
    }
}

impl Sub for Complex {
    type Output = Complex;
    #[inline(always)]
    fn sub(self, other: Complex) -> Complex {
        Complex { re: self.re - other.re, im: self.im - other.im }
    }
}

impl Mul for Complex {
    type Output = Complex;
    #[inline(always)]
    fn mul(self, other: Complex) -> Complex {
        Complex { re: self.re * other.re - self.im * other.im, im: self.re * other.im + self.im * other.re }
    }
}

impl Mul<f64> for Complex {
    type Output = Complex;
    #[inline(always)]
    fn mul(self, x: f64) -> Complex {
        self.scale(x)
    }
}

impl Neg for Complex {
    type Output = Complex;
    #[inline(always)]
    fn neg(self) -> Complex {
        Complex { re: -self.re, im: -self.im }
    }
}

impl AddAssign for Complex {
    #[inline(always)]
    fn add_assign(&mut self, other: Complex) {
        *self = *self + other;
    }
}

impl SubAssign for Complex {
    #[inline(always)]
    fn sub_assign(&mut self, other: Complex) {
        *self = *self - other;
    }
}

impl fmt::Display for Complex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{:+}i", self.re, self.im)
    }
}

#[cfg(feature = "num-complex")]
impl From<num_complex::Complex64> for Complex {
    fn from(z: num_complex::Complex64) -> Complex {
        Complex { re: z.re, im: z.im }
    }
}

#[cfg(feature = "num-complex")]
impl From<Complex> for num_complex::Complex64 {
    fn from(z: Complex) -> num_complex::Complex64 {
        num_complex::Complex64 { re: z.re, im: z.im }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_is_that_of_complex_numbers() {
        let (a, b) = (Complex { re: 2.0, im: -3.0 }, Complex { re: 0.5, im: 4.0 });
        assert_eq!(a + b, Complex { re: 2.5, im: 1.0 });
        assert_eq!(a - b, Complex { re: 1.5, im: -7.0 });
        assert_eq!(a * b, Complex { re: 13.0, im: 6.5 });
        assert_eq!(a * a.conj(), Complex::from(a.norm_sq()));
        assert_eq!(-a * 2.0, Complex { re: -4.0, im: 6.0 });
        assert!((Complex { re: -1.0, im: 0.0 }.arg() - std::f64::consts::PI).abs() < 1e-15);
        assert!((Complex { re: 3e200, im: 4e200 }.norm() / 5e200 - 1.0).abs() < 1e-15);
        assert_eq!(format!("{a}"), "2-3i");
    }

    #[cfg(feature = "num-complex")]
    #[test]
    fn numbers_survive_the_conversion() {
        let z = Complex { re: 2.0, im: -3.0 };
        assert_eq!(Complex::from(num_complex::Complex64::from(z)), z);
    }
}
