//! Steps 4 to 6: the harmonic part of a derivative, and that integrated face by face.

use crate::winding::triangulation::{Triangulation, next};
use eikona_mesh::{Face, Halfedge, Orientation, TriangleMesh};
use eikona_numeric::{
    Cholesky, Graph, NumericError, Ordering, Symbolic, SymmetricMatrix, nested_dissection_order,
};

/// The corner of a halfedge's face at its tip. (That at its origin has the halfedge's own index.)
pub(crate) fn tip_corner(h: Halfedge) -> usize {
    next(h.index())
}

/// The Hodge system on faces, `d1 *1^-1 d1^T`.
#[derive(Debug)]
pub(crate) struct Hodge {
    factor: Cholesky<f64>,
    /// 1 over the star of each halfedge's side.
    inverse_star: Vec<f64>,
}

impl Hodge {
    /// The surface is cut open along edges of three or more faces. Closed orientable patches have
    /// the constants as kernel: their first face is held at zero.
    pub fn new(mesh: &TriangleMesh, triangulation: &Triangulation) -> Result<Hodge, NumericError> {
        let halfedges = triangulation.weight.len();
        let inverse_star: Vec<f64> = (0..halfedges).map(|h| 1.0 / triangulation.star(h)).collect();
        let mut graph = Graph { unknowns: mesh.face_count(), pairs: Vec::new() };
        let mut matrix = SymmetricMatrix { diagonal: vec![0.0; mesh.face_count()], off_diagonal: Vec::new() };
        for h in 0..halfedges {
            matrix.diagonal[h / 3] += inverse_star[h];
        }
        for h in 0..halfedges {
            let Some((other, same_way)) = triangulation.other(h) else { continue };
            debug_assert_ne!(h / 3, other / 3, "flips leave no triangle glued to itself");
            if h < other {
                graph.pairs.push([h as u32 / 3, other as u32 / 3]);
                matrix.off_diagonal.push(if same_way { inverse_star[h] } else { -inverse_star[h] });
            }
        }
        for first in closed_patches(mesh) {
            matrix.diagonal[first.index()] *= 2.0;
        }
        let centre = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|v| mesh.positions()[v as usize]);
            [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0)
        };
        let centres: Vec<[f64; 3]> = triangulation.corners.iter().map(centre).collect();
        let order = nested_dissection_order(&graph, &centres)?;
        let symbolic = Symbolic::new(&graph, Ordering::Given(&order))?;
        Ok(Hodge { factor: Cholesky::new(symbolic.into(), &matrix)?, inverse_star })
    }

    /// The harmonic part (section 3.3) of a co-closed form along halfedges, with the relative
    /// residual of the solve.
    pub fn harmonic_part(
        &self,
        triangulation: &Triangulation,
        form: &[f64],
    ) -> Result<(Vec<f64>, f64), NumericError> {
        let curl: Vec<f64> = form.chunks_exact(3).map(|sides| sides.iter().sum()).collect();
        let potential = self.factor.solve(&curl)?;
        let residual = self.factor.residual(&potential, &curl);
        let harmonic = triangulation.form(|h| {
            let beyond = triangulation.other(h).map_or(0.0, |(other, same_way)| {
                if same_way { potential[other / 3] } else { -potential[other / 3] }
            });
            form[h] - self.inverse_star[h] * (potential[h / 3] + beyond)
        });
        Ok((harmonic, residual))
    }
}

/// The first face of each patch that is closed and orientable.
fn closed_patches(mesh: &TriangleMesh) -> Vec<Face> {
    let orientation = Orientation::of(mesh);
    let mut closed: Vec<bool> = orientation.patches.iter().map(|p| p.is_orientable()).collect();
    for e in mesh.edges() {
        if let halfedges @ ([_] | [_, _, _, ..]) = mesh.edge_halfedges(e) {
            for h in halfedges {
                closed[orientation.patch_of_face[h.face()] as usize] = false;
            }
        }
    }
    orientation.patches.iter().zip(closed).filter(|(_, closed)| *closed).map(|(p, _)| p.first_face).collect()
}

/// A form without curl as values at the corners of each face, zero at the first.
pub(crate) fn integrated_in_faces(form: &[f64]) -> Vec<f64> {
    form.chunks_exact(3).flat_map(|sides| [0.0, sides[0], sides[0] + sides[1]]).collect()
}

