//! Near contact: pairs of faces that are close relative to their size, and their subdivision for
//! adaptive quadrature.
//!
//! Between such faces the midpoint rule is off by any factor: the closest points may lie anywhere
//! between the centroids. So both triangles are split in four, again and again, until they are
//! small relative to their distance, and the parts are integrated by a rule of degree two. Its
//! points are linear in the corners, and parts keep the normals of their faces; so the sum over
//! them, with the subdivision held, is as smooth as before.
//!
//! Deviation: the paper has none of this. Repulsive Shells uses the midpoint rule on the parts,
//! which is still 1 to 2 % off with parts of a third of the size.
//!
//! **Reference.** Josua Sassen, Henrik Schumacher, Martin Rumpf and Keenan Crane, *Repulsive
//! Shells*, ACM Transactions on Graphics 43 (4), 2024.

use crate::geometry::vector::{add, cross, dot, norm, scale, sub};
use crate::repulsive::error::RepulsiveError;
use crate::repulsive::leaf_sums::Block;
use crate::spatial::{Ball, ClosePairs, LEAF_POINTS, close_pairs, triangle_distance, triangles_intersect};
use eikona_mesh::{ElementId, Face};
use eikona_numeric::{NumericError, check_step, check_stopped, for_chunks};

type Vec3 = [f64; 3];

/// Eight pairs of parts: where both lie and their sizes, see [`Part`].
pub(super) type Parts = Block<6>;

/// Parts may be larger by this factor, since their rule is exact for polynomials of degree two.
const PARTS: f64 = 2.0;
/// Triangles that lie side by side, as those of one smooth sheet do, are not split: there the
/// kernel is below this share of its value for triangles that face each other at the same distance.
const LEAST_SHARE: f64 = 0.1;
/// A face is split at most this often: its parts are no smaller than a millionth of it.
const MOST_SPLITS: usize = 20;
/// There are at most this many pairs of parts, 48 bytes each, and so many more per face.
const MOST_PARTS: usize = 1 << 20;
const MOST_PARTS_PER_FACE: usize = 32;

/// All pairs of faces in near contact, with their subdivision.
#[derive(Clone, Default)]
pub(crate) struct NearContact {
    /// In increasing order.
    pub pairs: Vec<[u32; 2]>,
    /// The parts of all pairs.
    parts: Vec<Parts>,
    /// Where those of each pair begin, and where the last ones end.
    starts: Vec<usize>,
    partners: Vec<u32>,
    /// Where those of each face begin, and where the last ones end; empty if there are no pairs.
    first_partners: Vec<usize>,
}

impl NearContact {
    /// Finds the pairs, and subdivides them.
    ///
    /// # Errors
    /// [`RepulsiveError::NearContact`] if there are too many pairs, [`RepulsiveError::Numeric`].
    pub fn new(
        faces: &[[u32; 3]],
        triangles: &[[Vec3; 3]],
        separation: f64,
        alpha: f64,
        threads: usize,
    ) -> Result<NearContact, RepulsiveError> {
        let most = MOST_PARTS + MOST_PARTS_PER_FACE * faces.len();
        let normals: Vec<Vec3> = triangles.iter().map(|corners| normal_of(*corners)).collect();
        let balls: Vec<Ball> = triangles.iter().map(|corners| Ball::of(*corners)).collect();
        let whole = Criterion { separation, slope: LEAST_SHARE.powf(1.0 / alpha) };
        let close = |f: usize, g: usize| {
            let apart = !faces[f].iter().any(|v| faces[g].contains(v));
            let (triangles, normals, balls) =
                ([f, g].map(|f| triangles[f]), [f, g].map(|f| normals[f]), [f, g].map(|f| balls[f]));
            apart && whole.too_large(triangles, normals, balls) != [false; 2]
        };
        let ClosePairs { pairs, count } = close_pairs(triangles, separation, close, most, threads)?;
        if count > most {
            let faces = pairs[0].map(|f| Face::from_index(f as usize));
            return Err(RepulsiveError::NearContact { pairs: most, faces });
        }
        if pairs.is_empty() {
            return Ok(NearContact::default());
        }
        let criterion = Criterion { separation: PARTS * separation, ..whole };
        let work = Subdivision { pairs: &pairs, triangles, normals: &normals, criterion, most, threads };
        let (parts, starts) = grouped(&work.run()?, pairs.len())?;
        let (partners, first_partners) = partners_of(&pairs, faces.len());
        Ok(NearContact { pairs, parts, starts, partners, first_partners })
    }

    /// The parts of a pair. Lanes that are left over hold parts without area.
    pub fn parts(&self, pair: usize) -> &[Parts] {
        &self.parts[self.starts[pair]..self.starts[pair + 1]]
    }

