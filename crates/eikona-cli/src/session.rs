//! One run of a command: messages, the report, and output files, which appear together at the end
//! or not at all.

use crate::exit::Failure;
use crate::progress::Progress;
use crate::report::{Output, Report, peak_memory_bytes};
use crate::warned::Warned;
use clap::Args;
use eikona::numeric::observed;
use eikona_mesh::io::{
    MeshFormat, MeshOut, StagedFile, publish_files, stage_file, stage_mesh, write_mesh_bytes,
};
use std::collections::{BTreeMap, HashSet};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Options of every command.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "General options")]
pub struct General {
    /// Write a JSON report: input, options, seconds per phase, residuals, warnings, outputs
    #[arg(long, global = true, value_name = "R.json")]
    pub report: Option<PathBuf>,
    /// Number of threads [default: number of cores]; results do not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print the time of each phase
    #[arg(long, global = true)]
    pub timings: bool,
    /// Exit with code 4 if there are warnings (outputs are still written)
    #[arg(long, global = true)]
    pub strict: bool,
    /// Print only errors and warnings; twice: only errors
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub quiet: u8,
    /// Print more details
    #[arg(short, long, global = true)]
    pub verbose: bool,
}

/// Number of warnings printed per kind.
const PRINTED: usize = 5;

/// One run of a command.
pub struct Session {
    general: General,
    started: Instant,
    progress: Progress,
    staged: Vec<StagedFile>,
    stdout: Option<Vec<u8>>,
    /// Number of warnings of each kind.
    warned: BTreeMap<String, usize>,
    /// Sentences of all warnings.
    sentences: HashSet<String>,
    /// Report of the run.
    pub report: Report,
}

impl Session {
    /// Starts a run and its clock.
    pub fn new(verb: &'static str, general: &General) -> Session {
        Session {
            general: general.clone(),
            started: Instant::now(),
            progress: Progress::new(general.quiet == 0),
            staged: Vec::new(),
            stdout: None,
            warned: BTreeMap::new(),
            sentences: HashSet::new(),
            report: Report::new(verb),
        }
    }

    /// The number of threads to use.
    pub fn threads(&self) -> usize {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        self.general.threads.map_or(cores, usize::from)
    }

    /// Runs a phase of the work and records its time.
    pub fn phase<T>(&mut self, name: &str, work: impl FnOnce() -> T) -> T {
        self.progress.phase(name);
        let start = Instant::now();
        let result = work();
        self.report.phase(name, start.elapsed());
        result
    }

    /// Runs a solver, which measures its own phases, and shows its progress.
    pub fn solver<T>(&mut self, step: &str, work: impl FnOnce() -> T) -> T {
        self.progress.phase(step);
        observed(self.progress.observer(step), work)
    }

    /// Prints a note, unless quiet.
    pub fn note(&mut self, text: &str) {
        if self.general.quiet == 0 {
            self.progress.print(text);
        }
    }

    /// Prints a detail if verbose.
    pub fn detail(&mut self, text: &str) {
        if self.general.verbose {
            self.progress.print(text);
        }
    }

    /// Records a warning and prints it, unless it repeats one or is one of many of its kind.
    pub fn warn(&mut self, warning: impl Into<Warned>) {
        let warning = warning.into();
        if !self.sentences.insert(warning.message().to_string()) {
            return;
        }
        let count = self.warned.entry(warning.kind().to_string()).or_default();
        *count += 1;
        if self.general.quiet < 2 && *count <= PRINTED {
            self.progress.print(&format!("warning: {}", warning.message()));
        }
        self.report.warnings.push(warning);
    }

    /// Prints how many warnings of each kind were left out.
    fn count_the_rest(&self) {
        let place = if self.general.report.is_some() { "the report" } else { "--report R.json" };
        for (kind, count) in self.warned.iter().filter(|(_, count)| **count > PRINTED) {
            self.progress.print(&format!(
                "warning: … and {} more of kind {kind} ({place} lists all)",
                count - PRINTED
            ));
        }
    }

    /// Checks before the work that the report path is usable.
    pub fn check_report(&self) -> Result<(), Failure> {
        self.general.report.as_deref().map_or(Ok(()), check_output)
    }

    /// Adds an output file, which appears when the run finishes.
    pub fn output(&mut self, kind: &'static str, path: &Path, bytes: Vec<u8>) -> Result<(), Failure> {
        if path == Path::new("-") {
            if self.stdout.is_some() {
                return Err(Failure::Usage(
                    "two outputs go to standard output (-); give one of them a file".into(),
                ));
            }
            self.stdout = Some(bytes);
            self.list(kind, path);
            return Ok(());
        }
        let file = stage_file(path, |out| out.write_all(&bytes)).map_err(Failure::writing)?;
        self.staged_output(kind, path, file);
        Ok(())
    }

