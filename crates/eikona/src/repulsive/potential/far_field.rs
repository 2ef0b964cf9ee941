//! Sums of `w |x - y|^-p` over many fixed points y with weights w, by clusters.
//!
//! A far cluster is expanded around its centroid up to the second moments; the first ones vanish.
//! What is far is decided for each x anew. A cluster does not become far at once: between two
//! distances, its expansion and the sum over its parts are blended. So the sum has two continuous
//! derivatives in x, and a line search sees no jumps, wherever the surface moves.

//!
//! Several points x that are close to each other descend the tree together, one in each lane. What
//! is left of a sum below a cluster is weighted by the shares of its ancestors that are not far, so
//! that clusters can be visited in any order.

use crate::repulsive::faces::FaceDatum;
use crate::repulsive::leaf_sums::{Vector, dot, parts, plus, splat};
use crate::repulsive::moments::{Moments, moments_of, radius};
use crate::spatial::{Cluster, ClusterTree, LEAF_POINTS};
use eikona_numeric::{Instructions, Pack, Vectorized, vectorized};

type Vec3 = [f64; 3];

/// A sum at a point, with its derivative by the point.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum {
    pub value: f64,
    pub gradient: Vec3,
}

/// Numbers in the lanes, with their derivatives by the points in the lanes.
#[derive(Clone, Copy)]
struct Sums<S: Instructions> {
    value: Pack<S>,
    gradient: Vector<S>,
}

impl<S: Instructions> Sums<S> {
    #[inline(always)]
    fn constant(simd: S, x: f64) -> Self {
        Sums { value: Pack::splat(simd, x), gradient: splat(simd, [0.0; 3]) }
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        let (a, b) = (self.gradient, other.gradient);
        Sums { value: self.value - other.value, gradient: [a[0] - b[0], a[1] - b[1], a[2] - b[2]] }
    }

    /// Adds the product of two, with its derivative.
    #[inline(always)]
    fn plus_product(self, a: Self, b: Self) -> Self {
        Sums {
            value: a.value.mul_add(b.value, self.value),
            gradient: plus(a.gradient, b.value, plus(b.gradient, a.value, self.gradient)),
        }
    }
}

/// A cluster is far if its radius is below this number, divided by the exponent, times its
/// distance: the terms that the expansion omits grow with the third power of their product. With 1,
/// sums at a point are within 2 %, integrals over surfaces within 0.05 % and their gradients within
/// 0.2 %, since the errors of clusters have both signs.
const SEPARATION: f64 = 1.0;
/// For small exponents, whose sums have most of their value in far clusters, a cluster is far only
/// if its radius is below this share of its distance.
const LARGEST: f64 = 0.2;
/// From this many times the separation on, a cluster is near.
const BLEND: f64 = 1.2;

/// The kernel `|x - y|^-p`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kernel {
    /// `p / 2`: the kernel is this power of the squared distance.
    half: f64,
    /// `p`, if it is a small integer.
    integer: Option<u32>,
    /// Squares of the shares of radius and distance up to which a cluster is far, and from which
    /// on it is near.
    shares: [f64; 2],
}

impl Kernel {
    pub fn new(exponent: f64) -> Kernel {
        let small = exponent.fract() == 0.0 && exponent <= 64.0;
        let separation = (SEPARATION / exponent).min(LARGEST);
        let shares = [separation, BLEND * separation].map(|x| x * x);
        Kernel { half: 0.5 * exponent, integer: small.then_some(exponent as u32), shares }
    }

    /// Returns the kernel at the inverse of a squared distance.
    #[inline(always)]
    fn at<S: Instructions>(&self, inverse: Pack<S>) -> Pack<S> {
        match self.integer {
            Some(p) if p % 2 == 0 => inverse.power(p / 2),
            Some(p) => inverse.map(f64::sqrt).power(p),
            None => inverse.map(
                #[inline(always)]
                |x| x.powf(self.half),
            ),
        }
    }

    /// The term of a point: infinite where it lies itself.
    #[inline(always)]
    fn of_point<S: Instructions>(&self, simd: S, x: Vector<S>, [a, b, c, weight]: [f64; 4]) -> Sums<S> {
        let y = splat(simd, [a, b, c]);
        let v = [x[0] - y[0], x[1] - y[1], x[2] - y[2]];
        let inverse = dot(v, v).inverse();
        let value = Pack::splat(simd, weight) * self.at(inverse);
        let slope = Pack::splat(simd, -2.0 * self.half) * value * inverse;
        Sums { value, gradient: [v[0] * slope, v[1] * slope, v[2] * slope] }
    }

