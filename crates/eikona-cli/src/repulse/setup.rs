//! What a run needs, from a mesh and options or from a scene.

use super::arguments::{RemeshKind, RepulseArguments, Until};
use super::attributes::Attributes;
use super::scene_setup;
use crate::exit::Failure;
use crate::input::MeshInput;
use crate::session::Session;
use crate::warned::Warned;
use eikona::repulsive::{Exponents, FlowOptions, Quantity, Remeshing};
use eikona::spatial::self_intersections;
use eikona_mesh::io::MeshFormat;
use eikona_mesh::{FileError, TriangleMesh, counted};
use eikona_scene::{SceneError, is_scene, read_scene};
use serde_json::{Value, json};
use std::path::Path;

/// A run.
pub struct Setup {
    /// The surface at the start.
    pub mesh: TriangleMesh,
    /// Its data, which follow the surface.
    pub attributes: Attributes,
    pub options: FlowOptions,
    pub until: Vec<Until>,
    pub frames_every: u64,
    pub checkpoint_every: u64,
    /// A checkpoint is continued only with the same.
    pub settings: Value,
}

/// Without further ado, frames are written after each step.
const FRAMES_EVERY: u64 = 1;
const CHECKPOINT_EVERY: u64 = 10;

impl Setup {
    /// Reads what the arguments name.
    pub fn read(arguments: &RepulseArguments, session: &mut Session) -> Result<Setup, Failure> {
        let mut setup = match is_scene(&arguments.mesh.mesh) {
            true => Setup::of_scene(arguments, session)?,
            false => Setup::of_mesh(arguments, session)?,
        };
        setup.allow_intersections(session)?;
        if arguments.no_data {
            setup.attributes = Attributes::default();
        }
        setup.check_animation(arguments)?;
        setup.settings["vertices"] = json!(setup.mesh.vertex_count());
        setup.settings["faces"] = json!(setup.mesh.face_count());
        setup.settings["area"] = json!(Quantity::Area.of(&setup.mesh));
        setup.settings["quadrature"] = json!(setup.options.quadrature());
        setup.settings["collisions"] = json!(setup.options.collisions);
        setup.settings["frames"] = json!(arguments.frames);
        setup.settings["data"] = json!(setup.attributes.names());
        Ok(setup)
    }

    fn of_mesh(arguments: &RepulseArguments, session: &mut Session) -> Result<Setup, Failure> {
        let exponents = arguments.p.map_or(Ok(Exponents::default()), Exponents::of_power)?;
        let keep = arguments.keep.clone().map_or(vec![Quantity::Area], |keep| keep.0);
        let options = FlowOptions::default()
            .with_exponents(exponents)
            .with_keep(keep)
            .with_quadrature(arguments.quadrature.map(Into::into))
            .with_collisions(!arguments.no_collisions)
            .with_remeshing(arguments.remeshing()?)
            .with_threads(session.threads());
        let input = MeshInput::read(&arguments.mesh, session)?;
        input.require_faces()?;
        let settings = json!({
            "alpha": exponents.alpha, "beta": exponents.beta, "keep": options.keep,
            "remeshing": options.remeshing,
        });
        let attributes = Attributes::of(&input, session);
        Ok(Setup {
            mesh: input.mesh,
            attributes,
            options,
            until: arguments.until.clone(),
            frames_every: arguments.frames_every.unwrap_or(FRAMES_EVERY),
            checkpoint_every: arguments.checkpoint_every.unwrap_or(CHECKPOINT_EVERY),
            settings,
        })
    }

