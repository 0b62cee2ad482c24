//! A navigation filter: a process, the sensors, and the order of time.

use core::marker::PhantomData;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::belief::{Belief, Column, Row};
use super::clocks::{Clocks, Displaced};
use super::history::{Arrival, History};
use super::intake::{Sources, take_new};
use super::interval::Interval;
use super::kinematics::{Kinematics, skew};
use super::measurement::{Event, KINDS, Kind, Measurements};
use super::monitor::Monitor;
use super::parameters::NavigationParameters;
use super::process::Process;
use super::sensor::{euler, euler_by_turn};
use super::track::{CHANNELS, Record, Setup, Track};
use super::turning::ATTITUDE_GAP;
use crate::ParameterError;

/// A silence longer than this (s) is not predicted through: the filter begins anew.
const LOST: f64 = 3600.0;
/// Driving signals that are silent for longer than this (s) are not waited for.
const SILENT: f64 = 0.25;

/// A filter of at most `N` states.
#[derive(Clone, Debug)]
pub struct Filter<P, const N: usize, M = ()> {
    pub(super) setup: Setup<P>,
    monitor: PhantomData<M>,
}

/// What a filter remembers between cycles.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct Memory<const N: usize, M = ()> {
    history: Option<History<N, M>>,
    sources: Sources,
    clocks: Clocks,
    late: [u32; KINDS],
    /// When the belief was last begun anew (s).
    reset: f64,
    /// The first cycle (s).
    begun: f64,
    now: f64,
    /// The part of the estimate that changes with the belief alone.
    spread: Estimate,
}

impl<const N: usize, M> Default for Memory<N, M> {
    fn default() -> Self {
        Self {
            history: None,
            sources: Sources::default(),
            clocks: Clocks::default(),
            late: [0; KINDS],
            reset: f64::NEG_INFINITY,
            begun: f64::NAN,
            now: f64::NAN,
            spread: Estimate::default(),
        }
    }
}

impl<const N: usize, M: Copy> Clone for Memory<N, M> {
    fn clone(&self) -> Self {
        Self { history: self.history.clone(), ..*self }
    }

    /// Keeps the room that the history has.
    fn clone_from(&mut self, from: &Self) {
        self.history.clone_from(&from.history);
        (self.sources, self.clocks, self.late) = (from.sources, from.clocks, from.late);
        (self.reset, self.begun, self.now) = (from.reset, from.begun, from.now);
        self.spread = from.spread;
    }
}

impl<const N: usize, M> Memory<N, M> {
    /// The belief at the newest instant up to which everything is known.
    #[must_use]
    pub fn belief(&self) -> Option<&Belief<N>> {
        self.history.as_ref().map(|history| &history.track.belief)
    }
}

/// How well a filter is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Health {
    /// All is as the filter expects.
    #[default]
    Good,
    /// The position is not bounded: no velocity, or no fix, for longer than a few samples.
    Starved,
    /// Measurements contradict the estimate more often than chance allows.
    Inconsistent,
    /// The estimate was lost and begun again from the start values with wide uncertainty.
    Diverged,
}

/// What is known of a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ChannelReport {
    /// Innovation of the newest measurement.
    pub innovation: [f64; 3],
    /// Its predicted standard deviation.
    pub sigma: [f64; 3],
    /// Its normalised innovation squared.
    pub nis: f64,
    /// Measurements fused.
    pub used: u32,
    /// Measurements limited as outliers, or refused as not fit.
    pub rejected: u32,
    /// Measurements that came late: put in their place, or lost where that is forgotten already.
    pub late: u32,
}

/// The estimate at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Position, NED (m).
    pub position: [f64; 3],
    /// Roll, pitch, yaw (rad).
    pub euler: [f64; 3],
    /// Velocity over ground, body (m/s).
    pub velocity: [f64; 3],
    /// Angular rate, body (rad/s).
    pub rate: [f64; 3],
    /// Time derivative of `velocity` (m/s2).
    pub acceleration: [f64; 3],
    /// Current north and east (m/s); zero where the filter has none.
    pub current: [f64; 2],
    /// Covariance of x, y, z, roll, pitch, yaw (m, rad).
    pub covariance: [[f64; 6]; 6],
    /// Standard deviations of the velocity (m/s).
    pub velocity_sigma: [f64; 3],
    /// Tilt, heading, depth, velocity log, fix.
    pub channels: [ChannelReport; CHANNELS],
    /// State of health.
    pub health: Health,
    /// Share of the thrust that each thruster is taken to have lost.
    pub loss: [f64; 8],
}

/// What every filter of the family offers, whatever is inside.
pub trait Navigation {
    /// What it remembers between cycles.
    type Memory;

    /// The memory at the start.
    fn memory(&self) -> Self::Memory;

    /// Takes what is new at time `now` (s).
    ///
    /// Time that does not advance, or goes back, changes nothing but what is new.
    fn take(&self, memory: &mut Self::Memory, now: f64, measured: &Measurements);

