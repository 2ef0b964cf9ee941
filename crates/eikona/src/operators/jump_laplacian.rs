//! Jump Laplace equation (SWN eq. 10): right-hand sides for given jumps, the smoothest function
//! with these jumps, and its derivative.

use crate::geometry::IntrinsicTriangulation;
use eikona_mesh::{Halfedge, UnionFind, Vertex};
use eikona_numeric::{
    Cholesky, Graph, NumericError, Ordering, Resources, Symbolic, SymmetricMatrix, check_stopped,
    nested_dissection_order,
};
use std::sync::Arc;

/// Cotan Laplacian on the vertices that are not excluded, analysed once per triangulation.
#[derive(Debug)]
pub(crate) struct JumpLaplacian {
    symbolic: Arc<Symbolic>,
}

impl JumpLaplacian {
    pub fn new(
        triangulation: &IntrinsicTriangulation,
        positions: &[[f64; 3]],
        threads: usize,
    ) -> Result<JumpLaplacian, NumericError> {
        let sides = |&[a, b, c]: &[Vertex; 3]| [[a.0, b.0], [b.0, c.0], [c.0, a.0]];
        let pairs = triangulation.corners.iter().flat_map(sides).collect();
        let graph = Graph { unknowns: positions.len(), pairs };
        check_stopped()?;
        let order = nested_dissection_order(&graph, positions, threads)?;
        Ok(JumpLaplacian { symbolic: Symbolic::new(&graph, Ordering::Given(&order))?.into() })
    }

    /// Factors the operator without the excluded vertices. The value at the first vertex of each
    /// remaining connected component is fixed to zero: the block of the component is singular
    /// otherwise, and its right-hand side sums to zero. Deviation: the authors' program adds 1e-8
    /// to the whole diagonal, here and in the Hodge system, which changes its results by 1e-6.
    pub fn factor(
        &self,
        triangulation: &IntrinsicTriangulation,
        excluded: &[bool],
        resources: Resources,
    ) -> Result<Cholesky<f64>, NumericError> {
        let halfedges = triangulation.weight.len();
        let mut matrix =
            SymmetricMatrix { diagonal: vec![0.0; excluded.len()], off_diagonal: vec![0.0; halfedges] };
        for (h, [i, j]) in included(triangulation, excluded) {
            let weight = triangulation.weight[h];
            matrix.off_diagonal[h.index()] = -weight;
            matrix.diagonal[i] += weight;
            matrix.diagonal[j] += weight;
        }
        check_stopped()?;
        let parts = parts(triangulation, excluded);
        for first in (0..parts.len()).filter(|&v| parts[v] == v as u32) {
            let diagonal = &mut matrix.diagonal[first];
            *diagonal += if *diagonal > 0.0 { *diagonal } else { 1.0 };
        }
        check_stopped()?;
        Cholesky::within(resources, self.symbolic.clone(), &matrix)
    }
}

/// Iterates over the halfedges between included vertices, with the indices of these.
fn included<'a>(
    triangulation: &'a IntrinsicTriangulation,
    excluded: &'a [bool],
) -> impl Iterator<Item = (Halfedge, [usize; 2])> + 'a {
    let ends = triangulation.corners.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let halfedges = triangulation.halfedges().zip(ends.map(|ends| ends.map(|v| v.index())));
    halfedges.filter(|(_, [i, j])| !excluded[*i] && !excluded[*j])
}

/// Returns the first vertex of the connected component of each vertex. Edges between included
/// vertices connect; an excluded vertex is a component of its own. The function on each component
/// is determined up to a constant.
pub(crate) fn parts(triangulation: &IntrinsicTriangulation, excluded: &[bool]) -> Vec<u32> {
    let mut parts = UnionFind::new(excluded.len());
    for (_, [i, j]) in included(triangulation, excluded) {
        parts.join(i as u32, j as u32);
    }
    (0..excluded.len() as u32).map(|v| parts.find(v)).collect()
}

/// Returns the right-hand side for the given differences of corner values along halfedges.
pub(crate) fn right_hand_side(
    triangulation: &IntrinsicTriangulation,
    excluded: &[bool],
    differences: &[f64],
) -> Vec<f64> {
    let mut rhs = vec![0.0; excluded.len()];
    for (h, [i, j]) in included(triangulation, excluded).filter(|(h, _)| differences[h.index()] != 0.0) {
        let flow = triangulation.weight[h] * differences[h.index()];
        rhs[i] += flow;
        rhs[j] -= flow;
    }
    rhs
}

/// Returns the vertex values whose sum with the corner values is smoothest, for corner values with
/// these differences, and the relative residual.
pub(crate) fn solve_jump_equation(
    triangulation: &IntrinsicTriangulation,
    factor: &Cholesky<f64>,
    excluded: &[bool],
    differences: &[f64],
) -> Result<(Vec<f64>, f64), NumericError> {
    let rhs = right_hand_side(triangulation, excluded, differences);
    check_stopped()?;
    let base = factor.solve(&rhs)?;
    check_stopped()?;
    let residual = factor.relative_residual(&base, &rhs);
    Ok((base, residual))
}

/// Returns the Darboux derivative along halfedges (SWN section 2.4.2) of the function with these
/// vertex values and corner differences: a 1-form, zero at sides with an excluded end.
pub(crate) fn darboux_derivative(
    triangulation: &IntrinsicTriangulation,
    excluded: &[bool],
    base: &[f64],
    differences: &[f64],
) -> Vec<f64> {
    triangulation.form(|h| {
        let [i, j] = [triangulation.origin(h), triangulation.tip(h)].map(|v| v.index());
        if excluded[i] || excluded[j] { 0.0 } else { base[j] - base[i] + differences[h.index()] }
    })
}

/// Returns the differences of corner values along halfedges.
pub(crate) fn differences(corner: &[f64]) -> Vec<f64> {
    let next = |h: usize| Halfedge(h as u32).next().index();
    (0..corner.len()).map(|h| corner[next(h)] - corner[h]).collect()
}
