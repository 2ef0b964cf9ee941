//! Nonorientable surfaces. Neighbouring faces are consistently oriented except across one seam.

use super::flat::concentric_rings;
use super::lattice::{Diagonal, Lattice, Seam};
use super::parameter::{limit_faces, require, require_length, require_ring, require_some};
use super::vector::{Vec3, dot, scale};
use crate::error::MeshError;
use crate::mesh::TriangleMesh;
use std::f64::consts::{FRAC_PI_4, TAU};

/// A Moebius band about the z axis: a segment of length `width` that makes half a turn while its
/// midpoint travels around the circle of this radius.
///
/// V = nu (nv + 1), E = nu (3 nv + 1), F = 2 nu nv, χ = 0, one boundary loop. Vertex i (nv + 1) + j
/// is at u = 2π i / nu around the axis and w = (j / nv - 1/2) `width` along the segment, at ((R + w
/// cos(u/2)) cos u, (R + w cos(u/2)) sin u, w sin(u/2)).
///
/// # Errors
/// [`MeshError::Parameter`] unless 1e-6 R <= `width` < 2 R, nu >= 3 and nv >= 1; also for too many
/// faces.
///
/// ```
/// let band = eikona_mesh::shapes::moebius_band(1.0, 0.6, 40, 4)?;
/// assert_eq!((band.vertex_count(), band.edge_count(), band.face_count()), (200, 520, 320));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn moebius_band(radius: f64, width: f64, nu: usize, nv: usize) -> Result<TriangleMesh, MeshError> {
    require_length("radius", radius)?;
    require_length("width", width)?;
    let fits = width < 2.0 * radius && width >= 1e-6 * radius;
    require(fits, "width", width, "it must be less than twice the radius and at least a millionth of it")?;
    require_ring("nu", nu)?;
    require_some("nv", nv)?;
    limit_faces("nu", nu, 2.0 * nu as f64 * nv as f64)?;
    let lattice = Lattice { columns: nu, rows: nv, seam: Seam::Mirrored, rows_closed: false };
    lattice.mesh(Diagonal::Shorter, |i, j| {
        let u = TAU * i as f64 / nu as f64;
        let w = width * (j as f64 / nv as f64 - 0.5);
        let from_axis = radius + w * (0.5 * u).cos();
        [from_axis * u.cos(), from_axis * u.sin(), w * (0.5 * u).sin()]
    })
}

/// A Klein bottle as the immersion of a figure eight that makes half a turn while it travels around
/// the circle of this radius.
///
/// V = nu nv, E = 3 nu nv, F = 2 nu nv, χ = 0, no boundary. It crosses itself along a circle that
/// contains no vertex.
///
/// # Errors
/// [`MeshError::Parameter`] unless `radius` lies in [1.5, 1e6] (the figure eight has width 2) and
/// both counts are at least 3; also for too many faces.
///
/// ```
/// let bottle = eikona_mesh::shapes::klein_bottle(2.5, 60, 30)?;
/// assert_eq!((bottle.vertex_count(), bottle.edge_count()), (1800, 5400));
/// assert_eq!(bottle.face_count(), 3600);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn klein_bottle(radius: f64, nu: usize, nv: usize) -> Result<TriangleMesh, MeshError> {
    require((1.5..=1e6).contains(&radius), "radius", radius, "it must lie between 1.5 and 1e6")?;
    require_ring("nu", nu)?;
    require_ring("nv", nv)?;
    limit_faces("nu", nu, 2.0 * nu as f64 * nv as f64)?;
    let lattice = Lattice { columns: nu, rows: nv, seam: Seam::Mirrored, rows_closed: true };
    lattice.mesh(Diagonal::Shorter, |i, j| {
        let u = TAU * i as f64 / nu as f64;
        // Half a step away from the crossing at v = 0 and v = π; symmetric under v -> -v, as the
        // seam requires.
        let v = TAU * (j as f64 + 0.5) / nv as f64;
        let (sin, cos) = (0.5 * u).sin_cos();
        let from_axis = radius + cos * v.sin() - sin * (2.0 * v).sin();
        [from_axis * u.cos(), from_axis * u.sin(), sin * v.sin() + cos * (2.0 * v).sin()]
    })
}

/// The projective plane as Boy's surface: an immersed sphere with opposite points identified, in
/// the parametrisation of Bryant and Kusner.
///
/// V = 3 n² + 1, E = 9 n², F = 6 n² for n rings, χ = 1, no boundary. A hemisphere is subdivided
/// into rings of 6 k vertices, and opposite vertices of its rim are identified. The surface crosses
/// itself along a closed curve with one triple point, the origin.
///
/// # Errors
/// [`MeshError::Parameter`] for fewer than 2 rings or too many faces.
///
/// ```
/// let plane = eikona_mesh::shapes::projective_plane(10)?;
/// assert_eq!((plane.vertex_count(), plane.edge_count(), plane.face_count()), (301, 900, 600));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn projective_plane(rings: usize) -> Result<TriangleMesh, MeshError> {
    require(rings >= 2, "rings", rings, "at least 2 are needed")?;
    limit_faces("rings", rings, 6.0 * (rings as f64).powi(2))?;
    let (mut positions, mut faces) = concentric_rings(rings, 6, |k, angle| {
        // Stereographic projection of evenly spaced latitudes.
        let r = (FRAC_PI_4 * k as f64 / rings as f64).tan();
        boy_surface([r * angle.cos(), r * angle.sin()])
    });
    let kept = positions.len() - 3 * rings;
    positions.truncate(kept);
    for v in faces.iter_mut().flatten() {
        if *v as usize >= kept {
            *v -= 3 * rings as u32;
        }
    }
    TriangleMesh::new(positions, faces)
}

/// Returns the point of Boy's surface for a complex number in the unit disk, as the inversion of a
/// minimal surface: g / |g|², g = (-3/2 Im(w (1 - w⁴) / D), -3/2 Re(w (1 + w⁴) / D), Im((1 + w⁶) /
/// D) - 1/2), D = w⁶ + sqrt(5) w³ - 1.
fn boy_surface(w: [f64; 2]) -> Vec3 {
    let times = |a: [f64; 2], b: [f64; 2]| [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
    let plus = |a: [f64; 2], s: f64, b: [f64; 2]| [a[0] + s * b[0], a[1] + s * b[1]];
    const ONE: [f64; 2] = [1.0, 0.0];
    let w2 = times(w, w);
    let w3 = times(w2, w);
    let w4 = times(w2, w2);
    let w6 = times(w3, w3);
    let d = plus(plus(w6, 5f64.sqrt(), w3), -1.0, ONE);
    let d_conjugate = [d[0], -d[1]];
    // h = |D|² g is finite where D is zero and g is not.
    let d_sq = d[0] * d[0] + d[1] * d[1];
    let h = [
        -1.5 * times(times(w, plus(ONE, -1.0, w4)), d_conjugate)[1],
        -1.5 * times(times(w, plus(ONE, 1.0, w4)), d_conjugate)[0],
        times(plus(ONE, 1.0, w6), d_conjugate)[1] - 0.5 * d_sq,
    ];
    let h_sq = dot(h, h);
    if h_sq > 0.0 { scale(h, d_sq / h_sq) } else { [0.0; 3] }
}
