//! One run of the command: what it says, what it notes for the report, and its output files, which
//! appear together at the end or not at all.

use crate::exit::Failure;
use crate::progress::Progress;
use crate::report::{Output, Report, peak_memory_bytes};
use clap::Args;
use eikona_mesh::io::{StagedFile, publish_files, stage_file};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// What every verb takes.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "General options")]
pub struct General {
    /// Write a report as JSON: input, options, phases with seconds, residuals, warnings, outputs
    #[arg(long, global = true, value_name = "R.json")]
    pub report: Option<PathBuf>,
    /// Threads to use [default: as many as there are cores]; the digits are the same for any number
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print how long each phase took
    #[arg(long, global = true)]
    pub timings: bool,
    /// End with exit code 4 if there were warnings (outputs are written all the same)
    #[arg(long, global = true)]
    pub strict: bool,
    /// Print nothing but errors and warnings; twice: errors only
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub quiet: u8,
    /// Say more
    #[arg(short, long, global = true)]
    pub verbose: bool,
}

/// Warnings of a kind that are printed.
const PRINTED: usize = 5;

/// A warning with its numbers left out: those that differ in nothing else are of one kind.
fn kind_of(warning: &str) -> String {
    let mut kind = String::with_capacity(warning.len());
    let mut rest = warning.chars().peekable();
    while let Some(c) = rest.next() {
        if !c.is_ascii_digit() {
            kind.push(c);
            continue;
        }
        kind.push('N');
        // The rest of the number, with point and exponent; a full stop behind it is left.
        loop {
            let mut ahead = rest.clone();
            if ahead.next_if(|c| matches!(c, 'e' | '.')).is_some() {
                ahead.next_if(|c| matches!(c, '-' | '+'));
            }
            if ahead.next_if(char::is_ascii_digit).is_none() {
                break;
            }
            rest = ahead;
        }
    }
    kind
}

/// One run of a verb.
pub struct Session {
    general: General,
    started: Instant,
    progress: Progress,
    staged: Vec<StagedFile>,
    stdout: Option<Vec<u8>>,
    /// How many warnings of each kind there were.
    warned: BTreeMap<String, usize>,
    /// What will be in the report.
    pub report: Report,
}

impl Session {
    /// Starts the clock.
    pub fn new(verb: &'static str, general: &General) -> Session {
        Session {
            general: general.clone(),
            started: Instant::now(),
            progress: Progress::new(general.quiet == 0),
            staged: Vec::new(),
            stdout: None,
            warned: BTreeMap::new(),
            report: Report::new(verb),
        }
    }

    /// The number of threads to use.
    pub fn threads(&self) -> usize {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        self.general.threads.map_or(cores, usize::from)
    }

    /// Runs a part of the work, measured under this name.
    pub fn phase<T>(&mut self, name: &str, work: impl FnOnce() -> T) -> T {
        self.progress.phase(name);
        let start = Instant::now();
        let result = work();
        self.report.phase(name, start.elapsed());
        result
    }

    /// As [`Session::phase`] for work that measures its own phases.
    pub fn unmeasured<T>(&mut self, name: &str, work: impl FnOnce() -> T) -> T {
        self.progress.phase(name);
        work()
    }

    /// Says something good to know.
    pub fn note(&mut self, text: &str) {
        if self.general.quiet == 0 {
            self.progress.print(text);
        }
    }

    /// Says something for those who want to know more.
    pub fn detail(&mut self, text: &str) {
        if self.general.verbose {
            self.progress.print(text);
        }
    }

    /// Says something that the user should look at. Of one kind only the first few are printed; the
    /// report has all.
    pub fn warn(&mut self, text: impl Into<String>) {
        let text = text.into();
        let count = self.warned.entry(kind_of(&text)).or_default();
        *count += 1;
        if self.general.quiet < 2 && *count <= PRINTED {
            self.progress.print(&format!("warning: {text}"));
        }
        self.report.warnings.push(text);
    }

    /// Says how many warnings were not printed.
    fn count_the_rest(&self) {
        let place =
            if self.general.report.is_some() { "in the report" } else { "in a report: --report R.json" };
        for (kind, count) in self.warned.iter().filter(|(_, count)| **count > PRINTED) {
            self.progress.print(&format!("warning: … and {} more (all {place}): {kind}", count - PRINTED));
        }
    }

