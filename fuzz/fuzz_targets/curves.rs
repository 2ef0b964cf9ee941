//! Arbitrary bytes as a curve file on a small mesh.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| eikona_fuzz::curves::check(bytes));
