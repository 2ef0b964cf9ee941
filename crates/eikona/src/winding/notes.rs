//! Warnings about the steps of a solve, with the elements of the input.

use crate::Warning;
use crate::winding::chain::Chain;
use crate::winding::coordinates::Coordinates;
use crate::winding::islands::Islands;
use eikona_mesh::{Edge, Face, Provenance, SurfacePoint, TriangleMesh, Vertex};

/// The elements of the input in which those of a cut mesh lie. The user knows only the input.
#[derive(Clone, Copy, Default)]
pub(super) struct Names<'a>(pub Option<&'a Provenance>);

impl Names<'_> {
    fn place(self, v: Vertex) -> SurfacePoint {
        self.0.and_then(|cut| cut.vertex_place(v)).unwrap_or(v.into())
    }

    fn face(self, f: Face) -> Face {
        self.0.map_or(f, |cut| cut.face_parent(f))
    }
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

pub(super) fn several_fans(coordinates: &Coordinates, names: Names) -> Option<Warning> {
    let vertices = &coordinates.not_fans;
    Some(Warning::SeveralFans { count: vertices.len(), first: names.place(*vertices.first()?) })
}

pub(super) fn faces_without_value(islands: &Islands, names: Names) -> Option<Warning> {
    let faces = &islands.without_value;
    Some(Warning::FacesWithoutValue { count: faces.len(), first: names.face(faces.first()?.0) })
}

pub(super) fn narrow_rings(freed: &[Edge], mesh: &TriangleMesh, names: Names) -> Option<Warning> {
    let first = mesh.edge_vertices(*freed.first()?).map(|v| names.place(v));
    Some(Warning::NarrowRings { count: freed.len(), first })
}
