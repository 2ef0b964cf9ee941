//! The folder of a run: log, frames and checkpoint. Each file is whole at any time, so that a run
//! that is killed can be resumed.

use super::recent::{PATIENCE, Recent};
use crate::exit::Failure;
use eikona::repulsive::{Flow, FlowState, Quantity};
use eikona_mesh::FileError;
use eikona_mesh::io::{MeshFormat, MeshOut, StagedFile, publish_files, stage_file, stage_mesh};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::fs::{self, File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

/// A row of the log.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    step: u64,
    seconds: f64,
    energy: f64,
    area: f64,
    volume: f64,
    self_distance: f64,
    faces: usize,
    step_size: f64,
    solver_iterations: usize,
}

const COLUMNS: &str = "step,seconds,energy,area,volume,self_distance,faces,step_size,solver_iterations";

impl Row {
    /// Measures the surface.
    pub fn of(flow: &Flow, step: u64, seconds: f64, step_size: f64, iterations: usize, distance: f64) -> Row {
        let mesh = flow.mesh();
        Row {
            step,
            seconds,
            energy: flow.energy(),
            area: Quantity::Area.of(mesh),
            volume: Quantity::Volume.of(mesh),
            self_distance: distance,
            faces: mesh.face_count(),
            step_size,
            solver_iterations: iterations,
        }
    }

    fn csv(&self) -> String {
        format!(
            "{},{:.3},{},{},{},{},{},{},{}",
            self.step,
            self.seconds,
            self.energy,
            self.area,
            self.volume,
            self.self_distance,
            self.faces,
            self.step_size,
            self.solver_iterations
        )
    }
}

/// All that a run continues from.
#[derive(Serialize, Deserialize)]
struct Checkpoint {
    version: u32,
    step: u64,
    seconds: f64,
    first_energy: f64,
    frames: Vec<u64>,
    settings: Value,
    state: FlowState,
}

const VERSION: u32 = 1;

/// The folder of a run.
pub struct RunFolder {
    path: PathBuf,
    /// That of the frames.
    format: MeshFormat,
    settings: Value,
    step: u64,
    seconds: f64,
    first_energy: Option<f64>,
    frames: Vec<u64>,
    csv: File,
    jsonl: File,
}

