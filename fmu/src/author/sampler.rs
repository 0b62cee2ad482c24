//! The clock of a sampled component: `t_k = t_start + k T`, counted in integers.

use serde::{Deserialize, Serialize};

use super::Time;

/// Sample instants `t_k = t_start + k T`. Keep it in `Memory`, take sample 0 in `initial`, answer
/// `next_event` with [`next`](Sampler::next) and call [`advance`](Sampler::advance) in `event`.
///
/// Each instant is computed from k, not summed up, so that a period that is no whole number of
/// nanoseconds (7 Hz) does not drift.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sampler {
    start: Time,
    period_s: f64,
    index: u64,
}

impl Sampler {
    /// Samples every `period_s` seconds from `start` on; sample 0 counts as taken.
    #[must_use]
    pub const fn new(start: Time, period_s: f64) -> Self {
        Self { start, period_s, index: 0 }
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

    /// Instant of the next sample, at least one nanosecond after the last.
    #[must_use]
    pub fn next(&self) -> Time {
        self.instant(self.index.saturating_add(1)).max(self.last().after_ns(1))
    }

    /// Counts the next sample as taken.
    pub fn advance(&mut self) {
        self.index = self.index.saturating_add(1);
    }

    fn instant(&self, index: u64) -> Time {
        self.start.after_ns(Time::from_seconds(index as f64 * self.period_s).ns())
    }
}
