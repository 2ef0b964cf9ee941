//! Steps 1 and 2: the smoothest function with given jumps.

use crate::winding::chain::Fan;
use crate::winding::weights::Weights;
use eikona_mesh::{TriangleMesh, Vertex};
use eikona_numeric::{
    Cholesky, Graph, NumericError, Ordering, Symbolic, SymmetricMatrix, nested_dissection_order,
};
use std::sync::Arc;

/// What jumps mean around each vertex.
#[derive(Clone, Debug)]
pub(crate) struct Coordinates {
    /// Value at each corner relative to the vertex's first one (*reduced coordinates*, section 2.3.1).
    pub corner: Vec<f64>,
    /// Vertices around which the jumps do not add up: the curve ends there. They have no coordinates.
    pub endpoints: Vec<Vertex>,
    /// Vertices with jumps whose faces are not one fan. They have no coordinates either.
    ///
    /// Deviation: the public program takes the curve for absent there, so that the jumps at both ends of an edge differ and the
    /// derivative is no form any more. (Test `a_fin_is_warned_of_and_changes_little_elsewhere`.)
    pub not_fans: Vec<Vertex>,
}

impl Coordinates {
    /// The vertices that have no coordinates.
    pub fn left_out(&self) -> impl Iterator<Item = Vertex> {
        self.endpoints.iter().chain(&self.not_fans).copied()
    }

    /// Walks around every vertex at an edge with a jump. Around an inner vertex jumps that add up to more than `tolerance` make it
    /// an endpoint.
    pub fn of(mesh: &TriangleMesh, jump: &[f64], tolerance: f64) -> Coordinates {
        let mut result = Coordinates {
            corner: vec![0.0; 3 * mesh.face_count()],
            endpoints: Vec::new(),
            not_fans: Vec::new(),
        };
        let mut fan = Fan::default();
        for v in vertices_at_jumps(mesh, jump) {
            if !fan.walk(mesh, v) {
                result.not_fans.push(v);
                continue;
            }
            let mut sum = 0.0;
            for (i, crossing) in fan.crossings.iter().enumerate() {
                sum += crossing.change(jump);
                if let Some(&corner) = fan.corners.get(i + 1) {
                    result.corner[corner] = sum;
                }
            }
            if fan.closed && sum.abs() > tolerance {
                fan.corners.iter().for_each(|&c| result.corner[c] = 0.0);
                result.endpoints.push(v);
            }
        }
        result
    }
}

fn vertices_at_jumps(mesh: &TriangleMesh, jump: &[f64]) -> Vec<Vertex> {
    let mut vertices: Vec<Vertex> =
        mesh.edges().filter(|e| jump[e.index()] != 0.0).flat_map(|e| mesh.edge_vertices(e)).collect();
    vertices.sort_unstable();
    vertices.dedup();
    vertices
}

/// The Laplacian of eq. 10 on all vertices but some, analysed once a mesh.
#[derive(Debug)]
pub(crate) struct JumpLaplace {
    symbolic: Arc<Symbolic>,
}

impl JumpLaplace {
    pub fn new(mesh: &TriangleMesh) -> Result<JumpLaplace, NumericError> {
        let pairs = mesh.triangles().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        let graph = Graph { unknowns: mesh.vertex_count(), pairs };
        let order = nested_dissection_order(&graph, mesh.positions())?;
        Ok(JumpLaplace { symbolic: Symbolic::new(&graph, Ordering::Given(&order))?.into() })
    }

    /// Factors the operator without the vertices that are excluded. Of every connected part that is left the first vertex is
    /// held at zero; the part is singular otherwise, and its right-hand sides add up to zero.
    pub fn factor(
        &self,
        mesh: &TriangleMesh,
        weights: &Weights,
        excluded: &[bool],
    ) -> Result<Cholesky<f64>, NumericError> {
        let mut matrix = SymmetricMatrix {
            diagonal: vec![0.0; mesh.vertex_count()],
            off_diagonal: vec![0.0; 3 * mesh.face_count()],
        };
        for (f, corners) in mesh.triangles().iter().enumerate() {
            for k in 0..3 {
                let (i, j) = (corners[k] as usize, corners[(k + 1) % 3] as usize);
                if !excluded[i] && !excluded[j] {
                    let weight = weights.of_halfedge[3 * f + k];
                    matrix.off_diagonal[3 * f + k] = -weight;
                    matrix.diagonal[i] += weight;
                    matrix.diagonal[j] += weight;
                }
            }
        }
        for first in first_vertices(mesh, excluded) {
            let diagonal = &mut matrix.diagonal[first];
            *diagonal += if *diagonal > 0.0 { *diagonal } else { 1.0 };
        }
        Cholesky::new(self.symbolic.clone(), &matrix)
    }
}

/// The first vertex of each part that is connected through edges between vertices that are not excluded; excluded vertices are
/// parts of their own.
fn first_vertices(mesh: &TriangleMesh, excluded: &[bool]) -> impl Iterator<Item = usize> {
    let mut parent: Vec<u32> = (0..mesh.vertex_count() as u32).collect();
    fn root(parent: &mut [u32], mut v: u32) -> u32 {
        while parent[v as usize] != v {
            parent[v as usize] = parent[parent[v as usize] as usize];
            v = parent[v as usize];
        }
        v
    }
    for corners in mesh.triangles() {
        for k in 0..3 {
            let (i, j) = (corners[k], corners[(k + 1) % 3]);
            if !excluded[i as usize] && !excluded[j as usize] {
                let (a, b) = (root(&mut parent, i), root(&mut parent, j));
                parent[a.max(b) as usize] = a.min(b);
            }
        }
    }
    (0..parent.len()).filter(move |&v| parent[v] == v as u32)
}

/// The values at corners of the function with these coordinates that is smoothest across vertices; NaN at excluded vertices.
pub(crate) fn solve_jump_equation(
    mesh: &TriangleMesh,
    weights: &Weights,
    factor: &Cholesky<f64>,
    excluded: &[bool],
    coordinates: &[f64],
) -> Result<(Vec<f64>, f64), NumericError> {
    let mut rhs = vec![0.0; mesh.vertex_count()];
    for (f, corners) in mesh.triangles().iter().enumerate() {
        for k in 0..3 {
            let (i, j) = (corners[k] as usize, corners[(k + 1) % 3] as usize);
            if !excluded[i] && !excluded[j] {
                let difference = coordinates[3 * f + k] - coordinates[3 * f + (k + 1) % 3];
                let flow = weights.of_halfedge[3 * f + k] * difference;
                rhs[i] -= flow;
                rhs[j] += flow;
            }
        }
    }
    let base = factor.solve(&rhs)?;
    let residual = factor.residual(&base, &rhs);
    let values = mesh.triangles().iter().flatten().zip(coordinates).map(|(&v, c)| {
        let v = v as usize;
        if excluded[v] { f64::NAN } else { base[v] + c }
    });
    Ok((values.collect(), residual))
}
