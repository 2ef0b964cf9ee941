//! The flow that a scene describes: its surface and the options.

use super::attributes::Attributes;
use crate::exit::Failure;
use crate::input::{MeshArguments, MeshInput};
use crate::numpy::NpzReader;
use crate::session::Session;
use eikona::repulsive::{
    Barycentre, Exponents, FlowOptions, Growth, ImplicitSurface, Pin, Potential, Quadrature, Quantity,
    Remeshing, RepulsiveError, SampledDistance,
};
use eikona_mesh::{TriangleMesh, Vertex};
use eikona_scene::Scene;
use eikona_scene::implicit::{self, Action, Barrier};
use eikona_scene::model::{self, Goal, ObstacleShape, OnLine, Source, Surface, Target, Term};
use std::collections::BTreeSet;
use std::path::Path;

/// Reads the meshes of a scene, and returns the surface, its data, and the options.
pub fn flow_of(
    scene: &Scene,
    session: &mut Session,
) -> Result<(TriangleMesh, Attributes, FlowOptions), Failure> {
    let (mut parts, mut data) = (Vec::new(), Vec::new());
    for surface in &scene.surfaces {
        let (part, attributes) = part_of(&surface.value, session)?;
        data.push((attributes, part.vertex_count(), part.face_count()));
        parts.push(part);
    }
    let mesh = joined(&parts)?;
    let attributes = Attributes::joined(data, session);
    let [alpha, beta] = scene.exponents;
    let mut options =
        FlowOptions::default().with_exponents(Exponents::new(alpha, beta)?).with_keep(Vec::new());
    options.barycentre = match scene.constraints.barycentre.map(|b| b.value) {
        Some(model::Barycentre::Kept) => Barycentre::Kept,
        Some(model::Barycentre::Floating) | None => Barycentre::Free,
    };
    options.quadrature = scene.quadrature.map(|quadrature| match quadrature.value {
        model::Quadrature::Midpoint => Quadrature::Midpoint,
        model::Quadrature::Adaptive => Quadrature::adaptive(),
    });
    options.collisions = scene.collisions.is_none_or(|c| c.value);
    options.metric.low_order = scene.low_order_off.is_none();
    options.remeshing = match scene.remeshing.map(|r| r.value) {
        Some(model::Remeshing::Off) => Remeshing::Off,
        Some(model::Remeshing::On { edge_length, adaptive: true }) => {
            Remeshing::Adaptive { length: edge_length }
        }
        Some(model::Remeshing::On { edge_length, adaptive: false }) => {
            Remeshing::Uniform { length: edge_length }
        }
        None => Remeshing::Uniform { length: None },
    };
    if let Some(method) = &scene.method {
        let of_name = model::Method::NAMES[method.value as usize].parse();
        options.method = of_name.map_err(|fault| at_line(scene, method.line, fault))?;
    }
    let mut obstacles = Vec::new();
    add_obstacles(scene, session, &mut options, &mut obstacles)?;
    add_terms(scene, &mesh, &mut options)?;
    add_quantities(scene, &obstacles, &mut options);
    add_pins(scene, &mesh, &mut options)?;
    options.obstacle = if obstacles.is_empty() { None } else { Some(joined(&obstacles)?) };
    if let Some(log) = &scene.log {
        session.note(&format!("line {}: the log is log.csv in the output folder", log.line));
    }
    Ok((mesh, attributes, options))
}

fn at_line(scene: &Scene, line: usize, fault: impl std::fmt::Display) -> Failure {
    Failure::Input(format!("{}: line {line}: {fault}", scene.file.display()))
}

fn read(path: &Path, session: &mut Session) -> Result<MeshInput, Failure> {
    let arguments = MeshArguments {
        mesh: path.to_path_buf(),
        in_format: None,
        weld: None,
        drop_degenerate: false,
        stitch: None,
        all_faults: false,
    };
    MeshInput::read(&arguments, session)
}

fn mesh_of(surface: &Surface, session: &mut Session) -> Result<TriangleMesh, Failure> {
    part_of(surface, session).map(|(mesh, _)| mesh)
}

/// A mesh of the scene with its data; shapes have none.
fn part_of(surface: &Surface, session: &mut Session) -> Result<(TriangleMesh, Attributes), Failure> {
    let (mesh, attributes) = match &surface.source {
        Source::File(path) => {
            let input = read(path, session)?;
            let attributes = Attributes::of(&input, session);
            (input.mesh, attributes)
        }
        shape @ Source::Shape { .. } => {
            let mesh = shape.shape().unwrap_or_else(|| TriangleMesh::new(vec![], vec![]))?;
            (mesh, Attributes::default())
        }
    };
    let scaled = mesh.positions().iter().map(|p| p.map(|x| surface.scale * x)).collect();
    Ok((moved(&mesh.with_positions(scaled)?, surface.offset)?, attributes))
}

