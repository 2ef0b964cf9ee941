//! Finds zero isolines shorter than an edge, which rounding leaves beside curves and points.

use eikona_mesh::TriangleMesh;

/// Returns, per face, whether its part of the zero isoline, or the border of a stroke that reaches
/// into it, belongs to a connected piece shorter than an edge (the mean over the faces it crosses).
/// Empty if there is no such piece.
pub(crate) fn short_zero_isolines(mesh: &TriangleMesh, values: &[f64]) -> Vec<bool> {
    // Zeros lie at vertices and inside edges; faces connect them.
    let vertices = mesh.vertex_count();
    let mut pieces = Pieces { parent: Vec::new(), length: Vec::new(), edges: Vec::new() };
    let mut piece_of_zero = vec![NONE; vertices + mesh.edge_count()];
    let mut piece_of_face = vec![NONE; mesh.face_count()];
    for face in mesh.faces() {
        let corners = mesh.face_vertices(face);
        let value = corners.map(|v| values[v.index()]);
        let touched = value.iter().any(|x| *x <= 0.0) && value.iter().any(|x| *x >= 0.0);
        if !touched || value.iter().any(|x| !x.is_finite()) {
            continue;
        }
        let piece = pieces.add();
        piece_of_face[face.index()] = piece;
        let position = mesh.face_positions(face);
        let mut ends = Vec::with_capacity(3);
        let mut perimeter = 0.0;
        for (k, edge) in mesh.face_edges(face).into_iter().enumerate() {
            let next = (k + 1) % 3;
            let (a, b) = (value[k], value[next]);
            perimeter += distance(position[k], position[next]);
            let (zero, point) = if a == 0.0 {
                (corners[k].index(), position[k])
            } else if (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0) {
                // Halve first: the difference may overflow.
                let t = 0.5 * a / (0.5 * a - 0.5 * b);
                let between = |i: usize| position[k][i] + t * (position[next][i] - position[k][i]);
                (vertices + edge.index(), [0, 1, 2].map(between))
            } else {
                continue;
            };
            ends.push(point);
            match piece_of_zero[zero] {
                NONE => piece_of_zero[zero] = piece,
                other => pieces.join(piece, other),
            }
        }
        let length = match ends.as_slice() {
            [a, b] => distance(*a, *b),
            [_, _, _] => perimeter, // 0 everywhere
            _ => 0.0,
        };
        let root = pieces.root(piece);
        pieces.length[root] += length;
        let (sum, count) = pieces.edges[root];
        pieces.edges[root] = (sum + perimeter, count + 3);
    }
    mark_short_and_neighbours(mesh, &piece_of_face, &mut pieces)
}

fn mark_short_and_neighbours(mesh: &TriangleMesh, piece_of_face: &[u32], pieces: &mut Pieces) -> Vec<bool> {
    let (mut beside_short, mut beside_line) =
        (vec![false; mesh.vertex_count()], vec![false; mesh.vertex_count()]);
    let mut short = vec![false; mesh.face_count()];
    for face in mesh.faces() {
        let piece = piece_of_face[face.index()];
        if piece == NONE {
            continue;
        }
        let is_short = pieces.is_short(piece);
        short[face.index()] = is_short;
        let beside = if is_short { &mut beside_short } else { &mut beside_line };
        mesh.face_vertices(face).iter().for_each(|v| beside[v.index()] = true);
    }
    if !short.contains(&true) {
        return Vec::new();
    }
    for face in mesh.faces().filter(|f| piece_of_face[f.index()] == NONE) {
        let corners = mesh.face_vertices(face);
        let beside = |which: &[bool]| corners.iter().any(|v| which[v.index()]);
        short[face.index()] = beside(&beside_short) && !beside(&beside_line);
    }
    short
}

/// Marks the absence of a piece.
const NONE: u32 = u32::MAX;

/// Union-find of pieces, with their lengths and the edge lengths of their faces.
struct Pieces {
    parent: Vec<u32>,
    length: Vec<f64>,
    /// Sum of edge lengths, and number of edges.
    edges: Vec<(f64, usize)>,
}

impl Pieces {
    fn add(&mut self) -> u32 {
        let piece = self.parent.len() as u32;
        self.parent.push(piece);
        self.length.push(0.0);
        self.edges.push((0.0, 0));
        piece
    }
    fn root(&mut self, piece: u32) -> usize {
        let mut i = piece as usize;
        while self.parent[i] as usize != i {
            self.parent[i] = self.parent[self.parent[i] as usize];
            i = self.parent[i] as usize;
        }
        i
    }
    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        if a != b {
            let (low, high) = (a.min(b), a.max(b));
            self.parent[high] = low as u32;
            self.length[low] += self.length[high];
            let (sum, count) = self.edges[high];
            self.edges[low] = (self.edges[low].0 + sum, self.edges[low].1 + count);
        }
    }
    fn is_short(&mut self, piece: u32) -> bool {
        let root = self.root(piece);
        let (sum, count) = self.edges[root];
        self.length[root] * (count as f64) < sum
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1]).hypot(a[2] - b[2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use eikona_mesh::shapes::{Diagonal, grid};

    /// Faces with short zero isolines of a function on a flat grid of unit cells.
    fn field(value: impl Fn(f64, f64) -> f64) -> Vec<bool> {
        let mesh = grid(8, 8, 8.0, 8.0, Diagonal::Uniform).unwrap();
        let low = mesh.position(eikona_mesh::Vertex(0));
        let values: Vec<f64> = mesh.positions().iter().map(|p| value(p[0] - low[0], p[1] - low[1])).collect();
        short_zero_isolines(&mesh, &values)
    }

    #[test]
    fn long_lines_are_not_marked() {
        assert!(field(|x, _| x - 4.3).is_empty());
        assert!(field(|x, _| x - 4.0).is_empty(), "along edges");
        assert!(field(|_, _| 0.0).is_empty(), "everywhere");
        assert!(field(|_, _| 1.0).is_empty(), "nowhere");
        assert!(field(|x, _| if x > 3.0 { f64::NAN } else { x - 1.5 }).is_empty());
    }

    #[test]
    fn small_loops_and_points_are_marked_with_their_neighbours() {
        let at_vertex = |x: f64, y: f64, value: f64| {
            if x == 2.0 && y == 2.0 { value } else { x.max(y) }
        };
        for value in [0.0, -1e-3] {
            let short = field(|x, y| 0.1 + at_vertex(x, y, value - 0.1));
            // The six faces at the vertex, and their neighbours.
            assert!(short.iter().filter(|c| **c).count() > 6, "{value}");
        }
        assert!(
            field(|x, y| 0.1 + at_vertex(x, y, -3.0)).is_empty(),
            "a loop about as long as the boundary of its faces"
        );
    }

    #[test]
    fn a_short_loop_near_a_line_does_not_mark_the_line() {
        // The line x = 5.5, and a negative dip at (2, 2).
        let dip = |x: f64, y: f64| if x == 2.0 && y == 2.0 { -1e-3 } else { 5.5 - x };
        let (with, mesh) = (field(dip), grid(8, 8, 8.0, 8.0, Diagonal::Uniform).unwrap());
        for face in mesh.faces() {
            let low = mesh.position(eikona_mesh::Vertex(0))[0];
            let middle = mesh.face_positions(face).iter().map(|p| p[0] - low).sum::<f64>() / 3.0;
            if (5.0..6.0).contains(&middle) {
                assert!(!with[face.index()], "{face}");
            }
        }
        assert!(with.contains(&true));
    }
}
