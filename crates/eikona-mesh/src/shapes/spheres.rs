//! Unit spheres, and a sphere with waves on it.

use super::boxes::BoxSurface;
use super::lattice::{Ring, cut_quads, fan};
use super::parameter::{limit_faces, require, require_ring, require_some};
use super::platonic::{ICOSAHEDRON_FACES, icosahedron_positions};
use super::vector::{Vec3, add, scale, unit};
use crate::error::MeshError;
use crate::mesh::TriangleMesh;
use std::f64::consts::{FRAC_PI_4, PI, TAU};

/// The unit sphere as an icosahedron whose faces are subdivided into `frequency`² triangles each.
///
/// V = 10 n² + 2, E = 30 n², F = 20 n² for frequency n: 71 gives 100,820 faces, 158 gives 499,280.
/// Points on the icosahedron's edges are evenly spaced along great circles. Outward oriented; every
/// angle lies between 53° and 72.1°.
///
/// # Errors
/// [`MeshError::Parameter`] if `frequency` is 0 or would give more than
/// [`MAX_SHAPE_FACES`](super::MAX_SHAPE_FACES) faces.
///
/// ```
/// let sphere = eikona_mesh::shapes::geodesic_sphere(71)?;
/// assert_eq!((sphere.vertex_count(), sphere.face_count()), (50_412, 100_820));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn geodesic_sphere(frequency: usize) -> Result<TriangleMesh, MeshError> {
    require_some("frequency", frequency)?;
    limit_faces("frequency", frequency, 20.0 * (frequency as f64).powi(2))?;
    let n = frequency;
    let corners = icosahedron_positions();
    let edges = icosahedron_edges();
    // Weights sin(i a / n) of the corners, for corners an angle `a` apart, space the points of an
    // edge evenly.
    let angle = 2f64.atan();
    let weight = |i: usize| (angle * i as f64 / n as f64).sin();

    let mut positions: Vec<Vec3> = corners.to_vec();
    for &[a, b] in &edges {
        for step in 1..n {
            let p = add(scale(corners[a], weight(n - step)), scale(corners[b], weight(step)));
            positions.push(unit(p));
        }
    }
    let mut faces = Vec::with_capacity(20 * n * n);
    for corner in ICOSAHEDRON_FACES {
        let interior = positions.len();
        // Row r contains the points at r steps from corner 0; point c of it is c steps from the
        // side of corners 0 and 1.
        for r in 2..n {
            for c in 1..r {
                let weights = [n - r, r - c, c].map(weight);
                let terms = [0, 1, 2].map(|k| scale(corners[corner[k]], weights[k]));
                positions.push(unit(add(add(terms[0], terms[1]), terms[2])));
            }
        }
        let on_edge = |a: usize, b: usize, steps_from_a: usize| {
            let edge = edges.iter().position(|&e| e == [a.min(b), a.max(b)]).unwrap_or(0);
            let step = if a < b { steps_from_a } else { n - steps_from_a };
            12 + edge * (n - 1) + step - 1
        };
        let sides: [Vec<usize>; 3] = [0, 1, 2].map(|k| {
            let (a, b) = (corner[k], corner[(k + 1) % 3]);
            (1..n).map(|step| on_edge(a, b, step)).collect()
        });
        let point = |r: usize, c: usize| -> u32 {
            let index = match (r, c) {
                (0, _) => corner[0],
                (r, 0) if r == n => corner[1],
                (r, c) if r == n && c == n => corner[2],
                (r, 0) => sides[0][r - 1],
                (r, c) if r == n => sides[1][c - 1],
                (r, c) if r == c => sides[2][n - r - 1],
                (r, c) => interior + (r - 1) * (r - 2) / 2 + c - 1,
            };
            index as u32
        };
        for r in 0..n {
            for c in 0..=r {
                faces.push([point(r, c), point(r + 1, c), point(r + 1, c + 1)]);
                if c < r {
                    faces.push([point(r, c), point(r + 1, c + 1), point(r, c + 1)]);
                }
            }
        }
    }
    TriangleMesh::new(positions, faces)
}

/// Returns the 30 edges of the icosahedron, smaller endpoint first, in the order in which its faces
/// meet them.
fn icosahedron_edges() -> Vec<[usize; 2]> {
    let mut edges: Vec<[usize; 2]> = Vec::with_capacity(30);
    for face in ICOSAHEDRON_FACES {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            let edge = [a.min(b), a.max(b)];
            if !edges.contains(&edge) {
                edges.push(edge);
            }
        }
    }
    edges
}

/// The unit sphere as an icosahedron refined `levels` times: each step bisects every edge and moves
/// its midpoint to the sphere.
///
/// V = 10 · 4^k + 2, E = 30 · 4^k, F = 20 · 4^k for k levels. The vertices of a level are the first
/// vertices of the next one. Outward oriented.
///
/// # Errors
/// [`MeshError::Parameter`] past level 10.
///
/// ```
/// let sphere = eikona_mesh::shapes::icosphere(3)?;
/// assert_eq!((sphere.vertex_count(), sphere.face_count()), (642, 1280));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn icosphere(levels: u32) -> Result<TriangleMesh, MeshError> {
    limit_faces("levels", levels, 20.0 * 4f64.powf(f64::from(levels)))?;
    let faces = ICOSAHEDRON_FACES.map(|f| f.map(|v| v as u32)).to_vec();
    let mut mesh = TriangleMesh::new(icosahedron_positions().to_vec(), faces)?;
    for _ in 0..levels {
        mesh = with_bisected_edges(&mesh, unit)?;
    }
    Ok(mesh)
}