/// For each edge of two faces the value in the first face minus that in the second, at the origin
/// of the first halfedge; 0 at other edges.
pub(crate) fn jumps_of(mesh: &TriangleMesh, values: &[f64]) -> Vec<f64> {
    mesh.edges()
        .map(|e| match mesh.edge_halfedges(e) {
            &[a, b] => {
                let other = if mesh.origin(b) == mesh.origin(a) { b.index() } else { tip_corner(b) };
                values[a.index()] - values[other]
            }
            _ => 0.0,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Triangle, lay_out};
    use crate::winding::coordinates::Coordinates;
    use crate::winding::jump_laplace::{darboux_derivative, differences, solve_jump_equation};
    use crate::winding::operators::Operators;
    use eikona_mesh::{Vertex, damage, shapes};

    /// A form that is closed in every triangle and co-closed at every vertex inside, also at the
    /// curve's ends.
    fn is_harmonic(mesh: &TriangleMesh, on: &Operators, arc: &[u32]) {
        let mut jump = vec![0.0; mesh.edge_count()];
        for ends in arc.windows(2) {
            let e = mesh.find_edge(Vertex(ends[0]), Vertex(ends[1])).unwrap();
            jump[e.index()] = if mesh.edge_vertices(e)[0] == Vertex(ends[0]) { 1.0 } else { -1.0 };
        }
        let coordinates = Coordinates::of(mesh, &jump, 0.5);
        let mut excluded = vec![false; mesh.vertex_count()];
        coordinates.left_out().for_each(|v| excluded[v.index()] = true);
        let mut kappa = differences(&coordinates.corner);
        on.triangulation.form_from_mesh(&mut kappa);
        let factor = on.factor(mesh, &excluded).unwrap();
        let (base, _) = solve_jump_equation(&on.triangulation, &factor, &excluded, &kappa).unwrap();
        let derivative = darboux_derivative(&on.triangulation, &excluded, &base, &kappa);
        let (form, _) = on.hodge(mesh).unwrap().harmonic_part(&on.triangulation, &derivative).unwrap();
        let largest = form.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        assert!(largest > 1e-3, "there is something to be harmonic");
        let curl = form.chunks_exact(3).map(|sides| sides.iter().sum::<f64>().abs()).fold(0.0, f64::max);
        let mut divergence = vec![0.0; mesh.vertex_count()];
        for (h, value) in form.iter().enumerate() {
            // Half of a side's flow is in each of its triangles.
            divergence[on.triangulation.origin(h) as usize] += on.triangulation.weight[h] * value;
            divergence[on.triangulation.tip(h) as usize] -= on.triangulation.weight[h] * value;
        }
        let divergence = divergence.iter().fold(0.0f64, |m, d| m.max(d.abs()));
        assert!(curl < 1e-9 && divergence < 1e-9, "{curl:e} {divergence:e}");
    }

    #[test]
    fn harmonic_parts_are_closed_and_co_closed() {
        let torus = damage::jitter(&shapes::torus(1.0, 0.4, 30, 15).unwrap(), 0.3, 5).unwrap();
        let annulus = shapes::annulus(1.0, 2.0, 8, 40).unwrap();
        let band = shapes::moebius_band(1.0, 0.6, 60, 8).unwrap();
        let tube: Vec<u32> = (105..116).collect();
        let mut kept = vec![false; torus.vertex_count()];
        (105..116).for_each(|v| kept[v] = true);
        for (mesh, arc) in [(&torus, tube), (&annulus, inner_path(&annulus)), (&band, inner_path(&band))] {
            let triangles: Vec<Triangle> = lay_out(mesh);
            is_harmonic(mesh, &Operators::on_faces(mesh, &triangles), &arc);
            if std::ptr::eq(mesh, &torus) {
                is_harmonic(mesh, &Operators::on_delaunay(mesh, &triangles, &kept), &arc);
            }
        }
    }

    /// Some steps along edges between vertices inside.
    fn inner_path(mesh: &TriangleMesh) -> Vec<u32> {
        let is_inner = |v: Vertex| {
            let edges = mesh.vertex_corners(v).iter().flat_map(|c| [c.halfedge(), c.halfedge().previous()]);
            edges.into_iter().all(|h| mesh.edge_halfedges(mesh.edge(h)).len() == 2)
        };
        let mut path = vec![mesh.vertices().find(|&v| is_inner(v)).unwrap()];
        while path.len() < 6 {
            let last = path[path.len() - 1];
            let next = mesh
                .vertex_corners(last)
                .iter()
                .map(|c| mesh.tip(c.halfedge()))
                .find(|v| is_inner(*v) && !path.contains(v) && mesh.find_edge(last, *v).is_some());
            path.push(next.unwrap());
        }
        path.into_iter().map(|v| v.0).collect()
    }
}
