//! Small meshes for tests of curves, and a seeded generator.
#![allow(dead_code)] // each test file uses some of them

use eikona_mesh::{PolygonMesh, TriangleMesh};
use std::collections::BTreeMap;
use std::path::Path;

/// SplitMix64.
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
    pub fn point(&mut self, low: f64, high: f64) -> [f64; 3] {
        [0; 3].map(|_| low + (high - low) * self.unit())
    }
}

/// n x n squares over [0, 1]^2, each divided by its rising diagonal.
pub fn grid(n: usize, height: impl Fn(f64, f64) -> [f64; 3]) -> TriangleMesh {
    let m = n as u32 + 1;
    let mut positions = Vec::new();
    for i in 0..=n {
        for j in 0..=n {
            positions.push(height(j as f64 / n as f64, i as f64 / n as f64));
        }
    }
    let mut faces = Vec::new();
    for i in 0..n as u32 {
        for j in 0..n as u32 {
            let a = i * m + j;
            faces.push([a, a + 1, a + m + 1]);
            faces.push([a, a + m + 1, a + m]);
        }
    }
    TriangleMesh::new(positions, faces).unwrap()
}

pub fn flat_grid(n: usize) -> TriangleMesh {
    grid(n, |x, y| [x, y, 0.0])
}

/// A height field with randomly moved inner vertices.
pub fn rough_grid(n: usize, seed: u64) -> TriangleMesh {
    let random = std::cell::RefCell::new(Random(seed));
    let h = 0.3 / n as f64;
    grid(n, |x, y| {
        let [a, b, c] = random.borrow_mut().point(-h, h);
        let inner = x > 0.0 && x < 1.0 && y > 0.0 && y < 1.0;
        let (dx, dy) = if inner { (a, b) } else { (0.0, 0.0) };
        [x + dx, y + dy, c + 0.2 * (6.0 * x).sin() * (5.0 * y).cos()]
    })
}

/// The unit sphere: an icosahedron subdivided in four `levels` times.
pub fn sphere(levels: usize) -> TriangleMesh {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let mut positions: Vec<[f64; 3]> = Vec::new();
    for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        positions.extend([[a, b, 0.0], [0.0, a, b], [b, 0.0, a]]);
    }
    let edge = 2.0 + 1e-9;
    let distance = |p: [f64; 3], q: [f64; 3]| (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt();
    let mut faces: Vec<[u32; 3]> = Vec::new();
    for i in 0..12usize {
        for j in i + 1..12 {
            for k in j + 1..12 {
                let [p, q, r] = [positions[i], positions[j], positions[k]];
                if distance(p, q) < edge && distance(q, r) < edge && distance(p, r) < edge {
                    let det = p[0] * (q[1] * r[2] - q[2] * r[1]) - p[1] * (q[0] * r[2] - q[2] * r[0])
                        + p[2] * (q[0] * r[1] - q[1] * r[0]);
                    let [i, j, k] = [i as u32, j as u32, k as u32];
                    faces.push(if det > 0.0 { [i, j, k] } else { [i, k, j] });
                }
            }
        }
    }
    for _ in 0..levels {
        let mut middle = BTreeMap::new();
        let mut finer = Vec::new();
        for &f in &faces {
            let m = [0, 1, 2].map(|k| {
                let (a, b) = (f[k], f[(k + 1) % 3]);
                *middle.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let (p, q) = (positions[a as usize], positions[b as usize]);
                    positions.push([0, 1, 2].map(|k| 0.5 * (p[k] + q[k])));
                    positions.len() as u32 - 1
                })
            });
            finer.extend([[f[0], m[0], m[2]], [f[1], m[1], m[0]], [f[2], m[2], m[1]], m]);
        }
        faces = finer;
    }
    for p in &mut positions {
        let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        *p = p.map(|x| x / length);
    }
    TriangleMesh::new(positions, faces).unwrap()
}

/// A torus with radii 1 and `r` about the z axis.
pub fn torus(n: usize, m: usize, r: f64) -> TriangleMesh {
    band(n, m, |s, t| {
        let (a, b) = (std::f64::consts::TAU * s, std::f64::consts::TAU * t);
        [(1.0 + r * b.cos()) * a.cos(), (1.0 + r * b.cos()) * a.sin(), r * b.sin()]
    })
}

