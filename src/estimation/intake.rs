//! Intake of readings: which are new, which are valid, and the time they refer to.

use serde::{Deserialize, Serialize};

use super::measurement::{Event, KINDS, Kind, LONGEST, Measurements, Reading, is_same};

/// A stamp may be this far ahead of the filter's clock (s): an importer's step, a rounding.
const AHEAD: f64 = 0.05;

/// What is remembered about one instrument.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Source {
    stamp: f64,
    value: [f64; LONGEST],
    seen: bool,
    /// Offset added to its stamps since its clock stepped (s).
    offset: f64,
    /// Newest time of its samples, and the filter's time when the newest came (s).
    pub(super) newest: f64,
    pub(super) arrived: f64,
    /// Readings that were new but invalid: not numbers, out of range, stuck.
    pub(super) invalid: u32,
    /// Steps of its clock.
    pub(super) steps: u32,
    /// Consecutive repetitions of the same value.
    repeated: u32,
}

impl Default for Source {
    fn default() -> Self {
        Self {
            stamp: f64::NEG_INFINITY,
            value: [0.0; LONGEST],
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
        let stamped = reading.is_stamped(self.stamp, &self.value);
        if !reading.valid || stamp.is_nan() || (stamped && reading.is_of(self.stamp)) {
            return None;
        }
        let value = reading.padded();
        let repeats = self.seen && kind.never_repeats() && is_same(&value, &self.value);
        if repeats && !stamped {
            return None;
        }
        (self.stamp, self.seen) = (stamp, true);
        if !repeats {
            // The first of equal values is kept: a slow change adds up to a different value.
            self.value = value;
        }
        // The same value at another instant: the instrument is stuck.
        if repeats || !kind.is_plausible(&value) {
            self.invalid = self.invalid.saturating_add(1);
            return None;
        }
        let time = if stamped { self.anchor(now, stamp, latency) } else { now };
        self.newest = self.newest.max(time);
        self.arrived = now;
        Some(Event { time, kind, value })
    }

    /// The time of a stamp. An impossible stamp, in the future or older than any latency, shows
    /// that the clock stepped; its samples count as taken when they arrived, and so do later ones
    /// with the same offset, until the stamps are plausible by themselves again.
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

/// Passes every reading that is new and valid to `take`, in the order of the kinds.
pub(super) fn take_new(
    sources: &mut Sources,
    now: f64,
    measured: &Measurements,
    latency: f64,
    mut take: impl FnMut(Event),
) {
    let [imu, thrust, ahrs, depth, dvl, fix] = sources;
    imu.accept(Kind::Imu, now, &measured.imu, latency).map(&mut take);
    thrust.accept(Kind::Thrust, now, &measured.thrust, latency).map(&mut take);
    ahrs.accept(Kind::Ahrs, now, &measured.ahrs, latency).map(&mut take);
    depth.accept(Kind::Depth, now, &measured.depth, latency).map(&mut take);
    dvl.accept(Kind::Dvl, now, &measured.dvl, latency).map(&mut take);
    fix.accept(Kind::Fix, now, &measured.fix, latency).map(&mut take);
}

#[cfg(test)]
mod tests {
    use super::*;

    const VALUE: [f64; 3] = [0.31, -0.02, 1.7];

    /// How many events these readings make, one per cycle of 0.1 s, and how many are rejected.
    fn events(readings: impl IntoIterator<Item = Reading<3>>) -> (usize, u32) {
        let mut source = Source::default();
        let readings = readings.into_iter().enumerate();
        let taken =
            readings.filter_map(|(i, r)| source.accept(Kind::Dvl, 0.1 * i as f64, &r, 2.0)).count();
        (taken, source.invalid)
    }

    fn up(value: [f64; 3], ulps: usize) -> [f64; 3] {
        (0..ulps).fold(value, |value, _| value.map(f64::next_up))
    }

    #[test]
    fn a_stamp_that_differs_by_rounding_is_the_same_measurement() {
        let stamp = |i: usize| (0..i).fold(0.3, |stamp: f64, _| stamp.next_up());
        assert_eq!(events((3..9).map(|i| Reading::at(stamp(i), up(VALUE, i)))), (1, 0));
        // However small the differences, a stamp that changes is another measurement.
        let creeping = |i: usize| 0.3 + 0.4e-9 * i as f64;
        assert_eq!(events((0..9).map(|i| Reading::at(creeping(i), up(VALUE, 9999 * i)))), (3, 0));
    }

    #[test]
    fn without_stamps_a_value_that_differs_by_rounding_is_the_same_measurement() {
        assert_eq!(events((0..9).map(|i| Reading::at(-1.0, up(VALUE, i)))), (1, 0));
        assert_eq!(
            events((0..9).map(|i| Reading::at(-1.0, VALUE.map(|x| x + 1e-9 * i as f64)))),
            (9, 0)
        );
    }

    #[test]
    fn a_stamp_that_stays_zero_while_the_value_changes_is_no_stamp() {
        let value = |i: usize| VALUE.map(|x| x + 0.01 * i as f64);
        assert_eq!(events((0..9).map(|i| Reading::at(0.0, value(i)))), (9, 0));
        assert_eq!(events((0..9).map(|i| Reading::at(0.0, up(VALUE, i)))), (1, 0));
        // The measurement of the beginning is held until the next one.
        assert_eq!(events((0..9).map(|i| Reading::at(0.4 * (i / 4) as f64, value(i / 4)))), (3, 0));
    }

    #[test]
    fn an_instrument_whose_values_differ_by_rounding_is_stuck() {
        assert_eq!(events((0..9).map(|i| Reading::at(0.1 * i as f64, up(VALUE, i)))), (1, 8));
    }
}
