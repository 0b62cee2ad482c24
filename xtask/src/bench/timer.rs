//! Timing on a machine that is never idle: the compared works take turns in short rounds, and the
//! median of the rounds counts.

use std::time::Instant;

const ROUNDS: usize = 201;

/// Something to be timed: does its work a given number of times.
pub(super) type Work<'a> = &'a mut dyn FnMut(u32);

/// Does `work` repeatedly.
pub(super) fn repeat(mut work: impl FnMut()) -> impl FnMut(u32) {
    move |times| (0..times).for_each(|_| work())
}

/// The durations of the rounds of some works, in nanoseconds per time.
pub(super) struct Rounds<const N: usize>(Vec<[f64; N]>);

/// Lets the works take turns, with this many times per round.
pub(super) fn rounds<const N: usize>(times: u32, mut works: [Work<'_>; N]) -> Rounds<N> {
    let mut round = || {
        works.each_mut().map(|work| {
            let begun = Instant::now();
            work(times);
            begun.elapsed().as_nanos() as f64 / f64::from(times)
        })
    };
    // The first one finds cold caches.
    round();
    Rounds((0..ROUNDS).map(|_| round()).collect())
}

impl<const N: usize> Rounds<N> {
    /// Nanoseconds of a work.
    pub(super) fn ns(&self, work: usize) -> f64 {
        self.median(|round| round[work])
    }

    /// The ratio of one work to another, each round by itself.
    pub(super) fn ratio(&self, work: usize, other: usize) -> f64 {
        self.median(|round| round[work] / round[other])
    }

    /// The time of one work in excess of another.
    pub(super) fn beyond(&self, work: usize, other: usize) -> f64 {
        self.median(|round| round[work] - round[other])
    }

    fn median(&self, of: impl Fn(&[f64; N]) -> f64) -> f64 {
        let mut values: Vec<f64> = self.0.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    }
}
