//! Scene files in both grammars.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| eikona_fuzz::scenes::check(bytes));
