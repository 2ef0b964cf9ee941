//! Constrained triangulation of one triangle with exact predicates.
//!
//! Points are barycentric coordinates (corners 1 and 2) as integer multiples of 2^-52. Points on a
//! side therefore lie on it exactly, seen from either face, and orientations fit into 128 bits.
//! Only the choice among valid triangulations, by circumcircles in the true shape of the triangle,
//! uses floating point: an error there costs shape, not validity.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// Weights of corners 1 and 2, in units of `1 / ONE`.
pub(super) type Point = [i64; 2];

/// The weight 1 in these units.
pub(super) const ONE: i64 = 1 << 52;

/// Twice the signed area of the triangle `a b c` in grid units: positive if counter-clockwise.
pub(super) fn turn(a: Point, b: Point, c: Point) -> i128 {
    let [ux, uy] = [b[0] - a[0], b[1] - a[1]].map(i128::from);
    let [vx, vy] = [c[0] - a[0], c[1] - a[1]].map(i128::from);
    ux * vy - uy * vx
}

/// Hashes pairs of small numbers. These are internal vertex numbers, so no input can provoke
/// collisions deliberately.
#[derive(Default)]
pub(super) struct PairHasher(u64);

impl Hasher for PairHasher {
    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let word = chunk.iter().rev().fold(0, |word, &b| word << 8 | u64::from(b));
            self.write_u64(word);
        }
    }
    fn write_u64(&mut self, word: u64) {
        let product = u128::from(self.0 ^ word ^ 0x9e37_79b9_7f4a_7c15) * 0xd6e8_feb8_6659_fd93;
        self.0 = (product >> 64) as u64 ^ product as u64;
    }
    fn write_usize(&mut self, _length: usize) {} // all pairs have the same length
    fn finish(&self) -> u64 {
        self.0
    }
}

/// A map keyed by pairs of vertices.
pub(super) type ByPair<T> = HashMap<[u32; 2], T, BuildHasherDefault<PairHasher>>;

/// Location of a point in a triangulation.
enum Place {
    Vertex,
    /// On this directed edge, which has a triangle on its left.
    Edge([u32; 2]),
    Inside([u32; 3]),
}

/// A triangulation stored by directed edges.
pub(super) struct Triangulation {
    pub points: Vec<Point>,
    /// The third corner of the triangle on the left of each directed edge; outer edges have a
    /// triangle on one side only.
    apex: ByPair<u32>,
    /// For each vertex, the tip of an edge with a triangle on its left; the vertex itself before it
    /// is in a triangle.
    around: Vec<u32>,
    /// Sides 01 and 02 of the triangle in its plane, the longest side about 1.
    axes: [[f64; 2]; 2],
    /// An edge near the last modification.
    recent: [u32; 2],
}

impl Triangulation {
    /// Creates a single triangle of this shape.
    pub fn new(axes: [[f64; 2]; 2]) -> Self {
        let mut new = Triangulation {
            points: vec![[0, 0], [ONE, 0], [0, ONE]],
            apex: ByPair::default(),
            around: vec![1, 2, 0],
            axes,
            recent: [0, 1],
        };
        new.add([0, 1, 2]);
        new
    }

    /// Returns the third corner of the triangle on the left of a directed edge.
    pub fn apex(&self, from: u32, to: u32) -> Option<u32> {
        self.apex.get(&[from, to]).copied()
    }
    /// Whether an edge joins two vertices.
    pub fn has_edge(&self, a: u32, b: u32) -> bool {
        self.apex.contains_key(&[a, b]) || self.apex.contains_key(&[b, a])
    }
    /// Whether an edge lies on a side of the outer triangle.
    pub fn is_rim(&self, a: u32, b: u32) -> bool {
        self.apex.contains_key(&[a, b]) != self.apex.contains_key(&[b, a])
    }
    pub fn turn(&self, a: u32, b: u32, c: u32) -> i128 {
        turn(self.points[a as usize], self.points[b as usize], self.points[c as usize])
    }

