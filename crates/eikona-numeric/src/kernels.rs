//! Dense SIMD kernels for small fronts. Most fronts are ten to sixty rows high, where calling a
//! general matrix product costs more than the product.
//!
//! Blocks are stored by columns. Complex columns are read as pairs of doubles, so that two real
//! fused multiply-adds per vector do one complex one; real and imaginary parts are combined once,
//! at the end of a sum.

use pulp::Simd;
use std::ops::Range;

/// Scalar types that can be processed in vectors of doubles.
///
/// Supertrait of [`Scalar`](crate::Scalar). It cannot be named outside this crate, so nobody else
/// can implement `Scalar`.
pub trait Lanes: bytemuck::Pod {
    /// Doubles per number.
    const PARTS: usize;
    /// Vectors accumulated side by side in [`eliminate_columns`]: as many as the registers hold.
    const VECTORS: usize;
    /// Accumulator for a sum of products, not yet combined.
    type Sum<S: Simd>: Copy;
    /// Returns the empty sum.
    fn zero_sum<S: Simd>(simd: S) -> Self::Sum<S>;
    /// `sum + x conj(factor)`
    fn add_product<S: Simd>(simd: S, sum: Self::Sum<S>, x: S::f64s, factor: Self) -> Self::Sum<S>;
    /// Combines a sum of products into its value.
    fn products<S: Simd>(simd: S, sum: Self::Sum<S>) -> S::f64s;
    /// `sum + conj(x) y`, elementwise.
    fn add_dot<S: Simd>(simd: S, sum: Self::Sum<S>, x: S::f64s, y: S::f64s) -> Self::Sum<S>;
    /// Combines a sum into the value of an inner product.
    fn dot<S: Simd>(simd: S, sum: Self::Sum<S>) -> Self;
}

impl Lanes for f64 {
    const PARTS: usize = 1;
    const VECTORS: usize = 2;
    type Sum<S: Simd> = S::f64s;
    #[inline(always)]
    fn zero_sum<S: Simd>(simd: S) -> S::f64s {
        simd.splat_f64s(0.0)
    }
    #[inline(always)]
    fn add_product<S: Simd>(simd: S, sum: S::f64s, x: S::f64s, factor: f64) -> S::f64s {
        simd.mul_add_e_f64s(x, simd.splat_f64s(factor), sum)
    }
    #[inline(always)]
    fn products<S: Simd>(_: S, sum: S::f64s) -> S::f64s {
        sum
    }
    #[inline(always)]
    fn add_dot<S: Simd>(simd: S, sum: S::f64s, x: S::f64s, y: S::f64s) -> S::f64s {
        simd.mul_add_e_f64s(x, y, sum)
    }
    #[inline(always)]
    fn dot<S: Simd>(simd: S, sum: S::f64s) -> f64 {
        simd.reduce_sum_f64s(sum)
    }
}

impl Lanes for crate::Complex {
    const PARTS: usize = 2;
    const VECTORS: usize = 1;
    /// Products with the real parts of the factors, and with the imaginary parts.
    type Sum<S: Simd> = (S::f64s, S::f64s);
    #[inline(always)]
    fn zero_sum<S: Simd>(simd: S) -> Self::Sum<S> {
        (simd.splat_f64s(0.0), simd.splat_f64s(0.0))
    }
    #[inline(always)]
    fn add_product<S: Simd>(simd: S, sum: Self::Sum<S>, x: S::f64s, factor: Self) -> Self::Sum<S> {
        let real = simd.mul_add_e_f64s(x, simd.splat_f64s(factor.re), sum.0);
        (real, simd.mul_add_e_f64s(x, simd.splat_f64s(factor.im), sum.1))
    }
    #[inline(always)]
    fn products<S: Simd>(simd: S, sum: Self::Sum<S>) -> S::f64s {
        // x (re - i im): -i (a + i b) = b - i a.
        let turned: S::c64s = simd.conj_c64s(swapped(simd, sum.1));
        simd.add_f64s(sum.0, bytemuck::cast(turned))
    }
    #[inline(always)]
    fn add_dot<S: Simd>(simd: S, sum: Self::Sum<S>, x: S::f64s, y: S::f64s) -> Self::Sum<S> {
        let crossed = bytemuck::cast(swapped(simd, y));
        (simd.mul_add_e_f64s(x, y, sum.0), simd.mul_add_e_f64s(x, crossed, sum.1))
    }
    #[inline(always)]
    fn dot<S: Simd>(simd: S, sum: Self::Sum<S>) -> Self {
        // `sum.0` holds re re and im im; `sum.1` alternates re im and im re.
        let crossed: S::c64s = simd.conj_c64s(bytemuck::cast(sum.1));
        crate::Complex { re: simd.reduce_sum_f64s(sum.0), im: simd.reduce_sum_f64s(bytemuck::cast(crossed)) }
    }
}

