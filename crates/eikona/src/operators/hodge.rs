//! Hodge star of 1-forms, and the projection to their harmonic part (SWN section 3.3).

use crate::geometry::IntrinsicTriangulation;
use eikona_mesh::{Face, Halfedge, Orientation, TriangleMesh, UnionFind};
use eikona_numeric::{
    Cholesky, Graph, NumericError, Ordering, Resources, Symbolic, SymmetricMatrix, check_step, check_stopped,
    nested_dissection_order,
};

/// Hodge system on faces, `d1 *1^-1 d1^T`, factored.
#[derive(Debug)]
pub(crate) struct Hodge {
    factor: Cholesky<f64>,
    /// Inverse of the Hodge star of each halfedge's side.
    inverse_star: Vec<f64>,
}

impl Hodge {
    /// Factors the system. The surface is cut along edges of three or more faces. On closed
    /// orientable patches the constants are in the kernel, so the value at their first face is
    /// fixed to zero.
    pub fn new(
        mesh: &TriangleMesh,
        triangulation: &IntrinsicTriangulation,
        resources: Resources,
    ) -> Result<Hodge, NumericError> {
        let inverse_star: Vec<f64> = triangulation.halfedges().map(|h| 1.0 / triangulation.star(h)).collect();
        let mut graph = Graph { unknowns: mesh.face_count(), pairs: Vec::new() };
        let mut matrix = SymmetricMatrix { diagonal: vec![0.0; mesh.face_count()], off_diagonal: Vec::new() };
        for h in triangulation.halfedges() {
            check_step(h.index())?;
            matrix.diagonal[h.face().index()] += inverse_star[h.index()];
        }
        for h in triangulation.halfedges() {
            check_step(h.index())?;
            let Some((other, same_direction)) = triangulation.other(h) else { continue };
            debug_assert_ne!(h.face(), other.face(), "flips leave no triangle glued to itself");
            if h < other {
                graph.pairs.push([h.face().0, other.face().0]);
                let entry = inverse_star[h.index()];
                matrix.off_diagonal.push(if same_direction { entry } else { -entry });
            }
        }
        check_stopped()?;
        for first in closed_patches(mesh)? {
            matrix.diagonal[first.index()] *= 2.0;
        }
        check_stopped()?;
        let centres: Vec<[f64; 3]> = triangulation
            .corners
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(|v| mesh.position(v));
                [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0)
            })
            .collect();
        check_stopped()?;
        let order = nested_dissection_order(&graph, &centres, resources.threads)?;
        let symbolic = Symbolic::new(&graph, Ordering::Given(&order))?;
        Ok(Hodge { factor: Cholesky::within(resources, symbolic.into(), &matrix)?, inverse_star })
    }

    /// Returns the harmonic part of a co-closed 1-form along halfedges, and the relative residual
    /// of the solve.
    pub fn harmonic_part(
        &self,
        triangulation: &IntrinsicTriangulation,
        form: &[f64],
    ) -> Result<(Vec<f64>, f64), NumericError> {
        let (first, residual) = self.without_curl(triangulation, form)?;
        // The curl that is left is rounding, but jumps add it up along paths of many faces, and a
        // second solve removes most of it.
        let (harmonic, _) = self.without_curl(triangulation, &first)?;
        Ok((harmonic, residual))
    }

    /// Subtracts from a 1-form the co-exact form with the same curl; also returns the relative
    /// residual of the solve.
    fn without_curl(
        &self,
        triangulation: &IntrinsicTriangulation,
        form: &[f64],
    ) -> Result<(Vec<f64>, f64), NumericError> {
        let curl: Vec<f64> = form.chunks_exact(3).map(|sides| sides.iter().sum()).collect();
        check_stopped()?;
        let potential = self.factor.solve(&curl)?;
        check_stopped()?;
        let residual = self.factor.relative_residual(&potential, &curl);
        let at = |h: Halfedge| potential[h.face().index()];
        let difference = triangulation.form(|h| {
            let across = triangulation
                .other(h)
                .map_or(0.0, |(other, same_direction)| if same_direction { at(other) } else { -at(other) });
            form[h.index()] - self.inverse_star[h.index()] * (at(h) + across)
        });
        Ok((difference, residual))
    }
}

/// Returns the first face of each closed orientable patch: a set of faces connected through edges
/// of two faces.
fn closed_patches(mesh: &TriangleMesh) -> Result<Vec<Face>, NumericError> {
    if mesh.is_consistently_oriented() {
        return closed_sheets(mesh);
    }
    let orientation = Orientation::of(mesh);
    let mut closed: Vec<bool> = orientation.patches.iter().map(|p| p.is_orientable()).collect();
    for e in mesh.edges() {
        if let halfedges @ ([_] | [_, _, _, ..]) = mesh.edge_halfedges(e) {
            for h in halfedges {
                closed[orientation.patch_of_face[h.face()] as usize] = false;
            }
        }
    }
    let patches = orientation.patches.iter().zip(closed).filter(|(_, closed)| *closed);
    Ok(patches.map(|(patch, _)| patch.first_face).collect())
}

/// [`closed_patches`] of a consistently oriented mesh. Every patch is orientable.
fn closed_sheets(mesh: &TriangleMesh) -> Result<Vec<Face>, NumericError> {
    let mut sheets = UnionFind::new(mesh.face_count());
    let mut rim = Vec::new();
    for e in mesh.edges() {
        check_step(e.index())?;
        match mesh.edge_halfedges(e) {
            [a, b] => sheets.join(a.face().0, b.face().0),
            halfedges => rim.extend(halfedges.iter().map(|h| h.face())),
        }
    }
    let mut found = vec![false; mesh.face_count()];
    rim.into_iter().for_each(|face| found[sheets.find(face.0) as usize] = true);
    let is_first = |f: &Face| !std::mem::replace(&mut found[sheets.find(f.0) as usize], true);
    Ok(mesh.faces().filter(is_first).collect())
}
