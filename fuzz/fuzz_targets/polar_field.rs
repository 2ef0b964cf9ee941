//! Polar fields on small arbitrary meshes, with arbitrary singularities and indices.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| eikona_fuzz::polar_field::check(bytes));
