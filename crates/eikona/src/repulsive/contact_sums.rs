//! The sums over the parts of faces in near contact, several pairs of parts at once.

use crate::geometry::vector::{add, scale, sub};
use crate::repulsive::error::RepulsiveError;
use crate::repulsive::faces::{FaceDatum, FaceForce, Row};
use crate::repulsive::kernel::{Kernel, Powers};
use crate::repulsive::leaf_sums::{Vector, dot, load, parts, plus, splat};
use crate::repulsive::near_contact::{NearContact, Parts};
use crate::repulsive::options::Exponents;
use eikona_mesh::{ElementId, Face};
use eikona_numeric::{Instructions, NumericError, Pack, Vectorized, check_stopped, for_chunks, vectorized};

type Vec3 = [f64; 3];

/// What one pair of faces contributes, per product of their areas.
#[derive(Clone, Copy, Default)]
struct PairRow {
    /// The mean of the kernel from the first face, and from the second.
    kernels: [f64; 2],
    /// Whether centroids of parts coincide.
    touches: bool,
    /// The derivatives by the normals.
    normals: [Vec3; 2],
    /// The derivatives by the corners, with normals and areas held.
    corners: [[Vec3; 3]; 2],
}

/// Pairs whose contributions are held at a time.
const BATCH: usize = 1 << 14;
/// Pairs per piece of work.
const CHUNK: usize = 16;

/// Adds what pairs in near contact contribute to the rows of the faces, and to derivatives by the
/// corners of faces. Those are left out if there is no place for them.
///
/// # Errors
/// [`RepulsiveError::Touching`], [`RepulsiveError::Numeric`].
pub(super) fn add_near_contact(
    contact: &NearContact,
    triangles: &[[Vec3; 3]],
    faces: &[FaceDatum],
    exponents: Exponents,
    threads: usize,
    rows: &mut [Row],
    mut at_corners: Option<&mut [[Vec3; 3]]>,
) -> Result<(), RepulsiveError> {
    let differential = at_corners.is_some();
    let mut found = vec![PairRow::default(); contact.pairs.len().min(BATCH)];
    for (batch, pairs) in contact.pairs.chunks(BATCH).enumerate() {
        let found = &mut found[..pairs.len()];
        for_chunks(threads, found, CHUNK, |chunk, found| {
            check_stopped()?;
            let first = batch * BATCH + chunk * CHUNK;
            exponents.with_powers(Piece { contact, triangles, faces, differential, first, found });
            Ok::<(), NumericError>(())
        })?;
        for (&[f, g], own) in pairs.iter().zip(&*found) {
            let [f, g] = [f as usize, g as usize];
            if own.touches {
                return Err(RepulsiveError::Touching { faces: [f, g].map(Face::from_index) });
            }
            for (i, face, other) in [(0, f, g), (1, g, f)] {
                let [own_area, area] = [face, other].map(|f| faces[f].area);
                rows[face].density += area * own.kernels[i];
                rows[face].force.add(&FaceForce {
                    normal: scale(own.normals[i], own_area * area),
                    area: area * (own.kernels[0] + own.kernels[1]),
                    ..FaceForce::default()
                });
                if let Some(at_corners) = &mut at_corners {
                    for (sum, own) in at_corners[face].iter_mut().zip(own.corners[i]) {
                        *sum = add(*sum, scale(own, own_area * area));
                    }
                }
            }
        }
    }
    Ok(())
}

/// Some consecutive pairs.
struct Piece<'a> {
    contact: &'a NearContact,
    triangles: &'a [[Vec3; 3]],
    faces: &'a [FaceDatum],
    differential: bool,
    first: usize,
    found: &'a mut [PairRow],
}

impl Kernel for Piece<'_> {
    type Output = ();
    fn with<P: Powers>(self, exponents: Exponents, powers: P) {
        let (contact, differential) = (self.contact, self.differential);
        for (i, found) in self.found.iter_mut().enumerate() {
            let pair = self.first + i;
            let [f, g] = contact.pairs[pair].map(|f| f as usize);
            let triangles = [self.triangles[f], self.triangles[g]];
            let normals = [self.faces[f].normal, self.faces[g].normal];
            let blocks = contact.parts(pair);
            *found = vectorized(Pair { exponents, powers, triangles, normals, blocks, differential });
        }
    }
}

/// All parts of a pair of faces.
struct Pair<'a, P> {
    exponents: Exponents,
    powers: P,
    triangles: [[Vec3; 3]; 2],
    normals: [Vec3; 2],
    blocks: &'a [Parts],
    differential: bool,
}

impl<P: Powers> Vectorized for Pair<'_, P> {
    type Output = PairRow;
    #[inline(always)]
    fn run<S: Instructions>(self, simd: S) -> PairRow {
        if self.differential { self.row(simd) } else { self.kernels(simd) }
    }
}

/// A pair of faces in vectors: the difference of the first corners, the sides from there, and the
/// normals.
struct Frame<S: Instructions> {
    between: Vector<S>,
    sides: [Vector<S>; 4],
    normals: [Vector<S>; 2],
}