fn moved(mesh: &TriangleMesh, offset: [f64; 3]) -> Result<TriangleMesh, Failure> {
    let positions = mesh.positions().iter().map(|p| [0, 1, 2].map(|k| p[k] + offset[k])).collect();
    Ok(mesh.with_positions(positions)?)
}

fn joined(parts: &[TriangleMesh]) -> Result<TriangleMesh, Failure> {
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    for part in parts {
        let shift = positions.len() as u32;
        positions.extend_from_slice(part.positions());
        faces.extend(part.triangles().iter().map(|corners| corners.map(|v| v + shift)));
    }
    Ok(TriangleMesh::new(positions, faces)?)
}

/// The mean of points, with weights.
fn mean(points: impl Iterator<Item = ([f64; 3], f64)>) -> [f64; 3] {
    let mut sum = [0.0; 4];
    for (p, weight) in points {
        (0..3).for_each(|k| sum[k] += weight * p[k]);
        sum[3] += weight;
    }
    [0, 1, 2].map(|k| if sum[3] > 0.0 { sum[k] / sum[3] } else { 0.0 })
}

fn add_obstacles(
    scene: &Scene,
    session: &mut Session,
    options: &mut FlowOptions,
    meshes: &mut Vec<TriangleMesh>,
) -> Result<(), Failure> {
    let power = options.exponents.alpha;
    for OnLine { line, value } in &scene.obstacles {
        let refuse = |fault: RepulsiveError| at_line(scene, *line, fault);
        let potential = match &value.shape {
            ObstacleShape::Mesh { surface, centred } => {
                let mut mesh = mesh_of(surface, session)?;
                if *centred {
                    mesh = centred_at_origin(&mesh)?;
                }
                let potential = Potential::obstacle(value.weight, &mesh, power).map_err(refuse)?;
                meshes.push(mesh);
                potential
            }
            ObstacleShape::Points { surface, centred } => {
                let mut points = mesh_of(surface, session)?.positions().to_vec();
                if *centred {
                    let centre = mean(points.iter().map(|p| (*p, 1.0)));
                    points.iter_mut().for_each(|p| (0..3).for_each(|k| p[k] -= centre[k]));
                }
                Potential::point_obstacle(value.weight, &points, power).map_err(refuse)?
            }
            ObstacleShape::Grid { file } => {
                let grid = read_grid(file).map_err(|fault| at_line(scene, *line, fault))?;
                Potential::repel_from(value.weight, ImplicitSurface::Grid(grid), power)
            }
        };
        if value.weight != 0.0 {
            options.potentials.push(potential);
        }
    }
    for barrier in &scene.barriers {
        options.potentials.push(potential_of(&barrier.value));
    }
    Ok(())
}

/// Moves the barycentre of a surface to the origin.
fn centred_at_origin(mesh: &TriangleMesh) -> Result<TriangleMesh, Failure> {
    let area = |f| {
        let [a, b, c] = mesh.face_positions(f);
        let (s, t) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
        let normal = [0, 1, 2].map(|k| s[(k + 1) % 3] * t[(k + 2) % 3] - s[(k + 2) % 3] * t[(k + 1) % 3]);
        let middle = [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) / 3.0);
        (middle, normal.iter().map(|x| x * x).sum::<f64>().sqrt())
    };
    moved(mesh, mean(mesh.faces().map(area)).map(|x| -x))
}

/// Reads `distance`, `origin` and `spacing`.
fn read_grid(path: &Path) -> Result<SampledDistance, String> {
    let named = |fault: String| format!("{}: {fault}", path.display());
    let bytes = std::fs::read(path).map_err(|fault| named(fault.to_string()))?;
    let mut npz = NpzReader::new(&bytes).map_err(named)?;
    let distance = npz.array("distance", &[None, None, None]).map_err(named)?;
    let three = |array: crate::numpy::Array| [array.values[0], array.values[1], array.values[2]];
    let origin = three(npz.array("origin", &[Some(3)]).map_err(named)?);
    let spacing = three(npz.array("spacing", &[Some(3)]).map_err(named)?);
    let shape = [distance.shape[0], distance.shape[1], distance.shape[2]];
    SampledDistance::new(origin, spacing, shape, distance.values).map_err(|fault| named(fault.to_string()))
}

