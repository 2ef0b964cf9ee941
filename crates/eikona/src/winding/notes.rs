//! What the user is told of.

use crate::winding::chain::Chain;
use crate::winding::coordinates::Coordinates;
use crate::winding::islands::Islands;
use crate::wording::counted;
use eikona_mesh::{Edge, TriangleMesh};

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

pub(super) fn note_not_fans(coordinates: &Coordinates, warnings: &mut Vec<String>) {
    if let Some(first) = coordinates.not_fans.first() {
        let vertices =
            counted(coordinates.not_fans.len(), "vertex of the curve has", "vertices of the curve have");
        warnings.push(format!(
            "{vertices} more than one fan of faces, the first is vertex {}; the winding number has no value there",
            first.index()
        ));
    }
}

pub(super) fn note_without_value(islands: &Islands, warnings: &mut Vec<String>) {
    if let Some((first, _)) = islands.without_value.first() {
        let faces = counted(islands.without_value.len(), "face has", "faces have");
        warnings.push(format!(
            "{faces} endpoints at all corners, so no value, the first is {first}; labelled like the nearest face with one"
        ));
    }
}

pub(super) fn note_freed(freed: &[Edge], mesh: &TriangleMesh, warnings: &mut Vec<String>) {
    if let Some(&first) = freed.first() {
        let [a, b] = mesh.edge_vertices(first);
        let edges = counted(freed.len(), "edge of the curve is", "edges of the curve are");
        warnings.push(format!(
            "{edges} all that joins a ring of faces, the first from vertex {} to {}: the nonbounding part may be larger than the \
             curve there; refine the mesh around it",
            a.index(),
            b.index()
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
