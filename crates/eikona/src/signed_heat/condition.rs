//! Condition of a source: whether its curves have gaps, and how rough they are.

use crate::curves::nearest_end::nearest_others;
use crate::geometry::vector::distance;
use eikona_mesh::{CurveKind, Located, Segment, SurfaceCurves, TriangleMesh};
use std::collections::BTreeMap;

/// Condition of the signed curves of a source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Condition {
    /// No signed curve ends inside the surface, or little is missing.
    Whole,
    /// The curves have gaps.
    Broken,
    /// The curves have gaps and are rough.
    BrokenAndRough,
}

/// Curves with a larger [`roughness`] count as rough. Measured: isolines of slowly varying
/// functions have at most 0.05; with noise of a third of an edge, at least 0.07; walks along edges,
/// at least 0.13 unless they follow straight rows of edges.
const ROUGH: f64 = 0.06;

/// Gaps that make up less than this share of the curves count as none. Measured: coefficients above
/// the paper's 1 pay off where about half is missing, and cost a tenth of the accuracy where a
/// tenth is missing.
const SMALL_GAPS: f64 = 0.25;

pub(super) fn condition(mesh: &TriangleMesh, source: &SurfaceCurves) -> Condition {
    let is_signed = |s: &&Segment| source.curves[s.curve].kind == CurveKind::Signed;
    // The solver reports invalid sources.
    let segments = source.segments(mesh).unwrap_or_default();
    let ends = open_ends(mesh, segments.iter().filter(is_signed));
    let length: f64 = segments
        .iter()
        .filter(is_signed)
        .map(|s| s.ends.map(|end| end.position(mesh)))
        .map(|[a, b]| distance(a, b))
        .sum();
    if ends.is_empty() || missing_length(mesh, &ends) < SMALL_GAPS * length {
        Condition::Whole
    } else if roughness(mesh, source) > ROUGH {
        Condition::BrokenAndRough
    } else {
        Condition::Broken
    }
}

/// Returns the open ends of the segments, at which gaps begin: places inside the surface that
/// exactly one segment meets. Ends on the boundary of the surface, and places where a curve begins
/// or ends on another, are not open.
pub(super) fn open_ends<'a>(
    mesh: &TriangleMesh,
    segments: impl Iterator<Item = &'a Segment>,
) -> Vec<Located> {
    let mut met: BTreeMap<_, (usize, Located)> = BTreeMap::new();
    for end in segments.flat_map(|segment| segment.ends) {
        met.entry(end.key()).or_insert((0, end)).0 += 1;
    }
    let single = met.into_values().filter(|(count, _)| *count == 1).map(|(_, place)| place);
    single.filter(|place| !on_boundary(mesh, *place)).collect()
}

/// Estimates the total length of the gaps: half the distance in space from each open end to the
/// nearest other one.
fn missing_length(mesh: &TriangleMesh, ends: &[Located]) -> f64 {
    let positions: Vec<[f64; 3]> = ends.iter().map(|end| end.position(mesh)).collect();
    let nearest = nearest_others(&positions);
    nearest.into_iter().flatten().map(|(_, gap)| 0.5 * gap).sum()
}

fn on_boundary(mesh: &TriangleMesh, place: Located) -> bool {
    match place {
        Located::Vertex(v) => mesh.is_boundary_vertex(v),
        Located::Edge(e, _) => mesh.is_boundary_edge(e),
        Located::Face(..) => false,
    }
}

/// Length over which roughness is measured, in mean edge lengths; longer than zigzags along edges.
const WINDOW: f64 = 3.0;

/// Relative excess of the length of the signed curves over that of their chords across [`WINDOW`]:
/// about `(window / radius)^2 / 24` for smooth curves, and 0.1 for zigzags along edges.
pub(super) fn roughness(mesh: &TriangleMesh, source: &SurfaceCurves) -> f64 {
    let lengths = mesh.edges().map(|e| {
        let [a, b] = mesh.edge_vertices(e).map(|v| mesh.position(v));
        distance(a, b)
    });
    let window = WINDOW * lengths.sum::<f64>() / mesh.edge_count().max(1) as f64;
    let (mut arcs, mut chords) = (0.0, 0.0);
    for curve in source.curves.iter().filter(|c| c.kind == CurveKind::Signed) {
        let places = curve.nodes.iter().filter_map(|p| p.locate(mesh).ok());
        let mut points = places.map(|p| p.position(mesh));
        let Some(mut from) = points.next() else { continue };
        let (mut last, mut arc) = (from, 0.0);
        for p in points {
            arc += distance(last, p);
            last = p;
            if arc >= window {
                arcs += arc;
                chords += distance(from, p);
                (from, arc) = (p, 0.0);
            }
        }
        arcs += arc;
        chords += distance(from, last);
    }
    if arcs > 0.0 { 1.0 - chords / arcs } else { 0.0 }
}
