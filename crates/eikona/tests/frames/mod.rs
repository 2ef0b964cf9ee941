//! Angles of vectors in faces.

use eikona::mesh::{Face, TriangleMesh};
use std::f64::consts::TAU;

type Vector = [f64; 3];

pub fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The representative of an angle within half a turn of zero.
pub fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

/// The angle of a vector in the frame of a face, whose first axis is its first side.
pub fn angle_in_face(mesh: &TriangleMesh, f: Face, v: Vector) -> f64 {
    let [a, b, c] = mesh.face_positions(f);
    // Products of tiny or huge lengths would leave the range.
    let scaled = |v: Vector| v.map(|x| x / v.iter().fold(0.0, |m: f64, x| m.max(x.abs())));
    let (along, v) = (scaled(sub(b, a)), scaled(v));
    let normal = cross(along, scaled(sub(c, a)));
    let across = cross(normal, along).map(|x| x / dot(normal, normal).sqrt());
    dot(v, across).atan2(dot(v, along))
}
