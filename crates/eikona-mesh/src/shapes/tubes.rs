//! Tubes around curves in space: knots and chains.

use super::curves::{figure_eight_knot_point, trefoil_point};
use super::lattice::{Diagonal, Lattice, Seam};
use super::parameter::{limit_faces, refuse, require, require_length, require_ring, require_some};
use super::revolution::{check_torus, torus_lattice, torus_point};
use super::vector::{Vec3, add, cross, distance, dot, norm, scale, sub, unit};
use crate::error::MeshError;
use crate::mesh::TriangleMesh;
use std::f64::consts::TAU;

/// A tube: the points at distance `radius` from a curve, in its normal planes.
///
/// `curve` is called with parameters in [0, 1]; the values of a closed curve at 0 and 1 must agree.
/// The `n_along` cross-sections are (nearly) evenly spaced in arc length. Their frame is rotation
/// minimising; on a closed curve the remaining angle is spread evenly over all sections, so that
/// the seam does not show.
///
/// Closed: V = na nr, E = 3 na nr, F = 2 na nr. Open, without ends: V = (na + 1) nr, E = (3 na + 1)
/// nr, F = 2 na nr. Outward oriented. The tube crosses itself where the curve's radius of
/// curvature, or half its distance to itself, is below `radius`.
///
/// # Errors
/// [`MeshError::Parameter`] if the radius is not a length, `n_around` < 3, `n_along` < 3 (open: <
/// 1), there are too many faces, or the curve is not finite, has zero speed somewhere, or does not
/// close.
///
/// Reference: W. Wang, B. Jüttler, D. Zheng, Y. Liu, "Computation of rotation minimizing frames",
/// ACM TOG 27 (2008).
///
/// ```
/// use std::f64::consts::TAU;
/// let circle = |t: f64| [(TAU * t).cos(), (TAU * t).sin(), 0.0];
/// let ring = eikona_mesh::shapes::tube(&circle, true, 0.2, 40, 12)?;
/// assert_eq!((ring.vertex_count(), ring.edge_count(), ring.face_count()), (480, 1440, 960));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn tube(
    curve: &dyn Fn(f64) -> [f64; 3],
    closed: bool,
    radius: f64,
    n_along: usize,
    n_around: usize,
) -> Result<TriangleMesh, MeshError> {
    require_length("radius", radius)?;
    require_ring("n_around", n_around)?;
    if closed {
        require_ring("n_along", n_along)?;
    } else {
        require_some("n_along", n_along)?;
    }
    limit_faces("n_along", n_along, 2.0 * n_along as f64 * n_around as f64)?;
    let parameters = evenly_spaced_parameters(curve, closed, n_along)?;
    let points: Vec<Vec3> = parameters.iter().map(|&t| curve(t)).collect();
    let tangents =
        parameters.iter().map(|&t| tangent(curve, closed, t)).collect::<Result<Vec<Vec3>, MeshError>>()?;
    let normals = rotation_minimising_normals(&points, &tangents, closed);

    let seam = if closed { Seam::Closed } else { Seam::Open };
    let lattice = Lattice { columns: n_along, rows: n_around, seam, rows_closed: true };
    lattice.mesh(Diagonal::Shorter, |i, j| {
        let binormal = cross(tangents[i], normals[i]);
        let (s, c) = (TAU * j as f64 / n_around as f64).sin_cos();
        add(points[i], add(scale(normals[i], radius * c), scale(binormal, -radius * s)))
    })
}

/// Number of chords that measure the arc length of one section.
const CHORDS: usize = 16;

