//! Turns the document into the scene.

use super::document::{
    Document, Floating, GoalOf, GrowthTable, ImplicitEntry, Keep, ObstacleEntry, OutputTable, PinEntry,
    RemeshTable, StopTable, TermEntry,
};
use super::tree::Lines;
use super::values::{Finite, SurfaceEntry, Surfaces, Switch};
use crate::faults::{Faults, unknown};
use crate::implicit::{Barrier, ImplicitSurface};
use crate::model::{
    Barycentre, Constraints, Goal, Growth, Line, Motion, Obstacle, ObstacleShape, OnLine, Output, Pin,
    Remeshing, Scene, Source, Stop, Surface, Target, Term,
};
use eikona::repulsive::Exponents;
use eikona_mesh::shapes::{shape_descriptions, shape_names};
use toml::Spanned;

/// Fills the scene, and adds what is wrong with single entries.
pub fn fill(scene: &mut Scene, document: Document, lines: &Lines, faults: &mut Faults) {
    exponents(scene, &document, lines, faults);
    if let Some(mesh) = document.mesh {
        surfaces(scene, mesh, lines, faults);
    }
    scene.method = document.method.map(|method| lined(lines, method));
    scene.low_order_off =
        document.low_order.filter(|on| !on.get_ref()).map(|low_order| lines.of_value(&low_order));
    scene.quadrature = document.quadrature.map(|quadrature| lined(lines, quadrature));
    scene.collisions = document.collisions.map(|on| lined(lines, on));
    scene.seed = document.seed.map(|seed| lined(lines, seed));
    scene.log = document.log.map(|log| lined(lines, log).map(|name| scene.beside(&name)));
    scene.constraints = constraints(document.keep, lines, faults);
    scene.remeshing = document.remesh.map(|remesh| lined(lines, remesh).map(remeshing));
    scene.stop = stop(document.stop, lines);
    scene.output = output(document.output, lines);
    scene.terms = document.minimise.into_iter().map(|entry| lined(lines, entry).map(term)).collect();
    for entry in document.pin {
        let OnLine { line, value } = lined(lines, entry);
        let pins = faults.take(line, pins(line, value));
        scene.constraints.pins.extend(pins.into_iter().flatten());
    }
    for entry in document.obstacle {
        let OnLine { line, value } = lined(lines, entry);
        if let Some(value) = obstacle(scene, line, value, lines, faults) {
            scene.obstacles.push(OnLine { line, value });
        }
    }
    for entry in document.implicit {
        let OnLine { line, value } = lined(lines, entry);
        if let Some(value) = faults.take(line, barrier(value)) {
            scene.barriers.push(OnLine { line, value });
        }
    }
}

fn lined<T>(lines: &Lines, value: Spanned<T>) -> OnLine<T> {
    OnLine { line: lines.of_value(&value), value: value.into_inner() }
}

/// Reads `p`, or `alpha` and `beta`.
fn exponents(scene: &mut Scene, document: &Document, lines: &Lines, faults: &mut Faults) {
    let line = |value: &Option<Spanned<f64>>| value.as_ref().map_or(0, |value| lines.of_value(value));
    let value = |value: &Option<Spanned<f64>>| value.as_ref().map(|value| *value.get_ref());
    let (p, alpha, beta) = (&document.p, &document.alpha, &document.beta);
    let [of_p, of_alpha, of_beta] = [p, alpha, beta].map(line);
    let (at, exponents) = match [p, alpha, beta].map(value) {
        [None, None, None] => return,
        [Some(p), None, None] => (of_p, Exponents::of_power(p)),
        [None, Some(alpha), None] => (of_alpha, Exponents::of_power(alpha)),
        [None, Some(alpha), Some(beta)] => (of_beta, Exponents::new(alpha, beta)),
        [None, None, Some(_)] => return faults.add(of_beta, "`beta` needs `alpha`; add it"),
        [Some(_), _, _] => {
            let other = of_alpha.max(of_beta);
            let twice = format!("`p` on line {of_p} and `alpha` or `beta` on line {other} say the same");
            return faults.add(of_p.max(other), format!("{twice}; keep one of them"));
        }
    };
    match exponents {
        Ok(Exponents { alpha, beta, .. }) => scene.exponents = [alpha, beta],
        Err(fault) => faults.add(at, fault.to_string()),
    }
}

fn surfaces(scene: &mut Scene, mesh: Spanned<Surfaces>, lines: &Lines, faults: &mut Faults) {
    let OnLine { line, value } = lined(lines, mesh);
    let entries = match value {
        Surfaces::One(entry) => vec![OnLine { line, value: entry }],
        Surfaces::Many(entries) if entries.is_empty() => {
            return faults.add(line, "the list of meshes is empty; name at least one");
        }
        Surfaces::Many(entries) => entries.into_iter().map(|entry| lined(lines, entry)).collect(),
    };
    for OnLine { line, value } in entries {
        if let Some(value) = surface(scene, line, value, lines, faults) {
            scene.surfaces.push(OnLine { line, value });
        }
    }
}

