//! Step 2: the smoothest function with given jumps.

use crate::winding::triangulation::{Triangulation, next};
use eikona_mesh::DisjointSets;
use eikona_numeric::{
    Cholesky, Graph, NumericError, Ordering, Symbolic, SymmetricMatrix, nested_dissection_order,
};
use std::sync::Arc;

/// The Laplacian of eq. 10 on all vertices but some, analysed once a triangulation.
#[derive(Debug)]
pub(crate) struct JumpLaplace {
    symbolic: Arc<Symbolic>,
}

impl JumpLaplace {
    pub fn new(triangulation: &Triangulation, positions: &[[f64; 3]]) -> Result<JumpLaplace, NumericError> {
        let pairs = triangulation.corners.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        let graph = Graph { unknowns: positions.len(), pairs };
        let order = nested_dissection_order(&graph, positions)?;
        Ok(JumpLaplace { symbolic: Symbolic::new(&graph, Ordering::Given(&order))?.into() })
    }

    /// Factors the operator without the vertices that are excluded. Of every connected part that is
    /// left the first vertex is held at zero; the part is singular otherwise, and its right-hand
    /// sides add up to zero. Deviation: the public program adds 1e-8 to the whole diagonal, here
    /// and in the Hodge system, which moves its figures by 1e-6.
    pub fn factor(
        &self,
        triangulation: &Triangulation,
        excluded: &[bool],
    ) -> Result<Cholesky<f64>, NumericError> {
        let halfedges = triangulation.weight.len();
        let mut matrix =
            SymmetricMatrix { diagonal: vec![0.0; excluded.len()], off_diagonal: vec![0.0; halfedges] };
        for (h, [i, j]) in included(triangulation, excluded) {
            let weight = triangulation.weight[h];
            matrix.off_diagonal[h] = -weight;
            matrix.diagonal[i] += weight;
            matrix.diagonal[j] += weight;
        }
        let parts = parts(triangulation, excluded);
        for first in (0..parts.len()).filter(|&v| parts[v] == v as u32) {
            let diagonal = &mut matrix.diagonal[first];
            *diagonal += if *diagonal > 0.0 { *diagonal } else { 1.0 };
        }
        Cholesky::new(self.symbolic.clone(), &matrix)
    }
}

/// The halfedges between vertices that are not excluded, with these.
fn included<'a>(
    triangulation: &'a Triangulation,
    excluded: &'a [bool],
) -> impl Iterator<Item = (usize, [usize; 2])> + 'a {
    let ends = triangulation.corners.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let halfedges = ends.enumerate().map(|(h, ends)| (h, ends.map(|v| v as usize)));
    halfedges.filter(|(_, [i, j])| !excluded[*i] && !excluded[*j])
}

/// The part of each vertex, named by its first vertex: what is connected through edges between
/// vertices that are not excluded. Excluded vertices are parts of their own. The function of each
/// part is known up to a constant.
pub(crate) fn parts(triangulation: &Triangulation, excluded: &[bool]) -> Vec<u32> {
    let mut parts = DisjointSets::new(excluded.len());
    for (_, [i, j]) in included(triangulation, excluded) {
        parts.join(i as u32, j as u32);
    }
    (0..excluded.len() as u32).map(|v| parts.find(v)).collect()
}

/// What a function whose values at corners have these differences along halfedges, before any
/// values at vertices are added, makes the right-hand side.
pub(crate) fn right_hand_side(
    triangulation: &Triangulation,
    excluded: &[bool],
    differences: &[f64],
) -> Vec<f64> {
    let mut rhs = vec![0.0; excluded.len()];
    for (h, [i, j]) in included(triangulation, excluded).filter(|(h, _)| differences[*h] != 0.0) {
        let flow = triangulation.weight[h] * differences[h];
        rhs[i] += flow;
        rhs[j] -= flow;
    }
    rhs
}

/// The values at vertices that, added at their corners, make the function with these differences as
/// smooth as can be; with the relative residual.
pub(crate) fn solve_jump_equation(
    triangulation: &Triangulation,
    factor: &Cholesky<f64>,
    excluded: &[bool],
    differences: &[f64],
) -> Result<(Vec<f64>, f64), NumericError> {
    let rhs = right_hand_side(triangulation, excluded, differences);
    let base = factor.solve(&rhs)?;
    let residual = factor.residual(&base, &rhs);
    Ok((base, residual))
}

/// The derivative along halfedges (section 2.4.2) of a function with these values at vertices and
/// differences at corners: the same in both triangles of a side; zero at sides with an end that is
/// excluded.
pub(crate) fn darboux_derivative(
    triangulation: &Triangulation,
    excluded: &[bool],
    base: &[f64],
    differences: &[f64],
) -> Vec<f64> {
    triangulation.form(|h| {
        let [i, j] = [triangulation.origin(h), triangulation.tip(h)].map(|v| v as usize);
        if excluded[i] || excluded[j] { 0.0 } else { base[j] - base[i] + differences[h] }
    })
}

/// Differences along halfedges of values at corners.
pub(crate) fn differences(corner: &[f64]) -> Vec<f64> {
    (0..corner.len()).map(|h| corner[next(h)] - corner[h]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::lay_out;
    use crate::winding::coordinates::Coordinates;
    use crate::winding::operators::Operators;
    use eikona_mesh::{Vertex, damage, shapes};

    #[test]
    fn the_first_solve_is_linear_in_the_curve() {
        let torus = damage::jitter(&shapes::torus(1.0, 0.4, 30, 15).unwrap(), 0.2, 5).unwrap();
        let on = Operators::on_faces(&torus, &lay_out(&torus));
        let chain = |path: &[u32], copies: f64| {
            let mut jump = vec![0.0; torus.edge_count()];
            for ends in path.windows(2) {
                let e = torus.find_edge(Vertex(ends[0]), Vertex(ends[1])).unwrap();
                jump[e.index()] = if torus.edge_vertices(e)[0].0 == ends[0] { copies } else { -copies };
            }
            jump
        };
        let around: Vec<u32> = (0..=15).map(|j| 105 + j % 15).collect();
        let arc: Vec<u32> = (8..20).map(|i| 15 * i + 3).collect();
        let (a, b) = (chain(&around, 2.0), chain(&arc, 3.0));
        let sum: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a + b).collect();
        // All without the ends of the arc.
        let mut excluded = vec![false; torus.vertex_count()];
        [arc[0], arc[arc.len() - 1]].into_iter().for_each(|v| excluded[v as usize] = true);
        let factor = on.factor(&torus, &excluded).unwrap();
        let derivative = |jump: &[f64]| {
            let kappa = differences(&Coordinates::of(&torus, jump, 0.5).corner);
            let (base, _) = solve_jump_equation(&on.triangulation, &factor, &excluded, &kappa).unwrap();
            darboux_derivative(&on.triangulation, &excluded, &base, &kappa)
        };
        let (a, b, sum) = (derivative(&a), derivative(&b), derivative(&sum));
        assert!(sum.iter().fold(0.0f64, |m, x| m.max(x.abs())) > 0.1);
        assert!((0..sum.len()).all(|h| (a[h] + b[h] - sum[h]).abs() < 1e-11));
    }
}
