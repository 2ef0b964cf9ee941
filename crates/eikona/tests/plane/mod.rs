//! Points of flat meshes.

use eikona::mesh::{Face, SurfacePoint, TriangleMesh};

/// Returns the surface point at a place in the plane of a flat mesh.
pub fn in_plane(mesh: &TriangleMesh, [x, y]: [f64; 2]) -> SurfacePoint {
    let weights = |f: Face| {
        let [a, b, c] = mesh.face_positions(f);
        let twice = |p: [f64; 3], q: [f64; 3]| (p[0] - x) * (q[1] - y) - (p[1] - y) * (q[0] - x);
        let parts = [twice(b, c), twice(c, a), twice(a, b)];
        let whole: f64 = parts.iter().sum();
        parts.map(|p| p / whole)
    };
    let least = |f: &Face| weights(*f).into_iter().fold(f64::INFINITY, f64::min);
    let face = mesh.faces().max_by(|f, g| least(f).total_cmp(&least(g))).unwrap();
    SurfacePoint::Face { vertices: mesh.face_vertices(face).map(|v| v.0), bary: weights(face) }
}
