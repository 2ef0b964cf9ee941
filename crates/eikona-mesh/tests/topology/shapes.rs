//! Small meshes whose topology is known in closed form.

use eikona_mesh::TriangleMesh;
use std::f64::consts::TAU;

pub fn mesh(positions: Vec<[f64; 3]>, faces: Vec<[u32; 3]>) -> TriangleMesh {
    TriangleMesh::new(positions, faces).expect("test meshes are valid")
}

/// How opposite sides of a grid of squares are joined.
#[derive(Clone, Copy, PartialEq)]
pub enum Seam {
    Open,
    Joined,
    /// Joined after a reflection of the seam.
    Reflected,
}

/// Returns an `n` by `m` grid of squares, each cut in two, with its sides joined in both
/// directions, and all vertices at generic positions.
pub fn glued_grid(n: u32, m: u32, seams: [Seam; 2]) -> TriangleMesh {
    let rows = if seams[1] == Seam::Open { m + 1 } else { m };
    let columns = if seams[0] == Seam::Open { n + 1 } else { n };
    let vertex = |i: u32, j: u32| {
        let (mut i, mut j) = (i, j);
        if i == n && seams[0] != Seam::Open {
            i = 0;
            if seams[0] == Seam::Reflected {
                j = if seams[1] == Seam::Open { m - j } else { (m - j) % m };
            }
        }
        if j == m && seams[1] != Seam::Open {
            j = 0;
        }
        i * rows + j
    };
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            faces.push([a, b, c]);
            faces.push([a, c, d]);
        }
    }
    let at = |k: u32| [k as f64, ((k % 31).pow(2) % 31) as f64, ((k % 17).pow(2) % 17) as f64 * 0.1];
    mesh((0..columns * rows).map(at).collect(), faces)
}

/// Returns a flat grid of unit squares.
pub fn grid(n: u32, m: u32) -> TriangleMesh {
    let flat = glued_grid(n, m, [Seam::Open; 2]);
    let positions = (0..(n + 1) * (m + 1)).map(|k| [(k / (m + 1)) as f64, (k % (m + 1)) as f64, 0.0]);
    flat.with_positions(positions.collect()).expect("finite")
}

/// Returns an embedded Moebius band.
pub fn moebius(n: u32, m: u32) -> TriangleMesh {
    let band = glued_grid(n, m, [Seam::Reflected, Seam::Open]);
    let positions = (0..n * (m + 1)).map(|k| {
        let (angle, width) = (TAU * (k / (m + 1)) as f64 / n as f64, (k % (m + 1)) as f64 / m as f64 - 0.5);
        let radius = 2.0 + width * (angle / 2.0).cos();
        [radius * angle.cos(), radius * angle.sin(), width * (angle / 2.0).sin()]
    });
    band.with_positions(positions.collect()).expect("finite")
}

/// Returns the projective plane with six vertices: all fifteen pairs are edges.
pub fn projective_plane() -> TriangleMesh {
    let faces = vec![
        [0, 1, 2],
        [0, 2, 3],
        [0, 3, 4],
        [0, 4, 5],
        [0, 5, 1],
        [1, 2, 4],
        [2, 3, 5],
        [3, 4, 1],
        [4, 5, 2],
        [5, 1, 3],
    ];
    mesh((0..6).map(|k| [(k * k) as f64, k as f64, (k * k * k % 7) as f64]).collect(), faces)
}

pub fn cube() -> TriangleMesh {
    let positions = (0..8).map(|k| [(k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2 & 1) as f64]).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    mesh(positions, quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect())
}

/// Returns `blades` triangles at the edge from vertex 0 to vertex 1.
pub fn book(blades: u32) -> TriangleMesh {
    let mut positions = vec![[0., 0., 0.], [0., 0., 1.]];
    positions.extend((0..blades).map(|k| {
        let angle = TAU * k as f64 / blades as f64;
        [angle.cos(), angle.sin(), 0.5]
    }));
    mesh(positions, (0..blades).map(|k| [0, 1, 2 + k]).collect())
}

/// Returns two tetrahedra that share their first `shared` vertices.
pub fn two_tetrahedra(shared: u32) -> TriangleMesh {
    let second = |v: u32| if v < shared { v } else { 4 + v - shared };
    let first = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    let mut faces = first.to_vec();
    faces.extend(first.iter().map(|f| f.map(second)));
    let corner = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]];
    let mut positions = corner.to_vec();
    positions.extend(corner[shared as usize..].iter().map(|p| p.map(|x| -x)));
    mesh(positions, faces)
}

/// The generator SplitMix64.
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, bound: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) % bound
    }
    pub fn permutation(&mut self, n: usize) -> Vec<u32> {
        let mut order: Vec<u32> = (0..n as u32).collect();
        for i in (1..n).rev() {
            order.swap(i, self.below(i as u64 + 1) as usize);
        }
        order
    }
}
