//! Surfaces of the study, and the lowest eigenfunctions of their Laplacians.

use eikona::geometry::lay_out;
use eikona::mesh::random::Random;
use eikona::mesh::{TriangleMesh, damage, io, shapes};
use eikona::operators::CotanLaplacian;
use eikona_numeric::{Cholesky, Ordering, Symbolic, nested_dissection_order};
use std::path::Path;

/// Files of the data folder, with the genus of each.
const FILES: [(&str, u32); 5] = [
    ("closed/spot.obj", 0),
    ("closed/bunny.obj", 0),
    ("closed/rocker-arm.obj", 1),
    ("closed/double-torus.obj", 2),
    ("boundary/lilium.obj", 0),
];

/// Returns six generated surfaces, and those files of the data folder that exist.
pub fn surfaces() -> Vec<(String, TriangleMesh)> {
    let torus = shapes::torus(1.0, 0.4, 72, 36).unwrap();
    let cylinder = shapes::cylinder(0.5, 2.0, 48, 60, shapes::Ends::Open).unwrap();
    let mut surfaces = vec![
        ("bumpy sphere, genus 0".to_string(), shapes::bumpy_sphere(18, 0.3, 4.0).unwrap()),
        ("clay animal, genus 0".to_string(), shapes::clay_animal(3).unwrap()),
        ("torus, genus 1".to_string(), damage::jitter(&torus, 0.15, 5).unwrap()),
        ("open cylinder".to_string(), damage::jitter(&cylinder, 0.15, 6).unwrap()),
        ("chain, genus 2".to_string(), shapes::chain_of_genus(2, 3).unwrap()),
        ("geodesic sphere, genus 0".to_string(), shapes::geodesic_sphere(16).unwrap()),
    ];
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    for (file, genus) in FILES {
        if let Ok(read) = io::read_mesh(data.join(file)) {
            surfaces.push((format!("{file}, genus {genus}"), read.mesh.triangulate().unwrap().0));
        }
    }
    surfaces
}

/// Returns the `count` lowest nonconstant eigenfunctions of the Laplacian with their eigenvalues,
/// by inverse iteration. Eigenfunctions with nearly equal eigenvalues are mixed, which is harmless
/// here: every combination varies as slowly.
pub fn eigenfunctions(mesh: &TriangleMesh, count: usize) -> Vec<(f64, Vec<f64>)> {
    let n = mesh.vertex_count();
    let triangles = lay_out(mesh);
    let mut laplacian = CotanLaplacian::new(mesh, &triangles);
    let mut mass = vec![0.0; n];
    for (corners, triangle) in mesh.triangles().iter().zip(&triangles) {
        corners.iter().for_each(|&v| mass[v as usize] += triangle.area / 3.0);
    }
    let total: f64 = mass.iter().sum();
    for (diagonal, m) in laplacian.matrix.diagonal.iter_mut().zip(&mass) {
        *diagonal += m.max(1e-12 * total) / total;
    }
    let order = nested_dissection_order(&laplacian.graph, mesh.positions(), 1).unwrap();
    let symbolic = Symbolic::new(&laplacian.graph, Ordering::Given(&order)).unwrap();
    let factor = Cholesky::new(symbolic.into(), &laplacian.matrix).unwrap();
    let product = |x: &[f64], y: &[f64]| (0..n).map(|i| mass[i] * x[i] * y[i]).sum::<f64>();
    let mut random = Random::from_seed(1);
    let mut found = vec![(0.0, vec![1.0 / total.sqrt(); n])];
    while found.len() <= count {
        let mut x: Vec<f64> = (0..n).map(|_| random.normal()).collect();
        let mut value = 0.0;
        for _ in 0..60 {
            let load: Vec<f64> = x.iter().zip(&mass).map(|(x, m)| x * m).collect();
            x = factor.solve(&load).unwrap();
            for (_, y) in &found {
                let along = product(&x, y);
                x.iter_mut().zip(y).for_each(|(x, y)| *x -= along * y);
            }
            let size = product(&x, &x).sqrt();
            x.iter_mut().for_each(|x| *x /= size);
            value = 1.0 / size - 1.0 / total;
        }
        found.push((value, x));
    }
    found.split_off(1)
}
