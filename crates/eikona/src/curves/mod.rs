//! Curves on a mesh: polylines traced across its faces, shortest paths in a homotopy class, the
//! left side of a curve, and reports of what is wrong with a set of curves.
//!
//! Every curve made here has each segment in one closed face, so that the methods take it as it is.

mod error;
mod funnel;
mod meeting;
pub(crate) mod nearest_end;
mod report;
mod shortest;
pub(crate) mod side;
mod straighten;
mod trace;
mod vertex_path;
mod walk;

pub use error::TraceError;
pub use report::{CurveFacts, CurveReport, Doubled, LISTED, Meeting, MeetingKind, OpenEnd, SegmentId};
pub use straighten::straighten_curve;
pub(crate) use straighten::{path_length, straighten_around, straighten_loop};
pub use trace::{DEFAULT_TOLERANCE, Traced, trace_curve, trace_polyline};
pub use vertex_path::shortest_vertex_path;
