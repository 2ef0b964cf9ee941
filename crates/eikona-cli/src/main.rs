//! The command `eikona`: it reads files, calls the library, prints and writes. No mathematics is
//! done here.

mod bench;
mod demo;
mod exit;
mod field_file;
mod input;
mod inspect;
mod isoline_file;
mod make;
mod number;
mod picture;
mod progress;
mod render;
mod report;
mod sdf;
mod seams;
mod session;
mod source;
mod winding;
mod winding_file;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Parser, Subcommand};
use exit::Failure;
use progress::say;
use session::General;
use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;

/// Signed distance to broken curves on real meshes, and the tools around it.
#[derive(Parser, Debug)]
#[command(name = "eikona", version, max_term_width = 110, after_help = AFTER_HELP)]
struct Cli {
    #[command(flatten)]
    general: General,
    #[command(subcommand)]
    verb: Verb,
}

const AFTER_HELP: &str = "Examples:
  eikona demo                                      a mesh, a broken curve, its distance, a picture
  eikona make torus -o torus.ply
  eikona torus.ply                                 the same as: eikona inspect torus.ply
  eikona sdf torus.ply --points 0 -o distance.ply --render distance.png

Exit codes: 0 done, 1 failed, 2 bad usage, 3 bad input, 4 finished with warnings under --strict, 130 interrupted.";

#[derive(Subcommand, Debug)]
enum Verb {
    /// Signed distance on a surface to curves and points
    Sdf(Box<sdf::SdfArguments>),
    /// Inside or outside of curves on a surface, and how often
    Winding(Box<winding::WindingArguments>),
    /// What a mesh is and what is wrong with it; curves too
    Inspect(Box<inspect::InspectArguments>),
    /// Procedural shapes, damaged on request, and curves on them
    Make(Box<make::MakeArguments>),
    /// A picture of a mesh, its fields and curves
    Render(Box<render::RenderArguments>),
    /// Makes a mesh and a broken curve, measures, draws: a first look
    Demo(demo::DemoArguments),
    /// Phases, accuracy and memory on meshes with a known answer
    Bench(bench::BenchArguments),
    /// Completions for a shell, to the standard output: eikona completions bash >
    /// /etc/bash_completion.d/eikona
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
}

fn main() -> ExitCode {
    let interrupted = || {
        eikona_mesh::io::discard_temporary_files();
        bench::remove_temporary_folder();
        say("interrupted; no output was left behind");
        std::process::exit(i32::from(exit::INTERRUPTED));
    };
    if let Err(fault) = ctrlc::set_handler(interrupted) {
        say(&format!("warning: an interruption may leave temporary files behind: {fault}"));
    }
    ExitCode::from(run(std::env::args_os().collect()))
}

/// Runs the command line, with the program's name in front. Gives the exit code.
fn run(arguments: Vec<OsString>) -> u8 {
    let cli = match Cli::try_parse_from(with_inspect(arguments)) {
        Ok(cli) => cli,
        Err(mut message) => {
            give_hint(&mut message);
            // Help and version go to the standard output and are no failure. There is nobody to
            // tell if printing fails.
            let _ = message.print();
            return if message.use_stderr() { exit::USAGE } else { 0 };
        }
    };
    let general = &cli.general;
    if let Some(threads) = general.threads {
        // A pool that was set up by an earlier verb of the same run serves as well.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads)).build_global();
    }
    let done = match &cli.verb {
        Verb::Sdf(arguments) => sdf::run(arguments, general),
        Verb::Winding(arguments) => winding::run(arguments, general),
        Verb::Inspect(arguments) => inspect::run(arguments, general),
        Verb::Make(arguments) => make::run(arguments, general),
        Verb::Render(arguments) => render::run(arguments, general),
        Verb::Demo(arguments) => demo::run(arguments, general, run),
        Verb::Bench(arguments) => bench::run(arguments, general),
        Verb::Completions { shell } => {
            let mut text = Vec::new();
            clap_complete::generate(*shell, &mut Cli::command(), "eikona", &mut text);
            session::print_bytes(&text).map(|()| 0)
        }
    };
    done.unwrap_or_else(|failure: Failure| {
        say(&format!("error: {failure}"));
        failure.code()
    })
}

/// Adds what would help to a message about the command line.
fn give_hint(message: &mut clap::Error) {
    let hint = match message.kind() {
        ErrorKind::InvalidSubcommand => {
            let verbs: Vec<String> =
                Cli::command().get_subcommands().map(|c| c.get_name().to_string()).collect();
            Some(format!("the verbs are {}; a mesh file alone means inspect", verbs.join(", ")))
        }
        ErrorKind::UnknownArgument => match message.get(ContextKind::InvalidArg) {
            // A second file beside the mesh.
            Some(ContextValue::String(word)) if Path::new(word).exists() => Some(format!(
                "one mesh is taken at a time; if {word} holds curves or points, give it with --curve or --points"
            )),
            _ => None,
        },
        _ => return,
    };
    // This takes the place of "to pass '-x' as a value, use '-- -x'": no name or number here begins
    // with a hyphen.
    match hint {
        Some(hint) => message.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![hint.into()])),
        None => message.remove(ContextKind::Suggested),
    };
}

/// `eikona MESH` means `eikona inspect MESH`.
fn with_inspect(mut arguments: Vec<OsString>) -> Vec<OsString> {
    if let Some(first) = arguments.get(1) {
        let is_verb = Cli::command().get_subcommands().any(|c| first == c.get_name());
        let path = Path::new(first);
        let is_mesh = path.exists() || eikona_mesh::io::MeshFormat::from_path(path).is_some();
        if !is_verb && is_mesh && first != "help" {
            arguments.insert(1, "inspect".into());
        }
    }
    arguments
}
