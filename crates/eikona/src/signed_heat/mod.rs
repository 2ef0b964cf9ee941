//! story to be written
mod confidence;
mod diffusion;
mod error;
mod integration;
mod options;
mod report;
mod side;
mod solution;
mod solver;
mod source;
mod time;

pub use error::SignedHeatError;
pub use options::{DiffusionTime, LevelSets, SignConvention, SolveOptions, SolverOptions};
pub use report::{Phases, Preparation, Report};
pub use solution::{Confidence, Solution};
pub use solver::Solver;
pub use time::ChosenTime;
