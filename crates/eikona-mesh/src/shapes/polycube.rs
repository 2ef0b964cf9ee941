//! Smooth surfaces from blocks: the surface of a set of boxes, smoothed by Catmull-Clark
//! subdivision.
//!
//! Reference: E. Catmull and J. Clark, "Recursively generated B-spline surfaces on arbitrary
//! topological meshes", CAD 10 (1978).

use super::lattice::cut_quads;
use super::parameter::{limit_faces, require_some};
use crate::error::MeshError;
use crate::mesh::TriangleMesh;
use crate::vector::{Vec3, add, scale};
use std::collections::{BTreeMap, BTreeSet};

/// A smooth closed surface of genus `genus`: a row of rings, fused together.
///
/// Blocks around g openings in a row are smoothed `levels` times (at least once). For k levels and
/// q = (26 g + 14) 4^k: V = q + 2 - 2 g, E = 3 q, F = 2 q, χ = 2 - 2 g. Outward oriented. The row
/// lies along x, centred at the origin, with one ring every 2.6 units.
///
/// # Errors
/// [`MeshError::Parameter`] if `genus` or `levels` is 0 or there are too many faces.
///
/// ```
/// let double = eikona_mesh::shapes::chain_of_genus(2, 2)?;
/// assert_eq!((double.vertex_count(), double.face_count()), (1054, 2112));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn chain_of_genus(genus: usize, levels: u32) -> Result<TriangleMesh, MeshError> {
    require_some("genus", genus)?;
    require_some("levels", levels as usize)?;
    limit_faces("genus", genus, 2.0 * (26.0 * genus as f64 + 14.0) * 4f64.powf(f64::from(levels)))?;
    // A bar one unit wide, an opening of two columns, a bar, and so on. Plane i along x has a bar
    // to its right if i % 3 = 0, to its left if i % 3 = 1, and otherwise lies in the middle of an
    // opening, where the ring is widest.
    let length = 3 * genus + 1;
    let is_solid = |[i, j, _]: [usize; 3]| j != 1 || i % 3 == 0;
    let row_length = 1.0 + 2.6 * genus as f64;
    let place = |[i, j, k]: [usize; 3]| {
        let x = 2.6 * (i / 3) as f64 + [0.0, 1.0, 1.8][i % 3] - 0.5 * row_length;
        let (opening, outer) = match i {
            _ if i % 3 == 2 => (0.75, 1.65),
            _ if i == 0 || i == length => (0.4, 0.8),
            _ => (0.5, 1.05),
        };
        [x, [-outer, -opening, opening, outer][j], k as f64 - 0.5]
    };
    smooth(block_surface([length, 3, 1], is_solid, place), levels)
}

/// A clay animal on four legs: a closed surface with a long neck, ears and a tail, for pictures and
/// tests on a shape with features.
///
/// Boxes smoothed `levels` times (at least once). With q = 110 · 4^k for k levels, V = q + 2, E = 3
/// q, F = 2 q and χ = 2. It stands on the plane y = 0, faces +z, is about 3.4 long, 1.1 wide and
/// 3.4 high, and is symmetric under x -> -x. Outward oriented.
///
/// # Errors
/// [`MeshError::Parameter`] if `levels` is 0 or gives too many faces.
///
/// ```
/// let animal = eikona_mesh::shapes::clay_animal(3)?;
/// let [v, e, f] = [animal.vertex_count(), animal.edge_count(), animal.face_count()];
/// let chi = v as i64 - e as i64 + f as i64;
/// assert_eq!(chi, 2);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn clay_animal(levels: u32) -> Result<TriangleMesh, MeshError> {
    require_some("levels", levels as usize)?;
    limit_faces("levels", levels, 2.0 * 110.0 * 4f64.powf(f64::from(levels)))?;
    // The positions of the planes between the blocks.
    const X: [f64; 8] = [-0.5, 0.0, 0.55, 1.45, 2.0, 2.45, 3.0, 3.5];
    const Y: [f64; 6] = [-0.6, -0.5, -0.17, 0.17, 0.5, 0.6];
    const Z: [f64; 9] = [0.0, 0.55, 1.1, 1.75, 2.15, 2.6, 3.1, 3.5, 4.0];
    let is_solid = |[i, j, k]: [usize; 3]| {
        let middle = j == 2;
        let within_body = (1..=3).contains(&j);
        match k {
            0 | 1 => (i == 1 || i == 3) && (j == 1 || j == 3),
            2 => ((1..=3).contains(&i) && within_body) || (i == 0 && middle),
            3 | 4 => i == 3 && middle,
            5 => (i == 3 || i == 4 || i == 5) && within_body,
            6 => i == 3 && (j == 1 || j == 3),
            _ => false,
        }
    };
    let place = |[i, j, k]: [usize; 3]| {
        let [mut x, mut y, mut z] = [X[i], Y[j], Z[k]];
        match (i, k) {
            (0, _) => z += 0.45,                       // the tail points up
            (_, 0) => y *= 1.15,                       // the legs stand apart
            (_, 3) => y *= 0.8,                        // the back is round
            (5.., _) => (y, z) = (0.75 * y, z - 0.1),  // the snout is narrow
            (_, 7..) => (x, y) = (x - 0.25, 1.25 * y), // the ears point back and out
            _ => {}
        }
        // Files of figures mostly have y up.
        [y, z, x]
    };
    smooth(block_surface([7, 5, 8], is_solid, place), levels)
}

