//! The grammar of the authors' program (repulsive-surfaces, `scenes/FORMAT.txt`, and what its
//! reader accepts beyond that): a statement per line, words separated by blanks.

use super::faults::{Faults, once, shown, unknown};
use super::implicit::{Action, Barrier, ImplicitSurface};
use super::model::{
    Barycentre, Goal, Growth, Line, Method, Motion, Obstacle, ObstacleShape, OnLine, Pin, Quantity, Scene,
    Source, Surface, Target, Term,
};
use crate::number::{above_zero, finite, zero_or_more};
use eikona::repulsive::Exponents;
use std::path::Path;

/// The first words of lines.
const STATEMENTS: [&str; 13] = [
    "repel_mesh",
    "constrain",
    "minimize",
    "obstacle",
    "point_cloud_obstacle",
    "implicit",
    "iteration_limit",
    "time_limit",
    "allow_barycenter_shift",
    "disable_near_field",
    "method",
    "log",
    "autotarget_volume",
];

/// What can be constrained.
const CONSTRAINTS: [&str; 6] =
    ["barycenter", "area", "volume", "vertices", "boundary_vertices", "boundary_normals"];

/// Returns whether the first line that is no comment begins with a statement.
pub fn starts_like_a_scene(text: &str) -> bool {
    let mut words = text.lines().filter_map(|line| line.split_whitespace().next());
    words.find(|word| !word.starts_with('#')).is_some_and(|word| STATEMENTS.contains(&word))
}

/// Reads a scene, with all faults of its lines.
pub fn read(text: &str, path: &Path) -> (Scene, Faults) {
    let mut reader = Reader { scene: Scene::new(path), shift: None, ratio: None };
    let mut faults = Faults::default();
    let mut mesh_named = false;
    for (line, words) in (1..).zip(text.lines().map(|line| line.split_whitespace().collect::<Vec<_>>())) {
        let Some((&first, values)) = words.split_first() else { continue };
        if first.starts_with('#') {
            continue;
        }
        mesh_named |= first == "repel_mesh";
        faults.take(line, reader.statement(&Statement { line, first, values }));
    }
    if !mesh_named {
        faults.add(None, "no line says what to move; add `repel_mesh FILE ALPHA BETA`");
    }
    reader.finish(&mut faults);
    (reader.scene, faults)
}

/// A line with its words.
struct Statement<'a> {
    line: Line,
    first: &'a str,
    values: &'a [&'a str],
}

impl Statement<'_> {
    /// Checks the number of words after `what`. `form` shows what they mean.
    fn count(&self, what: &str, form: &str, values: &[&str], allowed: &[usize]) -> Result<(), String> {
        let given = values.len();
        if allowed.contains(&given) {
            return Ok(());
        }
        let expected = match allowed {
            [0] => "no values".to_string(),
            [1] => "1 value".to_string(),
            [number] => format!("{number} values"),
            [] => "values".to_string(),
            [first @ .., last] => {
                let first: Vec<String> = first.iter().map(usize::to_string).collect();
                format!("{} or {last} values", first.join(", "))
            }
        };
        // A comment at the end of a line counts as values.
        let comment = match values.iter().any(|word| word.starts_with('#')) {
            true => "; a comment needs a line of its own",
            false => "",
        };
        let meaning = if form.is_empty() { String::new() } else { format!(" ({form})") };
        Err(format!("`{what}` takes {expected}{meaning}, but has {given}{comment}"))
    }
}

/// A scene so far, with the two statements that change what another one says.
struct Reader {
    scene: Scene,
    /// The line of `allow_barycenter_shift`.
    shift: Option<Line>,
    /// `autotarget_volume`.
    ratio: Option<OnLine<f64>>,
}

