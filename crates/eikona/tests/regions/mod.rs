//! Regions of faces and the curves around them.
#![allow(dead_code)] // each test file uses some of them

use eikona::geometry::Triangle;
use eikona::mesh::{Curve, Face, Neighbour, TriangleMesh};

pub fn centre(mesh: &TriangleMesh, f: Face) -> [f64; 3] {
    let [a, b, c] = mesh.face_positions(f);
    [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0)
}

/// Returns the boundary of a region as one curve per side, with the region on the left by the
/// orientation of its faces.
pub fn boundary_of(mesh: &TriangleMesh, inside: impl Fn(Face) -> bool) -> Vec<Curve> {
    let mut sides = Vec::new();
    for h in mesh.faces().filter(|&f| inside(f)).flat_map(|f| [0, 1, 2].map(|k| f.halfedge(k))) {
        if matches!(mesh.neighbour(h), Neighbour::Twin(other) if !inside(other.face())) {
            sides.push(Curve::signed([mesh.origin(h), mesh.tip(h)]));
        }
    }
    sides
}

pub fn area(mesh: &TriangleMesh, f: Face) -> f64 {
    Triangle::of_face(mesh, f).area
}