impl<P: Powers> Pair<'_, P> {
    #[inline(always)]
    fn frame<S: Instructions>(&self, simd: S) -> Frame<S> {
        let [[a, b, c], [d, e, f]] = self.triangles;
        let [u, v, w, z] = [sub(b, a), sub(c, a), sub(d, e), sub(d, f)];
        Frame {
            between: splat(simd, sub(a, d)),
            sides: [splat(simd, u), splat(simd, v), splat(simd, w), splat(simd, z)],
            normals: [splat(simd, self.normals[0]), splat(simd, self.normals[1])],
        }
    }

    /// Without derivatives.
    #[inline(always)]
    fn kernels<S: Instructions>(&self, simd: S) -> PairRow {
        let frame = self.frame(simd);
        let zero = Pack::splat(simd, 0.0);
        let (mut sums, mut same) = ([zero; 2], zero);
        for block in self.blocks {
            for i in parts::<S>() {
                let (first, second, share) = points(simd, load(simd, block, i));
                for s in first {
                    let from = frame.from(s);
                    for t in second {
                        let v = frame.to(from, t);
                        let squared = dot(v, v);
                        same = same + squared.is_zero() * share;
                        let power = share * self.powers.inverse(squared.inverse_or_zero());
                        for (sum, normal) in sums.iter_mut().zip(frame.normals) {
                            let p = dot(normal, v);
                            let [plane, _] = self.powers.plane(p * p);
                            // In this order, as with derivatives: both give the same digits.
                            *sum = *sum + plane * power * p * p;
                        }
                    }
                }
            }
        }
        PairRow { kernels: sums.map(Pack::sum), touches: same.sum() > 0.0, ..PairRow::default() }
    }

    /// With derivatives.
    #[inline(always)]
    fn row<S: Instructions>(&self, simd: S) -> PairRow {
        let frame = self.frame(simd);
        let zero = Pack::splat(simd, 0.0);
        let alpha = Pack::splat(simd, self.exponents.alpha);
        let minus_beta = Pack::splat(simd, -self.exponents.beta);
        let (mut sums, mut same, mut tilts) = ([zero; 2], zero, [[zero; 3]; 2]);
        let (mut whole, mut along) = ([zero; 3], [[zero; 3]; 4]);
        for block in self.blocks {
            for i in parts::<S>() {
                let (first, second, share) = points(simd, load(simd, block, i));
                for s in first {
                    let from = frame.from(s);
                    let mut at_s = [zero; 3];
                    for t in second {
                        let v = frame.to(from, t);
                        let squared = dot(v, v);
                        same = same + squared.is_zero() * share;
                        let inverse = squared.inverse_or_zero();
                        let power = share * self.powers.inverse(inverse);
                        let (mut kernels, mut by_v) = (zero, [zero; 3]);
                        for (k, normal) in frame.normals.into_iter().enumerate() {
                            let p = dot(normal, v);
                            let [plane, _] = self.powers.plane(p * p);
                            let half = plane * power;
                            let kernel = half * p * p;
                            sums[k] = sums[k] + kernel;
                            kernels = kernels + kernel;
                            let by_p = alpha * half * p;
                            tilts[k] = plus(v, by_p, tilts[k]);
                            by_v = plus(normal, by_p, by_v);
                        }
                        let by_v = plus(v, minus_beta * kernels * inverse, by_v);
                        at_s = sum(at_s, by_v);
                        along[2] = plus(by_v, t[0], along[2]);
                        along[3] = plus(by_v, t[1], along[3]);
                    }
                    whole = sum(whole, at_s);
                    along[0] = plus(at_s, s[0], along[0]);
                    along[1] = plus(at_s, s[1], along[1]);
                }
            }
        }
        let number = |v: Vector<S>| v.map(Pack::sum);
        let [whole, a, b, c, d] =
            [number(whole), number(along[0]), number(along[1]), number(along[2]), number(along[3])];
        let corners = |a: Vec3, b: Vec3| [sub(sub(whole, a), b), a, b];
        PairRow {
            kernels: sums.map(Pack::sum),
            touches: same.sum() > 0.0,
            normals: tilts.map(number),
            corners: [corners(a, b), corners(c, d).map(|force| scale(force, -1.0))],
        }
    }
}

/// The barycentric coordinates of the three points of the quadrature, twice the first and once the
/// second. The rule is exact for polynomials of degree two.
const COORDINATES: [f64; 2] = [1.0 / 6.0, 2.0 / 3.0];

/// The points of two parts, and the share of each pair of points in the areas.
#[inline(always)]
fn points<S: Instructions>(
    simd: S,
    [a, b, s, c, d, t]: [Pack<S>; 6],
) -> ([Point<S>; 3], [Point<S>; 3], Pack<S>) {
    let share = s * s * t * t * Pack::splat(simd, 1.0 / 9.0);
    (points_of(simd, [a, b], s), points_of(simd, [c, d], t), share)
}

type Point<S> = [Pack<S>; 2];

#[inline(always)]
fn points_of<S: Instructions>(simd: S, [x, y]: Point<S>, size: Pack<S>) -> [Point<S>; 3] {
    let [near, far] = COORDINATES.map(|u| Pack::splat(simd, u));
    let ([x, x_far], [y, y_far]) =
        ([size.mul_add(near, x), size.mul_add(far, x)], [size.mul_add(near, y), size.mul_add(far, y)]);
    [[x, y], [x_far, y], [x, y_far]]
}

#[inline(always)]
fn sum<S: Instructions>(a: Vector<S>, b: Vector<S>) -> Vector<S> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

impl<S: Instructions> Frame<S> {
    /// The vector from the first corner of the second face to a point of the first one.
    #[inline(always)]
    fn from(&self, [a, b]: [Pack<S>; 2]) -> Vector<S> {
        plus(self.sides[0], a, plus(self.sides[1], b, self.between))
    }

    /// The vector from a point of the second face.
    #[inline(always)]
    fn to(&self, from: Vector<S>, [c, d]: [Pack<S>; 2]) -> Vector<S> {
        plus(self.sides[2], c, plus(self.sides[3], d, from))
    }
}