impl Reader {
    fn statement(&mut self, s: &Statement) -> Result<(), String> {
        match s.first {
            "repel_mesh" => self.mesh(s),
            "constrain" => self.constraint(s),
            "minimize" => self.term(s),
            "obstacle" | "point_cloud_obstacle" => self.obstacle(s),
            "implicit" => self.barrier(s),
            "iteration_limit" => self.iteration_limit(s),
            "time_limit" => self.time_limit(s),
            "allow_barycenter_shift" => flag(&mut self.shift, s),
            "disable_near_field" => flag(&mut self.scene.low_order_off, s),
            "method" => self.method(s),
            "log" => self.log(s),
            "autotarget_volume" => self.autotarget(s),
            other => Err(unknown("word", other, &STATEMENTS)),
        }
    }

    fn mesh(&mut self, s: &Statement) -> Result<(), String> {
        once(self.scene.surfaces.first().map(|mesh| mesh.line), s.line, s.first)?;
        s.count(s.first, "FILE [ALPHA BETA]", s.values, &[1, 3])?;
        let exponents = match s.values {
            [_, alpha, beta] => Some((value("alpha", alpha, finite)?, value("beta", beta, finite)?)),
            _ => None,
        };
        let file = self.scene.beside(s.values[0]);
        // Kept even if it is missing, so that a second mesh is still recognised as one.
        let surface = Surface { source: Source::File(file), scale: 1.0, offset: [0.0; 3] };
        self.scene.surfaces.push(OnLine { line: s.line, value: surface });
        if let Some((alpha, beta)) = exponents {
            Exponents::new(alpha, beta).map_err(|fault| fault.to_string())?;
            self.scene.exponents = [alpha, beta];
        }
        self.scene.existing(s.values[0]).map(drop)
    }

    fn constraint(&mut self, s: &Statement) -> Result<(), String> {
        let Some((&kind, values)) = s.values.split_first() else {
            return Err(format!("`constrain` says nothing to constrain; add {}", CONSTRAINTS.join(", ")));
        };
        let what = format!("constrain {kind}");
        let constraints = &mut self.scene.constraints;
        match kind {
            "barycenter" => {
                s.count(&what, "", values, &[0])?;
                once(constraints.barycentre.map(|b| b.line), s.line, &what)?;
                constraints.barycentre = Some(OnLine { line: s.line, value: Barycentre::Kept });
            }
            "area" | "volume" => {
                let target = target(s, &what, values)?;
                let slot = if kind == "area" { &mut constraints.area } else { &mut constraints.volume };
                once(slot.map(|slot| slot.line), s.line, &what)?;
                *slot = Some(OnLine { line: s.line, value: target });
            }
            "vertices" | "vertex" => constraints.pins.extend(pins(s, &what, values)?),
            "boundary_vertices" => {
                s.count(&what, "", values, &[0])?;
                once(constraints.boundary_vertices.replace(s.line), s.line, &what)?;
            }
            "boundary_normals" => {
                s.count(&what, "", values, &[0])?;
                once(constraints.boundary_normals.replace(s.line), s.line, &what)?;
            }
            "normals" | "normal" => {
                return Err(format!(
                    "`{what}` is not supported (the authors' program warns and ignores it); remove the line, \
                     or keep the normals along the boundary with `constrain boundary_normals`"
                ));
            }
            other => return Err(unknown("constraint", other, &CONSTRAINTS)),
        }
        Ok(())
    }

    fn term(&mut self, s: &Statement) -> Result<(), String> {
        s.count(s.first, "TERM [WEIGHT [TARGET]]", s.values, &[1, 2, 3])?;
        let quantity = named("term", s.values[0], &Quantity::NAMES, &Quantity::ALL)?;
        let weight = s.values.get(1).map_or(Ok(1.0), |text| value("the weight", text, finite))?;
        let target = s.values.get(2).map(|text| value("the target", text, finite)).transpose()?;
        self.scene.terms.push(OnLine { line: s.line, value: Term { quantity, weight, target } });
        Ok(())
    }

