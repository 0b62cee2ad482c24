//! The clock of a sampled component: `t_k = t_start + k T`, counted in integers.

use serde::{Deserialize, Serialize};

use super::Time;

/// Sample instants `t_k = t_start + k T`. [`Sampled`](super::Sampled) has one; a component that
/// also has continuous states keeps its own in `Memory`, takes sample 0 in `initial`, answers
/// `next_event` with [`next`](Sampler::next) and calls [`advance`](Sampler::advance) in `event`.
///
/// Each instant is computed from k, not summed up, so a period that is not a whole number of
/// nanoseconds (7 Hz) does not drift.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sampler {
    start: Time,
    period_s: f64,
    index: u64,
}

impl Sampler {
    /// Samples every `period_s` seconds (at least a nanosecond) starting at `start`; sample 0
    /// counts as taken.
    #[must_use]
    pub const fn new(start: Time, period_s: f64) -> Self {
        Self { start, period_s: period_s.max(1e-9), index: 0 }
    }

    /// Index of the newest sample taken.
    #[must_use]
    pub const fn index(&self) -> u64 {
        self.index
    }

    /// Instant of the newest sample taken.
    #[must_use]
    pub fn last(&self) -> Time {
        self.instant(self.index)
    }

    /// Instant of the next sample.
    #[must_use]
    pub fn next(&self) -> Time {
        self.instant(self.index.saturating_add(1))
    }

    /// Counts the next sample as taken.
    pub fn advance(&mut self) {
        self.index = self.index.saturating_add(1);
    }

    fn instant(&self, index: u64) -> Time {
        self.start.after_ns(Time::from_seconds(index as f64 * self.period_s).ns())
    }
}

#[cfg(test)]
mod tests {
    use super::{Sampler, Time};

    #[test]
    fn instants_are_counted_and_do_not_drift() {
        let mut seven = Sampler::new(Time::from_ns(5), 1.0 / 7.0);
        assert_eq!((seven.last().ns(), seven.next().ns()), (5, 142_857_148));
        (0..7_000_000).for_each(|_| seven.advance());
        assert_eq!((seven.index(), seven.last().ns()), (7_000_000, 1_000_000_000_000_005));
    }

    #[test]
    fn the_clock_always_moves_on() {
        for period_s in [1.4e-9, 1e-12, 0.0, -1.0, f64::NAN] {
            let mut sampler = Sampler::new(Time::from_ns(0), period_s);
            for _ in 0..10 {
                let due = sampler.next();
                assert!(due > sampler.last());
                sampler.advance();
                assert_eq!(sampler.last(), due);
            }
        }
    }
}
