//! The report of a run as JSON: what went in, what was chosen, how long it took, what was noticed,
//! what came out.

use eikona::signed_heat::Phases;
use serde::Serialize;
use serde_json::{Map, Value};
use std::time::Duration;

/// Raised whenever a key changes its meaning or goes away; new keys leave it.
pub const VERSION: u32 = 1;

/// A phase and how long it took.
#[derive(Clone, Debug, Serialize)]
pub struct Phase {
    /// Its name, with the step it belongs to: "prepare: factorisation".
    pub name: String,
    /// Seconds of the clock on the wall.
    pub seconds: f64,
}

/// A file that was written.
#[derive(Clone, Debug, Serialize)]
pub struct Output {
    /// What it holds: "distance", "isolines", "picture", "mesh", "curve", "report".
    pub kind: &'static str,
    /// As named on the command line; "-" is the standard output.
    pub path: String,
}

/// The report. The parts that differ from verb to verb are in `input`, `options` and `result`.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    eikona: &'static str,
    version: u32,
    tool_version: &'static str,
    verb: &'static str,
    arguments: Vec<String>,
    /// Facts about what was read.
    pub input: Map<String, Value>,
    /// What was asked for, defaults included.
    pub options: Map<String, Value>,
    /// What came out, in numbers.
    pub result: Map<String, Value>,
    /// In the order in which they ran.
    pub phases: Vec<Phase>,
    /// From start to the writing of this report.
    pub seconds: f64,
    /// The most memory the process has held, where the system tells.
    pub peak_memory_bytes: Option<u64>,
    /// Sentences for the user.
    pub warnings: Vec<String>,
    /// What was written.
    pub outputs: Vec<Output>,
}

impl Report {
    /// An empty report of this verb.
    pub fn new(verb: &'static str) -> Report {
        Report {
            eikona: "report",
            version: VERSION,
            tool_version: env!("CARGO_PKG_VERSION"),
            verb,
            arguments: std::env::args_os().skip(1).map(|a| a.to_string_lossy().into_owned()).collect(),
            input: Map::new(),
            options: Map::new(),
            result: Map::new(),
            phases: Vec::new(),
            seconds: 0.0,
            peak_memory_bytes: None,
            warnings: Vec::new(),
            outputs: Vec::new(),
        }
    }

    /// Adds a phase.
    pub fn phase(&mut self, name: impl Into<String>, time: Duration) {
        self.phases.push(Phase { name: name.into(), seconds: time.as_secs_f64() });
    }

    /// Adds the phases of a step of the library.
    pub fn phases_of(&mut self, step: &str, phases: &Phases) {
        for (name, time) in &phases.0 {
            self.phase(format!("{step}: {name}"), *time);
        }
    }

    /// The text of the file.
    pub fn to_json(&self) -> String {
        // A report holds only strings, numbers and lists: there is no way to fail. NaN becomes
        // null.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}

/// The most memory that this process has held, from the system's process table (Linux only).
pub fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}