/// Reads a file or shape with its parameters.
fn surface(
    scene: &Scene,
    line: Line,
    entry: SurfaceEntry,
    lines: &Lines,
    faults: &mut Faults,
) -> Option<Surface> {
    let offset = numbers(entry.offset.unwrap_or([Finite(0.0); 3]));
    let scale = entry.scale.as_ref().map_or(1.0, |scale| scale.get_ref().0);
    if let Some(given) = entry.scale.as_ref().filter(|_| scale <= 0.0) {
        faults.add(lines.of_value(given), format!("`scale` is {scale}; give a number above 0"));
    }
    let source = match (entry.file, entry.shape) {
        (Some(file), None) => {
            for (name, _) in &entry.parameters {
                let known = ["file", "scale", "move"];
                faults.add(lines.of_value(name), unknown("key of a mesh file", name.get_ref(), &known));
            }
            Source::File(faults.take(line, scene.existing(&file))?)
        }
        (None, Some(shape)) => {
            let at = lines.of_value(&shape);
            let name = faults.take(at, shape_name(shape.get_ref()))?;
            let known = parameters(name, &entry.parameters, lines, faults);
            let values = entry.parameters.into_iter().map(|(key, value)| (key.into_inner(), value));
            let source = Source::Shape { name: name.into(), parameters: values.collect() };
            // Making it is the only way to learn whether the values are in range.
            if let (true, Some(Err(fault))) = (known, source.shape()) {
                faults.add(at, fault.to_string());
            }
            source
        }
        (Some(_), Some(shape)) => {
            faults.add(lines.of_value(&shape), "a mesh is a file or a shape; keep one of both");
            return None;
        }
        (None, None) => {
            faults.add(line, "a mesh is a file or a shape; add file = \"NAME\" or shape = \"NAME\"");
            return None;
        }
    };
    Some(Surface { source, scale, offset })
}

/// Returns the name of a shape as the registry has it. A hyphen counts as an underscore.
fn shape_name(name: &str) -> Result<&'static str, String> {
    let wanted = name.replace('-', "_");
    let names: Vec<&'static str> = shape_names().collect();
    let found = names.iter().find(|known| **known == wanted);
    found.copied().ok_or_else(|| unknown("shape", name, &names))
}

/// Checks the names of the parameters of a shape. Returns whether all are known.
fn parameters(shape: &str, given: &[(Spanned<String>, String)], lines: &Lines, faults: &mut Faults) -> bool {
    let mut all_known = true;
    let description = shape_descriptions().find(|description| description.name == shape);
    let known: Vec<&str> =
        description.into_iter().flat_map(|d| d.parameters).map(|parameter| parameter.name).collect();
    for (name, _) in given {
        if !known.contains(&name.get_ref().replace('-', "_").as_str()) {
            all_known = false;
            let what = format!("parameter of {shape}");
            faults.add(lines.of_value(name), unknown(&what, name.get_ref(), &known));
        }
    }
    all_known
}

/// Reads `[keep]`. Without it, the command's own default holds: the barycentre and the area.
fn constraints(keep: Option<Keep>, lines: &Lines, faults: &mut Faults) -> Constraints {
    let Some(keep) = keep else {
        // There is no line to name: the first stands for the file.
        return Constraints {
            barycentre: Some(OnLine { line: 1, value: Barycentre::Kept }),
            area: Some(OnLine { line: 1, value: Target::Constant }),
            ..Constraints::default()
        };
    };
    let flag = |on: Option<Spanned<bool>>| on.filter(|on| *on.get_ref()).map(|on| lines.of_value(&on));
    let barycentre = match keep.barycentre.map(|barycentre| lined(lines, barycentre)) {
        None => Some(OnLine { line: 1, value: Barycentre::Kept }),
        Some(OnLine { value: Switch::Plain(false), .. }) => None,
        Some(OnLine { line, value: Switch::Plain(true) }) => Some(OnLine { line, value: Barycentre::Kept }),
        Some(OnLine { line, value: Switch::With(Floating::Floating) }) => {
            Some(OnLine { line, value: Barycentre::Floating })
        }
    };
    let area = keep.area.and_then(|area| target(lined(lines, area), faults));
    if let Some(OnLine { line, value: Target::Growth(Growth { goal: Goal::Obstacle { .. }, .. }) }) = area {
        faults.add(line, "only the volume can become that of an obstacle; leave `of` out");
    }
    Constraints {
        barycentre,
        area,
        volume: keep.volume.and_then(|volume| target(lined(lines, volume), faults)),
        pins: Vec::new(),
        boundary_vertices: flag(keep.boundary_vertices),
        boundary_normals: flag(keep.boundary_normals),
    }
}