    fn of_scene(arguments: &RepulseArguments, session: &mut Session) -> Result<Setup, Failure> {
        if let Some(flag) = arguments.first_of_mesh() {
            return Err(Failure::Usage(format!("{flag} goes with a mesh; the scene has a word for it")));
        }
        let scene = session
            .phase("read scene", || read_scene(&arguments.mesh.mesh))
            .map_err(|fault| unread(&arguments.mesh.mesh, fault))?;
        let (mesh, attributes, options) = scene_setup::flow_of(&scene, session)?;
        let stop = &scene.stop;
        let mut until = arguments.until.clone();
        if until.is_empty() {
            until.extend(stop.steps.map(|x| Until::Steps(x.value)));
            until.extend(stop.energy.map(|x| Until::Energy(x.value)));
            until.extend(stop.seconds.map(|x| Until::Seconds(x.value)));
        }
        let every =
            |argument: Option<u64>, of_scene: Option<u64>, usual: u64| argument.or(of_scene).unwrap_or(usual);
        let output = &scene.output;
        let frames = output.frames_every.map(|x| x.value);
        let checkpoints = output.checkpoint_every.map(|x| x.value);
        // A run may be resumed from another folder, and with other limits.
        let mut settings = json!(scene);
        for key in ["file", "stop", "output", "log"] {
            settings[key] = Value::Null;
        }
        Ok(Setup {
            mesh,
            attributes,
            options: options.with_threads(session.threads()),
            until,
            frames_every: every(arguments.frames_every, frames, FRAMES_EVERY),
            checkpoint_every: every(arguments.checkpoint_every, checkpoints, CHECKPOINT_EVERY),
            settings: json!({ "scene": settings }),
        })
    }

    /// An animation needs frames with the same vertices and faces.
    fn check_animation(&self, arguments: &RepulseArguments) -> Result<(), Failure> {
        if arguments.animation.is_none() {
            return Ok(());
        }
        if self.options.remeshing != Remeshing::Off {
            return Err(Failure::Usage(
                "--animation needs faces that keep their numbers, but remeshing changes them; add \
                 --remesh off (remesh = false in a scene), or play the files in frames/ one by one"
                    .into(),
            ));
        }
        if arguments.frames == MeshFormat::Stl {
            return Err(Failure::Usage(
                "--animation reads the frames, and faces in STL files do not share vertices; choose other \
                 --frames"
                    .into(),
            ));
        }
        Ok(())
    }

    /// Below p = 4, surfaces may intersect at the start. Steps cannot be kept free of collisions
    /// then.
    fn allow_intersections(&mut self, session: &mut Session) -> Result<(), Failure> {
        if self.options.exponents.alpha >= 4.0 || !self.options.collisions {
            return Ok(());
        }
        let pairs = self_intersections(&self.mesh, self.options.threads)
            .map_err(|fault| Failure::Failed(fault.to_string()))?;
        if !pairs.is_empty() {
            let count = counted(pairs.len(), "pair of faces intersects", "pairs of faces intersect");
            let sentence = format!("{count} at the start, so collisions are not looked for");
            session.warn(Warned::new("intersecting_start", sentence).with("pairs", pairs.len()));
            self.options.collisions = false;
        }
        Ok(())
    }
}

fn unread(path: &Path, fault: SceneError) -> Failure {
    match fault {
        SceneError::Io { path: name, fault } => Failure::reading(path, FileError::Io { path: name, fault }),
        faults => Failure::Input(faults.to_string()),
    }
}

impl RepulseArguments {
    /// The first argument that is given and that does not go with a scene.
    fn first_of_mesh(&self) -> Option<&'static str> {
        let given = [
            (self.keep.is_some(), "--keep"),
            (self.p.is_some(), "--p"),
            (self.quadrature.is_some(), "--quadrature"),
            (self.no_collisions, "--no-collisions"),
            (self.remesh.is_some(), "--remesh"),
            (self.edge_length.is_some(), "--edge-length"),
        ];
        given.into_iter().find(|(given, _)| *given).map(|(_, flag)| flag)
    }

    fn remeshing(&self) -> Result<Remeshing, Failure> {
        let length = self.edge_length;
        match self.remesh.unwrap_or_default() {
            RemeshKind::Off if length.is_some() => {
                Err(Failure::Usage("--edge-length goes with remeshing, which --remesh=off turns off".into()))
            }
            RemeshKind::Off => Ok(Remeshing::Off),
            RemeshKind::Uniform => Ok(Remeshing::Uniform { length }),
            RemeshKind::Adaptive => Ok(Remeshing::Adaptive { length }),
        }
    }
}