/// Two rings, each through the hole of the other, joined by a bar: a closed surface of genus 2 that
/// looks tied, and is not. (Slide one end of the bar around its ring.)
///
/// Boxes smoothed `levels` times (at least once). With q = 226 · 4^k for k levels, V = q - 2, E = 3
/// q, F = 2 q and χ = -2. Outward oriented. The tubes are about 1 wide, and 2 apart.
///
/// # Errors
/// [`MeshError::Parameter`] if `levels` is 0 or gives too many faces.
///
/// ```
/// let handcuffs = eikona_mesh::shapes::handcuffs(2)?;
/// let [v, e, f] = [handcuffs.vertex_count(), handcuffs.edge_count(), handcuffs.face_count()];
/// assert_eq!(v as i64 - e as i64 + f as i64, -2);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn handcuffs(levels: u32) -> Result<TriangleMesh, MeshError> {
    require_some("levels", levels as usize)?;
    limit_faces("levels", levels, 2.0 * 226.0 * 4f64.powf(f64::from(levels)))?;
    let is_solid = |[i, j, k]: [usize; 3]| {
        let first = k == 3 && i <= 6 && j <= 6 && (i % 6 == 0 || j % 6 == 0);
        let second = j == 3 && (3..=9).contains(&i) && (i == 3 || i == 9 || k % 6 == 0);
        // From a corner of the first ring to the far side of the second one.
        let bar = k == 3
            && ((j == 8 && (6..=9).contains(&i)) || (i == 6 && j == 7) || (i == 9 && (4..=7).contains(&j)));
        first || second || bar
    };
    let place = |[i, j, k]: [usize; 3]| [i as f64 - 5.0, j as f64 - 3.5, k as f64 - 3.5];
    smooth(block_surface([10, 9, 7], is_solid, place), levels)
}

/// Two rings, one above the other, joined by a bar: a closed surface of genus 2. A pole along the z
/// axis passes through both. (It can be moved so that the pole passes through one of them only.)
///
/// Boxes smoothed `levels` times (at least once). With q = 134 · 4^k for k levels, V = q - 2, E = 3
/// q, F = 2 q and χ = -2. Outward oriented. The rings are about 5 wide, their holes 3, and they are
/// 2 apart.
///
/// # Errors
/// [`MeshError::Parameter`] if `levels` is 0 or gives too many faces.
///
/// ```
/// let rings = eikona_mesh::shapes::joined_rings(2)?;
/// let [v, e, f] = [rings.vertex_count(), rings.edge_count(), rings.face_count()];
/// assert_eq!(v as i64 - e as i64 + f as i64, -2);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn joined_rings(levels: u32) -> Result<TriangleMesh, MeshError> {
    require_some("levels", levels as usize)?;
    limit_faces("levels", levels, 2.0 * 134.0 * 4f64.powf(f64::from(levels)))?;
    let is_solid = |[i, j, k]: [usize; 3]| match k {
        0 | 3 => i % 4 == 0 || j % 4 == 0,
        _ => [i, j] == [0, 2],
    };
    let place = |[i, j, k]: [usize; 3]| [i as f64 - 2.5, j as f64 - 2.5, k as f64 - 2.0];
    smooth(block_surface([5, 5, 4], is_solid, place), levels)
}

