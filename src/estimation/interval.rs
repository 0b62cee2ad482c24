//! The inputs that drove the vehicle between two instants of a filter: means of inertial and thrust
//! samples.
//!
//! Samples are points of a signal, joined by straight lines; their mean over an interval is the
//! integral of that line (with samples at both ends, the trapezoidal rule). A mean that begins or
//! ends between two samples is as accurate as one that does not, and no half sample is lost: a gyro
//! that lags by half a sample would turn the heading too late in every turn.

use serde::{Deserialize, Serialize};

use super::turning::Turning;
use crate::attitude;
use crate::vector::Vec3;

/// Instants closer than this (s) are the same.
pub(super) const SAME: f64 = 1e-9;
/// Samples farther apart than this (s) do not describe the signal between them.
pub(super) const GAP: f64 = 0.25;

/// A signal of `K` channels up to the newest sample, and its integrals since the interval began.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(serialize = "[f64; K]: Serialize", deserialize = "[f64; K]: Deserialize<'de>"))]
pub(super) struct Stream<const K: usize> {
    /// Time and value of the newest point.
    newest: Option<(f64, [f64; K])>,
    begun: f64,
    /// How much of the interval is covered by samples (s).
    covered: f64,
    integral: [f64; K],
    /// Integral of the value times the time since the interval began.
    moment: [f64; K],
}

/// Mean of a stream over an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mean<const K: usize> {
    /// Mean value.
    pub(super) value: [f64; K],
    /// Mean with a weight that rises from 0 to 1 over the interval.
    pub(super) rising: [f64; K],
    /// Value at the end.
    pub(super) end: [f64; K],
}

impl<const K: usize> Stream<K> {
    /// Nothing known yet, starting at an instant.
    pub(super) fn new(begun: f64) -> Self {
        Self { newest: None, begun, covered: 0.0, integral: [0.0; K], moment: [0.0; K] }
    }

    /// Mean since the interval began, as far as samples cover it.
    pub(super) fn so_far(&self) -> Option<Mean<K>> {
        let (_, end) = self.newest?;
        if self.covered <= 0.0 {
            return None;
        }
        let share = 1.0 / self.covered;
        let value = self.integral.map(|sum| sum * share);
        Some(Mean { value, rising: value, end })
    }

    /// The next sample.
    pub(super) fn push(&mut self, time: f64, value: [f64; K]) {
        if let Some((last, from)) = self.newest
            && time - last <= GAP
        {
            self.integrate(last, from, time, value);
        }
        self.newest = Some((time, value));
    }

    /// Ends the interval; `next` is the first sample after its end, if there is one yet.
    pub(super) fn close(&mut self, end: f64, next: Option<(f64, [f64; K])>) -> Option<Mean<K>> {
        if let Some((last, from)) = self.newest {
            let value = match next {
                // A sample exactly at the end needs no other.
                _ if (end - last).abs() < SAME => Some(from),
                Some((time, to)) if time - last <= GAP => {
                    let share = if time > last { (end - last) / (time - last) } else { 0.0 };
                    Some(core::array::from_fn(|i| from[i] + share * (to[i] - from[i])))
                }
                Some(_) => None,
                None => (end - last <= GAP).then_some(from),
            };
            if let Some(value) = value {
                self.integrate(last, from, end, value);
                self.newest = Some((end, value));
            }
        }
        let dt = end - self.begun;
        let mean = match self.newest {
            Some((_, end)) if dt > 0.0 && self.covered >= 0.999 * dt => {
                let share = 1.0 / self.covered;
                let value = self.integral.map(|sum| sum * share);
                Some(Mean { value, rising: self.moment.map(|sum| sum * (share / dt)), end })
            }
            _ => None,
        };
        (self.begun, self.covered) = (end, 0.0);
        (self.integral, self.moment) = ([0.0; K], [0.0; K]);
        mean
    }

    fn integrate(&mut self, from: f64, a: [f64; K], to: f64, b: [f64; K]) {
        let h = to - from;
        let since = from - self.begun;
        self.covered += h;
        for i in 0..K {
            self.integral[i] += 0.5 * h * (a[i] + b[i]);
            self.moment[i] += h * (a[i] * (0.5 * since + h / 6.0) + b[i] * (0.5 * since + h / 3.0));
        }
    }
}

/// Means of the inertial unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Inertial {
    /// Specific force at the centre of gravity, body (m/s2).
    pub specific_force: [f64; 3],
    /// Angular rate, body (rad/s).
    pub rate: [f64; 3],
    /// Angular rate at the end of the interval (rad/s).
    pub rate_end: [f64; 3],
}

/// Means of the thrusts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Thrusts {
    /// Mean of each thruster (N).
    pub mean: [f64; 8],
    /// Mean with a weight rising from 0 at the beginning to 1 at the end: the later half counts
    /// more.
    pub rising: [f64; 8],
}

/// An interval of prediction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Its end (s).
    pub end: f64,
    /// Its length (s).
    pub dt: f64,
    /// Inertial means; absent without an inertial unit.
    pub inertial: Option<Inertial>,
    /// Thrusts; absent while they are not reported.
    pub thrust: Option<Thrusts>,
    /// Angular rates from attitudes; absent without attitudes, and where there are gyros.
    pub turning: Option<Turning>,
    /// Rotation from body to level axes by the roll and pitch last measured.
    pub tilt: [Vec3; 3],
}

impl Default for Interval {
    /// Nothing is known, and the vehicle is level.
    fn default() -> Self {
        let tilt = attitude::rotation_euler([0.0; 3]);
        Self { end: 0.0, dt: 0.0, inertial: None, thrust: None, turning: None, tilt }
    }
}
