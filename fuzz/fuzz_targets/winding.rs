//! A small mesh of any shape, any curves, any options.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| eikona_fuzz::winding::check(bytes));
