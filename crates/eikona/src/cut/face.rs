//! Cuts one face along its curves: splits them into segments that meet only at vertices, each an
//! edge of a triangulation.
//!
//! Segments are inserted one after another. A segment that passes within [`NEAR`] of a vertex goes
//! through it, two that cross are both cut at the crossing, and pieces become edges by flips. All
//! of this is stored as *detours*: the edge from `a` to `b` goes by way of `c`. A detour always
//! leads to shorter pieces, so insertion terminates; at the end each segment is read off by
//! following its detours. Overlapping segments thereby share the same pieces.

use super::triangulation::{ByPair, ONE, Point, Triangulation, turn};
use eikona_mesh::random::Random;
use std::collections::{HashMap, VecDeque};

/// Vertices nearer than this are merged, in units of an edge.
pub(super) const SAME: f64 = 1e-9;
/// A segment nearer to a vertex than this goes through it. Half of [`SAME`], so that no vertex is
/// near to two others.
const NEAR: f64 = 0.5e-9;
/// A crossing nearer to a vertex than this moves onto it. It exceeds the largest distance of a
/// crossing within [`SAME`] of a side from a point of the side that is within [`SAME`] of its foot.
const CROSSING_AT_VERTEX: f64 = 2e-9;

/// The contents of a face.
pub(super) struct FaceCurves {
    /// Sides 01 and 02 in the plane of the face, in units of its longest side.
    pub axes: [[f64; 2]; 2],
    /// Points on the sides 01, 12, 20, each in order from its first to its second corner, in units
    /// of 1 / [`ONE`].
    pub sides: [Vec<i64>; 3],
    /// Points inside.
    pub inside: Vec<Point>,
    /// Segments between points: 0 to 2 for the corners, then those on the sides, then those inside.
    pub segments: Vec<[u32; 2]>,
    /// Whether another face has the same three corners, so that an edge between two points of the
    /// sides could be mistaken for one of that face.
    pub doubled: bool,
}

/// A face cut along its curves.
pub(super) struct FaceCut {
    /// Triangles oriented like the face. Vertices are numbered as in [`FaceCurves`] up to the
    /// sides; then come those of `inside`.
    pub triangles: Vec<[u32; 3]>,
    /// The vertices inside.
    pub inside: Vec<Point>,
    /// The vertex of each point inside; coinciding points share one.
    pub vertex_of_point: Vec<u32>,
    /// The vertices along each segment; a single one if its ends coincide.
    pub chains: Vec<Vec<u32>>,
}

/// Why a face was not cut.
pub(super) enum Stop {
    /// Segments cross so near to a side that the other faces there need the crossings, too: sides
    /// and positions on them.
    OnSides(Vec<(usize, i64)>),
    /// The curves are too close together to be ordered.
    Tangled,
}

/// Returns the coordinates of a point on a side.
pub(super) fn on_side(side: usize, s: i64) -> Point {
    match side {
        0 => [s, 0],
        1 => [ONE - s, s],
        _ => [0, ONE - s],
    }
}

/// Cuts a face along its curves.
pub(super) fn cut_face(curves: &FaceCurves) -> Result<FaceCut, Stop> {
    let mut work = Arrangement {
        mesh: Triangulation::new(curves.axes),
        fixed: ByPair::default(),
        detours: ByPair::default(),
        cells: HashMap::new(),
        pending: Vec::new(),
        asked: Vec::new(),
    };
    (0..3).for_each(|v| work.note_cell(v));
    for (side, points) in curves.sides.iter().enumerate() {
        for &s in points {
            work.push(on_side(side, s));
        }
    }
    let rim = work.mesh.points.len() as u32;
    let vertex_of_point: Vec<u32> = curves
        .inside
        .iter()
        .map(|&p| work.near(p, SAME).first().copied().unwrap_or_else(|| work.push(p)))
        .collect();
    // Inserted in order along a curve, each point may flip edges to all points before it; in random
    // order the flips are a few per point.
    let mut order: Vec<u32> = (3..work.mesh.points.len() as u32).collect();
    Random::from_seed(0).shuffle(&mut order);
    for v in order {
        work.mesh.insert(v, |_, _| false).ok_or(Stop::Tangled)?;
    }
    let vertex = |i: u32| if i < rim { Some(i) } else { vertex_of_point.get((i - rim) as usize).copied() };
    let mut segments = Vec::with_capacity(curves.segments.len());
    for &[a, b] in &curves.segments {
        let ends = [vertex(a).ok_or(Stop::Tangled)?, vertex(b).ok_or(Stop::Tangled)?];
        segments.push(ends);
        work.pending.push(ends);
        work.settle()?;
    }
    if !work.asked.is_empty() {
        return Err(Stop::OnSides(work.asked));
    }
    work.mesh.improve(work.mesh.edges(), |a, b| work.fixed.contains_key(&key(a, b)));
    if curves.doubled {
        work.divide_chords(rim)?;
    }
    let chains = segments.iter().map(|&s| work.follow(s)).collect::<Option<_>>().ok_or(Stop::Tangled)?;
    let inside = work.mesh.points.split_off(rim as usize);
    Ok(FaceCut { triangles: work.mesh.triangles(), inside, vertex_of_point, chains })
}

