//! Vector arithmetic in space, on plain arrays.

/// Vector or point in space.
pub type Vec3 = [f64; 3];

/// Returns `a + b`.
#[inline]
pub fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
/// Returns `a - b`.
#[inline]
pub fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
/// Returns `s a`.
#[inline]
pub fn scale(a: Vec3, s: f64) -> Vec3 {
    [s * a[0], s * a[1], s * a[2]]
}
/// Returns the dot product.
#[inline]
pub fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
/// Returns the cross product.
#[inline]
pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
/// Returns the Euclidean length.
#[inline]
pub fn norm(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}
/// Returns the Euclidean distance.
#[inline]
pub fn distance(a: Vec3, b: Vec3) -> f64 {
    norm(sub(a, b))
}
/// Returns `(1 - t) a + t b`.
#[inline]
pub fn lerp(a: Vec3, b: Vec3, t: f64) -> Vec3 {
    [0, 1, 2].map(|k| (1.0 - t) * a[k] + t * b[k])
}
/// Returns the unit vector in the direction of `a`; `None` if `a` is zero or not finite.
///
/// ```
/// use eikona_mesh::vector::normalize;
/// assert_eq!(normalize([0.0, 3e-200, 4e-200]), Some([0.0, 0.6, 0.8]));
/// assert_eq!(normalize([0.0; 3]), None);
/// ```
pub fn normalize(a: Vec3) -> Option<Vec3> {
    // Dividing by the largest entry first keeps the squares of tiny and huge vectors in range.
    let largest = a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let b = a.map(|x| x / largest);
    let length = norm(b);
    length.is_finite().then(|| b.map(|x| x / length))
}
/// Returns the unit vector in the direction of `a`; zero if `a` is zero or not finite.
pub fn unit(a: Vec3) -> Vec3 {
    normalize(a).unwrap_or_default()
}
/// Returns the angle between two vectors, in [0, pi]; 0 if one of them is zero. Accurate to
/// rounding also near 0 and pi.
pub fn angle(a: Vec3, b: Vec3) -> f64 {
    norm(cross(a, b)).atan2(dot(a, b))
}
