//! `cargo bench -p eikona-cli`: runs `eikona bench` at two sizes, with the same build settings.

use std::process::{Command, ExitCode};

fn main() -> ExitCode {
    // Only `cargo bench` passes this argument; test runs over all targets should do nothing here.
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
                eprintln!("error: cannot start eikona: {fault}");
                return ExitCode::FAILURE;
            }
        }
    }
    ExitCode::SUCCESS
}
