//! The signed heat method on a small arbitrary mesh, with arbitrary curves and options.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| eikona_fuzz::solve::check(bytes));
