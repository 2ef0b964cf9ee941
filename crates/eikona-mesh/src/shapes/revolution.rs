//! Surfaces of revolution about the z axis: torus, cylinder, cone.

use super::flat::concentric_rings;
use super::lattice::{Diagonal, Lattice, Ring, Seam, fan, zip_rings};
use super::parameter::{limit_faces, require, require_length, require_ring, require_some};
use crate::error::MeshError;
use crate::mesh::TriangleMesh;
use crate::vector::Vec3;
use std::f64::consts::TAU;

/// The torus about the z axis whose tube of radius `minor` follows the circle of radius `major`.
///
/// V = nu nv, E = 3 nu nv, F = 2 nu nv. Vertex i nv + j is at angle u = 2π i / nu around the axis
/// and v = 2π j / nv around the tube, at ((R + r cos v) cos u, (R + r cos v) sin u, r sin v).
/// Outward oriented. Area 4π² R r, volume 2π² R r².
///
/// # Errors
/// [`MeshError::Parameter`] unless 1e-6 `major` <= `minor` < `major` and both counts are at least
/// 3; also for too many faces.
///
/// ```
/// let torus = eikona_mesh::shapes::torus(1.0, 0.4, 48, 24)?;
/// assert_eq!((torus.vertex_count(), torus.edge_count(), torus.face_count()), (1152, 3456, 2304));
/// assert_eq!(torus.positions()[0], [1.4, 0.0, 0.0]);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn torus(major: f64, minor: f64, nu: usize, nv: usize) -> Result<TriangleMesh, MeshError> {
    check_torus(major, minor, nu, nv, 1)?;
    torus_lattice(nu, nv).mesh(Diagonal::Uniform, |i, j| torus_point(major, minor, nu, nv, i, j))
}

/// The torus about the z axis without a square patch of its outer side, which faces +x and is about
/// `hole` wide: a surface of genus 1 with one boundary loop, outward oriented.
///
/// Vertices are those of [`torus`] that are left, in its order. With a patch of m x n cells,
/// F = 2 nu nv - 2 m n and χ = -1. The signed volume is that of the cone from the origin, which
/// closes the hole.
///
/// # Errors
/// [`MeshError::Parameter`] as for [`torus`], and unless the patch is at least one cell and leaves
/// two cells, or more, in either direction.
///
/// ```
/// let torus = eikona_mesh::shapes::punctured_torus(1.0, 0.4, 0.5, 48, 24)?;
/// let [v, e, f] = [torus.vertex_count(), torus.edge_count(), torus.face_count()];
/// assert_eq!(v as i64 - e as i64 + f as i64, -1);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn punctured_torus(
    major: f64,
    minor: f64,
    hole: f64,
    nu: usize,
    nv: usize,
) -> Result<TriangleMesh, MeshError> {
    check_torus(major, minor, nu, nv, 1)?;
    require_length("hole", hole)?;
    let cells = |radius: f64, count: usize| (hole / (TAU * radius) * count as f64).round();
    let [across, around] = [cells(major + minor, nu), cells(minor, nv)];
    let fits = across >= 1.0 && around >= 1.0 && across + 2.0 <= nu as f64 && around + 2.0 <= nv as f64;
    require(fits, "hole", hole, "it must be at least a cell wide, and leave two cells around the tube")?;
    let [across, around] = [across as usize, around as usize];
    let whole = torus(major, minor, nu, nv)?;
    // The patch is centred at column 0 and row 0; places are counted from its first cell.
    let within = |place: usize, count: usize, size: usize| (place + size / 2) % count;
    let in_patch = |i: usize, j: usize| within(i, nu, across) < across && within(j, nv, around) < around;
    // Two triangles per cell, column by column.
    let faces = whole.triangles().chunks(2).enumerate();
    let left = faces.filter(|(cell, _)| !in_patch(cell / nv, cell % nv)).flat_map(|(_, faces)| faces);
    let mut faces: Vec<[u32; 3]> = left.copied().collect();
    let mut number = vec![u32::MAX; whole.vertex_count()];
    faces.iter().flatten().for_each(|&v| number[v as usize] = 0);
    let mut positions = Vec::new();
    for (number, position) in number.iter_mut().zip(whole.positions()).filter(|(n, _)| **n == 0) {
        *number = positions.len() as u32;
        positions.push(*position);
    }
    faces.iter_mut().flatten().for_each(|v| *v = number[*v as usize]);
    TriangleMesh::new(positions, faces)
}

pub(super) fn check_torus(
    major: f64,
    minor: f64,
    nu: usize,
    nv: usize,
    copies: usize,
) -> Result<(), MeshError> {
    require_length("major", major)?;
    require_length("minor", minor)?;
    let fits = minor < major && minor >= 1e-6 * major;
    require(fits, "minor", minor, "it must be below the major radius and at least a millionth of it")?;
    require_ring("nu", nu)?;
    require_ring("nv", nv)?;
    limit_faces("nu", nu, 2.0 * nu as f64 * nv as f64 * copies as f64)
}

pub(super) fn torus_lattice(nu: usize, nv: usize) -> Lattice {
    Lattice { columns: nu, rows: nv, seam: Seam::Closed, rows_closed: true }
}

pub(super) fn torus_point(major: f64, minor: f64, nu: usize, nv: usize, i: usize, j: usize) -> Vec3 {
    let (sin_u, cos_u) = (TAU * i as f64 / nu as f64).sin_cos();
    let (sin_v, cos_v) = (TAU * j as f64 / nv as f64).sin_cos();
    let from_axis = major + minor * cos_v;
    [from_axis * cos_u, from_axis * sin_u, minor * sin_v]
}