    fn add(&mut self, [a, b, c]: [u32; 3]) {
        for [u, v, w] in [[a, b, c], [b, c, a], [c, a, b]] {
            self.apex.insert([u, v], w);
            self.around[u as usize] = v;
        }
        self.recent = [a, b];
    }
    fn remove(&mut self, [a, b, c]: [u32; 3]) {
        for edge in [[a, b], [b, c], [c, a]] {
            self.apex.remove(&edge);
        }
    }

    /// Calls `visit(b, c)` for the triangles `v b c` at a vertex until it returns a value.
    pub fn find_around<T>(&self, v: u32, mut visit: impl FnMut(u32, u32) -> Option<T>) -> Option<T> {
        let first = self.around[v as usize];
        let mut b = first;
        while let Some(c) = self.apex(v, b) {
            let found = visit(b, c);
            if found.is_some() || c == first {
                return found;
            }
            b = c;
        }
        // At the rim: the rest lies on the other side of the first edge.
        b = first;
        while let Some(c) = self.apex(b, v) {
            let found = visit(c, b);
            if found.is_some() {
                return found;
            }
            b = c;
        }
        None
    }

    /// Returns all triangles, each starting with its smallest vertex, in increasing order.
    pub fn triangles(&self) -> Vec<[u32; 3]> {
        let of_edge = self.apex.iter().map(|(&[a, b], &c)| [a, b, c]);
        let mut all: Vec<[u32; 3]> = of_edge.filter(|[a, b, c]| a < b && a < c).collect();
        all.sort_unstable();
        all
    }

    /// Adds a vertex at this point, not yet in a triangle.
    pub fn push(&mut self, point: Point) -> u32 {
        let v = self.points.len() as u32;
        self.points.push(point);
        self.around.push(v);
        v
    }

    /// Inserts a vertex into the triangles. `fixed` edges stay; returns the one that the vertex
    /// cuts by lying exactly on it. `None` if it lies outside or on another vertex.
    pub fn insert(&mut self, v: u32, fixed: impl Fn(u32, u32) -> bool) -> Option<Option<[u32; 2]>> {
        let (rim, cut) = match self.locate(self.points[v as usize])? {
            Place::Vertex => return None,
            Place::Inside([a, b, c]) => {
                self.remove([a, b, c]);
                self.add([a, b, v]);
                self.add([b, c, v]);
                self.add([c, a, v]);
                (vec![[a, b], [b, c], [c, a]], None)
            }
            Place::Edge([a, b]) => (self.divide(a, b, v), fixed(a, b).then_some([a, b])),
        };
        self.improve(rim, fixed);
        self.recent = [v, self.around[v as usize]];
        Some(cut)
    }

    /// Inserts a point in an edge between its two triangles, without regard to shape. `None` if a
    /// triangle would be inverted.
    pub fn insert_in_edge(&mut self, a: u32, b: u32, point: Point) -> Option<u32> {
        let valid = |a: u32, b: u32| {
            self.apex(a, b).is_none_or(|c| {
                let [a, b, c] = [a, b, c].map(|v| self.points[v as usize]);
                turn(a, point, c) > 0 && turn(point, b, c) > 0
            })
        };
        if !valid(a, b) || !valid(b, a) {
            return None;
        }
        let v = self.push(point);
        self.divide(a, b, v);
        Some(v)
    }

    /// Splits the triangles at an edge in two; returns the edges opposite the new vertex.
    fn divide(&mut self, a: u32, b: u32, v: u32) -> Vec<[u32; 2]> {
        let mut rim = Vec::with_capacity(4);
        for [a, b] in [[a, b], [b, a]] {
            if let Some(c) = self.apex(a, b) {
                self.remove([a, b, c]);
                self.add([a, v, c]);
                self.add([v, b, c]);
                rim.extend([[b, c], [c, a]]);
            }
        }
        rim
    }

