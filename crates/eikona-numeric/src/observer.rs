//! Progress of long computations, and how to stop them.
//!
//! An observer is installed for everything that runs inside a closure, like a thread pool or a
//! subscriber of log messages, so that no function needs a variant with an observer.

use crate::NumericError;
use std::cell::RefCell;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Receives the progress of a computation and may stop it. Implemented for closures.
pub trait Observer: Send + Sync {
    /// Receives the current phase, and the share of it that is done, if known. `Break` stops the
    /// computation, which fails with [`NumericError::Stopped`]. Called at the beginning of each
    /// phase and about fifty times a second, from any thread of the computation, but by one at a
    /// time.
    fn progress(&self, phase: &'static str, fraction: Option<f64>) -> ControlFlow<()>;
}

impl<F: Fn(&'static str, Option<f64>) -> ControlFlow<()> + Send + Sync> Observer for F {
    fn progress(&self, phase: &'static str, fraction: Option<f64>) -> ControlFlow<()> {
        self(phase, fraction)
    }
}

/// Runs some work while `observer` receives the progress of all solvers in it, and may stop them.
///
/// An observer replaces that of an enclosing call until the work ends. A solver that was stopped
/// leaves nothing behind; what ran before it in the same closure is not undone.
///
/// ```
/// use eikona_numeric::{Graph, NumericError, Ordering, Symbolic, observed};
/// use std::ops::ControlFlow;
/// let path = Graph { unknowns: 100, pairs: (1..100).map(|i| [i - 1, i]).collect() };
/// let stop = |_: &'static str, _: Option<f64>| ControlFlow::Break(());
/// let stopped = observed(stop, || Symbolic::new(&path, Ordering::MinimumDegree));
/// assert!(matches!(stopped, Err(NumericError::Stopped)));
/// assert!(Symbolic::new(&path, Ordering::MinimumDegree).is_ok());
/// ```
pub fn observed<R>(observer: impl Observer + 'static, work: impl FnOnce() -> R) -> R {
    let now = Instant::now();
    let watch = Watch {
        observer: Box::new(observer),
        phase: Mutex::new(("", None)),
        stopped: AtomicBool::new(false),
        start: now,
        next: AtomicU64::new(0),
    };
    CurrentObserver(Some(Arc::new(watch))).install(work)
}

/// Begins a phase. Fails if the observer stops the computation.
///
/// # Errors
/// [`NumericError::Stopped`].
pub fn begin_phase(name: &'static str) -> Result<(), NumericError> {
    CurrentObserver::get().0.map_or(Ok(()), |watch| watch.report(|phase| *phase = (name, None)))
}

/// Lets the observer stop the computation. Costs some nanoseconds; to be called at least every few
/// milliseconds.
///
/// # Errors
/// [`NumericError::Stopped`].
pub fn check_stopped() -> Result<(), NumericError> {
    due_watch()?.map_or(Ok(()), |watch| watch.report(|_| ()))
}

/// Lets the observer stop a loop of short steps: [`check_stopped`] at every 1024th step.
///
/// # Errors
/// [`NumericError::Stopped`].
#[inline]
pub fn check_step(step: usize) -> Result<(), NumericError> {
    if step.is_multiple_of(1024) { check_stopped() } else { Ok(()) }
}

/// Like [`check_stopped`], with the share of the phase that is done.
pub(crate) fn check_at(fraction: impl FnOnce() -> f64) -> Result<(), NumericError> {
    due_watch()?.map_or(Ok(()), |watch| watch.report(|phase| phase.1 = Some(fraction())))
}

/// Returns the watch of this thread if its observer is to be called now.
fn due_watch() -> Result<Option<Arc<Watch>>, NumericError> {
    CURRENT.with_borrow(|current| match &current.0 {
        Some(watch) if watch.stopped.load(Relaxed) => Err(NumericError::Stopped),
        Some(watch) if watch.now() >= watch.next.load(Relaxed) => Ok(Some(watch.clone())),
        _ => Ok(None),
    })
}

thread_local! {
    static CURRENT: RefCell<CurrentObserver> = const { RefCell::new(CurrentObserver(None)) };
}

/// The observer of a thread, to be installed in the threads that it starts.
#[derive(Clone, Default)]
pub(crate) struct CurrentObserver(Option<Arc<Watch>>);

impl CurrentObserver {
    /// Returns the observer of this thread.
    pub fn get() -> CurrentObserver {
        CURRENT.with_borrow(CurrentObserver::clone)
    }

