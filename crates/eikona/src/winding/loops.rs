//! Decomposition of closed jumps into loops.

use crate::winding::decomposition::THRESHOLD;
use eikona_mesh::{Edge, Halfedge, Neighbour, TriangleMesh, Vertex};

/// A closed polyline along edges, or one from boundary to boundary, across which a function jumps.
#[derive(Clone, Debug, PartialEq)]
pub struct JumpLoop {
    /// The vertices, with the higher value on the left of the first step, by the orientation of the
    /// face there; left is transported along the loop. Closed if the last is the first.
    pub vertices: Vec<Vertex>,
    /// The height of the jump: an integer for boundaries of regions and for closed curves.
    pub jump: f64,
}

/// A step along an edge, with the halfedge of the face where the function is higher.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Step {
    high: Halfedge,
    /// In the direction of that halfedge.
    forward: bool,
}

/// Decomposes jumps into loops, starting at the highest edges. Leaves out loops with a jump of at
/// most [`THRESHOLD`].
///
/// The jump of an edge is the value in its first face minus that in its second; jumps sum to zero
/// around each inner vertex.
///
/// # Cost
/// Each loop uses up the jump of at least one edge. Worst case: the number of edges with a jump
/// times the length of a loop; usually the total length of all loops.
pub(crate) fn loops_of(mesh: &TriangleMesh, jump: impl Fn(Edge) -> f64) -> Vec<JumpLoop> {
    let mut left: Vec<f64> =
        mesh.edges().map(|e| if mesh.edge_halfedges(e).len() == 2 { jump(e) } else { 0.0 }).collect();
    // Rounding errors of sums must not leave edges behind.
    let largest = left.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let nothing = 1e-7 * largest.max(1.0);
    let mut edges: Vec<Edge> = mesh.edges().filter(|e| left[e.index()].abs() > nothing).collect();
    edges.sort_by(|a, b| left[b.index()].abs().total_cmp(&left[a.index()].abs()).then(a.cmp(b)));
    let mut place = vec![NONE; mesh.edge_count()];
    let mut result = Vec::new();
    for first in edges {
        while left[first.index()].abs() > nothing {
            let path = walk(mesh, &left, nothing, first, &mut place);
            let edge = |step: &Step| mesh.edge(step.high);
            let height = path.iter().map(|s| left[edge(s).index()].abs()).fold(f64::INFINITY, f64::min);
            for step in &path {
                let x = &mut left[edge(step).index()];
                *x -= height.copysign(*x);
            }
            if height > THRESHOLD {
                let ends = |s: &Step| {
                    let (a, b) = (mesh.origin(s.high), mesh.tip(s.high));
                    if s.forward { [a, b] } else { [b, a] }
                };
                let mut vertices = vec![ends(&path[0])[0]];
                vertices.extend(path.iter().map(|s| ends(s)[1]));
                result.push(JumpLoop { vertices, jump: height });
            }
        }
    }
    result
}

/// Marks edges that are not on the walk.
const NONE: i32 = i32::MIN;

/// Walks from an edge along edges with a jump until one of them recurs or the boundary is reached;
/// in the latter case also backwards from the first edge. Returns the loop found. `place` is all
/// [`NONE`] before and after.
fn walk(mesh: &TriangleMesh, left: &[f64], nothing: f64, first: Edge, place: &mut [i32]) -> Vec<Step> {
    let high = mesh.edge_halfedges(first)[usize::from(left[first.index()] < 0.0)];
    // Steps ahead have places 0, 1, ..; steps behind the first one have -1, -2, ...
    let mut ahead = vec![Step { high, forward: true }];
    let mut behind: Vec<Step> = Vec::new();
    place[first.index()] = 0;
    let mut meeting: Option<Vec<Step>> = None;
    while let (None, Some(next)) = (&meeting, next_step(mesh, left, nothing, ahead[ahead.len() - 1])) {
        let at = &mut place[mesh.edge(next.high).index()];
        if *at == NONE {
            *at = ahead.len() as i32;
            ahead.push(next);
        } else {
            meeting = Some(ahead[*at as usize..].to_vec());
        }
    }
    // Going backwards reverses every step.
    let reversed = |s: &Step| Step { forward: !s.forward, ..*s };
    let before =
        |behind: &[Step]| next_step(mesh, left, nothing, *behind.last().unwrap_or(&reversed(&ahead[0])));
    while let (None, Some(step)) = (&meeting, before(&behind)) {
        let at = &mut place[mesh.edge(step.high).index()];
        if *at == NONE {
            behind.push(step);
            *at = -(behind.len() as i32);
        } else if *at < 0 {
            meeting = Some(behind[(-1 - *at) as usize..].iter().rev().map(reversed).collect());
        } else {
            let to_first = behind.iter().rev().map(reversed);
            meeting = Some(to_first.chain(ahead[..=*at as usize].iter().copied()).collect());
        }
    }
    ahead.iter().chain(&behind).for_each(|s| place[mesh.edge(s.high).index()] = NONE);
    meeting.unwrap_or_else(|| behind.iter().rev().map(reversed).chain(ahead).collect())
}

/// Returns the next edge around the vertex at the end of a step, starting from the step's higher
/// side, whose higher side faces the side from which it is reached. `None` if the faces around the
/// vertex end first.
fn next_step(mesh: &TriangleMesh, left: &[f64], nothing: f64, step: Step) -> Option<Step> {
    let vertex = if step.forward { mesh.tip(step.high) } else { mesh.origin(step.high) };
    let mut side = step.high;
    for _ in 0..mesh.vertex_corners(vertex).len() {
        // The other edge of the face at the vertex.
        side = if mesh.tip(side) == vertex { side.next() } else { side.previous() };
        let edge = mesh.edge(side);
        let Neighbour::Twin(other) = mesh.neighbour(side) else { return None };
        let x = left[edge.index()];
        let high = mesh.edge_halfedges(edge)[usize::from(x < 0.0)];
        if x.abs() > nothing && high == side {
            return Some(Step { high, forward: mesh.origin(side) == vertex });
        }
        side = other;
    }
    None
}
