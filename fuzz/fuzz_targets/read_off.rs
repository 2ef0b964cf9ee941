//! Arbitrary bytes as OFF.
#![no_main]

use eikona_mesh::io::MeshFormat;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| eikona_fuzz::readers::check(bytes, MeshFormat::Off));
