//! `eikona repulse`: moves a surface so that it never touches itself.

mod arguments;
mod folder;
mod scene_setup;
mod setup;

pub use arguments::RepulseArguments;

use crate::exit::Failure;
use crate::picture::{PictureArguments, draw};
use crate::session::{General, Session};
use arguments::Until;
use eikona::repulsive::{Flow, FlowStep, Quantity};
use eikona::spatial::self_distance;
use eikona_render::{Coloring, Scene};
use folder::{Row, RunFolder};
use serde_json::{Value, json};
use setup::Setup;
use std::time::Instant;

/// Without `--until`: so many steps have to lower the energy by this share.
const PATIENCE: usize = 10;
const PROGRESS: f64 = 1e-3;

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
    started: Instant,
    /// The seconds before it was resumed.
    before: f64,
    first_energy: f64,
    self_distance: f64,
}

impl Run {
    fn start(setup: Setup, arguments: &RepulseArguments, session: &mut Session) -> Result<Run, Failure> {
        let (folder, flow) = if arguments.resume {
            let (folder, state) = RunFolder::resume(&arguments.output, &setup.settings)?;
            let flow = session.solver("energy", || Flow::resume(&setup.mesh, state, &setup.options))?;
            session.note(&format!("continuing after step {}", folder.step()));
            (folder, flow)
        } else {
            // The energy comes first, so that a mesh that is refused leaves no folder.
            let flow = session.solver("energy", || Flow::new(&setup.mesh, &setup.options))?;
            (RunFolder::create(&arguments.output, &setup.settings)?, flow)
        };
        let mut run = Run {
            before: folder.seconds(),
            first_energy: folder.first_energy().unwrap_or(flow.energy()),
            self_distance: distance(&flow, setup.options.threads)?,
            render: arguments.render,
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
        let mut recent = vec![self.flow.objective()];
        loop {
            let step = self.folder.step();
            if let Some(reason) = reached(&self.setup.until, step, self.flow.energy(), self.seconds()) {
                return Ok(reason);
            }
            let settled = self.setup.until.is_empty()
                && !self.flow.is_growing()
                && recent.len() > PATIENCE
                && recent[recent.len() - 1 - PATIENCE] - self.flow.objective()
                    < PROGRESS * self.flow.energy();
            if settled {
                return Ok("settled");
            }
            let name = self.progress(step + 1);
            let Some(done) = session.solver(&name, || self.flow.step())? else { return Ok("minimum") };
            recent.push(done.objective);
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
        self.folder.log(&row, facts_of(done))?;
        if step.is_multiple_of(self.setup.frames_every) {
            self.write_frame()?;
        }
        if step.is_multiple_of(self.setup.checkpoint_every) {
            self.folder.checkpoint(&self.flow.state())?;
        }
        Ok(())
    }

    fn write_frame(&mut self) -> Result<(), Failure> {
        let scene = || Scene::new(self.flow.mesh(), Coloring::default());
        let picture = match self.render {
            true => Some(draw(scene(), &PictureArguments::default())?),
            false => None,
        };
        self.folder.frame(self.flow.mesh(), picture)
    }

    /// Writes the last frame, the checkpoint and the report.
    fn finish(mut self, reason: &'static str, session: &mut Session) -> Result<(), Failure> {
        if !self.folder.has_frame() {
            self.write_frame()?;
        }
        self.folder.checkpoint(&self.flow.state())?;
        let Run { folder, flow, first_energy, .. } = &self;
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
                _ => "as asked",
            },
            folder.path().display(),
        ));
        Ok(())
    }
}

/// What the log has besides its columns.
fn facts_of(done: &FlowStep) -> Value {
    let mut facts = json!({
        "objective": done.objective,
        "descent": done.descent,
        "backtracks": done.backtracks,
        "limited_by_collision": done.limited_by_collision,
        "deviation": done.deviation,
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
