//! The sums of one face over its near faces and far clusters, several partners at once.

use crate::repulsive::faces::{FaceDatum, FaceForce, Row};
use crate::repulsive::kernel::Powers;
use crate::repulsive::options::Exponents;
use crate::spatial::LEAF_POINTS;
use eikona_numeric::{Instructions, Pack};

/// Eight partners of a leaf, number by number. Places that are left over hold partners without
/// area.
#[derive(Clone, Copy)]
pub(super) struct Block<const N: usize>(pub [[f64; LEAF_POINTS]; N]);

/// Near faces: centroid, area, then derivatives by them.
pub(super) type Near = Block<8>;

/// Far clusters: centre, area, second moments, then derivatives by them.
pub(super) type Far = Block<20>;

/// Somewhere far away, where partners without area lie. Lengths are about 1.
const AWAY: f64 = 16.0;

/// Fills blocks with the numbers of partners, and with derivatives of zero.
pub(super) fn fill<const N: usize, const M: usize>(
    blocks: &mut Vec<Block<N>>,
    partners: impl Iterator<Item = [f64; M]>,
) {
    let mut blank = Block([[0.0; LEAF_POINTS]; N]);
    blank.0[..3].fill([AWAY; LEAF_POINTS]);
    blocks.clear();
    let mut lane = LEAF_POINTS;
    for numbers in partners {
        if lane == LEAF_POINTS {
            blocks.push(blank);
            lane = 0;
        }
        if let Some(block) = blocks.last_mut() {
            (0..M).for_each(|k| block.0[k][lane] = numbers[k]);
        }
        lane += 1;
    }
}

/// Takes a partner out, and returns its numbers.
pub(super) fn take_out(blocks: &mut [Near], partner: usize) -> [f64; 8] {
    let (block, lane) = (&mut blocks[partner / LEAF_POINTS].0, partner % LEAF_POINTS);
    let numbers = std::array::from_fn(|k| block[k][lane]);
    (0..3).for_each(|k| block[k][lane] = AWAY);
    block[3][lane] = 0.0;
    numbers
}

/// Puts a partner back.
pub(super) fn put_back(blocks: &mut [Near], partner: usize, numbers: [f64; 8]) {
    let (block, lane) = (&mut blocks[partner / LEAF_POINTS].0, partner % LEAF_POINTS);
    (0..8).for_each(|k| block[k][lane] = numbers[k]);
}

pub(super) type Vector<S> = [Pack<S>; 3];

#[inline(always)]
pub(super) fn dot<S: Instructions>(a: Vector<S>, b: Vector<S>) -> Pack<S> {
    a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]))
}

/// `a x + b`
#[inline(always)]
pub(super) fn plus<S: Instructions>(a: Vector<S>, x: Pack<S>, b: Vector<S>) -> Vector<S> {
    [a[0].mul_add(x, b[0]), a[1].mul_add(x, b[1]), a[2].mul_add(x, b[2])]
}

#[inline(always)]
fn scaled<S: Instructions>(a: Vector<S>, x: Pack<S>) -> Vector<S> {
    [a[0] * x, a[1] * x, a[2] * x]
}

#[inline(always)]
fn times<S: Instructions>([xx, yy, zz, xy, xz, yz]: [Pack<S>; 6], v: Vector<S>) -> Vector<S> {
    [dot([xx, xy, xz], v), dot([xy, yy, yz], v), dot([xz, yz, zz], v)]
}

#[inline(always)]
pub(super) fn splat<S: Instructions>(simd: S, v: [f64; 3]) -> Vector<S> {
    [Pack::splat(simd, v[0]), Pack::splat(simd, v[1]), Pack::splat(simd, v[2])]
}

#[inline(always)]
pub(super) fn load<S: Instructions, const N: usize, const M: usize>(
    simd: S,
    block: &Block<N>,
    part: usize,
) -> [Pack<S>; M] {
    std::array::from_fn(
        #[inline(always)]
        |k| Pack::load(simd, &block.0[k], part),
    )
}

/// Returns the packs of blocks.
#[inline(always)]
pub(super) fn parts<S: Instructions>() -> std::ops::Range<usize> {
    0..LEAF_POINTS / Pack::<S>::LANES
}

/// Returns the sum of the kernel times the area over the near faces, and the number of faces at the
/// same centroid, which is 1 for the face itself.
#[inline(always)]
pub(super) fn near_density<S: Instructions, P: Powers>(
    simd: S,
    powers: P,
    face: &FaceDatum,
    near: &[Near],
) -> [f64; 2] {
    let (centroid, normal) = (splat(simd, face.centroid), splat(simd, face.normal));
    let mut density = Pack::splat(simd, 0.0);
    let mut same = density;
    for block in near.iter() {
        for i in parts::<S>() {
            let [x, y, z, area] = load(simd, block, i);
            let v = [centroid[0] - x, centroid[1] - y, centroid[2] - z];
            let (squared, p) = (dot(v, v), dot(normal, v));
            same = same + squared.is_zero();
            let [plane, _] = powers.plane(p * p);
            let kernel = plane * (p * p) * powers.inverse(squared.inverse_or_zero());
            density = area.mul_add(kernel, density);
        }
    }
    [density.sum(), same.sum()]
}

