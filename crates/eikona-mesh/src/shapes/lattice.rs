//! Rectangular lattices of quads, closed or open in either direction, cut into triangles; and bands
//! of triangles between rings.

use super::vector::{Vec3, distance};
use crate::error::MeshError;
use crate::mesh::TriangleMesh;

/// How each quad of a lattice is cut into two triangles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Diagonal {
    /// From the first corner to the third: every interior vertex has six neighbours.
    #[default]
    Uniform,
    /// Alternating like the colours of a chessboard: vertices have four or eight neighbours, and no
    /// direction is favoured.
    Alternating,
    /// The shorter one, and the first if both have the same length.
    Shorter,
}

/// How the last column of a lattice is joined to the first.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Seam {
    Open,
    Closed,
    /// Joined upside down, as in a Moebius band.
    Mirrored,
}

/// A lattice of `columns` x `rows` quads. Vertices are numbered column by column.
#[derive(Clone, Copy)]
pub(super) struct Lattice {
    pub columns: usize,
    pub rows: usize,
    pub seam: Seam,
    pub rows_closed: bool,
}

impl Lattice {
    /// Returns the number of vertices per column.
    fn height(&self) -> usize {
        self.rows + usize::from(!self.rows_closed)
    }

    /// Returns the number of columns of vertices.
    fn width(&self) -> usize {
        self.columns + usize::from(self.seam == Seam::Open)
    }

    /// Returns the vertex at column `i` (up to `columns`) and row `j` (up to `rows`).
    fn vertex(&self, i: usize, j: usize) -> u32 {
        let height = self.height();
        let j = if j == height { 0 } else { j };
        let (i, j) = match (i == self.width(), self.seam) {
            (true, Seam::Mirrored) => (0, height - 1 - j),
            (true, _) => (0, j),
            (false, _) => (i, j),
        };
        (i * height + j) as u32
    }

    pub(super) fn positions(&self, mut at: impl FnMut(usize, usize) -> Vec3) -> Vec<Vec3> {
        let mut positions = Vec::with_capacity(self.width() * self.height());
        for i in 0..self.width() {
            for j in 0..self.height() {
                positions.push(at(i, j));
            }
        }
        positions
    }

    /// Returns two triangles per quad, counter-clockwise if columns run to the right and rows up.
    pub(super) fn triangles(&self, positions: &[Vec3], diagonal: Diagonal) -> Vec<[u32; 3]> {
        let mut faces = Vec::with_capacity(2 * self.columns * self.rows);
        for i in 0..self.columns {
            for j in 0..self.rows {
                let quad = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| self.vertex(i, j));
                let second = match diagonal {
                    Diagonal::Uniform => false,
                    Diagonal::Alternating => (i + j) % 2 == 1,
                    Diagonal::Shorter => second_diagonal_is_shorter(positions, quad),
                };
                faces.extend(cut(quad, second));
            }
        }
        faces
    }

    pub(super) fn mesh(
        &self,
        diagonal: Diagonal,
        at: impl FnMut(usize, usize) -> Vec3,
    ) -> Result<TriangleMesh, MeshError> {
        let positions = self.positions(at);
        let faces = self.triangles(&positions, diagonal);
        TriangleMesh::new(positions, faces)
    }
}

fn cut([a, b, c, d]: [u32; 4], second: bool) -> [[u32; 3]; 2] {
    if second { [[a, b, d], [b, c, d]] } else { [[a, b, c], [a, c, d]] }
}

fn second_diagonal_is_shorter(positions: &[Vec3], quad: [u32; 4]) -> bool {
    let [a, b, c, d] = quad.map(|v| positions[v as usize]);
    // Diagonals that differ by rounding alone count as equal, so that symmetric shapes are cut
    // symmetrically.
    distance(b, d) < distance(a, c) * (1.0 - 1e-9)
}

/// Cuts each quad along its shorter diagonal.
pub(super) fn cut_quads(positions: &[Vec3], quads: &[[u32; 4]]) -> Vec<[u32; 3]> {
    quads.iter().flat_map(|&q| cut(q, second_diagonal_is_shorter(positions, q))).collect()
}

/// A closed ring of evenly spaced vertices with consecutive numbers; ring vertex 0 is at angle 0.
#[derive(Clone, Copy)]
pub(super) struct Ring {
    pub start: usize,
    pub count: usize,
}

/// Fills the band between two rings with `inner.count + outer.count` triangles, counter-clockwise
/// if the rings are. The next triangle takes the side whose midpoint has the smaller angle.
pub(super) fn zip_rings(faces: &mut Vec<[u32; 3]>, inner: Ring, outer: Ring) {
    let name = |ring: Ring, i: usize| (ring.start + i % ring.count) as u32;
    let (mut i, mut o) = (0, 0);
    while i < inner.count || o < outer.count {
        let outer_next =
            o < outer.count && (i == inner.count || (2 * o + 1) * inner.count <= (2 * i + 1) * outer.count);
        if outer_next {
            faces.push([name(inner, i), name(outer, o), name(outer, o + 1)]);
            o += 1;
        } else {
            faces.push([name(inner, i), name(outer, o), name(inner, i + 1)]);
            i += 1;
        }
    }
}

/// Fills a ring with triangles around one vertex, counter-clockwise if the ring is.
pub(super) fn fan(faces: &mut Vec<[u32; 3]>, centre: usize, ring: Ring) {
    let name = |i: usize| (ring.start + i % ring.count) as u32;
    faces.extend((0..ring.count).map(|i| [centre as u32, name(i), name(i + 1)]));
}
