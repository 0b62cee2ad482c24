//! Whether the clocks of velocity log and attitude agree.
//!
//! In a log without inertial unit only the attitude shows how the vehicle turns, and the velocity
//! log shows each turn as well: the lever arm and the slip of the vehicle outwards make a sway
//! opposed to the yaw rate, `v = -g r` with g > 0. Slip follows a turn, and never precedes it. So a
//! sway that matches the turn at a later time shows that the stamps of the attitude are late, or
//! those of the velocity log early. Every turn then bends the track, because seconds of sway are
//! applied along a wrong heading.
//!
//! For leads o from 0 to 2 s the changes of the sway are correlated with those of the yaw rate o
//! later. With C, B, A the sums of their products and squares, the lead explains the share
//! `C^2 / (A B)` of the sway. If one lead explains most of the sway, and is far likelier than the
//! present correction, it is removed from the stamps. Its effect on the position is known, too:
//! beside the sums a path is integrated for each lead.

use serde::{Deserialize, Serialize};

use super::measurement::{Event, Kind};
use crate::attitude;

/// Step of the leads (s), and their number.
const STEP: f64 = 0.1;
const LEADS: usize = 21;
/// Smallest lead that justifies a change of stamps, and smallest change of it after that, in steps.
const LEAST: usize = 5;
const FURTHER: usize = 2;
/// Half of the window for the yaw rate (s).
const HALF: f64 = 0.5;
/// Minimum time between samples of the velocity log, and between attitudes (s).
const LOG_SPACING: f64 = 0.9;
const ATTITUDE_SPACING: f64 = 0.2;
/// Samples farther apart than this belong to different stretches (s).
const GAP: f64 = 1.6;
/// Pairs of samples before any verdict, and the number of pairs for which it has to stay the same.
const PAIRS: u32 = 30;
const SAME: u32 = 10;
/// Share of the sway that a lead must explain.
const SHARE: f64 = 0.7;
/// Minimum ratio of yaw rates and their changes, squared: turns last, while waves oscillate within
/// seconds.
const LASTING: f64 = 4.0;
/// Logarithm of the likelihood ratio relative to the present correction.
const EVIDENCE: f64 = 60.0;
/// Standard deviation of changes of sway that are always present (m/s).
const ROUGHNESS: f64 = 3e-3;
/// Capacity for attitudes and for samples of the velocity log.
const ATTITUDES: usize = 32;
const LOGS: usize = 8;

/// A sample: time, and three components.
type Sample = (f64, [f64; 3]);

/// The newest samples, oldest first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound(
    serialize = "[Sample; K]: Serialize",
    deserialize = "[Sample; K]: Deserialize<'de>"
))]
struct Samples<const K: usize> {
    held: [Sample; K],
    count: usize,
}

impl<const K: usize> Samples<K> {
    const NONE: Self = Self { held: [(0.0, [0.0; 3]); K], count: 0 };

    fn slice(&self) -> &[Sample] {
        &self.held[..self.count]
    }

    /// Adds a sample, dropping the oldest if full.
    fn push(&mut self, sample: Sample) {
        if self.count == K {
            self.drop_first();
        }
        self.held[self.count] = sample;
        self.count += 1;
    }

    fn drop_first(&mut self) {
        self.held.copy_within(1.., 0);
        self.count = self.count.saturating_sub(1);
    }

    fn newest(&self) -> Option<&Sample> {
        self.slice().last()
    }
}

/// What is known about the clocks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Clocks {
    /// Attitudes with unwrapped headings, and velocities that still wait for attitudes.
    attitudes: Samples<ATTITUDES>,
    logs: Samples<LOGS>,
    /// Sums for each lead: changes of sway times those of the rate, and those of the rate squared;
    /// the changes of sway, and the rate itself, squared; and the number of pairs.
    products: [f64; LEADS],
    rates: [f64; LEADS],
    sways: f64,
    turns: f64,
    pairs: u32,
    /// The present correction, the likeliest lead, and for how many pairs it has been the
    /// likeliest.
    lead: usize,
    likeliest: usize,
    since: u32,
    /// North and east from the beginning of the path, for each lead (m), and the velocity there.
    paths: [[f64; 2]; LEADS],
    begun: Option<[f64; 2]>,
}

/// A lead was found: the position error it caused, and its standard deviation (m, NED).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Displaced {
    pub(super) by: [f64; 2],
    pub(super) within: [f64; 2],
}

impl Default for Clocks {
    fn default() -> Self {
        Self {
            attitudes: Samples::NONE,
            logs: Samples::NONE,
            products: [0.0; LEADS],
            rates: [0.0; LEADS],
            sways: 0.0,
            turns: 0.0,
            pairs: 0,
            lead: 0,
            likeliest: 0,
            since: 0,
            paths: [[0.0; 2]; LEADS],
            begun: None,
        }
    }
}

impl Clocks {
    /// What to add to the stamps of the velocity log (s).
    pub(super) fn lead(&self) -> f64 {
        STEP * self.lead as f64
    }

    /// Another sensor measures how the vehicle turns: only the lead found so far is kept.
    pub(super) fn rest(&mut self) {
        if self.attitudes.count > 0 || self.logs.count > 0 {
            *self = Self { lead: self.lead, ..Self::default() };
        }
    }

    /// The next sample, by its own stamp. Returns whether a lead was found.
    pub(super) fn hear(&mut self, event: &Event) -> Option<Displaced> {
        match event.kind {
            Kind::Ahrs => return self.attitude(event.time, event.cut()),
            Kind::Dvl => self.log(event.time, event.cut()),
            // The position is known, so the earlier path no longer matters.
            Kind::Fix => self.begun = None,
            _ => {}
        }
        None
    }

