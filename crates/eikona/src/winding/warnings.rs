//! Warnings about the steps of a solve. `provenance` leads from the input to the mesh of the solve.

use crate::Warning;
use crate::winding::chain::Chain;
use crate::winding::coordinates::Coordinates;
use crate::winding::islands::Islands;
use eikona_mesh::{Edge, Provenance, SurfacePoint, TriangleMesh, Vertex};

/// Returns where a vertex lies on the input, which is all that the user knows.
fn place(provenance: &Provenance, v: Vertex) -> SurfacePoint {
    provenance.vertex_place(v).unwrap_or(v.into())
}

pub(super) fn cancelled_or_ignored(chain: &Chain) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let mut add = |count: usize, warning: fn(usize) -> Warning| {
        if count > 0 {
            warnings.push(warning(count));
        }
    };
    add(chain.cancelled, |count| Warning::CancelledEdges { count });
    add(chain.on_boundary, |count| Warning::StepsOnBoundary { count });
    add(chain.on_nonmanifold, |count| Warning::StepsOnNonmanifoldEdges { count });
    if chain.jump.iter().all(|&j| j == 0) {
        warnings.push(Warning::NoJump);
    }
    warnings
}

pub(super) fn several_fans(coordinates: &Coordinates, provenance: &Provenance) -> Option<Warning> {
    let vertices = &coordinates.not_fans;
    Some(Warning::SeveralFans { count: vertices.len(), first: place(provenance, *vertices.first()?) })
}

pub(super) fn faces_without_value(islands: &Islands, provenance: &Provenance) -> Option<Warning> {
    let faces = &islands.without_value;
    Some(Warning::FacesWithoutValue { count: faces.len(), first: provenance.face_parent(faces.first()?.0) })
}

pub(super) fn narrow_rings(
    relaxed: &[Edge],
    mesh: &TriangleMesh,
    provenance: &Provenance,
) -> Option<Warning> {
    let first = mesh.edge_vertices(*relaxed.first()?).map(|v| place(provenance, v));
    Some(Warning::NarrowRings { count: relaxed.len(), first })
}
