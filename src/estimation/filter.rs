//! A navigation filter: a process, the sensors, and time ordering.

use core::marker::PhantomData;

use serde::{Deserialize, Serialize};

use super::belief::Belief;
use super::clocks::{Clocks, Displaced};
use super::estimate::{ChannelReport, Estimate, Health, Spread, estimate};
use super::history::{Arrival, History};
use super::intake::{Sources, take_new};
use super::measurement::{Event, KINDS, Kind, Measurements};
use super::monitor::Monitor;
use super::parameters::NavigationParameters;
use super::process::Process;
use super::track::{CHANNELS, Record, Setup, Track};
use super::turning::ATTITUDE_GAP;
use crate::ParameterError;

/// The filter does not predict through a silence longer than this (s); it restarts.
const LOST: f64 = 3600.0;
/// The filter does not wait for driving signals that are silent for longer than this (s).
const SILENT: f64 = 0.25;

/// A filter of at most `N` states.
#[derive(Clone, Debug)]
pub struct Filter<P, const N: usize, M = ()> {
    pub(super) setup: Setup<P>,
    monitor: PhantomData<M>,
}

/// The memory of a filter between cycles.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct Memory<const N: usize, M = ()> {
    history: Option<History<N, M>>,
    sources: Sources,
    clocks: Clocks,
    late: [u32; KINDS],
    /// When the belief was last restarted (s).
    reset: f64,
    /// The first cycle (s).
    begun: f64,
    now: f64,
    spread: Spread,
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
            spread: Spread::default(),
        }
    }
}

impl<const N: usize, M: Copy> Clone for Memory<N, M> {
    fn clone(&self) -> Self {
        Self { history: self.history.clone(), ..*self }
    }

    /// Keeps the capacity of the history.
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

    /// The share of its thrust that each thruster is assumed to give.
    pub(super) fn effectiveness(&self) -> [f64; 8] {
        self.history.as_ref().map_or([1.0; 8], |history| history.track.effectiveness)
    }

    /// From now on the thrusters are assumed to give these shares of their thrust.
    pub(super) fn assume(&mut self, effectiveness: [f64; 8])
    where
        M: Monitor<N>,
    {
        if let Some(history) = &mut self.history {
            let time = history.track.time;
            history.insert(Event { time, kind: Kind::Effectiveness, value: effectiveness });
        }
    }
}

/// The interface of every filter of the family, whatever is inside.
pub trait Navigation {
    /// Its memory between cycles.
    type Memory;

    /// The memory at the start.
    fn memory(&self) -> Self::Memory;

    /// Takes in new measurements at time `now` (s).
    ///
    /// If time does not advance, or goes back, only new measurements change anything.
    fn take(&self, memory: &mut Self::Memory, now: f64, measured: &Measurements);

    /// The estimate after the last measurements taken in.
    fn estimate(&self, memory: &mut Self::Memory) -> Estimate;

    /// A cycle: takes in new measurements, and estimates.
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
            let motion = self.setup.process.kinematics(&track.belief, &track.interval);
            let lag = (memory.now - track.time).max(0.0);
            memory.spread = Spread::of(&self.setup, &track.belief, &motion, lag);
        }
        let motion = track.motion_at(&self.setup, memory.now);
        let (channels, health) =
            (self.channels(memory, &track.records), self.health(memory, track));
        let loss = track.effectiveness.map(|share| 1.0 - share);
        Estimate { channels, health, loss, ..estimate(&motion, &memory.spread) }
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

    /// The time up to which the driving signals are known: inertial unit and thrusts, or, without
    /// an inertial unit, the attitude, whose change shows how the vehicle turns.
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