    /// The expansion of a cluster at distance `v` from its centroid.
    #[inline(always)]
    fn of_cluster<S: Instructions>(
        &self,
        simd: S,
        own: &Expansion,
        v: Vector<S>,
        squared: Pack<S>,
    ) -> Sums<S> {
        let h = self.half;
        let [xx, yy, zz, xy, xz, yz] = own.second;
        let inverse = squared.inverse();
        // `M v / |v|^2`, the trace by `|v|^2`, and `v M v` by `|v|^4`.
        let turned = [
            dot(splat(simd, [xx, xy, xz]), v) * inverse,
            dot(splat(simd, [xy, yy, yz]), v) * inverse,
            dot(splat(simd, [xz, yz, zz]), v) * inverse,
        ];
        let (area, trace) = (Pack::splat(simd, own.area), Pack::splat(simd, xx + yy + zz) * inverse);
        let along = dot(v, turned) * inverse;
        let kernel = self.at(inverse);
        let value =
            kernel * (area - Pack::splat(simd, h) * (trace - Pack::splat(simd, 2.0 * (h + 1.0)) * along));
        let bracket =
            Pack::splat(simd, h + 1.0) * (trace - Pack::splat(simd, 2.0 * (h + 2.0)) * along) - area;
        let outer = kernel * inverse;
        let (by_v, by_turned) =
            (Pack::splat(simd, 2.0 * h) * bracket * outer, Pack::splat(simd, 4.0 * h * (h + 1.0)) * outer);
        let gradient = plus(v, by_v, [turned[0] * by_turned, turned[1] * by_turned, turned[2] * by_turned]);
        Sums { value, gradient }
    }

    /// Returns the share of the expansion in the sum of a cluster.
    #[inline(always)]
    fn far_share<S: Instructions>(
        &self,
        simd: S,
        squared_radius: f64,
        v: Vector<S>,
        squared: Pack<S>,
    ) -> Sums<S> {
        let [far, near] = self.shares;
        let inverse = squared.inverse();
        let ratio = Pack::splat(simd, squared_radius) * inverse;
        let (zero, one) = (Pack::splat(simd, 0.0), Pack::splat(simd, 1.0));
        let t =
            ((Pack::splat(simd, near) - ratio) * Pack::splat(simd, 1.0 / (near - far))).max(zero).min(one);
        // From 0 to 1 with two derivatives that vanish at both ends.
        let cube = t * t * t;
        let value =
            cube * (Pack::splat(simd, 10.0) - Pack::splat(simd, 15.0) * t + Pack::splat(simd, 6.0) * (t * t));
        let rise = t * (one - t);
        // In the whole range of numbers, zero where the ratio is infinite.
        let slope = Pack::splat(simd, 60.0 / (near - far))
            * (rise * rise)
            * ratio.min(Pack::splat(simd, near))
            * inverse.min(Pack::splat(simd, f64::MAX));
        Sums { value, gradient: [v[0] * slope, v[1] * slope, v[2] * slope] }
    }
}

/// A cluster with its far field.
#[derive(Clone, Copy, Debug)]
struct Expansion {
    centre: Vec3,
    area: f64,
    second: [f64; 6],
    squared_radius: f64,
}

/// Fixed points with weights, in a tree.
#[derive(Clone, Debug)]
pub(super) struct Sources {
    tree: ClusterTree,
    /// The points in the order of the tree: coordinates and weight.
    points: Vec<[f64; 4]>,
    clusters: Vec<Expansion>,
}

impl Sources {
    /// Builds the tree over points with positive weights, at least one.
    pub fn new(points: &[(Vec3, f64)]) -> Sources {
        let tree = ClusterTree::new(&points.iter().map(|point| point.0).collect::<Vec<_>>());
        let datum = |(centroid, area)| FaceDatum { centroid, normal: [0.0; 3], area };
        let points: Vec<FaceDatum> = tree.in_order(points).into_iter().map(datum).collect();
        let moments = moments_of(&tree, &points, 1);
        let expansion = |(node, own): (&Cluster, &Moments)| Expansion {
            centre: own.centre,
            area: own.area,
            second: own.second,
            squared_radius: radius(&points[node.places()], own.centre).powi(2),
        };
        let clusters = tree.nodes().iter().zip(&moments).map(expansion).collect();
        let point = |FaceDatum { centroid: [x, y, z], area, .. }: &FaceDatum| [*x, *y, *z, *area];
        Sources { points: points.iter().map(point).collect(), tree, clusters }
    }

