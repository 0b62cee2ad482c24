//! The filter's memory between cycles, and the new measurements of a cycle.

use serde::{Deserialize, Serialize};

use super::intake::{Record, Source};
use super::prediction::Motion;
use crate::attitude;
use crate::estimation::belief::{Belief, Column};
use crate::estimation::kalman::{Verdict, absorb};
use crate::estimation::sensor::Observation;
use crate::estimation::{CHANNELS, Channel, Measurements};
use crate::vector::Vec3;

/// The filter's memory between cycles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EkfMemory {
    pub(super) belief: Belief<4>,
    pub(super) motion: Motion,
    /// Roll and pitch last measured (rad).
    pub(super) tilt: [f64; 2],
    /// Angular rate last measured (rad/s).
    pub(super) rate: Vec3,
    /// Thrusts last measured (N).
    pub(super) thrust: Option<[f64; 8]>,
    pub(super) sources: Option<Sources>,
    pub(super) records: [Record; CHANNELS],
    /// False until the first cycle, which does not predict.
    pub(super) running: bool,
    pub(super) now: f64,
    /// When the estimate was last lost (s).
    pub(super) lost: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Sources {
    pub(super) imu: Source,
    pub(super) ahrs: Source,
    pub(super) depth: Source,
    pub(super) dvl: Source,
    pub(super) fix: Source,
    pub(super) thrust: Source,
}

impl Sources {
    pub(super) fn new(now: f64) -> Self {
        let source = Source::new(now);
        Self { imu: source, ahrs: source, depth: source, dvl: source, fix: source, thrust: source }
    }
}

/// New measurements in a cycle.
pub(super) struct News {
    pub(super) imu: Option<[f64; 6]>,
    pub(super) ahrs: Option<[f64; 3]>,
    pub(super) depth: Option<[f64; 1]>,
    pub(super) dvl: Option<[f64; 3]>,
    pub(super) fix: Option<[f64; 3]>,
}

impl Default for EkfMemory {
    fn default() -> Self {
        let zero = Column::zeros();
        Self {
            belief: Belief::new(4, zero, &zero, [1.0, 0.0, 0.0, 0.0]),
            motion: Motion::default(),
            tilt: [0.0; 2],
            rate: [0.0; 3],
            thrust: None,
            sources: None,
            records: [Record::default(); CHANNELS],
            running: false,
            now: 0.0,
            lost: f64::NEG_INFINITY,
        }
    }
}

impl EkfMemory {
    pub(super) fn take_new(&mut self, measured: &Measurements) -> News {
        let now = self.now;
        let sources = self.sources.get_or_insert_with(|| Sources::new(now));
        if let Some(thrust) = sources.thrust.take(now, &measured.thrust) {
            self.thrust = Some(thrust);
        }
        News {
            imu: sources.imu.take(now, &measured.imu),
            ahrs: sources.ahrs.take(now, &measured.ahrs),
            depth: sources.depth.take(now, &measured.depth),
            dvl: sources.dvl.take(now, &measured.dvl),
            fix: sources.fix.take(now, &measured.fix),
        }
    }

    pub(super) fn is_finite(&self) -> bool {
        self.belief.is_finite()
            && self.motion.is_finite()
            && self.records.iter().all(Record::is_finite)
    }

    pub(super) fn fuse(&mut self, channel: Channel, observation: &Observation<4>) {
        let mut verdict = Verdict::new();
        verdict.judge(&self.belief, observation, f64::INFINITY);
        self.records[channel as usize].note(observation, &verdict);
        let correction = absorb(&mut self.belief, observation, &mut verdict, &mut ());
        self.belief.mean += correction;
        self.belief.mean[3] = attitude::wrap(self.belief.mean[3]);
    }

    pub(super) fn count(&mut self, channel: Channel) {
        self.records[channel as usize].count();
    }
}
