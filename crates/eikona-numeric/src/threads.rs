//! Tasks that run at the same time, under the observer of the thread that starts them.

use crate::NumericError;
use crate::observer::{CurrentObserver, check_stopped};
use std::sync::{Mutex, PoisonError};

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

/// Runs of consecutive chunks that each thread takes, about: some threads may be slower.
const RUNS: usize = 8;

/// Calls `work` for each chunk of this length (the last may be shorter) of an array, with the
/// number of the chunk. Threads take the chunks in runs, in order.
///
/// # Errors
/// An error of the work. Other threads may finish their chunks, and take more.
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
    let (length, threads) = (length.max(1), threads.max(1));
    let chunks = items.len().div_ceil(length);
    let run = if threads == 1 { chunks } else { chunks.div_ceil(RUNS * threads) }.max(1);
    let runs = Mutex::new(items.chunks_mut(run * length).enumerate());
    let next = || runs.lock().unwrap_or_else(PoisonError::into_inner).next();
    let task = || {
        while let Some((i, items)) = next() {
            items.chunks_mut(length).enumerate().try_for_each(|(k, chunk)| work(i * run + k, chunk))?;
        }
        Ok(())
    };
    together((0..threads.min(chunks)).map(|_| task)).into_iter().collect()
}

/// Values per piece of work.
const PIECE: usize = 256;

/// Returns a function of each number below a bound, in order.
///
/// # Errors
/// [`NumericError::Stopped`].
///
/// ```
/// assert_eq!(eikona_numeric::mapped(2, 4, |i| i * i)?, [0, 1, 4, 9]);
/// # Ok::<(), eikona_numeric::NumericError>(())
/// ```
pub fn mapped<T: Clone + Default + Send>(
    threads: usize,
    bound: usize,
    function: impl Fn(usize) -> T + Sync,
) -> Result<Vec<T>, NumericError> {
    let mut values = vec![T::default(); bound];
    for_chunks(threads, &mut values, PIECE, |piece, values| {
        check_stopped()?;
        (piece * PIECE..).zip(values).for_each(|(i, value)| *value = function(i));
        Ok(())
    })?;
    Ok(values)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_chunk_is_worked_on_once_by_any_number_of_threads() {
        for threads in [0, 1, 2, 3, 50] {
            for count in [0, 1, 7, 100, 1001] {
                let mut numbers = vec![0; count];
                for_chunks(threads, &mut numbers, 7, |chunk, numbers| {
                    numbers.iter_mut().zip(7 * chunk..).for_each(|(x, i)| *x += i);
                    Ok::<(), ()>(())
                })
                .unwrap();
                assert!(numbers.iter().copied().eq(0..count));
                assert_eq!(mapped(threads, count, |i| i).unwrap(), numbers);
            }
        }
    }

    #[test]
    fn an_error_of_any_chunk_is_returned() {
        for threads in [1, 2, 3] {
            let fails = |chunk: usize, _: &mut [u8]| if chunk == 80 { Err(chunk) } else { Ok(()) };
            assert_eq!(for_chunks(threads, &mut [0; 100], 1, fails), Err(80));
        }
    }
}
