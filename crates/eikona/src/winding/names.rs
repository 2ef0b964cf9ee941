//! Options of winding numbers as text, for hosts such as the command line.

use crate::option_name::option_names;
use crate::winding::options::{Completion, CompletionShape, Diagnosis};

option_names!(Completion, "full" => Completion::Full, "curve" => Completion::Curve);
option_names!(
    CompletionShape,
    "straight" => CompletionShape::Straight,
    "edges" => CompletionShape::Edges,
);
option_names!(
    Diagnosis,
    "auto" => Diagnosis::Automatic,
    "always" => Diagnosis::Always,
    "never" => Diagnosis::Never,
);
