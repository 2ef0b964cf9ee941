//! A progress line on the terminal that names the current phase after the first second.

use eikona::numeric::Observer;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::ops::ControlFlow;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Commands that finish sooner show nothing.
const PATIENCE: Duration = Duration::from_secs(1);
const TICK: Duration = Duration::from_millis(120);

/// Prints a line to standard error. Failures are ignored, so that a closed pipe (`2>&1 | head`)
/// does not stop the work.
pub fn say(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// The progress line. Disappears when dropped.
#[derive(Default)]
pub struct Progress {
    shared: Arc<(Mutex<State>, Condvar)>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct State {
    phase: String,
    bar: Option<ProgressBar>,
    finished: bool,
}

impl Progress {
    /// Creates a line that appears after a second if wanted and standard error is a terminal.
    pub fn new(wanted: bool) -> Progress {
        let mut progress = Progress::default();
        if wanted && std::io::stderr().is_terminal() {
            let shared = Arc::clone(&progress.shared);
            progress.thread = Some(std::thread::spawn(move || show_later(&shared)));
        }
        progress
    }

    /// Sets the name of the current phase.
    pub fn phase(&self, name: &str) {
        show(&self.shared, name.to_string());
    }

    /// Returns an observer that shows the phases of a solver, after the name of the step.
    pub fn observer(&self, step: &str) -> impl Observer + 'static {
        let (shared, step) = (Arc::clone(&self.shared), step.to_string());
        move |phase: &'static str, fraction: Option<f64>| {
            let percent = fraction.map_or(String::new(), |f| format!(" {:.0} %", 100.0 * f));
            show(&shared, format!("{step}: {phase}{percent}"));
            ControlFlow::Continue(())
        }
    }

    /// Prints a line to standard error without disturbing the progress line.
    pub fn print(&self, text: &str) {
        let state = self.shared.0.lock().unwrap_or_else(PoisonError::into_inner);
        match &state.bar {
            Some(bar) => bar.suspend(|| say(text)),
            None => say(text),
        }
    }
}

fn show(shared: &(Mutex<State>, Condvar), phase: String) {
    let mut state = shared.0.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(bar) = &state.bar {
        bar.set_message(phase.clone());
    }
    state.phase = phase;
}

fn show_later(shared: &(Mutex<State>, Condvar)) {
    let state = shared.0.lock().unwrap_or_else(PoisonError::into_inner);
    let waited = shared.1.wait_timeout_while(state, PATIENCE, |s| !s.finished);
    let mut state = waited.unwrap_or_else(PoisonError::into_inner).0;
    if state.finished {
        return;
    }
    let bar = ProgressBar::new_spinner().with_message(state.phase.clone());
    if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} ({elapsed})") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(TICK);
    state.bar = Some(bar);
}

impl Drop for Progress {
    fn drop(&mut self) {
        let bar = {
            let mut state = self.shared.0.lock().unwrap_or_else(PoisonError::into_inner);
            state.finished = true;
            state.bar.take()
        };
        self.shared.1.notify_all();
        if let Some(bar) = bar {
            bar.finish_and_clear();
        }
        if let Some(thread) = self.thread.take() {
            // A failure of the drawing thread does not matter.
            let _ = thread.join();
        }
    }
}
