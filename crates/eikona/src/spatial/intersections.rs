//! Pairs of faces that intersect, decided exactly.

use super::collision::{Sweep, joined};
use crate::geometry::vector::{cross, sub};
use eikona_mesh::{ElementId, Face, TriangleMesh};
use eikona_numeric::NumericError;
use robust::{Coord, Coord3D, orient2d, orient3d};

type Vec3 = [f64; 3];

/// Returns all pairs of faces that intersect, the lower face first, in increasing order.
///
/// Faces that share corners intersect only if they have more points in common than those of their
/// common side or corner: if one crosses the other, or lies folded onto it. Corners at equal
/// positions count as shared. Other faces intersect already if they touch. Faces of zero area have
/// no inside, and are left out.
///
/// All decisions are exact: they use signs of determinants computed without rounding (Shewchuk
/// 1997).
///
/// # Errors
/// [`NumericError::Stopped`].
///
/// # Cost
/// O(F log F) plus the pairs of faces whose boxes meet: about 2 us per face and thread.
///
/// ```
/// use eikona::mesh::{Face, TriangleMesh};
/// use eikona::spatial::self_intersections;
/// // The second triangle pierces the first one.
/// let base = [[0., 0., 0.], [9., 0., 0.], [0., 9., 0.]];
/// let other = [[1., 1., -1.], [2., 1., 3.], [1., 2., 3.]];
/// let mesh = TriangleMesh::new([base, other].concat(), vec![[0, 1, 2], [3, 4, 5]])?;
/// assert_eq!(self_intersections(&mesh, 1)?, [[Face(0), Face(1)]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn self_intersections(mesh: &TriangleMesh, threads: usize) -> Result<Vec<[Face; 2]>, NumericError> {
    pairs_of(mesh, |_, _| true, threads)
}

/// Returns all pairs of a face of the first mesh and one of the second that intersect, in
/// increasing order. Faces that touch intersect.
///
/// # Errors
/// [`NumericError::Stopped`].
///
/// # Cost
/// O(F log F) for the faces of both.
///
/// ```
/// use eikona::mesh::{Face, TriangleMesh};
/// use eikona::spatial::intersections_with;
/// let base = TriangleMesh::new(vec![[0., 0., 0.], [9., 0., 0.], [0., 9., 0.]], vec![[0, 1, 2]])?;
/// let corners = vec![[1., 1., -1.], [2., 1., 3.], [1., 2., 3.]];
/// let other = TriangleMesh::new(corners, vec![[0, 1, 2]])?;
/// assert_eq!(intersections_with(&base, &other, 1)?, [[Face(0), Face(0)]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn intersections_with(
    mesh: &TriangleMesh,
    other: &TriangleMesh,
    threads: usize,
) -> Result<Vec<[Face; 2]>, NumericError> {
    let first = mesh.face_count();
    let is_first = |f: Face| f.index() < first;
    let pairs = pairs_of(&joined(mesh, other), |f, g| is_first(f) != is_first(g), threads)?;
    Ok(pairs.into_iter().map(|[f, g]| [f, Face::from_index(g.index() - first)]).collect())
}

/// The pairs that count and intersect.
fn pairs_of(
    mesh: &TriangleMesh,
    counts: impl Fn(Face, Face) -> bool + Sync,
    threads: usize,
) -> Result<Vec<[Face; 2]>, NumericError> {
    let still = vec![[0.0; 3]; mesh.vertex_count()];
    let sweep = Sweep::new(mesh, mesh.face_count(), &still, threads)?;
    let found = |leaves: &[usize]| {
        let mut pairs = Vec::new();
        sweep.for_pairs(leaves, |a, b| {
            let [f, g] = [a, b].map(|place| sweep.face(place));
            if counts(f, g) && triangles_intersect(mesh.face_positions(f), mesh.face_positions(g)) {
                pairs.push([f.min(g), f.max(g)]);
            }
        })?;
        Ok(pairs)
    };
    let mut pairs = sweep.tree.over_leaves(threads, found)?.concat();
    pairs.sort_unstable();
    Ok(pairs)
}

