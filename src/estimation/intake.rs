//! Intake of readings: which are new, which are fit, and what time they speak of.

use serde::{Deserialize, Serialize};

use super::measurement::{Event, KINDS, Kind, Measurements, Reading};

/// A stamp may be this far ahead of the filter's clock (s): an importer's step, a rounding.
const AHEAD: f64 = 0.05;

/// What is remembered of one instrument.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Source {
    stamp: f64,
    value: [f64; 8],
    seen: bool,
    /// What is added to its stamps since its clock stepped (s).
    offset: f64,
    /// Newest time of its samples, and the filter's time when the newest came (s).
    pub(super) newest: f64,
    pub(super) arrived: f64,
    /// Readings that were new but not fit: not numbers, out of reason, stuck.
    pub(super) invalid: u32,
    /// Steps of its clock.
    pub(super) steps: u32,
    /// Repetitions of the same value in a row.
    repeated: u32,
}

impl Default for Source {
    fn default() -> Self {
        Self {
            stamp: f64::NEG_INFINITY,
            value: [0.0; 8],
            seen: false,
            offset: 0.0,
            newest: f64::NEG_INFINITY,
            arrived: f64::NEG_INFINITY,
            invalid: 0,
            steps: 0,
            repeated: 0,
        }
    }
}

impl Source {
    /// Whether samples have come within the last `seconds`.
    pub(super) fn is_alive(&self, now: f64, seconds: f64) -> bool {
        now - self.arrived < seconds
    }

    fn accept<const K: usize>(
        &mut self,
        kind: Kind,
        now: f64,
        reading: &Reading<K>,
        latency: f64,
    ) -> Option<Event> {
        let stamp = reading.stamp;
        let stamped = stamp >= 0.0;
        if !reading.valid || stamp.is_nan() || (stamped && stamp == self.stamp) {
            return None;
        }
        let value = core::array::from_fn(|i| if i < K { reading.value[i] } else { 0.0 });
        let repeats = self.seen && value == self.value && kind.never_repeats();
        if repeats && !stamped {
            return None;
        }
        (self.stamp, self.value, self.seen) = (stamp, value, true);
        // The same bits at another instant: the instrument is stuck.
        if repeats || !kind.is_plausible(&value) {
            self.invalid = self.invalid.saturating_add(1);
            return None;
        }
        let time = if stamped { self.anchor(now, stamp, latency) } else { now };
        self.newest = self.newest.max(time);
        self.arrived = now;
        Some(Event { time, kind, value })
    }

    /// The time of a stamp. One that cannot be, in the future or older than any latency, shows that
    /// the clock stepped; its samples count as taken when they came, and so do later ones by the same
    /// step, until the stamps make sense by themselves again.
    fn anchor(&mut self, now: f64, stamp: f64, latency: f64) -> f64 {
        let fits = |time: f64| (-AHEAD..=latency.max(AHEAD)).contains(&(now - time));
        if fits(stamp) {
            self.offset = 0.0;
        } else if !fits(stamp + self.offset) || self.offset == 0.0 {
            self.offset = now - stamp;
            self.steps = self.steps.saturating_add(1);
        }
        (stamp + self.offset).min(now)
    }
}

/// All instruments.
pub(super) type Sources = [Source; KINDS];

/// Hands every reading that is new and fit to `take`, in the order of the kinds.
pub(super) fn take_new(
    sources: &mut Sources,
    now: f64,
    measured: &Measurements,
    latency: f64,
    take: impl FnMut(Event),
) {
    let [imu, thrust, ahrs, depth, dvl, fix] = sources;
    let events = [
        imu.accept(Kind::Imu, now, &measured.imu, latency),
        thrust.accept(Kind::Thrust, now, &measured.thrust, latency),
        ahrs.accept(Kind::Ahrs, now, &measured.ahrs, latency),
        depth.accept(Kind::Depth, now, &measured.depth, latency),
        dvl.accept(Kind::Dvl, now, &measured.dvl, latency),
        fix.accept(Kind::Fix, now, &measured.fix, latency),
    ];
    events.into_iter().flatten().for_each(take);
}
