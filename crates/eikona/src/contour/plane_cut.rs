//! Cuts of a mesh by a plane, or by a wavy surface about a plane.

use super::ContourError;
use super::isolines::isolines;
use crate::geometry::vector::{Vec3, cross, dot, normalize, sub};
use eikona_mesh::{Curve, TriangleMesh};

/// Cuts the mesh by a plane. The curves are signed, and closed or ending at the boundary, with one
/// segment per face.
///
/// The side of the plane to which `normal` points is on the right of each curve. Vertices exactly
/// on the plane count as on the normal's side, so the cut of faces that lie in the plane is their
/// boundary towards the other side.
///
/// # Errors
/// [`ContourError::BadPlane`] if the point or the normal is not finite, or the normal is zero.
///
/// # Cost
/// O(F).
pub fn plane_cut(mesh: &TriangleMesh, point: [f64; 3], normal: [f64; 3]) -> Result<Vec<Curve>, ContourError> {
    let unit = checked_plane(point, normal)?;
    cut(mesh, |p| dot(sub(p, point), unit))
}

/// Wave of a cut about its plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// Largest distance from the plane, in the mesh's unit.
    pub amplitude: f64,
    /// Number of periods in one turn about the normal through the point.
    pub count: u32,
}

/// Cuts the mesh as [`plane_cut`] does, by a surface that deviates from the plane by `amplitude`
/// sin(`count` angle), where the angle turns about the normal through the point.
///
/// # Errors
/// Those of [`plane_cut`]; [`ContourError::Parameter`] if the amplitude is not finite.
pub fn wavy_plane_cut(
    mesh: &TriangleMesh,
    point: [f64; 3],
    normal: [f64; 3],
    wave: Wave,
) -> Result<Vec<Curve>, ContourError> {
    let unit = checked_plane(point, normal)?;
    if !wave.amplitude.is_finite() {
        let bound = "it must be finite";
        return Err(ContourError::Parameter { name: "amplitude", value: wave.amplitude, bound });
    }
    // Any two directions that span the plane work: start from the axis farthest from the normal.
    let farthest = (0..3).fold(0, |a, b| if unit[b].abs() < unit[a].abs() { b } else { a });
    let axis: Vec3 = [0, 1, 2].map(|k| if k == farthest { 1.0 } else { 0.0 });
    let across =
        normalize(cross(unit, axis)).ok_or(ContourError::BadPlane { name: "normal", value: normal })?;
    let along = cross(across, unit);
    cut(mesh, |p| {
        let from_point = sub(p, point);
        let angle = dot(from_point, across).atan2(dot(from_point, along));
        dot(from_point, unit) - wave.amplitude * (f64::from(wave.count) * angle).sin()
    })
}

fn checked_plane(point: Vec3, normal: Vec3) -> Result<Vec3, ContourError> {
    let unit = normalize(normal).ok_or(ContourError::BadPlane { name: "normal", value: normal })?;
    if !point.iter().all(|x| x.is_finite()) {
        return Err(ContourError::BadPlane { name: "point", value: point });
    }
    Ok(unit)
}

fn cut(mesh: &TriangleMesh, height: impl Fn(Vec3) -> f64) -> Result<Vec<Curve>, ContourError> {
    let heights: Vec<f64> = mesh.positions().iter().map(|&p| height(p)).collect();
    Ok(isolines(mesh, &heights.into(), &[0.0])?.pop().map_or_else(Vec::new, |l| l.curves))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contour::polylines;
    use eikona_mesh::shapes;

    #[test]
    fn a_wavy_cut_of_a_cylinder_follows_the_wave() {
        let mesh = shapes::cylinder(0.5, 2.0, 200, 200, shapes::Ends::Open).unwrap();
        let wave = Wave { amplitude: 0.2, count: 3 };
        let curves = wavy_plane_cut(&mesh, [0.0, 0.0, 1.0], [0.0, 0.0, 2.0], wave).unwrap();
        assert_eq!(curves.len(), 1);
        assert!(curves[0].is_closed());
        let heights: Vec<f64> = polylines(&mesh, &curves).unwrap()[0].iter().map(|p| p[2] - 1.0).collect();
        let (low, high) = heights.iter().fold((0.0f64, 0.0f64), |(l, h), &z| (l.min(z), h.max(z)));
        assert!((low + 0.2).abs() < 1e-3 && (high - 0.2).abs() < 1e-3, "{low} {high}");
        let ups = heights.windows(2).filter(|z| z[0] < 0.0 && z[1] >= 0.0).count();
        assert_eq!(ups, 3);
        let flat = wavy_plane_cut(&mesh, [0.0, 0.0, 1.0], [0.0, 0.0, 2.0], Wave { amplitude: 0.0, count: 3 });
        assert_eq!(flat.unwrap(), plane_cut(&mesh, [0.0, 0.0, 1.0], [0.0, 0.0, 2.0]).unwrap());
    }
}