/// Like [`near_density`], with derivatives.
#[inline(always)]
pub(super) fn near_row<S: Instructions, P: Powers>(
    simd: S,
    exponents: Exponents,
    powers: P,
    face: &FaceDatum,
    near: &mut [Near],
) -> (Row, f64) {
    let (centroid, normal) = (splat(simd, face.centroid), splat(simd, face.normal));
    let zero = Pack::splat(simd, 0.0);
    let own_area = Pack::splat(simd, face.area);
    let (alpha, minus_beta) = (Pack::splat(simd, exponents.alpha), Pack::splat(simd, -exponents.beta));
    let (mut density, mut same) = (zero, zero);
    let (mut along, mut radial, mut tilt) = (zero, [zero; 3], [zero; 3]);
    for block in near.iter_mut() {
        for i in parts::<S>() {
            let [x, y, z, area] = load(simd, block, i);
            let v = [centroid[0] - x, centroid[1] - y, centroid[2] - z];
            let (squared, p) = (dot(v, v), dot(normal, v));
            same = same + squared.is_zero();
            let inverse = squared.inverse_or_zero();
            let [plane, _] = powers.plane(p * p);
            let half = plane * powers.inverse(inverse) * p;
            let kernel = half * p;
            density = area.mul_add(kernel, density);
            // The derivative by v is `by_p n + by_v v`.
            let (by_p, by_v) = (alpha * half, minus_beta * kernel * inverse);
            let (at_p, at_v) = (area * by_p, area * by_v);
            along = along + at_p;
            radial = plus(v, at_v, radial);
            tilt = plus(v, at_p, tilt);
            let minus = zero - own_area;
            let other = plus(normal, at_p * minus, scaled(v, at_v * minus));
            other[0].add_to(&mut block.0[4], i);
            other[1].add_to(&mut block.0[5], i);
            other[2].add_to(&mut block.0[6], i);
            (own_area * kernel).add_to(&mut block.0[7], i);
        }
    }
    let along = along.sum();
    let centroid = [0, 1, 2].map(|k| face.area * (along * face.normal[k] + radial[k].sum()));
    let normal = tilt.map(|x| face.area * x.sum());
    let density = density.sum();
    (Row { density, force: FaceForce { centroid, normal, area: density } }, same.sum())
}

/// The expansion of the kernel around the centre of a cluster: with `u = 1 / |v|^2`, `h =
/// |p|^(alpha - 2) u^(beta / 2)`, and the second moment M,
/// `sum = h (a p^2 + c2 n^T M n + c1 n^T M v + c0 v^T M v + ct tr M)`.
struct Expansion<S: Instructions> {
    v: Vector<S>,
    p: Pack<S>,
    inverse: Pack<S>,
    lower: Pack<S>,
    radial: Pack<S>,
    h: Pack<S>,
    area: Pack<S>,
    on_normal: Vector<S>,
    on_v: Vector<S>,
    /// `n^T M v`, `v^T M v` and `tr M`.
    products: [Pack<S>; 3],
    /// `c1`, `c0` and `ct`.
    factors: [Pack<S>; 3],
    /// `sum / h`
    bracket: Pack<S>,
}

/// Constants of an expansion.
#[derive(Clone, Copy)]
struct Constants<S: Instructions> {
    /// `c2 = alpha (alpha - 1) / 2`
    c2: Pack<S>,
    /// `-alpha beta`
    c1: Pack<S>,
    /// `beta (beta / 2 + 1)`
    c0: Pack<S>,
    /// `-beta / 2`
    ct: Pack<S>,
}

impl<S: Instructions> Constants<S> {
    #[inline(always)]
    fn new(simd: S, Exponents { alpha, beta }: Exponents) -> Self {
        // The derivative of `|p|^(alpha - 2)` has no bound below 3: the expansion ends before it.
        let order = if alpha < 3.0 { 0.0 } else { 1.0 };
        Constants {
            c2: Pack::splat(simd, order * 0.5 * alpha * (alpha - 1.0)),
            c1: Pack::splat(simd, order * -alpha * beta),
            c0: Pack::splat(simd, order * beta * (0.5 * beta + 1.0)),
            ct: Pack::splat(simd, order * -0.5 * beta),
        }
    }
}

impl<S: Instructions> Expansion<S> {
    #[inline(always)]
    fn new<P: Powers>(
        powers: P,
        constants: &Constants<S>,
        centroid: Vector<S>,
        normal: Vector<S>,
        [x, y, z, area, xx, yy, zz, xy, xz, yz]: [Pack<S>; 10],
    ) -> Self {
        let second = [xx, yy, zz, xy, xz, yz];
        let v = [centroid[0] - x, centroid[1] - y, centroid[2] - z];
        let (squared, p) = (dot(v, v), dot(normal, v));
        let inverse = squared.inverse_or_zero();
        let [plane, lower] = powers.plane(p * p);
        let radial = powers.inverse(inverse);
        let (on_normal, on_v) = (times(second, normal), times(second, v));
        let products = [dot(on_normal, v), dot(on_v, v), xx + yy + zz];
        let slope = p * inverse;
        let factors = [constants.c1 * slope, constants.c0 * slope * slope, constants.ct * p * slope];
        let bracket = area.mul_add(p * p, constants.c2 * dot(on_normal, normal));
        let bracket = factors[0].mul_add(products[0], bracket);
        let bracket = factors[1].mul_add(products[1], factors[2].mul_add(products[2], bracket));
        let h = plane * radial;
        Expansion { v, p, inverse, lower, radial, h, area, on_normal, on_v, products, factors, bracket }
    }
}

