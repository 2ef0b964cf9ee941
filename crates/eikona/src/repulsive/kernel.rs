//! The powers of the tangent-point kernel, for any exponents.

use crate::repulsive::options::Exponents;
use eikona_numeric::{Instructions, Pack};

/// The powers of the kernel `K = |p|^alpha / |v|^beta`, where `p` is the distance from the tangent
/// plane.
pub(crate) trait Powers: Copy + Send + Sync {
    /// Returns `|p|^(alpha - 2)` and `|p|^(alpha - 4)` from `p^2`; where `p = 0`, the second is 0
    /// or finite.
    fn plane<S: Instructions>(self, squared: Pack<S>) -> [Pack<S>; 2];
    /// Returns `|v|^-beta` from `1 / |v|^2`.
    fn inverse<S: Instructions>(self, inverse_squared: Pack<S>) -> Pack<S>;
}

/// Work on powers that are known when it is compiled.
pub(crate) trait Kernel {
    type Output;
    fn with<P: Powers>(self, exponents: Exponents, powers: P) -> Self::Output;
}

impl Exponents {
    /// Does the work with the fastest powers for these exponents.
    pub(crate) fn with_powers<K: Kernel>(self, work: K) -> K::Output {
        let whole = |x: f64| (x.fract() == 0.0 && (0.0..64.0).contains(&x)).then_some(x as u32);
        match (whole(0.5 * self.alpha - 2.0), whole(0.5 * self.beta)) {
            (Some(1), Some(6)) => work.with(self, Sixth),
            (Some(plane), Some(inverse)) => work.with(self, Whole { plane, inverse }),
            _ => work.with(self, Real { plane: 0.5 * self.alpha - 2.0, inverse: 0.5 * self.beta }),
        }
    }
}

/// `p = 6`, the default.
#[derive(Clone, Copy)]
struct Sixth;

impl Powers for Sixth {
    #[inline(always)]
    fn plane<S: Instructions>(self, squared: Pack<S>) -> [Pack<S>; 2] {
        [squared * squared, squared]
    }
    #[inline(always)]
    fn inverse<S: Instructions>(self, x: Pack<S>) -> Pack<S> {
        let cube = x * x * x;
        cube * cube
    }
}

/// Even exponents.
#[derive(Clone, Copy)]
struct Whole {
    plane: u32,
    inverse: u32,
}

impl Powers for Whole {
    #[inline(always)]
    fn plane<S: Instructions>(self, squared: Pack<S>) -> [Pack<S>; 2] {
        let lower = squared.power(self.plane);
        [lower * squared, lower]
    }
    #[inline(always)]
    fn inverse<S: Instructions>(self, x: Pack<S>) -> Pack<S> {
        x.power(self.inverse)
    }
}

/// Any exponents, number by number.
#[derive(Clone, Copy)]
struct Real {
    plane: f64,
    inverse: f64,
}

impl Powers for Real {
    #[inline(always)]
    fn plane<S: Instructions>(self, squared: Pack<S>) -> [Pack<S>; 2] {
        let power = |x: f64| if x > 0.0 { x.powf(self.plane) } else { 0.0 };
        let lower = squared.map(power);
        [lower * squared, lower]
    }
    #[inline(always)]
    fn inverse<S: Instructions>(self, x: Pack<S>) -> Pack<S> {
        x.map(|x| x.powf(self.inverse))
    }
}