/// Whether two triangles have more points in common than shared corners and sides.
pub(crate) fn triangles_intersect(s: [Vec3; 3], t: [Vec3; 3]) -> bool {
    if has_no_area(s) || has_no_area(t) {
        return false;
    }
    // The corner of t at each corner of s.
    let shared = s.map(|p| t.iter().position(|&q| q == p));
    let opposite =
        |triangle: [Vec3; 3], corner: usize| [triangle[(corner + 1) % 3], triangle[(corner + 2) % 3]];
    match shared.iter().flatten().count() {
        0 => {
            let sides = |triangle: [Vec3; 3]| (0..3).map(move |corner| opposite(triangle, corner));
            sides(s).any(|side| meets(side, t)) || sides(t).any(|side| meets(side, s))
        }
        // What they have in common beyond the corner reaches an opposite side.
        1 => shared
            .iter()
            .enumerate()
            .any(|(i, j)| j.is_some_and(|j| meets(opposite(s, i), t) || meets(opposite(t, j), s))),
        2 => {
            let i = shared.iter().position(Option::is_none).unwrap_or(0);
            let j = (0..3).find(|j| !shared.contains(&Some(*j))).unwrap_or(0);
            let [a, b] = opposite(s, i);
            orient(a, b, s[i], t[j]) == 0.0 && {
                let axis = widest_axis(s);
                flat(axis, a, b, s[i]).signum() == flat(axis, a, b, t[j]).signum()
            }
        }
        _ => true,
    }
}

/// Whether a point lies inside a tetrahedron, not on its faces.
pub(crate) fn is_in_tetrahedron(p: Vec3, [a, b, c, d]: [Vec3; 4]) -> bool {
    let signs = [orient(p, b, c, d), orient(a, p, c, d), orient(a, b, p, d), orient(a, b, c, p)];
    signs.iter().all(|x| *x > 0.0) || signs.iter().all(|x| *x < 0.0)
}

/// Six times the signed volume of a tetrahedron, with the exact sign.
fn orient(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> f64 {
    let coord = |[x, y, z]: Vec3| Coord3D { x, y, z };
    orient3d(coord(a), coord(b), coord(c), coord(d))
}

/// Twice the signed area of a triangle seen along an axis, with the exact sign.
fn flat(axis: usize, a: Vec3, b: Vec3, c: Vec3) -> f64 {
    let coord = |p: Vec3| Coord { x: p[(axis + 1) % 3], y: p[(axis + 2) % 3] };
    orient2d(coord(a), coord(b), coord(c))
}

fn has_no_area([a, b, c]: [Vec3; 3]) -> bool {
    (0..3).all(|axis| flat(axis, a, b, c) == 0.0)
}

/// The axis along which a triangle of positive area is seen at its largest; it has area there.
fn widest_axis([a, b, c]: [Vec3; 3]) -> usize {
    let normal = cross(sub(b, a), sub(c, a)).map(f64::abs);
    let has_area = |axis: &usize| flat(*axis, a, b, c) != 0.0;
    (0..3).filter(has_area).max_by(|&i, &j| normal[i].total_cmp(&normal[j])).unwrap_or(0)
}

/// Whether a segment meets a triangle of positive area; touching counts.
fn meets([p, q]: [Vec3; 2], triangle: [Vec3; 3]) -> bool {
    let [a, b, c] = triangle;
    let (at_p, at_q) = (orient(a, b, c, p), orient(a, b, c, q));
    if at_p * at_q > 0.0 || (at_p.signum() == at_q.signum() && at_p != 0.0 && at_q != 0.0) {
        return false;
    }
    if at_p == 0.0 && at_q == 0.0 {
        return meets_in_plane([p, q], triangle);
    }
    let turns = [orient(p, q, a, b), orient(p, q, b, c), orient(p, q, c, a)];
    turns.iter().all(|x| *x >= 0.0) || turns.iter().all(|x| *x <= 0.0)
}

/// The same for a segment in the plane of the triangle.
fn meets_in_plane([p, q]: [Vec3; 2], triangle: [Vec3; 3]) -> bool {
    let axis = widest_axis(triangle);
    let [a, b, c] = triangle;
    let inside = |p: Vec3| {
        let turns = [flat(axis, a, b, p), flat(axis, b, c, p), flat(axis, c, a, p)];
        turns.iter().all(|x| *x >= 0.0) || turns.iter().all(|x| *x <= 0.0)
    };
    inside(p) || inside(q) || [[a, b], [b, c], [c, a]].iter().any(|&side| cross_in_plane(axis, [p, q], side))
}

/// Whether two segments in a plane cross at an inner point of both. Others that meet have an end in
/// the triangle, or meet another side of it.
fn cross_in_plane(axis: usize, [p, q]: [Vec3; 2], [a, b]: [Vec3; 2]) -> bool {
    let opposite = |x: f64, y: f64| (x > 0.0 && y < 0.0) || (x < 0.0 && y > 0.0);
    let (at_a, at_b) = (flat(axis, p, q, a), flat(axis, p, q, b));
    let (at_p, at_q) = (flat(axis, a, b, p), flat(axis, a, b, q));
    if opposite(at_p, at_q) {
        // The segment passes through the line of the side; a corner on it counts.
        return opposite(at_a, at_b) || at_a == 0.0 || at_b == 0.0;
    }
    false
}