/// Returns the sum of the kernel times the area over the far clusters.
#[inline(always)]
pub(super) fn far_density<S: Instructions, P: Powers>(
    simd: S,
    exponents: Exponents,
    powers: P,
    face: &FaceDatum,
    far: &[Far],
) -> f64 {
    let (centroid, normal) = (splat(simd, face.centroid), splat(simd, face.normal));
    let constants = Constants::new(simd, exponents);
    let mut density = Pack::splat(simd, 0.0);
    for block in far.iter() {
        for i in parts::<S>() {
            let e = Expansion::new(powers, &constants, centroid, normal, load(simd, block, i));
            density = e.h.mul_add(e.bracket, density);
        }
    }
    density.sum()
}

/// Like [`far_density`], with derivatives.
#[inline(always)]
pub(super) fn far_row<S: Instructions, P: Powers>(
    simd: S,
    exponents: Exponents,
    powers: P,
    face: &FaceDatum,
    far: &mut [Far],
) -> Row {
    let (centroid, normal) = (splat(simd, face.centroid), splat(simd, face.normal));
    let zero = Pack::splat(simd, 0.0);
    let constants = Constants::new(simd, exponents);
    let two = Pack::splat(simd, 2.0);
    let own_area = Pack::splat(simd, face.area);
    let beta = Pack::splat(simd, exponents.beta);
    let above = Pack::splat(simd, exponents.alpha - 2.0);
    let (mut density, mut shift, mut tilt) = (zero, [zero; 3], [zero; 3]);
    for block in far.iter_mut() {
        for i in parts::<S>() {
            let e = Expansion::new(powers, &constants, centroid, normal, load(simd, block, i));
            let (n, v, u, h) = (normal, e.v, e.inverse, e.h);
            let [m1, m0, trace] = e.products;
            let [c1, c0, ct] = e.factors;
            density = h.mul_add(e.bracket, density);
            // Derivatives by p and by u of the bracket: its terms are products of powers of both.
            let slope = e.p * u;
            let by_p = two * (e.p * e.area + constants.ct * slope * trace)
                + u * (constants.c1 * m1 + two * constants.c0 * slope * m0);
            let by_u =
                e.p * (constants.c1 * m1 + two * constants.c0 * slope * m0 + constants.ct * e.p * trace);
            let by_p = h.mul_add(by_p, above * e.bracket * e.p * e.lower * e.radial);
            // du = -2 u^2 v . dv
            let by_v = zero - u * (beta * h * e.bracket + two * u * h * by_u);
            let by_v = plus(n, by_p, scaled(v, by_v));
            let (h1, h0) = (h * c1, two * h * c0);
            let by_v = plus(e.on_normal, h1, plus(e.on_v, h0, by_v));
            let by_n = plus(v, by_p, plus(e.on_v, h1, scaled(e.on_normal, two * h * constants.c2)));
            shift = [shift[0] + by_v[0], shift[1] + by_v[1], shift[2] + by_v[2]];
            tilt = [tilt[0] + by_n[0], tilt[1] + by_n[1], tilt[2] + by_n[2]];

            let weight = own_area * h;
            let minus = zero - own_area;
            (by_v[0] * minus).add_to(&mut block.0[10], i);
            (by_v[1] * minus).add_to(&mut block.0[11], i);
            (by_v[2] * minus).add_to(&mut block.0[12], i);
            (weight * e.p * e.p).add_to(&mut block.0[13], i);
            // c2 n n^T + c1 (n v^T + v n^T) / 2 + c0 v v^T + ct 1 = n w^T + v z^T, made symmetric.
            let half = Pack::splat(simd, 0.5) * c1;
            let w = plus(n, constants.c2, scaled(v, half));
            let z = plus(v, c0, scaled(n, half));
            let entry = |j: usize, k: usize| n[j].mul_add(w[k], v[j] * z[k]);
            (weight * (entry(0, 0) + ct)).add_to(&mut block.0[14], i);
            (weight * (entry(1, 1) + ct)).add_to(&mut block.0[15], i);
            (weight * (entry(2, 2) + ct)).add_to(&mut block.0[16], i);
            (weight * entry(0, 1)).add_to(&mut block.0[17], i);
            (weight * entry(0, 2)).add_to(&mut block.0[18], i);
            (weight * entry(1, 2)).add_to(&mut block.0[19], i);
        }
    }
    let density = density.sum();
    let centroid = shift.map(|x| face.area * x.sum());
    let normal = tilt.map(|x| face.area * x.sum());
    Row { density, force: FaceForce { centroid, normal, area: density } }
}
