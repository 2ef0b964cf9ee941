//! A rectangular plate with holes whose boundaries are exact, not staircases.
//!
//! The triangles of a grid are cut along the boundaries of the holes. Vertices close to a boundary
//! are first snapped onto it, which keeps the cut triangles from becoming slivers (F. Labelle and
//! J. Shewchuk, "Isosurface stuffing", SIGGRAPH 2007, in the plane).

use super::flat::grid;
use super::lattice::Diagonal;
use super::parameter::{refuse, require, require_length};
use super::vector::{Vec3, lerp};
use crate::error::MeshError;
use crate::id::Vertex;
use crate::mesh::TriangleMesh;

/// A hole in a plate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Hole {
    /// An axis-aligned rectangle. Its corners are cut off by less than a cell.
    Rectangle {
        /// Its lower left corner.
        min: [f64; 2],
        /// Its upper right corner.
        max: [f64; 2],
    },
    /// A disk.
    Disk {
        /// Its centre.
        centre: [f64; 2],
        /// Its radius.
        radius: f64,
    },
}

impl Hole {
    /// Returns a level set function, negative inside the hole and equal to the signed distance near
    /// its sides.
    fn signed_distance(&self, p: Vec3) -> f64 {
        match *self {
            Hole::Disk { centre, radius } => (p[0] - centre[0]).hypot(p[1] - centre[1]) - radius,
            Hole::Rectangle { min, max } => {
                [0, 1].map(|k| (min[k] - p[k]).max(p[k] - max[k])).into_iter().fold(f64::MIN, f64::max)
            }
        }
    }

    fn check(&self) -> Result<(), MeshError> {
        match self {
            Hole::Disk { centre, radius } => {
                let finite = centre.iter().all(|x| x.is_finite());
                require(finite, "hole centre", format_args!("{centre:?}"), "it must be finite")?;
                require_length("hole radius", *radius)
            }
            Hole::Rectangle { min, max } => {
                let ordered =
                    [0, 1].iter().all(|&k| min[k] < max[k] && min[k].is_finite() && max[k].is_finite());
                let bound = "min must be below max, and both finite";
                require(ordered, "hole rectangle", format_args!("{min:?} to {max:?}"), bound)
            }
        }
    }
}

/// The share of an edge that a vertex may move along it to reach the rim. With 0.35 every triangle
/// of a [`Diagonal::Uniform`] grid keeps at least 0.19 of its area, in whatever directions its
/// three corners move: the area is linear in each of the three steps, so its minimum is among the
/// 7³ extreme cases.
const SNAP: f64 = 0.35;

/// The rectangle [0, `width`] x [0, `height`], subdivided into `nx` x `ny` cells, without the
/// interiors of the holes.
///
/// Every hole adds one boundary loop: χ = 1 - holes, if the holes are disjoint. Boundary vertices
/// of round holes lie on the circle. Triangles away from the holes are those of [`grid`]; at a
/// round hole, in square cells, angles stay above 10°.
///
/// # Errors
/// [`MeshError::Parameter`] for bad parameters of [`grid`] or a hole, and if holes are so small or
/// so close to each other or to the border that the mesh would not have exactly one more boundary
/// loop per hole.
///
/// # Cost
/// O(nx ny) times the number of holes.
///
/// ```
/// use eikona_mesh::shapes::{Hole, grid_with_holes};
/// let hole = Hole::Disk { centre: [1.0, 0.5], radius: 0.25 };
/// let plate = grid_with_holes(40, 20, 2.0, 1.0, &[hole])?;
/// let chi = plate.vertex_count() as i64 - plate.edge_count() as i64 + plate.face_count() as i64;
/// assert_eq!(chi, 0);
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn grid_with_holes(
    nx: usize,
    ny: usize,
    width: f64,
    height: f64,
    holes: &[Hole],
) -> Result<TriangleMesh, MeshError> {
    for hole in holes {
        hole.check()?;
    }
    let plate = grid(nx, ny, width, height, Diagonal::Uniform)?;
    let value = |p: Vec3| holes.iter().map(|h| h.signed_distance(p)).fold(f64::MAX, f64::min);
    let values: Vec<f64> = plate.positions().iter().map(|&p| value(p)).collect();

    // The parameter at which each edge crosses a rim, if it does; endpoints included.
    let crossing: Vec<Option<f64>> = plate
        .edges()
        .map(|e| {
            let [a, b] = plate.edge_vertices(e);
            let (outside, inside) = (values[a.index()] > 0.0, values[b.index()] > 0.0);
            (outside != inside).then(|| root(|t| value(lerp(plate.position(a), plate.position(b), t))))
        })
        .collect();
    let mut cutter = Cutter::new(&plate, &values, crossing);
    cutter.snap();
    let mesh = cutter.cut()?;
    if boundary_loops(&mesh) == Some(1 + holes.len()) {
        return Ok(mesh);
    }
    let bound = "every hole must be at least two cells wide and two cells from other holes and the border; use more cells";
    refuse("holes", format_args!("{holes:?}"), bound)
}

