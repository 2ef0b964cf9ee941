//! Distances across stitched seams equal those on the conforming mesh.

use eikona::signed_heat::{SolveOptions, Solver, SolverOptions};
use eikona_mesh::random::Random;
use eikona_mesh::{Curve, SurfaceCurves, TriangleMesh, Vertex, stitch, weld};

fn solve(mesh: &TriangleMesh, line: Vec<Vertex>) -> Vec<f64> {
    let solver = Solver::new(mesh, &SolverOptions::default()).unwrap();
    let source = SurfaceCurves::from_curve(Curve::signed(line));
    solver.solve(&source, &SolveOptions::default()).unwrap().distance.into_vec()
}

/// The vertices on x = 0, upwards.
fn line(mesh: &TriangleMesh) -> Vec<Vertex> {
    let mut on: Vec<Vertex> = mesh.vertices().filter(|v| mesh.position(*v)[0] == 0.0).collect();
    on.sort_by(|a, b| mesh.position(*a)[1].total_cmp(&mesh.position(*b)[1]));
    on
}

/// A part of `n` by `n` unit squares from column `x` on, with each square's side on the left and
/// right rim divided as given.
fn part(x: f64, n: usize, rims: [&[Vec<f64>]; 2], bend: f64) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    // Bent into a cylinder about the y axis, which nearly preserves distances along x and y.
    let place = |i: f64, y: f64| {
        if bend == 0.0 {
            [x + i, y, 0.0]
        } else {
            let angle = (x + i) * bend;
            [angle.sin() / bend, y, (1.0 - angle.cos()) / bend]
        }
    };
    let mut positions = Vec::new();
    for i in 0..=n {
        positions.extend((0..=n).map(|j| place(i as f64, j as f64)));
    }
    let number = |i: usize, j: usize| (i * (n + 1) + j) as u32;
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let [a, b, c, d] = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)];
            let mut side = |from: u32, to: u32, apex: u32, inside: &[f64], up: bool| {
                let mut row = vec![from];
                let mut inside = inside.to_vec();
                if !up {
                    inside.reverse();
                }
                for t in inside {
                    row.push(positions.len() as u32);
                    positions.push(place(if up { n as f64 } else { 0.0 }, j as f64 + t));
                }
                row.push(to);
                faces.extend(row.windows(2).map(|p| [p[0], p[1], apex]));
            };
            side(b, c, a, if i + 1 == n { &rims[1][j] } else { &[] }, true);
            side(d, a, c, if i == 0 { &rims[0][j] } else { &[] }, false);
        }
    }
    (positions, faces)
}

#[test]
fn random_t_junctions_give_the_distances_of_the_conforming_mesh() {
    // Parts of n columns side by side; each side of each seam is divided at random.
    let mut random = Random::from_seed(7);
    for round in 0..12 {
        let n = 2 + round % 3;
        let bend = [0.0, 0.2][round % 2];
        let draw = |random: &mut Random| -> Vec<Vec<f64>> {
            let one = |random: &mut Random| -> Vec<f64> {
                let mut inside: Vec<f64> =
                    (0..random.below(4)).map(|_| (1 + random.below(31)) as f64 / 32.0).collect();
                inside.sort_by(f64::total_cmp);
                inside.dedup();
                inside
            };
            (0..n).map(|_| one(random)).collect()
        };
        let sides: Vec<Vec<Vec<f64>>> = (0..4).map(|_| draw(&mut random)).collect();
        let none = vec![Vec::new(); n];
        let both = |a: &[Vec<f64>], b: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let join = |(a, b): (&Vec<f64>, &Vec<f64>)| {
                let mut all: Vec<f64> = a.iter().chain(b).copied().collect();
                all.sort_by(f64::total_cmp);
                all.dedup();
                all
            };
            a.iter().zip(b).map(join).collect()
        };
        let [first, second] = [both(&sides[0], &sides[1]), both(&sides[2], &sides[3])];
        let joined = |rims: [[&[Vec<f64>]; 2]; 3]| {
            let (mut positions, mut faces) = (Vec::new(), Vec::new());
            for (k, rims) in rims.into_iter().enumerate() {
                let (more, new) = part((k * n) as f64, n, rims, bend);
                let start = positions.len() as u32;
                positions.extend(more);
                faces.extend(new.into_iter().map(|f| f.map(|v| v + start)));
            }
            TriangleMesh::new(positions, faces).unwrap()
        };
        let cut = joined([[&none, &sides[0]], [&sides[1], &sides[2]], [&sides[3], &none]]);
        let whole = weld(&joined([[&none, &first], [&first, &second], [&second, &none]]), 0.0).unwrap().mesh;
        let stitched = stitch(&cut, None).unwrap();
        let (got, right) = (solve(&stitched.mesh, line(&stitched.mesh)), solve(&whole, line(&whole)));
        assert_eq!(got.len(), right.len());
        for v in cut.vertices() {
            let d = got[stitched.provenance.new_vertex(v).unwrap().index()];
            let p = cut.position(v);
            let near = |w: &Vertex| (0..3).all(|k| (whole.position(*w)[k] - p[k]).abs() < 1e-9);
            let w = whole.vertices().find(near).expect("the conforming mesh has all vertices");
            assert!((d - right[w.index()]).abs() < 1e-10, "{v} {p:?}: {d}, not {}", right[w.index()]);
            if bend == 0.0 {
                assert!((d - p[0]).abs() < 1e-10, "{v} {p:?}: {d}");
            }
        }
    }
}
