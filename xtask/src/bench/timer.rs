//! Timing: the least of several repetitions, because all disturbances only ever add.

use std::time::Instant;

const REPETITIONS: usize = 7;

/// Nanoseconds per call of `work`.
pub(super) fn nanoseconds(calls: u32, mut work: impl FnMut()) -> f64 {
    let mut least = f64::INFINITY;
    for _ in 0..REPETITIONS {
        let begun = Instant::now();
        for _ in 0..calls {
            work();
        }
        least = least.min(begun.elapsed().as_nanos() as f64 / f64::from(calls));
    }
    least
}