    fn obstacle(&mut self, s: &Statement) -> Result<(), String> {
        s.count(s.first, "FILE [WEIGHT [centered]]", s.values, &[1, 2, 3])?;
        let weight = s.values.get(1).map_or(Ok(1.0), |text| value("the weight", text, zero_or_more))?;
        let centred = match s.values.get(2) {
            None => false,
            Some(&"centered") => true,
            Some(other) => return Err(unknown("option of an obstacle", other, &["centered"])),
        };
        let source = Source::File(self.scene.beside(s.values[0]));
        let surface = Surface { source, scale: 1.0, offset: [0.0; 3] };
        let shape = match s.first {
            "obstacle" => ObstacleShape::Mesh { surface, centred },
            _ => ObstacleShape::Points { surface, centred },
        };
        self.scene.obstacles.push(OnLine { line: s.line, value: Obstacle { shape, weight } });
        self.scene.existing(s.values[0]).map(drop)
    }

    fn barrier(&mut self, s: &Statement) -> Result<(), String> {
        let Some(&name) = s.values.first() else {
            let names = ImplicitSurface::NAMES.join(", ");
            return Err(format!("`implicit` names no surface; the choices are {names}"));
        };
        if !ImplicitSurface::NAMES.contains(&name) {
            return Err(unknown("implicit surface", name, &ImplicitSurface::NAMES));
        }
        let parameters = ImplicitSurface::parameters(name);
        let form = format!("repel|attract POWER WEIGHT {parameters}");
        let expected = form.split_whitespace().count();
        s.count(&format!("implicit {name}"), &form, &s.values[1..], &[expected])?;
        let action = named("action", s.values[1], &["repel", "attract"], &[Action::Repel, Action::Attract])?;
        let power = value("the power", s.values[2], above_zero)?;
        let weight = value("the weight", s.values[3], zero_or_more)?;
        let mut numbers = Vec::new();
        for (name, text) in parameters.split_whitespace().zip(&s.values[4..]) {
            numbers.push(value(name, text, finite)?);
        }
        let surface = ImplicitSurface::of_parameters(name, &numbers)
            .ok_or_else(|| format!("`implicit {name}` takes the parameters {parameters}"))?;
        surface.check()?;
        self.scene.barriers.push(OnLine { line: s.line, value: Barrier { surface, action, power, weight } });
        Ok(())
    }

    fn iteration_limit(&mut self, s: &Statement) -> Result<(), String> {
        s.count(s.first, "ITERATIONS", s.values, &[1])?;
        let steps = value("the limit", s.values[0], count)?;
        once(self.scene.stop.steps.map(|steps| steps.line), s.line, s.first)?;
        self.scene.stop.steps = Some(OnLine { line: s.line, value: steps });
        Ok(())
    }

    fn time_limit(&mut self, s: &Statement) -> Result<(), String> {
        s.count(s.first, "MILLISECONDS", s.values, &[1])?;
        let milliseconds = value("the limit", s.values[0], count)?;
        once(self.scene.stop.seconds.map(|seconds| seconds.line), s.line, s.first)?;
        self.scene.stop.seconds = Some(OnLine { line: s.line, value: milliseconds as f64 / 1e3 });
        Ok(())
    }

    fn method(&mut self, s: &Statement) -> Result<(), String> {
        s.count(s.first, "NAME", s.values, &[1])?;
        let method = named("method", s.values[0], &Method::NAMES, &Method::ALL)?;
        once(self.scene.method.map(|method| method.line), s.line, s.first)?;
        self.scene.method = Some(OnLine { line: s.line, value: method });
        Ok(())
    }

    fn log(&mut self, s: &Statement) -> Result<(), String> {
        s.count(s.first, "FILE", s.values, &[1])?;
        once(self.scene.log.as_ref().map(|log| log.line), s.line, s.first)?;
        self.scene.log = Some(OnLine { line: s.line, value: self.scene.beside(s.values[0]) });
        Ok(())
    }

    fn autotarget(&mut self, s: &Statement) -> Result<(), String> {
        s.count(s.first, "[RATIO]", s.values, &[0, 1])?;
        let ratio = s.values.first().map_or(Ok(1.0), |text| value("the ratio", text, above_zero))?;
        once(self.ratio.map(|ratio| ratio.line), s.line, s.first)?;
        self.ratio = Some(OnLine { line: s.line, value: ratio });
        Ok(())
    }