/// The Borromean rings: three tori, no two of which are linked, but which cannot be taken apart.
///
/// Boxes smoothed `levels` times (at least once). With q = 336 · 4^k for k levels, V = q, E = 3 q,
/// F = 2 q and χ = 0, in three components. Outward oriented. The rings are 11 long and 5 wide, in
/// the three coordinate planes; their tubes are about 1 wide, and 1 apart.
///
/// # Errors
/// [`MeshError::Parameter`] if `levels` is 0 or gives too many faces.
///
/// ```
/// let rings = eikona_mesh::shapes::borromean_rings(1)?;
/// assert_eq!((rings.vertex_count(), rings.face_count()), (1344, 2688));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn borromean_rings(levels: u32) -> Result<TriangleMesh, MeshError> {
    require_some("levels", levels as usize)?;
    limit_faces("levels", levels, 2.0 * 336.0 * 4f64.powf(f64::from(levels)))?;
    // In the plane where a coordinate is zero, the next one is the long side.
    let is_solid = |block: [usize; 3]| {
        (0..3).any(|axis| {
            let [across, long, short] = [0, 1, 2].map(|k| block[(axis + k) % 3].abs_diff(5));
            across == 0 && short <= 2 && (long == 5 || short == 2)
        })
    };
    let place = |p: [usize; 3]| p.map(|x| x as f64 - 5.5);
    smooth(block_surface([11; 3], is_solid, place), levels)
}

/// Which knot a tunnel follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TunnelKnot {
    /// The trefoil.
    #[default]
    Trefoil,
    /// The figure-eight knot.
    FigureEight,
}

impl TunnelKnot {
    /// The rows that each column of a grid diagram joins: columns pass over rows.
    fn columns(self) -> &'static [[usize; 2]] {
        match self {
            TunnelKnot::Trefoil => &[[4, 1], [0, 2], [1, 3], [2, 4], [3, 0]],
            TunnelKnot::FigureEight => &[[2, 4], [5, 3], [4, 1], [0, 2], [1, 5], [3, 0]],
        }
    }
}

/// A block with a knotted tunnel: a closed surface of genus 1. Both ends of the tunnel are at the
/// side of least x; closed outside of the block, it is the knot.
///
/// Boxes smoothed `levels` times (at least once). With q = 704 · 4^k for the trefoil and q = 928 ·
/// 4^k for the figure-eight knot and k levels, V = q, E = 3 q, F = 2 q and χ = 0. Outward oriented.
/// The tunnel is about 1 wide, and its strands 1 apart; the block is 11 x 11 x 5 or 13 x 13 x 5.
///
/// # Errors
/// [`MeshError::Parameter`] if `levels` is 0 or gives too many faces.
///
/// ```
/// use eikona_mesh::shapes::{TunnelKnot, knotted_tunnel};
/// let block = knotted_tunnel(TunnelKnot::Trefoil, 1)?;
/// let [v, e, f] = [block.vertex_count(), block.edge_count(), block.face_count()];
/// assert_eq!(v as i64 - e as i64 + f as i64, 0);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn knotted_tunnel(knot: TunnelKnot, levels: u32) -> Result<TriangleMesh, MeshError> {
    require_some("levels", levels as usize)?;
    limit_faces("levels", levels, 2.0 * 1000.0 * 4f64.powf(f64::from(levels)))?;
    let columns = knot.columns();
    let (size, tunnel) = (2 * columns.len() + 1, tunnel(columns));
    let place = |p: [usize; 3]| [0, 1, 2].map(|k| p[k] as f64 - 0.5 * [size, size, 5][k] as f64);
    smooth(block_surface([size, size, 5], |block| !tunnel.contains(&block), place), levels)
}

/// The blocks of a tunnel along a grid diagram: rows one block above the floor, columns above them,
/// a block apart. The first column, which crosses nothing, is left out: the rows that it joins lead
/// out of the block instead.
fn tunnel(columns: &[[usize; 2]]) -> BTreeSet<[usize; 3]> {
    let mut result = BTreeSet::new();
    let at = |index: usize| 2 * index + 1;
    for (x, &[from, to]) in columns.iter().enumerate().skip(1) {
        result.extend((at(from.min(to))..=at(from.max(to))).map(|y| [at(x), y, 3]));
        result.extend([from, to].map(|y| [at(x), at(y), 2]));
    }
    for row in 0..columns.len() {
        let of_row = |column: &[usize; 2]| column.contains(&row);
        let first = columns.iter().position(of_row).map_or(0, |x| if x == 0 { 0 } else { at(x) });
        let last = columns.iter().rposition(of_row).map_or(0, at);
        result.extend((first..=last).map(|x| [x, at(row), 1]));
    }
    result
}

struct QuadMesh {
    positions: Vec<Vec3>,
    quads: Vec<[u32; 4]>,
}

