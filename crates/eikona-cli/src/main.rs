//! The command `eikona`: reads files, calls the library, prints and writes. It does no mathematics.

mod bench;
mod demo;
mod direction_files;
mod directions;
mod energy;
mod exit;
mod field;
mod field_file;
mod field_inspect;
mod input;
mod inspect;
mod isoline_file;
mod make;
mod number;
mod numpy;
mod picture;
mod progress;
mod quadrature;
mod render;
mod report;
mod repulse;
mod sdf;
mod seams;
mod session;
mod source;
mod stored_field;
mod warned;
mod winding;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Parser, Subcommand};
use exit::Failure;
use progress::say;
use session::General;
use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;

/// Signed distance and inside/outside labels from curves with gaps, noise and crossings, and
/// directions with prescribed singularities, on surface meshes
#[derive(Parser, Debug)]
#[command(name = "eikona", version, max_term_width = 110, after_help = AFTER_HELP)]
struct Cli {
    #[command(flatten)]
    general: General,
    #[command(subcommand)]
    verb: Verb,
}

const AFTER_HELP: &str = "Examples:
  eikona demo                                      mesh, broken curve, distance, directions, pictures
  eikona make torus -o torus.ply
  eikona torus.ply                                 same as: eikona inspect torus.ply
  eikona sdf torus.ply --points 0 -o distance.ply --render distance.png

Exit codes: 0 done, 1 failed, 2 bad usage, 3 bad input, 4 finished with warnings under --strict, 130 interrupted.";

#[derive(Subcommand, Debug)]
enum Verb {
    /// Compute signed distance to curves and points on a surface
    Sdf(Box<sdf::SdfArguments>),
    /// Label the regions inside and outside of curves by winding number
    Winding(Box<winding::WindingArguments>),
    /// Compute a field of N directions with prescribed singularities
    Field(Box<field::FieldArguments>),
    /// Report indices, turning and curl of a field of N vectors per face
    FieldInspect(Box<field_inspect::FieldInspectArguments>),
    /// Compute the tangent-point energy of a surface, which grows as it comes close to itself
    Energy(Box<energy::EnergyArguments>),
    /// Move a surface so that it never touches itself, down its tangent-point energy
    Repulse(Box<repulse::RepulseArguments>),
    /// Report the topology, quality and faults of a mesh and its curves
    Inspect(Box<inspect::InspectArguments>),
    /// Generate shapes and curves, optionally damaged
    Make(Box<make::MakeArguments>),
    /// Draw a mesh with its fields and curves as PNG
    Render(Box<render::RenderArguments>),
    /// Run a first example: make a mesh and a broken curve, compute distance and directions, draw
    Demo(demo::DemoArguments),
    /// Measure time, accuracy and memory on meshes with a known answer
    Bench(bench::BenchArguments),
    /// Print shell completions: eikona completions bash > /etc/bash_completion.d/eikona
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
}

fn main() -> ExitCode {
    let interrupted = || {
        eikona_mesh::io::discard_temporary_files();
        bench::remove_temporary_folder();
        say("interrupted; removed all temporary files");
        std::process::exit(i32::from(exit::INTERRUPTED));
    };
    if let Err(fault) = ctrlc::set_handler(interrupted) {
        say(&format!(
            "warning: cannot catch Ctrl-C ({fault}); an interruption may leave temporary files \
         behind"
        ));
    }
    ExitCode::from(run(std::env::args_os().collect()))
}

/// Runs a command line that starts with the program's name, and returns the exit code.
fn run(arguments: Vec<OsString>) -> u8 {
    let cli = match Cli::try_parse_from(with_inspect(arguments)) {
        Ok(cli) => cli,
        Err(mut message) => {
            give_hint(&mut message);
            // Help and version go to standard output and exit with 0. A failure to print them
            // cannot be reported anywhere.
            let _ = message.print();
            return if message.use_stderr() { exit::USAGE } else { 0 };
        }
    };
    let general = &cli.general;
    if let Some(threads) = general.threads {
        // This fails if an earlier command of the demo has set up the pool, with the same count.
        let _ = rayon::ThreadPoolBuilder::new().num_threads(usize::from(threads)).build_global();
    }
    let done = match &cli.verb {
        Verb::Sdf(arguments) => sdf::run(arguments, general),
        Verb::Winding(arguments) => winding::run(arguments, general),
        Verb::Field(arguments) => field::run(arguments, general),
        Verb::FieldInspect(arguments) => field_inspect::run(arguments, general),
        Verb::Energy(arguments) => energy::run(arguments, general),
        Verb::Repulse(arguments) => repulse::run(arguments, general),
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

/// Adds a hint to a usage error.
fn give_hint(message: &mut clap::Error) {
    let hint = match message.kind() {
        ErrorKind::InvalidSubcommand => {
            let verbs: Vec<String> =
                Cli::command().get_subcommands().map(|c| c.get_name().to_string()).collect();
            Some(format!("the commands are {}; a mesh file alone means inspect", verbs.join(", ")))
        }
        ErrorKind::UnknownArgument => match message.get(ContextKind::InvalidArg) {
            // A second file after the mesh.
            Some(ContextValue::String(word)) if Path::new(word).exists() => Some(format!(
                "only one mesh can be given; if {word} holds curves or points, pass it with --curve or \
                 --points"
            )),
            _ => None,
        },
        _ => return,
    };
    // Replaces clap's hint "to pass '-x' as a value, use '-- -x'", which misleads here: options
    // take negative numbers as they are, and file names rarely begin with a hyphen.
    match hint {
        Some(hint) => message.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![hint.into()])),
        None => message.remove(ContextKind::Suggested),
    };
}

/// Turns `eikona MESH` into `eikona inspect MESH`.
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