    /// What is known since something was last taken.
    fn estimate(&self, memory: &mut Self::Memory) -> Estimate;

    /// A cycle: takes what is new, and estimates.
    fn update(&self, memory: &mut Self::Memory, now: f64, measured: &Measurements) -> Estimate {
        self.take(memory, now, measured);
        self.estimate(memory)
    }
}

impl<P: Process<N>, const N: usize, M: Monitor<N>> Navigation for Filter<P, N, M> {
    type Memory = Memory<N, M>;

    fn memory(&self) -> Memory<N, M> {
        let history = Some(History::new(Track::new(&self.setup, 0.0)));
        Memory { history, ..Memory::default() }
    }

    fn take(&self, memory: &mut Memory<N, M>, now: f64, measured: &Measurements) {
        let Memory { history, sources, clocks, late, reset, begun: first, now: last, .. } = memory;
        let begun = !last.is_nan();
        let history = history.get_or_insert_with(|| History::new(Track::new(&self.setup, now)));
        if !begun && now.is_finite() {
            *first = now;
            history.reset(Track::new(&self.setup, now));
        }
        let now = if now.is_finite() { now.max(if begun { *last } else { now }) } else { *last };
        if now.is_nan() {
            return;
        }
        *last = now;
        let latency = self.setup.parameters.latency;
        let turns_by_attitude = !sources[Kind::Imu as usize].is_alive(now, SILENT);
        let watched = self.setup.watches_clocks() && turns_by_attitude;
        if !watched {
            clocks.rest();
        }
        let mut displaced = None;
        take_new(sources, now, measured, latency, |mut event| {
            if watched {
                displaced = clocks.hear(&event).or(displaced);
            }
            if event.kind == Kind::Dvl {
                event.time += clocks.lead();
            }
            if event.kind == Kind::Thrust && !self.setup.process.uses_thrust() {
                // Nothing waits for it, so it would be late in every cycle.
                return;
            }
            let kind = event.kind as usize;
            match history.insert(event) {
                Arrival::InTime => {}
                Arrival::Late | Arrival::Lost => late[kind] = late[kind].saturating_add(1),
            }
        });
        if let Some(Displaced { by: [north, east], within: [n, e] }) = displaced {
            let (time, value) = (history.track.time, [north, east, n, e, 0.0, 0.0, 0.0, 0.0]);
            history.insert(Event { time, kind: Kind::Displacement, value });
        }
        let horizon = self.horizon(sources, now);
        if horizon - history.track.time > LOST {
            *reset = now;
            history.reset(Track::lost(&self.setup, now));
        }
        let changed = history.run(&self.setup, horizon, &mut ());
        if changed && !history.track.belief.is_finite() {
            *reset = now;
            history.reset(Track::lost(&self.setup, now));
        }
    }

    fn estimate(&self, memory: &mut Memory<N, M>) -> Estimate {
        let changed = memory.history.as_mut().is_some_and(History::take_changed);
        let Some(history) = memory.history.as_ref().filter(|_| !memory.now.is_nan()) else {
            return Estimate::default();
        };
        let track = &history.track;
        if changed {
            memory.spread = self.spread(memory, track);
        }
        let motion = track.motion_at(&self.setup, memory.now);
        Estimate {
            position: motion.position.into(),
            euler: euler(&motion.rotation),
            velocity: motion.velocity.into(),
            rate: motion.rate.into(),
            acceleration: motion.acceleration.into(),
            channels: self.channels(memory, &track.records),
            health: self.health(memory, track),
            ..memory.spread
        }
    }
}

impl<P: Process<N>, const N: usize, M: Monitor<N>> Filter<P, N, M> {
    /// # Errors
    /// Names the parameter that is out of range.
    pub fn new(process: P, parameters: &NavigationParameters) -> Result<Self, ParameterError> {
        parameters.check()?;
        Ok(Self { setup: Setup::new(process, parameters), monitor: PhantomData })
    }

    /// The memory at the start.
    #[must_use]
    pub fn memory(&self) -> Memory<N, M> {
        Navigation::memory(self)
    }

    /// See [`Navigation::update`].
    pub fn update(&self, memory: &mut Memory<N, M>, now: f64, measured: &Measurements) -> Estimate {
        Navigation::update(self, memory, now, measured)
    }

    /// The share of its thrust that each thruster is taken to give.
    pub(super) fn effectiveness(memory: &Memory<N, M>) -> [f64; 8] {
        memory.history.as_ref().map_or([1.0; 8], |history| history.track.effectiveness)
    }

    /// From now on the thrusters are taken to give these shares of their thrust.
    pub(super) fn assume(&self, memory: &mut Memory<N, M>, effectiveness: [f64; 8]) {
        if let Some(history) = &mut memory.history {
            let time = history.track.time;
            history.insert(Event { time, kind: Kind::Effectiveness, value: effectiveness });
        }
    }

