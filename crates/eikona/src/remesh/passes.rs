//! The passes over all edges: long ones are split, short ones collapsed, and those flipped that
//! are not Delaunay (RS section 6).

use super::barrier;
use super::changing::{Changing, Fan, Hinge, NONE, Vec3};
use super::guard::{Guard, Replacement};
use super::options::RemeshOptions;
use crate::geometry::vector::{add, cross, distance, dot, lerp, norm, scale, sub};
use eikona_numeric::{NumericError, check_step};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Edges longer than this, relative to the length to aim for, are split.
const LONG: f64 = 1.5;
/// Edges shorter than this are collapsed.
const SHORT: f64 = 0.5;
/// Faces turn by less than 60 degrees in an operation.
const LEAST_COSINE: f64 = 0.5;
/// A boundary that turns by less than 25 degrees at a vertex is smooth there.
pub(super) const SMOOTH_BOUNDARY: f64 = 0.9;
/// Faces get no flatter than this: twice the area relative to the square of the longest side.
const FLATTEST: f64 = 0.05;
/// Splits per face and round, at most, and beyond these: huge faces among small ones take more
/// rounds.
const MOST_SPLITS: [usize; 2] = [4, 10_000];
/// Flips per edge, at most. Each makes the mesh more Delaunay, so there are few.
const MOST_FLIPS: usize = 10;

/// How often each operation was done, or refused since the surface would have touched itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RemeshCounts {
    /// Edges that were split.
    pub splits: usize,
    /// Edges that were collapsed.
    pub collapses: usize,
    /// Edges that were flipped.
    pub flips: usize,
    /// Operations that were refused.
    pub refused: usize,
}

impl RemeshCounts {
    /// Whether the connectivity changed.
    pub fn changed(&self) -> bool {
        self.splits + self.collapses + self.flips > 0
    }
}

/// The mesh, with what its operations need.
pub(super) struct Passes<'a> {
    pub mesh: Changing,
    pub counts: RemeshCounts,
    /// Built when it is first needed.
    guard: Option<Guard>,
    options: &'a RemeshOptions,
    replacement: Replacement,
}

/// An edge in a queue: its priority in bits, so that it has an order, and its halfedge.
type Queued = (u64, Reverse<u32>);

