//! A mesh and the data that do not depend on the curve.

use crate::geometry::{Triangle, lay_out_in, unit_of};
use crate::winding::operators::Operators;
use eikona_mesh::{Topology, TriangleMesh};
use eikona_numeric::{Cholesky, NumericError, Resources};
use std::ops::Deref;
use std::sync::OnceLock;

/// A mesh, consistently oriented where orientable, with its operators. These are analysed and
/// factored on first use.
#[derive(Debug)]
pub(super) struct Surface {
    pub mesh: TriangleMesh,
    /// Whether the faces are consistently oriented.
    pub consistent: bool,
    /// Whether every closed curve bounds, so that there is no nonbounding part.
    pub simply_connected: bool,
    /// The unit of length of `triangles`. Labels do not depend on the size of the mesh, and squares
    /// of very large or small lengths overflow or underflow.
    pub unit: f64,
    pub triangles: Vec<Triangle>,
    pub resources: Resources,
    pub on_faces: Operators,
    on_delaunay: OnceLock<Operators>,
}

impl Surface {
    pub fn new(mesh: TriangleMesh, resources: Resources) -> Surface {
        let unit = unit_of(&mesh);
        let triangles = lay_out_in(&mesh, unit);
        Surface {
            consistent: mesh.is_consistently_oriented(),
            simply_connected: is_simply_connected(&mesh),
            on_faces: Operators::on_faces(&mesh, &triangles, resources),
            on_delaunay: OnceLock::new(),
            resources,
            mesh,
            unit,
            triangles,
        }
    }

    /// Returns the operators without the excluded vertices, on the faces or on Delaunay triangles.
    pub fn prepared(&self, excluded: &[bool], delaunay: bool) -> Result<Prepared<'_>, NumericError> {
        let mesh = &self.mesh;
        let whole = !excluded.contains(&true);
        let make = || Operators::on_delaunay(mesh, &self.triangles, excluded, self.resources);
        let on = match (delaunay, whole) {
            (false, _) => &self.on_faces,
            (true, true) => self.on_delaunay.get_or_init(make),
            (true, false) => {
                let on = make();
                let factor = Kept::Own(on.factor(mesh, excluded)?.into());
                return Ok(Prepared { on: Kept::Own(on.into()), factor });
            }
        };
        let factor = if whole {
            Kept::Lent(on.whole_factor(mesh)?)
        } else {
            Kept::Own(on.factor(mesh, excluded)?.into())
        };
        Ok(Prepared { on: Kept::Lent(on), factor })
    }
}

/// Operators and the factor of the Laplacian, borrowed from the surface or temporary.
pub(super) struct Prepared<'a> {
    pub on: Kept<'a, Operators>,
    pub factor: Kept<'a, Cholesky<f64>>,
}

pub(super) enum Kept<'a, T> {
    Lent(&'a T),
    Own(Box<T>),
}

impl<T> Deref for Kept<'_, T> {
    type Target = T;
    fn deref(&self) -> &T {
        match self {
            Kept::Lent(kept) => kept,
            Kept::Own(own) => own,
        }
    }
}

/// Whether every component is a sphere or a disk.
fn is_simply_connected(mesh: &TriangleMesh) -> bool {
    let topology = Topology::of(mesh);
    topology.is_manifold()
        && topology.components.iter().all(|c| c.genus == Some(0) && c.boundary_loop_count <= 1)
}
