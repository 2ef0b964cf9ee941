//! The two operators of the method on one triangulation, made when they are needed first.

use crate::geometry::Triangle;
use crate::winding::harmonic::Hodge;
use crate::winding::jump_laplace::JumpLaplace;
use crate::winding::triangulation::Triangulation;
use eikona_mesh::TriangleMesh;
use eikona_numeric::{Cholesky, NumericError};
use std::sync::OnceLock;

#[derive(Debug)]
pub(crate) struct Operators {
    pub triangulation: Triangulation,
    laplace: OnceLock<JumpLaplace>,
    /// Without excluded vertices.
    whole: OnceLock<Cholesky<f64>>,
    hodge: OnceLock<Hodge>,
}

impl Operators {
    /// On the faces of the mesh.
    pub fn on_faces(mesh: &TriangleMesh, triangles: &[Triangle]) -> Operators {
        Operators::on(Triangulation::of(mesh, triangles))
    }

    /// On intrinsic Delaunay triangles, but for those at the excluded vertices.
    pub fn on_delaunay(mesh: &TriangleMesh, triangles: &[Triangle], excluded: &[bool]) -> Operators {
        Operators::on(Triangulation::delaunay(mesh, triangles, excluded))
    }

    fn on(triangulation: Triangulation) -> Operators {
        Operators { triangulation, laplace: OnceLock::new(), whole: OnceLock::new(), hodge: OnceLock::new() }
    }

    /// The Laplacian without these vertices, factored.
    pub fn factor(&self, mesh: &TriangleMesh, excluded: &[bool]) -> Result<Cholesky<f64>, NumericError> {
        let analyse = || JumpLaplace::new(&self.triangulation, mesh.positions());
        made_once(&self.laplace, analyse)?.factor(&self.triangulation, excluded)
    }

    /// The Laplacian of all vertices, factored once.
    pub fn whole_factor(&self, mesh: &TriangleMesh) -> Result<&Cholesky<f64>, NumericError> {
        made_once(&self.whole, || self.factor(mesh, &vec![false; mesh.vertex_count()]))
    }

    /// The Hodge system, factored once.
    pub fn hodge(&self, mesh: &TriangleMesh) -> Result<&Hodge, NumericError> {
        made_once(&self.hodge, || Hodge::new(mesh, &self.triangulation))
    }
}

pub(crate) fn made_once<T, E>(cell: &OnceLock<T>, make: impl FnOnce() -> Result<T, E>) -> Result<&T, E> {
    if let Some(made) = cell.get() {
        return Ok(made);
    }
    let made = make()?;
    Ok(cell.get_or_init(|| made))
}
