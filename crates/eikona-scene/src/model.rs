//! What a scene says, whichever grammar it is written in. Plain data: the meshes are not read yet.

use super::implicit::Barrier;
use eikona_mesh::{MeshError, TriangleMesh, shapes};
use serde::{Deserialize, Serialize, Serializer};
use std::path::{Path, PathBuf};

/// The number of a line in the scene file, from 1.
pub type Line = usize;

/// A value with the line that gives it, for messages of whoever uses it. Serialised, it is the
/// value alone: comments may be added to a scene whose run is resumed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct OnLine<T> {
    /// The line.
    #[serde(skip)]
    pub line: Line,
    /// The value.
    pub value: T,
}

impl<T> OnLine<T> {
    /// Converts the value.
    pub fn map<U>(self, convert: impl FnOnce(T) -> U) -> OnLine<U> {
        OnLine { line: self.line, value: convert(self.value) }
    }
}

/// Serialises whether there is a line.
fn is_given<S: Serializer>(line: &Option<Line>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_bool(line.is_some())
}

/// A scene. What is `None` or empty is not in the file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scene {
    /// The scene file.
    pub file: PathBuf,
    /// The surfaces that move, joined in this order into one. At least one.
    pub surfaces: Vec<OnLine<Surface>>,
    /// The exponents alpha and beta of the energy, in the range that it allows. Default: 6 and 12.
    pub exponents: [f64; 2],
    /// What keeps its value, or changes it in a given way.
    pub constraints: Constraints,
    /// Terms that are added to the energy, each at most once.
    pub terms: Vec<OnLine<Term>>,
    /// Obstacles that are given by files, or as shapes.
    pub obstacles: Vec<OnLine<Obstacle>>,
    /// Obstacles and attractors that are given by formulas.
    pub barriers: Vec<OnLine<Barrier>>,
    /// The descent method.
    pub method: Option<OnLine<Method>>,
    /// The line that drops the low-order term of the inner product. (The authors' program calls it
    /// `disable_near_field`, but the energy keeps all its pairs.)
    #[serde(serialize_with = "is_given")]
    pub low_order_off: Option<Line>,
    /// How the energy of two faces is integrated.
    pub quadrature: Option<OnLine<Quadrature>>,
    /// When to stop.
    pub stop: Stop,
    /// A log file, relative to the scene's folder.
    pub log: Option<OnLine<PathBuf>>,
    /// Whether and how triangles are remeshed.
    pub remeshing: Option<OnLine<Remeshing>>,
    /// Whether steps are shortened before collisions.
    pub collisions: Option<OnLine<bool>>,
    /// What is written, and how often.
    pub output: Output,
    /// The seed of all that is random.
    pub seed: Option<OnLine<u64>>,
}

impl Scene {
    /// Returns a scene without content.
    pub fn new(file: &Path) -> Scene {
        Scene {
            file: file.to_path_buf(),
            surfaces: Vec::new(),
            exponents: [6.0, 12.0],
            constraints: Constraints::default(),
            terms: Vec::new(),
            obstacles: Vec::new(),
            barriers: Vec::new(),
            method: None,
            low_order_off: None,
            quadrature: None,
            stop: Stop::default(),
            log: None,
            remeshing: None,
            collisions: None,
            output: Output::default(),
            seed: None,
        }
    }

    /// Returns the path that a file has from where the command runs.
    pub fn beside(&self, name: &str) -> PathBuf {
        self.file.parent().unwrap_or(Path::new("")).join(name)
    }

    /// Returns the path of a file that has to exist.
    pub fn existing(&self, name: &str) -> Result<PathBuf, String> {
        let path = self.beside(name);
        let folder = "paths are relative to the scene's folder";
        if path.is_file() {
            Ok(path)
        } else if path.is_dir() {
            Err(format!("{} is a folder; name a file ({folder})", path.display()))
        } else {
            Err(format!("there is no file {}; check the name ({folder})", path.display()))
        }
    }
}

/// A surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Surface {
    /// Where it comes from.
    pub source: Source,
    /// The factor by which it is scaled about the origin.
    pub scale: f64,
    /// The vector that it is moved by after that.
    pub offset: [f64; 3],
}