/// Finds a change of sign of `f` between 0 and 1 by bisection.
fn root(f: impl Fn(f64) -> f64) -> f64 {
    let positive_at_0 = f(0.0) > 0.0;
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..52 {
        let middle = 0.5 * (low + high);
        if (f(middle) > 0.0) == positive_at_0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[derive(Clone, Copy, PartialEq)]
enum Side {
    Kept,
    Rim,
    Removed,
}

struct Cutter<'a> {
    plate: &'a TriangleMesh,
    positions: Vec<Vec3>,
    side: Vec<Side>,
    crossing: Vec<Option<f64>>,
}

impl<'a> Cutter<'a> {
    fn new(plate: &'a TriangleMesh, values: &[f64], crossing: Vec<Option<f64>>) -> Cutter<'a> {
        let side = values.iter().map(|&x| if x > 0.0 { Side::Kept } else { Side::Removed }).collect();
        Cutter { plate, positions: plate.positions().to_vec(), side, crossing }
    }

    /// Snaps the vertices that are close to the rim along one of their edges onto it.
    fn snap(&mut self) {
        for v in self.plate.vertices() {
            let mut nearest: Option<(f64, Vec3)> = None;
            for corner in self.plate.vertex_corners(v) {
                for h in [corner.halfedge(), corner.halfedge().previous()] {
                    let e = self.plate.edge(h);
                    let [a, b] = self.plate.edge_vertices(e);
                    let Some(t) = self.crossing[e.index()] else { continue };
                    let share = if a == v { t } else { 1.0 - t };
                    if share <= SNAP && nearest.is_none_or(|(s, _)| share < s) {
                        nearest = Some((share, lerp(self.plate.position(a), self.plate.position(b), t)));
                    }
                }
            }
            if let Some((_, place)) = nearest {
                self.positions[v.index()] = place;
                self.side[v.index()] = Side::Rim;
            }
        }
    }

    fn cut(mut self) -> Result<TriangleMesh, MeshError> {
        // A vertex on each edge that still crosses the rim.
        let mut cut_vertex: Vec<Option<u32>> = vec![None; self.plate.edge_count()];
        for e in self.plate.edges() {
            let [a, b] = self.plate.edge_vertices(e);
            let sides = [self.side[a.index()], self.side[b.index()]];
            if let (Some(t), [Side::Kept, Side::Removed] | [Side::Removed, Side::Kept]) =
                (self.crossing[e.index()], sides)
            {
                cut_vertex[e.index()] = Some(self.positions.len() as u32);
                self.positions.push(lerp(self.plate.position(a), self.plate.position(b), t));
            }
        }
        let mut faces = Vec::with_capacity(self.plate.face_count());
        for f in self.plate.faces() {
            let corners = self.plate.face_vertices(f);
            if corners.iter().all(|&v| self.side[v.index()] != Side::Kept) {
                continue;
            }
            // The boundary of the kept part: kept and rim corners, and the cut points between them.
            let mut polygon: Vec<u32> = Vec::with_capacity(4);
            for k in 0..3 {
                if self.side[corners[k].index()] != Side::Removed {
                    polygon.push(corners[k].0);
                }
                polygon.extend(cut_vertex[self.plate.face_edges(f)[k].index()]);
            }
            match polygon[..] {
                [a, b, c] => faces.push([a, b, c]),
                [a, b, c, d] => faces.extend(super::lattice::cut_quads(&self.positions, &[[a, b, c, d]])),
                _ => {}
            }
        }
        without_unused_vertices(self.positions, faces)
    }
}

fn without_unused_vertices(
    positions: Vec<Vec3>,
    mut faces: Vec<[u32; 3]>,
) -> Result<TriangleMesh, MeshError> {
    let mut new_number: Vec<Option<u32>> = vec![None; positions.len()];
    for &v in faces.iter().flatten() {
        new_number[v as usize] = Some(0);
    }
    let mut kept = Vec::new();
    for (number, p) in new_number.iter_mut().zip(positions) {
        if number.is_some() {
            *number = Some(kept.len() as u32);
            kept.push(p);
        }
    }
    for v in faces.iter_mut().flatten() {
        *v = new_number[*v as usize].unwrap_or(0);
    }
    TriangleMesh::new(kept, faces)
}

/// Returns the number of boundary loops, or `None` if two loops touch or the mesh is not connected.
fn boundary_loops(mesh: &TriangleMesh) -> Option<usize> {
    let mut next: Vec<Option<Vertex>> = vec![None; mesh.vertex_count()];
    for e in mesh.edges() {
        if let [h] = *mesh.edge_halfedges(e) {
            let start = mesh.origin(h).index();
            if next[start].is_some() {
                return None;
            }
            next[start] = Some(mesh.tip(h));
        }
    }
    let mut loops = 0;
    for start in 0..next.len() {
        let mut here = start;
        let mut length = 0;
        while let Some(v) = next[here].take() {
            here = v.index();
            length += 1;
        }
        loops += usize::from(length > 0);
    }
    // With one outer loop and the others around holes, χ = 2 - loops exactly if the mesh is
    // connected.
    let chi = mesh.vertex_count() as i64 - mesh.edge_count() as i64 + mesh.face_count() as i64;
    (chi == 2 - loops as i64).then_some(loops)
}
