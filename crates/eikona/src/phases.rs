//! Phases of a computation: their timings, and progress for an observer.

use eikona_numeric::{NumericError, begin_phase};
use std::time::{Duration, Instant};

/// Names and durations of the phases of a computation, in the order in which they began. A phase
/// that ran several times is listed once, with its total.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Phases(pub Vec<(&'static str, Duration)>);

impl Phases {
    /// Begins the first phase. Fails if the observer stops the computation.
    pub(crate) fn begin(name: &'static str) -> Result<Running, NumericError> {
        begin_phase(name)?;
        Ok(Running { phases: Phases::default(), name, since: Instant::now() })
    }
    /// Total duration of all phases.
    pub fn total(&self) -> Duration {
        self.0.iter().map(|(_, d)| *d).sum()
    }
    /// Adds time to a phase.
    pub(crate) fn add(&mut self, name: &'static str, time: Duration) {
        match self.0.iter_mut().find(|(known, _)| *known == name) {
            Some((_, total)) => *total += time,
            None => self.0.push((name, time)),
        }
    }
}

/// Finished phases and the current one.
pub(crate) struct Running {
    phases: Phases,
    name: &'static str,
    since: Instant,
}

impl Running {
    /// Ends the current phase and begins the next. Fails if the observer stops the computation.
    pub fn next(&mut self, name: &'static str) -> Result<(), NumericError> {
        let now = Instant::now();
        self.phases.add(self.name, now - self.since);
        (self.name, self.since) = (name, now);
        begin_phase(name)
    }
    /// Ends the last phase and returns all.
    pub fn finish(mut self) -> Phases {
        self.phases.add(self.name, self.since.elapsed());
        self.phases
    }
}