/// Where a surface comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// A mesh file. It existed when the scene was read.
    File(PathBuf),
    /// A shape with parameters, as `eikona make` takes them. It could be made when the scene was
    /// read.
    Shape {
        /// The name of the shape.
        name: String,
        /// Names and values of parameters.
        parameters: Vec<(String, String)>,
    },
}

impl Source {
    /// Makes the shape. `None` for a file.
    pub fn shape(&self) -> Option<Result<TriangleMesh, MeshError>> {
        match self {
            Source::File(_) => None,
            Source::Shape { name, parameters } => {
                let values: Vec<(&str, &str)> =
                    parameters.iter().map(|(name, value)| (name.as_str(), value.as_str())).collect();
                Some(shapes::make(name, &values))
            }
        }
    }
}

/// What keeps its value, or changes it in a given way.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Constraints {
    /// The barycentre. `None`: it is not constrained.
    pub barycentre: Option<OnLine<Barycentre>>,
    /// The total area.
    pub area: Option<OnLine<Target>>,
    /// The enclosed volume.
    pub volume: Option<OnLine<Target>>,
    /// Pinned vertices, each at most once.
    pub pins: Vec<OnLine<Pin>>,
    /// The line that pins all vertices of the boundary.
    #[serde(serialize_with = "is_given")]
    pub boundary_vertices: Option<Line>,
    /// The line that keeps the normals along the boundary.
    #[serde(serialize_with = "is_given")]
    pub boundary_normals: Option<Line>,
}

/// How the barycentre is constrained.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Barycentre {
    /// It stays where it is.
    Kept,
    /// The directions of descent keep it, but the surface as a whole may drift.
    Floating,
}

/// The value that an area or a volume has to have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Target {
    /// That of the start.
    Constant,
    /// One that changes with the steps.
    Growth(Growth),
}

/// A target that changes by the same amount at each of `steps` steps, and then stays.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Growth {
    /// The value at the end.
    pub goal: Goal,
    /// The number of steps, at least 1.
    pub steps: u64,
}

/// The value of a growing target at the end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Goal {
    /// `times` the value at the start, and `plus` on top.
    Start {
        /// The multiplier, above 0. Below 1 the quantity shrinks.
        times: f64,
        /// The addition.
        plus: f64,
    },
    /// `times` the volume of the scene's only mesh obstacle.
    Obstacle {
        /// The multiplier, above 0.
        times: f64,
    },
}

/// A vertex that stays in its place, or moves in a given way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pin {
    /// The vertex, from 0 in the order of the file (`v` line 1 of an OBJ file is vertex 0), as in
    /// the authors' program; through all surfaces if several are joined.
    pub vertex: u32,
    /// Where it moves to.
    pub motion: Option<Motion>,
}

/// The straight motion of a pin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Motion {
    /// The displacement at the end.
    pub offset: [f64; 3],
    /// The number of steps that it takes, at least 1.
    pub steps: u64,
}

/// A term that is added to the energy.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Term {
    /// What is measured.
    pub quantity: Quantity,
    /// The factor. Default: 1.
    pub weight: f64,
    /// The value that the quantity should have. In the authors' program only the boundary length
    /// has one, by default 0.
    pub target: Option<f64>,
}

/// What a term measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// The squared distance of the vertices from where they start.
    SquaredError,
    /// The total area.
    Area,
    /// The enclosed volume.
    Volume,
    /// The change of the area since the start.
    AreaDeviation,
    /// The change of the volume since the start.
    VolumeDeviation,
    /// The length of the boundary.
    BoundaryLength,
    /// The curvature of the boundary.
    BoundaryCurvature,
    /// The Willmore energy.
    Willmore,
}

impl Quantity {
    /// All of them, in the order of [`NAMES`](Self::NAMES).
    pub const ALL: [Quantity; 8] = [
        Quantity::SquaredError,
        Quantity::Area,
        Quantity::Volume,
        Quantity::AreaDeviation,
        Quantity::VolumeDeviation,
        Quantity::BoundaryLength,
        Quantity::BoundaryCurvature,
        Quantity::Willmore,
    ];
    /// Their names in both grammars.
    pub const NAMES: [&'static str; 8] = [
        "squared_error",
        "area",
        "volume",
        "area_deviation",
        "volume_deviation",
        "boundary_length",
        "boundary_curvature",
        "willmore",
    ];