/// Bisects every edge and moves its midpoint by `place`; each face becomes four. The midpoint of
/// edge e is vertex V + e.
fn with_bisected_edges(mesh: &TriangleMesh, place: fn(Vec3) -> Vec3) -> Result<TriangleMesh, MeshError> {
    let mut positions = mesh.positions().to_vec();
    let first = positions.len() as u32;
    for e in mesh.edges() {
        let [a, b] = mesh.edge_vertices(e).map(|v| mesh.position(v));
        positions.push(place(scale(add(a, b), 0.5)));
    }
    let mut faces = Vec::with_capacity(4 * mesh.face_count());
    for f in mesh.faces() {
        let [a, b, c] = mesh.face_vertices(f).map(|v| v.0);
        let [ab, bc, ca] = mesh.face_edges(f).map(|e| first + e.0);
        faces.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    TriangleMesh::new(positions, faces)
}

/// The unit sphere, subdivided by `meridians` half circles from pole to pole and `parallels`
/// circles of latitude between the poles.
///
/// V = m p + 2, E = 3 m p, F = 2 m p. Vertex 0 is the south pole (0, 0, -1), the last one the north
/// pole; between them the parallels from south to north, each from longitude 0 eastward. Outward
/// oriented. Triangles become thin at the poles.
///
/// # Errors
/// [`MeshError::Parameter`] for fewer than 3 meridians, no parallel, or too many faces.
///
/// ```
/// let sphere = eikona_mesh::shapes::uv_sphere(12, 5)?;
/// assert_eq!((sphere.vertex_count(), sphere.edge_count(), sphere.face_count()), (62, 180, 120));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn uv_sphere(meridians: usize, parallels: usize) -> Result<TriangleMesh, MeshError> {
    require_ring("meridians", meridians)?;
    require_some("parallels", parallels)?;
    limit_faces("meridians", meridians, 2.0 * meridians as f64 * parallels as f64)?;
    let mut positions = vec![[0.0, 0.0, -1.0]];
    for j in 1..=parallels {
        let (s, c) = (PI * j as f64 / (parallels + 1) as f64).sin_cos();
        for i in 0..meridians {
            let (y, x) = (TAU * i as f64 / meridians as f64).sin_cos();
            positions.push([s * x, s * y, -c]);
        }
    }
    let north = positions.len();
    positions.push([0.0, 0.0, 1.0]);
    let ring = |j: usize| Ring { start: 1 + j * meridians, count: meridians };
    let mut faces = Vec::with_capacity(2 * meridians * parallels);
    fan(&mut faces, 0, ring(0));
    for face in &mut faces {
        face.swap(1, 2); // seen from below, eastward is clockwise
    }
    for j in 1..parallels {
        let (low, high) = (ring(j - 1).start as u32, ring(j).start as u32);
        for i in 0..meridians as u32 {
            let next = (i + 1) % meridians as u32;
            faces.push([low + i, low + next, high + next]);
            faces.push([low + i, high + next, high + i]);
        }
    }
    fan(&mut faces, north, ring(parallels - 1));
    TriangleMesh::new(positions, faces)
}

/// The unit sphere as a cube with `n` x `n` quads per side, spaced by equal angles and cut along
/// their shorter diagonals.
///
/// V = 6 n² + 2, E = 18 n², F = 12 n². Outward oriented. No poles: areas differ by less than a
/// factor of 2.
///
/// # Errors
/// [`MeshError::Parameter`] if `n` is 0 or gives too many faces.
///
/// ```
/// let sphere = eikona_mesh::shapes::cube_sphere(10)?;
/// assert_eq!((sphere.vertex_count(), sphere.edge_count()), (602, 1800));
/// assert_eq!(sphere.face_count(), 1200);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn cube_sphere(n: usize) -> Result<TriangleMesh, MeshError> {
    require_some("n", n)?;
    limit_faces("n", n, 12.0 * (n as f64).powi(2))?;
    let surface = BoxSurface { cells: [n; 3] };
    let equal_angle = |i: usize| (FRAC_PI_4 * (2.0 * i as f64 / n as f64 - 1.0)).tan();
    let positions = surface.positions(|lattice| unit(lattice.map(equal_angle)));
    let faces = cut_quads(&positions, &surface.quads());
    TriangleMesh::new(positions, faces)
}

/// A sphere with smooth waves: radius 1 + `amplitude` (sin(w x) + sin(w y) + sin(w z)) / 3 in
/// direction (x, y, z), w = `waves`.
///
/// Counts and orientation are those of [`geodesic_sphere`]; star-shaped, so free of
/// self-intersections.
///
/// # Errors
/// [`MeshError::Parameter`] if `amplitude` is not in [0, 0.9], `waves` not in [0, 1000], or the
/// frequency is out of range.
///
/// ```
/// let bumpy = eikona_mesh::shapes::bumpy_sphere(10, 0.3, 6.0)?;
/// assert_eq!((bumpy.vertex_count(), bumpy.face_count()), (1002, 2000));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn bumpy_sphere(frequency: usize, amplitude: f64, waves: f64) -> Result<TriangleMesh, MeshError> {
    require((0.0..=0.9).contains(&amplitude), "amplitude", amplitude, "it must lie between 0 and 0.9")?;
    require((0.0..=1000.0).contains(&waves), "waves", waves, "it must lie between 0 and 1000")?;
    let sphere = geodesic_sphere(frequency)?;
    let wave = |p: Vec3| p.iter().map(|x| (waves * x).sin()).sum::<f64>() / 3.0;
    let positions = sphere.positions().iter().map(|&p| scale(p, 1.0 + amplitude * wave(p))).collect();
    sphere.with_positions(positions)
}
