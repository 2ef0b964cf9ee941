//! Timings of the phases of a computation.

use std::time::{Duration, Instant};

/// Names and durations of the phases of a computation, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Phases(pub Vec<(&'static str, Duration)>);

impl Phases {
    /// Starts timing the first phase.
    pub(crate) fn start() -> Running {
        Running { phases: Phases::default(), since: Instant::now() }
    }
    /// Total duration of all phases.
    pub fn total(&self) -> Duration {
        self.0.iter().map(|(_, d)| *d).sum()
    }
}

/// Finished phases and the start of the current one.
pub(crate) struct Running {
    phases: Phases,
    since: Instant,
}

impl Running {
    /// Ends the current phase under this name and starts the next.
    pub fn end(&mut self, name: &'static str) {
        let now = Instant::now();
        self.phases.0.push((name, now - self.since));
        self.since = now;
    }
    /// Returns all finished phases.
    pub fn finish(self) -> Phases {
        self.phases
    }
}
