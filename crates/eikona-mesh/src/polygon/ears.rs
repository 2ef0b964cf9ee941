//! Ear clipping.
//!
//! An ear is a corner whose triangle with its two neighbours lies inside the polygon. Clipping ears
//! one by one, best shaped first, triangulates every simple polygon, and polygons that touch
//! themselves: keyholes, whose bridge to a hole is traversed twice, have ears until one triangle is
//! left. Orientation tests are exact, so that rounding never leaves a simple polygon without ears.
//!
//! Only reflex corners can lie in the triangle of another corner. They are kept in a [`BoxTree`]; a
//! corner that one of them blocks waits until that one is gone.

use super::box_tree::{Box2, BoxTree};
use super::crossing::crosses_itself;
use super::outline::{Shape, cross, exact_side, squared, tolerance};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Which corners may be clipped. When none is left under one rule, the next one applies.
#[derive(Clone, Copy, PartialEq)]
enum Rule {
    /// Ears with an area beyond rounding, whose cut keeps away from all other corners.
    Clear,
    /// All ears, by exact tests.
    Exact,
    /// Every corner, ear or not. Needed only if the polygon crosses itself or has no area.
    Any,
}

/// A corner to be clipped.
struct Candidate {
    quality: f64,
    corner: usize,
    /// Number of changes of its neighbours at the time it was listed.
    version: u32,
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.quality.total_cmp(&other.quality).then(other.corner.cmp(&self.corner))
    }
}
impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Candidate {}

/// Why a corner is not an ear.
struct Blocker {
    corner: usize,
    /// Whether only the directions of its edges decide: it lies on the boundary of the triangle.
    touches: bool,
}

/// Triangulates a polygon, as triples of its corners (not of vertices). Returns `n - 2` triangles,
/// unless the polygon visits a vertex twice and separates there: then each part has two triangles
/// fewer than corners. No triangle repeats a vertex.
///
/// `vertices` gives the vertex of each corner; neighbours must differ, and so must second
/// neighbours (no dead ends).
///
/// # Cost
/// O(n log n) in practice, at worst O(n^2) tests for contrived simple polygons. For
/// self-intersecting polygons the search for ears stops after O(n) tests.
pub(crate) fn triangulate(points: &[[f64; 2]], vertices: &[u32], triangles: &mut Vec<[usize; 3]>) {
    Clipper::new(points, vertices).run(triangles);
}

struct Clipper<'a> {
    points: &'a [[f64; 2]],
    vertices: &'a [u32],
    next: Vec<usize>,
    previous: Vec<usize>,
    version: Vec<u32>,
    removed: Vec<bool>,
    /// The remaining reflex corners.
    blockers: BoxTree,
    /// Head of the list in `waiting` of the corners that each blocker blocks.
    first_waiting: Vec<usize>,
    /// Corner, its version, and the next entry of the list.
    waiting: Vec<(usize, u32, usize)>,
    /// Whether another corner waits for the directions of this one's edges.
    touched: Vec<bool>,
    candidates: BinaryHeap<Candidate>,
    rule: Rule,
}

/// End of a list.
const NONE: usize = usize::MAX;

impl<'a> Clipper<'a> {
    fn new(points: &'a [[f64; 2]], vertices: &'a [u32]) -> Self {
        let n = points.len();
        let previous: Vec<usize> = (0..n).map(|k| (k + n - 1) % n).collect();
        let next: Vec<usize> = (0..n).map(|k| (k + 1) % n).collect();
        let blocks = |k: usize| {
            let shape = Shape::of([previous[k], k, next[k]].map(|k| points[k]));
            shape.is_flat().then(|| Box2::of([points[k]]))
        };
        let blockers: Vec<_> = (0..n).map(blocks).collect();
        Clipper {
            blockers: BoxTree::new(&blockers),
            points,
            vertices,
            next,
            previous,
            version: vec![0; n],
            removed: vec![false; n],
            first_waiting: vec![NONE; n],
            waiting: Vec::new(),
            touched: vec![false; n],
            candidates: BinaryHeap::new(),
            rule: Rule::Clear,
        }
    }

    fn run(mut self, triangles: &mut Vec<[usize; 3]>) {
        let n = self.points.len();
        let mut remaining = n;
        let mut tests = 0;
        let mut tests_allowed = 64 * n + 4096;
        self.list_all();
        while remaining > 3 {
            let Some(candidate) = self.candidates.pop() else {
                self.rule = match self.rule {
                    Rule::Clear => Rule::Exact,
                    _ => Rule::Any,
                };
                self.list_all();
                continue;
            };
            let b = candidate.corner;
            if self.removed[b] || candidate.version != self.version[b] {
                continue;
            }
            if self.rule != Rule::Any {
                tests += 1;
                if let Some(blocker) = self.blocker(b) {
                    self.wait(b, &blocker);
                    if tests > tests_allowed {
                        if crosses_itself(self.points) {
                            self.rule = Rule::Any;
                            self.candidates.clear();
                            self.list_all();
                        }
                        tests_allowed = usize::MAX;
                    }
                    continue;
                }
            }
            triangles.push([self.previous[b], b, self.next[b]]);
            remaining = self.clip(b, remaining);
        }
        if let (3, Some(a)) = (remaining, (0..n).find(|&k| !self.removed[k])) {
            triangles.push([a, self.next[a], self.previous[a]]);
        }
    }

    /// Lists all remaining corners that the rule allows.
    fn list_all(&mut self) {
        for k in 0..self.points.len() {
            if !self.removed[k] {
                self.list(k);
            }
        }
    }

