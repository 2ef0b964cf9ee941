//! The surface of a box, subdivided into a lattice of cells.

use super::lattice::cut_quads;
use super::parameter::{limit_faces, require_length, require_some};
use super::vector::Vec3;
use crate::error::MeshError;
use crate::mesh::TriangleMesh;

/// The quads on the surface of a box of `cells` cubes. Lattice points have coordinates (i, j, k),
/// from 0 to the number of cells.
pub(super) struct BoxSurface {
    pub cells: [usize; 3],
}

impl BoxSurface {
    /// Returns the number of a lattice point on the surface: the bottom row by row, the rings from
    /// bottom to top, the top.
    fn vertex(&self, [i, j, k]: [usize; 3]) -> u32 {
        let [nx, ny, nz] = self.cells;
        let in_layer = j * (nx + 1) + i;
        let bottom = (nx + 1) * (ny + 1);
        let ring = 2 * (nx + ny);
        let index = if k == 0 {
            in_layer
        } else if k == nz {
            bottom + (nz - 1) * ring + in_layer
        } else {
            let around = if j == 0 {
                i
            } else if i == nx {
                nx + j
            } else if j == ny {
                nx + ny + (nx - i)
            } else {
                2 * nx + ny + (ny - j)
            };
            bottom + (k - 1) * ring + around
        };
        index as u32
    }

    /// Returns the positions of the lattice points, in the order of their numbers.
    pub(super) fn positions(&self, at: impl Fn([usize; 3]) -> Vec3) -> Vec<Vec3> {
        let [nx, ny, nz] = self.cells;
        let layer = |k: usize| (0..=ny).flat_map(move |j| (0..=nx).map(move |i| [i, j, k]));
        let ring = |k: usize| {
            let there = (0..nx).map(move |i| [i, 0, k]).chain((0..ny).map(move |j| [nx, j, k]));
            let back = (0..nx).map(move |i| [nx - i, ny, k]).chain((0..ny).map(move |j| [0, ny - j, k]));
            there.chain(back)
        };
        layer(0).chain((1..nz).flat_map(ring)).chain(layer(nz)).map(at).collect()
    }

    /// Returns the quads, counter-clockwise seen from outside.
    pub(super) fn quads(&self) -> Vec<[u32; 4]> {
        let mut quads = Vec::new();
        for normal in 0..3 {
            // (normal, first, second) is a cyclic order of the axes, so first x second points along
            // the normal.
            let (first, second) = ((normal + 1) % 3, (normal + 2) % 3);
            for (side, outward) in [(0, false), (self.cells[normal], true)] {
                for a in 0..self.cells[first] {
                    for b in 0..self.cells[second] {
                        let corner = |da: usize, db: usize| {
                            let mut p = [0; 3];
                            p[normal] = side;
                            p[first] = a + da;
                            p[second] = b + db;
                            self.vertex(p)
                        };
                        let mut quad = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                        if !outward {
                            quad.reverse();
                        }
                        quads.push(quad);
                    }
                }
            }
        }
        quads
    }
}

/// A box centred at the origin, with `size` along the axes and its sides subdivided into `cells`
/// quads along the axes.
///
/// V = 2 s + 2, E = 6 s, F = 4 s with s = ab + bc + ca for cells [a, b, c]. Outward oriented.
///
/// # Errors
/// [`MeshError::Parameter`] if a size is not a positive length, a count is 0, or there are too many
/// faces.
///
/// ```
/// let cube = eikona_mesh::shapes::cuboid([1.0, 1.0, 1.0], [1, 1, 1])?;
/// assert_eq!((cube.vertex_count(), cube.edge_count(), cube.face_count()), (8, 18, 12));
/// # Ok::<(), eikona_mesh::MeshError>(())
/// ```
pub fn cuboid(size: [f64; 3], cells: [usize; 3]) -> Result<TriangleMesh, MeshError> {
    for k in 0..3 {
        require_length(["size x", "size y", "size z"][k], size[k])?;
        require_some(["cells x", "cells y", "cells z"][k], cells[k])?;
    }
    let [a, b, c] = cells.map(|n| n as f64);
    limit_faces("cells", format_args!("{cells:?}"), 4.0 * (a * b + b * c + c * a))?;
    let surface = BoxSurface { cells };
    let positions =
        surface.positions(|at| [0, 1, 2].map(|k| size[k] * (at[k] as f64 / cells[k] as f64 - 0.5)));
    let faces = cut_quads(&positions, &surface.quads());
    TriangleMesh::new(positions, faces)
}
