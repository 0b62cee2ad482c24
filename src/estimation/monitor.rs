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
//! The share is estimated as C/J, its log-likelihood ratio against no loss is C^2/(2 J); that of a
//! lost propeller, the share 1, is C - J/2. Willsky & Jones (1976); Basseville & Nikiforov (1993)
//! ch. 7.2.

use nalgebra::SMatrix;
use serde::{Deserialize, Serialize};

use super::belief::{Column, Row};
use super::interval::Interval;
use super::kalman::Witness;
use super::lanes::{HYPOTHESES, Heard, Numbers, Vectors, advance, drive, hear};
use super::transition::Transition;

/// Restarts kept: the newest of every second, and older ones of every other second.
const RESTARTS: usize = HYPOTHESES / THRUSTERS;
/// How many of them are of odd seconds; they are replaced earlier than those of even ones.
const ODD: usize = 2;
/// Seconds after which restarts are kept in the same places again.
const CYCLE: usize = 2 * ODD * (RESTARTS - ODD);
/// Seconds between restarts.
const SPACING: f64 = 1.0;
const THRUSTERS: usize = 8;

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

/// The bank; hypotheses are the thrusters of restart 0, of restart 1, ...
// Aligned because a vector across two cache lines takes twice the time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[repr(C, align(64))]
pub struct ThrusterMonitor<const N: usize> {
    /// Errors of the states under each hypothesis.
    errors: Vectors<N>,
    c: Numbers,
    j: Numbers,
    restarted: f64,
    next: usize,
    direct: [f64; THRUSTERS],
    /// Effect of one newton of each thruster on the states per second, and the states it acts on.
    effect: SMatrix<f64, THRUSTERS, N>,
    affected: u64,
}

impl<const N: usize> Default for ThrusterMonitor<N> {
    fn default() -> Self {
        Self {
            errors: Vectors::zeros(),
            c: Numbers::zeros(),
            j: Numbers::zeros(),
            restarted: f64::NEG_INFINITY,
            next: 0,
            direct: [0.0; THRUSTERS],
            effect: SMatrix::zeros(),
            affected: 0,
        }
    }
}

/// Twice the log-likelihood ratio of an alarm, for a share that is estimated. Below about 60, a
/// vehicle whose mass is wrong by 20 % or whose speed changes raises a false alarm every hour if its
/// gyro is good, and the wrong thruster is named now and then.
const THRESHOLD: f32 = 70.0;
/// The same if the whole thrust is lost, which is more likely and seldom looks like anything else.
const WHOLE_THRESHOLD: f32 = 55.0;
/// Range of shares in which a lost propeller can be distinguished from a disturbance.
const SHARES: core::ops::Range<f64> = 0.35..1.4;

impl<const N: usize> Monitor<N> for ThrusterMonitor<N> {
    fn prepare(&mut self, effect: &[Column<N>; THRUSTERS]) {
        self.effect = SMatrix::from_fn(|i, state| effect[i][state]);
        let acts = |state: usize| self.effect.column(state).iter().any(|&by| by != 0.0);
        self.affected = (0..N).filter(|&state| acts(state)).fold(0, |set, state| set | 1 << state);
    }

    fn judge(&mut self, now: f64) -> Option<Alarm<N>> {
        // C^2/J without a division; nearly always all are below.
        let above = |k: usize| {
            let (c, j) = (self.c[k], self.j[k]);
            (c * c > THRESHOLD * j) | (2.0 * c - j > WHOLE_THRESHOLD)
        };
        let best = || {
            (0..HYPOTHESES)
                .filter(|&k| above(k) && SHARES.contains(&self.share(k)))
                .max_by(|&a, &b| self.ratio(a).total_cmp(&self.ratio(b)))
        };
        let any = (0..HYPOTHESES).fold(false, |any, k| any | above(k));
        if let Some(k) = any.then(best).flatten() {
            let share = self.share(k);
            let error = self.errors.row(k).transpose().map(f64::from);
            let alarm = Alarm {
                thruster: k % THRUSTERS,
                share: share.min(1.0),
                correction: error * share,
                widening: error / f64::from(self.j[k]).sqrt(),
            };
            let Self { effect, affected, .. } = *self;
            *self = Self { effect, affected, restarted: now, ..Self::default() };
            return Some(alarm);
        }
        if now - self.restarted >= SPACING {
            self.restarted = now;
            let from = place(self.next) * THRUSTERS;
            self.next = (self.next + 1) % CYCLE;
            self.errors.rows_mut(from, THRUSTERS).fill(0.0);
            self.c.rows_mut(from, THRUSTERS).fill(0.0);
            self.j.rows_mut(from, THRUSTERS).fill(0.0);
        }
        None
    }
}

/// Where the restart of a second is kept, in place of an older one.
fn place(second: usize) -> usize {
    let (pair, odd) = (second / 2, second % 2 == 1);
    if odd { pair % ODD } else { ODD + pair % (RESTARTS - ODD) }
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
        let impulses = thrusts.mean.map(|thrust| thrust * interval.dt);
        drive(&mut self.errors, self.affected, &self.effect, &impulses);
    }

    fn direct(&mut self, effect: [f64; THRUSTERS]) {
        self.direct = effect;
    }

    fn updated(&mut self, row: &Row<N>, gain: &Column<N>, innovation: f64, s: f64) {
        let direct = core::mem::take(&mut self.direct);
        let heard = Heard { row, gain, innovation, s, direct: &direct };
        hear(&mut self.errors, &mut self.c, &mut self.j, &heard);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn restarts_are_kept_of_every_second_and_then_of_every_other() {
        let mut kept = [0; RESTARTS];
        for second in 0..200 {
            kept[place(second % CYCLE)] = second;
            let mut ages = kept.map(|restart| second - restart);
            ages.sort_unstable();
            let want = [[0, 1, 2, 3, 4, 6, 8, 10], [0, 1, 2, 3, 5, 7, 9, 11]][second % 2];
            assert!(second < 12 || ages == want, "after {second} s: {ages:?}");
        }
    }

    #[test]
    fn a_whole_loss_needs_less_evidence_than_a_share() {
        let alarm = |c: f32, j: f32| {
            let mut monitor = ThrusterMonitor::<4>::default();
            (monitor.c[12], monitor.j[12]) = (c, j);
            monitor.judge(0.0).map(|alarm| (alarm.thruster, alarm.share))
        };
        // Twice the log-likelihood ratios: of the estimated share, of the share 1.
        assert_eq!(alarm(60.0, 60.0), Some((4, 1.0)), "60, 60");
        assert_eq!(alarm(120.0, 240.0), None, "60, 0");
        assert_eq!(alarm(160.0, 320.0), Some((4, 0.5)), "80, 0");
        assert_eq!(alarm(50.0, 50.0), None, "50, 50");
        assert_eq!(alarm(40.0, 20.0), None, "80, 60, but of a share of 2");
    }
}
