//! The JSON report of a run: input, options, timings, warnings and results.

use crate::warned::Warned;
use eikona::signed_heat::Phases;
use eikona_mesh::{Provenance, Vertex};
use serde::Serialize;
use serde_json::{Map, Value};
use std::time::Duration;

/// Schema version. Incremented when a key changes its meaning or disappears, not for new keys.
pub const VERSION: u32 = 2;

/// A phase and its duration.
#[derive(Clone, Debug, Serialize)]
pub struct Phase {
    /// Name, with the step it belongs to: "prepare: factorisation".
    pub name: String,
    /// Wall-clock seconds.
    pub seconds: f64,
}

/// An output file.
#[derive(Clone, Debug, Serialize)]
pub struct Output {
    /// Content: "distance", "isolines", "picture", "mesh", "curve", "regions", "split mesh",
    /// "labels", "loops" or "report".
    pub kind: &'static str,
    /// Path as given on the command line; "-" is standard output.
    pub path: String,
    /// Names of the fields in it, in the order of their columns.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub fields: Vec<String>,
}

/// The report. `input`, `options` and `result` depend on the command.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    eikona: &'static str,
    version: u32,
    tool_version: &'static str,
    verb: &'static str,
    arguments: Vec<String>,
    /// Facts about the input files.
    pub input: Map<String, Value>,
    /// Options, including defaults.
    pub options: Map<String, Value>,
    /// Results as numbers.
    pub result: Map<String, Value>,
    /// Phases in the order in which they ran.
    pub phases: Vec<Phase>,
    /// Seconds from start to the writing of this report.
    pub seconds: f64,
    /// Peak memory of the process, if the system provides it.
    pub peak_memory_bytes: Option<u64>,
    /// Warnings for the user.
    pub warnings: Vec<Warned>,
    /// Output files.
    pub outputs: Vec<Output>,
}

impl Report {
    /// Creates an empty report of a command.
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

    /// Adds the phases of a library step.
    pub fn phases_of(&mut self, step: &str, phases: &Phases) {
        for (name, time) in &phases.0 {
            self.phase(format!("{step}: {name}"), *time);
        }
    }

    /// Formats the report as JSON text.
    pub fn to_json(&self) -> String {
        // This cannot fail, since a report holds only strings, numbers and lists. NaN becomes null.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}

/// Peak resident memory of this process, from /proc (Linux only).
pub fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// The new number of each vertex for the report; null if all keep their numbers.
pub fn vertex_map(provenance: &Provenance, vertices: usize) -> Value {
    let new = |v: u32| provenance.new_vertex(Vertex(v)).map(|v| v.0);
    if provenance.keeps_vertices() { Value::Null } else { (0..vertices as u32).map(new).collect() }
}
