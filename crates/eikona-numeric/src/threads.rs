//! Tasks that run at the same time, under the observer of the thread that starts them.

use crate::observer::CurrentObserver;

/// Runs all tasks at the same time, the first on this thread, and returns their results in order.
///
/// ```
/// let squares = eikona_numeric::together((1..4).map(|n| move || n * n));
/// assert_eq!(squares, [1, 4, 9]);
/// ```
pub fn together<R: Send, F: FnOnce() -> R + Send>(tasks: impl IntoIterator<Item = F>) -> Vec<R> {
    let observer = CurrentObserver::get();
    std::thread::scope(|scope| {
        let mut tasks = tasks.into_iter();
        let first = tasks.next();
        let start = |task: F| {
            let observer = observer.clone();
            scope.spawn(move || observer.install(task))
        };
        let others: Vec<_> = tasks.map(start).collect();
        let first = first.map(|task| task());
        first.into_iter().chain(others.into_iter().map(joined)).collect()
    })
}

/// Runs two tasks, at the same time if there are at least two threads.
///
/// ```
/// assert_eq!(eikona_numeric::side_by_side(2, || 1 + 1, || "two"), (2, "two"));
/// ```
pub fn side_by_side<A: Send, B>(
    threads: usize,
    first: impl FnOnce() -> A + Send,
    second: impl FnOnce() -> B,
) -> (A, B) {
    if threads < 2 {
        return (first(), second());
    }
    let observer = CurrentObserver::get();
    std::thread::scope(|scope| {
        let first = scope.spawn(|| observer.install(first));
        let second = second();
        (joined(first), second)
    })
}

/// Waits for a thread. A panic there becomes one here.
fn joined<R>(thread: std::thread::ScopedJoinHandle<'_, R>) -> R {
    match thread.join() {
        Ok(result) => result,
        Err(panic) => std::panic::resume_unwind(panic),
    }
}
