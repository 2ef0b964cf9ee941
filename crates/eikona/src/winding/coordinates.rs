//! Step 1: reduced coordinates, jumps across edges as values at corners.

use eikona_mesh::{TriangleMesh, Vertex, VertexFan};

/// Reduced coordinates of jumps around each vertex.
#[derive(Clone, Debug, Default)]
pub(crate) struct Coordinates {
    /// Value at each corner relative to the vertex's first one (*reduced coordinates*, section
    /// 2.3.1).
    pub corner: Vec<f64>,
    /// Vertices around which the jumps do not sum to zero: the curve ends there. They have no
    /// coordinates.
    pub endpoints: Vec<Vertex>,
    /// Vertices with jumps whose faces form more than one fan. They have no coordinates either.
    ///
    /// Deviation: the public program treats the curve as absent there, so that the jumps at both
    /// ends of an edge differ and the derivative is no longer a 1-form. (Tests
    /// `a_fin_gives_a_warning_and_changes_little_elsewhere`,
    /// `a_completed_loop_through_a_pinched_vertex_keeps_its_jumps`.)
    pub not_fans: Vec<Vertex>,
}

impl Coordinates {
    /// Returns the vertices that have no coordinates.
    pub fn left_out(&self) -> impl Iterator<Item = Vertex> {
        self.endpoints.iter().chain(&self.not_fans).copied()
    }

    /// Coordinates of the zero chain.
    pub fn none(mesh: &TriangleMesh) -> Coordinates {
        Coordinates { corner: vec![0.0; 3 * mesh.face_count()], ..Coordinates::default() }
    }

    /// Accumulates jumps around every vertex at an edge with a jump. An inner vertex around which
    /// they sum to more than `tolerance` is an endpoint.
    pub fn of(mesh: &TriangleMesh, jump: &[f64], tolerance: f64) -> Coordinates {
        let mut result = Coordinates::none(mesh);
        result.walk_around(mesh, jump, vertices_at_jumps(mesh, jump), tolerance);
        result
    }

    /// Accumulates jumps around the given vertices.
    pub fn walk_around(&mut self, mesh: &TriangleMesh, jump: &[f64], vertices: Vec<Vertex>, tolerance: f64) {
        for v in vertices {
            let fans = VertexFan::all(mesh, v);
            let fan = match &fans[..] {
                [fan] if !fan.ends_at_nonmanifold_edge => fan,
                _ => {
                    self.not_fans.push(v);
                    continue;
                }
            };
            let mut sum = 0.0;
            for (i, crossing) in fan.crossings.iter().enumerate() {
                sum += crossing.change(jump);
                if let Some(&corner) = fan.corners.get(i + 1) {
                    self.corner[corner.index()] = sum;
                }
            }
            if fan.is_closed() && sum.abs() > tolerance {
                fan.corners.iter().for_each(|c| self.corner[c.index()] = 0.0);
                self.endpoints.push(v);
            }
        }
    }
}

fn vertices_at_jumps(mesh: &TriangleMesh, jump: &[f64]) -> Vec<Vertex> {
    let mut vertices: Vec<Vertex> =
        mesh.edges().filter(|e| jump[e.index()] != 0.0).flat_map(|e| mesh.edge_vertices(e)).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}
