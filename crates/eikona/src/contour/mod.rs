//! Isolines of a vertex field, plane cuts, and the export of curves as polylines.
//!
//! Isolines have the smaller values on their left, like the signed distance on a surface.

mod error;
mod export;
mod isolines;
mod levels;
mod plane_cut;

pub use error::ContourError;
pub use export::{FLATNESS_TOLERANCE, Polyline, obj_lines, ply_edges, polylines, svg_paths};
pub use isolines::{LevelSet, isolines};
pub use levels::{MAX_LEVELS, round_levels, spaced_levels};
pub use plane_cut::{Wave, plane_cut, wavy_plane_cut};