    /// The faces in near contact with a face, in increasing order.
    pub fn partners(&self, face: usize) -> &[u32] {
        match self.first_partners.get(face..=face + 1) {
            Some(bounds) => &self.partners[bounds[0]..bounds[1]],
            None => &[],
        }
    }
}

/// A part of a triangle, scaled by `size` and moved to `at` in coordinates along the sides from the
/// first corner. Middle parts are upside down: their size is negative.
#[derive(Clone, Copy)]
struct Part {
    at: [f64; 2],
    size: f64,
}

impl Part {
    const WHOLE: Part = Part { at: [0.0; 2], size: 1.0 };

    fn quarters(self) -> [Part; 4] {
        let ([x, y], half) = (self.at, 0.5 * self.size);
        [
            Part { at: [x, y], size: half },
            Part { at: [x + half, y], size: half },
            Part { at: [x, y + half], size: half },
            Part { at: [x + half, y + half], size: -half },
        ]
    }

    fn centroid(self) -> [f64; 2] {
        self.at.map(|x| x + self.size / 3.0)
    }

    fn corners(self, [a, b, c]: [Vec3; 3]) -> [Vec3; 3] {
        let (u, v) = (sub(b, a), sub(c, a));
        let first = add(a, add(scale(u, self.at[0]), scale(v, self.at[1])));
        [first, add(first, scale(u, self.size)), add(first, scale(v, self.size))]
    }
}

#[derive(Clone, Copy)]
struct PairOfParts {
    pair: u32,
    parts: [Part; 2],
}

impl PairOfParts {
    /// Splits some of the two in four.
    fn split(self, [first, second]: [bool; 2], mut visit: impl FnMut(PairOfParts)) {
        let (quarters, whole) = (self.parts.map(Part::quarters), self.parts.map(|part| [part]));
        for s in if first { &quarters[0][..] } else { &whole[0][..] } {
            for t in if second { &quarters[1][..] } else { &whole[1][..] } {
                visit(PairOfParts { pair: self.pair, parts: [*s, *t] });
            }
        }
    }
}

struct Subdivision<'a> {
    pairs: &'a [[u32; 2]],
    triangles: &'a [[Vec3; 3]],
    normals: &'a [Vec3],
    criterion: Criterion,
    most: usize,
    threads: usize,
}

impl Subdivision<'_> {
    /// Splits all pairs once before any is split twice. Stops before there are too many parts.
    fn run(&self) -> Result<Vec<PairOfParts>, NumericError> {
        let whole = |pair: usize| PairOfParts { pair: pair as u32, parts: [Part::WHOLE; 2] };
        let mut current: Vec<PairOfParts> = (0..self.pairs.len()).map(whole).collect();
        let mut done = Vec::new();
        for _ in 0..MOST_SPLITS {
            let splits = self.splits(&current)?;
            let children =
                |split: &[bool; 2]| split.iter().map(|own| if *own { 4 } else { 1 }).product::<usize>();
            if current.is_empty() || done.len() + splits.iter().map(children).sum::<usize>() > self.most {
                break;
            }
            let mut next = Vec::new();
            for (step, (own, split)) in current.iter().zip(splits).enumerate() {
                check_step(step)?;
                match split {
                    [false, false] => done.push(*own),
                    split => own.split(split, |child| next.push(child)),
                }
            }
            current = next;
        }
        done.extend(current);
        Ok(done)
    }

    /// Which parts of each pair are too large for their distance.
    fn splits(&self, current: &[PairOfParts]) -> Result<Vec<[bool; 2]>, NumericError> {
        const CHUNK: usize = 256;
        let mut splits = vec![[false; 2]; current.len()];
        for_chunks(self.threads, &mut splits, CHUNK, |chunk, splits| {
            check_stopped()?;
            splits
                .iter_mut()
                .zip(&current[chunk * CHUNK..])
                .for_each(|(split, own)| *split = self.split(own));
            Ok::<(), NumericError>(())
        })?;
        Ok(splits)
    }

    fn split(&self, PairOfParts { pair, parts: [s, t] }: &PairOfParts) -> [bool; 2] {
        let [f, g] = self.pairs[*pair as usize].map(|f| f as usize);
        let triangles = [s.corners(self.triangles[f]), t.corners(self.triangles[g])];
        self.criterion.too_large(triangles, [self.normals[f], self.normals[g]], triangles.map(Ball::of))
    }
}

/// Which triangles are too large for their distance.
#[derive(Clone, Copy)]
struct Criterion {
    /// The largest share of radius and distance.
    separation: f64,
    /// Triangles lie side by side if each sees the other at no more than this sine from its plane.
    slope: f64,
}

