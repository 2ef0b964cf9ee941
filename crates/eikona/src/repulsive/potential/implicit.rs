//! Surfaces given by a signed distance, which repel or attract (RS section 7.3.3).

use super::sampled_distance::SampledDistance;
use super::surface::{Vec3, face_shapes};
use crate::geometry::vector::{add, dot, norm, normalize, scale, sub, unit};
use crate::repulsive::error::RepulsiveError;
use eikona_mesh::{Face, TriangleMesh};

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
    pub(super) fn checked(&self) -> Result<ImplicitSurface, RepulsiveError> {
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
    pub(super) fn at(&self, x: Vec3) -> (f64, Vec3) {
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

/// Points of a triangle and their weights, by which polynomials of degree three are integrated: the
/// corners, the middles of the sides, and the centroid.
///
/// Corners alone do not see where a face reaches through the surface: edges are chords, and their
/// middles are closest to what the surface surrounds. Remeshing puts vertices there.
const POINTS: [([f64; 3], f64); 7] = [
    ([1.0, 0.0, 0.0], 0.05),
    ([0.0, 1.0, 0.0], 0.05),
    ([0.0, 0.0, 1.0], 0.05),
    ([0.0, 0.5, 0.5], 2.0 / 15.0),
    ([0.5, 0.0, 0.5], 2.0 / 15.0),
    ([0.5, 0.5, 0.0], 2.0 / 15.0),
    ([1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0], 0.45),
];

fn point_at(corners: [Vec3; 3], [a, b, c]: [f64; 3]) -> Vec3 {
    add(scale(corners[0], a), add(scale(corners[1], b), scale(corners[2], c)))
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
    let power = if action.attract { action.power } else { -action.power };
    let second = |x: Vec3| {
        let second = power * (power - 1.0) * surface.at(x).0.abs().powf(power - 2.0);
        if second.is_finite() { second } else { 0.0 }
    };
    for ((f, corners), shape) in mesh.faces().zip(mesh.triangles()).zip(face_shapes(mesh)?) {
        for (shares, weight) in POINTS {
            let own = shape.area * weight * second(point_at(mesh.face_positions(f), shares));
            corners.iter().zip(shares).for_each(|(v, share)| sums[*v as usize] += share * own);
        }
    }
    Ok(())
}

/// A potential of an implicit surface, checked.
struct Field {
    surface: ImplicitSurface,
    action: Action,
}

impl Field {
    /// # Errors
    /// [`RepulsiveError::PotentialExponent`], [`RepulsiveError::ImplicitShape`].
    fn new(surface: &ImplicitSurface, action: Action) -> Result<Field, RepulsiveError> {
        action.check()?;
        Ok(Field { surface: surface.checked()?, action })
    }

    /// The potential and its gradient at the points of a face.
    ///
    /// # Errors
    /// [`RepulsiveError::FaceOnObstacle`], [`RepulsiveError::PotentialRange`].
    fn on_face(
        &self,
        mesh: &TriangleMesh,
        face: Face,
    ) -> Result<[(f64, Vec3); POINTS.len()], RepulsiveError> {
        let corners = mesh.face_positions(face);
        let values = POINTS.map(|(shares, _)| {
            let (distance, gradient) = self.surface.at(point_at(corners, shares));
            let (value, slope) = self.action.at(distance);
            (value, scale(gradient, slope))
        });
        let finite = values
            .iter()
            .all(|(value, gradient)| value.is_finite() && gradient.iter().all(|x| x.is_finite()));
        match (finite, self.action.attract) {
            (true, _) => Ok(values),
            (false, true) => {
                Err(RepulsiveError::PotentialRange { potential: "the potential of an attractor" })
            }
            (false, false) => Err(RepulsiveError::FaceOnObstacle { face }),
        }
    }
}

/// The mean of the potential over a face.
fn mean(values: &[(f64, Vec3); POINTS.len()]) -> f64 {
    POINTS.iter().zip(values).map(|((_, weight), (value, _))| weight * value).sum()
}

/// Returns the integral of the potential over the surface.
pub(super) fn value(
    mesh: &TriangleMesh,
    surface: &ImplicitSurface,
    action: Action,
) -> Result<f64, RepulsiveError> {
    let field = Field::new(surface, action)?;
    let shapes = face_shapes(mesh)?;
    mesh.faces()
        .zip(shapes)
        .try_fold(0.0, |sum, (f, shape)| Ok(sum + shape.area * mean(&field.on_face(mesh, f)?)))
}

pub(super) fn differential(
    mesh: &TriangleMesh,
    surface: &ImplicitSurface,
    action: Action,
) -> Result<Vec<Vec3>, RepulsiveError> {
    let field = Field::new(surface, action)?;
    let mut result = vec![[0.0; 3]; mesh.vertex_count()];
    for ((f, corners), shape) in mesh.faces().zip(mesh.triangles()).zip(face_shapes(mesh)?) {
        let values = field.on_face(mesh, f)?;
        let mean = mean(&values);
        let mut own = shape.area_gradient().map(|by_area| scale(by_area, mean));
        for ((shares, weight), (_, gradient)) in POINTS.iter().zip(values) {
            let force = scale(gradient, shape.area * weight);
            (0..3).for_each(|k| own[k] = add(own[k], scale(force, shares[k])));
        }
        corners.iter().zip(own).for_each(|(v, own)| result[*v as usize] = add(result[*v as usize], own));
    }
    Ok(result)
}
