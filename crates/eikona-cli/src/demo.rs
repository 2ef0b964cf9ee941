//! `eikona demo`: makes a mesh and a broken curve, computes the distance and a cross field, and
//! draws them, by running the commands that it prints.

use crate::exit::Failure;
use crate::progress::say;
use crate::session::{General, check_output};
use clap::Args;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Arguments of `eikona demo`.
#[derive(Args, Clone, Debug)]
#[command(after_help = "Example:
  eikona demo")]
pub struct DemoArguments {
    /// Output folder; created if it does not exist
    #[arg(short, long, value_name = "DIR", default_value = "eikona-demo")]
    pub output: PathBuf,
}

/// The commands: make a mesh and a curve with 60 % of its length kept, compute the distance to it,
/// and a cross field with automatic singularities. `DIR` stands for the folder and `REPORT` for the
/// report of the second command.
const COMMANDS: [&str; 3] = [
    "make clay_animal levels=5 -o DIR/animal.ply --broken-curve DIR/broken-loop.json \
     --cut axis=x,at=0,wave=0.13,waves=7,about=0:1.1:0.8 --keep 0.06 --drop 0.04 --seed 3",
    "sdf DIR/animal.ply --curve DIR/broken-loop.json -o DIR/distance.ply --isolines DIR/isolines.obj --render DIR/distance.png \
     --report REPORT",
    "field DIR/animal.ply --auto -o DIR/cross.rawfield --streamlines DIR/streamlines.obj --render DIR/field.png",
];

/// Runs the commands through `run`, which takes a command line that starts with the program's name.
/// Returns the exit code.
pub fn run(
    arguments: &DemoArguments,
    general: &General,
    run: impl Fn(Vec<OsString>) -> u8,
) -> Result<u8, Failure> {
    let folder = &arguments.output;
    general.report.as_deref().map_or(Ok(()), check_output)?;
    std::fs::create_dir_all(folder).map_err(|fault| {
        Failure::Failed(format!(
            "{}: cannot create this folder ({fault}); choose another one with -o DIR",
            folder.display()
        ))
    })?;
    let report = general.report.clone().unwrap_or_else(|| folder.join("report.json"));
    for command in COMMANDS {
        let words: Vec<OsString> =
            command.split_whitespace().map(|word| filled_in(word, folder, &report)).collect();
        if general.quiet == 0 {
            say(&format!("$ eikona {}", shown(&words)));
        }
        let flags = forwarded_flags(general);
        let code = run([OsString::from("eikona")].into_iter().chain(words).chain(flags).collect());
        if code != 0 {
            return Ok(code);
        }
    }
    if general.quiet == 0 {
        let [distance, field] = ["distance.png", "field.png"].map(|name| folder.join(name));
        say(&format!("see {} and {}", distance.display(), field.display()));
    }
    Ok(0)
}

/// A word of [`COMMANDS`] with the file names filled in.
fn filled_in(word: &str, folder: &Path, report: &Path) -> OsString {
    match word.strip_prefix("DIR/") {
        Some(name) => folder.join(name).into_os_string(),
        None if word == "REPORT" => report.into(),
        None => word.into(),
    }
}

/// The command as a user would type it.
fn shown(words: &[OsString]) -> String {
    let quoted = |word: &OsString| {
        let word = word.to_string_lossy();
        if word.contains(char::is_whitespace) { format!("'{word}'") } else { word.into_owned() }
    };
    words.iter().map(quoted).collect::<Vec<_>>().join(" ")
}

fn forwarded_flags(general: &General) -> Vec<OsString> {
    let mut flags = vec![OsString::from("-q"); usize::from(general.quiet)];
    if let Some(threads) = general.threads {
        flags.extend(["--threads".into(), threads.to_string().into()]);
    }
    for (given, flag) in
        [(general.timings, "--timings"), (general.strict, "--strict"), (general.verbose, "-v")]
    {
        flags.extend(given.then(|| flag.into()));
    }
    flags
}
