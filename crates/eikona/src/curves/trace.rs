//! Traces polylines in space, and curves whose segments span several faces, into curves with each
//! segment in one face.
//!
//! Each point is projected to the nearest point of the surface. Two points are joined by walking
//! from face to face along the plane through both that contains the mean of their normals
//! ([`plane_walks`]). Where the walk leaves the surface, runs much longer than the segment or
//! misses its end, the segment is halved in space, its midpoint is projected, and both halves are
//! traced. A walk that may be a detour is compared with the shortest path on the surface
//! ([`PathSearch`]), which replaces it if clearly shorter, and also where no walk arrives.

use super::TraceError;
use super::shortest::{AMBIGUOUS, PathSearch};
use super::side::Fans;
use super::walk::{Walked, plane_walks};
use crate::Warning;
use crate::geometry::vector::{distance, lerp};
use crate::spatial::Bvh;
use eikona_mesh::{Curve, CurveKind, Located, TriangleMesh, segment_host};
use std::cell::{OnceCell, RefCell};

/// Default tolerance for moving nodes onto a nearby vertex or edge, as a share of the face's size:
/// it avoids segments of length 1e-14 without visible displacement.
pub const DEFAULT_TOLERANCE: f64 = 1e-6;

/// Times a segment is halved before the shortest path replaces it: 64 parts show whether the
/// polyline follows the surface.
const HALVINGS: u32 = 6;

/// A walk in a trusted plane follows the polyline more closely than the shortest path does. It is
/// kept if it is at most this many times as long.
const DETOUR: f64 = 1.05;

/// Comparisons end when the searches for one curve have settled this many nodes (about 10 seconds)
/// plus [`COMPARED_MESHES`] times all vertices and edges.
const COMPARED: usize = 30_000_000;

/// See [`COMPARED`].
const COMPARED_MESHES: usize = 20;

/// A path longer than this multiple of the straight segment may have alternatives of equal length.
const ROUNDABOUT: f64 = 1.25;

/// A curve with each segment in one face, and how it was made.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Traced {
    /// The curve. A closed one repeats its first node at the end.
    pub curve: Curve,
    /// For each node of the curve, the 0-based index of the input node that it represents or
    /// follows.
    pub parents: Vec<usize>,
    /// Largest distance between a point and its projection; 0 for curves already on the surface.
    pub largest_projection_distance: f64,
    /// Input nodes that coincide with their predecessor and were removed.
    pub merged: Vec<usize>,
    /// Input nodes whose following segment was halved and projected again.
    pub subdivided: Vec<usize>,
    /// Input nodes whose following segment does not follow the surface and was replaced by the
    /// shortest path.
    pub replaced: Vec<usize>,
    /// Input nodes whose following segment would take a detour and was replaced by the shortest
    /// path.
    pub shortened: Vec<usize>,
    /// Input nodes whose following segment has several paths whose lengths differ by at most 3 %.
    pub ambiguous: Vec<usize>,
    /// Input nodes whose following segment may take a detour: earlier long segments exhausted the
    /// limit on comparisons with the shortest path.
    pub uncompared: Vec<usize>,
}

impl Traced {
    /// Returns the warnings about this polyline.
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let mut add = |nodes: &[usize], warning: fn(Vec<usize>) -> Warning| {
            if !nodes.is_empty() {
                warnings.push(warning(nodes.to_vec()));
            }
        };
        add(&self.merged, |nodes| Warning::MergedNodes { nodes });
        add(&self.replaced, |nodes| Warning::ReplacedSegments { nodes });
        add(&self.ambiguous, |nodes| Warning::AmbiguousSegments { nodes, tolerance: AMBIGUOUS });
        add(&self.uncompared, |nodes| Warning::UncomparedSegments { nodes });
        warnings
    }
}