    /// Checks before the work that the report can be written.
    pub fn check_report(&self) -> Result<(), Failure> {
        self.general.report.as_deref().map_or(Ok(()), check_output)
    }

    /// Adds an output file. It appears when the session is finished.
    pub fn output(&mut self, kind: &'static str, path: &Path, bytes: Vec<u8>) -> Result<(), Failure> {
        if path == Path::new("-") {
            if self.stdout.is_some() {
                return Err(Failure::Usage("only one output can go to the standard output (-)".into()));
            }
            self.stdout = Some(bytes);
            self.list(kind, path);
            return Ok(());
        }
        let file = stage_file(path, |out| out.write_all(&bytes)).map_err(Failure::writing)?;
        self.staged_output(kind, path, file);
        Ok(())
    }

    /// Adds an output file that is written already but has not its name yet.
    pub fn staged_output(&mut self, kind: &'static str, path: &Path, file: StagedFile) {
        self.staged.push(file);
        self.list(kind, path);
    }

    fn list(&mut self, kind: &'static str, path: &Path) {
        self.report.outputs.push(Output { kind, path: path.display().to_string() });
    }

    /// Writes the report, gives all files their names, says what was written and how long it took.
    /// Gives the exit code.
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
        // First, since files that are not published yet go away if this fails.
        if let Some(bytes) = self.stdout.take() {
            print_bytes(&bytes)?;
        }
        publish_files(std::mem::take(&mut self.staged)).map_err(Failure::writing)?;
        self.progress = Progress::default(); // the line goes away before the last words
        if self.general.quiet < 2 {
            self.count_the_rest();
        }
        if self.general.timings {
            for phase in &self.report.phases {
                self.progress.print(&format!("{:>9.3} s  {}", phase.seconds, phase.name));
            }
            self.progress.print(&format!("{:>9.3} s  in all", self.report.seconds));
        }
        for output in self.report.outputs.iter().filter(|o| o.path != "-" && self.general.quiet == 0) {
            self.progress.print(&format!("wrote {} ({})", output.path, output.kind));
        }
        Ok(if self.general.strict && !self.report.warnings.is_empty() { crate::exit::WARNINGS } else { 0 })
    }
}

/// Writes to the standard output. A reader that has gone away (`| head`) is no failure.
pub fn print_bytes(bytes: &[u8]) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(fault) if fault.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Failed(format!("the standard output can not be written: {fault}")))
        }
        _ => Ok(()),
    }
}

/// Refuses early what could not be written late, two outputs that are one file, and an output that
/// is one of the inputs.
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
                format!("{shown}: two outputs have this name; give each its own")
            } else {
                format!("{} and {shown}: two outputs go to this one file; give each its own", other.display())
            }));
        }
        if let Some((_, input)) = read.iter().find(|(f, _)| *f == file) {
            return Err(Failure::Usage(format!(
                "{shown}: this output would take the place of the input {}; give it another name",
                input.display()
            )));
        }
        seen.push((file, path));
    }
    Ok(())
}

/// The file that a name leads to, however it is spelled and through whatever links. (An output
/// takes the place of one hard link and leaves the others as they are, so these are files of their
/// own.)
fn file_of(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    path.canonicalize().unwrap_or_else(|_| match (folder.canonicalize(), path.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => path.to_path_buf(),
    })
}

/// Refuses early what could not be written late: a folder, or a file in a folder that does not
/// exist.
pub fn check_output(path: &Path) -> Result<(), Failure> {
    if path == Path::new("-") {
        return Ok(());
    }
    if path.is_dir() {
        return Err(Failure::Usage(format!(
            "{}: this is a folder, but an output must be a file; name a file in it",
            path.display()
        )));
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty());
    if let Some(folder) = folder.filter(|f| !f.is_dir()) {
        return Err(Failure::Usage(format!(
            "{}: the folder {} does not exist; make it first",
            path.display(),
            folder.display()
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn warnings_that_differ_in_numbers_are_of_one_kind() {
        assert_eq!(kind_of("component 12 (1 faces) is NaN"), "component N (N faces) is NaN");
        assert_eq!(kind_of("at 1.5e-3, -2 of 1,000."), "at N, -N of N,N.");
        assert_eq!(kind_of("nothing to count: e. 5."), "nothing to count: e. N.");
        assert_ne!(kind_of("node 1 fell"), kind_of("node 1 rose"));
    }
}
