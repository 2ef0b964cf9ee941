//! `eikona repulse`: moves a surface so that it never touches itself.

mod animation;
mod arguments;
mod attributes;
mod folder;
mod recent;
mod scene_setup;
mod setup;

pub use arguments::RepulseArguments;

use crate::exit::Failure;
use crate::picture::{PictureArguments, draw};
use crate::session::{General, Session};
use crate::warned::Warned;
use animation::write_animation;
use arguments::Until;
use attributes::Attributes;
use eikona::repulsive::{Flow, FlowStep, Quantity, Remeshing};
use eikona::spatial::self_distance;
use eikona_mesh::io::{MeshFormat, write_mesh_bytes};
use eikona_render::{Coloring, Scene};
use folder::{Row, RunFolder};
use recent::blocked_sentence;
use serde_json::{Value, json};
use setup::Setup;
use std::time::Instant;

/// Runs the command and returns the exit code.
pub fn run(arguments: &RepulseArguments, general: &General) -> Result<u8, Failure> {
    let mut session = Session::new("repulse", general);
    session.check_report()?;
    let setup = Setup::read(arguments, &mut session)?;
    session.report.options.extend(
        [("flow", setup.settings.clone()), ("threads", json!(setup.options.threads))]
            .map(|(key, value)| (key.to_string(), value)),
    );
    let mut run = Run::start(setup, arguments, &mut session)?;
    let reason = run.steps(&mut session)?;
    run.finish(reason, &mut session)?;
    session.finish()
}

/// A run that is under way.
struct Run {
    setup: Setup,
    folder: RunFolder,
    flow: Flow,
    render: bool,
    /// Frames per second of the animation, if there is to be one.
    animation: Option<f64>,
    started: Instant,
    /// The seconds before it was resumed.
    before: f64,
    first_energy: f64,
    self_distance: f64,
}

impl Run {
    fn start(setup: Setup, arguments: &RepulseArguments, session: &mut Session) -> Result<Run, Failure> {
        let format = arguments.frames;
        check_frames(&setup, format, session)?;
        let (folder, flow) = if arguments.resume {
            let (folder, state) = RunFolder::resume(&arguments.output, format, &setup.settings)?;
            let flow = session.solver("energy", || Flow::resume(&setup.mesh, state, &setup.options))?;
            session.note(&format!("continuing after step {}", folder.step()));
            (folder, flow)
        } else {
            // The energy comes first, so that a mesh that is refused leaves no folder.
            let flow = session.solver("energy", || Flow::new(&setup.mesh, &setup.options))?;
            (RunFolder::create(&arguments.output, format, &setup.settings)?, flow)
        };
        let mut run = Run {
            before: folder.seconds(),
            first_energy: folder.first_energy().unwrap_or(flow.energy()),
            self_distance: distance(&flow, setup.options.threads)?,
            render: arguments.render,
            animation: arguments.animation,
            started: Instant::now(),
            setup,
            folder,
            flow,
        };
        if !arguments.resume {
            let row = Row::of(&run.flow, 0, 0.0, 0.0, 0, run.self_distance);
            run.folder.log(&row, json!({ "objective": run.flow.objective() }))?;
            run.write_frame()?;
            run.folder.checkpoint(&run.flow.state())?;
        }
        Ok(run)
    }

    fn seconds(&self) -> f64 {
        self.before + self.started.elapsed().as_secs_f64()
    }

