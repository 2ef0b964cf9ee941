//! The generator for all seeded choices: xoshiro256++, seeded by SplitMix64.
//!
//! Implemented here so that a seed gives the same numbers in every release and on every machine:
//! integers and [`Random::uniform`] to the bit, [`Random::normal`] up to the last digit of the
//! platform's logarithm.
//!
//! Reference: D. Blackman and S. Vigna, "Scrambled linear pseudorandom number generators", ACM TOMS
//! 47 (2021).

/// A stream of pseudorandom numbers, determined by its seed. Not for cryptography.
///
/// ```
/// use eikona_mesh::random::Random;
/// let mut a = Random::from_seed(7);
/// let mut b = Random::from_seed(7);
/// assert_eq!(a.next_u64(), b.next_u64());
/// assert!((0.0..1.0).contains(&a.uniform()));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Random {
    state: [u64; 4],
}

/// Advances SplitMix64 by one step: spreads any seed, even 0 or 1, over 64 bits.
fn split_mix(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl Random {
    /// Creates the stream of this seed. Every seed is good.
    pub fn from_seed(seed: u64) -> Random {
        let mut s = seed;
        Random { state: std::array::from_fn(|_| split_mix(&mut s)) }
    }

    /// Returns the next 64 bits, uniformly distributed.
    pub fn next_u64(&mut self) -> u64 {
        let s = &mut self.state;
        let result = s[0].wrapping_add(s[3]).rotate_left(23).wrapping_add(s[0]);
        let t = s[1] << 17;
        s[2] ^= s[0];
        s[3] ^= s[1];
        s[1] ^= s[2];
        s[0] ^= s[3];
        s[2] ^= t;
        s[3] = s[3].rotate_left(45);
        result
    }

    /// Returns a number in `[0, 1)`, a multiple of 2^-53.
    pub fn uniform(&mut self) -> f64 {
        (self.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Returns a number between `low` (included) and `high` (excluded, up to rounding).
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Returns an integer in `0..bound`, uniformly distributed; 0 if `bound` is 0.
    pub fn below(&mut self, bound: usize) -> usize {
        let bound = bound as u64;
        if bound == 0 {
            return 0;
        }
        // Products whose low half is below 2^64 mod bound would bias the result; they are rejected.
        let surplus = bound.wrapping_neg() % bound;
        loop {
            let product = self.next_u64() as u128 * bound as u128;
            if product as u64 >= surplus {
                return (product >> 64) as usize;
            }
        }
    }

    /// Returns a normally distributed number with mean 0 and variance 1 (Marsaglia's polar method;
    /// the second number of each pair is discarded, so that the state is just four words).
    pub fn normal(&mut self) -> f64 {
        loop {
            let (x, y) = (self.range(-1.0, 1.0), self.range(-1.0, 1.0));
            let s = x * x + y * y;
            if s > 0.0 && s < 1.0 {
                return x * (-2.0 * s.ln() / s).sqrt();
            }
        }
    }

    /// Returns a point in the unit ball, uniformly distributed by volume.
    pub fn in_unit_ball(&mut self) -> [f64; 3] {
        loop {
            let p = [self.range(-1.0, 1.0), self.range(-1.0, 1.0), self.range(-1.0, 1.0)];
            if p[0] * p[0] + p[1] * p[1] + p[2] * p[2] <= 1.0 {
                return p;
            }
        }
    }

    /// Shuffles the items; all orders are equally likely.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }

    /// Chooses `count` different numbers of `0..total`, in increasing order; all of them if `count`
    /// is larger than `total`.
    pub fn choose(&mut self, count: usize, total: usize) -> Vec<usize> {
        let count = count.min(total);
        let mut all: Vec<usize> = (0..total).collect();
        for i in 0..count {
            let j = i + self.below(total - i);
            all.swap(i, j);
        }
        all.truncate(count);
        all.sort_unstable();
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn agrees_with_the_published_sequences() {
        let mut seed = 1_234_567;
        let mixed: Vec<u64> = (0..3).map(|_| split_mix(&mut seed)).collect();
        assert_eq!(mixed, [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]);
        let mut random = Random { state: [1, 2, 3, 4] };
        let words: Vec<u64> = (0..5).map(|_| random.next_u64()).collect();
        assert_eq!(
            words,
            [41_943_041, 58_720_359, 3_588_806_011_781_223, 3_591_011_842_654_386, 9_228_616_714_210_784_205]
        );
    }

    #[test]
    fn moments_are_those_of_the_distributions() {
        let mut random = Random::from_seed(0);
        let n = 200_000;
        let mut sums = [0.0; 4];
        for _ in 0..n {
            let (u, z) = (random.uniform(), random.normal());
            assert!((0.0..1.0).contains(&u));
            sums[0] += u;
            sums[1] += z;
            sums[2] += z * z;
            sums[3] += z * z * z * z;
        }
        let [u, z, z2, z4] = sums.map(|s| s / n as f64);
        assert!((u - 0.5).abs() < 0.005, "{u}");
        assert!(z.abs() < 0.01 && (z2 - 1.0).abs() < 0.02 && (z4 - 3.0).abs() < 0.15, "{z} {z2} {z4}");
    }

    #[test]
    fn bounded_numbers_are_uniform_and_choices_are_exact() {
        let mut random = Random::from_seed(3);
        let mut seen = [0usize; 6];
        for _ in 0..60_000 {
            seen[random.below(6)] += 1;
        }
        assert!(seen.iter().all(|&s| (9_500..10_500).contains(&s)), "{seen:?}");
        assert_eq!(random.below(0), 0);
        let chosen = random.choose(10, 30);
        assert_eq!(chosen.len(), 10);
        assert!(chosen.windows(2).all(|w| w[0] < w[1]) && chosen[9] < 30);
        assert_eq!(random.choose(9, 4), [0, 1, 2, 3]);
        let mut items: Vec<usize> = (0..100).collect();
        random.shuffle(&mut items);
        assert_ne!(items, (0..100).collect::<Vec<_>>());
        items.sort_unstable();
        assert_eq!(items, (0..100).collect::<Vec<_>>());
    }
}
