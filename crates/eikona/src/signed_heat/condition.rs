//! The condition of a source: whether its curves have gaps, and how rough they are.

use crate::curves::nearest_end::nearest_others;
use crate::geometry::vector::distance;
use eikona_mesh::{CurveKind, Located, Segment, SurfaceCurves, TriangleMesh};
use std::collections::BTreeMap;

/// What kind of damage the signed curves of a source show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Condition {
    /// No signed curve ends inside the surface, or little is missing.
    Whole,
    /// There are gaps.
    Broken,
    /// There are gaps, and the curves run in zigzag.
    BrokenAndRough,
}

/// Curves count as rough above this [`roughness`]. Measured: isolines of slowly varying functions
/// have up to 0.05, with noise of a third of an edge 0.07 or more, walks along edges 0.13 or more
/// unless they follow straight rows of edges.
const ROUGH: f64 = 0.06;

/// Gaps that make up less than this share of the curves change nothing: measured, coefficients
/// above the paper's 1 pay where about half is missing, and cost a tenth of the accuracy where a
/// tenth is.
const LITTLE: f64 = 0.25;

pub(super) fn condition(mesh: &TriangleMesh, source: &SurfaceCurves) -> Condition {
    let is_signed = |s: &&Segment| source.curves[s.curve].kind == CurveKind::Signed;
    // A source with a fault is refused by the solver.
    let segments = source.segments(mesh).unwrap_or_default();
    let ends = open_ends(mesh, segments.iter().filter(is_signed));
    let length: f64 = segments
        .iter()
        .filter(is_signed)
        .map(|s| s.ends.map(|end| end.position(mesh)))
        .map(|[a, b]| distance(a, b))
        .sum();
    if ends.is_empty() || missing_length(mesh, &ends) < LITTLE * length {
        Condition::Whole
    } else if roughness(mesh, source) > ROUGH {
        Condition::BrokenAndRough
    } else {
        Condition::Broken
    }
}

/// The places inside the surface that only one of the segments meets: the ends of gaps. Not among
/// them are ends at the boundary of the surface and places where one curve begins or ends on
/// another.
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

/// About how much is missing between open ends: half the distance in space from each to the nearest
/// other one.
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

/// Length over which roughness is measured, in mean edges: zigzags along edges are shorter.
const WINDOW: f64 = 3.0;

/// By which share the signed curves are longer than their chords over [`WINDOW`]: about `(window /
/// radius)^2 / 24` for smooth curves, and 0.1 for zigzags along edges.
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
