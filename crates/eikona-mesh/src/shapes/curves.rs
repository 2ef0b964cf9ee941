//! Polylines in space for tests and examples, and functions that break them into pieces.
//!
//! A polyline is a list of nodes; it is closed if its last node equals its first. All curves here
//! are closed.

use super::parameter::{MAX_SHAPE_FACES, require, require_length, require_ring};
use super::vector::{Vec3, distance, lerp};
use crate::error::MeshError;
use crate::random::Random;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Returns nodes at t = 0, 1/n, ..., 1, the last one bitwise equal to the first.
fn closed_polyline(n: usize, at: impl Fn(f64) -> Vec3) -> Result<Vec<Vec3>, MeshError> {
    require_ring("nodes", n)?;
    require(n <= MAX_SHAPE_FACES, "nodes", n, "at most 2^25 segments are allowed")?;
    Ok((0..=n).map(|i| at((i % n) as f64 / n as f64)).collect())
}

/// The circle of this radius about the origin in the plane z = 0, counter-clockwise from (radius,
/// 0, 0): `n` segments, n + 1 nodes.
///
/// # Errors
/// [`MeshError::Parameter`] if n < 3 or the radius is not a length.
///
/// ```
/// let nodes = eikona_mesh::shapes::circle(2.0, 4)?;
/// assert_eq!(nodes.len(), 5);
/// assert_eq!(nodes[0], nodes[4]);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn circle(radius: f64, n: usize) -> Result<Vec<[f64; 3]>, MeshError> {
    require_length("radius", radius)?;
    closed_polyline(n, |t| [radius * (TAU * t).cos(), radius * (TAU * t).sin(), 0.0])
}

/// The circle of latitude `latitude` (radians north of the equator) on the unit sphere, eastward:
/// the north pole is on its left.
///
/// # Errors
/// [`MeshError::Parameter`] if n < 3 or the latitude is not strictly between the poles.
///
/// ```
/// let nodes = eikona_mesh::shapes::latitude_circle(0.5, 100)?;
/// assert!(nodes.iter().all(|p| (p[2] - 0.5f64.sin()).abs() < 1e-15));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn latitude_circle(latitude: f64, n: usize) -> Result<Vec<[f64; 3]>, MeshError> {
    wavy_latitude(latitude, 0.0, 0, n)
}

/// A curve on the unit sphere, eastward, whose latitude is `latitude` + `amplitude` sin(`waves` ·
/// longitude), in radians.
///
/// # Errors
/// [`MeshError::Parameter`] if n < 3 or the curve reaches a pole.
///
/// ```
/// let nodes = eikona_mesh::shapes::wavy_latitude(0.2, 0.3, 5, 200)?;
/// assert!(nodes.iter().all(|p| (p[0].hypot(p[1]).hypot(p[2]) - 1.0).abs() < 1e-15));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn wavy_latitude(
    latitude: f64,
    amplitude: f64,
    waves: u32,
    n: usize,
) -> Result<Vec<[f64; 3]>, MeshError> {
    let between = latitude.abs() + amplitude.abs() < FRAC_PI_2;
    require(between, "latitude", latitude, "with the amplitude it must stay strictly between -π/2 and π/2")?;
    closed_polyline(n, |t| {
        let phi = latitude + amplitude * (f64::from(waves) * TAU * t).sin();
        [phi.cos() * (TAU * t).cos(), phi.cos() * (TAU * t).sin(), phi.sin()]
    })
}

/// The curve on a [`torus`](super::torus) that winds `p` times around the axis and `q` times around
/// the tube. It is a single knot if p and q are coprime.
///
/// # Errors
/// [`MeshError::Parameter`] if n < 3 or the radii are not lengths.
///
/// ```
/// let nodes = eikona_mesh::shapes::torus_knot(2, 3, 1.0, 0.4, 300)?;
/// assert_eq!(nodes.len(), 301);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn torus_knot(p: i32, q: i32, major: f64, minor: f64, n: usize) -> Result<Vec<[f64; 3]>, MeshError> {
    require_length("major", major)?;
    require_length("minor", minor)?;
    closed_polyline(n, |t| {
        let (u, v) = (f64::from(p) * TAU * t, f64::from(q) * TAU * t);
        let from_axis = major + minor * v.cos();
        [from_axis * u.cos(), from_axis * u.sin(), minor * v.sin()]
    })
}

/// The trefoil knot that [`trefoil_tube`](super::trefoil_tube) follows, with `n` segments.
///
/// # Errors
/// [`MeshError::Parameter`] if n < 3.
pub fn trefoil(n: usize) -> Result<Vec<[f64; 3]>, MeshError> {
    closed_polyline(n, trefoil_point)
}

