//! Surfaces that have fields: checked, consistently oriented, laid out.

use crate::Warning;
use crate::curves::side::consistently_oriented;
use crate::geometry::{lay_out_in, unit_of};
use crate::polar_field::bevel::BeveledMesh;
use crate::polar_field::error::PolarFieldError;
use eikona_mesh::{Topology, TriangleMesh};
use eikona_numeric::check_stopped;

/// The beveled mesh of a surface, and what was changed on the way to it.
pub(crate) struct Surface {
    pub bevel: BeveledMesh,
    pub warnings: Vec<Warning>,
}

impl Surface {
    /// Checks and orients a mesh.
    pub fn of(mesh: &TriangleMesh) -> Result<Surface, PolarFieldError> {
        if mesh.face_count() == 0 {
            return Err(PolarFieldError::NoFaces);
        }
        let topology = Topology::in_steps(mesh, check_stopped)?;
        check_stopped()?;
        check_surface(mesh, &topology)?;
        let mut warnings = Vec::new();
        let mesh = consistently_oriented(mesh, &mut warnings);
        check_stopped()?;
        // The numbers of boundary halfedges depend on the orientation.
        let topology = if warnings.is_empty() { topology } else { Topology::in_steps(&mesh, check_stopped)? };
        let triangles = lay_out_in(&mesh, unit_of(&mesh))?;
        if let Some(face) = mesh.faces().find(|f| triangles[f.index()].mollified) {
            return Err(PolarFieldError::FlatFace { face });
        }
        check_stopped()?;
        Ok(Surface { bevel: BeveledMesh::new(&mesh, topology, triangles), warnings })
    }
}

/// Refuses surfaces on which a field has no sense.
fn check_surface(mesh: &TriangleMesh, topology: &Topology) -> Result<(), PolarFieldError> {
    if let Some(&edge) = topology.nonmanifold_edges.first() {
        let (vertices, faces) = (mesh.edge_vertices(edge), mesh.edge_halfedges(edge).len());
        return Err(PolarFieldError::NonmanifoldEdge { edge, vertices, faces });
    }
    if let Some(v) = topology.nonmanifold_vertices.first() {
        return Err(PolarFieldError::NonmanifoldVertex { vertex: v.vertex, fans: v.fans });
    }
    match topology.components.iter().position(|c| !c.orientable) {
        Some(component) => {
            let first_face = topology.components[component].first_face;
            Err(PolarFieldError::NotOrientable { component, first_face })
        }
        None => Ok(()),
    }
}
