//! `eikona bench`: times the phases of each method. Each size runs in its own process.

mod case;
mod field;
mod peer;
mod repulse;
mod sdf;
mod winding;

pub use peer::remove_temporary_folder;

use crate::exit::Failure;
use crate::session::{General, Session, print_bytes};
use clap::{Args, Subcommand};
use serde::{Deserialize, Serialize};
use std::process::{Command, Stdio};

/// Arguments of `eikona bench`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Examples:
  eikona bench sdf --faces 5000
  eikona bench winding --shape double-torus --faces 35000")]
pub struct BenchArguments {
    #[command(subcommand)]
    pub method: Method,
}

/// Methods to measure.
#[derive(Subcommand, Clone, Debug)]
pub enum Method {
    /// Signed distance on a surface
    Sdf(sdf::SdfBench),
    /// Surface winding numbers
    Winding(winding::WindingBench),
    /// Power-linear polar fields
    Field(field::FieldBench),
    /// Repulsive surfaces
    Repulse(repulse::RepulseBench),
}

/// Runs the command and returns the exit code.
pub fn run(arguments: &BenchArguments, general: &General) -> Result<u8, Failure> {
    match &arguments.method {
        Method::Sdf(arguments) => sdf::run(arguments, general),
        Method::Winding(arguments) => winding::run(arguments, general),
        Method::Field(arguments) => field::run(arguments, general),
        Method::Repulse(arguments) => repulse::run(arguments, general),
    }
}

fn parse_faces(text: &str) -> Result<usize, String> {
    const MOST: usize = 100_000_000;
    text.parse().ok().filter(|n| (1..=MOST).contains(n)).ok_or("expected a number from 1 to 100000000".into())
}

/// A command that starts this program again.
fn this_program() -> Result<Command, Failure> {
    let program = std::env::current_exe().map_err(|e| {
        Failure::Failed(format!("cannot find the path of this program to start it again: {e}"))
    })?;
    Ok(Command::new(program))
}

/// Runs a program and parses the JSON that it prints.
fn output_json<T: for<'a> Deserialize<'a>>(command: &mut Command) -> Result<T, Failure> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command
        .stdin(Stdio::null())
        .stderr(Stdio::piped())
        .output()
        .map_err(|e| Failure::Failed(format!("{name}: cannot start this program: {e}")))?;
    if !output.status.success() {
        let message = String::from_utf8_lossy(&output.stderr);
        let message = message.trim().trim_start_matches("error: ").to_string();
        return Err(match output.status.code() {
            Some(2) => Failure::Usage(message),
            Some(3) => Failure::Input(message),
            _ => Failure::Failed(format!("{name} failed with {}: {message}", output.status)),
        });
    }
    serde_json::from_slice(&output.stdout)
        .map_err(|e| Failure::Failed(format!("{name} printed invalid results: {e}")))
}

/// Prints the results of this process and returns the exit code.
fn printed(run: &impl Serialize) -> Result<u8, Failure> {
    let text = serde_json::to_string(run).map_err(|e| Failure::Failed(e.to_string()))?;
    print_bytes(text.as_bytes()).map(|()| 0)
}

/// Adds all runs to the report, and prints them as JSON on request.
fn print_json(
    method: &str,
    runs: &[impl Serialize],
    wanted: bool,
    session: &mut Session,
) -> Result<(), Failure> {
    let value = serde_json::json!({
        "eikona": "bench", "version": 1, "tool_version": env!("CARGO_PKG_VERSION"), "method": method, "runs": runs,
    });
    if wanted {
        print_bytes((serde_json::to_string_pretty(&value).unwrap_or_default() + "\n").as_bytes())?;
    }
    session.report.result.insert("bench".into(), value);
    Ok(())
}

fn megabytes(bytes: Option<u64>) -> String {
    bytes.map_or("?".to_string(), |b| match b as f64 / 1e6 {
        few if few < 10.0 => format!("{few:.2} MB"),
        many => format!("{many:.0} MB"),
    })
}