#[inline(always)]
fn swapped<S: Simd>(simd: S, x: S::f64s) -> S::c64s {
    simd.swap_re_im_c64s(bytemuck::cast(x))
}

/// Work compiled once per vector width; the widest that the processor supports is chosen at run
/// time.
pub(crate) trait Vectorized {
    type Output;
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// Runs work with vectors of at most four doubles: wider ones gain nothing on fronts of some tens
/// of rows.
pub(crate) fn dispatch<W: Vectorized>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if let Some(four) = pulp::x86::V3::try_new() {
        return pulp::Simd::vectorize(four, Adapter(work));
    }
    dispatch_widest(work)
}

/// Runs work with the widest vectors.
pub(crate) fn dispatch_widest<W: Vectorized>(work: W) -> W::Output {
    pulp::Arch::new().dispatch(Adapter(work))
}

struct Adapter<W>(W);

impl<W: Vectorized> pulp::WithSimd for Adapter<W> {
    type Output = W::Output;
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> W::Output {
        // A complex number takes two doubles. (Processors without vectors, which are rare, emulate
        // them: slow but correct.)
        if S::F64_LANES < 2 { self.0.run(pulp::Scalar128b) } else { self.0.run(simd) }
    }
}

/// Numbers per vector.
#[inline(always)]
const fn numbers<S: Simd, T: Lanes>() -> usize {
    S::F64_LANES / T::PARTS
}

#[inline(always)]
fn vectors<S: Simd, T: Lanes>(numbers: &[T]) -> &[S::f64s] {
    S::as_simd_f64s(bytemuck::cast_slice(numbers)).0
}

#[inline(always)]
fn vectors_mut<S: Simd, T: Lanes>(numbers: &mut [T]) -> &mut [S::f64s] {
    S::as_mut_simd_f64s(bytemuck::cast_slice_mut(numbers)).0
}

/// Calls a kernel for four columns at a time, and once for the remaining one to three. The number
/// of columns is a compile-time constant in each call.
macro_rules! in_fours {
    ($columns:expr, |$first:ident, $count:ident| $call:expr) => {{
        let columns: Range<usize> = $columns;
        let mut $first = columns.start;
        while $first + 4 <= columns.end {
            const $count: usize = 4;
            $call;
            $first += 4;
        }
        match columns.end - $first {
            3 => {
                const $count: usize = 3;
                $call;
            }
            2 => {
                const $count: usize = 2;
                $call;
            }
            1 => {
                const $count: usize = 1;
                $call;
            }
            _ => {}
        }
    }};
}

/// Block of columns of equal height.
#[derive(Clone, Copy)]
struct Block<'a, T> {
    values: &'a [T],
    height: usize,
}

impl<T: crate::Scalar> Block<'_, T> {
    /// Computes a tile of `A A^H` by columns: the sum over the columns of `row.. x conj(right..)`.
    #[inline(always)]
    fn tile<S: Simd, const VECTORS: usize, const COLUMNS: usize>(
        self,
        simd: S,
        columns: Range<usize>,
        row: usize,
        right: usize,
    ) -> [[T::Sum<S>; VECTORS]; COLUMNS] {
        let mut sums = [[T::zero_sum(simd); VECTORS]; COLUMNS];
        for k in columns {
            let column = &self.values[k * self.height..(k + 1) * self.height];
            let x = vectors::<S, T>(&column[row..row + VECTORS * numbers::<S, T>()]);
            let factors = &column[right..right + COLUMNS];
            for c in 0..COLUMNS {
                for v in 0..VECTORS {
                    sums[c][v] = T::add_product(simd, sums[c][v], x[v], factors[c]);
                }
            }
        }
        sums
    }

    /// Computes one entry of `A A^H`.
    #[inline(always)]
    fn entry(self, columns: Range<usize>, row: usize, right: usize) -> T {
        let mut sum = T::ZERO;
        for k in columns {
            sum += self.values[k * self.height + row] * self.values[k * self.height + right].conj();
        }
        sum
    }
}

/// Computes the lower triangle of `target <- -A A^H`, where `A` is the part of the panel below its
/// `width` columns. Also overwrites some entries above the diagonal.
#[inline(always)]
pub(crate) fn minus_outer_product<S: Simd, T: crate::Scalar>(
    simd: S,
    panel: &[T],
    width: usize,
    height: usize,
    target: &mut [T],
) {
    let size = height - width;
    let panel = Block { values: panel, height };
    in_fours!(0..size, |column, COLUMNS| {
        minus_outer_columns::<S, T, COLUMNS>(simd, panel, width, column, target)
    });
}

