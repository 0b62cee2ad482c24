//! The angular rate of a vehicle without gyros, from its attitudes.
//!
//! The difference of two attitudes is a mean rate of the past: over a short time it is mostly
//! noise, over a long time it lags. So the rate is tracked: `theta' = omega`, with `omega` a random
//! walk, measured by each attitude (Bar-Shalom, Li & Kirubarajan 2001, ch. 6.2.2). The axes share
//! one covariance. Between two attitudes the change from one to the other is exact, and the rate is
//! a straight line with this mean.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::interval::SAME;
use super::process::rotation::{exp, log};
use crate::attitude;

/// Seconds between attitudes beyond which they contain no information about the rate.
pub(super) const ATTITUDE_GAP: f64 = 1.5;
/// White angular acceleration of a vehicle that manoeuvres (rad/s2/sqrt(Hz)).
const ANGULAR_ACCELERATION: f64 = 0.1;
/// Standard deviation of a completely unknown rate (rad/s).
const UNKNOWN: f64 = 0.5;
/// NIS of an attitude at which its influence is limited: 99.9 % of three degrees of freedom.
const GATE: f64 = 16.27;

/// Angular rates of an interval, from attitudes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Turning {
    /// Mean, body (rad/s).
    pub mean: [f64; 3],
    /// At the end of the interval, body (rad/s).
    pub end: [f64; 3],
    /// Variance of each component at the end ((rad/s)^2).
    pub variance: f64,
}

/// Information about the rate from the attitudes so far.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Tracker {
    /// Time and value of the newest attitude.
    newest: Option<(f64, [f64; 3])>,
    /// Whether more is known than the newest attitude.
    tracking: bool,
    /// The newest attitude without noise, and the rate.
    rotation: [[f64; 3]; 3],
    rate: [f64; 3],
    /// Variances of angle and rate, and their covariance.
    angle_variance: f64,
    covariance: f64,
    variance: f64,
    /// Standard deviation of an attitude (rad).
    sigma: f64,
}

impl Tracker {
    pub(super) fn new(sigma: f64) -> Self {
        Self {
            newest: None,
            tracking: false,
            rotation: [[0.0; 3]; 3],
            rate: [0.0; 3],
            angle_variance: 0.0,
            covariance: 0.0,
            variance: UNKNOWN * UNKNOWN,
            sigma,
        }
    }

    /// The next attitude, while there are gyros: where tracking would begin.
    pub(super) fn stand_by(&mut self, time: f64, euler: [f64; 3]) {
        self.newest = Some((time, euler));
        self.tracking = false;
    }

    /// The next attitude `[roll, pitch, yaw]` (rad).
    pub(super) fn hear(&mut self, time: f64, euler: [f64; 3]) {
        let (last, from) = match self.newest {
            Some((last, from)) if time - last <= ATTITUDE_GAP => (last, from),
            _ => return self.stand_by(time, euler),
        };
        self.newest = Some((time, euler));
        let measured = matrix(attitude::rotation_euler(euler));
        let noise = self.sigma * self.sigma;
        if !self.tracking {
            self.tracking = true;
            (self.rotation, self.rate) = (attitude::rotation_euler(from), [0.0; 3]);
            (self.angle_variance, self.covariance) = (noise, 0.0);
            self.variance = UNKNOWN * UNKNOWN;
        }
        let dt = time - last;
        let q = ANGULAR_ACCELERATION * ANGULAR_ACCELERATION * dt;
        self.angle_variance +=
            dt * (2.0 * self.covariance + dt * self.variance) + q * dt * dt / 3.0;
        self.covariance += dt * self.variance + 0.5 * q * dt;
        self.variance += q;
        let rate = Vector3::from(self.rate);
        let predicted = matrix(self.rotation) * exp(&(rate * dt));
        let s = self.angle_variance + noise;
        let innovation = log(&(predicted.transpose() * measured));
        let nis = innovation.norm_squared() / s;
        let innovation = innovation * (GATE / nis.max(GATE));
        self.rotation = rows(&(predicted * exp(&(innovation * (self.angle_variance / s)))));
        self.rate = (rate + innovation * (self.covariance / s)).into();
        self.variance -= self.covariance * self.covariance / s;
        self.covariance *= noise / s;
        self.angle_variance *= noise / s;
    }

    /// The rates of an interval that ends at `end`; `next` is the first attitude not before it, if
    /// it has already come. None if attitudes contain no information.
    pub(super) fn until(&self, end: f64, next: Option<(f64, [f64; 3])>) -> Option<Turning> {
        let (before, from) = self.newest?;
        if end - before > ATTITUDE_GAP {
            return None;
        }
        let mut at_next = *self;
        match next {
            Some((time, to)) if time - before > SAME && time - before <= ATTITUDE_GAP => {
                at_next.hear(time, to);
                let dt = time - before;
                let [a, b] = [from, to].map(|euler| matrix(attitude::rotation_euler(euler)));
                let mean = log(&(a.transpose() * b)) / dt;
                // How much of the difference of mean and end is manoeuvring rather than noise.
                let drift = ANGULAR_ACCELERATION * ANGULAR_ACCELERATION * dt / 3.0;
                let share = drift / (drift + 2.0 * self.sigma * self.sigma / (dt * dt));
                let left = 2.0 * (time - end) / dt * share;
                let rate = Vector3::from(at_next.rate);
                let end = rate + (mean - rate) * left;
                Some(Turning { mean: mean.into(), end: end.into(), variance: at_next.variance })
            }
            _ if !self.tracking => None,
            _ => {
                let q = ANGULAR_ACCELERATION * ANGULAR_ACCELERATION * (end - before);
                let variance = self.variance + q;
                Some(Turning { mean: self.rate, end: self.rate, variance })
            }
        }
    }

    /// The rates at the newest attitude.
    pub(super) fn newest(&self) -> Option<Turning> {
        self.newest.and_then(|(time, _)| self.until(time, None))
    }
}

fn matrix(rows: [[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

fn rows(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    core::array::from_fn(|i| core::array::from_fn(|j| m[(i, j)]))
}