/// Returns the quads between solid and empty blocks, counter-clockwise from the empty side. Blocks
/// must not touch in an edge or corner alone.
fn block_surface(
    cells: [usize; 3],
    is_solid: impl Fn([usize; 3]) -> bool,
    at: impl Fn([usize; 3]) -> Vec3,
) -> QuadMesh {
    let solid = |block: [usize; 3], axis: usize, step: isize| {
        let mut neighbour = block;
        match block[axis].checked_add_signed(step) {
            Some(x) if x < cells[axis] => neighbour[axis] = x,
            _ => return false,
        }
        is_solid(neighbour)
    };
    let mut number: BTreeMap<[usize; 3], u32> = BTreeMap::new();
    let mut mesh = QuadMesh { positions: Vec::new(), quads: Vec::new() };
    for index in 0..cells[0] * cells[1] * cells[2] {
        let block = [index / (cells[1] * cells[2]), index / cells[2] % cells[1], index % cells[2]];
        if !is_solid(block) {
            continue;
        }
        for axis in 0..3 {
            for (side, step) in [(0, -1), (1, 1)] {
                if solid(block, axis, step) {
                    continue;
                }
                let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
                let mut quad = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| {
                    let mut p = block;
                    p[axis] += side;
                    p[first] += a;
                    p[second] += b;
                    *number.entry(p).or_insert_with(|| {
                        mesh.positions.push(at(p));
                        mesh.positions.len() as u32 - 1
                    })
                });
                if side == 0 {
                    quad.reverse();
                }
                mesh.quads.push(quad);
            }
        }
    }
    mesh
}

fn smooth(mut mesh: QuadMesh, levels: u32) -> Result<TriangleMesh, MeshError> {
    for _ in 0..levels {
        mesh = subdivide(&mesh);
    }
    let faces = cut_quads(&mesh.positions, &mesh.quads);
    TriangleMesh::new(mesh.positions, faces)
}

/// Applies one step of Catmull-Clark to a closed surface. The vertices come first, then one point
/// per quad, then one point per edge.
fn subdivide(mesh: &QuadMesh) -> QuadMesh {
    let (vertices, quads) = (mesh.positions.len(), mesh.quads.len());
    // Sides of quads sorted by their endpoints: the two sides of an edge become neighbours.
    let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(4 * quads);
    for (q, quad) in mesh.quads.iter().enumerate() {
        for k in 0..4 {
            let (a, b) = (quad[k], quad[(k + 1) % 4]);
            sides.push((a.min(b), a.max(b), (4 * q + k) as u32));
        }
    }
    sides.sort_unstable();
    let quad_points: Vec<Vec3> = mesh
        .quads
        .iter()
        .map(|quad| scale(quad.iter().fold([0.0; 3], |sum, &v| add(sum, mesh.positions[v as usize])), 0.25))
        .collect();

    let mut positions = mesh.positions.clone();
    positions.extend_from_slice(&quad_points);
    let mut edge_of_side = vec![0u32; 4 * quads];
    let mut edge_sums = vec![[0.0; 3]; vertices];
    let mut valence = vec![0usize; vertices];
    for group in sides.chunk_by(|s, t| (s.0, s.1) == (t.0, t.1)) {
        let (a, b, _) = group[0];
        let ends = add(mesh.positions[a as usize], mesh.positions[b as usize]);
        let across = group.iter().fold([0.0; 3], |sum, s| add(sum, quad_points[s.2 as usize / 4]));
        for &(_, _, side) in group {
            edge_of_side[side as usize] = positions.len() as u32;
        }
        positions.push(scale(add(ends, across), 1.0 / (2 + group.len()) as f64));
        for v in [a as usize, b as usize] {
            edge_sums[v] = add(edge_sums[v], scale(ends, 0.5));
            valence[v] += 1;
        }
    }
    let mut quad_sums = vec![[0.0; 3]; vertices];
    for (quad, &point) in mesh.quads.iter().zip(&quad_points) {
        for &v in quad {
            quad_sums[v as usize] = add(quad_sums[v as usize], point);
        }
    }
    for v in 0..vertices {
        // A vertex of a closed surface has as many quads as edges.
        let n = valence[v] as f64;
        let around = add(quad_sums[v], scale(edge_sums[v], 2.0));
        positions[v] = add(scale(around, 1.0 / (n * n)), scale(mesh.positions[v], (n - 3.0) / n));
    }
    let mut finer = Vec::with_capacity(4 * quads);
    for (q, quad) in mesh.quads.iter().enumerate() {
        for k in 0..4 {
            let (after, before) = (edge_of_side[4 * q + k], edge_of_side[4 * q + (k + 3) % 4]);
            finer.push([quad[k], after, (vertices + q) as u32, before]);
        }
    }
    QuadMesh { positions, quads: finer }
}
