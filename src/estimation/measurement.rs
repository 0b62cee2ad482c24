//! The inputs of a filter in each cycle, and which of them are valid.

use serde::{Deserialize, Serialize};

use super::interval::SAME;

/// Numbers in the longest value.
pub(super) const LONGEST: usize = 8;
/// Values with a relative difference of no more than this are the same except for rounding: an
/// importer that interpolates between two equal values changes the last digits.
const ROUNDING: f64 = 1e-12;

/// The latest value of an instrument, with the time it was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading<const K: usize> {
    /// The value.
    pub value: [f64; K],
    /// Time of measurement (s); a time within 1e-9 s of the previous one is the same measurement.
    /// Negative, or 0 while the value changes: unknown, so the value counts as new in every cycle;
    /// if noise prevents a value from repeating, only if it differs from the previous one by more
    /// than rounding (a relative 1e-12).
    pub stamp: f64,
    /// False while the instrument has not measured yet, or is absent.
    pub valid: bool,
}

impl<const K: usize> Default for Reading<K> {
    /// Nothing measured.
    fn default() -> Self {
        Self { value: [0.0; K], stamp: -1.0, valid: false }
    }
}

impl<const K: usize> Reading<K> {
    /// A value measured at a time (s).
    #[must_use]
    pub fn at(stamp: f64, value: [f64; K]) -> Self {
        Self { value, stamp, valid: true }
    }

    /// The value, padded with zeros to the length of the longest.
    pub(super) fn padded(&self) -> [f64; LONGEST] {
        core::array::from_fn(|i| if i < K { self.value[i] } else { 0.0 })
    }

    /// Whether the time of measurement is known. A stamp that stays 0 while the value changes is an
    /// input that is not connected, in an importer that sets such inputs to zero.
    pub(super) fn is_stamped(&self, newest: f64, value: &[f64; LONGEST]) -> bool {
        let held = || is_same(&self.padded(), value) || self.value.iter().any(|x| x.is_nan());
        self.stamp > 0.0 || self.stamp == 0.0 && (newest != 0.0 || held())
    }

    /// Whether this is the measurement with a stamp (s), except for rounding.
    pub(super) fn is_of(&self, stamp: f64) -> bool {
        (self.stamp - stamp).abs() < SAME
    }
}

/// Whether values are the same except for rounding.
pub(super) fn is_same(a: &[f64; LONGEST], b: &[f64; LONGEST]) -> bool {
    let close = |a: f64, b: f64| a == b || (a - b).abs() <= ROUNDING * a.abs().max(b.abs());
    a.iter().zip(b).all(|(&a, &b)| close(a, b))
}

/// Everything that a filter can use in a cycle; absent measurements are never fused.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measurements {
    /// Specific force (m/s2) and angular rate (rad/s) at the inertial unit, body axes.
    pub imu: Reading<6>,
    /// Roll, pitch, heading (rad).
    pub ahrs: Reading<3>,
    /// Velocity over ground at the velocity log, body axes (m/s).
    pub dvl: Reading<3>,
    /// North and east of the fix, and its standard deviation, 0 if not reported (m).
    pub fix: Reading<3>,
    /// Depth of the pressure sensor (m).
    pub depth: Reading<1>,
    /// Thrusts, from measured rotor speeds (N).
    pub thrust: Reading<8>,
}

/// Kinds of samples, in the order in which those of one instant are processed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Kind {
    /// Inertial unit.
    Imu,
    /// Thrusts.
    Thrust,
    /// Attitude and heading.
    Ahrs,
    /// Depth.
    Depth,
    /// Velocity log.
    Dvl,
    /// Position fix.
    Fix,
    /// Shares of the thrust that the thrusters give, as found by a monitor.
    Effectiveness,
    /// The position error that was found, and its standard deviation: north and east of each.
    Displacement,
}

/// How many kinds of samples come from instruments.
pub const KINDS: usize = 6;

/// A sample at an instant; only the kind's own components of `value` count.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Event {
    pub(super) time: f64,
    pub(super) kind: Kind,
    pub(super) value: [f64; 8],
}

impl Event {
    /// Position of the event in the order of all events.
    pub(super) fn key(&self) -> Key {
        (self.time, self.kind)
    }

    /// The first `K` components.
    pub(super) fn cut<const K: usize>(&self) -> [f64; K] {
        core::array::from_fn(|i| self.value[i])
    }
}

/// Time and kind; a total order, so the order of arrival does not matter.
pub(super) type Key = (f64, Kind);

impl Kind {
    /// How many components a sample has.
    pub(super) fn size(self) -> usize {
        match self {
            Self::Imu => 6,
            Self::Thrust | Self::Effectiveness => 8,
            Self::Displacement => 4,
            Self::Ahrs | Self::Dvl | Self::Fix => 3,
            Self::Depth => 1,
        }
    }

    /// Largest magnitude of a component that is accepted.
    fn bound(self) -> f64 {
        match self {
            // Over a hundred g; rates are far below.
            Self::Imu => 1e3,
            Self::Thrust | Self::Effectiveness => 1e6,
            Self::Ahrs => 1e3,
            Self::Dvl => 50.0,
            Self::Fix | Self::Displacement => 1e9,
            Self::Depth => 2e4,
        }
    }

    /// Whether values can have come from a working instrument: numbers within range, and not all
    /// zero where noise makes that impossible.
    pub(super) fn is_plausible(self, value: &[f64; 8]) -> bool {
        let own = &value[..self.size()];
        let all_zero = match self {
            Self::Imu => own[..3].iter().all(|&x| x == 0.0),
            Self::Dvl | Self::Ahrs => own.iter().all(|&x| x == 0.0),
            Self::Fix => own[..2].iter().all(|&x| x == 0.0),
            Self::Thrust | Self::Depth | Self::Effectiveness | Self::Displacement => false,
        };
        let bound = self.bound();
        !all_zero && own.iter().fold(true, |all, x| all & (x.abs() <= bound))
    }

    /// Whether repeating the previous value, except for rounding, shows that an instrument is
    /// stuck. A rotor can stand still, and a depth has a coarse resolution.
    pub(super) fn never_repeats(self) -> bool {
        !matches!(self, Self::Thrust | Self::Depth | Self::Effectiveness | Self::Displacement)
    }
}