impl<'a> Passes<'a> {
    pub fn new(mesh: Changing, options: &'a RemeshOptions) -> Passes<'a> {
        let counts = RemeshCounts::default();
        Passes { mesh, counts, guard: None, options, replacement: Replacement::default() }
    }

    /// Splits long edges, the longest first.
    pub fn split_long(&mut self) -> Result<(), NumericError> {
        let long = |mesh: &Changing, hinge: &Hinge| {
            let ratio = mesh.length(hinge.ends) / mesh.size(hinge.ends);
            let held = hinge.ends.iter().all(|v| mesh.fixed[*v as usize]);
            (ratio > LONG && !held).then(|| (ratio.to_bits(), Reverse(hinge.halfedge)))
        };
        let mut queue: BinaryHeap<Queued> = self.mesh.hinges().filter_map(|h| long(&self.mesh, &h)).collect();
        let mut fan = Fan::default();
        let mut step = 0;
        let most = MOST_SPLITS[0] * self.mesh.faces.len() + MOST_SPLITS[1];
        while let Some(queued) = queue.pop().filter(|_| self.counts.splits < most) {
            step += 1;
            check_step(step)?;
            let hinge = self.mesh.hinge(queued.1.0);
            // It may have been split, and queued anew, since.
            if long(&self.mesh, &hinge) != Some(queued) {
                continue;
            }
            let middle = self.mesh.split(&hinge);
            self.counts.splits += 1;
            self.note_fan(middle, &mut fan);
            for side in fan.corners.iter().flat_map(|c| (0..3).map(move |k| c - c % 3 + k)) {
                queue.extend(long(&self.mesh, &self.mesh.hinge(side)));
            }
        }
        Ok(())
    }

    /// Collapses short edges, the shortest first.
    pub fn collapse_short(&mut self) -> Result<(), NumericError> {
        let short = |mesh: &Changing, hinge: &Hinge| {
            let ratio = mesh.length(hinge.ends) / mesh.size(hinge.ends);
            (ratio < SHORT).then(|| (!ratio.to_bits(), Reverse(hinge.halfedge)))
        };
        let mut queue: BinaryHeap<Queued> =
            self.mesh.hinges().filter_map(|h| short(&self.mesh, &h)).collect();
        let mut fans = [Fan::default(), Fan::default()];
        let mut step = 0;
        while let Some(queued) = queue.pop() {
            step += 1;
            check_step(step)?;
            if !self.mesh.is_alive(queued.1.0 / 3) {
                continue;
            }
            let hinge = self.mesh.hinge(queued.1.0);
            if short(&self.mesh, &hinge) != Some(queued) || !self.collapse(hinge, &mut fans) {
                continue;
            }
            for side in fans[0].corners.iter().flat_map(|c| (0..3).map(move |k| c - c % 3 + k)) {
                queue.extend(short(&self.mesh, &self.mesh.hinge(side)));
            }
        }
        Ok(())
    }

    /// Collapses an edge if the surface stays one, and stays good. Leaves the fan of what is left
    /// of it.
    fn collapse(&mut self, mut hinge: Hinge, fans: &mut [Fan; 2]) -> bool {
        for (v, fan) in hinge.ends.into_iter().zip(fans.iter_mut()) {
            self.mesh.fan(v, fan);
        }
        let Some((end, target)) = self.place_of_collapse(&hinge, fans) else { return false };
        if end == 1 {
            hinge.ends.swap(0, 1);
            fans.swap(0, 1);
        }
        if !self.keeps_surface(&hinge, fans) || !self.plan_collapse(&hinge, fans, target) {
            return false;
        }
        if !self.allowed() {
            return false;
        }
        let [a, b] = hinge.ends.map(|v| v as usize);
        self.mesh.collapse(&hinge, &fans[1]);
        self.mesh.sizes[a] = self.mesh.size([a as u32, b as u32]);
        self.mesh.positions[a] = target;
        self.counts.collapses += 1;
        self.note_fan(a as u32, &mut fans[0]);
        true
    }

    /// The end that is kept, and where it comes to lie: at a vertex that is fixed or at the
    /// boundary, else in the middle.
    fn place_of_collapse(&self, hinge: &Hinge, fans: &[Fan; 2]) -> Option<(usize, Vec3)> {
        let [a, b] = hinge.ends.map(|v| self.mesh.positions[v as usize]);
        // 2: stays; 1: stays on the boundary; 0: free.
        let rank = |i: usize| match hinge.ends[i] as usize {
            v if self.mesh.fixed[v] => 2,
            _ if !fans[i].is_open => 0,
            v if is_boundary_smooth(&self.mesh, v as u32, &fans[i]) => 1,
            _ => 2,
        };
        match [rank(0), rank(1)] {
            [2, 2] => None,
            [m, n] if m > n => Some((0, a)),
            [m, n] if m < n => Some((1, b)),
            _ => Some((0, lerp(a, b, 0.5))),
        }
    }

    /// Whether the surface keeps its topology (the link condition).
    fn keeps_surface(&self, hinge: &Hinge, [first, second]: &[Fan; 2]) -> bool {
        let opposite = hinge.opposite;
        let at_boundary = hinge.twin == NONE;
        if first.is_open && second.is_open && !at_boundary {
            return false;
        }
        let common = first.ring.iter().filter(|v| second.ring.contains(v)).count();
        if common != if at_boundary { 1 } else { 2 } || opposite[0] == opposite[1] {
            return false;
        }
        // Opposite vertices lose a face; a closed fan keeps three, an open one keeps one.
        let mut fan = Fan::default();
        opposite.iter().filter(|v| **v != NONE).all(|v| {
            self.mesh.fan(*v, &mut fan);
            fan.corners.len() > if fan.is_open { 1 } else { 3 }
        }) && first.corners.len() + second.corners.len() > if at_boundary { 3 } else { 6 }
    }

    /// Prepares the replacement. False if a face would turn, or get long or flat.
    fn plan_collapse(&mut self, hinge: &Hinge, fans: &[Fan; 2], target: Vec3) -> bool {
        let mesh = &self.mesh;
        let gone = [hinge.halfedge, hinge.twin].map(|h| if h == NONE { NONE } else { h / 3 });
        self.replacement.clear();
        self.replacement.removed.extend(gone.into_iter().filter(|f| *f != NONE));
        let size = mesh.size(hinge.ends);
        for &corner in fans.iter().flat_map(|fan| &fan.corners).filter(|c| !gone.contains(&(**c / 3))) {
            let before = mesh.triangle(corner / 3);
            let mut after = before;
            after[corner as usize % 3] = target;
            let longest = longest_side(&after);
            if !turns_little(&before, &after) || longest > LONG * size || is_flatter(&before, &after) {
                return false;
            }
            let [p, q, r] = before;
            self.replacement.removed.push(corner / 3);
            self.replacement.added.push(after);
            self.replacement.between.push([p, q, r, target]);
        }
        true
    }

    /// Flips edges until all are Delaunay, except where faces would turn or touch others.
    pub fn flip_to_delaunay(&mut self) -> Result<(), NumericError> {
        let mut stack: Vec<u32> = self.mesh.hinges().map(|hinge| hinge.halfedge).collect();
        stack.reverse();
        let most = MOST_FLIPS * stack.len();
        let mut fan = Fan::default();
        let mut step = 0;
        while let Some(halfedge) = stack.pop() {
            step += 1;
            check_step(step)?;
            if !self.mesh.is_alive(halfedge / 3) || step > most {
                continue;
            }
            let hinge = self.mesh.hinge(halfedge);
            if hinge.twin == NONE || !self.should_flip(&hinge) || !self.can_flip(&hinge, &mut fan) {
                continue;
            }
            self.mesh.flip(&hinge);
            self.counts.flips += 1;
            let faces = [hinge.halfedge, hinge.twin].map(|h| h / 3);
            for face in faces {
                self.note(face);
            }
            stack.extend(faces.into_iter().flat_map(|f| (0..3).map(move |k| 3 * f + k)));
        }
        Ok(())
    }

    /// Whether the angles opposite to an edge add up to more than 180 degrees.
    fn should_flip(&self, hinge: &Hinge) -> bool {
        let [a, b] = hinge.ends.map(|v| self.mesh.positions[v as usize]);
        let cotan = |v: u32| {
            let p = self.mesh.positions[v as usize];
            let (s, t) = (sub(a, p), sub(b, p));
            dot(s, t) / norm(cross(s, t))
        };
        // The margin keeps rounding from flipping a square for ever.
        cotan(hinge.opposite[0]) + cotan(hinge.opposite[1]) < -1e-9
    }

    fn can_flip(&mut self, hinge: &Hinge, fan: &mut Fan) -> bool {
        let mesh = &self.mesh;
        let ([a, b], [c, d]) = (hinge.ends, hinge.opposite);
        mesh.fan(c, fan);
        if c == d || fan.ring.contains(&d) {
            return false;
        }
        let [p, q, r, s] = [a, b, c, d].map(|v| mesh.positions[v as usize]);
        let before = [[p, q, r], [q, p, s]];
        let after = [[p, s, r], [s, q, r]];
        let good = before.iter().all(|t| after.iter().all(|u| turns_little(t, u)))
            && !after.iter().any(|u| before.iter().all(|t| is_flatter(t, u)));
        if !good {
            return false;
        }
        self.replacement.clear();
        self.replacement.removed.extend([hinge.halfedge / 3, hinge.twin / 3]);
        self.replacement.added.extend(after);
        self.replacement.between.push([p, q, r, s]);
        self.allowed()
    }

    /// Whether the surface stays free of collisions.
    fn allowed(&mut self) -> bool {
        if !self.options.collisions {
            return true;
        }
        let clears = self.options.barrier.as_deref().is_none_or(|barrier| {
            let removed = self.replacement.removed.iter().map(|f| self.mesh.triangle(*f));
            barrier::allows(barrier, &removed.collect::<Vec<_>>(), &self.replacement)
        });
        let obstacle = self.options.obstacle.as_ref();
        let guard = self.guard.get_or_insert_with(|| Guard::new(&self.mesh, obstacle));
        let allowed = clears && guard.allows(&self.mesh, &self.replacement);
        self.counts.refused += usize::from(!allowed);
        allowed
    }

    fn note_fan(&mut self, vertex: u32, fan: &mut Fan) {
        self.mesh.fan(vertex, fan);
        for corner in &fan.corners {
            self.note(corner / 3);
        }
    }

    fn note(&mut self, face: u32) {
        if let Some(guard) = &mut self.guard {
            guard.insert(face, &self.mesh.triangle(face));
        }
    }
}

/// Whether the boundary goes nearly straight at a vertex with an open fan.
fn is_boundary_smooth(mesh: &Changing, vertex: u32, fan: &Fan) -> bool {
    let p = mesh.positions[vertex as usize];
    let [Some(before), Some(after)] = [fan.ring.first(), fan.ring.last()] else { return false };
    let (s, t) = (sub(p, mesh.positions[*before as usize]), sub(mesh.positions[*after as usize], p));
    dot(s, t) > SMOOTH_BOUNDARY * norm(s) * norm(t)
}

fn doubled_normal([a, b, c]: &[Vec3; 3]) -> Vec3 {
    cross(sub(*b, *a), sub(*c, *a))
}

pub(super) fn turns_little(before: &[Vec3; 3], after: &[Vec3; 3]) -> bool {
    let (m, n) = (doubled_normal(before), doubled_normal(after));
    dot(m, n) > LEAST_COSINE * norm(m) * norm(n)
}

fn longest_side([a, b, c]: &[Vec3; 3]) -> f64 {
    distance(*a, *b).max(distance(*b, *c)).max(distance(*c, *a))
}

/// Whether a face becomes flat: flatter than it was, too.
fn is_flatter(before: &[Vec3; 3], after: &[Vec3; 3]) -> bool {
    let flatness = |t: &[Vec3; 3]| norm(doubled_normal(t)) / longest_side(t).powi(2);
    flatness(after) < FLATTEST.min(flatness(before))
}

/// The mean of the corners.
pub(super) fn centroid([a, b, c]: &[Vec3; 3]) -> Vec3 {
    scale(add(add(*a, *b), *c), 1.0 / 3.0)
}