    /// Locates a point by walking towards it, from the nearest of the last vertex and a sample of
    /// all vertices. This keeps walks short even for points in random order and thousands of
    /// triangles at one corner.
    fn locate(&self, p: Point) -> Option<Place> {
        let square = |v: u32| -> f64 {
            self.points[v as usize].iter().zip(p).map(|(x, y)| ((x - y) as f64).powi(2)).sum()
        };
        let [mut a, mut b] = self.recent;
        let stride = self.points.len().isqrt().max(8);
        let sample = (0..self.points.len() as u32).step_by(stride).filter(|&v| self.around[v as usize] != v);
        let sample = sample.map(|v| (square(v), v));
        if let Some((near, v)) = sample.min_by(|x, y| x.0.total_cmp(&y.0))
            && near < square(a)
        {
            [a, b] = [v, self.around[v as usize]];
        }
        // A walk by exact orientations may cycle where triangles are not Delaunay; then all are
        // searched.
        'walk: for _ in 0..2 * self.apex.len() + 16 {
            let Some(c) = self.apex(a, b) else { break };
            for [u, v] in [[a, b], [b, c], [c, a]] {
                if turn(self.points[u as usize], self.points[v as usize], p) < 0 && self.apex(v, u).is_some()
                {
                    [a, b] = [v, u];
                    continue 'walk;
                }
            }
            return self.place_in([a, b, c], p);
        }
        self.triangles().into_iter().find_map(|t| self.place_in(t, p))
    }

    fn place_in(&self, [a, b, c]: [u32; 3], p: Point) -> Option<Place> {
        let corners = [a, b, c];
        let sides = [0, 1, 2].map(|k| {
            let [u, v] = [corners[k], corners[(k + 1) % 3]].map(|v| self.points[v as usize]);
            turn(u, v, p)
        });
        if sides.iter().any(|&s| s < 0) {
            return None;
        }
        // At a corner the point is on two sides, in an edge on one, else on none.
        let on = [0, 1, 2].map(|k| sides[k] == 0);
        Some(match on {
            [true, _, true] | [true, true, _] | [_, true, true] => Place::Vertex,
            [true, ..] => Place::Edge([a, b]),
            [_, true, _] => Place::Edge([b, c]),
            [.., true] => Place::Edge([c, a]),
            _ => Place::Inside(corners),
        })
    }

    /// Flips the edge between two triangles and returns the other diagonal; `None` if their union
    /// is not strictly convex.
    pub fn flip(&mut self, a: u32, b: u32) -> Option<[u32; 2]> {
        let (c, d) = (self.apex(a, b)?, self.apex(b, a)?);
        if self.turn(a, d, c) <= 0 || self.turn(d, b, c) <= 0 {
            return None;
        }
        self.remove([a, b, c]);
        self.remove([b, a, d]);
        self.add([a, d, c]);
        self.add([d, b, c]);
        Some([c, d])
    }

    /// Flips these edges and those affected until each is Delaunay in the true shape or fixed.
    pub fn improve(&mut self, mut edges: Vec<[u32; 2]>, fixed: impl Fn(u32, u32) -> bool) {
        // Flips terminate except for rounding, far below this bound.
        let mut flips = 64 + 32 * (edges.len() + self.points.len());
        while let Some([a, b]) = edges.pop() {
            let (Some(c), Some(d)) = (self.apex(a, b), self.apex(b, a)) else { continue };
            if fixed(a, b) || !self.inside_circle([a, b, c], d) || self.flip(a, b).is_none() {
                continue;
            }
            flips -= 1;
            if flips == 0 {
                return;
            }
            edges.extend([[a, d], [d, b], [b, c], [c, a]]);
        }
    }

    /// Returns all edges, each once, in increasing order.
    pub fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges: Vec<[u32; 2]> = self.apex.keys().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    /// Whether `d` lies inside the circle through the corners of a triangle, by more than rounding.
    fn inside_circle(&self, triangle: [u32; 3], d: u32) -> bool {
        let d = self.points[d as usize];
        let rows = triangle.map(|v| {
            let p = self.points[v as usize];
            let [x, y] = [0, 1].map(|k| (p[k] - d[k]) as f64 / ONE as f64);
            [0, 1].map(|k| x * self.axes[0][k] + y * self.axes[1][k])
        });
        let (mut sum, mut bound) = (0.0, 0.0);
        for k in 0..3 {
            let [u, v, w] = [rows[k], rows[(k + 1) % 3], rows[(k + 2) % 3]];
            let square = u[0] * u[0] + u[1] * u[1];
            sum += square * (v[0] * w[1] - v[1] * w[0]);
            bound += square * ((v[0] * w[1]).abs() + (v[1] * w[0]).abs());
        }
        sum > 1e-13 * bound
    }
}
