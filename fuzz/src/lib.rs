//! Checks run by the fuzz targets. A check panics if the library breaks a promise; libFuzzer itself
//! detects panics, hangs and excessive memory use on bad input.

pub mod choices;
pub mod curves;
pub mod polar_field;
pub mod readers;
pub mod repulsive;
pub mod scenes;
pub mod solve;
pub mod winding;