/// Projects a polyline in space onto the mesh and traces it across the faces.
///
/// `tolerance` is the share of a face within which nodes move onto vertices and edges, and within
/// which points coincide; [`DEFAULT_TOLERANCE`] is a good choice.
///
/// ```
/// use eikona::curves::{DEFAULT_TOLERANCE, trace_polyline};
/// use eikona::spatial::Bvh;
/// use eikona_mesh::{CurveKind, SurfaceCurves, TriangleMesh};
/// let corners = vec![[0., 0., 0.], [1., 0., 0.], [1., 1., 0.], [0., 1., 0.]];
/// let mesh = TriangleMesh::new(corners, vec![[0, 1, 2], [0, 2, 3]])?;
/// let line = [[0.5, 0.0, 3.0], [0.0, 0.5, 3.0]];
/// let (bvh, kind) = (Bvh::new(&mesh), CurveKind::Signed);
/// let traced = trace_polyline(&mesh, &bvh, &line, false, kind, DEFAULT_TOLERANCE)?;
/// assert_eq!(traced.curve.nodes.len(), 3, "it crosses the diagonal");
/// assert_eq!(traced.largest_projection_distance, 3.0);
/// assert_eq!(SurfaceCurves::from_curve(traced.curve).segments(&mesh)?.len(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`TraceError::NoFaces`], [`TraceError::NonFinitePoint`], [`TraceError::TooFewPoints`] (also if
/// all points coincide), [`TraceError::Parameter`] for a tolerance outside [0, 0.1], and
/// [`TraceError::NotConnected`] if the surface has no path between two points.
///
/// # Cost
/// O(log F) per point and O(1) per crossed face. A segment that is not nearly straight on the
/// surface takes O(n log n) in the number n of faces whose distances from both ends sum to at most
/// the path's length. These searches end, with a warning, after 30 million nodes plus 20 times the
/// size of the mesh.
pub fn trace_polyline(
    mesh: &TriangleMesh,
    bvh: &Bvh,
    points: &[[f64; 3]],
    closed: bool,
    kind: CurveKind,
    tolerance: f64,
) -> Result<Traced, TraceError> {
    if !(0.0..=0.1).contains(&tolerance) {
        let bound = "choose a share of a face from 0 to 0.1";
        return Err(TraceError::Parameter { name: "tolerance", value: tolerance, bound });
    }
    let tracer = Tracer::new(mesh, Some(bvh), tolerance);
    let mut nodes = Vec::with_capacity(points.len());
    let mut largest: f64 = 0.0;
    for (node, &position) in points.iter().enumerate() {
        if !position.iter().all(|x| x.is_finite()) {
            return Err(TraceError::NonFinitePoint { node, position });
        }
        let (place, distance) = tracer.project(position).ok_or(TraceError::NoFaces)?;
        largest = largest.max(distance);
        nodes.push(place);
    }
    // Ends that differ only by rounding are one point.
    let returns = nodes.len() > 3 && tracer.coincide(nodes[0], nodes[nodes.len() - 1]);
    let mut traced = tracer.trace(&nodes, closed || returns)?;
    traced.largest_projection_distance = largest;
    traced.curve.kind = kind;
    Ok(traced)
}

/// Traces a curve on the mesh whose segments may span several faces; keeps segments in one face.
///
/// # Errors
/// [`TraceError::Curve`] for a node that is not on the mesh, and the errors of
/// [`trace_polyline`].
///
/// # Cost
/// As [`trace_polyline`]; a tree over the faces is built only if a segment has to be halved.
pub fn trace_curve(mesh: &TriangleMesh, curve: &Curve) -> Result<Traced, TraceError> {
    let tracer = Tracer::new(mesh, None, DEFAULT_TOLERANCE);
    let located = curve.nodes.iter().enumerate();
    let located: Result<Vec<Located>, _> =
        located.map(|(n, p)| p.locate(mesh).map_err(|e| e.at(0, n))).collect();
    let mut traced = tracer.trace(&located?, false)?;
    traced.curve.kind = curve.kind;
    traced.curve.up = curve.up;
    Ok(traced)
}

struct Tracer<'a> {
    mesh: &'a TriangleMesh,
    bvh: Option<&'a Bvh>,
    own_bvh: OnceCell<Bvh>,
    tolerance: f64,
    fans: RefCell<Fans<'a>>,
    search: RefCell<PathSearch<'a>>,
    /// Number of settled nodes at which comparisons end.
    compared: usize,
}

