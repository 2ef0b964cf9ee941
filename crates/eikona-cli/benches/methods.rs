//! `cargo bench -p eikona-cli`: what `eikona bench` measures at two sizes, built as that command
//! is.

use std::process::{Command, ExitCode};

fn main() -> ExitCode {
    // Only `cargo bench` gives this word: tests that list or run all targets have nothing to do
    // here.
    if !std::env::args().any(|word| word == "--bench") {
        return ExitCode::SUCCESS;
    }
    for method in ["sdf", "winding"] {
        match Command::new(env!("CARGO_BIN_EXE_eikona"))
            .args(["bench", method, "--faces", "20000,100000"])
            .status()
        {
            Ok(status) if status.success() => {}
            Ok(_) => return ExitCode::FAILURE,
            Err(fault) => {
                eprintln!("error: the command eikona can not be started: {fault}");
                return ExitCode::FAILURE;
            }
        }
    }
    ExitCode::SUCCESS
}
