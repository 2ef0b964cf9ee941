//! `cargo bench -p eikona-cli`: what `eikona bench sdf` measures at two sizes, built as that command is.

use std::process::{Command, ExitCode};

fn main() -> ExitCode {
    // Only `cargo bench` gives this word: tests that list or run all targets have nothing to do here.
    if !std::env::args().any(|word| word == "--bench") {
        return ExitCode::SUCCESS;
    }
    match Command::new(env!("CARGO_BIN_EXE_eikona"))
        .args(["bench", "sdf", "--faces", "20000,100000"])
        .status()
    {
        Ok(status) if status.success() => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(fault) => {
            eprintln!("error: the command eikona can not be started: {fault}");
            ExitCode::FAILURE
        }
    }
}