    fn list(&mut self, corner: usize) {
        let [a, b, c] = self.triangle(corner);
        let shape = Shape::of([a, b, c]);
        let admitted = match self.rule {
            Rule::Clear => !shape.is_flat(),
            Rule::Exact => exact_side(a, b, c) > 0.0,
            Rule::Any => true,
        };
        if admitted {
            let version = self.version[corner];
            self.candidates.push(Candidate { quality: shape.quality(), corner, version });
        }
    }

    fn triangle(&self, corner: usize) -> [[f64; 2]; 3] {
        [self.previous[corner], corner, self.next[corner]].map(|k| self.points[k])
    }

    /// Returns a corner that keeps `b` from being an ear.
    fn blocker(&self, b: usize) -> Option<Blocker> {
        let own = [self.previous[b], b, self.next[b]];
        let [pa, pb, pc] = self.triangle(b);
        let bounds = Box2::of([pa, pb, pc]);
        // Under the first rule, corners close to the cut from a to c block it too: clipping them
        // later would give a sliver.
        let slack = if self.rule == Rule::Clear { tolerance(squared(pa, pc)) } else { 0.0 };
        let margin = 2.0 * tolerance(Shape::of([pa, pb, pc]).longest_squared);
        let sides = [[pa, pb], [pb, pc], [pc, pa]];
        let near = |area: &Box2| {
            (area.meets(&bounds) || slack > 0.0)
                && sides.iter().all(|[p, q]| area.sides_of(*p, *q)[1] >= -margin)
        };
        self.blockers.find(near, |k| {
            if own.contains(&k) {
                return None;
            }
            let p = self.points[k];
            let edge_ends = [self.previous[k], self.next[k]].map(|j| self.points[j]);
            let enters = |[u, v, w]: [[f64; 2]; 3]| {
                // Strictly inside the angle at v of the counter-clockwise triangle u v w.
                edge_ends.iter().any(|&q| exact_side(u, v, q) > 0.0 && exact_side(v, w, q) > 0.0)
            };
            let touching = |blocks: bool| blocks.then_some(Blocker { corner: k, touches: true });
            if p == pb {
                return touching(enters([pa, pb, pc]));
            } else if p == pa {
                return touching(enters([pc, pa, pb]));
            } else if p == pc {
                return touching(enters([pb, pc, pa]));
            }
            let [ab, bc] = [exact_side(pa, pb, p), exact_side(pb, pc, p)];
            if ab < 0.0 || bc < 0.0 || exact_side(pc, pa, p) < -slack {
                return None;
            }
            // The polygon may touch its own edges from the other side.
            for (side, [u, v]) in [(ab, [pa, pb]), (bc, [pb, pc])] {
                if side == 0.0 {
                    return touching(edge_ends.iter().any(|&q| exact_side(u, v, q) > 0.0));
                }
            }
            Some(Blocker { corner: k, touches: false })
        })
    }

    fn wait(&mut self, corner: usize, blocker: &Blocker) {
        self.waiting.push((corner, self.version[corner], self.first_waiting[blocker.corner]));
        self.first_waiting[blocker.corner] = self.waiting.len() - 1;
        self.touched[blocker.corner] |= blocker.touches;
    }

    /// Lists the corners that wait for this one again.
    fn wake(&mut self, corner: usize) {
        let mut entry = std::mem::replace(&mut self.first_waiting[corner], NONE);
        self.touched[corner] = false;
        while entry != NONE {
            let (waiting, version, following) = self.waiting[entry];
            if !self.removed[waiting] && self.version[waiting] == version {
                self.list(waiting);
            }
            entry = following;
        }
    }

    /// Removes a corner after its triangle was taken, and with it any dead end that this leaves: a
    /// part attached to the rest at a vertex is used up. Returns the number of remaining corners.
    fn clip(&mut self, b: usize, mut remaining: usize) -> usize {
        let [mut a, mut c] = [self.previous[b], self.next[b]];
        self.remove(b);
        remaining -= 1;
        while remaining > 3 {
            // The tip of the dead end is a or c.
            let (tip, twin) = if self.same_vertex(self.previous[a], c) {
                (a, self.previous[a])
            } else if self.same_vertex(a, self.next[c]) {
                (c, self.next[c])
            } else {
                break;
            };
            (a, c) = if tip == a { (self.previous[twin], c) } else { (a, self.next[twin]) };
            self.remove(tip);
            self.remove(twin);
            remaining -= 2;
        }
        for k in [a, c] {
            self.version[k] += 1;
            if self.blockers.contains(k) && !Shape::of(self.triangle(k)).is_flat() {
                self.blockers.remove(k);
                self.wake(k);
            } else if self.touched[k] {
                self.wake(k);
            }
            self.list(k);
        }
        remaining
    }

    fn same_vertex(&self, j: usize, k: usize) -> bool {
        self.vertices[j] == self.vertices[k]
    }

    /// Unlinks a corner.
    fn remove(&mut self, k: usize) {
        let [a, c] = [self.previous[k], self.next[k]];
        self.next[a] = c;
        self.previous[c] = a;
        self.removed[k] = true;
        if self.blockers.contains(k) {
            self.blockers.remove(k);
        }
        self.wake(k);
    }
}

/// Returns twice the total unsigned area of the triangles.
pub(crate) fn doubled_area(points: &[[f64; 2]], triangles: &[[usize; 3]]) -> f64 {
    triangles.iter().map(|t| cross(points[t[0]], points[t[1]], points[t[2]]).abs()).sum()
}
