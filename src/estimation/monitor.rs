//! Detection of lost thrust: a bank of generalised likelihood ratios beside the filter.
//!
//! Hypothesis (i, k): thruster i has lost a share of its thrust since restart k, while its rotor
//! turns as before. Each hypothesis carries V, the mean error of the filter per unit of the lost
//! share, and compares the innovations y with those expected in that case:
//!
//! ```text
//! predict   V <- F V - B_i T_i dt
//! update    s = h^T V (+ the direct effect of the thrust on the measurement)
//!           C += s y / S,  J += s^2 / S,  V -= K s
//! ```
//! The share is estimated as C/J, its log-likelihood ratio against no loss is C^2/(2 J). Willsky &
//! Jones (1976); Basseville & Nikiforov (1993) ch. 7.2.

use nalgebra::SVector;
use serde::{Deserialize, Serialize};

use super::belief::{Column, Row};
use super::interval::Interval;
use super::kalman::Witness;
use super::lanes::{CHUNK, Chunk, Heard, advance, hear};
use super::transition::Transition;

/// Restarts kept; one a second, so losses up to this many seconds old are distinguished.
const RESTARTS: usize = 12;
/// Seconds between restarts.
const SPACING: f64 = 1.0;
const THRUSTERS: usize = 8;
const HYPOTHESES: usize = RESTARTS * THRUSTERS;

/// One number for each hypothesis: the thrusters of restart 0, of restart 1, ...
type Lanes = SVector<f32, HYPOTHESES>;

/// A thruster found to have lost thrust.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alarm<const N: usize> {
    /// Which thruster.
    pub thruster: usize,
    /// Share of its thrust lost.
    pub share: f64,
    /// Correction of the states, and the standard deviation along it.
    pub correction: Column<N>,
    /// The direction in which the covariance grows: P increases by the product of this with itself.
    pub widening: Column<N>,
}

/// Monitors a filter's innovations for a fault.
pub trait Monitor<const N: usize>: Witness<N> + Copy + Default {
    /// Checks for a fault at an instant (s); after an alarm it restarts.
    fn judge(&mut self, now: f64) -> Option<Alarm<N>> {
        let _ = now;
        None
    }

    /// Sets the effect of one newton of each thruster on the states per second.
    fn prepare(&mut self, effect: &[Column<N>; THRUSTERS]) {
        let _ = effect;
    }
}

impl<const N: usize> Monitor<N> for () {}

/// The bank.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ThrusterMonitor<const N: usize> {
    /// Errors of the states under each hypothesis.
    errors: [Chunk<N>; HYPOTHESES / CHUNK],
    c: Lanes,
    j: Lanes,
    restarted: f64,
    next: usize,
    direct: [f64; THRUSTERS],
    effect: [Column<N>; THRUSTERS],
}

impl<const N: usize> Default for ThrusterMonitor<N> {
    fn default() -> Self {
        Self {
            errors: [Chunk::zeros(); HYPOTHESES / CHUNK],
            c: Lanes::zeros(),
            j: Lanes::zeros(),
            restarted: f64::NEG_INFINITY,
            next: 0,
            direct: [0.0; THRUSTERS],
            effect: [Column::zeros(); THRUSTERS],
        }
    }
}

/// Twice the log-likelihood ratio of an alarm. With half of it, a vehicle whose mass is wrong by 20
/// % raises an alarm every hour, and the wrong thruster is named now and then; losses are still
/// found within a second.
const THRESHOLD: f32 = 50.0;
/// Range of shares in which a lost propeller can be distinguished from a disturbance.
const SHARES: core::ops::Range<f64> = 0.35..1.4;

impl<const N: usize> Monitor<N> for ThrusterMonitor<N> {
    fn prepare(&mut self, effect: &[Column<N>; THRUSTERS]) {
        self.effect = *effect;
    }

    fn judge(&mut self, now: f64) -> Option<Alarm<N>> {
        let best = (0..HYPOTHESES)
            // C^2/J without a division, because nearly all are below.
            .filter(|&k| self.c[k] * self.c[k] > THRESHOLD * self.j[k])
            .filter(|&k| SHARES.contains(&self.share(k)))
            .max_by(|&a, &b| self.ratio(a).total_cmp(&self.ratio(b)));
        if let Some(k) = best {
            let share = self.share(k);
            let error = self.errors[k / CHUNK].row(k % CHUNK).transpose().map(f64::from);
            let alarm = Alarm {
                thruster: k % THRUSTERS,
                share: share.min(1.0),
                correction: error * share,
                widening: error / f64::from(self.j[k]).sqrt(),
            };
            let effect = self.effect;
            *self = Self { effect, restarted: now, ..Self::default() };
            return Some(alarm);
        }
        if now - self.restarted >= SPACING {
            self.restarted = now;
            let from = self.next * THRUSTERS;
            self.next = (self.next + 1) % RESTARTS;
            self.errors[from / CHUNK].rows_mut(from % CHUNK, THRUSTERS).fill(0.0);
            self.c.rows_mut(from, THRUSTERS).fill(0.0);
            self.j.rows_mut(from, THRUSTERS).fill(0.0);
        }
        None
    }
}

impl<const N: usize> ThrusterMonitor<N> {
    /// The most likely lost share.
    fn share(&self, k: usize) -> f64 {
        f64::from(self.c[k]) / f64::from(self.j[k])
    }

    /// Twice the logarithm of its likelihood ratio.
    fn ratio(&self, k: usize) -> f64 {
        self.share(k) * f64::from(self.c[k])
    }
}

impl<const N: usize> Witness<N> for ThrusterMonitor<N> {
    fn predicted(&mut self, f: &Transition<N>) {
        advance(&mut self.errors, f);
    }

    fn driven(&mut self, interval: &Interval) {
        let Some(thrusts) = &interval.thrust else { return };
        for state in 0..N {
            let change = |i: usize| self.effect[i][state] * thrusts.mean[i] * interval.dt;
            let change: [f32; THRUSTERS] = core::array::from_fn(|i| change(i) as f32);
            if change.iter().any(|&c| c != 0.0) {
                for chunk in &mut self.errors {
                    for restart in chunk.data.0[state].chunks_exact_mut(THRUSTERS) {
                        restart.iter_mut().zip(&change).for_each(|(error, by)| *error -= by);
                    }
                }
            }
        }
    }

    fn direct(&mut self, effect: [f64; THRUSTERS]) {
        self.direct = effect;
    }

    fn updated(&mut self, row: &Row<N>, gain: &Column<N>, innovation: f64, s: f64) {
        let direct = core::mem::take(&mut self.direct);
        let heard = Heard { row, gain, innovation, s, direct: &direct };
        hear(&mut self.errors, self.c.as_mut_slice(), self.j.as_mut_slice(), &heard);
    }
}
