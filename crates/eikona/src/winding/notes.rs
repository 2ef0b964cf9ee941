//! User-facing warnings.

use crate::winding::chain::Chain;
use crate::winding::coordinates::Coordinates;
use crate::winding::islands::Islands;
use crate::wording::counted;
use eikona_mesh::{Edge, Face, Provenance, SurfacePoint, TriangleMesh, Vertex};

/// Names of elements in warnings. The user knows only elements of the input: on a cut mesh a vertex
/// is named by its place, a face by the face it was cut from.
#[derive(Clone, Copy, Default)]
pub(super) struct Names<'a>(pub Option<&'a Provenance>);

impl Names<'_> {
    fn vertex(self, v: Vertex) -> String {
        match self.0.and_then(|cut| cut.vertex_place(v)) {
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
            Some(cut) => format!("a part of {}", cut.face_parent(f)),
        }
    }
}

pub(super) fn note_chain(chain: &Chain, warnings: &mut Vec<String>) {
    if chain.cancelled > 0 {
        let edges = counted(chain.cancelled, "edge is", "edges are");
        warnings.push(format!("{edges} traversed equally often in both directions; these steps cancel"));
    }
    if chain.on_boundary > 0 {
        let steps = counted(chain.on_boundary, "step runs", "steps run");
        warnings.push(format!("{steps} along the boundary, where no jump is possible; ignored"));
    }
    if chain.on_nonmanifold > 0 {
        let steps = counted(chain.on_nonmanifold, "step runs", "steps run");
        warnings
            .push(format!("{steps} along edges of three or more faces, where left is undefined; ignored"));
    }
    if chain.jump.iter().all(|&j| j == 0) {
        warnings.push("no edge has a jump, so all labels are 0".into());
    }
}

pub(super) fn note_not_fans(coordinates: &Coordinates, names: Names, warnings: &mut Vec<String>) {
    if let Some(&first) = coordinates.not_fans.first() {
        let count = coordinates.not_fans.len();
        let vertices =
            counted(count, "vertex of the completed curve has", "vertices of the completed curve have");
        warnings.push(format!(
            "{vertices} more than one fan of faces (first: {}); the winding number is undefined there",
            names.vertex(first)
        ));
    }
}

pub(super) fn note_without_value(islands: &Islands, names: Names, warnings: &mut Vec<String>) {
    if let Some(&(first, _)) = islands.without_value.first() {
        let faces = counted(islands.without_value.len(), "face has", "faces have");
        warnings.push(format!(
            "{faces} no value at any corner (first: {}); labels there come from the nearest face with a value, if there is one",
            names.face(first)
        ));
    }
}

pub(super) fn note_freed(freed: &[Edge], mesh: &TriangleMesh, names: Names, warnings: &mut Vec<String>) {
    if let Some(&first) = freed.first() {
        let [a, b] = mesh.edge_vertices(first);
        let edges = counted(freed.len(), "edge of the curve is", "edges of the curve are");
        warnings.push(format!(
            "{edges} the only edges connecting a ring of faces (first: from {} to {}), so the nonbounding part may exceed \
             the curve there; refine the mesh around them",
            names.vertex(a),
            names.vertex(b)
        ));
    }
}

/// Along the gaps of a broken curve a smaller share of uncertain area is normal.
const MUCH_UNCERTAIN: f64 = 0.05;

pub(super) fn note_uncertain(share: f64, warnings: &mut Vec<String>) {
    if share > MUCH_UNCERTAIN {
        warnings.push(format!(
            "labels are uncertain (margin below 0.1) on {:.0} % of the area; close the widest gaps of the curve",
            100.0 * share
        ));
    }
}