impl RunFolder {
    /// Creates the folder, which has to be new or empty.
    pub fn create(path: &Path, format: MeshFormat, settings: &Value) -> Result<RunFolder, Failure> {
        let shown = path.display();
        if path.is_file() {
            return Err(Failure::Usage(format!("{shown}: this is a file; name a folder")));
        }
        if path.join("checkpoint").is_file() {
            return Err(Failure::Usage(format!(
                "{shown}: this folder holds a run; add --resume to continue it, or name another folder"
            )));
        }
        if fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_some()) {
            return Err(Failure::Usage(format!(
                "{shown}: this folder is not empty; name a new or empty one"
            )));
        }
        fs::create_dir_all(path.join("frames")).map_err(|fault| cannot_write(path, &fault))?;
        let mut csv = fresh(&path.join("log.csv"))?;
        let jsonl = fresh(&path.join("log.jsonl"))?;
        writeln!(csv, "{COLUMNS}").map_err(|fault| cannot_write(&path.join("log.csv"), &fault))?;
        Ok(RunFolder {
            path: path.to_path_buf(),
            format,
            settings: settings.clone(),
            step: 0,
            seconds: 0.0,
            first_energy: None,
            frames: Vec::new(),
            csv,
            jsonl,
        })
    }

    /// Opens the folder of a run, and takes back what it did after its checkpoint.
    pub fn resume(
        path: &Path,
        format: MeshFormat,
        settings: &Value,
    ) -> Result<(RunFolder, FlowState), Failure> {
        let file = path.join("checkpoint");
        let shown = file.display();
        let text = fs::read_to_string(&file).map_err(|fault| {
            Failure::Input(format!("{shown}: cannot read the checkpoint ({fault}); start without --resume"))
        })?;
        let checkpoint: Checkpoint = serde_json::from_str(&text)
            .map_err(|fault| Failure::Input(format!("{shown}: this is no checkpoint ({fault})")))?;
        if checkpoint.version != VERSION {
            return Err(Failure::Input(format!(
                "{shown}: its version is {} instead of {VERSION}; start without --resume",
                checkpoint.version
            )));
        }
        if checkpoint.settings != *settings {
            return Err(Failure::Usage(format!(
                "{shown}: the run has the settings {}, but {settings} are given; give the same",
                checkpoint.settings
            )));
        }
        let keep = checkpoint.step as usize + 1;
        let csv = truncated(&path.join("log.csv"), keep + 1)?;
        let jsonl = truncated(&path.join("log.jsonl"), keep)?;
        let folder = RunFolder {
            path: path.to_path_buf(),
            format,
            settings: settings.clone(),
            step: checkpoint.step,
            seconds: checkpoint.seconds,
            first_energy: Some(checkpoint.first_energy),
            frames: checkpoint.frames,
            csv,
            jsonl,
        };
        for entry in fs::read_dir(path.join("frames")).into_iter().flatten().flatten() {
            let number = entry.path().file_stem().and_then(|stem| stem.to_str()?.parse::<u64>().ok());
            if number.is_some_and(|number| number > folder.step) {
                fs::remove_file(entry.path()).map_err(|fault| cannot_write(&entry.path(), &fault))?;
            }
        }
        Ok((folder, checkpoint.state))
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The last step that was logged.
    pub fn step(&self) -> u64 {
        self.step
    }
    /// The seconds of the run so far.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }
    /// The energy at the start.
    pub fn first_energy(&self) -> Option<f64> {
        self.first_energy
    }
    /// The steps whose frames are written.
    pub fn frames(&self) -> &[u64] {
        &self.frames
    }
    /// Whether the frame of the last step is written.
    pub fn has_frame(&self) -> bool {
        self.frames.last() == Some(&self.step)
    }

    /// Reads the last steps from the log, so that a run that is resumed ends where it would have.
    pub fn recent(&self) -> Result<Recent, Failure> {
        let path = self.path.join("log.jsonl");
        let text = fs::read_to_string(&path).map_err(|fault| cannot_read(&path, fault))?;
        let mut recent = Recent::default();
        let lines: Vec<&str> = text.lines().rev().take(PATIENCE + 1).collect();
        for line in lines.into_iter().rev() {
            let row: Value = serde_json::from_str(line).map_err(|fault| cannot_read(&path, fault))?;
            let number = |key: &str| row[key].as_f64();
            recent.push(number("objective").unwrap_or(f64::MAX), number("growth").unwrap_or(0.0));
        }
        Ok(recent)
    }

    /// Appends a row to both logs.
    pub fn log(&mut self, row: &Row, more: Value) -> Result<(), Failure> {
        (self.step, self.seconds) = (row.step, row.seconds);
        self.first_energy.get_or_insert(row.energy);
        let mut all = json!(row);
        if let (Some(all), Value::Object(more)) = (all.as_object_mut(), more) {
            all.extend(more);
        }
        writeln!(self.csv, "{}", row.csv())
            .map_err(|fault| cannot_write(&self.path.join("log.csv"), &fault))?;
        writeln!(self.jsonl, "{all}").map_err(|fault| cannot_write(&self.path.join("log.jsonl"), &fault))
    }

    /// Writes the frame of the last step, with a picture if there is one, and lists it.
    pub fn frame(&mut self, mesh: &MeshOut, picture: Option<Vec<u8>>) -> Result<(), Failure> {
        self.frames.push(self.step);
        let mut files = vec![stage_mesh(self.frame_path(self.step), mesh).map_err(unwritten)?.0];
        if let Some(picture) = picture {
            let path = self.frame_path(self.step).with_extension("png");
            files.push(stage_file(path, |out| out.write_all(&picture)).map_err(unwritten)?);
        }
        let listed: Vec<Value> = self
            .frames
            .iter()
            .map(|step| json!({"step": step, "mesh": self.frame_path(*step).file_name().map(|n| n.to_string_lossy())}))
            .collect();
        files.push(self.json("frames/manifest.json", &json!({"version": VERSION, "frames": listed}))?);
        publish_files(files).map_err(unwritten)
    }

    /// The mesh file of a frame.
    pub fn frame_path(&self, step: u64) -> PathBuf {
        let extension = self.format.name().to_lowercase();
        self.path.join("frames").join(format!("{step:06}.{extension}"))
    }

    /// Replaces the checkpoint.
    pub fn checkpoint(&mut self, state: &FlowState) -> Result<(), Failure> {
        let checkpoint = Checkpoint {
            version: VERSION,
            step: self.step,
            seconds: self.seconds,
            first_energy: self.first_energy.unwrap_or(f64::MAX),
            frames: self.frames.clone(),
            settings: self.settings.clone(),
            state: state.clone(),
        };
        let file = self.json("checkpoint", &json!(checkpoint))?;
        publish_files(vec![file]).map_err(unwritten)
    }

    fn json(&self, name: &str, value: &Value) -> Result<StagedFile, Failure> {
        let text = format!("{value}\n");
        stage_file(self.path.join(name), |out| out.write_all(text.as_bytes())).map_err(unwritten)
    }
}

fn cannot_write(path: &Path, fault: &std::io::Error) -> Failure {
    Failure::Failed(format!(
        "{}: cannot write this file ({fault}); make room, and continue from the last checkpoint with --resume",
        path.display()
    ))
}

/// A file of a run that could not be written.
pub fn unwritten(fault: FileError) -> Failure {
    match fault {
        FileError::Io { path, fault } => cannot_write(Path::new(&path), &fault),
        fault => Failure::writing(fault),
    }
}

fn cannot_read(path: &Path, fault: impl std::fmt::Display) -> Failure {
    Failure::Input(format!("{}: cannot read the log of the run ({fault}); start a new one", path.display()))
}

fn fresh(path: &Path) -> Result<File, Failure> {
    File::create(path).map_err(|fault| cannot_write(path, &fault))
}

/// Opens a file for appending after its first lines.
fn truncated(path: &Path, lines: usize) -> Result<File, Failure> {
    let text = fs::read_to_string(path).map_err(|fault| cannot_write(path, &fault))?;
    let kept: usize = text.split_inclusive('\n').take(lines).map(str::len).sum();
    let file = OpenOptions::new().append(true).open(path).map_err(|fault| cannot_write(path, &fault))?;
    file.set_len(kept as u64).map_err(|fault| cannot_write(path, &fault))?;
    Ok(file)
}
