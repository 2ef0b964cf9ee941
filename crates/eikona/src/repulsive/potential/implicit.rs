//! Surfaces given by a signed distance, which repel or attract (RS section 7.3.3).

use super::sampled_distance::SampledDistance;
use super::surface::{Vec3, add_faces, dual_areas, face_shapes};
use crate::geometry::vector::{add, dot, norm, normalize, scale, sub, unit};
use crate::repulsive::error::RepulsiveError;
use eikona_mesh::{ElementId, TriangleMesh, Vertex};

/// A surface given by its signed distance, negative inside.
///
/// ```
/// use eikona::repulsive::ImplicitSurface;
/// let ball = ImplicitSurface::Sphere { centre: [0.0; 3], radius: 2.0 };
/// assert_eq!(ball.distance([0.0, 0.5, 0.0])?, (-1.5, [0.0, 1.0, 0.0]));
/// # Ok::<(), eikona::repulsive::RepulsiveError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ImplicitSurface {
    /// A sphere.
    Sphere {
        /// Its centre.
        centre: [f64; 3],
        /// Its radius, positive.
        radius: f64,
    },
    /// A plane. The distance is positive on the side to which the normal points.
    Plane {
        /// A point of it.
        point: [f64; 3],
        /// Its normal, of any length but zero.
        normal: [f64; 3],
    },
    /// A cylinder without ends.
    Cylinder {
        /// A point of its axis.
        point: [f64; 3],
        /// The direction of its axis, of any length but zero.
        axis: [f64; 3],
        /// Its radius, positive.
        radius: f64,
    },
    /// A torus.
    Torus {
        /// Its centre.
        centre: [f64; 3],
        /// The direction of its axis, of any length but zero.
        axis: [f64; 3],
        /// The radius of the circle in its middle, positive.
        major: f64,
        /// The radius of the tube, positive.
        minor: f64,
    },
    /// Any surface, by samples of its signed distance.
    Grid(SampledDistance),
}

impl ImplicitSurface {
    /// Returns the signed distance of a point and its gradient. The gradient is zero where the
    /// distance has none: at the centre of a sphere, on the axis of a cylinder, on the axis and the
    /// middle circle of a torus.
    ///
    /// # Errors
    /// [`RepulsiveError::ImplicitShape`] if a radius is not positive, a direction zero, or a number
    /// not finite, of the point too.
    ///
    /// ```
    /// use eikona::repulsive::ImplicitSurface;
    /// let torus = ImplicitSurface::Torus {
    ///     centre: [0.0; 3],
    ///     axis: [0.0, 1.0, 0.0],
    ///     major: 2.0,
    ///     minor: 0.5,
    /// };
    /// assert_eq!(torus.distance([0.0, 1.0, 2.0])?, (0.5, [0.0, 1.0, 0.0]));
    /// # Ok::<(), eikona::repulsive::RepulsiveError>(())
    /// ```
    pub fn distance(&self, point: [f64; 3]) -> Result<(f64, [f64; 3]), RepulsiveError> {
        check_point("the point", point)?;
        Ok(self.checked()?.at(point))
    }

    /// Returns a torus about the y axis, like those of the published program.
    ///
    /// ```
    /// use eikona::repulsive::ImplicitSurface;
    /// let torus = ImplicitSurface::torus([0.0; 3], 2.0, 0.5);
    /// assert_eq!(torus.distance([3.0, 0.0, 0.0])?, (0.5, [1.0, 0.0, 0.0]));
    /// # Ok::<(), eikona::repulsive::RepulsiveError>(())
    /// ```
    pub fn torus(centre: [f64; 3], major: f64, minor: f64) -> ImplicitSurface {
        ImplicitSurface::Torus { centre, axis: [0.0, 1.0, 0.0], major, minor }
    }

    /// Checks the numbers, and makes directions unit vectors.
    fn checked(&self) -> Result<ImplicitSurface, RepulsiveError> {
        let result = match *self {
            ImplicitSurface::Sphere { centre, radius } => {
                check_point("the centre of a sphere", centre)?;
                check_radius("the radius of a sphere", radius)?;
                ImplicitSurface::Sphere { centre, radius }
            }
            ImplicitSurface::Plane { point, normal } => {
                check_point("the point of a plane", point)?;
                let normal = direction("the length of the normal of a plane", normal)?;
                ImplicitSurface::Plane { point, normal }
            }
            ImplicitSurface::Cylinder { point, axis, radius } => {
                check_point("the point of a cylinder", point)?;
                check_radius("the radius of a cylinder", radius)?;
                let axis = direction("the length of the axis of a cylinder", axis)?;
                ImplicitSurface::Cylinder { point, axis, radius }
            }
            ImplicitSurface::Torus { centre, axis, major, minor } => {
                check_point("the centre of a torus", centre)?;
                check_radius("the major radius of a torus", major)?;
                check_radius("the minor radius of a torus", minor)?;
                let axis = direction("the length of the axis of a torus", axis)?;
                ImplicitSurface::Torus { centre, axis, major, minor }
            }
            ImplicitSurface::Grid(ref samples) => ImplicitSurface::Grid(samples.clone()),
        };
        Ok(result)
    }

    /// The distance and its gradient; directions are unit vectors.
    fn at(&self, x: Vec3) -> (f64, Vec3) {
        match *self {
            ImplicitSurface::Sphere { centre, radius } => {
                let v = sub(x, centre);
                (norm(v) - radius, unit(v))
            }
            ImplicitSurface::Plane { point, normal } => (dot(sub(x, point), normal), normal),
            ImplicitSurface::Cylinder { point, axis, radius } => {
                let (_, across) = split(sub(x, point), axis);
                (norm(across) - radius, unit(across))
            }
            ImplicitSurface::Torus { centre, axis, major, minor } => {
                let (along, across) = split(sub(x, centre), axis);
                // In the half plane through the axis and the point.
                let outwards = unit(across);
                let [p, q] = [norm(across) - major, along];
                let away = p.hypot(q);
                let gradient = add(scale(outwards, p), scale(axis, q));
                (away - minor, if away > 0.0 { scale(gradient, 1.0 / away) } else { [0.0; 3] })
            }
            ImplicitSurface::Grid(ref samples) => samples.at(x),
        }
    }
}