    /// Adds a mesh in the format of its file's name, and warns of what that cannot store. Standard
    /// output (-) has `stdout_format`.
    pub fn mesh_output(
        &mut self,
        kind: &'static str,
        path: &Path,
        stdout_format: Option<MeshFormat>,
        out: &MeshOut<'_>,
    ) -> Result<(), Failure> {
        let left_out = if let (true, Some(format)) = (path == Path::new("-"), stdout_format) {
            let mut bytes = Vec::new();
            let left_out = write_mesh_bytes(&mut bytes, format, out).map_err(Failure::writing)?;
            self.output(kind, path, bytes)?;
            left_out
        } else {
            let (file, left_out) = stage_mesh(path, out).map_err(Failure::writing)?;
            self.staged_output(kind, path, file);
            left_out
        };
        for warning in &left_out {
            self.warn(Warned::from(warning).about(path.display()));
        }
        Ok(())
    }

    /// Adds an output file that is written under a temporary name.
    fn staged_output(&mut self, kind: &'static str, path: &Path, file: StagedFile) {
        self.staged.push(file);
        self.list(kind, path);
    }

    fn list(&mut self, kind: &'static str, path: &Path) {
        self.report.outputs.push(Output { kind, path: path.display().to_string(), fields: Vec::new() });
    }

    /// Names the fields in the output added last.
    pub fn name_fields<'a>(&mut self, names: impl Iterator<Item = &'a str>) {
        if let Some(last) = self.report.outputs.last_mut() {
            last.fields = names.map(str::to_string).collect();
        }
    }

    /// Writes the report, publishes all files, and prints timings and outputs. Returns the exit
    /// code.
    pub fn finish(mut self) -> Result<u8, Failure> {
        self.report.seconds = self.started.elapsed().as_secs_f64();
        self.report.peak_memory_bytes = peak_memory_bytes();
        if let Some(path) = self.general.report.clone() {
            self.list("report", &path);
            let text = self.report.to_json();
            if let Some(last) = self.report.outputs.pop() {
                self.output(last.kind, &path, text.into_bytes())?;
            }
        }
        // Standard output comes first: if it fails, no file is published.
        if let Some(bytes) = self.stdout.take() {
            print_bytes(&bytes)?;
        }
        publish_files(std::mem::take(&mut self.staged)).map_err(Failure::writing)?;
        self.progress = Progress::default(); // removes the progress line before the last messages
        if self.general.quiet < 2 {
            self.count_the_rest();
        }
        if self.general.timings {
            for phase in &self.report.phases {
                self.progress.print(&format!("{:>9.3} s  {}", phase.seconds, phase.name));
            }
            self.progress.print(&format!("{:>9.3} s  total", self.report.seconds));
        }
        for output in self.report.outputs.iter().filter(|o| o.path != "-" && self.general.quiet == 0) {
            let content =
                if output.fields.is_empty() { output.kind.into() } else { output.fields.join(", ") };
            self.progress.print(&format!("wrote {} ({content})", output.path));
        }
        Ok(if self.general.strict && !self.report.warnings.is_empty() { crate::exit::WARNINGS } else { 0 })
    }
}

/// Writes to standard output. A closed pipe (`| head`) is not a failure.
pub fn print_bytes(bytes: &[u8]) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(fault) if fault.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Failed(format!("cannot write to standard output: {fault}")))
        }
        _ => Ok(()),
    }
}

/// Checks output paths before the work: each is a file in an existing folder, differs from the
/// others, and is no input file.
pub fn check_outputs(outputs: &[&Path], inputs: &[&Path]) -> Result<(), Failure> {
    let stdio = Path::new("-");
    let read: Vec<(PathBuf, &Path)> =
        inputs.iter().filter(|p| **p != stdio && p.is_file()).map(|p| (file_of(p), *p)).collect();
    let mut seen: Vec<(PathBuf, &Path)> = Vec::new();
    for &path in outputs {
        check_output(path)?;
        let file = if path == stdio { path.to_path_buf() } else { file_of(path) };
        let shown = path.display();
        if let Some((_, other)) = seen.iter().find(|(f, _)| *f == file) {
            return Err(Failure::Usage(if *other == path {
                format!("{shown}: two outputs have this name; name them differently")
            } else {
                format!(
                    "{} and {shown}: two outputs are the same file; name them differently",
                    other.display()
                )
            }));
        }
        if let Some((_, input)) = read.iter().find(|(f, _)| *f == file) {
            return Err(Failure::Usage(format!(
                "{shown}: this output would overwrite the input {}; give it another name",
                input.display()
            )));
        }
        seen.push((file, path));
    }
    Ok(())
}

/// The file that a path refers to, however it is spelled, with symbolic links followed. (Hard links
/// count as different files: an output replaces only one of them.)
fn file_of(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    path.canonicalize().unwrap_or_else(|_| match (folder.canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_path_buf(),
    })
}

/// Fails early if an output is a folder, or a file in a folder that does not exist.
pub fn check_output(path: &Path) -> Result<(), Failure> {
    if path == Path::new("-") {
        return Ok(());
    }
    if path.is_dir() {
        return Err(Failure::Usage(format!("{}: this is a folder; name a file in it", path.display())));
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|f| !f.is_dir()) {
        return Err(Failure::Usage(format!(
            "{}: the folder {} does not exist; create it first",
            path.display(),
            folder.display()
        )));
    }
    Ok(())
}