/// Whether a cylinder has flat caps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Ends {
    /// Without caps: the surface has two boundary loops.
    #[default]
    Open,
    /// With caps: the surface is closed.
    Capped,
}

/// The cylinder about the z axis from z = 0 to z = `height`, with `sectors` vertices around the
/// axis and `stacks` bands.
///
/// Open: V = s (n + 1), E = s (3 n + 1), F = 2 s n for s sectors and n stacks; vertex i (n + 1) + j
/// is at angle 2π i / s and height j / n. Capped: each cap has rings with fewer vertices towards
/// the middle, and χ = 2. Outward oriented.
///
/// # Errors
/// [`MeshError::Parameter`] for fewer than 3 sectors, no stack, a length that is not positive, or
/// too many faces.
///
/// ```
/// use eikona_mesh::shapes::{Ends, cylinder};
/// let tube = cylinder(0.5, 2.0, 16, 8, Ends::Open)?;
/// assert_eq!((tube.vertex_count(), tube.edge_count(), tube.face_count()), (144, 400, 256));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn cylinder(
    radius: f64,
    height: f64,
    sectors: usize,
    stacks: usize,
    ends: Ends,
) -> Result<TriangleMesh, MeshError> {
    require_length("radius", radius)?;
    require_length("height", height)?;
    require_ring("sectors", sectors)?;
    require_some("stacks", stacks)?;
    let s = sectors as f64;
    let cap_faces = if ends == Ends::Capped { s * s / 3.0 } else { 0.0 };
    limit_faces("sectors", sectors, 2.0 * s * stacks as f64 + cap_faces)?;

    let lattice = Lattice { columns: sectors, rows: stacks, seam: Seam::Closed, rows_closed: false };
    let mut positions = lattice.positions(|i, j| {
        let (s, c) = (TAU * i as f64 / sectors as f64).sin_cos();
        [radius * c, radius * s, height * j as f64 / stacks as f64]
    });
    let mut faces = lattice.triangles(&positions, Diagonal::Uniform);
    if ends == Ends::Capped {
        for (row, z, upward) in [(0, 0.0, false), (stacks, height, true)] {
            let (points, triangles) =
                cap(sectors, |r, angle| [radius * r * angle.cos(), radius * r * angle.sin(), z]);
            // The cap's last vertices are its rim, shared with the end ring of the side.
            let own = points.len() - sectors;
            let first = positions.len();
            let number = |v: u32| match (v as usize).checked_sub(own) {
                Some(i) => (i * (stacks + 1) + row) as u32,
                None => (first + v as usize) as u32,
            };
            faces.extend(triangles.into_iter().map(|t| {
                let [a, b, c] = t.map(number);
                if upward { [a, b, c] } else { [a, c, b] }
            }));
            positions.extend_from_slice(&points[..own]);
        }
    }
    TriangleMesh::new(positions, faces)
}

/// Returns a disk with triangles of about the same size and `sectors` vertices on its rim, which
/// come last; placed by radius (1 = rim) and angle.
fn cap(sectors: usize, at: impl Fn(f64, f64) -> Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let rings = (sectors as f64 / TAU).round().max(1.0) as usize;
    let mut positions = vec![at(0.0, 0.0)];
    let mut faces = Vec::new();
    let mut inner: Option<Ring> = None;
    for k in 1..=rings {
        let ring = Ring { start: positions.len(), count: (sectors * k).div_ceil(rings).max(3) };
        let r = k as f64 / rings as f64;
        positions.extend((0..ring.count).map(|i| at(r, TAU * i as f64 / ring.count as f64)));
        match inner {
            None => fan(&mut faces, 0, ring),
            Some(inner) => zip_rings(&mut faces, inner, ring),
        }
        inner = Some(ring);
    }
    (positions, faces)
}

/// The lateral surface of the cone with its rim of this radius in the plane z = 0 and its apex,
/// vertex 0, at z = `height`.
///
/// Counts are those of [`disk`](super::disk). Open at the base; normals point outward and up. The
/// half-angle at the apex is a = atan(radius / height), and the angles of the faces around the apex
/// sum to 2π sin a in the limit: the cone unrolls to a sector of a disk, on which distances are
/// known.
///
/// # Errors
/// [`MeshError::Parameter`] for fewer than 3 sectors, no ring, a length that is not positive, or
/// too many faces.
///
/// ```
/// let cone = eikona_mesh::shapes::cone(1.0, 2.0, 10, 6)?;
/// assert_eq!((cone.vertex_count(), cone.face_count()), (331, 600));
/// assert_eq!(cone.positions()[0], [0.0, 0.0, 2.0]);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn cone(radius: f64, height: f64, rings: usize, sectors: usize) -> Result<TriangleMesh, MeshError> {
    require_length("radius", radius)?;
    require_length("height", height)?;
    require_some("rings", rings)?;
    require_ring("sectors", sectors)?;
    limit_faces("rings", rings, sectors as f64 * (rings as f64).powi(2))?;
    let (positions, faces) = concentric_rings(rings, sectors, |k, angle| {
        let share = k as f64 / rings as f64;
        let r = radius * share;
        [r * angle.cos(), r * angle.sin(), height * (1.0 - share)]
    });
    TriangleMesh::new(positions, faces)
}
