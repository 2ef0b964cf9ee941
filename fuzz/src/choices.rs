//! Structured choices from fuzzer bytes. When the bytes run out, every choice is the first one.

use arbitrary::Unstructured;

/// A source of choices from bytes.
pub struct Choices<'a>(Unstructured<'a>);

impl<'a> Choices<'a> {
    /// Starts with all bytes.
    pub fn new(bytes: &'a [u8]) -> Self {
        Choices(Unstructured::new(bytes))
    }
    /// Returns a number from 0 to `count - 1`; 0 if `count` is 0.
    pub fn below(&mut self, count: usize) -> usize {
        self.0.int_in_range(0..=count.saturating_sub(1)).unwrap_or(0)
    }
    /// Returns one of several values.
    pub fn of<T: Copy, const N: usize>(&mut self, values: [T; N]) -> T {
        values[self.below(N)]
    }
    /// Returns a multiple of 1/255 from 0 to 1.
    pub fn share(&mut self) -> f64 {
        f64::from(self.0.arbitrary::<u8>().unwrap_or(0)) / 255.0
    }
    /// Returns a float with arbitrary bits.
    pub fn any_float(&mut self) -> f64 {
        f64::from_bits(self.0.arbitrary().unwrap_or(0))
    }
    /// Returns an ordinary float or one of the troublesome ones.
    pub fn wild_float(&mut self) -> f64 {
        match self.below(6) {
            0 | 1 => self.share(),
            2 => self.below(5) as f64 - 2.0,
            3 => self.of([f64::NAN, f64::INFINITY, -1e-320, 1e-160, 1e-9, 1e-7, 1e99, 1e155, -1e308, -0.0]),
            4 => 10f64.powi(self.below(617) as i32 - 308),
            _ => self.any_float(),
        }
    }
}