/// What a segment meets first.
enum Way {
    /// It is an edge.
    Edge,
    /// It passes through this vertex.
    Through(u32),
    /// It crosses this fixed edge.
    Across([u32; 2]),
    /// It crosses these edges, which can be flipped.
    Free(Vec<[u32; 2]>),
}

struct Arrangement {
    mesh: Triangulation,
    /// Edges that are pieces of curves.
    fixed: ByPair<()>,
    /// The vertex through which each detoured edge goes.
    detours: ByPair<u32>,
    /// Vertices by grid cell.
    cells: HashMap<Point, Vec<u32>>,
    /// Segments not yet inserted.
    pending: Vec<[u32; 2]>,
    /// Sides and positions on them where vertices are needed.
    asked: Vec<(usize, i64)>,
}

impl Arrangement {
    fn point(&self, v: u32) -> Point {
        self.mesh.points[v as usize]
    }

    fn push(&mut self, p: Point) -> u32 {
        let v = self.mesh.push(p);
        self.note_cell(v);
        v
    }

    fn note_cell(&mut self, v: u32) {
        self.cells.entry(cell(self.point(v))).or_default().push(v);
    }

    /// Returns the vertices within a distance, nearest first.
    fn near(&self, p: Point, within: f64) -> Vec<u32> {
        let [x, y] = cell(p);
        let mut found: Vec<(f64, u32)> = Vec::new();
        for [i, j] in (x - 1..=x + 1).flat_map(|i| (y - 1..=y + 1).map(move |j| [i, j])) {
            let vertices = self.cells.get(&[i, j]).map_or(&[][..], |c| c).iter();
            found.extend(vertices.map(|&v| (separation(p, self.point(v)), v)).filter(|f| f.0 <= within));
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        found.into_iter().map(|f| f.1).collect()
    }

    /// Routes an edge through a vertex and queues its two pieces.
    fn detour(&mut self, a: u32, b: u32, by: u32) {
        self.fixed.remove(&key(a, b));
        self.detours.insert(key(a, b), by);
        self.pending.extend([[by, b], [a, by]]);
    }

    /// Whether a detour leads to shorter pieces.
    fn shortens(&self, a: u32, b: u32, by: u32) -> bool {
        let [a, b, by] = [a, b, by].map(|v| self.point(v));
        let whole = squared(a, b);
        squared(a, by) < whole && squared(by, b) < whole
    }

    /// Inserts all pending segments.
    fn settle(&mut self) -> Result<(), Stop> {
        while let Some([a, b]) = self.pending.pop() {
            // The pieces of an existing detour are already inserted or pending.
            if a == b || self.fixed.contains_key(&key(a, b)) || self.detours.contains_key(&key(a, b)) {
                continue;
            }
            match self.way(a, b)? {
                Way::Edge => {
                    self.fixed.insert(key(a, b), ());
                }
                Way::Through(v) => self.detour(a, b, v),
                Way::Across([p, q]) => self.cross([a, b], [p, q])?,
                Way::Free(edges) => {
                    self.flip_in(a, b, edges)?;
                    self.fixed.insert(key(a, b), ());
                }
            }
        }
        Ok(())
    }

    /// Walks along a segment to the first obstacle.
    fn way(&self, a: u32, b: u32) -> Result<Way, Stop> {
        if self.mesh.has_edge(a, b) {
            if self.mesh.is_rim(a, b) {
                return Ok(Way::Edge);
            }
            let near = [self.mesh.apex(a, b), self.mesh.apex(b, a)];
            let near = near.into_iter().flatten().find(|&v| self.passes(a, b, v));
            return Ok(near.map_or(Way::Edge, Way::Through));
        }
        // The triangle at `a` through which the segment leaves: its other corners lie right and
        // left of it.
        enum Leave {
            Through(u32),
            Between(u32, u32),
        }
        let leave = self.mesh.find_around(a, |right, left| {
            let (r, l) = (self.mesh.turn(a, b, right), self.mesh.turn(a, b, left));
            let ahead = |v| along(self.point(a), self.point(b), self.point(v)) > 0.0;
            if r == 0 && ahead(right) {
                Some(Leave::Through(right))
            } else if l == 0 && ahead(left) {
                Some(Leave::Through(left))
            } else {
                (r < 0 && l > 0).then_some(Leave::Between(right, left))
            }
        });
        let (mut right, mut left) = match leave.ok_or(Stop::Tangled)? {
            Leave::Through(v) => return Ok(Way::Through(v)),
            Leave::Between(right, left) => (right, left),
        };
        let mut crossed = Vec::new();
        loop {
            if let Some(v) = [right, left].into_iter().find(|&v| self.passes(a, b, v)) {
                return Ok(Way::Through(v));
            }
            if self.fixed.contains_key(&key(right, left)) {
                return Ok(Way::Across([right, left]));
            }
            crossed.push([right, left]);
            // The segment crosses from the triangle on the left of right -> left to the one on its
            // right.
            let next = self.mesh.apex(left, right).ok_or(Stop::Tangled)?;
            if next == b {
                return Ok(Way::Free(crossed));
            }
            match self.mesh.turn(a, b, next).signum() {
                0 => return Ok(Way::Through(next)),
                1 => left = next,
                _ => right = next,
            }
        }
    }

    /// Whether a segment passes so near to a vertex that it must go through it.
    fn passes(&self, a: u32, b: u32, v: u32) -> bool {
        if v == a || v == b || !self.shortens(a, b, v) {
            return false;
        }
        let [p, q, x] = [a, b, v].map(|v| self.point(v));
        let height = 0.75f64.sqrt() * turn(p, q, x).unsigned_abs() as f64
            / (separation(p, q) * (ONE as f64) * (ONE as f64));
        height <= NEAR && along(p, q, x) > 0.0 && along(q, p, x) > 0.0
    }

    /// Cuts two segments at their crossing; the second is fixed.
    fn cross(&mut self, [a, b]: [u32; 2], [p, q]: [u32; 2]) -> Result<(), Stop> {
        let crossing = {
            let [a, b, p, q] = [a, b, p, q].map(|v| self.point(v));
            let (left, right) = (turn(p, q, a) as f64, turn(p, q, b) as f64);
            let t = left / (left - right);
            [0, 1].map(|k| a[k] + (t * (b[k] - a[k]) as f64).round() as i64)
        };
        let near = self.near(crossing, CROSSING_AT_VERTEX);
        for &v in &near {
            let ends_first = v == a || v == b;
            let ends_second = v == p || v == q;
            let first = !ends_first && self.shortens(a, b, v);
            let second = !ends_second && self.shortens(p, q, v);
            if (first || ends_first) && (second || ends_second) && (first || second) {
                if second {
                    self.detour(p, q, v);
                }
                if first {
                    self.detour(a, b, v);
                } else {
                    self.pending.push([a, b]);
                }
                return Ok(());
            }
        }
        let [x, y] = crossing;
        let weights = [ONE - x - y, x, y];
        for (side, weight, s) in [(1, weights[0], y), (2, weights[1], weights[0]), (0, weights[2], x)] {
            if weight as f64 <= SAME * ONE as f64 {
                // An existing point on the side would have been near.
                if !near.is_empty() {
                    return Err(Stop::Tangled);
                }
                self.asked.push((side, s));
                // Continue, to collect all requests at once, unless rounding has put the crossing
                // onto the side.
                if weight <= 0 {
                    return Err(Stop::OnSides(std::mem::take(&mut self.asked)));
                }
            }
        }
        // The fixed edge must be released while the vertex is inserted.
        self.fixed.remove(&key(p, q));
        let v = self.push(crossing);
        let cut = self.mesh.insert(v, |c, d| self.fixed.contains_key(&key(c, d))).ok_or(Stop::Tangled)?;
        if !self.shortens(a, b, v) || !self.shortens(p, q, v) {
            return Err(Stop::Tangled);
        }
        if let Some([c, d]) = cut {
            self.detour(c, d, v);
        }
        self.detour(p, q, v);
        self.detour(a, b, v);
        // Other curves may pass near the new vertex.
        let mut near = Vec::new();
        self.mesh.find_around(v, |c, d| {
            if self.fixed.contains_key(&key(c, d)) && self.passes(c, d, v) {
                near.push([c, d]);
            }
            None::<()>
        });
        near.into_iter().for_each(|[c, d]| self.detour(c, d, v));
        Ok(())
    }

    /// Flips the edges that a segment crosses until it is an edge itself.
    fn flip_in(&mut self, a: u32, b: u32, crossed: Vec<[u32; 2]>) -> Result<(), Stop> {
        let mut new = Vec::new();
        // Each round through the queue removes at least one crossing for good.
        let mut rest = (crossed.len() + 4).saturating_pow(3);
        let mut queue = VecDeque::from(crossed);
        while let Some([c, d]) = queue.pop_front() {
            rest = rest.checked_sub(1).ok_or(Stop::Tangled)?;
            let Some([e, f]) = self.mesh.flip(c, d) else {
                queue.push_back([c, d]);
                continue;
            };
            let ends = [e, f].iter().any(|v| *v == a || *v == b);
            if !ends && (self.mesh.turn(a, b, e) > 0) != (self.mesh.turn(a, b, f) > 0) {
                queue.push_back([e, f]);
            } else {
                new.push([e, f]);
            }
        }
        if !self.mesh.has_edge(a, b) {
            return Err(Stop::Tangled);
        }
        let this = key(a, b);
        self.mesh.improve(new, |c, d| key(c, d) == this || self.fixed.contains_key(&key(c, d)));
        Ok(())
    }

    /// Inserts a vertex in the middle of every inner edge between two points of the sides.
    fn divide_chords(&mut self, rim: u32) -> Result<(), Stop> {
        for [a, b] in self.mesh.edges() {
            if b < rim && !self.mesh.is_rim(a, b) {
                let (p, q) = (self.point(a), self.point(b));
                let middle = [0, 1].map(|k| p[k] + (q[k] - p[k]) / 2);
                let v = self.mesh.insert_in_edge(a, b, middle).ok_or(Stop::Tangled)?;
                if self.fixed.contains_key(&key(a, b)) {
                    self.detours.insert(key(a, b), v);
                }
            }
        }
        Ok(())
    }

    /// Returns the vertices along a segment; `None` if a step is no edge.
    fn follow(&self, [a, b]: [u32; 2]) -> Option<Vec<u32>> {
        let mut chain = vec![a];
        let mut pieces = vec![[a, b]];
        while let Some([a, b]) = pieces.pop() {
            if a == b {
                continue;
            }
            if let Some(&v) = self.detours.get(&key(a, b)) {
                pieces.extend([[v, b], [a, v]]);
            } else if self.mesh.has_edge(a, b) {
                chain.push(b);
            } else {
                return None;
            }
        }
        Some(chain)
    }
}

fn key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// Returns the grid cell of a point. Cells are so large that everything within reach of a point
/// lies in its own cell or the eight around it.
fn cell(p: Point) -> Point {
    const SIZE: i64 = (2.0 * CROSSING_AT_VERTEX * ONE as f64) as i64;
    p.map(|x| x.div_euclid(SIZE))
}

/// Returns the squared distance in an equilateral triangle with sides of length 1, which prefers no
/// corner; exact, in grid units.
fn squared(a: Point, b: Point) -> i128 {
    let [x, y] = [0, 1].map(|k| i128::from(b[k] - a[k]));
    x * x + y * y + x * y
}

/// Returns the distance in an equilateral triangle with sides of length 1.
fn separation(a: Point, b: Point) -> f64 {
    (squared(a, b) as f64).sqrt() / ONE as f64
}

/// Returns the dot product of `a -> b` and `a -> p` in that triangle, in grid units.
fn along(a: Point, b: Point, p: Point) -> f64 {
    let [ux, uy] = [0, 1].map(|k| (b[k] - a[k]) as f64);
    let [vx, vy] = [0, 1].map(|k| (p[k] - a[k]) as f64);
    ux * vx + uy * vy + 0.5 * (ux * vy + uy * vx)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curves(inside: Vec<Point>, segments: Vec<[u32; 2]>) -> FaceCurves {
        FaceCurves {
            axes: [[1.0, 0.0], [0.3, 0.8]],
            sides: Default::default(),
            inside,
            segments,
            doubled: false,
        }
    }

    fn check(curves: &FaceCurves) -> FaceCut {
        let Ok(cut) = cut_face(curves) else { panic!("the face is not cut") };
        let mut points = vec![[0, 0], [ONE, 0], [0, ONE]];
        for (side, on) in curves.sides.iter().enumerate() {
            points.extend(on.iter().map(|&s| on_side(side, s)));
        }
        points.extend(&cut.inside);
        // All triangles are positive, and their areas sum up exactly, since areas on the grid are
        // integers.
        let areas: Vec<i128> = cut
            .triangles
            .iter()
            .map(|t| turn(points[t[0] as usize], points[t[1] as usize], points[t[2] as usize]))
            .collect();
        assert!(areas.iter().all(|&a| a > 0));
        assert_eq!(areas.iter().sum::<i128>(), i128::from(ONE) * i128::from(ONE));
        for chain in &cut.chains {
            for step in chain.windows(2) {
                assert!(cut.triangles.iter().any(|t| step.iter().all(|v| t.contains(v))));
            }
        }
        cut
    }

    fn at(x: f64, y: f64) -> Point {
        [x, y].map(|x| (x * ONE as f64).round() as i64)
    }

    #[test]
    fn two_segments_share_their_crossing() {
        let points = vec![at(0.1, 0.1), at(0.4, 0.4), at(0.1, 0.4), at(0.4, 0.1)];
        let cut = check(&curves(points, vec![[3, 4], [5, 6]]));
        assert_eq!(cut.inside.len(), 5);
        assert_eq!(cut.chains[0][1], cut.chains[1][1]);
        assert!((0..2).all(|k| (cut.inside[4][k] - ONE / 4).abs() <= 1));
    }

    #[test]
    fn overlapping_segments_share_their_edges() {
        let points = vec![at(0.1, 0.2), at(0.5, 0.2), at(0.3, 0.2), at(0.7, 0.2)];
        let cut = check(&curves(points, vec![[3, 4], [6, 5], [3, 6]]));
        assert_eq!(cut.chains, [vec![3, 5, 4], vec![6, 4, 5], vec![3, 5, 4, 6]]);
    }

    #[test]
    fn near_misses_are_merged() {
        // The third point lies 1e-12 beside the segment; the fourth 1e-12 from its end.
        let points = vec![at(0.1, 0.2), at(0.5, 0.2), at(0.3, 0.2 + 1e-12), at(0.5 + 1e-12, 0.2)];
        let cut = check(&curves(points, vec![[3, 4], [5, 6]]));
        assert_eq!(cut.vertex_of_point, [3, 4, 5, 4]);
        assert_eq!(cut.chains, [vec![3, 5, 4], vec![5, 4]]);
    }

    #[test]
    fn a_crossing_beside_a_side_is_requested_on_it() {
        // Both start on the side and rise by 8e-9 of their length in opposite directions: they
        // cross at a height of 4e-10.
        let mut face = curves(vec![at(0.5, 2.4e-9), at(0.05, 2.0e-9)], vec![[3, 5], [4, 6]]);
        face.sides[0] = vec![at(0.2, 0.0)[0], at(0.3, 0.0)[0]];
        let Err(Stop::OnSides(asked)) = cut_face(&face) else { panic!("not asked for") };
        let [(0, s)] = asked[..] else { panic!("asked for {asked:?}") };
        assert!((s as f64 / ONE as f64 - 0.25).abs() < 1e-3);
        // Both pass through the vertex once it exists.
        face.sides[0].insert(1, s);
        face.segments = vec![[3, 6], [5, 7]];
        let cut = check(&face);
        assert!(cut.chains.iter().all(|c| c.contains(&4)));
    }
}
