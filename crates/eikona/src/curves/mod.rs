//! Curves on a mesh: tracing of polylines across faces, shortest paths in a homotopy class, the
//! left side of a curve, and reports of defects in a set of curves.
//!
//! Every segment of a curve made here lies in one closed face, as the methods require.

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
pub use report::{CurveFacts, CurveReport, MAX_LISTED, Meeting, MeetingKind, OpenEnd, Overlap, SegmentId};
pub use straighten::straighten_curve;
pub(crate) use straighten::{path_length, straighten_around, straighten_loop};
pub use trace::{DEFAULT_TOLERANCE, Traced, trace_curve, trace_polyline};
pub use vertex_path::shortest_vertex_path;
