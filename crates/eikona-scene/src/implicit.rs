//! Obstacles and attractors that are given by formulas.

use serde::{Deserialize, Serialize};

/// An obstacle or attractor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Barrier {
    /// The surface from which distances d are measured.
    pub surface: ImplicitSurface,
    /// Whether it repels or attracts.
    pub action: Action,
    /// The power q of the potential, above 0: `d^-q` of an obstacle, `d^q` of an attractor.
    pub power: f64,
    /// The factor of the potential, 0 or more.
    pub weight: f64,
}

/// Whether a surface repels or attracts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Action {
    /// It is an obstacle.
    Repel,
    /// It is an attractor.
    Attract,
}

/// A surface given by a formula.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ImplicitSurface {
    /// A sphere.
    Sphere(Sphere),
    /// A cylinder without end.
    Cylinder(Cylinder),
    /// A torus.
    Torus(Torus),
    /// A plane.
    Plane(Plane),
}

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table such as { radius = 1, centre = [0, 0, 0] }")]
pub struct Sphere {
    /// The radius, above 0.
    pub radius: f64,
    /// The centre.
    #[serde(alias = "center")]
    pub centre: [f64; 3],
}

/// A cylinder without end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    deny_unknown_fields,
    expecting = "a table such as { radius = 1, centre = [0, 0, 0], axis = [0, 0, 1] }"
)]
pub struct Cylinder {
    /// The radius, above 0.
    pub radius: f64,
    /// A point on the axis.
    #[serde(alias = "center")]
    pub centre: [f64; 3],
    /// The direction of the axis, of any length above 0.
    pub axis: [f64; 3],
}

/// A torus about an axis parallel to y, as in the authors' program.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table such as { major = 1, minor = 0.2, centre = [0, 0, 0] }")]
pub struct Torus {
    /// The radius of the circle that the tube follows, above 0.
    pub major: f64,
    /// The radius of the tube, above 0.
    pub minor: f64,
    /// The centre.
    #[serde(alias = "center")]
    pub centre: [f64; 3],
}

/// A plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table such as { point = [0, 0, 0], normal = [0, 0, 1] }")]
pub struct Plane {
    /// A point of it.
    pub point: [f64; 3],
    /// The direction of its normal, of any length above 0.
    pub normal: [f64; 3],
}

impl ImplicitSurface {
    /// The names in both grammars.
    pub const NAMES: [&'static str; 4] = ["sphere", "cylinder", "torus", "plane"];

    /// Returns the parameters of a surface in the original grammar. The name is one of
    /// [`NAMES`](Self::NAMES).
    pub fn parameters(name: &str) -> &'static str {
        match name {
            "sphere" => "RADIUS CX CY CZ",
            "cylinder" => "RADIUS CX CY CZ AX AY AZ",
            "torus" => "MAJOR MINOR CX CY CZ",
            _ => "PX PY PZ NX NY NZ",
        }
    }

    /// Returns the surface with these parameters in the order of the original grammar. `None` if
    /// their number is not that of [`parameters`](Self::parameters).
    pub fn of_parameters(name: &str, values: &[f64]) -> Option<ImplicitSurface> {
        Some(match (name, values) {
            ("sphere", &[radius, x, y, z]) => ImplicitSurface::Sphere(Sphere { radius, centre: [x, y, z] }),
            ("cylinder", &[radius, x, y, z, a, b, c]) => {
                ImplicitSurface::Cylinder(Cylinder { radius, centre: [x, y, z], axis: [a, b, c] })
            }
            ("torus", &[major, minor, x, y, z]) => {
                ImplicitSurface::Torus(Torus { major, minor, centre: [x, y, z] })
            }
            ("plane", &[x, y, z, a, b, c]) => {
                ImplicitSurface::Plane(Plane { point: [x, y, z], normal: [a, b, c] })
            }
            _ => return None,
        })
    }

    /// Checks that all numbers are finite, and that radii and directions are not zero.
    pub fn check(&self) -> Result<(), String> {
        match *self {
            ImplicitSurface::Sphere(Sphere { radius, centre }) => {
                length("radius", radius)?;
                point("centre", centre)
            }
            ImplicitSurface::Cylinder(Cylinder { radius, centre, axis }) => {
                length("radius", radius)?;
                point("centre", centre)?;
                direction("axis", axis)
            }
            ImplicitSurface::Torus(Torus { major, minor, centre }) => {
                length("major radius", major)?;
                length("minor radius", minor)?;
                point("centre", centre)
            }
            ImplicitSurface::Plane(Plane { point: of, normal }) => {
                point("point", of)?;
                direction("normal", normal)
            }
        }
    }
}

fn length(name: &str, x: f64) -> Result<(), String> {
    let fine = x > 0.0 && x.is_finite();
    fine.then_some(()).ok_or_else(|| format!("the {name} is {x}; expected a number above 0"))
}

fn point(name: &str, x: [f64; 3]) -> Result<(), String> {
    let fine = x.iter().all(|x| x.is_finite());
    fine.then_some(()).ok_or_else(|| format!("the {name} is {x:?}; expected three finite numbers"))
}

fn direction(name: &str, x: [f64; 3]) -> Result<(), String> {
    point(name, x)?;
    let fine = x.iter().any(|x| *x != 0.0);
    fine.then_some(()).ok_or_else(|| format!("the {name} is {x:?}, which has no direction"))
}
