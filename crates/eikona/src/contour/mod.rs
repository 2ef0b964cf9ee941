//! Curves over a mesh: polylines traced across its faces, shortest paths, plane cuts, isolines of a
//! vertex field, what is wrong with a set of curves, meshes cut along curves, and the export of
//! curves.
//!
//! Every curve made here has each segment in one closed face, so that it goes straight into the
//! methods as a source. Isolines run with the smaller values on their left, as a signed distance on
//! a surface has it.

mod embed;
mod error;
mod export;
mod funnel;
mod inspect_curve;
mod isolines;
mod levels;
mod meeting;
pub(crate) mod nearest_end;
mod plane_cut;
mod shortest;
pub(crate) mod side;
mod straighten;
mod trace;
mod vertex_path;
mod walk;

pub use embed::{ChainEdge, CurveChain, EmbedError, Embedded, EmbeddedCurve, SHORT, Walk, embed_curves};
pub(crate) use embed::{areas_of_pieces, label_of_most, parts_of_short_edges, places_of_places, weights_in};
pub use error::ContourError;
pub use export::{FLAT, Polyline, obj_lines, ply_edges, polylines, svg_paths};
pub use inspect_curve::{CurveFacts, CurveReport, Doubled, LISTED, Meeting, MeetingKind, OpenEnd, SegmentId};
pub use isolines::{LevelSet, isolines};
pub use levels::{MAX_LEVELS, round_levels, spaced_levels};
pub use plane_cut::{Wave, plane_cut, wavy_plane_cut};
pub use straighten::straighten_curve;
pub(crate) use straighten::{path_length, straighten_around, straighten_loop};
pub use trace::{DEFAULT_TOLERANCE, Traced, trace_curve, trace_polyline};
pub use vertex_path::shortest_vertex_path;