    /// The next velocity.
    fn log(&mut self, time: f64, velocity: [f64; 3]) {
        if self.logs.newest().is_none_or(|(last, _)| time - last >= LOG_SPACING) {
            self.logs.push((time, velocity));
        }
    }

    /// The next attitude. Returns whether a lead was found.
    fn attitude(&mut self, time: f64, euler: [f64; 3]) -> Option<Displaced> {
        let mut euler = euler;
        if let Some(&(last, before)) = self.attitudes.newest() {
            if time - last < ATTITUDE_SPACING {
                return None;
            }
            if time - last > GAP {
                (self.attitudes, self.logs, self.begun) = (Samples::NONE, Samples::NONE, None);
            }
            euler[2] = before[2] + attitude::wrap(euler[2] - before[2]);
        }
        self.attitudes.push((time, euler));
        let mut found = None;
        while let &[before, next, ..] = self.logs.slice() {
            let Some(&(oldest, _)) = self.attitudes.slice().get(1) else { break };
            // A spline needs one more sample on each side.
            let needed = next.0 + STEP * (LEADS - 1) as f64 + HALF;
            if self.attitudes.slice().iter().filter(|(t, _)| *t >= needed).count() < 2 {
                break;
            }
            self.logs.drop_first();
            if before.0 - HALF < oldest || next.0 - before.0 > GAP {
                self.begun = None;
            } else {
                found = self.compare(before, next).or(found);
            }
        }
        found
    }

    /// The attitude at an instant, by a cubic through those around it.
    fn at(&self, time: f64) -> [f64; 3] {
        let samples = self.attitudes.slice();
        let after = samples.partition_point(|(t, _)| *t <= time).clamp(2, samples.len() - 2);
        let &[(t0, a), (t1, b), (t2, c), (t3, d)] = &samples[after - 2..after + 2] else {
            return [0.0; 3];
        };
        let h = t2 - t1;
        let u = (time - t1) / h;
        core::array::from_fn(|i| {
            let (m1, m2) = ((c[i] - a[i]) / (t2 - t0) * h, (d[i] - b[i]) / (t3 - t1) * h);
            let (square, cube) = (u * u, u * u * u);
            (2.0 * cube - 3.0 * square + 1.0) * b[i]
                + (cube - 2.0 * square + u) * m1
                + (3.0 * square - 2.0 * cube) * c[i]
                + (cube - square) * m2
        })
    }

    fn yaw_rate(&self, time: f64) -> f64 {
        (self.at(time + HALF)[2] - self.at(time - HALF)[2]) / (2.0 * HALF)
    }

    /// Velocity over ground, north and east.
    fn over_ground(&self, time: f64, velocity: [f64; 3]) -> [f64; 2] {
        let r = attitude::rotation_euler(self.at(time));
        [0, 1].map(|i| (0..3).map(|j| r[i][j] * velocity[j]).sum())
    }

    /// Two successive velocities against the attitudes, for every lead.
    fn compare(&mut self, (before, from): Sample, (time, to): Sample) -> Option<Displaced> {
        let (dt, sway) = (time - before, to[1] - from[1]);
        let middle = core::array::from_fn(|i| 0.5 * (from[i] + to[i]));
        if self.begun.is_none() {
            self.begun = Some(self.over_ground(before + self.lead(), from));
            self.paths = [[0.0; 2]; LEADS];
        }
        for k in 0..LEADS {
            let lead = STEP * k as f64;
            let rate = self.yaw_rate(time + lead);
            let change = rate - self.yaw_rate(before + lead);
            if k == self.lead {
                self.turns += rate * rate;
            }
            self.products[k] += sway * change;
            self.rates[k] += change * change;
            let velocity = self.over_ground(0.5 * (before + time) + lead, middle);
            (0..2).for_each(|i| self.paths[k][i] += velocity[i] * dt);
        }
        self.sways += sway * sway;
        self.pairs = self.pairs.saturating_add(1);
        self.judge((time, to))
    }

    fn judge(&mut self, (time, velocity): Sample) -> Option<Displaced> {
        // Only a sway opposed to the turn counts.
        let explained = |k: usize| {
            let c = self.products[k].min(0.0);
            c * c / self.rates[k].max(f64::MIN_POSITIVE)
        };
        let best =
            (0..LEADS).fold(0, |best, k| if explained(k) > explained(best) { k } else { best });
        self.since = if best == self.likeliest { self.since.saturating_add(1) } else { 0 };
        self.likeliest = best;
        let pairs = f64::from(self.pairs);
        let rest = |k: usize| (self.sways - explained(k)).max(ROUGHNESS * ROUGHNESS * pairs);
        let evidence = 0.5 * pairs * libm::log(rest(self.lead) / rest(best));
        let decided = self.pairs >= PAIRS
            && self.since >= SAME
            && best + 1 < LEADS
            && best.abs_diff(self.lead) >= if self.lead == 0 { LEAST } else { FURTHER }
            && explained(best) > SHARE * self.sways
            && self.turns > LASTING * self.rates[best]
            && evidence > EVIDENCE;
        if !decided {
            return None;
        }
        // The paths begin and end at times that differ by the difference of the leads.
        let later = STEP * (best as f64 - self.lead as f64);
        let (begun, end) = (self.begun?, self.over_ground(time + self.lead(), velocity));
        let by = [0, 1]
            .map(|i| self.paths[best][i] - self.paths[self.lead][i] + later * (begun[i] - end[i]));
        self.lead = best;
        Some(Displaced { by, within: by.map(|b| b * STEP / later) })
    }
}
