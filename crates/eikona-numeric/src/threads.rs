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

/// Calls `work` for each chunk of this length (the last may be shorter) of an array, with the
/// number of the chunk. Each thread takes consecutive chunks.
///
/// # Errors
/// The first error of the work, by number of the chunk at which its thread began.
///
/// ```
/// use eikona_numeric::for_chunks;
/// let mut numbers = [0; 7];
/// let fill = |chunk: usize, numbers: &mut [usize]| {
///     numbers.fill(chunk);
///     Ok::<(), ()>(())
/// };
/// for_chunks(2, &mut numbers, 3, fill).unwrap();
/// assert_eq!(numbers, [0, 0, 0, 1, 1, 1, 2]);
/// ```
pub fn for_chunks<T: Send, E: Send>(
    threads: usize,
    items: &mut [T],
    length: usize,
    work: impl Fn(usize, &mut [T]) -> Result<(), E> + Sync,
) -> Result<(), E> {
    let length = length.max(1);
    let share = items.len().div_ceil(length).div_ceil(threads.max(1)).max(1);
    let work = &work;
    let tasks = items.chunks_mut(share * length).enumerate().map(|(i, items)| {
        move || items.chunks_mut(length).enumerate().try_for_each(|(k, chunk)| work(i * share + k, chunk))
    });
    together(tasks).into_iter().collect()
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