impl<'a> Tracer<'a> {
    fn new(mesh: &'a TriangleMesh, bvh: Option<&'a Bvh>, tolerance: f64) -> Self {
        let (fans, search) = (Fans::new(mesh, false).into(), PathSearch::new(mesh).into());
        let compared = COMPARED + COMPARED_MESHES * (mesh.vertex_count() + mesh.edge_count());
        Tracer { mesh, bvh, own_bvh: OnceCell::new(), tolerance, fans, search, compared }
    }

    /// Returns the nearest place on the mesh, moved onto a vertex or edge within the tolerance, and
    /// its distance.
    fn project(&self, p: [f64; 3]) -> Option<(Located, f64)> {
        let bvh = self.bvh.unwrap_or_else(|| self.own_bvh.get_or_init(|| Bvh::new(self.mesh)));
        let closest = bvh.closest_point(p)?;
        let weights = closest.weights.map(|w| if w <= self.tolerance { 0.0 } else { w });
        Some((Located::in_face(self.mesh, closest.face, weights), closest.distance))
    }

    fn trace(&self, nodes: &[Located], closed: bool) -> Result<Traced, TraceError> {
        let mut traced = Traced::default();
        let mut kept: Vec<(usize, Located)> = Vec::new();
        for (i, &node) in nodes.iter().enumerate() {
            if kept.last().is_some_and(|&(_, last)| self.coincide(last, node)) {
                traced.merged.push(i);
            } else {
                kept.push((i, node));
            }
        }
        while closed && kept.len() > 1 && self.coincide(kept[0].1, kept[kept.len() - 1].1) {
            traced.merged.extend(kept.pop().map(|k| k.0));
        }
        if kept.len() < 2 {
            return Err(TraceError::TooFewPoints { points: kept.len() });
        }
        if closed {
            kept.push((kept[0].0, kept[0].1));
        }
        let mut path = vec![kept[0].1];
        traced.parents.push(kept[0].0);
        // Two opposite nodes of a closed curve stand for a circle: the second segment takes the
        // alternative.
        let mut alternative: Option<Vec<Located>> = None;
        for pair in kept.windows(2) {
            let [(from, a), (to, b)] = [pair[0], pair[1]];
            let back = alternative.take().filter(|path| path.first() == Some(&b) && path.last() == Some(&a));
            let piece = if segment_host(self.mesh, a, b).is_some() {
                vec![b]
            } else if let Some(back) = back {
                traced.ambiguous.push(from);
                back.into_iter().rev().skip(1).collect()
            } else {
                let joined = self.join(a, b, from, &mut traced);
                let (path, another) = joined.ok_or(TraceError::NotConnected { from, to })?;
                alternative = another;
                path
            };
            traced.parents.extend(piece.iter().map(|_| from));
            path.extend(piece);
            if let Some(last) = traced.parents.last_mut() {
                *last = to;
            }
        }
        traced.curve.nodes = path.iter().map(|p| p.to_surface_point(self.mesh)).collect();
        Ok(traced)
    }

    /// Whether two places count as the same.
    fn coincide(&self, a: Located, b: Located) -> bool {
        if a == b {
            return true;
        }
        let Some(face) = a.faces(self.mesh).into_iter().find(|&f| b.weights_in_face(self.mesh, f).is_some())
        else {
            return false;
        };
        let p = self.mesh.face_positions(face);
        let size = distance(p[0], p[1]).max(distance(p[1], p[2])).max(distance(p[2], p[0]));
        distance(a.position(self.mesh), b.position(self.mesh)) <= self.tolerance * size
    }