/// The figure-eight knot that [`figure_eight_tube`](super::figure_eight_tube) follows, with `n`
/// segments.
///
/// # Errors
/// [`MeshError::Parameter`] if n < 3.
pub fn figure_eight_knot(n: usize) -> Result<Vec<[f64; 3]>, MeshError> {
    closed_polyline(n, figure_eight_knot_point)
}

pub(super) fn trefoil_point(t: f64) -> Vec3 {
    let t = TAU * t;
    [t.sin() + 2.0 * (2.0 * t).sin(), t.cos() - 2.0 * (2.0 * t).cos(), -(3.0 * t).sin()]
}

pub(super) fn figure_eight_knot_point(t: f64) -> Vec3 {
    let t = TAU * t;
    let r = 2.0 + (2.0 * t).cos();
    [r * (3.0 * t).cos(), r * (3.0 * t).sin(), (4.0 * t).sin()]
}

/// Breaks the polyline into open pieces: from its first node on, a piece of `keep` times its length
/// stays, the following `drop` times its length is removed, and so on. Cuts within a segment get a
/// new node.
///
/// Every piece of a closed polyline is followed by a full gap: the last piece is shortened so that
/// it does not touch the first. 10 % kept and 5 % dropped make 7 pieces: six of 10 % and one of 5
/// %. The last piece of an open polyline ends where the polyline does.
///
/// # Errors
/// [`MeshError::Parameter`] if `keep` or `drop` is not a share between 1e-6 and 1, or the polyline
/// does not have a positive finite length.
///
/// ```
/// use eikona_mesh::shapes::{break_polyline, circle};
/// let pieces = break_polyline(&circle(1.0, 360)?, 0.10, 0.05)?;
/// assert_eq!(pieces.len(), 7);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn break_polyline(nodes: &[[f64; 3]], keep: f64, drop: f64) -> Result<Vec<Vec<[f64; 3]>>, MeshError> {
    break_with(nodes, keep, drop, |mean| mean)
}

/// Breaks the polyline like [`break_polyline`], with random pieces and gaps between half and one
/// and a half times `keep` and `drop`; a closed polyline is also first broken at a random place.
/// Everything random is determined by `seed`.
///
/// # Errors
/// As for [`break_polyline`].
///
/// ```
/// use eikona_mesh::shapes::{break_polyline_at_random, circle};
/// let nodes = circle(1.0, 360)?;
/// let pieces = break_polyline_at_random(&nodes, 0.1, 0.05, 1)?;
/// assert_eq!(pieces, break_polyline_at_random(&nodes, 0.1, 0.05, 1)?);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn break_polyline_at_random(
    nodes: &[[f64; 3]],
    keep: f64,
    drop: f64,
    seed: u64,
) -> Result<Vec<Vec<[f64; 3]>>, MeshError> {
    let mut random = Random::from_seed(seed);
    if !is_closed(nodes) {
        return break_with(nodes, keep, drop, |mean| random.range(0.5 * mean, 1.5 * mean));
    }
    let start = random.uniform() * arc_lengths(nodes)?.last().copied().unwrap_or(0.0);
    let turned = begin_at(nodes, start)?;
    break_with(&turned, keep, drop, |mean| random.range(0.5 * mean, 1.5 * mean))
}

fn is_closed(nodes: &[Vec3]) -> bool {
    nodes.len() > 2 && nodes.first() == nodes.last()
}

fn break_with(
    nodes: &[Vec3],
    keep: f64,
    drop: f64,
    mut length_of: impl FnMut(f64) -> f64,
) -> Result<Vec<Vec<Vec3>>, MeshError> {
    for (name, share) in [("keep", keep), ("drop", drop)] {
        require((1e-6..=1.0).contains(&share), name, share, "a share must lie between 1e-6 and 1")?;
    }
    let lengths = arc_lengths(nodes)?;
    let total = lengths.last().copied().unwrap_or(0.0);
    // A margin for rounding, so that shares that divide the length exactly leave no tiny piece.
    let least = 1e-9 * total;
    let mut pieces = Vec::new();
    let mut from = 0.0;
    let mut i = 0; // the segment that `from` lies in
    while from < total - least {
        let gap = length_of(drop) * total;
        let latest = if is_closed(nodes) { total - gap } else { total };
        let to = (from + length_of(keep) * total).min(latest);
        if to - from > least {
            let piece = stretch(nodes, &lengths, from, to, &mut i);
            pieces.push(piece);
        }
        if to >= latest {
            break;
        }
        from = to + gap;
    }
    Ok(pieces)
}

