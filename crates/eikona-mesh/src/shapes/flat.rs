//! Flat shapes in the plane z = 0, with all normals along +z.

use super::lattice::{Diagonal, Lattice, Ring, Seam, fan, zip_rings};
use super::parameter::{limit_faces, require, require_length, require_ring, require_some};
use super::vector::Vec3;
use crate::error::MeshError;
use crate::mesh::TriangleMesh;
use std::f64::consts::TAU;

/// The rectangle [0, `width`] x [0, `height`], subdivided into `nx` x `ny` quads of two triangles
/// each.
///
/// V = (nx + 1)(ny + 1), E = 3 nx ny + nx + ny, F = 2 nx ny. Vertices are numbered along y first.
///
/// # Errors
/// [`MeshError::Parameter`] if a count is 0, a length is not positive, or there are too many faces.
///
/// ```
/// use eikona_mesh::shapes::{Diagonal, grid};
/// let plate = grid(4, 3, 2.0, 1.0, Diagonal::Alternating)?;
/// assert_eq!((plate.vertex_count(), plate.edge_count(), plate.face_count()), (20, 43, 24));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn grid(
    nx: usize,
    ny: usize,
    width: f64,
    height: f64,
    diagonal: Diagonal,
) -> Result<TriangleMesh, MeshError> {
    require_some("nx", nx)?;
    require_some("ny", ny)?;
    require_length("width", width)?;
    require_length("height", height)?;
    limit_faces("nx", nx, 2.0 * nx as f64 * ny as f64)?;
    let lattice = Lattice { columns: nx, rows: ny, seam: Seam::Open, rows_closed: false };
    lattice.mesh(diagonal, |i, j| [width * i as f64 / nx as f64, height * j as f64 / ny as f64, 0.0])
}

/// A parallel strip of equilateral triangles with edges of length 1: `columns` x `rows` pairs of
/// triangles, odd rows of vertices shifted by 1/2.
///
/// V = (c + 1)(r + 1), E = 3 c r + c + r, F = 2 c r; all angles are 60°. It fills [0, c + 1/2] x
/// [0, r sqrt(3)/2] except for its serrated ends.
///
/// # Errors
/// [`MeshError::Parameter`] if a count is 0 or there are too many faces.
///
/// ```
/// let strip = eikona_mesh::shapes::strip(5, 2)?;
/// assert_eq!((strip.vertex_count(), strip.edge_count(), strip.face_count()), (18, 37, 20));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn strip(columns: usize, rows: usize) -> Result<TriangleMesh, MeshError> {
    require_some("columns", columns)?;
    require_some("rows", rows)?;
    limit_faces("columns", columns, 2.0 * columns as f64 * rows as f64)?;
    let lattice = Lattice { columns, rows, seam: Seam::Open, rows_closed: false };
    let row_height = 3f64.sqrt() / 2.0;
    lattice.mesh(Diagonal::Shorter, |i, j| {
        [i as f64 + if j % 2 == 1 { 0.5 } else { 0.0 }, row_height * j as f64, 0.0]
    })
}

/// The disk of this radius about the origin: ring k of `rings` has k · `sectors` evenly spaced
/// vertices, with one vertex at the centre.
///
/// V = 1 + s n (n + 1) / 2, E = s n (3 n + 1) / 2, F = s n² for n rings and s sectors. Six sectors
/// give the best triangles (no angle below 42°). Vertex 0 is the centre; the last n s vertices form
/// the rim, from angle 0.
///
/// # Errors
/// [`MeshError::Parameter`] for fewer than 3 sectors, no ring, a radius that is not positive, or
/// too many faces.
///
/// ```
/// let disk = eikona_mesh::shapes::disk(10, 6, 1.0)?;
/// assert_eq!((disk.vertex_count(), disk.edge_count(), disk.face_count()), (331, 930, 600));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn disk(rings: usize, sectors: usize, radius: f64) -> Result<TriangleMesh, MeshError> {
    require_some("rings", rings)?;
    require_ring("sectors", sectors)?;
    require_length("radius", radius)?;
    limit_faces("rings", rings, sectors as f64 * (rings as f64).powi(2))?;
    let (positions, faces) = concentric_rings(rings, sectors, |k, angle| {
        let r = radius * k as f64 / rings as f64;
        [r * angle.cos(), r * angle.sin(), 0.0]
    });
    TriangleMesh::new(positions, faces)
}

/// Returns the vertices and faces of a disk whose ring k has k · `sectors` vertices, each placed by
/// ring and angle.
pub(super) fn concentric_rings(
    rings: usize,
    sectors: usize,
    at: impl Fn(usize, f64) -> Vec3,
) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let ring = |k: usize| Ring { start: 1 + sectors * k * (k - 1) / 2, count: sectors * k };
    let mut positions = vec![at(0, 0.0)];
    let mut faces = Vec::with_capacity(sectors * rings * rings);
    for k in 1..=rings {
        let count = ring(k).count;
        positions.extend((0..count).map(|i| at(k, TAU * i as f64 / count as f64)));
        if k == 1 {
            fan(&mut faces, 0, ring(1));
        } else {
            zip_rings(&mut faces, ring(k - 1), ring(k));
        }
    }
    (positions, faces)
}

/// The annulus between two circles about the origin, in `rings` bands of 2 · `sectors` triangles.
///
/// V = s (n + 1), E = s (3 n + 1), F = 2 s n for n rings and s sectors. The radii grow
/// geometrically, so that the triangles of all bands are similar: nearly right-angled and isosceles
/// if `rings` is about `sectors` ln(`outer` / `inner`) / 2π.
///
/// # Errors
/// [`MeshError::Parameter`] unless `inner` / `outer` lies between 1e-6 and 0.999999; also for fewer
/// than 3 sectors, no ring, or too many faces.
///
/// ```
/// let ring = eikona_mesh::shapes::annulus(0.5, 1.0, 4, 32)?;
/// assert_eq!((ring.vertex_count(), ring.edge_count(), ring.face_count()), (160, 416, 256));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn annulus(inner: f64, outer: f64, rings: usize, sectors: usize) -> Result<TriangleMesh, MeshError> {
    require_length("inner", inner)?;
    require_length("outer", outer)?;
    let bound = "the inner radius must be between 1e-6 and 0.999999 of the outer one";
    require((1e-6..=0.999_999).contains(&(inner / outer)), "inner", inner, bound)?;
    require_some("rings", rings)?;
    require_ring("sectors", sectors)?;
    limit_faces("sectors", sectors, 2.0 * rings as f64 * sectors as f64)?;
    // Columns run clockwise and rows outward, so that the normal is +z.
    let lattice = Lattice { columns: sectors, rows: rings, seam: Seam::Closed, rows_closed: false };
    lattice.mesh(Diagonal::Uniform, |i, j| {
        let (s, c) = (-TAU * i as f64 / sectors as f64).sin_cos();
        let r = if j == rings { outer } else { inner * (outer / inner).powf(j as f64 / rings as f64) };
        [r * c, r * s, 0.0]
    })
}