fn target(given: OnLine<Switch<GrowthTable>>, faults: &mut Faults) -> Option<OnLine<Target>> {
    let OnLine { line, value } = given;
    let growth = match value {
        Switch::Plain(false) => return None,
        Switch::Plain(true) => return Some(OnLine { line, value: Target::Constant }),
        Switch::With(growth) => growth,
    };
    let times = growth.times.map_or(1.0, |times| times.0);
    let goal = match (growth.of, growth.plus) {
        (GoalOf::Start, plus) => Goal::Start { times, plus: plus.map_or(0.0, |plus| plus.0) },
        (GoalOf::Obstacle, None) => Goal::Obstacle { times },
        (GoalOf::Obstacle, Some(_)) => {
            faults.add(line, "`plus` adds to a multiple of the start, not of an obstacle; leave it out");
            return None;
        }
    };
    Some(OnLine { line, value: Target::Growth(Growth { goal, steps: growth.steps.0 }) })
}

fn pins(line: Line, entry: PinEntry) -> Result<Vec<OnLine<Pin>>, String> {
    if entry.vertices.is_empty() {
        return Err("the list of vertices is empty; name at least one, from 0".into());
    }
    let motion = match (entry.offset, entry.steps) {
        (None, None) => None,
        (Some(offset), Some(steps)) => Some(Motion { offset: numbers(offset), steps: steps.0 }),
        (Some(_), None) => return Err("`move` needs `steps`, the number of steps it takes; add it".into()),
        (None, Some(_)) => return Err("`steps` needs `move`, the displacement [x, y, z]; add it".into()),
    };
    Ok(entry.vertices.into_iter().map(|vertex| OnLine { line, value: Pin { vertex, motion } }).collect())
}

fn term(entry: TermEntry) -> Term {
    let weight = entry.weight.map_or(1.0, |weight| weight.0);
    Term { quantity: entry.term, weight, target: entry.target.map(|target| target.0) }
}

fn obstacle(
    scene: &Scene,
    line: Line,
    entry: ObstacleEntry,
    lines: &Lines,
    faults: &mut Faults,
) -> Option<Obstacle> {
    let centring = entry.centred.as_ref().map(|centred| lines.of_value(centred));
    let centred = entry.centred.is_some_and(|centred| centred.into_inner());
    let weight = entry.weight.map_or(1.0, |weight| weight.0);
    let shape = match (entry.mesh, entry.points, entry.grid) {
        (Some(mesh), None, None) => {
            let OnLine { line, value } = lined(lines, mesh);
            let surface = surface(scene, line, value, lines, faults)?;
            ObstacleShape::Mesh { surface, centred }
        }
        (None, Some(points), None) => {
            let OnLine { line, value } = lined(lines, points);
            ObstacleShape::Points { surface: surface(scene, line, value, lines, faults)?, centred }
        }
        (None, None, Some(grid)) => {
            if let (Some(line), true) = (centring, centred) {
                faults.add(line, "a grid can not be centred; its file says where it lies");
            }
            let OnLine { line, value } = lined(lines, grid);
            ObstacleShape::Grid { file: faults.take(line, scene.existing(&value))? }
        }
        _ => {
            faults.add(line, "an obstacle has exactly one of the keys mesh, points and grid");
            return None;
        }
    };
    Some(Obstacle { shape, weight })
}

fn barrier(entry: ImplicitEntry) -> Result<Barrier, String> {
    let surfaces = [
        entry.sphere.map(ImplicitSurface::Sphere),
        entry.cylinder.map(ImplicitSurface::Cylinder),
        entry.torus.map(ImplicitSurface::Torus),
        entry.plane.map(ImplicitSurface::Plane),
    ];
    let given: Vec<ImplicitSurface> = surfaces.into_iter().flatten().collect();
    let &[surface] = given.as_slice() else {
        let names = ImplicitSurface::NAMES.join(", ");
        return Err(format!("an implicit surface has exactly one of the keys {names}"));
    };
    surface.check()?;
    Ok(Barrier { surface, action: entry.action, power: entry.power.0, weight: entry.weight.0 })
}

fn remeshing(remesh: Switch<RemeshTable>) -> Remeshing {
    match remesh {
        Switch::Plain(false) => Remeshing::Off,
        Switch::Plain(true) => Remeshing::On { edge_length: None, adaptive: false },
        Switch::With(RemeshTable { edge, adaptive }) => {
            Remeshing::On { edge_length: edge.map(|edge| edge.0), adaptive }
        }
    }
}

fn stop(stop: StopTable, lines: &Lines) -> Stop {
    Stop {
        steps: stop.steps.map(|steps| lined(lines, steps).map(|steps| steps.0)),
        energy: stop.energy.map(|energy| lined(lines, energy).map(|energy| energy.0)),
        seconds: stop.seconds.map(|seconds| lined(lines, seconds).map(|seconds| seconds.0)),
    }
}

fn output(output: OutputTable, lines: &Lines) -> Output {
    Output {
        frames_every: output.frames_every.map(|every| lined(lines, every).map(|every| every.0)),
        checkpoint_every: output.checkpoint_every.map(|every| lined(lines, every).map(|every| every.0)),
    }
}

fn numbers(x: [Finite; 3]) -> [f64; 3] {
    x.map(|x| x.0)
}