/// The part of a vector along a unit vector, and the vector across it.
fn split(v: Vec3, axis: Vec3) -> (f64, Vec3) {
    let along = dot(v, axis);
    (along, sub(v, scale(axis, along)))
}

fn check_point(what: &'static str, point: Vec3) -> Result<(), RepulsiveError> {
    let bad = point.iter().find(|x| !x.is_finite());
    bad.map_or(Ok(()), |&value| Err(RepulsiveError::ImplicitShape { what, value }))
}

fn check_radius(what: &'static str, value: f64) -> Result<(), RepulsiveError> {
    let fine = value > 0.0 && value.is_finite();
    if fine { Ok(()) } else { Err(RepulsiveError::ImplicitShape { what, value }) }
}

fn direction(what: &'static str, vector: Vec3) -> Result<Vec3, RepulsiveError> {
    normalize(vector).ok_or(RepulsiveError::ImplicitShape { what, value: norm(vector) })
}

/// What an implicit surface does, and with which power of the distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Action {
    pub attract: bool,
    pub power: f64,
}

impl Action {
    /// # Errors
    /// [`RepulsiveError::PotentialExponent`].
    fn check(self) -> Result<(), RepulsiveError> {
        let Action { attract, power: exponent } = self;
        // Powers below 1 attract with infinite force.
        let (least, fine) = if attract { (1.0, exponent >= 1.0) } else { (0.0, exponent > 0.0) };
        let fine = fine && exponent.is_finite();
        if fine { Ok(()) } else { Err(RepulsiveError::PotentialExponent { exponent, least }) }
    }

    /// The potential at a distance, and its derivative by it.
    fn at(self, distance: f64) -> (f64, f64) {
        let power = if self.attract { self.power } else { -self.power };
        let size = distance.abs();
        // Where the surface attracts, the potential is lowest and its derivative zero; for the
        // power 1 it has a kink.
        let slope = if distance == 0.0 { 0.0 } else { power * size.powf(power - 1.0) };
        (size.powf(power), slope.copysign(power * distance))
    }
}

/// Adds to each vertex its share of the second derivative of the integral, in the direction of the
/// surface.
pub(super) fn add_stiffness(
    mesh: &TriangleMesh,
    surface: &ImplicitSurface,
    action: Action,
    sums: &mut [f64],
) -> Result<(), RepulsiveError> {
    action.check()?;
    let surface = surface.checked()?;
    let areas = dual_areas(mesh, &face_shapes(mesh)?);
    for ((sum, area), x) in sums.iter_mut().zip(areas).zip(mesh.positions()) {
        let power = if action.attract { action.power } else { -action.power };
        let second = power * (power - 1.0) * surface.at(*x).0.abs().powf(power - 2.0);
        *sum += area * if second.is_finite() { second } else { 0.0 };
    }
    Ok(())
}

/// Returns the potential at each vertex and its gradient, zero at vertices without faces.
fn at_vertices(
    mesh: &TriangleMesh,
    areas: &[f64],
    surface: &ImplicitSurface,
    action: Action,
) -> Result<Vec<(f64, Vec3)>, RepulsiveError> {
    action.check()?;
    let surface = surface.checked()?;
    let at = |(v, (&position, &area)): (usize, (&Vec3, &f64))| {
        if area == 0.0 {
            return Ok((0.0, [0.0; 3]));
        }
        let (distance, gradient) = surface.at(position);
        let (value, slope) = action.at(distance);
        let finite = value.is_finite() && slope.is_finite();
        match (finite, action.attract) {
            (true, _) => Ok((value, scale(gradient, slope))),
            (false, true) => {
                Err(RepulsiveError::PotentialRange { potential: "the potential of an attractor" })
            }
            (false, false) => Err(RepulsiveError::VertexOnObstacle { vertex: Vertex::from_index(v) }),
        }
    };
    mesh.positions().iter().zip(areas).enumerate().map(at).collect()
}

/// Returns the integral of the potential over the surface, with dual areas as weights.
pub(super) fn value(
    mesh: &TriangleMesh,
    surface: &ImplicitSurface,
    action: Action,
) -> Result<f64, RepulsiveError> {
    let areas = dual_areas(mesh, &face_shapes(mesh)?);
    let potentials = at_vertices(mesh, &areas, surface, action)?;
    Ok(areas.iter().zip(potentials).map(|(area, (value, _))| area * value).sum())
}

pub(super) fn differential(
    mesh: &TriangleMesh,
    surface: &ImplicitSurface,
    action: Action,
) -> Result<Vec<Vec3>, RepulsiveError> {
    let shapes = face_shapes(mesh)?;
    let areas = dual_areas(mesh, &shapes);
    let potentials = at_vertices(mesh, &areas, surface, action)?;
    let own = |(&area, &(_, gradient)): (&f64, &(f64, Vec3))| scale(gradient, area);
    let mut result: Vec<Vec3> = areas.iter().zip(&potentials).map(own).collect();
    add_faces(mesh, &shapes, &mut result, |_, corners, shape| {
        let mean = corners.iter().map(|&v| potentials[v].0).sum::<f64>() / 3.0;
        shape.area_gradient().map(|by_area| scale(by_area, mean))
    });
    Ok(result)
}
