//! Spatial search for vertices near a point or a segment, with a tolerance per vertex.

use crate::id::Vertex;

/// A k-d tree of vertices, some of which are active. Its height is logarithmic for any positions,
/// including equal ones.
///
/// Active vertices of tolerance `s` or more that are more than `s` apart are met a bounded number
/// of times per scale `s`, so a search costs O(log n) whatever the other vertices are.
pub(crate) struct NearVertices {
    /// Position, vertex and tolerance; the children of a node halve its range.
    points: Vec<([f64; 3], Vertex, f64)>,
    /// The bounding box of each node's points.
    boxes: Vec<[[f64; 3]; 2]>,
    /// The largest tolerance of each node's active points; negative if there are none.
    reach: Vec<f64>,
    active: Vec<bool>,
    /// The position of each vertex in `points`, by the order in which the vertices were given.
    place: Vec<u32>,
}

const LEAF: usize = 8;

impl NearVertices {
    /// Builds the tree, with no vertex active yet.
    pub(crate) fn new(vertices: impl Iterator<Item = ([f64; 3], Vertex, f64)>) -> NearVertices {
        let mut points: Vec<_> = vertices.enumerate().map(|(i, p)| (p, i as u32)).collect();
        let nodes = 2 * points.len().div_ceil(LEAF).next_power_of_two();
        let mut boxes = vec![[[0.0; 3]; 2]; nodes];
        build(&mut points, &mut boxes, 1);
        let mut place = vec![0; points.len()];
        points.iter().enumerate().for_each(|(at, (_, given))| place[*given as usize] = at as u32);
        NearVertices {
            active: vec![false; points.len()],
            points: points.into_iter().map(|(p, _)| p).collect(),
            reach: vec![-1.0; nodes],
            boxes,
            place,
        }
    }

    /// Activates the vertex that was given at this position.
    pub(crate) fn activate(&mut self, given: usize) {
        let at = self.place[given] as usize;
        self.active[at] = true;
        let tolerance = self.points[at].2;
        let (mut node, mut low, mut high) = (1, 0, self.points.len());
        loop {
            self.reach[node] = self.reach[node].max(tolerance);
            if high - low <= LEAF {
                return;
            }
            let middle = usize::midpoint(low, high);
            (node, low, high) =
                if at < middle { (2 * node, low, middle) } else { (2 * node + 1, middle, high) };
        }
    }

    /// Visits the active vertices, with their tolerances, that may lie within `min(their tolerance,
    /// within)` of a segment: those near its bounding box, clipped to the leaves of the tree.
    pub(crate) fn near_segment(
        &self,
        ends: [[f64; 3]; 2],
        within: f64,
        mut visit: impl FnMut([f64; 3], Vertex, f64),
    ) {
        let mut stack = vec![(1, 0, self.points.len())];
        while let Some((node, low, high)) = stack.pop() {
            let reach = self.reach[node].min(within);
            if reach < 0.0 || !box_meets_segment(&self.boxes[node], ends, reach) {
                continue;
            }
            if high - low <= LEAF {
                for at in (low..high).filter(|&at| self.active[at]) {
                    let (position, vertex, tolerance) = self.points[at];
                    visit(position, vertex, tolerance);
                }
                continue;
            }
            let middle = usize::midpoint(low, high);
            stack.push((2 * node + 1, middle, high));
            stack.push((2 * node, low, middle));
        }
    }
}

fn build(points: &mut [(([f64; 3], Vertex, f64), u32)], boxes: &mut [[[f64; 3]; 2]], node: usize) {
    let Some(((first, ..), _)) = points.first() else { return };
    let mut bounds = [*first, *first];
    for ((p, ..), _) in points.iter() {
        for k in 0..3 {
            bounds[0][k] = bounds[0][k].min(p[k]);
            bounds[1][k] = bounds[1][k].max(p[k]);
        }
    }
    boxes[node] = bounds;
    if points.len() <= LEAF {
        return;
    }
    let extent = |k: usize| bounds[1][k] - bounds[0][k];
    let axis = (1..3).fold(0, |best, k| if extent(k) > extent(best) { k } else { best });
    let middle = points.len() / 2;
    points.select_nth_unstable_by(middle, |a, b| a.0.0[axis].total_cmp(&b.0.0[axis]).then(a.1.cmp(&b.1)));
    let (left, right) = points.split_at_mut(middle);
    build(left, boxes, 2 * node);
    build(right, boxes, 2 * node + 1);
}

/// Returns whether a segment comes within `reach` of a box in each coordinate. Errs slightly on the
/// side of `true`.
fn box_meets_segment(bounds: &[[f64; 3]; 2], [a, b]: [[f64; 3]; 2], reach: f64) -> bool {
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    for k in 0..3 {
        // Rounding of coordinates of either must not hide a point that lies on the segment.
        let slack = reach + 1e-15 * (a[k].abs().max(b[k].abs()));
        let (low, high) = (bounds[0][k] - slack, bounds[1][k] + slack);
        let step = b[k] - a[k];
        if step == 0.0 {
            if a[k] < low || a[k] > high {
                return false;
            }
            continue;
        }
        let (s, t) = ((low - a[k]) / step, (high - a[k]) / step);
        enter = enter.max(s.min(t));
        leave = leave.min(s.max(t));
    }
    enter <= leave + 1e-12
}