#[inline(always)]
fn minus_outer_columns<S: Simd, T: crate::Scalar, const COLUMNS: usize>(
    simd: S,
    panel: Block<'_, T>,
    width: usize,
    first: usize,
    target: &mut [T],
) {
    let size = panel.height - width;
    let lanes = numbers::<S, T>();
    let right = width + first;
    if size - first < lanes {
        for c in 0..COLUMNS {
            for row in first + c..size {
                target[(first + c) * size + row] = -panel.entry(0..width, width + row, right + c);
            }
        }
        return;
    }
    let mut row = first;
    while row < size {
        if T::VECTORS == 2 && row + 2 * lanes <= size {
            let sums = panel.tile::<S, 2, COLUMNS>(simd, 0..width, width + row, right);
            for (c, sums) in sums.into_iter().enumerate() {
                let target = &mut target[(first + c) * size + row..][..2 * lanes];
                let target = vectors_mut::<S, T>(target);
                target[0] = simd.neg_f64s(T::products(simd, sums[0]));
                target[1] = simd.neg_f64s(T::products(simd, sums[1]));
            }
            row += 2 * lanes;
            continue;
        }
        // Overlapping the last tile is cheaper than computing its rows one by one.
        let at = row.min(size - lanes);
        let sums = panel.tile::<S, 1, COLUMNS>(simd, 0..width, width + at, right);
        for (c, [sum]) in sums.into_iter().enumerate() {
            let target = &mut target[(first + c) * size + at..][..lanes];
            vectors_mut::<S, T>(target)[0] = simd.neg_f64s(T::products(simd, sum));
        }
        row += lanes;
    }
}

/// Cholesky factorisation of columns `columns` of a panel, over all rows. Contributions of earlier
/// columns must have been subtracted. Entries below `negligible` are set to zero. On failure,
/// returns the column.
#[inline(always)]
pub(crate) fn eliminate_columns<S: Simd, T: crate::Scalar>(
    simd: S,
    panel: &mut [T],
    columns: Range<usize>,
    height: usize,
    negligible: f64,
) -> Result<(), usize> {
    in_fours!(columns.clone(), |column, COLUMNS| {
        eliminate_some::<S, T, COLUMNS>(simd, panel, columns.start, column, height, negligible)?
    });
    Ok(())
}

/// Eliminates `COLUMNS` columns from `first` on; columns `start..first` are done.
#[inline(always)]
fn eliminate_some<S: Simd, T: crate::Scalar, const COLUMNS: usize>(
    simd: S,
    panel: &mut [T],
    start: usize,
    first: usize,
    height: usize,
    negligible: f64,
) -> Result<(), usize> {
    let (done, rest) = panel.split_at_mut(first * height);
    let done = Block { values: done, height };
    let rest = &mut rest[..COLUMNS * height];
    // Diagonal block.
    let mut lower = [[T::ZERO; COLUMNS]; COLUMNS];
    let mut inverse = [0.0; COLUMNS];
    for c in 0..COLUMNS {
        for r in c..COLUMNS {
            let mut value = rest[c * height + first + r] - done.entry(start..first, first + r, first + c);
            for d in 0..c {
                value -= lower[d][r] * lower[d][c].conj();
            }
            if r == c {
                let pivot = value.real_part();
                if pivot.is_nan() || pivot <= 0.0 {
                    return Err(first + c);
                }
                let root = pivot.sqrt();
                inverse[c] = 1.0 / root;
                value = T::real(root);
            } else {
                value = flushed(value.scale(inverse[c]), negligible);
            }
            lower[c][r] = value;
            rest[c * height + first + r] = value;
        }
    }
    // Rows below the diagonal block.
    let lanes = numbers::<S, T>();
    let threshold = simd.splat_f64s(negligible);
    let scales = inverse.map(|x| simd.splat_f64s(x));
    let mut row = first + COLUMNS;
    macro_rules! rows {
        ($vectors:literal) => {{
            let sums = done.tile::<S, $vectors, COLUMNS>(simd, start..first, row, first);
            for v in 0..$vectors {
                let at = row + v * lanes;
                let mut solved = [simd.splat_f64s(0.0); COLUMNS];
                for c in 0..COLUMNS {
                    let mut sum = sums[c][v];
                    for d in 0..c {
                        sum = T::add_product(simd, sum, solved[d], lower[d][c]);
                    }
                    let target = &mut vectors_mut::<S, T>(&mut rest[c * height + at..][..lanes])[0];
                    let value = simd.mul_f64s(simd.sub_f64s(*target, T::products(simd, sum)), scales[c]);
                    let small = simd.less_than_f64s(simd.abs_f64s(value), threshold);
                    solved[c] = simd.select_f64s(small, simd.splat_f64s(0.0), value);
                    *target = solved[c];
                }
            }
            row += $vectors * lanes;
        }};
    }
    if T::VECTORS == 2 {
        while row + 2 * lanes <= height {
            rows!(2);
        }
    }
    while row + lanes <= height {
        rows!(1);
    }
    for row in row..height {
        let mut solved = [T::ZERO; COLUMNS];
        for c in 0..COLUMNS {
            let mut value = rest[c * height + row] - done.entry(start..first, row, first + c);
            for d in 0..c {
                value -= solved[d] * lower[d][c].conj();
            }
            solved[c] = flushed(value.scale(inverse[c]), negligible);
            rest[c * height + row] = solved[c];
        }
    }
    Ok(())
}

