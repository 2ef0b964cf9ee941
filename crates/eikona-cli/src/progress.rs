//! A line on the terminal that says what is being done, once the command has run for a second.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::{IsTerminal, Write};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Quick commands show nothing.
const PATIENCE: Duration = Duration::from_secs(1);
const TICK: Duration = Duration::from_millis(120);

/// Prints a line to the standard error. When nobody reads it (`2>&1 | head`) the work goes on.
pub fn say(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{text}");
}

/// The line. It goes away when dropped.
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
    /// A line that appears after a second if standard error is a terminal; otherwise nothing ever
    /// appears.
    pub fn new(wanted: bool) -> Progress {
        let mut progress = Progress::default();
        if wanted && std::io::stderr().is_terminal() {
            let shared = Arc::clone(&progress.shared);
            progress.thread = Some(std::thread::spawn(move || show_later(&shared)));
        }
        progress
    }

    /// What is being done from now on.
    pub fn phase(&self, name: &str) {
        let mut state = self.shared.0.lock().unwrap_or_else(PoisonError::into_inner);
        state.phase = name.to_string();
        if let Some(bar) = &state.bar {
            bar.set_message(name.to_string());
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
            // A thread that only draws a line has nothing to say.
            let _ = thread.join();
        }
    }
}
