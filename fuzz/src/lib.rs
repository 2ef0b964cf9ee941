//! What the fuzz targets check. A check panics when the library breaks a promise; whatever the
//! library itself does with bad input (panic, hang, take too much memory) is seen by libFuzzer.

pub mod choices;
pub mod curves;
pub mod readers;
pub mod solve;
pub mod winding;
