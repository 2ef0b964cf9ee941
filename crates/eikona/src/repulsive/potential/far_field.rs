//! Sums of `w |x - y|^-p` over many fixed points y with weights w, by clusters.
//!
//! A far cluster is expanded around its centroid up to the second moments; the first ones vanish.
//! What is far is decided for each x anew. A cluster does not become far at once: between two
//! distances, its expansion and the sum over its parts are blended. So the sum has two continuous
//! derivatives in x, and a line search sees no jumps, wherever the surface moves.

use crate::geometry::vector::{add, dot, scale, sub};
use crate::repulsive::faces::FaceDatum;
use crate::repulsive::moments::{Moments, moments_of, radii};
use crate::spatial::ClusterTree;

type Vec3 = [f64; 3];

/// A sum at a point, with its derivative by the point.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum {
    pub value: f64,
    pub gradient: Vec3,
}

impl Sum {
    fn plus(self, other: Sum) -> Sum {
        Sum { value: self.value + other.value, gradient: add(self.gradient, other.gradient) }
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
    fn at(&self, inverse: f64) -> f64 {
        match self.integer {
            Some(p) if p % 2 == 0 => power(inverse, p / 2),
            Some(p) => power(inverse.sqrt(), p),
            None => inverse.powf(self.half),
        }
    }

    #[inline(always)]
    fn of_point(&self, x: Vec3, point: &FaceDatum) -> Sum {
        let v = sub(x, point.centroid);
        let inverse = dot(v, v).recip();
        let value = point.area * self.at(inverse);
        Sum { value, gradient: scale(v, -2.0 * self.half * value * inverse) }
    }

    /// The expansion of a cluster at distance `v` from its centroid.
    #[inline(always)]
    fn of_cluster(&self, cluster: &Moments, v: Vec3, squared: f64) -> Sum {
        let h = self.half;
        let inverse = squared.recip();
        let [xx, yy, zz, xy, xz, yz] = cluster.second;
        let [x, y, z] = v;
        // `M v / |v|^2`, the trace by `|v|^2`, and `v M v` by `|v|^4`.
        let turned = [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z];
        let turned = scale(turned, inverse);
        let trace = (xx + yy + zz) * inverse;
        let along = dot(v, turned) * inverse;
        let kernel = self.at(inverse);
        let value = kernel * (cluster.area - h * (trace - 2.0 * (h + 1.0) * along));
        let by_square = h * ((h + 1.0) * (trace - 2.0 * (h + 2.0) * along) - cluster.area);
        let by_turned = 4.0 * h * (h + 1.0);
        let direction = add(scale(v, 2.0 * by_square), scale(turned, by_turned));
        Sum { value, gradient: scale(direction, kernel * inverse) }
    }

    /// Returns the share of the expansion in the sum of a cluster, and its derivative by the
    /// squared distance.
    fn far_share(&self, squared_radius: f64, squared: f64) -> (f64, f64) {
        let [far, near] = self.shares;
        if squared_radius <= far * squared {
            return (1.0, 0.0);
        }
        if squared_radius >= near * squared {
            return (0.0, 0.0);
        }
        let ratio = squared_radius / squared;
        let t = (near - ratio) / (near - far);
        // From 0 to 1 with two derivatives that vanish at both ends.
        let share = t * t * t * (10.0 - 15.0 * t + 6.0 * t * t);
        let slope = 30.0 * (t * (1.0 - t)).powi(2);
        (share, slope * ratio / (squared * (near - far)))
    }
}

/// Faster than `powi`, which is a call.
#[inline(always)]
fn power(x: f64, exponent: u32) -> f64 {
    let (mut result, mut square, mut left) = (1.0, x, exponent);
    while left > 0 {
        if left & 1 == 1 {
            result *= square;
        }
        square *= square;
        left >>= 1;
    }
    result
}

/// Fixed points with weights, in a tree.
#[derive(Clone, Debug)]
pub(super) struct Sources {
    tree: ClusterTree,
    /// The points in the order of the tree. Areas are weights; normals are not used.
    points: Vec<FaceDatum>,
    moments: Vec<Moments>,
    squared_radii: Vec<f64>,
}

impl Sources {
    /// Builds the tree over points with positive weights, at least one.
    pub fn new(points: &[(Vec3, f64)]) -> Sources {
        let tree = ClusterTree::new(&points.iter().map(|point| point.0).collect::<Vec<_>>());
        let datum = |(centroid, area)| FaceDatum { centroid, normal: [0.0; 3], area };
        let points: Vec<FaceDatum> = tree.in_order(points).into_iter().map(datum).collect();
        let moments = moments_of(&tree, &points);
        let squared_radii = radii(&tree, &points, &moments).into_iter().map(|r| r * r).collect();
        Sources { tree, points, moments, squared_radii }
    }

