//! Many runs over all cores; the outcome does not depend on the number of threads.

use std::num::NonZero;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::available_parallelism;

/// One thread per core.
pub(crate) fn default_threads() -> usize {
    available_parallelism().map_or(1, NonZero::get)
}

/// Works on each item, returns the results in the order of the items, and writes a line to standard
/// error at every tenth part. No new item is begun after one has failed.
pub(crate) fn on_threads<T: Sync, R: Send>(
    name: &str,
    items: &[T],
    threads: usize,
    work: impl Fn(&T) -> anyhow::Result<R> + Sync,
) -> anyhow::Result<Vec<R>> {
    let next = AtomicUsize::new(0);
    let finished = Mutex::new(Vec::with_capacity(items.len()));
    let worker = || -> anyhow::Result<()> {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(item) = items.get(index) else { return Ok(()) };
            let result = work(item).inspect_err(|_| next.store(items.len(), Ordering::Relaxed))?;
            let mut finished = finished.lock().unwrap_or_else(|e| e.into_inner());
            finished.push((index, result));
            progress(name, finished.len(), items.len());
        }
    };
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads.max(1)).map(|_| scope.spawn(worker)).collect();
        workers.into_iter().try_for_each(|worker| match worker.join() {
            Ok(result) => result,
            Err(panic) => std::panic::resume_unwind(panic),
        })
    })?;
    let mut finished = finished.into_inner().unwrap_or_else(|e| e.into_inner());
    finished.sort_by_key(|(index, _)| *index);
    Ok(finished.into_iter().map(|(_, result)| result).collect())
}

fn progress(name: &str, done: usize, all: usize) {
    if done * 10 / all != (done - 1) * 10 / all {
        eprintln!("{name}: {done} of {all} runs");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_keep_the_order_of_the_items_and_the_first_failure_ends_the_work() {
        let items: Vec<u64> = (0..100).collect();
        let doubled = on_threads("test", &items, 3, |i| Ok(2 * i)).unwrap();
        assert_eq!(doubled, items.iter().map(|i| 2 * i).collect::<Vec<_>>());
        let begun = AtomicUsize::new(0);
        let failed = on_threads("test", &items, 1, |i| {
            begun.fetch_add(1, Ordering::Relaxed);
            anyhow::ensure!(*i < 7, "seven");
            Ok(())
        });
        assert_eq!(failed.unwrap_err().to_string(), "seven");
        assert_eq!(begun.into_inner(), 8);
    }
}