    /// Takes steps, and returns why they ended.
    fn steps(&mut self, session: &mut Session) -> Result<&'static str, Failure> {
        let mut recent = self.folder.recent()?;
        loop {
            let step = self.folder.step();
            if let Some(reason) = reached(&self.setup.until, step, self.flow.energy(), self.seconds()) {
                return Ok(reason);
            }
            if self.setup.until.is_empty() && recent.settled(&self.flow) {
                return Ok("settled");
            }
            if recent.blocked(&self.flow) {
                return Ok("blocked");
            }
            let name = self.progress(step + 1);
            let Some(done) = session.solver(&name, || self.flow.step())? else {
                return Ok(if self.flow.is_growing() { "blocked" } else { "minimum" });
            };
            recent.push(done.objective, done.growth);
            self.record(step + 1, &done, session)?;
        }
    }

    /// What the progress line says.
    fn progress(&self, step: u64) -> String {
        let seconds = self.seconds();
        let shares = self.setup.until.iter().filter_map(|until| match until {
            Until::Steps(count) => Some((step - 1) as f64 / *count as f64),
            Until::Seconds(limit) => Some(seconds / limit),
            Until::Energy(_) => None,
        });
        let share = shares.fold(0.0, f64::max);
        let left = match share > 0.0 {
            true => format!(", {:.0} s left", (seconds / share - seconds).max(0.0)),
            false => String::new(),
        };
        format!(
            "step {step}, energy {:.5}, self-distance {:.3e}, {} faces{left}",
            self.flow.energy(),
            self.self_distance,
            self.flow.mesh().face_count()
        )
    }

    /// Logs a step, and writes frame and checkpoint if it is their turn.
    fn record(&mut self, step: u64, done: &FlowStep, session: &mut Session) -> Result<(), Failure> {
        self.self_distance = distance(&self.flow, self.setup.options.threads)?;
        let row = Row::of(
            &self.flow,
            step,
            self.seconds(),
            done.step_size,
            done.solver_iterations,
            self.self_distance,
        );
        session.detail(&format!("step {step}: energy {:.6}, length {:.3e}", done.energy, done.step_size));
        self.folder.log(&row, facts_of(done, &self.flow))?;
        if step.is_multiple_of(self.setup.frames_every) {
            self.write_frame()?;
        }
        if step.is_multiple_of(self.setup.checkpoint_every) {
            self.folder.checkpoint(&self.flow.state())?;
        }
        Ok(())
    }

    fn write_frame(&mut self) -> Result<(), Failure> {
        let mesh = self.flow.mesh();
        let picture = match self.render {
            true => Some(draw(Scene::new(mesh, Coloring::default()), &PictureArguments::default())?),
            false => None,
        };
        let Setup { mesh: start, attributes, options, .. } = &self.setup;
        let pulled;
        let attributes: &Attributes = match self.folder.step() == 0 || options.remeshing == Remeshing::Off {
            true => attributes,
            false => {
                pulled = attributes.pulled(self.flow.places(), start, mesh.triangles());
                &pulled
            }
        };
        let colours = attributes.colours();
        self.folder.frame(&attributes.out(mesh, colours.as_deref()), picture)
    }

    /// Writes the last frame, the checkpoint and the report.
    fn finish(mut self, reason: &'static str, session: &mut Session) -> Result<(), Failure> {
        if !self.folder.has_frame() {
            self.write_frame()?;
        }
        self.folder.checkpoint(&self.flow.state())?;
        let Run { setup, folder, flow, first_energy, .. } = &self;
        if reason == "blocked" {
            let sentence = blocked_sentence(&setup.mesh, &setup.options, flow, self.self_distance);
            session.warn(Warned::new("blocked", sentence).with("growth_done", flow.growth_done()));
        }
        if let Some(rate) = self.animation {
            let path = write_animation(folder, &setup.mesh, &setup.attributes, rate)?;
            let frames = folder.frames().len();
            session.note(&format!("{} holds {frames} frames, {rate} per second", path.display()));
        }
        session.report.phase("flow", self.started.elapsed());
        session.report.result.extend(
            [
                ("steps", json!(folder.step())),
                ("stopped_by", json!(reason)),
                ("first_energy", json!(first_energy)),
                ("energy", json!(flow.energy())),
                ("objective", json!(flow.objective())),
                ("area", json!(Quantity::Area.of(flow.mesh()))),
                ("volume", json!(Quantity::Volume.of(flow.mesh()))),
                ("faces", json!(flow.mesh().face_count())),
                ("growth_done", json!(flow.growth_done())),
                ("self_distance", json!(self.self_distance)),
                ("frames", json!(folder.frames())),
            ]
            .map(|(key, value)| (key.to_string(), value)),
        );
        session.note(&format!(
            "{} steps to energy {} from {first_energy} ({}); {} holds the run",
            folder.step(),
            flow.energy(),
            match reason {
                "settled" => "ten steps lowered it by less than 0.1 %",
                "minimum" => "no step lowers it further",
                "blocked" => "what should grow or move is blocked",
                _ => "as asked",
            },
            folder.path().display(),
        ));
        Ok(())
    }
}

/// Checks that frames can be written, and warns of what their format cannot hold.
fn check_frames(setup: &Setup, format: MeshFormat, session: &mut Session) -> Result<(), Failure> {
    let colours = setup.attributes.colours();
    let out = setup.attributes.out(&setup.mesh, colours.as_deref());
    let left_out = write_mesh_bytes(&mut std::io::sink(), format, &out)
        .map_err(|fault| Failure::Usage(format!("--frames {}: {fault}", format.name().to_lowercase())))?;
    for warning in &left_out {
        session.warn(Warned::from(warning).about("frames"));
    }
    Ok(())
}

/// What the log has besides its columns.
fn facts_of(done: &FlowStep, flow: &Flow) -> Value {
    let mut facts = json!({
        "objective": done.objective,
        "descent": done.descent,
        "backtracks": done.backtracks,
        "limited_by_collision": done.limited_by_collision,
        "deviation": done.deviation,
        "growth": done.growth,
        "growth_done": flow.growth_done(),
    });
    if let Some(counts) = done.remeshing {
        facts["remeshing"] = json!({
            "splits": counts.splits, "collapses": counts.collapses, "flips": counts.flips, "refused": counts.refused,
        });
    }
    facts
}

fn distance(flow: &Flow, threads: usize) -> Result<f64, Failure> {
    self_distance(flow.mesh(), threads).map_err(|fault| Failure::Failed(fault.to_string()))
}

fn reached(until: &[Until], step: u64, energy: f64, seconds: f64) -> Option<&'static str> {
    until.iter().find_map(|until| match until {
        Until::Steps(count) => (step >= *count).then_some("steps"),
        Until::Energy(bound) => (energy <= *bound).then_some("energy"),
        Until::Seconds(bound) => (seconds >= *bound).then_some("seconds"),
    })
}