/// A Moebius strip with a middle line of radius 1.
pub fn moebius(n: usize, m: usize) -> TriangleMesh {
    let mut positions = Vec::new();
    for i in 0..n {
        for j in 0..=m {
            let a = std::f64::consts::TAU * i as f64 / n as f64;
            let w = 0.4 * (2.0 * j as f64 / m as f64 - 1.0);
            let radius = 1.0 + w * (a / 2.0).cos();
            positions.push([radius * a.cos(), radius * a.sin(), w * (a / 2.0).sin()]);
        }
    }
    let id = |i: usize, j: usize| if i < n { (i * (m + 1) + j) as u32 } else { (m - j) as u32 };
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
            faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    TriangleMesh::new(positions, faces).unwrap()
}

fn band(n: usize, m: usize, place: impl Fn(f64, f64) -> [f64; 3]) -> TriangleMesh {
    let mut positions = Vec::new();
    for i in 0..n {
        for j in 0..m {
            positions.push(place(i as f64 / n as f64, j as f64 / m as f64));
        }
    }
    let id = |i: usize, j: usize| ((i % n) * m + j % m) as u32;
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
            faces.extend([[a, b, c], [a, c, d]]);
        }
    }
    TriangleMesh::new(positions, faces).unwrap()
}

/// The surface of [0, 1]^3, each side n x n squares.
pub fn cube(n: usize) -> TriangleMesh {
    let mut ids = BTreeMap::new();
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for axis in 0..3 {
        for end in [0, n] {
            let mut id = |u: usize, v: usize| {
                let mut p = [0; 3];
                p[axis] = end;
                p[(axis + 1) % 3] = u;
                p[(axis + 2) % 3] = v;
                *ids.entry(p).or_insert_with(|| {
                    positions.push(p.map(|x| x as f64 / n as f64));
                    positions.len() as u32 - 1
                })
            };
            for u in 0..n {
                for v in 0..n {
                    let q = [id(u, v), id(u + 1, v), id(u + 1, v + 1), id(u, v + 1)];
                    let [a, b, c, d] = if end == n { q } else { [q[0], q[3], q[2], q[1]] };
                    faces.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
    }
    TriangleMesh::new(positions, faces).unwrap()
}

/// Reads vertices and faces of an OBJ or OFF file, just enough for the data folder. `None` if the
/// file does not exist.
pub fn read_mesh(path: impl AsRef<Path>) -> Option<TriangleMesh> {
    let text = String::from_utf8_lossy(&std::fs::read(path.as_ref()).ok()?).into_owned();
    let numbers =
        |line: &str| -> Vec<f64> { line.split_whitespace().filter_map(|w| w.parse().ok()).collect() };
    let (mut positions, mut faces): (Vec<[f64; 3]>, Vec<Vec<u32>>) = (Vec::new(), Vec::new());
    if path.as_ref().extension()? == "off" {
        let mut lines = text.lines().filter(|l| !l.starts_with('#') && !l.trim().is_empty()).skip(1);
        let counts = numbers(lines.next()?);
        for line in lines.by_ref().take(counts[0] as usize) {
            let n = numbers(line);
            positions.push([n[0], n[1], n[2]]);
        }
        for line in lines.take(counts[1] as usize) {
            let n = numbers(line);
            faces.push(n[1..=n[0] as usize].iter().map(|&x| x as u32).collect());
        }
    } else {
        for line in text.lines() {
            let mut words = line.split_whitespace();
            match words.next() {
                Some("v") => {
                    let n = numbers(line);
                    positions.push([n[0], n[1], n[2]]);
                }
                Some("f") => faces
                    .push(words.map(|w| w.split('/').next().unwrap().parse::<u32>().unwrap() - 1).collect()),
                _ => {}
            }
        }
    }
    let mut mesh = PolygonMesh::new(positions);
    faces.into_iter().for_each(|f| mesh.push_face(f));
    Some(mesh.triangulate().ok()?.0)
}

pub const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data");