/// Returns the parameters of n (closed) or n + 1 (open) points that divide the curve into n pieces
/// of equal length, measured by chords.
fn evenly_spaced_parameters(
    curve: &dyn Fn(f64) -> Vec3,
    closed: bool,
    n: usize,
) -> Result<Vec<f64>, MeshError> {
    let samples = CHORDS * n;
    let mut lengths = Vec::with_capacity(samples + 1);
    let mut total = 0.0;
    let start = curve(0.0);
    let mut previous = start;
    for i in 0..=samples {
        let t = i as f64 / samples as f64;
        let here = curve(t);
        total += distance(previous, here);
        if total.is_nan() || total > 1e70 {
            return refuse(
                "curve",
                format_args!("{here:?} at t = {t}"),
                "its points must be finite and below 1e70",
            );
        }
        lengths.push(total);
        previous = here;
    }
    require(total >= 1e-70, "curve", format_args!("length {total:e}"), "its length must be at least 1e-70")?;
    if closed {
        let gap = distance(start, previous);
        let bound = "the ends of a closed curve must agree; make it an open tube or close the curve";
        require(gap <= 1e-6 * total, "curve", format_args!("gap {gap:e} of length {total:e}"), bound)?;
    }
    let mut parameters = Vec::with_capacity(n + 1);
    let mut i = 0;
    for k in 0..n {
        let wanted = total * k as f64 / n as f64;
        while i + 1 < samples && lengths[i + 1] <= wanted {
            i += 1;
        }
        let step = lengths[i + 1] - lengths[i];
        let share = if step > 0.0 { (wanted - lengths[i]) / step } else { 0.0 };
        parameters.push((i as f64 + share.clamp(0.0, 1.0)) / samples as f64);
    }
    if !closed {
        parameters.push(1.0);
    }
    Ok(parameters)
}

/// Returns the unit tangent, by a finite difference over 2e-5 of the parameter, one-sided at the
/// ends of an open curve.
fn tangent(curve: &dyn Fn(f64) -> Vec3, closed: bool, t: f64) -> Result<Vec3, MeshError> {
    const STEP: f64 = 1e-5;
    let at = |t: f64| if closed { curve(t.rem_euclid(1.0)) } else { curve(t.clamp(0.0, 1.0)) };
    let difference = sub(at(t + STEP), at(t - STEP));
    let length = norm(difference);
    if length.is_finite() && length > 0.0 {
        return Ok(scale(difference, 1.0 / length));
    }
    refuse(
        "curve",
        format_args!("zero or infinite speed at t = {t}"),
        "its speed must be positive and finite everywhere",
    )
}

/// Returns a unit normal at each point; each follows from the previous one by two reflections,
/// without rotation about the tangent.
fn rotation_minimising_normals(points: &[Vec3], tangents: &[Vec3], closed: bool) -> Vec<Vec3> {
    let first = any_normal(tangents[0]);
    let mut normals = vec![first];
    let transport = |normal: Vec3, from: usize, to: usize| {
        let reflect = |v: Vec3, mirror: Vec3| {
            let size_sq = dot(mirror, mirror);
            if size_sq > 0.0 { sub(v, scale(mirror, 2.0 * dot(mirror, v) / size_sq)) } else { v }
        };
        let chord = unit(sub(points[to], points[from]));
        let (normal, tangent) = (reflect(normal, chord), reflect(tangents[from], chord));
        let moved = reflect(normal, sub(tangents[to], tangent));
        // Keeps the frame perpendicular despite accumulated rounding.
        unit(sub(moved, scale(tangents[to], dot(moved, tangents[to]))))
    };
    for i in 1..points.len() {
        normals.push(transport(normals[i - 1], i - 1, i));
    }
    if closed {
        let last = points.len() - 1;
        let returned = transport(normals[last], last, 0);
        let holonomy = dot(cross(first, returned), tangents[0]).atan2(dot(first, returned));
        for (i, normal) in normals.iter_mut().enumerate() {
            let (s, c) = (-holonomy * i as f64 / points.len() as f64).sin_cos();
            *normal = add(scale(*normal, c), scale(cross(tangents[i], *normal), s));
        }
    }
    normals
}