fn potential_of(barrier: &Barrier) -> Potential {
    let surface = match barrier.surface {
        implicit::ImplicitSurface::Sphere(s) => {
            ImplicitSurface::Sphere { centre: s.centre, radius: s.radius }
        }
        implicit::ImplicitSurface::Cylinder(c) => {
            ImplicitSurface::Cylinder { point: c.centre, axis: c.axis, radius: c.radius }
        }
        implicit::ImplicitSurface::Torus(t) => {
            ImplicitSurface::Torus { centre: t.centre, axis: [0.0, 1.0, 0.0], major: t.major, minor: t.minor }
        }
        implicit::ImplicitSurface::Plane(p) => ImplicitSurface::Plane { point: p.point, normal: p.normal },
    };
    match barrier.action {
        Action::Repel => Potential::repel_from(barrier.weight, surface, barrier.power),
        Action::Attract => Potential::attract_to(barrier.weight, surface, barrier.power),
    }
}

fn add_terms(scene: &Scene, mesh: &TriangleMesh, options: &mut FlowOptions) -> Result<(), Failure> {
    for OnLine { line, value } in &scene.terms {
        let &Term { quantity, weight, target } = value;
        let made = match (quantity, target) {
            (model::Quantity::BoundaryLength, target) => {
                Ok(Potential::boundary_length(weight, target.unwrap_or(0.0)))
            }
            (model::Quantity::AreaDeviation, None) => Potential::area_deviation(weight, mesh),
            (model::Quantity::VolumeDeviation, None) => Potential::volume_deviation(weight, mesh),
            (_, Some(_)) => {
                let fault = format!("{} takes no target; only boundary_length does", quantity.name());
                return Err(at_line(scene, *line, fault));
            }
            (model::Quantity::SquaredError, None) => Potential::start_distance(weight, mesh),
            (model::Quantity::Area, None) => Ok(Potential::area(weight)),
            (model::Quantity::Volume, None) => Ok(Potential::volume(weight)),
            (model::Quantity::BoundaryCurvature, None) => Ok(Potential::boundary_curvature(weight)),
            (model::Quantity::Willmore, None) => Ok(Potential::willmore(weight)),
        };
        let potential = made.map_err(|fault| at_line(scene, *line, fault))?;
        potential.value(mesh).map_err(|fault| at_line(scene, *line, fault))?;
        options.potentials.push(potential);
    }
    Ok(())
}

fn add_quantities(scene: &Scene, obstacles: &[TriangleMesh], options: &mut FlowOptions) {
    let given = [(Quantity::Area, scene.constraints.area), (Quantity::Volume, scene.constraints.volume)];
    for (quantity, target) in given {
        match target.map(|target| target.value) {
            None => {}
            Some(Target::Constant) => options.keep.push(quantity),
            Some(Target::Growth(model::Growth { goal, steps })) => {
                let (times, plus) = match goal {
                    Goal::Start { times, plus } => (times, plus),
                    Goal::Obstacle { times } => {
                        let volume = obstacles.iter().map(|o| Quantity::Volume.of(o).abs()).sum::<f64>();
                        (0.0, times * volume)
                    }
                };
                options.growth.push(Growth { quantity, times, plus, steps });
            }
        }
    }
}

fn add_pins(scene: &Scene, mesh: &TriangleMesh, options: &mut FlowOptions) -> Result<(), Failure> {
    let constraints = &scene.constraints;
    let mut still: BTreeSet<u32> = BTreeSet::new();
    if constraints.boundary_vertices.is_some() {
        still.extend(mesh.vertices().filter(|v| mesh.is_boundary_vertex(*v)).map(|v| v.0));
    }
    if constraints.boundary_normals.is_some() {
        // The normals of the faces along the boundary.
        let boundary = mesh.edges().filter(|e| mesh.is_boundary_edge(*e));
        let faces = boundary.map(|e| mesh.edge_halfedges(e)[0].face());
        still.extend(faces.flat_map(|f| mesh.face_vertices(f)).map(|v| v.0));
    }
    for OnLine { line, value } in &constraints.pins {
        let count = mesh.vertex_count();
        if value.vertex as usize >= count {
            let fault = format!("vertex {} is pinned, but the surface has {count} vertices", value.vertex);
            return Err(at_line(scene, *line, fault));
        }
        still.remove(&value.vertex);
        let vertex = Vertex(value.vertex);
        options.pins.push(match value.motion {
            Some(motion) => Pin { vertex, motion: motion.offset, steps: motion.steps },
            None => Pin::still(vertex),
        });
    }
    options.pins.extend(still.into_iter().map(|v| Pin::still(Vertex(v))));
    Ok(())
}