/// Returns the part between two arc lengths; `i` is a segment at or before `from`, and is advanced
/// to the one in which the part ends.
fn stretch(nodes: &[Vec3], lengths: &[f64], from: f64, to: f64, i: &mut usize) -> Vec<Vec3> {
    let point = |i: usize, s: f64| {
        let length = lengths[i + 1] - lengths[i];
        if length > 0.0 {
            lerp(nodes[i], nodes[i + 1], ((s - lengths[i]) / length).clamp(0.0, 1.0))
        } else {
            nodes[i]
        }
    };
    let last = nodes.len() - 2;
    while *i < last && lengths[*i + 1] <= from {
        *i += 1;
    }
    let mut piece = vec![point(*i, from)];
    while *i < last && lengths[*i + 1] < to {
        *i += 1;
        if piece.last() != Some(&nodes[*i]) {
            piece.push(nodes[*i]);
        }
    }
    piece.push(point(*i, to));
    piece
}

/// Rotates a closed polyline so that it begins and ends at this arc length.
fn begin_at(nodes: &[Vec3], start: f64) -> Result<Vec<Vec3>, MeshError> {
    let lengths = arc_lengths(nodes)?;
    let total = lengths.last().copied().unwrap_or(0.0);
    let mut i = 0;
    let mut turned = stretch(nodes, &lengths, start, total, &mut i);
    let mut i = 0;
    turned.extend(stretch(nodes, &lengths, 0.0, start, &mut i).into_iter().skip(1));
    // The seam is computed twice, with different rounding.
    turned.pop();
    turned.extend(turned.first().copied());
    Ok(turned)
}

/// Returns the arc length from the first node to each node.
fn arc_lengths(nodes: &[Vec3]) -> Result<Vec<f64>, MeshError> {
    let mut lengths = Vec::with_capacity(nodes.len());
    let mut total = 0.0;
    let mut previous = nodes.first().copied().unwrap_or([0.0; 3]);
    for &node in nodes {
        total += distance(previous, node);
        lengths.push(total);
        previous = node;
    }
    let bound = "the polyline must have a positive finite length";
    require(
        total > 0.0 && total.is_finite(),
        "nodes",
        format_args!("{} nodes of length {total:e}", nodes.len()),
        bound,
    )?;
    Ok(lengths)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn length(nodes: &[Vec3]) -> f64 {
        nodes.windows(2).map(|w| distance(w[0], w[1])).sum()
    }

    #[test]
    fn pieces_have_the_requested_lengths_and_gaps() {
        for n in [7, 100, 361] {
            let nodes = torus_knot(2, 3, 2.0, 0.7, n).unwrap();
            let total = length(&nodes);
            let pieces = break_polyline(&nodes, 0.10, 0.05).unwrap();
            assert_eq!(pieces.len(), 7);
            for (k, piece) in pieces.iter().enumerate() {
                let wanted = if k < 6 { 0.10 } else { 0.05 };
                assert!((length(piece) / total - wanted).abs() < 1e-12, "n {n}, piece {k}");
            }
            assert_eq!(pieces[0][0], nodes[0]);
        }
    }

    #[test]
    fn an_open_polyline_keeps_its_end() {
        let nodes: Vec<Vec3> = (0..=10).map(|i| [f64::from(i), 0.0, 0.0]).collect();
        let pieces = break_polyline(&nodes, 0.25, 0.125).unwrap();
        let ends: Vec<(f64, f64)> = pieces.iter().map(|p| (p[0][0], p[p.len() - 1][0])).collect();
        assert_eq!(ends, [(0.0, 2.5), (3.75, 6.25), (7.5, 10.0)]);
        assert_eq!(pieces[0].len(), 4);
        let halves = break_polyline(&nodes, 0.5, 0.5).unwrap();
        assert_eq!(halves.len(), 1);
    }

    #[test]
    fn random_pieces_depend_on_the_seed_and_lie_on_the_curve() {
        let nodes = circle(1.0, 500).unwrap();
        let one = break_polyline_at_random(&nodes, 0.10, 0.05, 1).unwrap();
        assert_ne!(one, break_polyline_at_random(&nodes, 0.10, 0.05, 2).unwrap());
        let kept: f64 = one.iter().map(|p| length(p)).sum::<f64>() / length(&nodes);
        assert!((0.4..0.9).contains(&kept), "{kept}");
        for p in one.iter().flatten() {
            assert!((p[0].hypot(p[1]) - 1.0).abs() < 1e-4);
        }
        // No piece touches the next.
        for (a, b) in one.iter().zip(one.iter().cycle().skip(1)) {
            assert!(distance(a[a.len() - 1], b[0]) > 0.024 * TAU * 0.9);
        }
    }

    #[test]
    fn polylines_without_length_are_errors() {
        for nodes in [vec![], vec![[0.0; 3]], vec![[1.0; 3]; 4], vec![[0.0; 3], [f64::NAN, 0.0, 0.0]]] {
            assert!(break_polyline(&nodes, 0.1, 0.1).is_err());
            assert!(break_polyline_at_random(&nodes, 0.1, 0.1, 0).is_err());
        }
        assert!(break_polyline(&circle(1.0, 9).unwrap(), 0.0, 0.1).is_err());
    }
}
