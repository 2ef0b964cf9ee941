//! Lengths of the gaps of curves.

use eikona::geometry::vector::distance;
use eikona::mesh::{Located, SurfaceCurves, TriangleMesh};
use std::collections::BTreeMap;

/// Returns the distance in space from each open end to the nearest other one, in ascending order.
/// An end on the boundary of the surface, or where another segment begins, is not open.
pub fn gaps(mesh: &TriangleMesh, source: &SurfaceCurves) -> Vec<f64> {
    let ends = open_ends(mesh, source);
    let nearest = |i: usize| {
        let others = (0..ends.len()).filter(|&j| j != i);
        others.map(|j| distance(ends[i], ends[j])).min_by(f64::total_cmp)
    };
    let mut gaps: Vec<f64> = (0..ends.len()).filter_map(nearest).collect();
    gaps.sort_by(f64::total_cmp);
    gaps
}

fn open_ends(mesh: &TriangleMesh, source: &SurfaceCurves) -> Vec<[f64; 3]> {
    let mut met: BTreeMap<_, (usize, Located)> = BTreeMap::new();
    for end in source.segments(mesh).unwrap().into_iter().flat_map(|segment| segment.ends) {
        met.entry(end.key()).or_insert((0, end)).0 += 1;
    }
    let single = met.into_values().filter(|(count, _)| *count == 1).map(|(_, place)| place);
    single.filter(|place| !on_boundary(mesh, *place)).map(|place| place.position(mesh)).collect()
}

fn on_boundary(mesh: &TriangleMesh, place: Located) -> bool {
    match place {
        Located::Vertex(v) => mesh.is_boundary_vertex(v),
        Located::Edge(e, _) => mesh.is_boundary_edge(e),
        Located::Face(..) => false,
    }
}