    /// The points with their weights, in the order of the tree.
    pub fn points(&self) -> impl ExactSizeIterator<Item = (Vec3, f64)> + '_ {
        self.points.iter().map(|point| (point.centroid, point.area))
    }

    /// Returns the sum at a point: infinite or not a number at one of the points themselves.
    ///
    /// # Cost
    /// O(log n).
    pub fn sum(&self, kernel: &Kernel, x: Vec3) -> Sum {
        self.sum_below(0, kernel, x)
    }

    fn sum_below(&self, node: usize, kernel: &Kernel, x: Vec3) -> Sum {
        let cluster = &self.moments[node];
        let v = sub(x, cluster.centre);
        let squared = dot(v, v);
        let (share, slope) = kernel.far_share(self.squared_radii[node], squared);
        if share == 1.0 {
            return kernel.of_cluster(cluster, v, squared);
        }
        let near = match self.tree.children(node) {
            Some([first, second]) => self.sum_below(first, kernel, x).plus(self.sum_below(second, kernel, x)),
            None => {
                let points = self.points[self.tree.nodes()[node].places()].iter();
                points.fold(Sum::default(), |sum, point| sum.plus(kernel.of_point(x, point)))
            }
        };
        if share == 0.0 {
            return near;
        }
        let far = kernel.of_cluster(cluster, v, squared);
        let blended = |far: f64, near: f64| share * far + (1.0 - share) * near;
        let by_share = 2.0 * slope * (far.value - near.value);
        Sum {
            value: blended(far.value, near.value),
            gradient: [0, 1, 2].map(|k| blended(far.gradient[k], near.gradient[k]) + by_share * v[k]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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

    #[test]
    fn the_gradient_is_the_derivative_also_where_clusters_become_far() {
        let sources = sphere(3);
        for exponent in [2.0, 3.0, 6.0, 7.5, 12.0] {
            let kernel = Kernel::new(exponent);
            let mut blends = 0;
            for i in 0..400 {
                let x = [0.3 + 0.01 * f64::from(i), 0.7, 0.9];
                let blended = |node: usize| {
                    let v = sub(x, sources.moments[node].centre);
                    let (share, _) = kernel.far_share(sources.squared_radii[node], dot(v, v));
                    share > 0.0 && share < 1.0
                };
                blends += (0..sources.moments.len()).filter(|&node| blended(node)).count();
                let Sum { gradient, .. } = sources.sum(&kernel, x);
                let h = 1e-4;
                for k in 0..3 {
                    let at = |step: f64| {
                        let mut x = x;
                        x[k] += step;
                        sources.sum(&kernel, x).value
                    };
                    let quotient = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
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
        for exponent in [1.0, 2.5, 4.0, 6.0, 12.0] {
            let kernel = Kernel::new(exponent);
            let (mut worst, mut worst_gradient) = (0.0f64, 0.0f64);
            for i in 0..300 {
                let away = 1.02 + 0.02 * f64::from(i);
                let angle = 0.37 * f64::from(i);
                let x = [away * angle.cos() * 0.6, away * angle.sin() * 0.6, away * 0.8];
                let sum = sources.sum(&kernel, x);
                let exact = sources.points.iter().map(|point| kernel.of_point(x, point));
                let exact = exact.fold(Sum::default(), Sum::plus);
                worst = worst.max((sum.value / exact.value - 1.0).abs());
                let off = sub(sum.gradient, exact.gradient);
                let size = dot(exact.gradient, exact.gradient);
                worst_gradient = worst_gradient.max((dot(off, off) / size).sqrt());
            }
            println!("p = {exponent}: value {worst:.1e}, gradient {worst_gradient:.1e}");
            assert!(worst < 0.02 && worst_gradient < 0.02);
        }
    }
}