#[inline(always)]
fn flushed<T: crate::Scalar>(value: T, negligible: f64) -> T {
    if value.max_part() < negligible { T::ZERO } else { value }
}

/// Forward sweep of one panel: `x <- L^-1 x` for the first `width` numbers of `x`, then `x <- x - L
/// x` with the result for those below.
#[inline(always)]
pub(crate) fn forward<S: Simd, T: crate::Scalar>(simd: S, panel: &[T], width: usize, x: &mut [T]) {
    in_fours!(0..width, |column, COLUMNS| forward_some::<S, T, COLUMNS>(simd, panel, column, x));
}

#[inline(always)]
fn forward_some<S: Simd, T: crate::Scalar, const COLUMNS: usize>(
    simd: S,
    panel: &[T],
    first: usize,
    x: &mut [T],
) {
    let height = x.len();
    let columns: [&[T]; COLUMNS] =
        std::array::from_fn(|c| &panel[(first + c) * height + first..][..height - first]);
    let (known, below) = x[first..].split_at_mut(COLUMNS);
    let mut factors = [T::ZERO; COLUMNS];
    for c in 0..COLUMNS {
        let mut value = known[c];
        for d in 0..c {
            value -= columns[d][c] * known[d];
        }
        known[c] = value.scale(1.0 / columns[c][c].real_part());
        factors[c] = known[c].conj();
    }
    let columns = columns.map(|column| &column[COLUMNS..]);
    let whole = below.len() - below.len() % numbers::<S, T>();
    let count = whole / numbers::<S, T>();
    let wide = columns.map(|column| &vectors::<S, T>(&column[..whole])[..count]);
    let targets = &mut vectors_mut::<S, T>(&mut below[..whole])[..count];
    for (i, target) in targets.iter_mut().enumerate() {
        let mut sum = T::zero_sum(simd);
        for c in 0..COLUMNS {
            sum = T::add_product(simd, sum, wide[c][i], factors[c]);
        }
        *target = simd.sub_f64s(*target, T::products(simd, sum));
    }
    for (i, target) in below.iter_mut().enumerate().skip(whole) {
        for c in 0..COLUMNS {
            *target -= columns[c][i] * known[c];
        }
    }
}

/// Backward sweep of one panel: `x <- L^-H x` for the first `width` numbers of `x`, given those
/// below.
#[inline(always)]
pub(crate) fn backward<S: Simd, T: crate::Scalar>(simd: S, panel: &[T], width: usize, x: &mut [T]) {
    let mut end = width;
    match width % 4 {
        3 => backward_some::<S, T, 3>(simd, panel, width - 3, x),
        2 => backward_some::<S, T, 2>(simd, panel, width - 2, x),
        1 => backward_some::<S, T, 1>(simd, panel, width - 1, x),
        _ => {}
    }
    end -= width % 4;
    while end > 0 {
        end -= 4;
        backward_some::<S, T, 4>(simd, panel, end, x);
    }
}

#[inline(always)]
fn backward_some<S: Simd, T: crate::Scalar, const COLUMNS: usize>(
    simd: S,
    panel: &[T],
    first: usize,
    x: &mut [T],
) {
    let height = x.len();
    let columns: [&[T]; COLUMNS] =
        std::array::from_fn(|c| &panel[(first + c) * height + first..][..height - first]);
    let (unknown, below) = x[first..].split_at_mut(COLUMNS);
    let whole = below.len() - below.len() % numbers::<S, T>();
    let count = whole / numbers::<S, T>();
    let wide = columns.map(|column| &vectors::<S, T>(&column[COLUMNS..][..whole])[..count]);
    let mut sums = [T::zero_sum(simd); COLUMNS];
    for (i, &y) in vectors::<S, T>(&below[..whole])[..count].iter().enumerate() {
        for c in 0..COLUMNS {
            sums[c] = T::add_dot(simd, sums[c], wide[c][i], y);
        }
    }
    for c in (0..COLUMNS).rev() {
        let mut sum = T::dot(simd, sums[c]);
        for (i, &y) in below.iter().enumerate().skip(whole) {
            sum += columns[c][COLUMNS + i].conj() * y;
        }
        for d in c + 1..COLUMNS {
            sum += columns[c][d].conj() * unknown[d];
        }
        unknown[c] = (unknown[c] - sum).scale(1.0 / columns[c][c].real_part());
    }
}