    /// Returns the nodes after `a` up to and including `b`, and an equally good path (with `a`) if
    /// there is one. `None` if the surface does not connect them.
    fn join(
        &self,
        a: Located,
        b: Located,
        node: usize,
        traced: &mut Traced,
    ) -> Option<(Vec<Located>, Option<Vec<Located>>)> {
        // Enough to cross the whole mesh twice in all attempts together, which bounds the walks on
        // any input.
        let mut budget = 2 * self.mesh.face_count() + 64;
        let mut walks = self.walks((a, b), &mut budget);
        if walks.first().is_some_and(|walk| walk.direct) {
            return Some((walks.swap_remove(0).path, None));
        }
        let halved = walks.is_empty();
        if halved {
            let path = self.halve(a, b, HALVINGS, &mut budget);
            walks.extend(path.map(|path| Walked::new(self.mesh, a, path)));
        }
        let arrived = !walks.is_empty();
        let mut search = self.search.borrow_mut();
        let exhausted = search.settled > self.compared;
        if exhausted && arrived {
            traced.uncompared.push(node);
            traced.subdivided.extend(halved.then_some(node));
            return Some((walks.swap_remove(0).path, None));
        }
        let (shortest, length) = search.shortest(a, b)?;
        let good = |walk: &Walked| walk.length <= length * if walk.trusted { DETOUR } else { 1.0 };
        let walk = walks.into_iter().find(good);
        let long = length > ROUNDABOUT * distance(a.position(self.mesh), b.position(self.mesh));
        let doubtful = long || halved || walk.as_ref().is_none_or(|walk| !walk.trusted);
        let way = match walk {
            Some(walk) => {
                traced.subdivided.extend(halved.then_some(node));
                [vec![a], walk.path].concat()
            }
            None => {
                let list = if arrived { &mut traced.shortened } else { &mut traced.replaced };
                list.push(node);
                shortest
            }
        };
        let mut other = None;
        if doubtful && !exhausted {
            other = search.alternative(&way, length);
            traced.ambiguous.extend(other.is_some().then_some(node));
        }
        Some((way[1..].to_vec(), other))
    }

    fn walks(&self, ends: (Located, Located), budget: &mut usize) -> Vec<Walked> {
        plane_walks(self.mesh, &mut self.fans.borrow_mut(), ends, self.tolerance, budget)
    }

    /// Joins both halves of a segment at the projection of its midpoint.
    fn halve(&self, a: Located, b: Located, depth: u32, budget: &mut usize) -> Option<Vec<Located>> {
        let (pa, pb) = (a.position(self.mesh), b.position(self.mesh));
        let (middle, off) = self.project(lerp(pa, pb, 0.5))?;
        let length = distance(pa, pb);
        let advance = |p| distance(middle.position(self.mesh), p);
        // A midpoint beside one of the ends makes no progress; a distant one belongs to another
        // part of the surface.
        if depth == 0 || advance(pa).min(advance(pb)) < 0.1 * length || off > length {
            return None;
        }
        let mut path = Vec::new();
        for (from, to) in [(a, middle), (middle, b)] {
            if segment_host(self.mesh, from, to).is_some() {
                path.push(to);
                continue;
            }
            path.extend(match self.walks((from, to), budget).into_iter().next() {
                Some(walk) => walk.path,
                None => self.halve(from, to, depth - 1, budget)?,
            });
        }
        Some(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use eikona_mesh::shapes::geodesic_sphere;

    #[test]
    fn comparisons_end_with_a_warning_when_a_curve_has_too_many_long_segments() {
        let mesh = geodesic_sphere(10).unwrap();
        let bvh = Bvh::new(&mesh);
        let mut tracer = Tracer::new(&mesh, Some(&bvh), DEFAULT_TOLERANCE);
        tracer.compared = 5_000;
        // A spiral, three nodes per turn.
        let node = |i: usize| {
            let (angle, z) = (2.0 * i as f64, 0.01 * i as f64 - 0.5);
            [angle.cos(), angle.sin(), z]
        };
        let nodes: Vec<Located> = (0..100).map(|i| tracer.project(node(i)).unwrap().0).collect();
        let traced = tracer.trace(&nodes, false).unwrap();
        assert!(traced.uncompared.len() > 50 && traced.uncompared.len() < 99);
        assert!(tracer.search.borrow().settled < 10_000);
        assert!(matches!(traced.warnings()[..], [.., Warning::UncomparedSegments { .. }]));
        let traced = Tracer::new(&mesh, Some(&bvh), DEFAULT_TOLERANCE).trace(&nodes, false).unwrap();
        assert_eq!(traced.warnings(), []);
    }
}
