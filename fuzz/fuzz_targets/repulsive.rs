//! Tangent-point energies, motions and flows of small arbitrary meshes.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| eikona_fuzz::repulsive::check(bytes));
