//! What the user is told of.

use crate::winding::chain::Chain;
use crate::winding::coordinates::Coordinates;
use crate::winding::islands::Islands;
use crate::wording::counted;
use eikona_mesh::{Edge, Face, SurfacePoint, TriangleMesh, Vertex};

/// How elements are called to the user, who knows those of the input only: of a mesh that was cut,
/// where its vertices lie and the faces that they were cut from.
#[derive(Clone, Copy, Default)]
pub(super) struct Names<'a>(pub Option<(&'a [SurfacePoint], &'a [Face])>);

impl Names<'_> {
    fn vertex(self, v: Vertex) -> String {
        match self.0.map(|(places, _)| places[v.index()]) {
            None => format!("vertex {}", v.index()),
            Some(SurfacePoint::Vertex { vertex }) => format!("vertex {vertex}"),
            Some(SurfacePoint::Edge { vertices: [a, b], .. }) => {
                format!("a point between vertices {a} and {b}")
            }
            Some(SurfacePoint::Face { vertices: [a, b, c], .. }) => {
                format!("a point in the face of vertices {a}, {b} and {c}")
            }
        }
    }

    fn face(self, f: Face) -> String {
        match self.0 {
            None => f.to_string(),
            Some((_, parents)) => format!("a part of {}", parents[f.index()]),
        }
    }
}

pub(super) fn note_chain(chain: &Chain, warnings: &mut Vec<String>) {
    if chain.cancelled > 0 {
        let edges = counted(chain.cancelled, "edge is", "edges are");
        warnings.push(format!("{edges} walked in both directions equally often; these steps cancel"));
    }
    if chain.on_boundary > 0 {
        let steps = counted(chain.on_boundary, "step runs", "steps run");
        warnings.push(format!("{steps} along the boundary, where nothing can jump; they are left out"));
    }
    if chain.on_nonmanifold > 0 {
        let steps = counted(chain.on_nonmanifold, "step runs", "steps run");
        warnings.push(format!(
            "{steps} along edges of three or more faces, where there is no left; they are left out"
        ));
    }
    if chain.jump.iter().all(|&j| j == 0) {
        warnings.push("nothing is left of the curve, so every region is outside".into());
    }
}

pub(super) fn note_not_fans(coordinates: &Coordinates, names: Names, warnings: &mut Vec<String>) {
    if let Some(&first) = coordinates.not_fans.first() {
        let count = coordinates.not_fans.len();
        let vertices =
            counted(count, "vertex of the completed curve has", "vertices of the completed curve have");
        warnings.push(format!(
            "{vertices} more than one fan of faces, the first is {}; the winding number has no value there",
            names.vertex(first)
        ));
    }
}

pub(super) fn note_without_value(islands: &Islands, names: Names, warnings: &mut Vec<String>) {
    if let Some(&(first, _)) = islands.without_value.first() {
        let faces = counted(islands.without_value.len(), "face has", "faces have");
        warnings.push(format!(
            "{faces} endpoints at all corners, so no value, the first is {}; labelled like the nearest face with one",
            names.face(first)
        ));
    }
}

pub(super) fn note_freed(freed: &[Edge], mesh: &TriangleMesh, names: Names, warnings: &mut Vec<String>) {
    if let Some(&first) = freed.first() {
        let [a, b] = mesh.edge_vertices(first);
        let edges = counted(freed.len(), "edge of the curve is", "edges of the curve are");
        warnings.push(format!(
            "{edges} all that joins a ring of faces, the first from {} to {}: the nonbounding part may be larger than the \
             curve there; refine the mesh around it",
            names.vertex(a),
            names.vertex(b)
        ));
    }
}

/// Less than this share of uncertain area is the rule along the gaps of a broken curve.
const MUCH_UNCERTAIN: f64 = 0.05;

pub(super) fn note_uncertain(share: f64, warnings: &mut Vec<String>) {
    if share > MUCH_UNCERTAIN {
        warnings.push(format!(
            "on {:.0} % of the area the label is next to a guess, as the winding number lies almost halfway between two whole \
             numbers (see `margin`): close the widest gaps of the curve",
            100.0 * share
        ));
    }
}