    /// Up to where the driving signals are known: inertial unit and thrusts, or while there is no
    /// inertial unit the attitude, whose change says how the vehicle turns.
    fn horizon(&self, sources: &Sources, now: f64) -> f64 {
        let known = |kind: Kind, silence: f64| {
            let source = &sources[kind as usize];
            source.is_alive(now, silence).then_some(source.newest)
        };
        let turning = known(Kind::Imu, SILENT).or_else(|| known(Kind::Ahrs, ATTITUDE_GAP));
        let thrust =
            self.setup.process.uses_thrust().then(|| known(Kind::Thrust, SILENT)).flatten();
        [turning, thrust].into_iter().flatten().fold(now, f64::min)
    }

    /// What of an estimate changes with the belief alone: covariances, current, thrusters.
    fn spread(&self, memory: &Memory<N, M>, track: &Track<N, M>) -> Estimate {
        let belief = &track.belief;
        let motion = self.setup.process.kinematics(belief, &track.interval);
        let lag = (memory.now - track.time).max(0.0);
        Estimate {
            loss: track.effectiveness.map(|share| 1.0 - share),
            ..spread(&self.setup, belief, &motion, lag)
        }
    }

    fn channels(
        &self,
        memory: &Memory<N, M>,
        records: &[Record; CHANNELS],
    ) -> [ChannelReport; CHANNELS] {
        let kinds = [Kind::Ahrs, Kind::Ahrs, Kind::Depth, Kind::Dvl, Kind::Fix];
        core::array::from_fn(|i| {
            let (record, kind) = (&records[i], kinds[i] as usize);
            ChannelReport {
                innovation: record.innovation,
                sigma: record.sigma,
                nis: record.nis,
                used: record.used,
                rejected: record.rejected.saturating_add(memory.sources[kind].invalid),
                late: memory.late[kind],
            }
        })
    }

    fn health(&self, memory: &Memory<N, M>, track: &Track<N, M>) -> Health {
        let silent = |kind: Kind, seconds: f64| {
            let since = memory.sources[kind as usize].arrived.max(memory.begun);
            memory.now - since > seconds
        };
        if memory.now - memory.reset < 30.0 {
            return Health::Diverged;
        }
        if track.records.iter().any(|r| r.limited_share > 0.5) {
            return Health::Inconsistent;
        }
        if silent(Kind::Dvl, 5.0) && silent(Kind::Fix, 10.0) {
            return Health::Starved;
        }
        Health::Good
    }
}

/// What a belief says of the motion.
pub(super) fn describe<P: Process<N>, const N: usize>(
    setup: &Setup<P>,
    belief: &Belief<N>,
    interval: &Interval,
) -> Estimate {
    let motion = setup.process.motion(belief, interval);
    Estimate {
        position: motion.position.into(),
        euler: euler(&motion.rotation),
        velocity: motion.velocity.into(),
        rate: motion.rate.into(),
        acceleration: motion.acceleration.into(),
        ..spread(setup, belief, &setup.process.kinematics(belief, interval), 0.0)
    }
}

/// How far a belief can be trusted: the covariance of the pose `lag` seconds later, standard deviations
/// of the velocity; and the current.
fn spread<P: Process<N>, const N: usize>(
    setup: &Setup<P>,
    belief: &Belief<N>,
    motion: &Kinematics<N>,
    lag: f64,
) -> Estimate {
    let angles = euler_by_turn(&motion.rotation);
    let mut rows = [Row::zeros(); 6];
    for (i, row) in rows.iter_mut().enumerate() {
        match i {
            // The position moves on with the velocity, as a point of the body ahead.
            0..3 if lag > setup.parameters.interval => {
                motion.add_point_to(row, &(motion.velocity.value * lag), i);
                motion.velocity.add_to(row, &(motion.rotation.row(i).transpose() * lag));
            }
            0..3 => motion.position.add_to(row, &Vector3::ith(i, 1.0)),
            _ => motion.turn.add_to(row, &angles[i - 3]),
        }
    }
    let mut correlations = [Column::zeros(); 6];
    belief.correlate_all(&rows, &mut correlations);
    let mut covariance = [[0.0; 6]; 6];
    for i in 0..6 {
        for j in 0..=i {
            let value = rows[j].dot(&correlations[i]);
            covariance[i][j] = value;
            covariance[j][i] = value;
        }
    }
    if setup.process.tilt_is_input() {
        let sigma = setup.parameters.sensors.tilt_sigma;
        (3..5).for_each(|i| covariance[i][i] = sigma * sigma);
    }
    // A velocity log has taken the error of the rate for one of the velocity.
    let arms = skew(&Vector3::from(setup.parameters.mounting.dvl));
    let velocity_sigma = |i: usize| {
        let by_rate = arms.row(i).norm_squared() * motion.tracking_variance;
        (belief.variance(&motion.velocity.row(i)).max(0.0) + by_rate).sqrt()
    };
    Estimate {
        current: setup.process.current().map_or([0.0; 2], |c| c.map(|i| belief.mean[i])),
        covariance,
        velocity_sigma: core::array::from_fn(velocity_sigma),
        ..Estimate::default()
    }
}