    /// The points with their weights, in the order of the tree.
    pub fn points(&self) -> impl ExactSizeIterator<Item = (Vec3, f64)> + '_ {
        self.points.iter().map(|&[x, y, z, weight]| ([x, y, z], weight))
    }

    /// Writes the sums at some points: infinite or not a number at one of the points of the tree.
    /// Points that follow each other should be close to each other.
    ///
    /// # Cost
    /// O(log n) per point.
    pub fn sums(&self, kernel: &Kernel, points: &[Vec3], sums: &mut [Sum]) {
        vectorized(Descent { sources: self, kernel, points, sums });
    }

    /// Descends the tree with the points in the lanes. The stack is empty before and after.
    #[inline(always)]
    fn at<S: Instructions>(
        &self,
        simd: S,
        kernel: &Kernel,
        x: Vector<S>,
        stack: &mut Vec<(usize, Sums<S>)>,
    ) -> Sums<S> {
        let mut sum = Sums::constant(simd, 0.0);
        stack.push((0, Sums::constant(simd, 1.0)));
        while let Some((node, mut weight)) = stack.pop() {
            let own = &self.clusters[node];
            let centre = splat(simd, own.centre);
            let v = [x[0] - centre[0], x[1] - centre[1], x[2] - centre[2]];
            let squared = dot(v, v);
            let share = kernel.far_share(simd, own.squared_radius, v, squared);
            if share.value.sum() > 0.0 {
                // No nearer than clusters are that are far in part.
                let least = Pack::splat(simd, own.squared_radius / kernel.shares[1]);
                let far = kernel.of_cluster(simd, own, v, squared.max(least));
                let share = Sums::constant(simd, 0.0).plus_product(weight, share);
                sum = sum.plus_product(share, far);
                weight = weight.minus(share);
            }
            if weight.value.sum() == 0.0 {
                continue;
            }
            if let Some([first, second]) = self.tree.children(node) {
                stack.push((second, weight));
                stack.push((first, weight));
                continue;
            }
            for point in &self.points[self.tree.nodes()[node].places()] {
                sum = sum.plus_product(weight, kernel.of_point(simd, x, *point));
            }
        }
        sum
    }
}

struct Descent<'a> {
    sources: &'a Sources,
    kernel: &'a Kernel,
    points: &'a [Vec3],
    sums: &'a mut [Sum],
}