    /// Applies the statements that change what another one says.
    fn finish(&mut self, faults: &mut Faults) {
        let constraints = &mut self.scene.constraints;
        if let (Some(_), Some(barycentre)) = (self.shift, &mut constraints.barycentre) {
            barycentre.value = Barycentre::Floating;
        }
        let Some(OnLine { line, value: times }) = self.ratio else { return };
        match constraints.volume {
            Some(OnLine { value: Target::Growth(Growth { steps, .. }), .. }) => {
                let growth = Growth { goal: Goal::Obstacle { times }, steps };
                constraints.volume = Some(OnLine { line, value: Target::Growth(growth) });
            }
            Some(volume) => faults.add(
                line,
                format!(
                    "`autotarget_volume` sets where a growth ends, but line {} keeps the volume constant; \
                     write there `constrain volume 1 STEPS`",
                    volume.line
                ),
            ),
            // Unless the line that constrains it is at fault.
            None if !faults.is_empty() => {}
            None => faults.add(
                line,
                "`autotarget_volume` sets where a growth ends, but the volume is not constrained; add \
                 `constrain volume 1 STEPS`",
            ),
        }
    }
}

/// Sets a flag, which takes no values.
fn flag(slot: &mut Option<Line>, s: &Statement) -> Result<(), String> {
    s.count(s.first, "", s.values, &[0])?;
    once(slot.replace(s.line), s.line, s.first)
}

/// Reads a constant or growing target.
fn target(s: &Statement, what: &str, values: &[&str]) -> Result<Target, String> {
    s.count(what, "[MULTIPLIER STEPS [ADDITION]]", values, &[0, 2, 3])?;
    let [times, steps, rest @ ..] = values else { return Ok(Target::Constant) };
    let times = value("the growth multiplier", times, above_zero)?;
    let steps = value("the number of growth iterations", steps, count)?;
    let plus = rest.first().map_or(Ok(0.0), |text| value("the growth addition", text, finite))?;
    Ok(Target::Growth(Growth { goal: Goal::Start { times, plus }, steps }))
}

/// Reads the vertices of a pin, and where they move to.
fn pins(s: &Statement, what: &str, values: &[&str]) -> Result<Vec<OnLine<Pin>>, String> {
    let end = values.iter().position(|word| *word == "move").unwrap_or(values.len());
    let (vertices, motion) = values.split_at(end);
    if vertices.is_empty() {
        return Err(format!("`{what}` names no vertex; add their numbers, from 0"));
    }
    let motion = match motion {
        [] => None,
        [_, motion @ ..] => {
            s.count("move", "DX DY DZ ITERATIONS", motion, &[4])?;
            let mut offset = [0.0; 3];
            for (name, (x, text)) in ["DX", "DY", "DZ"].into_iter().zip(offset.iter_mut().zip(motion)) {
                *x = value(name, text, finite)?;
            }
            let steps = value("the number of iterations", motion[3], count)?;
            Some(Motion { offset, steps })
        }
    };
    let pin = |text: &&str| {
        let vertex = value("the vertex", text, index)?;
        Ok(OnLine { line: s.line, value: Pin { vertex, motion } })
    };
    vertices.iter().map(pin).collect()
}

/// Parses a value, with its name in the message.
fn value<T>(name: &str, text: &str, parse: impl Fn(&str) -> Result<T, String>) -> Result<T, String> {
    parse(text).map_err(|expected| format!("{name} is `{}`: {expected}", shown(text)))
}

/// Parses a number of steps.
fn count(text: &str) -> Result<u64, String> {
    text.parse().ok().filter(|n| *n > 0).ok_or("expected a whole number of 1 or more".into())
}

/// Parses the number of a vertex.
fn index(text: &str) -> Result<u32, String> {
    text.parse().map_err(|_| "expected the number of a vertex, a whole number of 0 or more".into())
}

/// Returns the value of a name.
fn named<T: Copy>(what: &str, text: &str, names: &[&str], values: &[T]) -> Result<T, String> {
    let found = names.iter().zip(values).find(|(name, _)| **name == text);
    found.map(|(_, value)| *value).ok_or_else(|| unknown(what, text, names))
}