/// Returns a unit vector perpendicular to this one, from the axis with the smallest component.
fn any_normal(tangent: Vec3) -> Vec3 {
    let size = tangent.map(f64::abs);
    let axis = if size[0] <= size[1] && size[0] <= size[2] {
        [1.0, 0.0, 0.0]
    } else if size[1] <= size[2] {
        [0.0, 1.0, 0.0]
    } else {
        [0.0, 0.0, 1.0]
    };
    unit(sub(axis, scale(tangent, dot(axis, tangent))))
}

/// A tube around the trefoil knot (sin t + 2 sin 2t, cos t - 2 cos 2t, -sin 3t): a knotted torus.
///
/// V = na nr, E = 3 na nr, F = 2 na nr, χ = 0, outward oriented. Free of self-intersections up to
/// radius 0.45.
///
/// # Errors
/// [`MeshError::Parameter`] as for [`tube`].
///
/// ```
/// let knot = eikona_mesh::shapes::trefoil_tube(0.4, 200, 16)?;
/// assert_eq!((knot.vertex_count(), knot.edge_count(), knot.face_count()), (3200, 9600, 6400));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn trefoil_tube(radius: f64, n_along: usize, n_around: usize) -> Result<TriangleMesh, MeshError> {
    tube(&trefoil_point, true, radius, n_along, n_around)
}

/// A tube around the figure-eight knot ((2 + cos 2t) cos 3t, (2 + cos 2t) sin 3t, sin 4t).
///
/// V = na nr, E = 3 na nr, F = 2 na nr, χ = 0, outward oriented. Free of self-intersections up to
/// radius 0.25.
///
/// # Errors
/// [`MeshError::Parameter`] as for [`tube`].
///
/// ```
/// let knot = eikona_mesh::shapes::figure_eight_tube(0.2, 300, 12)?;
/// assert_eq!((knot.vertex_count(), knot.face_count()), (3600, 7200));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn figure_eight_tube(radius: f64, n_along: usize, n_around: usize) -> Result<TriangleMesh, MeshError> {
    tube(&figure_eight_knot_point, true, radius, n_along, n_around)
}

/// A chain of `count` tori of major radius 1 along the x axis, each linked with the next,
/// alternately in the planes z = 0 and y = 0.
///
/// V = c nu nv, E = 3 c nu nv, F = 2 c nu nv for c rings; c components. Outward oriented, free of
/// intersections.
///
/// # Errors
/// [`MeshError::Parameter`] if `count` is 0, `minor` is not in [1e-6, 0.3], `nu` or `nv` is below
/// 3, or there are too many faces.
///
/// ```
/// let chain = eikona_mesh::shapes::linked_rings(3, 0.2, 32, 12)?;
/// assert_eq!((chain.vertex_count(), chain.edge_count(), chain.face_count()), (1152, 3456, 2304));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn linked_rings(count: usize, minor: f64, nu: usize, nv: usize) -> Result<TriangleMesh, MeshError> {
    require_some("count", count)?;
    require(
        (1e-6..=0.3).contains(&minor),
        "minor",
        minor,
        "it must lie between 1e-6 and 0.3, so that links do not touch",
    )?;
    check_torus(1.0, minor, nu, nv, count)?;
    // Halfway between touching the next ring and touching the one after it.
    let spacing = 1.5 - 0.5 * minor;
    let lattice = torus_lattice(nu, nv);
    let mut positions = Vec::with_capacity(count * nu * nv);
    let mut faces = Vec::with_capacity(2 * count * nu * nv);
    for ring in 0..count {
        let first = positions.len() as u32;
        let ring_positions = lattice.positions(|i, j| {
            let [x, y, z] = torus_point(1.0, minor, nu, nv, i, j);
            let x = x + spacing * ring as f64;
            if ring % 2 == 0 { [x, y, z] } else { [x, -z, y] }
        });
        let ring_faces = lattice.triangles(&ring_positions, Diagonal::Uniform);
        faces.extend(ring_faces.into_iter().map(|f| f.map(|v| v + first)));
        positions.extend(ring_positions);
    }
    TriangleMesh::new(positions, faces)
}
