//! The two operators of the method on one triangulation, built on first use.

use crate::geometry::{IntrinsicTriangulation, Triangle};
use crate::operators::{Hodge, JumpLaplacian};
use eikona_mesh::TriangleMesh;
use eikona_numeric::{Cholesky, NumericError, Resources};
use std::sync::OnceLock;

#[derive(Debug)]
pub(crate) struct Operators {
    pub triangulation: IntrinsicTriangulation,
    resources: Resources,
    laplace: OnceLock<JumpLaplacian>,
    /// Without excluded vertices.
    whole: OnceLock<Cholesky<f64>>,
    hodge: OnceLock<Hodge>,
}

impl Operators {
    /// On the faces of the mesh.
    pub fn on_faces(mesh: &TriangleMesh, triangles: &[Triangle], resources: Resources) -> Operators {
        Operators::on(IntrinsicTriangulation::of_faces(mesh, triangles), resources)
    }

    /// On intrinsic Delaunay triangles, except for the faces at excluded vertices.
    pub fn on_delaunay(
        mesh: &TriangleMesh,
        triangles: &[Triangle],
        excluded: &[bool],
        resources: Resources,
    ) -> Operators {
        Operators::on(IntrinsicTriangulation::delaunay(mesh, triangles, excluded), resources)
    }

    fn on(triangulation: IntrinsicTriangulation, resources: Resources) -> Operators {
        Operators {
            triangulation,
            resources,
            laplace: OnceLock::new(),
            whole: OnceLock::new(),
            hodge: OnceLock::new(),
        }
    }

    /// Factors the Laplacian without the excluded vertices.
    pub fn factor(&self, mesh: &TriangleMesh, excluded: &[bool]) -> Result<Cholesky<f64>, NumericError> {
        let analyse = || JumpLaplacian::new(&self.triangulation, mesh.positions(), self.resources.threads);
        get_or_try_init(&self.laplace, analyse)?.factor(&self.triangulation, excluded, self.resources)
    }

    /// Returns the Laplacian of all vertices, factored once.
    pub fn whole_factor(&self, mesh: &TriangleMesh) -> Result<&Cholesky<f64>, NumericError> {
        get_or_try_init(&self.whole, || self.factor(mesh, &vec![false; mesh.vertex_count()]))
    }

    /// Returns the Hodge system, factored once.
    pub fn hodge(&self, mesh: &TriangleMesh) -> Result<&Hodge, NumericError> {
        get_or_try_init(&self.hodge, || Hodge::new(mesh, &self.triangulation, self.resources))
    }
}

pub(crate) fn get_or_try_init<T, E>(
    cell: &OnceLock<T>,
    make: impl FnOnce() -> Result<T, E>,
) -> Result<&T, E> {
    if let Some(made) = cell.get() {
        return Ok(made);
    }
    let made = make()?;
    Ok(cell.get_or_init(|| made))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::lay_out;
    use crate::operators::{darboux_derivative, differences, solve_jump_equation};
    use crate::winding::coordinates::Coordinates;
    use eikona_mesh::{Vertex, damage, shapes};

    #[test]
    fn the_first_solve_is_linear_in_the_curve() {
        let torus = damage::jitter(&shapes::torus(1.0, 0.4, 30, 15).unwrap(), 0.2, 5).unwrap();
        let on = Operators::on_faces(&torus, &lay_out(&torus), Resources::default());
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
        // All vertices but the ends of the arc.
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

    /// The harmonic part is closed in every triangle and co-closed at every inner vertex, also at
    /// the curve's ends.
    fn assert_harmonic(mesh: &TriangleMesh, on: &Operators, arc: &[u32]) {
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
        assert!(largest > 1e-3, "the harmonic part does not vanish");
        let curl = form.chunks_exact(3).map(|sides| sides.iter().sum::<f64>().abs()).fold(0.0, f64::max);
        let mut divergence = vec![0.0; mesh.vertex_count()];
        for (h, value) in on.triangulation.halfedges().zip(&form) {
            // Each triangle carries half the flow of its side.
            divergence[on.triangulation.origin(h).index()] += on.triangulation.weight[h] * value;
            divergence[on.triangulation.tip(h).index()] -= on.triangulation.weight[h] * value;
        }
        let divergence = divergence.iter().fold(0.0f64, |m, d| m.max(d.abs()));
        assert!(curl < 1e-14 * largest.max(1.0) && divergence < 1e-9, "{curl:e} {divergence:e}");
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
            assert_harmonic(mesh, &Operators::on_faces(mesh, &triangles, Resources::default()), &arc);
            if std::ptr::eq(mesh, &torus) {
                assert_harmonic(
                    mesh,
                    &Operators::on_delaunay(mesh, &triangles, &kept, Resources::default()),
                    &arc,
                );
            }
        }
    }

    /// Returns a short path along edges between inner vertices.
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
