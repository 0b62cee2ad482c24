//! Which readings are new, and what happened to them.

use serde::{Deserialize, Serialize};

use crate::estimation::kalman::{GATE, Verdict};
use crate::estimation::measurement::LONGEST;
use crate::estimation::sensor::Observation;
use crate::estimation::{ChannelReport, Reading};

/// What is remembered about an instrument.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Source {
    /// Stamp of its newest reading (s), and its value.
    stamp: f64,
    value: [f64; LONGEST],
    /// When the last valid reading came (s).
    pub(super) arrived: f64,
    /// Readings that were not numbers.
    pub(super) refused: u32,
}

impl Source {
    pub(super) fn new(now: f64) -> Self {
        Self { stamp: -1.0, value: [0.0; LONGEST], arrived: now, refused: 0 }
    }

    /// The value of a reading, if it is new and consists of numbers.
    pub(super) fn take<const K: usize>(
        &mut self,
        now: f64,
        reading: &Reading<K>,
    ) -> Option<[f64; K]> {
        let stamped = reading.is_stamped(self.stamp, &self.value);
        if !reading.valid || (stamped && reading.is_of(self.stamp)) {
            return None;
        }
        (self.stamp, self.value) = (reading.stamp, reading.padded());
        if !reading.value.iter().chain([&reading.stamp]).all(|x| x.is_finite()) {
            self.refused = self.refused.saturating_add(1);
            return None;
        }
        self.arrived = now;
        Some(reading.value)
    }
}

/// The record of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Record {
    innovation: [f64; 3],
    sigma: [f64; 3],
    nis: f64,
    used: u32,
    /// Recent share beyond the 99.9 % quantile, over some twenty measurements.
    pub(super) surprises: f64,
}

impl Record {
    /// A measurement that is used as it is, without a prediction to compare it with.
    pub(super) fn count(&mut self) {
        self.used = self.used.saturating_add(1);
    }

    pub(super) fn note(&mut self, observation: &Observation<4>, verdict: &Verdict<4>) {
        self.count();
        self.innovation = observation.innovation;
        self.sigma = verdict.sigma;
        self.nis = verdict.nis.min(f64::MAX);
        let surprise = f64::from(u8::from(verdict.nis > GATE[observation.size - 1]));
        self.surprises += (surprise - self.surprises) / 20.0;
    }

    /// The counts alone.
    pub(super) fn emptied(&self) -> Self {
        Self { used: self.used, ..Self::default() }
    }

    pub(super) fn is_finite(&self) -> bool {
        self.innovation.iter().chain(&self.sigma).all(|x| x.is_finite())
    }

    pub(super) fn report(&self, source: &Source) -> ChannelReport {
        let Self { innovation, sigma, nis, used, .. } = *self;
        ChannelReport { innovation, sigma, nis, used, rejected: source.refused, late: 0 }
    }
}
