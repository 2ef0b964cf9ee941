//! The surfaces of the reference numbers.
#![allow(dead_code)] // each test uses some of them

use eikona::mesh::TriangleMesh;
use std::collections::BTreeMap;

pub fn moved(mesh: &TriangleMesh, map: impl Fn([f64; 3]) -> [f64; 3]) -> TriangleMesh {
    mesh.with_positions(mesh.positions().iter().map(|p| map(*p)).collect()).unwrap()
}

pub fn together(first: &TriangleMesh, second: &TriangleMesh) -> TriangleMesh {
    let shift = first.vertex_count() as u32;
    let faces = second.triangles().iter().map(|t| t.map(|v| v + shift));
    TriangleMesh::new(
        first.positions().iter().chain(second.positions()).copied().collect(),
        first.triangles().iter().copied().chain(faces).collect(),
    )
    .unwrap()
}

/// The sphere of the reference numbers: the icosahedron of the golden ratio, split in four.
fn golden_sphere(levels: usize) -> TriangleMesh {
    let golden = 0.5 * (1.0 + 5.0f64.sqrt());
    let on_sphere = |p: [f64; 3]| {
        let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        p.map(|x| x / length)
    };
    let mut points = Vec::new();
    for (s, t) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        points.extend([[0.0, s, t * golden], [s, t * golden, 0.0], [t * golden, 0.0, s]].map(on_sphere));
    }
    let distance = |a: u32, b: u32| {
        let [a, b] = [a, b].map(|v| points[v as usize]);
        (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum::<f64>().sqrt()
    };
    let mut faces = Vec::new();
    for a in 0..12u32 {
        for b in 0..a {
            // 1.05 is the length of a side, 1.7 the next distance.
            faces.extend(
                (0..b)
                    .filter(|&c| distance(a, b).max(distance(b, c)).max(distance(c, a)) < 1.2)
                    .map(|c| [a, b, c]),
            );
        }
    }
    assert_eq!(faces.len(), 20);
    for _ in 0..levels {
        let mut middles = BTreeMap::new();
        let mut split = Vec::new();
        for [a, b, c] in faces {
            let [x, y, z] = [[a, b], [b, c], [c, a]].map(|[a, b]: [u32; 2]| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let [p, q] = [a, b].map(|v| points[v as usize]);
                    points.push(on_sphere([0, 1, 2].map(|k| p[k] + q[k])));
                    points.len() as u32 - 1
                })
            });
            split.extend([[a, x, z], [x, b, y], [z, y, c], [x, y, z]]);
        }
        faces = split;
    }
    TriangleMesh::new(points, faces).unwrap()
}

pub fn two_spheres(levels: usize, gap: f64) -> TriangleMesh {
    let sphere = golden_sphere(levels);
    let at = |x: f64| moved(&sphere, |p| [p[0] + x, p[1], p[2]]);
    together(&at(-1.0 - 0.5 * gap), &at(1.0 + 0.5 * gap))
}

/// The torus of the reference numbers: quads split by the diagonal (i, j) - (i + 1, j + 1).
pub fn torus(nu: u32, nv: u32) -> TriangleMesh {
    let angle = |i: u32, n: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n);
    let point = |i: u32, j: u32| {
        let (u, v) = (angle(i, nu), angle(j, nv));
        let ring = 1.0 + v.cos() / 3.0;
        [ring * u.cos(), ring * u.sin(), v.sin() / 3.0]
    };
    let id = |i: u32, j: u32| (i % nu) * nv + j % nv;
    let cells = (0..nu).flat_map(|i| (0..nv).map(move |j| (i, j)));
    TriangleMesh::new(
        cells.clone().map(|(i, j)| point(i, j)).collect(),
        cells
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect(),
    )
    .unwrap()
}