impl Criterion {
    /// None is if they lie side by side.
    fn too_large(&self, [s, t]: [[Vec3; 3]; 2], normals: [Vec3; 2], balls: [Ball; 2]) -> [bool; 2] {
        let at = |distance: f64| balls.map(|ball| ball.radius > self.separation * distance);
        let least = balls[0].gap(&balls[1]).max(0.0);
        if at(least) == [false; 2] {
            return [false; 2];
        }
        // The distance is at least that along any direction.
        let between = sub(balls[1].centre, balls[0].centre);
        let apart = norm(between);
        let direction = scale(between, 1.0 / apart);
        let ([above, below], [up, down]) =
            (heights([s, t], normals), [s, t].map(|corners| corners.map(|p| dot(p, direction))));
        let (start, end) = (largest(up), -largest(down.map(|x| -x)));
        // Ratios of linear functions are largest at corners.
        let is_low = |height: f64, away: f64| height.abs() <= self.slope * away;
        let low_above = above.iter().zip(down).all(|(height, along)| is_low(*height, along - start));
        let low_below = below.iter().zip(up).all(|(height, along)| is_low(*height, end - along));
        let least = least.max(end - start).max(clearance(above)).max(clearance(below));
        let decided = at(least);
        if (low_above && low_below) || decided == [false; 2] {
            return [false; 2];
        }
        if decided == at(apart) {
            return decided;
        }
        let may_cross = clearance(above) == 0.0 && clearance(below) == 0.0;
        let distance = if may_cross && triangles_intersect(s, t) { 0.0 } else { triangle_distance(s, t) };
        let height = largest(above.map(f64::abs)).max(largest(below.map(f64::abs)));
        if is_low(height, distance) { [false; 2] } else { at(distance) }
    }
}

/// The heights of the corners of each triangle above the plane of the other, first those of the
/// second.
fn heights([s, t]: [[Vec3; 3]; 2], normals: [Vec3; 2]) -> [[f64; 3]; 2] {
    [t.map(|p| dot(sub(p, s[0]), normals[0])), s.map(|p| dot(sub(p, t[0]), normals[1]))]
}

fn largest([a, b, c]: [f64; 3]) -> f64 {
    a.max(b).max(c)
}

/// The distance of a triangle from a plane, by the heights of its corners.
fn clearance(heights: [f64; 3]) -> f64 {
    (-largest(heights.map(|x| -x))).max(-largest(heights)).max(0.0)
}

fn normal_of([a, b, c]: [Vec3; 3]) -> Vec3 {
    let doubled = cross(sub(b, a), sub(c, a));
    scale(doubled, 1.0 / norm(doubled))
}

/// Sorts parts by pair, into blocks.
fn grouped(parts: &[PairOfParts], pairs: usize) -> Result<(Vec<Parts>, Vec<usize>), NumericError> {
    let mut counts = vec![0usize; pairs];
    parts.iter().for_each(|own| counts[own.pair as usize] += 1);
    let mut starts = vec![0];
    for (pair, count) in counts.iter().enumerate() {
        starts.push(starts[pair] + count.div_ceil(LEAF_POINTS));
    }
    let mut blocks = vec![Block([[0.0; LEAF_POINTS]; 6]); starts[pairs]];
    let mut filled = vec![0usize; pairs];
    for (step, PairOfParts { pair, parts: [s, t] }) in parts.iter().enumerate() {
        check_step(step)?;
        let pair = *pair as usize;
        let (block, lane) = (starts[pair] + filled[pair] / LEAF_POINTS, filled[pair] % LEAF_POINTS);
        filled[pair] += 1;
        let numbers = [s.at[0], s.at[1], s.size, t.at[0], t.at[1], t.size];
        (0..6).for_each(|k| blocks[block].0[k][lane] = numbers[k]);
        if filled[pair] == counts[pair] {
            // Lanes that are left over hold its centroids.
            let ([a, b], [c, d]) = (s.centroid(), t.centroid());
            let numbers = [a, b, 0.0, c, d, 0.0];
            (0..6).for_each(|k| blocks[block].0[k][lane + 1..].fill(numbers[k]));
        }
    }
    Ok((blocks, starts))
}

/// The partners of each face, face by face, and where they begin.
fn partners_of(pairs: &[[u32; 2]], faces: usize) -> (Vec<u32>, Vec<usize>) {
    let mut both: Vec<[u32; 2]> = pairs.iter().flat_map(|&[f, g]| [[f, g], [g, f]]).collect();
    both.sort_unstable();
    let starts = (0..=faces).map(|face| both.partition_point(|[f, _]| (*f as usize) < face)).collect();
    (both.into_iter().map(|[_, g]| g).collect(), starts)
}
