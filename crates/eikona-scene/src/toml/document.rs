//! The keys of the document.

use super::values::{AboveZero, Count, Finite, SurfaceEntry, Surfaces, Switch, ZeroOrMore};
use crate::implicit::{Action, Cylinder, Plane, Sphere, Torus};
use crate::model::{Method, Quadrature, Quantity};
use serde::Deserialize;
use toml::Spanned;

/// The top level.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Document {
    /// What moves.
    pub mesh: Option<Spanned<Surfaces>>,
    /// The exponent p: alpha = p, beta = 2 p.
    pub p: Option<Spanned<f64>>,
    /// The exponent alpha.
    pub alpha: Option<Spanned<f64>>,
    /// The exponent beta. Default: 2 alpha.
    pub beta: Option<Spanned<f64>>,
    /// The descent method.
    pub method: Option<Spanned<Method>>,
    /// Whether the inner product has its low-order term.
    pub low_order: Option<Spanned<bool>>,
    /// How the energy of two faces is integrated.
    pub quadrature: Option<Spanned<Quadrature>>,
    /// Whether steps are shortened before collisions.
    pub collisions: Option<Spanned<bool>>,
    /// A log file.
    pub log: Option<Spanned<String>>,
    /// The seed of all that is random.
    pub seed: Option<Spanned<u64>>,
    /// The constraints.
    pub keep: Option<Keep>,
    /// Pinned vertices.
    #[serde(default)]
    pub pin: Vec<Spanned<PinEntry>>,
    /// Terms that are added to the energy.
    #[serde(default, alias = "minimize")]
    pub minimise: Vec<Spanned<TermEntry>>,
    /// Obstacles.
    #[serde(default)]
    pub obstacle: Vec<Spanned<ObstacleEntry>>,
    /// Obstacles and attractors given by formulas.
    #[serde(default)]
    pub implicit: Vec<Spanned<ImplicitEntry>>,
    /// When to stop.
    #[serde(default)]
    pub stop: StopTable,
    /// Whether and how triangles are remeshed.
    pub remesh: Option<Spanned<Switch<RemeshTable>>>,
    /// What is written, and how often.
    #[serde(default)]
    pub output: OutputTable,
}

/// `[keep]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Keep {
    /// The barycentre. Default: true.
    #[serde(alias = "barycenter")]
    pub barycentre: Option<Spanned<Switch<Floating>>>,
    /// The area. Default: false.
    pub area: Option<Spanned<Switch<GrowthTable>>>,
    /// The volume. Default: false.
    pub volume: Option<Spanned<Switch<GrowthTable>>>,
    /// Whether all vertices of the boundary are pinned.
    pub boundary_vertices: Option<Spanned<bool>>,
    /// Whether the normals along the boundary are kept.
    pub boundary_normals: Option<Spanned<bool>>,
}

/// The word of a barycentre that may drift.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Floating {
    /// See [`Barycentre::Floating`](crate::model::Barycentre::Floating).
    Floating,
}

/// A growing target.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "true, false, or a table such as { times = 2, steps = 200 }")]
pub struct GrowthTable {
    /// The multiplier. Default: 1.
    pub times: Option<AboveZero>,
    /// The addition. Default: 0.
    pub plus: Option<Finite>,
    /// What the multiplier multiplies.
    #[serde(default)]
    pub of: GoalOf,
    /// The number of steps that the growth takes.
    pub steps: Count,
}

/// What a growing target is a multiple of.
#[derive(Clone, Copy, Default, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
pub enum GoalOf {
    /// Its value at the start.
    #[default]
    Start,
    /// The volume of the obstacle.
    Obstacle,
}

/// An element of `[[pin]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table such as { vertices = [0, 1] }")]
pub struct PinEntry {
    /// The vertices, from 0.
    pub vertices: Vec<u32>,
    /// The displacement at the end.
    #[serde(rename = "move")]
    pub offset: Option<[Finite; 3]>,
    /// The number of steps that the motion takes.
    pub steps: Option<Count>,
}

/// An element of `[[minimise]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table such as { term = \"willmore\", weight = 1 }")]
pub struct TermEntry {
    /// What is measured.
    pub term: Quantity,
    /// The factor. Default: 1.
    pub weight: Option<Finite>,
    /// The value that it should have.
    pub target: Option<Finite>,
}

/// An element of `[[obstacle]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table such as { mesh = \"box.obj\", weight = 0.1 }")]
pub struct ObstacleEntry {
    /// A surface.
    pub mesh: Option<Spanned<SurfaceEntry>>,
    /// A file or shape whose vertices are the obstacle.
    pub points: Option<Spanned<SurfaceEntry>>,
    /// An NPZ file of signed distances.
    pub grid: Option<Spanned<String>>,
    /// The factor. Default: 1.
    pub weight: Option<ZeroOrMore>,
    /// Whether it is moved to the origin.
    #[serde(alias = "centered")]
    pub centred: Option<Spanned<bool>>,
}

/// An element of `[[implicit]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table such as { sphere = { radius = 1, centre = [0, 0, 0] } }")]
pub struct ImplicitEntry {
    /// A sphere.
    pub sphere: Option<Sphere>,
    /// A cylinder.
    pub cylinder: Option<Cylinder>,
    /// A torus.
    pub torus: Option<Torus>,
    /// A plane.
    pub plane: Option<Plane>,
    /// Whether it repels or attracts.
    pub action: Action,
    /// The power of the distance.
    pub power: AboveZero,
    /// The factor.
    pub weight: ZeroOrMore,
}

/// `[stop]`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StopTable {
    /// After so many steps.
    pub steps: Option<Spanned<Count>>,
    /// At this energy or below.
    pub energy: Option<Spanned<ZeroOrMore>>,
    /// After so many seconds.
    pub seconds: Option<Spanned<AboveZero>>,
}

/// `[remesh]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "true, false, or a table such as { edge = 0.1 }")]
pub struct RemeshTable {
    /// The length that edges should have. Default: their mean at the start.
    pub edge: Option<AboveZero>,
    /// Whether edges are shorter where the surface is curved.
    #[serde(default)]
    pub adaptive: bool,
}

/// `[output]`.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutputTable {
    /// A frame after every so many steps.
    pub frames_every: Option<Spanned<Count>>,
    /// A checkpoint after every so many steps.
    pub checkpoint_every: Option<Spanned<Count>>,
}
