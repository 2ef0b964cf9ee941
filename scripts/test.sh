#!/bin/sh
# All checks of the project, on any machine with a Rust toolchain: layers, comment width, formatting, lints, documentation, tests.
# Tests read the data folder ../shared/data where it is there, and say how many files they ran.
set -eu
cd "$(dirname "$0")/.."
sh scripts/check_layers.sh
sh scripts/check_comments.sh
if cargo fmt --version >/dev/null 2>&1; then cargo fmt --all --check; fi
if cargo clippy --version >/dev/null 2>&1; then cargo clippy --workspace --all-targets --profile test -- -D warnings; fi
# The fuzz targets are a workspace of their own, and need a C++ compiler.
if c++ --version >/dev/null 2>&1; then cargo check --quiet --manifest-path fuzz/Cargo.toml; fi
RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --quiet --profile test
cargo test --workspace