impl Vectorized for Descent<'_> {
    type Output = ();
    #[inline(always)]
    fn run<S: Instructions>(self, simd: S) {
        let Descent { sources, kernel, points, sums } = self;
        let mut stack = Vec::new();
        for (points, sums) in points.chunks(LEAF_POINTS).zip(sums.chunks_mut(LEAF_POINTS)) {
            // Lanes that are left over repeat the last point.
            let mut lanes = [[0.0; LEAF_POINTS]; 3];
            for lane in 0..LEAF_POINTS {
                let point = points[lane.min(points.len() - 1)];
                (0..3).for_each(|k| lanes[k][lane] = point[k]);
            }
            let mut found = [[0.0; LEAF_POINTS]; 4];
            for part in parts::<S>() {
                let x = [
                    Pack::load(simd, &lanes[0], part),
                    Pack::load(simd, &lanes[1], part),
                    Pack::load(simd, &lanes[2], part),
                ];
                let sum = sources.at(simd, kernel, x, &mut stack);
                sum.value.add_to(&mut found[0], part);
                sum.gradient[0].add_to(&mut found[1], part);
                sum.gradient[1].add_to(&mut found[2], part);
                sum.gradient[2].add_to(&mut found[3], part);
            }
            for (lane, sum) in sums.iter_mut().enumerate() {
                let [value, x, y, z] = [found[0][lane], found[1][lane], found[2][lane], found[3][lane]];
                *sum = Sum { value, gradient: [x, y, z] };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::vector::{add, dot, scale, sub};
    use eikona_mesh::shapes;

    fn sphere(levels: u32) -> Sources {
        let mesh = shapes::icosphere(levels).unwrap();
        let area = 4.0 * std::f64::consts::PI / mesh.face_count() as f64;
        let centroid = |f| {
            let [a, b, c] = mesh.face_positions(f);
            (scale(add(add(a, b), c), 1.0 / 3.0), area)
        };
        Sources::new(&mesh.faces().map(centroid).collect::<Vec<_>>())
    }

    fn sums(sources: &Sources, kernel: &Kernel, points: &[Vec3]) -> Vec<Sum> {
        let mut sums = vec![Sum::default(); points.len()];
        sources.sums(kernel, points, &mut sums);
        sums
    }

    /// The same by recursion, one point at a time.
    mod twin {
        use super::*;

        impl Sum {
            pub fn plus(self, other: Sum) -> Sum {
                Sum { value: self.value + other.value, gradient: add(self.gradient, other.gradient) }
            }
        }

        pub fn of_point(p: f64, x: Vec3, [a, b, c, weight]: [f64; 4]) -> Sum {
            let v = sub(x, [a, b, c]);
            let value = weight * dot(v, v).powf(-0.5 * p);
            Sum { value, gradient: scale(v, -p * value / dot(v, v)) }
        }

        fn of_cluster(p: f64, own: &Expansion, v: Vec3) -> Sum {
            let (h, squared) = (0.5 * p, dot(v, v));
            let [xx, yy, zz, xy, xz, yz] = own.second;
            let turned = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]].map(|row| dot(row, v) / squared);
            let (trace, along) = ((xx + yy + zz) / squared, dot(v, turned) / squared);
            let kernel = squared.powf(-h);
            let value = kernel * (own.area - h * (trace - 2.0 * (h + 1.0) * along));
            let by_square = h * ((h + 1.0) * (trace - 2.0 * (h + 2.0) * along) - own.area);
            let direction = add(scale(v, 2.0 * by_square), scale(turned, 4.0 * h * (h + 1.0)));
            Sum { value, gradient: scale(direction, kernel / squared) }
        }

        /// The share of the expansion, and its derivative by the squared distance.
        pub fn far_share([far, near]: [f64; 2], squared_radius: f64, squared: f64) -> (f64, f64) {
            let ratio = squared_radius / squared;
            let t = ((near - ratio) / (near - far)).clamp(0.0, 1.0);
            let share = t * t * t * (10.0 - 15.0 * t + 6.0 * t * t);
            (share, 30.0 * (t * (1.0 - t)).powi(2) * ratio / (squared * (near - far)))
        }

        pub fn sum(sources: &Sources, kernel: &Kernel, node: usize, x: Vec3) -> Sum {
            let (own, p) = (&sources.clusters[node], 2.0 * kernel.half);
            let v = sub(x, own.centre);
            let (share, slope) = far_share(kernel.shares, own.squared_radius, dot(v, v));
            if share == 1.0 {
                return of_cluster(p, own, v);
            }
            let parts: Vec<Sum> = match sources.tree.children(node) {
                Some(children) => children.map(|child| sum(sources, kernel, child, x)).to_vec(),
                None => {
                    let points = &sources.points[sources.tree.nodes()[node].places()];
                    points.iter().map(|point| of_point(p, x, *point)).collect()
                }
            };
            let near = parts.into_iter().fold(Sum::default(), Sum::plus);
            if share == 0.0 {
                return near;
            }
            let far = of_cluster(p, own, v);
            let blended = |far: f64, near: f64| share * far + (1.0 - share) * near;
            let by_share = 2.0 * slope * (far.value - near.value);
            Sum {
                value: blended(far.value, near.value),
                gradient: [0, 1, 2].map(|k| blended(far.gradient[k], near.gradient[k]) + by_share * v[k]),
            }
        }
    }

    fn off(found: &Sum, exact: &Sum) -> [f64; 2] {
        let (off, size) = (sub(found.gradient, exact.gradient), dot(exact.gradient, exact.gradient));
        [(found.value / exact.value - 1.0).abs(), (dot(off, off) / size).sqrt()]
    }

    /// Points outside and inside of the unit sphere, on a spiral.
    fn spiral(count: usize, away: impl Fn(f64) -> f64) -> Vec<Vec3> {
        let at = |i: usize| {
            let (away, angle) = (away(i as f64), 0.37 * i as f64);
            [away * angle.cos() * 0.6, away * angle.sin() * 0.6, away * 0.8]
        };
        (0..count).map(at).collect()
    }

    #[test]
    fn lanes_have_the_digits_of_single_points() {
        // No multiple of eight.
        let points = spiral(397, |i| 0.3 + 0.01 * i);
        for levels in [0, 3] {
            let sources = sphere(levels);
            for exponent in [1.0, 2.0, 2.5, 3.0, 6.0, 7.5, 12.0] {
                let kernel = Kernel::new(exponent);
                for (x, found) in points.iter().zip(sums(&sources, &kernel, &points)) {
                    let exact = twin::sum(&sources, &kernel, 0, *x);
                    let off = sub(found.gradient, exact.gradient);
                    // Inside of the sphere, the terms of gradients cancel, so that only their sizes
                    // count, which are about the value.
                    let size = exact.value + dot(exact.gradient, exact.gradient).sqrt();
                    assert!((found.value / exact.value - 1.0).abs() < 1e-12, "{exponent} {x:?}");
                    assert!(dot(off, off).sqrt() < 1e-12 * size, "{exponent} {x:?}: {off:?}");
                }
            }
        }
    }

    #[test]
    fn the_sum_is_not_finite_at_a_source() {
        for sources in [sphere(3), Sources::new(&[([0.3, 0.2, 0.1], 1.0)])] {
            let [x, y, z, _] = sources.points[0];
            for exponent in [1.0, 2.0, 2.5, 6.0] {
                let sums = sums(&sources, &Kernel::new(exponent), &[[x, y, z], [x, y, z + 1.0]]);
                assert!(!sums[0].value.is_finite() && sums[1].value.is_finite(), "{exponent}");
            }
        }
        // At the centre of a cluster, there is no source.
        let [a, b] = [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]];
        let sum = sums(&Sources::new(&[(a, 1.0), (b, 1.0)]), &Kernel::new(6.0), &[[0.0; 3]])[0];
        assert_eq!((sum.value, sum.gradient), (2.0, [0.0; 3]));
    }

    #[test]
    fn the_gradient_is_the_derivative_also_where_clusters_become_far() {
        let sources = sphere(3);
        for exponent in [2.0, 3.0, 6.0, 7.5, 12.0] {
            let kernel = Kernel::new(exponent);
            let mut blends = 0;
            for i in 0..400 {
                let x = [0.3 + 0.01 * f64::from(i), 0.7, 0.9];
                let blended = |own: &&Expansion| {
                    let v = sub(x, own.centre);
                    let (share, _) = twin::far_share(kernel.shares, own.squared_radius, dot(v, v));
                    share > 0.0 && share < 1.0
                };
                blends += sources.clusters.iter().filter(blended).count();
                let h = 1e-4;
                let steps = [2.0 * h, h, -h, -2.0 * h];
                let moved =
                    |k: usize| steps.map(|step| [0, 1, 2].map(|j| x[j] + if j == k { step } else { 0.0 }));
                let points: Vec<Vec3> = [x].into_iter().chain((0..3).flat_map(moved)).collect();
                let sums = sums(&sources, &kernel, &points);
                let gradient = sums[0].gradient;
                for k in 0..3 {
                    let at = |step: usize| sums[1 + 4 * k + step].value;
                    let quotient = (8.0 * (at(1) - at(2)) - (at(0) - at(3))) / (12.0 * h);
                    let size = dot(gradient, gradient).sqrt();
                    assert!((gradient[k] - quotient).abs() < 1e-7 * size, "{exponent} {i} {k}");
                }
            }
            assert!(blends > 1000, "{blends}");
        }
    }

    #[test]
    fn the_sum_is_close_to_that_over_all_points() {
        let sources = sphere(4);
        let points = spiral(300, |i| 1.02 + 0.02 * i);
        for exponent in [1.0, 2.5, 4.0, 6.0, 12.0] {
            let (mut worst, mut worst_gradient) = (0.0f64, 0.0f64);
            for (x, sum) in points.iter().zip(sums(&sources, &Kernel::new(exponent), &points)) {
                let exact = sources.points.iter().map(|point| twin::of_point(exponent, *x, *point));
                let [value, gradient] = off(&sum, &exact.fold(Sum::default(), Sum::plus));
                (worst, worst_gradient) = (worst.max(value), worst_gradient.max(gradient));
            }
            println!("p = {exponent}: value {worst:.1e}, gradient {worst_gradient:.1e}");
            assert!(worst < 0.02 && worst_gradient < 0.02);
        }
    }
}