    /// Runs some work with this observer.
    pub fn install<R>(self, work: impl FnOnce() -> R) -> R {
        /// Restores the previous observer, also after a panic.
        struct Restore(CurrentObserver);
        impl Drop for Restore {
            fn drop(&mut self) {
                CURRENT.set(std::mem::take(&mut self.0));
            }
        }
        let _restore = Restore(CURRENT.replace(self));
        work()
    }
}

/// Time between two calls of the observer.
const INTERVAL_MICROSECONDS: u64 = 20_000;

/// Name of a phase, and the share of it that is done, if known.
type Phase = (&'static str, Option<f64>);

struct Watch {
    observer: Box<dyn Observer>,
    phase: Mutex<Phase>,
    stopped: AtomicBool,
    start: Instant,
    /// When the observer is called next, in microseconds from the start.
    next: AtomicU64,
}

impl Watch {
    fn now(&self) -> u64 {
        self.start.elapsed().as_micros() as u64
    }

    /// Calls the observer after this change of the phase.
    fn report(&self, change: impl FnOnce(&mut Phase)) -> Result<(), NumericError> {
        // The lock is held during the call: one thread at a time, in order.
        let mut phase = self.phase.lock().unwrap_or_else(PoisonError::into_inner);
        change(&mut phase);
        self.next.store(self.now() + INTERVAL_MICROSECONDS, Relaxed);
        if !self.stopped.load(Relaxed) && self.observer.progress(phase.0, phase.1).is_break() {
            self.stopped.store(true, Relaxed);
        }
        if self.stopped.load(Relaxed) { Err(NumericError::Stopped) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;
    use std::time::Duration;

    #[test]
    fn phases_and_fractions_arrive_and_a_stop_lasts_until_the_end() {
        let (send, received) = mpsc::channel();
        let send = Mutex::new(send);
        let observer = move |phase: &'static str, fraction: Option<f64>| {
            send.lock().unwrap().send((phase, fraction)).unwrap();
            if fraction > Some(0.4) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        observed(observer, || {
            begin_phase("analysis").unwrap();
            begin_phase("factorisation").unwrap();
            let pause = || std::thread::sleep(Duration::from_micros(2 * INTERVAL_MICROSECONDS));
            pause();
            check_at(|| 0.25).unwrap();
            pause();
            std::thread::scope(|scope| {
                let current = CurrentObserver::get();
                let other = scope.spawn(|| current.install(|| check_at(|| 0.5)));
                assert_eq!(other.join().unwrap(), Err(NumericError::Stopped));
            });
            assert_eq!(check_stopped(), Err(NumericError::Stopped));
            assert_eq!(begin_phase("labels"), Err(NumericError::Stopped));
        });
        assert_eq!(check_stopped(), Ok(()));
        let all: Vec<_> = received.iter().collect();
        let factorisation = |fraction| ("factorisation", fraction);
        let expected = [None, Some(0.25), Some(0.5)].map(factorisation);
        assert_eq!(all, [&[("analysis", None)], &expected[..]].concat());
    }

    #[test]
    fn an_inner_observer_replaces_the_outer_one_also_inside_the_callback() {
        let outer = |_: &'static str, _: Option<f64>| {
            let inner = observed(|_: &'static str, _: Option<f64>| ControlFlow::Continue(()), check_stopped);
            assert_eq!(inner, Ok(()));
            ControlFlow::Break(())
        };
        observed(outer, || assert_eq!(check_stopped(), Err(NumericError::Stopped)));
    }

    #[test]
    fn the_outer_observer_returns_after_a_panic() {
        let stop = |_: &'static str, _: Option<f64>| ControlFlow::Break(());
        observed(stop, || {
            let go_on = |_: &'static str, _: Option<f64>| ControlFlow::Continue(());
            let panicked = std::panic::catch_unwind(|| observed(go_on, || panic!("on purpose")));
            assert!(panicked.is_err());
            assert_eq!(check_stopped(), Err(NumericError::Stopped));
        });
    }
}