    /// Its name in both grammars.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }
}

/// An obstacle that does not move.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Obstacle {
    /// What it is.
    pub shape: ObstacleShape,
    /// The factor of its energy, 0 or more. Default: 1.
    pub weight: f64,
}

/// What an obstacle is.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ObstacleShape {
    /// A surface.
    Mesh {
        /// The surface.
        surface: Surface,
        /// Whether its barycentre is moved to the origin.
        centred: bool,
    },
    /// The vertices of a surface, which share one weight.
    Points {
        /// The surface.
        surface: Surface,
        /// Whether their mean is moved to the origin.
        centred: bool,
    },
    /// A grid of signed distances in an NPZ file.
    Grid {
        /// The file.
        file: PathBuf,
    },
}

/// A descent method.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Method {
    /// Steepest descent in the fractional inner product.
    #[serde(rename = "hs")]
    Hs,
    /// Accelerated quadratic proxy.
    #[serde(rename = "aqp")]
    Aqp,
    /// Blended quasi-Newton.
    #[serde(rename = "bqn")]
    Bqn,
    /// Steepest descent in H1.
    #[serde(rename = "h1")]
    H1,
    /// L-BFGS that starts from H1.
    #[serde(rename = "h1-lbfgs")]
    H1Lbfgs,
    /// Steepest descent in H2.
    #[serde(rename = "h2")]
    H2,
    /// Steepest descent of the Willmore energy, instead of the tangent-point energy, in H2.
    #[serde(rename = "willmore")]
    Willmore,
    /// Steepest descent in L2.
    #[serde(rename = "l2")]
    L2,
}

/// How the energy of two faces is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Quadrature {
    /// By the midpoint rule, as in the paper.
    Midpoint,
    /// Faces are subdivided where they are close to each other.
    Adaptive,
}

impl Method {
    /// All of them, in the order of [`NAMES`](Self::NAMES).
    pub const ALL: [Method; 8] = [
        Method::Hs,
        Method::Aqp,
        Method::Bqn,
        Method::H1,
        Method::H1Lbfgs,
        Method::H2,
        Method::Willmore,
        Method::L2,
    ];
    /// Their names in both grammars.
    pub const NAMES: [&'static str; 8] = ["hs", "aqp", "bqn", "h1", "h1-lbfgs", "h2", "willmore", "l2"];
}

/// When to stop: as soon as one of these is reached.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Stop {
    /// After so many steps, at least 1.
    pub steps: Option<OnLine<u64>>,
    /// At this energy or below.
    pub energy: Option<OnLine<f64>>,
    /// After so many seconds, above 0.
    pub seconds: Option<OnLine<f64>>,
}

/// Whether and how triangles are remeshed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Remeshing {
    /// The triangles stay as they are.
    Off,
    /// They are remeshed during the flow.
    On {
        /// The length that edges should have, above 0. `None`: their mean at the start.
        edge_length: Option<f64>,
        /// Whether edges are shorter where the surface is curved.
        adaptive: bool,
    },
}

/// What is written, and how often.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Output {
    /// A frame after every so many steps, at least 1.
    pub frames_every: Option<OnLine<u64>>,
    /// A checkpoint after every so many steps, at least 1.
    pub checkpoint_every: Option<OnLine<u64>>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn names_are_those_of_the_values() {
        for (quantity, name) in Quantity::ALL.into_iter().zip(Quantity::NAMES) {
            assert_eq!((json!(quantity), quantity.name()), (json!(name), name));
        }
        for (method, name) in Method::ALL.into_iter().zip(Method::NAMES) {
            assert_eq!(json!(method), json!(name));
        }
    }

    #[test]
    fn shapes_are_made_as_by_the_command() {
        let shape = |name: &str, value: &str| {
            let parameters = vec![("frequency".to_string(), value.to_string())];
            Source::Shape { name: name.into(), parameters }.shape().unwrap()
        };
        assert_eq!(shape("geodesic_sphere", "3").unwrap().face_count(), 180);
        assert!(shape("geodesic_sphere", "-3").is_err());
        assert!(Source::File("a.obj".into()).shape().is_none());
    }
}
