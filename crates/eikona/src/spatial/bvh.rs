//! Bounding volume hierarchy of axis-aligned boxes over the triangles of a mesh.

use super::closest::{ClosestPoint, closest_point_of_triangle};
use eikona_mesh::{Face, TriangleMesh};

/// Most faces per leaf. Four triangles cost about as much as one more level of boxes.
const LEAF_FACES: usize = 4;

/// Bounding volume hierarchy over the triangles of a mesh.
///
/// It copies the corners, so the mesh need not stay alive.
///
/// ```
/// use eikona::spatial::Bvh;
/// use eikona_mesh::{Face, TriangleMesh};
/// let mesh = TriangleMesh::new(vec![[0., 0., 0.], [3., 0., 0.], [0., 3., 0.]], vec![[0, 1, 2]])?;
/// let closest = Bvh::new(&mesh).closest_point([1.0, 1.0, 2.0]).unwrap();
/// assert_eq!((closest.face, closest.position, closest.distance), (Face(0), [1.0, 1.0, 0.0], 2.0));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Bvh {
    /// Nodes in depth-first order: the first child of an inner node follows it.
    nodes: Vec<Node>,
    /// Faces in the order of the leaves; their corners are in the same order.
    faces: Vec<Face>,
    triangles: Vec<[[f64; 3]; 3]>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    low: [f64; 3],
    high: [f64; 3],
    /// Leaf: first face. Inner node: second child.
    index: u32,
    /// Number of faces of a leaf, 0 for an inner node.
    count: u32,
}

/// Centre of a face's box, relative to the mesh's box, and the face. Choosing a split needs no more
/// digits, and the small record halves the build time.
type Centre = ([f32; 3], u32);

impl Bvh {
    /// Builds the hierarchy.
    ///
    /// # Cost
    /// O(F log F), about half a second per million faces; about 150 bytes per face.
    pub fn new(mesh: &TriangleMesh) -> Self {
        let (low, high) = bounds(mesh.triangles().iter().flatten().map(|&v| mesh.positions()[v as usize]));
        let mut centres: Vec<Centre> = mesh
            .faces()
            .map(|f| {
                let p = mesh.face_positions(f);
                let centre = |k: usize| {
                    let [a, b, c] = [p[0][k], p[1][k], p[2][k]];
                    let middle = 0.5 * a.min(b).min(c) + 0.5 * a.max(b).max(c);
                    let share = (middle - low[k]) / (high[k] - low[k]);
                    if share > 0.0 { share as f32 } else { 0.0 } // NaN where the mesh is flat
                };
                ([centre(0), centre(1), centre(2)], f.0)
            })
            .collect();
        let extent = [0, 1, 2].map(|k| high[k] - low[k]);
        let mut nodes = Vec::with_capacity(centres.len());
        if !centres.is_empty() {
            build(mesh, extent, &mut centres, 0, &mut nodes);
        }
        let faces: Vec<Face> = centres.iter().map(|c| Face(c.1)).collect();
        let triangles = faces.iter().map(|&f| mesh.face_positions(f)).collect();
        Bvh { nodes, faces, triangles }
    }

    /// Returns the point of the mesh closest to `p`; `None` if the mesh has no faces or `p` is not
    /// finite.
    ///
    /// Exact up to rounding. Among equally close faces, the one with the lowest id is returned.
    ///
    /// # Cost
    /// O(log F) for points near the surface.
    pub fn closest_point(&self, p: [f64; 3]) -> Option<ClosestPoint> {
        let root = self.nodes.first()?;
        if !p.iter().all(|x| x.is_finite()) {
            return None;
        }
        // Boxes excluded only by rounding must be visited too, so that ties go to the lowest id.
        let largest = |x: &[f64; 3]| x.iter().fold(0.0f64, |m, v| m.max(v.abs()));
        let slack = 8.0 * f64::EPSILON * (largest(&p) + largest(&root.low).max(largest(&root.high)));
        let mut best: Option<ClosestPoint> = None;
        let mut best_sq = f64::INFINITY;
        let mut reach_sq = f64::INFINITY;
        let mut stack = vec![(0u32, root.distance_sq(p))];
        while let Some((n, box_sq)) = stack.pop() {
            if box_sq > reach_sq {
                continue;
            }
            let node = &self.nodes[n as usize];
            if node.count == 0 {
                let (first, second) = (n + 1, node.index);
                let d = [first, second].map(|c| self.nodes[c as usize].distance_sq(p));
                let mut children = [(first, d[0]), (second, d[1])];
                if d[0] <= d[1] {
                    children.swap(0, 1); // the nearer child is pushed last and visited first
                }
                stack.extend(children.into_iter().filter(|c| c.1 <= reach_sq));
                continue;
            }
            for i in node.index as usize..(node.index + node.count) as usize {
                let (weights, position, distance_sq) = closest_point_of_triangle(p, self.triangles[i]);
                let face = self.faces[i];
                if distance_sq < best_sq || (distance_sq == best_sq && best.is_none_or(|b| face < b.face)) {
                    best_sq = distance_sq;
                    let distance = distance_sq.sqrt();
                    reach_sq = (distance + slack).powi(2);
                    best = Some(ClosestPoint { face, weights, position, distance });
                }
            }
        }
        best
    }
}

impl Node {
    fn distance_sq(&self, p: [f64; 3]) -> f64 {
        let mut sum = 0.0;
        for k in 0..3 {
            let d = (self.low[k] - p[k]).max(p[k] - self.high[k]).max(0.0);
            sum += d * d;
        }
        sum
    }
}

fn bounds(points: impl Iterator<Item = [f64; 3]>) -> ([f64; 3], [f64; 3]) {
    points.fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(low, high), p| {
        ([0, 1, 2].map(|k| low[k].min(p[k])), [0, 1, 2].map(|k| high[k].max(p[k])))
    })
}

/// Appends the hierarchy over these faces, which start at index `first` of the leaf order. Median
/// splits bound the depth by log2 F.
fn build(mesh: &TriangleMesh, extent: [f64; 3], centres: &mut [Centre], first: usize, nodes: &mut Vec<Node>) {
    let here = nodes.len();
    nodes.push(Node { low: [0.0; 3], high: [0.0; 3], index: first as u32, count: centres.len() as u32 });
    if centres.len() <= LEAF_FACES {
        let (low, high) = bounds(centres.iter().flat_map(|c| mesh.face_positions(Face(c.1))));
        nodes[here] = Node { low, high, ..nodes[here] };
        return;
    }
    let (mut low, mut high) = (centres[0].0, centres[0].0);
    for (c, _) in centres.iter() {
        for k in 0..3 {
            low[k] = low[k].min(c[k]);
            high[k] = high[k].max(c[k]);
        }
    }
    let width = [0, 1, 2].map(|k| (high[k] - low[k]) as f64 * extent[k]);
    let widest = (0..3).max_by(|&i, &j| width[i].total_cmp(&width[j])).unwrap_or(0);
    let half = centres.len() / 2;
    // Shares are nonnegative, so their bits sort like their values; the face breaks ties.
    centres.select_nth_unstable_by_key(half, |c| (c.0[widest].to_bits() as u64) << 32 | c.1 as u64);
    let (left, right) = centres.split_at_mut(half);
    build(mesh, extent, left, first, nodes);
    let second = nodes.len();
    build(mesh, extent, right, first + half, nodes);
    let (a, b) = (nodes[here + 1], nodes[second]);
    let (low, high) = bounds([a.low, a.high, b.low, b.high].into_iter());
    nodes[here] = Node { low, high, index: second as u32, count: 0 };
}
